//! The size parameter of a drop: x = 2π r/λ, with the radius `r` and the wavelength `λ`.

use std::f64::consts::TAU;

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;

/// x.
pub(crate) fn size_parameter(radius: Micrometers, wavelength: Nanometers) -> f64 {
    TAU * 1e3 * radius.0 / wavelength.0
}
