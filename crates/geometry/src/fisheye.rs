//! Fisheye cameras.
//!
//! equidistant  r = f theta
//! equisolid    r = 2 f sin(theta/2)
//!
//! `r` distance from the middle of the picture, `f` focal length, both in pixels; `theta` angle from
//! the optical axis, up to 180 degrees. The equisolid mapping keeps solid angles: a pixel spans 1/f²
//! steradian wherever it lies. The picture ends at the image circle; beyond it there are no rays.
//! [S09] D. Schneider, E. Schwalbe, H.-G. Maas, ISPRS J. Photogrammetry and Remote Sensing 64,
//! 259-266 (2009).

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use glam::DVec3;
use niji_radiometry::Radians;

use crate::camera_pose::CameraPose;
use crate::error::Error;
use crate::lens::Lens;
use crate::ray::Ray;

/// How a fisheye maps angles to radii.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FisheyeMapping {
    /// Radius proportional to the angle.
    Equidistant,
    /// Area proportional to the solid angle.
    Equisolid,
}

impl FisheyeMapping {
    /// `r / f` at an angle from the axis.
    fn radius(self, theta_rad: f64) -> f64 {
        match self {
            Self::Equidistant => theta_rad,
            Self::Equisolid => 2.0 * (0.5 * theta_rad).sin(),
        }
    }

    /// Angle from the axis at `r / f`; `None` beyond the direction straight back.
    fn theta_rad(self, radius: f64) -> Option<f64> {
        let theta_rad = match self {
            Self::Equidistant => radius,
            Self::Equisolid => 2.0 * (0.5 * radius).asin(),
        };
        // The sine of more than 1 has no angle: NaN.
        (theta_rad <= PI).then_some(theta_rad)
    }
}

/// What a fisheye camera is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FisheyeRequest {
    /// Where it stands and how it is turned.
    pub pose: CameraPose,
    /// How it maps angles to radii.
    pub mapping: FisheyeMapping,
    /// Its scale; a field of view across the width may be up to 360 degrees.
    pub lens: Lens,
    /// Full angle that the image circle spans; `None`: the circle is as wide as the picture, or
    /// spans 360 degrees where that is narrower.
    pub image_circle: Option<Radians>,
    /// Width of the picture in pixels.
    pub width_px: u32,
    /// Height of the picture in pixels.
    pub height_px: u32,
}

/// A fisheye camera.
///
/// ```
/// use glam::DVec3;
/// use niji_geometry::{CameraPose, FisheyeCamera, FisheyeMapping, FisheyeRequest, Lens};
/// use niji_radiometry::Radians;
/// let dome = FisheyeCamera::new(FisheyeRequest {
///     pose: CameraPose::looking(DVec3::ZERO, [0.0, 90.0, 0.0].map(Radians::from_degrees))?,
///     mapping: FisheyeMapping::Equidistant,
///     lens: Lens::HorizontalFov(Radians::from_degrees(180.0)),
///     image_circle: None,
///     width_px: 512,
///     height_px: 512,
/// })?;
/// // The zenith in the middle, the horizon at the edge, nothing in the corners.
/// assert!(dome.ray(256.0, 256.0).unwrap().direction.distance(DVec3::Y) < 1e-15);
/// assert!(dome.ray(512.0, 256.0).unwrap().direction.y.abs() < 1e-15);
/// assert!(dome.ray(1.0, 1.0).is_none());
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FisheyeCamera {
    pose: CameraPose,
    mapping: FisheyeMapping,
    /// f in pixels.
    focal_px: f64,
    /// Largest angle from the axis.
    theta_max_rad: f64,
    size_px: [u32; 2],
}

impl FisheyeCamera {
    /// A camera.
    ///
    /// # Errors
    /// If the field of view or the image circle is not within 0..=360 degrees, a length of the lens
    /// is not above 0, or the picture has no pixels.
    pub fn new(request: FisheyeRequest) -> Result<Self, Error> {
        let (width_px, height_px) = (request.width_px, request.height_px);
        if width_px == 0 || height_px == 0 {
            return Err(Error::EmptyPicture {
                width_px,
                height_px,
            });
        }
        let half_width_px = 0.5 * f64::from(width_px);
        let focal_px = match request.lens {
            Lens::HorizontalFov(angle) => {
                half_width_px / request.mapping.radius(half_angle_rad(angle)?)
            }
            Lens::FocalLength(lengths) => lengths.checked()?.in_widths() * f64::from(width_px),
        };
        let theta_max_rad = match request.image_circle {
            Some(angle) => half_angle_rad(angle)?,
            None => request
                .mapping
                .theta_rad(half_width_px / focal_px)
                .unwrap_or(PI),
        };
        Ok(Self {
            pose: request.pose,
            mapping: request.mapping,
            focal_px,
            theta_max_rad,
            size_px: [width_px, height_px],
        })
    }

    /// Where it stands and how it is turned.
    #[must_use]
    pub fn pose(&self) -> &CameraPose {
        &self.pose
    }

    /// How it maps angles to radii.
    #[must_use]
    pub fn mapping(&self) -> FisheyeMapping {
        self.mapping
    }

    /// Focal length in pixels.
    #[must_use]
    pub fn focal_length_px(&self) -> f64 {
        self.focal_px
    }

    /// Width and height of the picture in pixels.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The ray through a point of the picture, in pixels from its top left corner; `None` outside
    /// the image circle.
    #[must_use]
    pub fn ray(&self, x_px: f64, y_px: f64) -> Option<Ray> {
        let [x, y] = self.right_and_up_px(x_px, y_px);
        let radius_px = x.hypot(y);
        let theta_rad = self.mapping.theta_rad(radius_px / self.focal_px)?;
        if theta_rad > self.theta_max_rad + rounding_rad(self.theta_max_rad) {
            return None;
        }
        let (sin, cos) = theta_rad.sin_cos();
        // The middle itself has no side: any will do.
        let along = if radius_px > 0.0 {
            sin / radius_px
        } else {
            0.0
        };
        Some(Ray {
            origin: self.pose.position(),
            direction: self
                .pose
                .to_world(DVec3::new(along * x, along * y, -cos))
                .normalize(),
        })
    }

    /// Where a direction falls in the picture, in pixels; `None` outside the image circle. The
    /// direction straight back falls on every point of its circle: the one on the right is given.
    #[must_use]
    pub fn project(&self, direction: DVec3) -> Option<(f64, f64)> {
        let local = self.pose.to_camera(direction);
        let off_axis = local.x.hypot(local.y);
        let theta_rad = off_axis.atan2(-local.z);
        if theta_rad > self.theta_max_rad + rounding_rad(self.theta_max_rad) {
            return None;
        }
        let radius_px = self.focal_px * self.mapping.radius(theta_rad);
        let (x, y) = if off_axis > 0.0 {
            (local.x / off_axis, local.y / off_axis)
        } else {
            (1.0, 0.0)
        };
        let [width, height] = self.size_px.map(f64::from);
        Some((0.5 * width + radius_px * x, 0.5 * height - radius_px * y))
    }

    /// Largest angle that a pixel spans.
    ///
    /// Along the radius d theta/dr is 1/f (equidistant) or 1/(f cos(theta/2)) (equisolid), which grows
    /// towards the edge; across it, it is smaller. No pixel spans more than half a turn.
    #[must_use]
    pub fn pixel_angle(&self) -> Radians {
        let edge = self.focal_px * self.mapping.radius(self.theta_max_rad);
        let angle = |radius_px: f64| {
            self.mapping
                .theta_rad(radius_px / self.focal_px)
                .unwrap_or(PI)
        };
        Radians(
            (angle(edge) - angle((edge - 1.0).max(0.0)))
                .max(angle(1.0))
                .min(PI),
        )
    }

    /// See [`crate::Camera::reach`].
    ///
    /// Along a way in the picture the direction turns at most by d theta/dr of its outermost point, or
    /// first along the radius and then, at no more than 1/f, along an arc of at most pi/2 chords: the
    /// smaller of both, as the first has no bound where the picture reaches straight back.
    pub(crate) fn reach_rad(&self, (x_px, y_px): (f64, f64), radius_px: f64) -> f64 {
        let [x, y] = self.right_and_up_px(x_px, y_px);
        let theta_rad = |at_px: f64| {
            let theta = self.mapping.theta_rad(at_px / self.focal_px);
            theta.map_or(self.theta_max_rad, |theta| theta.min(self.theta_max_rad))
        };
        let from_middle_px = x.hypot(y);
        let outermost_rad = theta_rad(from_middle_px + radius_px);
        let innermost_rad = theta_rad((from_middle_px - radius_px).max(0.0));
        let straight_rad = match self.mapping {
            FisheyeMapping::Equidistant => radius_px / self.focal_px,
            FisheyeMapping::Equisolid => {
                radius_px / (self.focal_px * (0.5 * outermost_rad).cos().max(f64::MIN_POSITIVE))
            }
        };
        straight_rad.min(outermost_rad - innermost_rad + FRAC_PI_2 * radius_px / self.focal_px)
    }

    /// Right and up of the middle of the picture.
    fn right_and_up_px(&self, x_px: f64, y_px: f64) -> [f64; 2] {
        let [width, height] = self.size_px.map(f64::from);
        [x_px - 0.5 * width, 0.5 * height - y_px]
    }
}

fn half_angle_rad(angle: Radians) -> Result<f64, Error> {
    let found_deg = angle.to_degrees();
    // The rounding of 360 degrees in radians.
    if found_deg > 0.0 && found_deg <= 360.0 * (1.0 + f64::EPSILON) {
        Ok((0.5 * angle.0).min(PI))
    } else {
        Err(Error::FisheyeAngle { found_deg })
    }
}

/// The edge of the image circle belongs to the picture, however it is rounded.
fn rounding_rad(theta_rad: f64) -> f64 {
    1e-12 * theta_rad
}
