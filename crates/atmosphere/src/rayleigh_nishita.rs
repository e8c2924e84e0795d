//! Rayleigh scattering with the constants that are usual in computer graphics.
//!
//! beta = 4 pi K/lambda^4 exp(-h/H0),  K = 2 pi^2 (n^2 - 1)^2/(3 Ns),  n = 1.0003 (N87, eqs. 3, 4)
//! Ns = 2.545e25 /m^3 and H0 = 7994 m. No dispersion and no King factor: 3.2, 5.3 and 6.5 % stronger
//! than air at 450, 550 and 650 nm. Kept to reproduce published pictures.
//! [N87] Nishita, Miyawaki and Nakamae, Computer Graphics (SIGGRAPH) 21(4), 303-310 (1987);
//! Nishita et al., SIGGRAPH 93, 175-182 (1993).

use std::f64::consts::PI;

use niji_radiometry::Meters;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::constituent::Constituent;
use crate::density_profile::DensityProfile;
use crate::phase_function::PhaseFunction;

/// Refractive index of air at all wavelengths (N87).
const REFRACTIVE_INDEX: f64 = 1.0003;
/// Molecules at sea level, 1/m^3 (N87).
const MOLECULES_M3: f64 = 2.545e25;
/// Scale height of the density, m (N87).
pub(crate) const SCALE_HEIGHT_M: f64 = 7994.0;

/// Scattering coefficient at sea level, 1/m (N87, eqs. 3 and 4).
pub fn rayleigh_nishita_m1(wavelength: Nanometers) -> f64 {
    let lambda_m = Meters::from(wavelength).0;
    let n = REFRACTIVE_INDEX;
    let k = 2.0 * PI * PI * (n * n - 1.0).powi(2) / (3.0 * MOLECULES_M3);
    4.0 * PI * k / lambda_m.powi(4)
}

/// Air molecules with these constants, evaluated at the centers of the bins.
pub fn rayleigh_nishita(wavelengths: &WavelengthGrid) -> Constituent {
    let scattering_m1: Vec<f64> = wavelengths.centers().map(rayleigh_nishita_m1).collect();
    Constituent {
        name: "rayleigh".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: SCALE_HEIGHT_M,
        },
        extinction_m1: scattering_m1.clone(),
        phase: PhaseFunction::Rayleigh {
            king_factor: vec![1.0; scattering_m1.len()],
        },
        scattering_m1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_are_those_of_the_formula_in_print() {
        // 4 pi 9.3100814e-32 m^3/lambda^4, eight digits from mpmath.
        for (nm, m1) in [
            (450.0, 2.853076e-5),
            (550.0, 1.278535e-5),
            (650.0, 6.554053e-6),
        ] {
            let found = rayleigh_nishita_m1(Nanometers(nm));
            assert!((found / m1 - 1.0).abs() < 2e-7, "{nm} nm: {found}");
        }
    }

    #[test]
    fn vertical_optical_depths_are_the_published_ones() {
        let grid = WavelengthGrid::new(450.0, 100.0, 3).unwrap();
        let found = rayleigh_nishita(&grid).vertical_optical_depth();
        for (found, expected) in found.into_iter().zip([0.2281, 0.1022, 0.0524]) {
            assert!((found - expected).abs() < 5.1e-5, "{found}");
        }
    }
}
