//! A camera of any projection.
//!
//! It looks along its −z; pixels run x right and y down, (0, 0) is the outer corner of the top left
//! pixel and pixel centers lie at +0.5.

use std::f64::consts::PI;

use glam::DMat4;
use glam::DVec3;
use niji_radiometry::Radians;

use crate::camera_pose::CameraPose;
use crate::error::Error;
use crate::fisheye::FisheyeCamera;
use crate::panorama::PanoramaCamera;
use crate::pinhole::PinholeCamera;
use crate::ray::Ray;

/// A camera of any projection.
///
/// ```
/// use glam::DVec3;
/// use niji_geometry::{Camera, CameraPose, PanoramaCamera};
/// use niji_radiometry::Radians;
/// let pose = CameraPose::looking(DVec3::ZERO, [Radians(0.0); 3])?;
/// let camera = Camera::from(PanoramaCamera::new(pose, [720, 360])?);
/// assert_eq!(camera.project(DVec3::NEG_Z), Some((360.0, 180.0)));
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// Straight lines stay straight.
    Pinhole(PinholeCamera),
    /// Up to all directions in a circle.
    Fisheye(FisheyeCamera),
    /// All directions, longitude across and latitude down.
    Panorama(PanoramaCamera),
}

impl From<PinholeCamera> for Camera {
    fn from(camera: PinholeCamera) -> Self {
        Self::Pinhole(camera)
    }
}

impl From<FisheyeCamera> for Camera {
    fn from(camera: FisheyeCamera) -> Self {
        Self::Fisheye(camera)
    }
}

impl From<PanoramaCamera> for Camera {
    fn from(camera: PanoramaCamera) -> Self {
        Self::Panorama(camera)
    }
}

impl TryFrom<Camera> for PinholeCamera {
    type Error = Error;

    fn try_from(camera: Camera) -> Result<Self, Error> {
        match camera {
            Camera::Pinhole(camera) => Ok(camera),
            Camera::Fisheye(_) | Camera::Panorama(_) => Err(Error::NotPinhole),
        }
    }
}

impl Camera {
    /// Where it stands and how it is turned.
    #[must_use]
    pub fn pose(&self) -> &CameraPose {
        match self {
            Self::Pinhole(camera) => camera.pose(),
            Self::Fisheye(camera) => camera.pose(),
            Self::Panorama(camera) => camera.pose(),
        }
    }

    fn size_px(&self) -> [u32; 2] {
        match self {
            Self::Pinhole(camera) => [camera.width_px(), camera.height_px()],
            Self::Fisheye(camera) => camera.size_px(),
            Self::Panorama(camera) => camera.size_px(),
        }
    }

    /// Width of the picture in pixels.
    #[must_use]
    pub fn width_px(&self) -> u32 {
        self.size_px()[0]
    }

    /// Height of the picture in pixels.
    #[must_use]
    pub fn height_px(&self) -> u32 {
        self.size_px()[1]
    }

    /// Position of the eye in metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.pose().position()
    }

    /// Unit vector along the optical axis.
    #[must_use]
    pub fn forward(&self) -> DVec3 {
        self.pose().forward()
    }

    /// The ray through a point of the picture, in pixels from its top left corner; `None` outside
    /// the image circle of a fisheye, where the picture is black.
    #[must_use]
    #[inline]
    pub fn ray(&self, x_px: f64, y_px: f64) -> Option<Ray> {
        match self {
            Self::Pinhole(camera) => Some(camera.ray(x_px, y_px)),
            Self::Fisheye(camera) => camera.ray(x_px, y_px),
            Self::Panorama(camera) => Some(camera.ray(x_px, y_px)),
        }
    }

    /// Change of the ray's unit direction from pixel to pixel [1/px], across and down, at a point of
    /// the picture; `None` where there is no ray. Beyond a pinhole the difference between the edges of
    /// a pixel around the point, of which the half that lies in a fisheye's image circle speaks for
    /// the other.
    #[must_use]
    pub fn direction_slopes(&self, x_px: f64, y_px: f64) -> Option<[DVec3; 2]> {
        if let Self::Pinhole(camera) = self {
            return Some(camera.direction_slopes(x_px, y_px));
        }
        let middle = self.ray(x_px, y_px)?.direction;
        let slopes = [(0.5, 0.0), (0.0, 0.5)].map(|(dx, dy)| {
            let end = |sign: f64| self.ray(x_px + sign * dx, y_px + sign * dy);
            match (end(-1.0), end(1.0)) {
                (Some(from), Some(to)) => to.direction - from.direction,
                (Some(from), None) => 2.0 * (middle - from.direction),
                (None, Some(to)) => 2.0 * (to.direction - middle),
                (None, None) => DVec3::ZERO,
            }
        });
        Some(slopes)
    }

    /// Where a direction falls in the picture, in pixels; `None` where the camera cannot see it.
    #[must_use]
    pub fn project(&self, direction: DVec3) -> Option<(f64, f64)> {
        match self {
            Self::Pinhole(camera) => camera.project(direction),
            Self::Fisheye(camera) => camera.project(direction),
            Self::Panorama(camera) => Some(camera.project(direction)),
        }
    }

    /// Largest angle that a pixel spans.
    #[must_use]
    pub fn pixel_angle(&self) -> Radians {
        match self {
            // In the middle of the picture.
            Self::Pinhole(camera) => camera.pixel_angle(),
            Self::Fisheye(camera) => camera.pixel_angle(),
            Self::Panorama(camera) => camera.pixel_angle(),
        }
    }

    /// An angle that no ray within `radius_px` pixels of a point of the picture exceeds from the ray
    /// through it.
    #[must_use]
    pub fn reach(&self, (x_px, y_px): (f64, f64), radius_px: f64) -> Radians {
        let reach_rad = match self {
            // Widest in the middle of a pinhole, and across the equator of a panorama, for all.
            Self::Pinhole(camera) => radius_px * camera.pixel_angle().0.tan(),
            Self::Panorama(camera) => radius_px * camera.pixel_angle().0,
            Self::Fisheye(camera) => camera.reach_rad((x_px, y_px), radius_px),
        };
        Radians(reach_rad.min(PI))
    }

    /// The matrix that takes points of the world to the camera's frame.
    #[must_use]
    pub fn world_to_camera(&self) -> DMat4 {
        self.pose().world_to_camera()
    }
}

#[cfg(test)]
#[path = "camera_tests.rs"]
mod tests;
