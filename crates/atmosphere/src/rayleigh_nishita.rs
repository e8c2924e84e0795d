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
use crate::error::Error;
use crate::error::positive;
use crate::error::within;
use crate::king_factor::KingFactor;

/// Air molecules by the formula of computer graphics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NishitaAir {
    /// Refractive index n of air at all wavelengths.
    pub refractive_index: f64,
    /// Molecules Ns at sea level, 1/m^3.
    pub molecules_m3: f64,
    /// Height H0 over which the density falls to 1/e, m.
    pub scale_height_m: f64,
    /// How far the molecules deviate from spheres: not at all in the publications.
    pub king_factor: KingFactor,
}

impl NishitaAir {
    /// The constants in print (N87).
    pub const PUBLISHED: Self = Self {
        refractive_index: 1.0003,
        molecules_m3: 2.545e25,
        scale_height_m: 7994.0,
        king_factor: KingFactor::Constant(1.0),
    };

    /// Scattering coefficient at sea level, 1/m (N87, eqs. 3 and 4).
    pub fn scattering_m1(&self, wavelength: Nanometers) -> f64 {
        let lambda_m = Meters::from(wavelength).0;
        let n = self.refractive_index;
        let k = 2.0 * PI * PI * (n * n - 1.0).powi(2) / (3.0 * self.molecules_m3);
        self.king_factor.at(wavelength) * (4.0 * PI * k / lambda_m.powi(4))
    }

    /// The molecules on a grid of wavelengths, evaluated at the centers of the bins.
    ///
    /// # Errors
    /// If a number lies outside its range.
    pub fn constituent(&self, wavelengths: &WavelengthGrid) -> Result<Constituent, Error> {
        within("refractive index of air", self.refractive_index, [1.0, 1.1])?;
        positive("number of molecules", self.molecules_m3, "1/m^3")?;
        let scale_height_m = positive("scale height of the air", self.scale_height_m, "m")?;
        self.king_factor.check()?;
        let scattering_m1: Vec<f64> = wavelengths
            .centers()
            .map(|center| self.scattering_m1(center))
            .collect();
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

    #[test]
    fn coefficients_are_those_of_the_formula_in_print() {
        // 4 pi 9.3100814e-32 m^3/lambda^4, eight digits from mpmath.
        for (nm, m1) in [
            (450.0, 2.853076e-5),
            (550.0, 1.278535e-5),
            (650.0, 6.554053e-6),
        ] {
            let found = NishitaAir::PUBLISHED.scattering_m1(Nanometers(nm));
            assert!((found / m1 - 1.0).abs() < 2e-7, "{nm} nm: {found}");
        }
    }

    #[test]
    fn vertical_optical_depths_are_the_published_ones() {
        let grid = WavelengthGrid::new(450.0, 100.0, 3).unwrap();
        let air = NishitaAir::PUBLISHED.constituent(&grid).unwrap();
        for (found, expected) in air
            .vertical_optical_depth()
            .into_iter()
            .zip([0.2281, 0.1022, 0.0524])
        {
            assert!((found - expected).abs() < 5.1e-5, "{found}");
        }
    }

    #[test]
    fn twice_the_molecules_of_the_same_index_scatter_half_as_much() {
        let published = NishitaAir::PUBLISHED;
        let denser = NishitaAir {
            molecules_m3: 2.0 * published.molecules_m3,
            ..published
        };
        let wavelength = Nanometers(550.0);
        let ratio = denser.scattering_m1(wavelength) / published.scattering_m1(wavelength);
        assert!((ratio - 0.5).abs() < 1e-15);
        let empty = NishitaAir {
            molecules_m3: 0.0,
            ..published
        };
        assert!(empty.constituent(&WavelengthGrid::visible()).is_err());
    }
}
