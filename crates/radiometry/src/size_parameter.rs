//! The size parameter of a drop.
//!
//! x = 2π r/λ   `r` radius, `λ` wavelength in the medium around it

use std::f64::consts::TAU;

use crate::units::Micrometers;
use crate::units::Nanometers;

/// x.
///
/// ```
/// use niji_radiometry::{Micrometers, Nanometers, size_parameter};
///
/// assert!((size_parameter(Micrometers(0.5), Nanometers(500.0)) / std::f64::consts::TAU - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn size_parameter(radius: Micrometers, wavelength: Nanometers) -> f64 {
    TAU * 1e3 * radius.0 / wavelength.0
}
