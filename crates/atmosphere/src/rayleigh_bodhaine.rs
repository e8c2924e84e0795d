//! Rayleigh scattering of real air.
//!
//! sigma = 24 pi^3 (n^2 - 1)^2/(lambda^4 Ns^2 (n^2 + 2)^2) F               (B99, eq. 22)
//! n  refractive index at 15 C and 1013.25 mb, 300 ppm CO2, scaled to 360 ppm   (B99, eqs. 4, 5)
//! F  King factor of N2, O2, Ar and CO2 in their shares by volume         (B99, eqs. 5, 6 and 23)
//! Ns = 2.546899e25 /m^3;  column = 2.15204e29 /m^2 at 1013.25 mb, 45 N, sea level (B99, eq. 26),
//! so that an exponential atmosphere of the density Ns has the scale height 8449.65 m.
//! Holds from 0.25 to 1 um; optical depths agree with B99's closed fit (eq. 30) to 1e-4.
//! [B99] Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999).
//! [PR72] Peck and Reeder, J. Opt. Soc. Am. 62, 958-962 (1972): the refractive index.

use std::f64::consts::PI;

use niji_radiometry::Meters;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::constituent::Constituent;
use crate::density_profile::DensityProfile;
use crate::phase_function::PhaseFunction;

/// Molecules at 15 C and 1013.25 mb, 1/m^3 (B99, below eq. 22).
const MOLECULES_M3: f64 = 2.546899e25;
/// Share of CO2 by volume (B99).
const CO2: f64 = 360e-6;
/// Avogadro's constant as used by B99, 1/mol.
const AVOGADRO: f64 = 6.0221367e23;
/// Standard pressure at sea level, Pa.
pub(crate) const STANDARD_PRESSURE_PA: f64 = 101_325.0;
/// Effective gravity of the air column at 45 N above sea level, m/s^2 (B99, eqs. 10 and 26).
const GRAVITY: f64 = 9.789_158;

/// Refractive index of air at 15 C with 360 ppm CO2 (B99, eqs. 4 and 5; PR72).
fn refractivity(wavelength: Nanometers) -> f64 {
    let inverse2 = Micrometers::from(wavelength).0.powi(-2);
    let at_300_ppm =
        1e-8 * (8060.51 + 2480990.0 / (132.274 - inverse2) + 17455.7 / (39.32957 - inverse2));
    at_300_ppm * (1.0 + 0.54 * (CO2 - 300e-6))
}

/// King factor of air (B99, eqs. 5, 6 and 23).
pub fn king_factor(wavelength: Nanometers) -> f64 {
    let inverse2 = Micrometers::from(wavelength).0.powi(-2);
    let nitrogen = 1.034 + 3.17e-4 * inverse2;
    let oxygen = 1.096 + 1.385e-3 * inverse2 + 1.448e-4 * inverse2 * inverse2;
    let co2_percent = 100.0 * CO2;
    let sum = 78.084 * nitrogen + 20.946 * oxygen + 0.934 * 1.00 + co2_percent * 1.15;
    sum / (78.084 + 20.946 + 0.934 + co2_percent)
}

/// Scattering coefficient at 15 C and 1013.25 mb, 1/m (B99, eq. 22 times Ns).
pub fn rayleigh_bodhaine_m1(wavelength: Nanometers) -> f64 {
    let lambda_m = Meters::from(wavelength).0;
    let refractivity = refractivity(wavelength);
    // n^2 - 1 = (n - 1)(n + 1), without the cancellation.
    let n2_minus_1 = refractivity * (2.0 + refractivity);
    let ratio = n2_minus_1 / (n2_minus_1 + 3.0);
    24.0 * PI.powi(3) * ratio.powi(2) * king_factor(wavelength) / (lambda_m.powi(4) * MOLECULES_M3)
}

/// Height of a column of air of sea level density above standard pressure, m.
pub(crate) fn equivalent_height_m() -> f64 {
    // Mean molecular mass of dry air, kg/mol (B99, eq. 17).
    let molar_mass = 1e-3 * (15.0556 * CO2 + 28.9595);
    STANDARD_PRESSURE_PA * AVOGADRO / (molar_mass * GRAVITY) / MOLECULES_M3
}

/// Air molecules at a pressure at sea level, evaluated at the centers of the bins.
pub fn rayleigh_bodhaine(wavelengths: &WavelengthGrid, pressure_pa: f64) -> Constituent {
    let pressure_ratio = pressure_pa / STANDARD_PRESSURE_PA;
    let scattering = |wavelength| pressure_ratio * rayleigh_bodhaine_m1(wavelength);
    let scattering_m1: Vec<f64> = wavelengths.centers().map(scattering).collect();
    Constituent {
        name: "rayleigh".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: equivalent_height_m(),
        },
        extinction_m1: scattering_m1.clone(),
        scattering_m1,
        phase: PhaseFunction::Rayleigh {
            king_factor: wavelengths.centers().map(king_factor).collect(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest deviation from the closed fit from 400 to 700 nm; the worst is 9.4e-5.
    const FIT_TOLERANCE: f64 = 1e-4;

    fn optical_depth(nm: f64) -> f64 {
        rayleigh_bodhaine_m1(Nanometers(nm)) * equivalent_height_m()
    }

    #[test]
    fn optical_depths_agree_with_the_closed_fit() {
        // B99, eq. 30.
        for step in 0..=30 {
            let nm = 400.0 + 10.0 * f64::from(step);
            let l2 = (1e-3 * nm) * (1e-3 * nm);
            let fit = 0.0021520 * (1.0455996 - 341.29061 / l2 - 0.90230850 * l2)
                / (1.0 + 0.0027059889 / l2 - 85.968563 * l2);
            let error = optical_depth(nm) / fit - 1.0;
            assert!(error.abs() < FIT_TOLERANCE, "{nm} nm: {error}");
        }
    }

    #[test]
    fn optical_depths_agree_with_published_values() {
        let published = [
            (400.0, 0.36021),
            (450.0, 0.22111),
            (500.0, 0.14335),
            (550.0, 0.09707),
            (600.0, 0.06809),
            (650.0, 0.04919),
            (700.0, 0.03642),
        ];
        for (nm, depth) in published {
            assert!(
                (optical_depth(nm) / depth - 1.0).abs() < 2e-4,
                "{nm}: {}",
                optical_depth(nm)
            );
        }
    }

    #[test]
    fn king_factors_agree_with_published_values() {
        let published = [
            (400.0, 1.0513),
            (500.0, 1.0493),
            (550.0, 1.0488),
            (600.0, 1.0484),
            (700.0, 1.0479),
        ];
        for (nm, factor) in published {
            let found = king_factor(Nanometers(nm));
            assert!((found - factor).abs() < 6e-5, "{nm} nm: {found}");
        }
    }

    #[test]
    fn the_equivalent_height_is_that_of_the_published_column() {
        assert!(
            (equivalent_height_m() - 8449.65).abs() < 0.1,
            "{}",
            equivalent_height_m()
        );
    }

    #[test]
    fn half_the_pressure_has_half_the_optical_depth() {
        let grid = WavelengthGrid::visible();
        let full = rayleigh_bodhaine(&grid, STANDARD_PRESSURE_PA).vertical_optical_depth();
        let half = rayleigh_bodhaine(&grid, 0.5 * STANDARD_PRESSURE_PA).vertical_optical_depth();
        for (full, half) in full.into_iter().zip(half) {
            assert!((0.5 * full - half).abs() < 1e-15);
        }
    }
}
