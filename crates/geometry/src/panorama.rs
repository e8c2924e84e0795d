//! The equirectangular panorama: all directions, longitude across and latitude down.
//!
//! longitude = 2 pi (x/W - 1/2),  latitude = pi (1/2 - y/H)
//! right, up, backwards = cos(lat) sin(lon), sin(lat), -cos(lat) cos(lon)
//!
//! `x`, `y` pixels from the top left corner, `W` x `H` the picture, twice as wide as high so that its
//! pixels are square where they are widest. The optical axis of a level camera, its azimuth, lies in
//! the middle; east of it is to the right. A pixel spans (2 pi/W) (sin lat_top - sin lat_bottom)
//! steradian. Beyond the left and right edge the picture repeats; beyond a pole it goes on down the
//! other side.
//! [S87] J. P. Snyder, Map Projections: A Working Manual, USGS Professional Paper 1395, 90-91 (1987).

use std::f64::consts::PI;
use std::f64::consts::TAU;

use glam::DVec3;
use niji_radiometry::Radians;

use crate::camera_pose::CameraPose;
use crate::error::Error;
use crate::ray::Ray;

/// A camera that sees all directions.
///
/// ```
/// use glam::DVec3;
/// use niji_geometry::{CameraPose, PanoramaCamera};
/// use niji_radiometry::Radians;
/// let pose = CameraPose::looking(DVec3::ZERO, [Radians(0.0); 3])?;
/// let panorama = PanoramaCamera::new(pose, [720, 360])?;
/// // East is a quarter of the width right of north, in the middle of the height.
/// assert!(panorama.ray(540.0, 180.0).direction.distance(DVec3::X) < 1e-15);
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanoramaCamera {
    pose: CameraPose,
    height_px: u32,
}

impl PanoramaCamera {
    /// A camera with a picture of width and height in pixels.
    ///
    /// # Errors
    /// [`Error::PanoramaShape`] if the picture is not twice as wide as high, [`Error::EmptyPicture`]
    /// if it has no pixels.
    pub fn new(pose: CameraPose, [width_px, height_px]: [u32; 2]) -> Result<Self, Error> {
        if width_px == 0 || height_px == 0 {
            return Err(Error::EmptyPicture {
                width_px,
                height_px,
            });
        }
        if Some(width_px) != height_px.checked_mul(2) {
            return Err(Error::PanoramaShape {
                width_px,
                height_px,
            });
        }
        Ok(Self { pose, height_px })
    }

    /// Where it stands and how it is turned.
    #[must_use]
    pub fn pose(&self) -> &CameraPose {
        &self.pose
    }

    /// Width and height of the picture in pixels.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        [2 * self.height_px, self.height_px]
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    #[must_use]
    pub fn ray(&self, x_px: f64, y_px: f64) -> Ray {
        let [width, height] = self.size_px().map(f64::from);
        let (sin_longitude, cos_longitude) = (TAU * (x_px / width - 0.5)).sin_cos();
        let (sin_latitude, cos_latitude) = (PI * (0.5 - y_px / height)).sin_cos();
        let local = DVec3::new(
            cos_latitude * sin_longitude,
            sin_latitude,
            -cos_latitude * cos_longitude,
        );
        Ray {
            origin: self.pose.position(),
            direction: self.pose.to_world(local).normalize(),
        }
    }

    /// Where a direction falls in the picture, in pixels. A pole falls on every point of its edge:
    /// the one in the middle is given.
    #[must_use]
    pub fn project(&self, direction: DVec3) -> (f64, f64) {
        let local = self.pose.to_camera(direction);
        let level = local.x.hypot(local.z);
        // At a pole the sign of a zero would decide.
        let longitude_rad = if level > 0.0 {
            local.x.atan2(-local.z)
        } else {
            0.0
        };
        let latitude_rad = local.y.atan2(level);
        let [width, height] = self.size_px().map(f64::from);
        (
            width * (0.5 + longitude_rad / TAU),
            height * (0.5 - latitude_rad / PI),
        )
    }

    /// Largest angle that a pixel spans: its height.
    #[must_use]
    pub fn pixel_angle(&self) -> Radians {
        Radians(PI / f64::from(self.height_px))
    }
}
