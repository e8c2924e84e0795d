//! Phase function of air molecules in natural light.
//!
//! p = 3/(16 pi (1 + 2 gamma)) [(1 + 3 gamma) + (1 - gamma) cos^2 theta]      [1/sr]
//! gamma = d/(2 - d),  d = 6 (F - 1)/(3 + 7 F)
//! `F` King factor, `d` depolarization ratio of natural light. F = 1 is Rayleigh's own
//! 3/(16 pi)(1 + cos^2); real air (F = 1.049) has 3 % less contrast between 0 and 90 degrees.
//! [C60] Chandrasekhar, Radiative Transfer, Dover (1960), chapter I, section 18.
//! [B95] Bucholtz, Applied Optics 34, 2765-2773 (1995), eq. 12.

use std::f64::consts::PI;

use niji_radiometry::Radians;

/// Phase function at a scattering angle for a King factor, 1/sr (B95, eq. 12).
pub fn rayleigh_phase(king_factor: f64, theta: Radians) -> f64 {
    let depolarization = 6.0 * (king_factor - 1.0) / (3.0 + 7.0 * king_factor);
    let gamma = depolarization / (2.0 - depolarization);
    let cos2 = theta.0.cos().powi(2);
    3.0 / (16.0 * PI * (1.0 + 2.0 * gamma)) * ((1.0 + 3.0 * gamma) + (1.0 - gamma) * cos2)
}
