//! Phase function of Cornette and Shanks: Henyey-Greenstein that tends to Rayleigh's.
//!
//! p = 3/(8 pi) (1 - g^2)(1 + cos^2 theta)/((2 + g^2)(1 + g^2 - 2 g cos theta)^(3/2))      [1/sr]
//! g = 0 is Rayleigh's phase function. `g` is a parameter; the mean cosine is a little larger,
//! (3/5) g (4 + g^2)/(2 + g^2), 0.757 at g = 0.7.
//! [CS92] Cornette and Shanks, Applied Optics 31, 3152-3160 (1992), eq. 8.

use niji_radiometry::Radians;

use crate::henyey_greenstein::henyey_greenstein;

/// Phase function at a scattering angle, 1/sr (CS92, eq. 8).
pub fn cornette_shanks(parameter: f64, theta: Radians) -> f64 {
    let g2 = parameter * parameter;
    let cos2 = theta.0.cos().powi(2);
    henyey_greenstein(parameter, theta) * 1.5 * (1.0 + cos2) / (2.0 + g2)
}
