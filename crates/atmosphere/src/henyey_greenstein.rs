//! Phase function of Henyey and Greenstein.
//!
//! p = (1 - g^2)/(4 pi (1 + g^2 - 2 g cos theta)^(3/2))      [1/sr]
//! `g` = mean of cos theta, -1 < g < 1.
//! [HG41] Henyey and Greenstein, Astrophysical Journal 93, 70-83 (1941), eq. 2.

use std::f64::consts::PI;

use niji_radiometry::Radians;

/// Phase function at a scattering angle, 1/sr (HG41, eq. 2).
///
/// ```
/// use niji_atmosphere::henyey_greenstein;
/// use niji_radiometry::Radians;
///
/// let even = henyey_greenstein(0.0, Radians(1.0));
/// assert!((even - 0.25 / std::f64::consts::PI).abs() < 1e-15);
/// assert!(henyey_greenstein(0.7, Radians(0.0)) > 18.0 * even);
/// ```
pub fn henyey_greenstein(asymmetry: f64, theta: Radians) -> f64 {
    let g = asymmetry;
    // 1 + g^2 - 2 g cos theta, without cancellation near the forward peak.
    let distance2 = (1.0 - g).powi(2) + 4.0 * g * (0.5 * theta.0).sin().powi(2);
    (1.0 - g * g) / (4.0 * PI * distance2 * distance2.sqrt())
}
