//! The section `[camera]`: where it stands, where it looks, and through what.
//!
//! A pose is written as position and angles, or as the matrix that another program gives; a lens as
//! its field of view, or as focal length and sensor width. Whatever is written, a scene holds position
//! and angles, so that nothing after it has to know two forms.

use glam::DMat4;
use glam::DVec3;
use glam::DVec4;
use niji_geometry::CameraPose;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::FocalLength;
use niji_geometry::Lens;
use niji_geometry::PanoramaCamera;
use niji_geometry::PinholeCamera;
use niji_geometry::PixelRegion;
use niji_geometry::Up;
use niji_radiometry::Radians;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::check::Check;
use crate::check::TURNS_DEG;
use crate::error::SceneError;

/// How directions become places in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Straight lines stay straight.
    #[default]
    Pinhole,
    /// The distance from the middle grows with the angle from the axis.
    FisheyeEquidistant,
    /// Equal areas are equal solid angles.
    FisheyeEquisolid,
    /// All directions, longitude across and latitude down; the picture is twice as wide as high.
    Panorama,
}

impl Projection {
    /// The projection as scene files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::FisheyeEquidistant => "fisheye-equidistant",
            Self::FisheyeEquisolid => "fisheye-equisolid",
            Self::Panorama => "panorama",
        }
    }

    fn fisheye(self) -> Option<FisheyeMapping> {
        match self {
            Self::FisheyeEquidistant => Some(FisheyeMapping::Equidistant),
            Self::FisheyeEquisolid => Some(FisheyeMapping::Equisolid),
            Self::Pinhole | Self::Panorama => None,
        }
    }

    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
    fn is_pinhole(&self) -> bool {
        *self == Self::Pinhole
    }
}

/// The section `[camera]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "CameraSection")]
pub struct Camera {
    /// Position of the eye, metres: x east, y up, z south.
    pub position_m: [f64; 3],
    /// Azimuth of the optical axis, clockwise from north, degrees.
    pub azimuth_deg: f64,
    /// Elevation of the optical axis above the horizon, degrees.
    pub elevation_deg: f64,
    /// Rotation about the optical axis, positive where the right side goes down, degrees.
    pub roll_deg: f64,
    /// How directions become places in the picture.
    #[serde(skip_serializing_if = "Projection::is_pinhole")]
    pub projection: Projection,
    /// Full field of view across the width, degrees: `None` for a panorama, and for a fisheye given
    /// by its focal length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizontal_fov_deg: Option<f64>,
    /// Focal length of a fisheye, millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length_mm: Option<f64>,
    /// Width of the sensor behind a fisheye, millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_width_mm: Option<f64>,
    /// Full angle of a fisheye's image circle, degrees: beyond it the picture is black; as wide as the
    /// picture where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_circle_deg: Option<f64>,
    /// Width of the picture, pixels.
    pub width_px: u32,
    /// Height of the picture, pixels.
    pub height_px: u32,
    /// Pixels that are rendered beyond the picture on each side, for lens effects and stabilizing.
    #[serde(skip_serializing_if = "is_zero")]
    pub overscan_px: u32,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_zero(count: &u32) -> bool {
    *count == 0
}

impl Camera {
    /// The same view on a picture no wider than `width_px`, with an even number of rows: a panorama is twice as
    /// wide as high.
    #[must_use]
    pub fn no_wider_than(mut self, width_px: u32) -> Self {
        let scale = f64::from(width_px) / f64::from(self.width_px);
        if scale < 1.0 {
            let half_rows = (0.5 * f64::from(self.height_px) * scale).round();
            self.height_px = 2 * half_rows.max(1.0) as u32;
            self.width_px = width_px;
            self.overscan_px = (f64::from(self.overscan_px) * scale).round() as u32;
        }
        self
    }

    /// The camera as the renderer takes it.
    ///
    /// # Errors
    /// A camera that cannot be; never for one of a scene that was read from a file.
    pub fn camera(&self) -> Result<niji_geometry::Camera, niji_geometry::Error> {
        let angles = [self.azimuth_deg, self.elevation_deg, self.roll_deg];
        let position = DVec3::from(self.position_m);
        let pose = CameraPose::looking(position, angles.map(Radians::from_degrees))?;
        let size_px = [self.width_px, self.height_px];
        Ok(match self.projection {
            Projection::Pinhole => PinholeCamera::with_lens(pose, self.lens(), size_px)?.into(),
            Projection::FisheyeEquidistant => self.fisheye(pose, FisheyeMapping::Equidistant)?,
            Projection::FisheyeEquisolid => self.fisheye(pose, FisheyeMapping::Equisolid)?,
            Projection::Panorama => PanoramaCamera::new(pose, size_px)?.into(),
        })
    }

    /// All pixels that are rendered: the frame and its overscan.
    ///
    /// # Errors
    /// A picture without pixels; never for one of a scene that was read from a file.
    pub fn region(&self) -> Result<PixelRegion, niji_geometry::Error> {
        PixelRegion::frame(self.width_px, self.height_px).grown(self.overscan_px)
    }

    /// The camera where only straight lines that stay straight will do.
    ///
    /// # Errors
    /// [`niji_geometry::Error::NotPinhole`] for another projection, and as [`Camera::camera`].
    pub fn pinhole(&self) -> Result<PinholeCamera, niji_geometry::Error> {
        PinholeCamera::try_from(self.camera()?)
    }

    fn fisheye(
        &self,
        pose: CameraPose,
        mapping: FisheyeMapping,
    ) -> Result<niji_geometry::Camera, niji_geometry::Error> {
        let camera = FisheyeCamera::new(FisheyeRequest {
            pose,
            mapping,
            lens: self.lens(),
            image_circle: self.image_circle_deg.map(Radians::from_degrees),
            width_px: self.width_px,
            height_px: self.height_px,
        })?;
        Ok(camera.into())
    }

    /// A lens that is not written is refused by the camera: NaN is no field of view.
    fn lens(&self) -> Lens {
        if let (Some(focal_length_mm), Some(sensor_width_mm)) =
            (self.focal_length_mm, self.sensor_width_mm)
        {
            return Lens::FocalLength(FocalLength {
                focal_length_mm,
                sensor_width_mm,
            });
        }
        let fov_deg = self.horizontal_fov_deg.unwrap_or(f64::NAN);
        Lens::HorizontalFov(Radians::from_degrees(fov_deg))
    }
}

/// The section as it is written.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "oneOf" = [
        {
            "required": ["position_m", "azimuth_deg", "elevation_deg"],
            "properties": { "matrix": false, "matrix_up": false },
        },
        {
            "required": ["matrix", "matrix_up"],
            "properties": {
                "position_m": false,
                "azimuth_deg": false,
                "elevation_deg": false,
                "roll_deg": false,
            },
        },
    ],
    "if" = { "properties": { "projection": { "const": "panorama" } }, "required": ["projection"] },
    "then" = { "properties": {
        "horizontal_fov_deg": false,
        "focal_length_mm": false,
        "sensor_width_mm": false,
        "overscan_px": { "const": 0 },
    } },
    "else" = { "oneOf": [
        {
            "required": ["horizontal_fov_deg"],
            "properties": { "focal_length_mm": false, "sensor_width_mm": false },
        },
        {
            "required": ["focal_length_mm", "sensor_width_mm"],
            "properties": { "horizontal_fov_deg": false },
        },
    ] },
))]
struct CameraSection {
    /// Position of the eye, metres: x east, y up, z south.
    #[serde(default)]
    #[schemars(inner(range(min = -1e7, max = 1e7)))]
    position_m: Option<[f64; 3]>,
    /// Azimuth of the optical axis, clockwise from north, degrees.
    #[serde(default)]
    #[schemars(range(min = -3600.0, max = 3600.0))]
    azimuth_deg: Option<f64>,
    /// Elevation of the optical axis above the horizon, degrees.
    #[serde(default)]
    #[schemars(range(min = -90.0, max = 90.0))]
    elevation_deg: Option<f64>,
    /// Rotation about the optical axis, positive where the right side goes down, degrees: 0 where it is
    /// left out.
    #[serde(default)]
    #[schemars(range(min = -3600.0, max = 3600.0))]
    roll_deg: Option<f64>,
    /// Camera-to-world matrix for column vectors by rows: the position is its last column.
    #[serde(default)]
    #[schemars(with = "Option<[[f64; 4]; 4]>")]
    matrix: Option<Matrix>,
    /// Which axis is up in the world of the matrix.
    #[serde(default)]
    matrix_up: Option<Up>,
    /// How directions become places in the picture.
    #[serde(default)]
    projection: Projection,
    /// Full field of view across the width, degrees: at most 175 for a pinhole.
    #[serde(default)]
    #[schemars(range(min = 0.001, max = 360.0))]
    horizontal_fov_deg: Option<f64>,
    /// Focal length, millimetres; with the width of the sensor in the place of the field of view.
    #[serde(default)]
    #[schemars(range(min = 0.001, max = 1e5))]
    focal_length_mm: Option<f64>,
    /// Width of the sensor, millimetres.
    #[serde(default)]
    #[schemars(range(min = 0.001, max = 1e5))]
    sensor_width_mm: Option<f64>,
    /// Full angle of a fisheye's image circle, degrees: beyond it the picture is black; as wide as the
    /// picture where it is left out.
    #[serde(default)]
    #[schemars(range(min = 0.001, max = 360.0))]
    image_circle_deg: Option<f64>,
    /// Width of the picture, pixels.
    #[schemars(range(min = 1, max = 65536))]
    width_px: u32,
    /// Height of the picture, pixels.
    #[schemars(range(min = 1, max = 65536))]
    height_px: u32,
    /// Pixels that are rendered beyond the picture on each side; 0 for a panorama.
    #[serde(default)]
    #[schemars(range(min = 0, max = 4096))]
    overscan_px: u32,
}

/// A matrix that only turns and moves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "[[f64; 4]; 4]")]
struct Matrix(DMat4);

impl TryFrom<[[f64; 4]; 4]> for Matrix {
    type Error = String;

    fn try_from(rows: [[f64; 4]; 4]) -> Result<Self, String> {
        let [x, y, z, w] = rows.map(DVec4::from_array);
        let matrix = DMat4::from_cols(x, y, z, w).transpose();
        // Which axis is up does not decide whether it turns and moves.
        match CameraPose::from_matrix(matrix, Up::Y) {
            Ok(_) => Ok(Self(matrix)),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl TryFrom<CameraSection> for Camera {
    type Error = String;

    fn try_from(section: CameraSection) -> Result<Self, String> {
        let (position_m, [azimuth_deg, elevation_deg, roll_deg]) = section.pose()?;
        section.check_lens()?;
        let fov_deg = |focal_length_mm: f64, sensor_width_mm: f64| {
            2.0 * (0.5 * sensor_width_mm / focal_length_mm)
                .atan()
                .to_degrees()
        };
        let lens = (section.focal_length_mm, section.sensor_width_mm);
        let (horizontal_fov_deg, (focal_length_mm, sensor_width_mm)) =
            match (section.projection, lens) {
                (Projection::Pinhole, (Some(focal_mm), Some(width_mm))) => {
                    (Some(fov_deg(focal_mm, width_mm)), (None, None))
                }
                (_, lens) => (section.horizontal_fov_deg, lens),
            };
        Ok(Self {
            position_m,
            azimuth_deg,
            elevation_deg,
            roll_deg,
            projection: section.projection,
            horizontal_fov_deg,
            focal_length_mm,
            sensor_width_mm,
            image_circle_deg: section.image_circle_deg,
            width_px: section.width_px,
            height_px: section.height_px,
            overscan_px: section.overscan_px,
        })
    }
}

impl CameraSection {
    /// Position in metres; azimuth, elevation and roll in degrees.
    fn pose(&self) -> Result<([f64; 3], [f64; 3]), String> {
        let angles = (self.azimuth_deg, self.elevation_deg);
        match (self.matrix, self.matrix_up, self.position_m, angles) {
            (None, None, Some(position_m), (Some(azimuth_deg), Some(elevation_deg))) => {
                let roll_deg = self.roll_deg.unwrap_or(0.0);
                Ok((position_m, [azimuth_deg, elevation_deg, roll_deg]))
            }
            (Some(matrix), Some(up), None, (None, None)) if self.roll_deg.is_none() => {
                let pose = CameraPose::from_matrix(matrix.0, up);
                let pose = pose.map_err(|error| error.to_string())?;
                let angles_deg = pose.angles().map(Radians::to_degrees);
                Ok((pose.position().to_array(), angles_deg))
            }
            _ => Err(
                "expected either position_m, azimuth_deg and elevation_deg, or matrix and matrix_up \
                      = \"y\" or \"z\""
                    .to_owned(),
            ),
        }
    }

    fn check_lens(&self) -> Result<(), String> {
        let (focal, sensor) = (self.focal_length_mm, self.sensor_width_mm);
        let projection = self.projection.name();
        if self.image_circle_deg.is_some() && self.projection.fisheye().is_none() {
            return Err(format!(
                "expected image_circle_deg for a fisheye only, found a {projection}"
            ));
        }
        match (self.projection, self.horizontal_fov_deg, focal, sensor) {
            (Projection::Panorama, None, None, None) => Ok(()),
            (Projection::Panorama, _, _, _) => {
                Err("expected a panorama without a lens: it shows all directions".to_owned())
            }
            (_, Some(_), None, None) | (_, None, Some(_), Some(_)) => Ok(()),
            (
                Projection::Pinhole | Projection::FisheyeEquidistant | Projection::FisheyeEquisolid,
                _,
                _,
                _,
            ) => Err(
                "expected either horizontal_fov_deg, or focal_length_mm and sensor_width_mm"
                    .to_owned(),
            ),
        }
    }
}

/// Largest side of a picture, pixels.
const MAX_SIDE_PX: u32 = 65_536;

/// Most pixels beyond a side of the picture.
const MAX_OVERSCAN_PX: u32 = 4096;

/// Longest focal length and widest sensor, millimetres.
const MAX_LENGTH_MM: f64 = 1e5;

/// Checks the ranges of the section.
pub(crate) fn check(camera: &Camera, check: &Check<'_>) -> Result<(), SceneError> {
    for coordinate in camera.position_m {
        check.coordinate("camera.position_m", coordinate)?;
    }
    check.number("camera.azimuth_deg", camera.azimuth_deg, TURNS_DEG)?;
    check.number("camera.elevation_deg", camera.elevation_deg, (-90.0, 90.0))?;
    check.number("camera.roll_deg", camera.roll_deg, TURNS_DEG)?;
    let widest_deg = if camera.projection.is_pinhole() {
        175.0
    } else {
        360.0
    };
    for (key, found, range) in [
        (
            "camera.horizontal_fov_deg",
            camera.horizontal_fov_deg,
            (0.001, widest_deg),
        ),
        (
            "camera.focal_length_mm",
            camera.focal_length_mm,
            (0.001, MAX_LENGTH_MM),
        ),
        (
            "camera.sensor_width_mm",
            camera.sensor_width_mm,
            (0.001, MAX_LENGTH_MM),
        ),
        (
            "camera.image_circle_deg",
            camera.image_circle_deg,
            (0.001, 360.0),
        ),
    ] {
        found.map_or(Ok(()), |found| check.number(key, found, range))?;
    }
    check.count("camera.width_px", &camera.width_px, (1, MAX_SIDE_PX))?;
    check.count("camera.height_px", &camera.height_px, (1, MAX_SIDE_PX))?;
    let overscan = ("camera.overscan_px", camera.overscan_px);
    check.count(overscan.0, &overscan.1, (0, MAX_OVERSCAN_PX))?;
    if camera.projection == Projection::Panorama && overscan.1 > 0 {
        let expected = "0 for a panorama: it shows all directions already";
        return Err(check.out_of_range(overscan.0, overscan.1.to_string(), expected));
    }
    let made = camera.camera();
    made.map(|_| ())
        .map_err(|error| check.refused("camera", &error))
}
