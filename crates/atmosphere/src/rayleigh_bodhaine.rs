//! Rayleigh scattering of real air.
//!
//! sigma = 24 pi^3 (n^2 - 1)^2/(lambda^4 Ns^2 (n^2 + 2)^2) F               (B99, eq. 22)
//! n  refractive index at 15 C and 1013.25 mb, 300 ppm CO2, scaled to 360 ppm   (B99, eqs. 4, 5)
//! F  King factor                                                        (B99, eqs. 5, 6 and 23)
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
use crate::error::Error;
use crate::error::positive;
use crate::king_factor::CO2;
use crate::king_factor::KingFactor;
use crate::king_factor::king_factor;

/// Molecules at 15 C and 1013.25 mb, 1/m^3 (B99, below eq. 22).
const MOLECULES_M3: f64 = 2.546899e25;
/// Avogadro's constant as used by B99, 1/mol.
const AVOGADRO: f64 = 6.0221367e23;
/// Standard pressure at sea level, Pa.
pub const STANDARD_PRESSURE_PA: f64 = 101_325.0;
/// Effective gravity of the air column at 45 N above sea level, m/s^2 (B99, eqs. 10 and 26).
const GRAVITY: f64 = 9.789_158;

/// Refractive index of air at 15 C with 360 ppm CO2 (B99, eqs. 4 and 5; PR72).
fn refractivity(wavelength: Nanometers) -> f64 {
    let inverse2 = Micrometers::from(wavelength).0.powi(-2);
    let at_300_ppm =
        1e-8 * (8060.51 + 2480990.0 / (132.274 - inverse2) + 17455.7 / (39.32957 - inverse2));
    at_300_ppm * (1.0 + 0.54 * (CO2 - 300e-6))
}

/// Scattering coefficient at 15 C and 1013.25 mb, 1/m (B99, eq. 22 times Ns).
///
/// ```
/// use niji_atmosphere::rayleigh_bodhaine_m1;
/// use niji_radiometry::Nanometers;
///
/// // Their table 3 has 4.513e-27 cm^2 at 550 nm, times 2.54743e19 molecules per cm^3.
/// let scattering_m1 = rayleigh_bodhaine_m1(Nanometers(550.0));
/// assert!((scattering_m1 / (4.513e-31 * 2.54743e25) - 1.0).abs() < 1e-3);
/// ```
pub fn rayleigh_bodhaine_m1(wavelength: Nanometers) -> f64 {
    king_factor(wavelength) * sphere_scattering_m1(wavelength)
}

/// The same for molecules without a King factor.
fn sphere_scattering_m1(wavelength: Nanometers) -> f64 {
    let lambda_m = Meters::from(wavelength).0;
    let refractivity = refractivity(wavelength);
    // n^2 - 1 = (n - 1)(n + 1), without the cancellation.
    let n2_minus_1 = refractivity * (2.0 + refractivity);
    let ratio = n2_minus_1 / (n2_minus_1 + 3.0);
    24.0 * PI.powi(3) * ratio.powi(2) / (lambda_m.powi(4) * MOLECULES_M3)
}

/// Height of a column of air of sea level density above standard pressure, m.
pub(crate) fn equivalent_height_m() -> f64 {
    // Mean molecular mass of dry air, kg/mol (B99, eq. 17).
    let molar_mass = 1e-3 * (15.0556 * CO2 + 28.9595);
    STANDARD_PRESSURE_PA * AVOGADRO / (molar_mass * GRAVITY) / MOLECULES_M3
}

/// Air molecules as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodhaineAir {
    /// Pressure at sea level, Pa.
    pub pressure_pa: f64,
    /// Height over which the density falls to 1/e, m.
    scale_height_m: f64,
    /// How far the molecules deviate from spheres.
    king_factor: KingFactor,
}

impl BodhaineAir {
    /// Air at a pressure at sea level that has the optical depth of the published column.
    pub fn at_pressure(pressure_pa: f64) -> Self {
        Self {
            pressure_pa,
            scale_height_m: equivalent_height_m(),
            king_factor: KingFactor::Air,
        }
    }

    /// The molecules on a grid of wavelengths, evaluated at the centers of the bins.
    ///
    /// # Errors
    /// If a number lies outside its range.
    pub fn constituent(&self, wavelengths: &WavelengthGrid) -> Result<Constituent, Error> {
        let pressure_ratio = positive("pressure", self.pressure_pa, "Pa")? / STANDARD_PRESSURE_PA;
        let scale_height_m = positive("scale height of the air", self.scale_height_m, "m")?;
        self.king_factor.check()?;
        let scattering = |wavelength| {
            pressure_ratio * self.king_factor.at(wavelength) * sphere_scattering_m1(wavelength)
        };
        let scattering_m1: Vec<f64> = wavelengths.centers().map(scattering).collect();
        let king_factor = wavelengths
            .centers()
            .map(|center| self.king_factor.at(center))
            .collect();
        Ok(Constituent::molecules(
            scattering_m1,
            king_factor,
            scale_height_m,
        ))
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
        let depth = |pressure_pa: f64| {
            let air = BodhaineAir::at_pressure(pressure_pa);
            air.constituent(&grid).unwrap().vertical_optical_depth()
        };
        let (full, half) = (
            depth(STANDARD_PRESSURE_PA),
            depth(0.5 * STANDARD_PRESSURE_PA),
        );
        for (full, half) in full.into_iter().zip(half) {
            assert!((0.5 * full - half).abs() < 1e-15);
        }
    }

    #[test]
    fn spheres_scatter_less_by_the_king_factor() {
        let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
        let air = BodhaineAir::at_pressure(STANDARD_PRESSURE_PA);
        let spheres = BodhaineAir {
            king_factor: KingFactor::Constant(1.0),
            ..air
        };
        let [air, spheres] = [air, spheres].map(|air| air.constituent(&grid).unwrap());
        let ratio = air.scattering_m1[0] / spheres.scattering_m1[0];
        assert!((ratio - 1.0488).abs() < 6e-5, "{ratio}");
    }

    #[test]
    fn air_without_height_or_pressure_is_refused() {
        let grid = WavelengthGrid::visible();
        let air = BodhaineAir::at_pressure(STANDARD_PRESSURE_PA);
        let flat = BodhaineAir {
            scale_height_m: 0.0,
            ..air
        };
        assert!(flat.constituent(&grid).is_err());
        assert!(BodhaineAir::at_pressure(-1.0).constituent(&grid).is_err());
    }
}
