//! The pinhole camera.
//!
//! It looks along its −z; pixels run x right and y down, (0, 0) is the outer corner of the top left
//! pixel and pixel centers lie at +0.5. Pixels are square.

use glam::DMat4;
use glam::DVec3;
use niji_radiometry::Radians;

use crate::camera_pose::CameraPose;
use crate::error::Error;
use crate::lens::Lens;
use crate::ray::Ray;

/// What a pinhole camera is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinholeRequest {
    /// Position of the eye in metres.
    pub position: DVec3,
    /// Azimuth of the optical axis, clockwise from north.
    pub azimuth: Radians,
    /// Elevation of the optical axis above the horizon.
    pub elevation: Radians,
    /// Rotation about the optical axis, positive where the right side of the camera goes down.
    pub roll: Radians,
    /// Full field of view across the width.
    pub horizontal_fov: Radians,
    /// Width of the picture in pixels.
    pub width_px: u32,
    /// Height of the picture in pixels.
    pub height_px: u32,
}

/// A pinhole camera.
///
/// ```
/// use glam::DVec3;
/// use niji_geometry::{PinholeCamera, PinholeRequest};
/// use niji_radiometry::Radians;
/// let camera = PinholeCamera::new(PinholeRequest {
///     position: DVec3::ZERO,
///     azimuth: Radians(0.0),
///     elevation: Radians(0.0),
///     roll: Radians(0.0),
///     horizontal_fov: Radians::from_degrees(90.0),
///     width_px: 640,
///     height_px: 480,
/// })?;
/// assert!(camera.ray(320.0, 240.0).direction.distance(DVec3::NEG_Z) < 1e-15);
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinholeCamera {
    pose: CameraPose,
    size_px: [u32; 2],
    /// Half the width of the picture in focal lengths.
    half_width: f64,
}

impl PinholeCamera {
    /// A camera.
    ///
    /// # Errors
    /// If a number is not finite, the field of view is not within 0..180 degrees, or the picture
    /// has no pixels.
    pub fn new(request: PinholeRequest) -> Result<Self, Error> {
        let angles = [request.azimuth, request.elevation, request.roll];
        let size_px = [request.width_px, request.height_px];
        let lens = Lens::HorizontalFov(request.horizontal_fov);
        let half_width = half_width(lens, size_px)?;
        let pose = CameraPose::looking(request.position, angles)?;
        Ok(Self {
            pose,
            size_px,
            half_width,
        })
    }

    /// A camera in a pose, with a picture of width and height in pixels.
    ///
    /// # Errors
    /// If the field of view is not within 0..180 degrees, a length of the lens is not above 0, or the
    /// picture has no pixels.
    pub fn with_lens(pose: CameraPose, lens: Lens, size_px: [u32; 2]) -> Result<Self, Error> {
        let half_width = half_width(lens, size_px)?;
        Ok(Self {
            pose,
            size_px,
            half_width,
        })
    }

    /// Where it stands and how it is turned.
    #[must_use]
    pub fn pose(&self) -> &CameraPose {
        &self.pose
    }

    /// Width of the frame at distance 1 before the eye, 2 tan(fov/2): `screenWindowWidth` of OpenEXR.
    #[must_use]
    pub fn window_width(&self) -> f64 {
        2.0 * self.half_width
    }

    /// Width of the picture in pixels.
    #[must_use]
    pub fn width_px(&self) -> u32 {
        self.size_px[0]
    }

    /// Height of the picture in pixels.
    #[must_use]
    pub fn height_px(&self) -> u32 {
        self.size_px[1]
    }

    /// Position of the eye in metres.
    #[must_use]
    #[inline]
    pub fn position(&self) -> DVec3 {
        self.pose.position()
    }

    /// Unit vector along the optical axis.
    #[must_use]
    pub fn forward(&self) -> DVec3 {
        self.pose.forward()
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    #[must_use]
    #[inline]
    pub fn ray(&self, x_px: f64, y_px: f64) -> Ray {
        let [width, height] = self.size_px.map(f64::from);
        let scale = 2.0 * self.half_width / width;
        let x = scale * (x_px - 0.5 * width);
        let y = scale * (0.5 * height - y_px);
        let direction = self.pose.to_world(DVec3::new(x, y, -1.0)).normalize();
        Ray {
            origin: self.position(),
            direction,
        }
    }

    /// Change of the ray's unit direction from pixel to pixel [1/px], across and down, at a point of
    /// the picture: with p = (x, y, -1), d = p/|p|, d' = (p' - d (d . p'))/|p|.
    /// Igehy, "Tracing ray differentials", SIGGRAPH 1999, 179-186, eq. 8.
    #[must_use]
    pub fn direction_slopes(&self, x_px: f64, y_px: f64) -> [DVec3; 2] {
        let [width, height] = self.size_px.map(f64::from);
        let scale = 2.0 * self.half_width / width;
        let local = DVec3::new(
            scale * (x_px - 0.5 * width),
            scale * (0.5 * height - y_px),
            -1.0,
        );
        let per_length = local.length_recip();
        let direction = local * per_length;
        [DVec3::X, DVec3::NEG_Y].map(|axis| {
            let off = axis - direction * direction.dot(axis);
            self.pose.to_world(scale * per_length * off)
        })
    }

    /// Where a direction falls in the picture, in pixels; `None` behind the camera.
    #[must_use]
    pub fn project(&self, direction: DVec3) -> Option<(f64, f64)> {
        let local = self.pose.to_camera(direction);
        if local.z >= 0.0 {
            return None;
        }
        let [width, height] = self.size_px.map(f64::from);
        let scale = width / (2.0 * self.half_width);
        let x_px = 0.5 * width - scale * local.x / local.z;
        let y_px = 0.5 * height + scale * local.y / local.z;
        Some((x_px, y_px))
    }

    /// Angle that a pixel in the center of the picture spans.
    #[must_use]
    pub fn pixel_angle(&self) -> Radians {
        Radians((2.0 * self.half_width / f64::from(self.size_px[0])).atan())
    }

    /// The matrix that takes points of the world to the camera's frame.
    #[must_use]
    pub fn world_to_camera(&self) -> DMat4 {
        self.pose.world_to_camera()
    }
}

/// Half the width of the picture in focal lengths: tan(fov/2).
fn half_width(lens: Lens, [width_px, height_px]: [u32; 2]) -> Result<f64, Error> {
    let half_width = match lens {
        Lens::HorizontalFov(fov) => {
            let found_deg = fov.to_degrees();
            if !(found_deg > 0.0 && found_deg < 180.0) {
                return Err(Error::FieldOfView { found_deg });
            }
            (0.5 * fov.0).tan()
        }
        Lens::FocalLength(lengths) => 0.5 / lengths.checked()?.in_widths(),
    };
    if width_px == 0 || height_px == 0 {
        return Err(Error::EmptyPicture {
            width_px,
            height_px,
        });
    }
    Ok(half_width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::FocalLength;
    use crate::ray::direction_from_azimuth_elevation;

    fn request(azimuth_deg: f64, elevation_deg: f64, roll_deg: f64) -> PinholeRequest {
        PinholeRequest {
            position: DVec3::new(1.0, 2.0, 3.0),
            azimuth: Radians::from_degrees(azimuth_deg),
            elevation: Radians::from_degrees(elevation_deg),
            roll: Radians::from_degrees(roll_deg),
            horizontal_fov: Radians::from_degrees(90.0),
            width_px: 640,
            height_px: 480,
        }
    }

    fn camera(azimuth_deg: f64, elevation_deg: f64, roll_deg: f64) -> PinholeCamera {
        PinholeCamera::new(request(azimuth_deg, elevation_deg, roll_deg)).unwrap()
    }

    #[test]
    fn the_axis_points_at_its_azimuth_and_elevation() {
        let expected = direction_from_azimuth_elevation(
            Radians::from_degrees(70.0),
            Radians::from_degrees(25.0),
        );
        let camera = camera(70.0, 25.0, 10.0);
        assert!(camera.ray(320.0, 240.0).direction.distance(expected) < 1e-15);
        assert!(camera.forward().distance(expected) < 1e-15);
    }

    #[test]
    fn the_edges_of_the_picture_are_half_the_field_of_view_away() {
        let camera = camera(0.0, 0.0, 0.0);
        let right = camera.ray(640.0, 240.0).direction;
        assert!((right.angle_between(DVec3::NEG_Z).to_degrees() - 45.0).abs() < 1e-6);
        assert!(right.x > 0.0, "x runs right, and east is right of north");
        assert!(camera.ray(320.0, 0.0).direction.y > 0.0, "row 0 is the top");
    }

    /// 36 mm of film behind a lens of 50 mm: 39.6 degrees across, as every table of lenses says.
    #[test]
    fn a_normal_lens_has_its_published_angle() {
        let lens = Lens::FocalLength(FocalLength {
            focal_length_mm: 50.0,
            sensor_width_mm: 36.0,
        });
        let pose = *camera(0.0, 0.0, 0.0).pose();
        let camera = PinholeCamera::with_lens(pose, lens, [36, 24]).unwrap();
        let edges = [0.0, 36.0].map(|x| camera.ray(x, 12.0).direction);
        let fov_deg = edges[0].angle_between(edges[1]).to_degrees();
        assert!((fov_deg - 39.6).abs() < 0.05, "{fov_deg}");
    }

    #[test]
    fn project_undoes_ray() {
        let camera = camera(200.0, -35.0, 17.0);
        for (x, y) in [(0.0, 0.0), (13.25, 400.5), (640.0, 480.0)] {
            let (x_back, y_back) = camera.project(camera.ray(x, y).direction).unwrap();
            assert!((x_back - x).abs() < 1e-9 && (y_back - y).abs() < 1e-9);
        }
        assert_eq!(camera.project(-camera.forward()), None);
    }

    #[test]
    fn slopes_are_what_neighboring_rays_differ_by() {
        let camera = camera(200.0, -35.0, 17.0);
        let step_px = 1e-3;
        for (x, y) in [(0.5, 0.5), (320.0, 240.0), (601.25, 77.5)] {
            let ends = |dx: f64, dy: f64| camera.ray(x + dx, y + dy).direction;
            let across = (ends(step_px, 0.0) - ends(-step_px, 0.0)) / (2.0 * step_px);
            let down = (ends(0.0, step_px) - ends(0.0, -step_px)) / (2.0 * step_px);
            for (found, expected) in camera.direction_slopes(x, y).iter().zip([across, down]) {
                // Of 3e-3; the difference has 16 - 3 - 3 digits.
                assert!(found.distance(expected) < 1e-12);
            }
        }
    }

    #[test]
    fn the_matrix_puts_the_eye_at_the_origin_and_the_axis_on_minus_z() {
        let camera = camera(123.0, 45.0, -30.0);
        let matrix = camera.world_to_camera();
        assert!(matrix.transform_point3(camera.position()).length() < 1e-12);
        assert!(
            matrix
                .transform_vector3(camera.forward())
                .distance(DVec3::NEG_Z)
                < 1e-12
        );
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let empty = PinholeRequest {
            width_px: 0,
            ..request(0.0, 0.0, 0.0)
        };
        assert!(matches!(
            PinholeCamera::new(empty),
            Err(Error::EmptyPicture { .. })
        ));
        let sound = request(0.0, 0.0, 0.0);
        for fov_deg in [0.0, 180.0, -3.0, f64::NAN] {
            let request = PinholeRequest {
                horizontal_fov: Radians::from_degrees(fov_deg),
                ..sound
            };
            assert!(matches!(
                PinholeCamera::new(request),
                Err(Error::FieldOfView { .. })
            ));
        }
        let request = PinholeRequest {
            position: DVec3::NAN,
            ..sound
        };
        assert!(matches!(PinholeCamera::new(request), Err(Error::NotFinite)));
    }
}
