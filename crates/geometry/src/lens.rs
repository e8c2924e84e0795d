//! The scale of a lens: its angle across the picture, or its focal length and the sensor's width.

use niji_radiometry::Radians;

use crate::error::Error;

/// The scale of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Full field of view across the width of the picture.
    HorizontalFov(Radians),
    /// Focal length and width of the sensor.
    FocalLength(FocalLength),
}

/// Focal length of a lens and width of the sensor behind it, which the picture fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocalLength {
    /// Focal length in millimetres.
    pub focal_length_mm: f64,
    /// Width of the sensor in millimetres.
    pub sensor_width_mm: f64,
}

impl FocalLength {
    /// The same, if both are lengths.
    ///
    /// # Errors
    /// [`Error::LensLength`].
    pub(crate) fn checked(self) -> Result<Self, Error> {
        for (name, found_mm) in [
            ("focal length", self.focal_length_mm),
            ("sensor width", self.sensor_width_mm),
        ] {
            if !(found_mm > 0.0 && found_mm.is_finite()) {
                return Err(Error::LensLength { name, found_mm });
            }
        }
        Ok(self)
    }

    /// The focal length in widths of the picture.
    pub(crate) fn in_widths(self) -> f64 {
        self.focal_length_mm / self.sensor_width_mm
    }
}
