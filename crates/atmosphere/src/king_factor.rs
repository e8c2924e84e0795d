//! The King factor: how much more molecules scatter because they are no spheres.
//!
//! F = (6 + 3 d)/(6 - 7 d),  d the depolarization ratio of natural light
//! F(lambda) of air is the mean over N2, O2, Ar and CO2 in their shares by volume:
//!   N2  1.034 + 3.17e-4 l^-2,  O2  1.096 + 1.385e-3 l^-2 + 1.448e-4 l^-4,  Ar 1.00,  CO2 1.15
//! with l the wavelength in um (B99, eqs. 5, 6 and 23). Holds from 0.2 to 1 um.
//! [B99] Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999).

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;

use crate::error::Error;
use crate::error::within;

/// Share of CO2 by volume (B99).
pub(crate) const CO2: f64 = 360e-6;

/// How far molecules deviate from spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KingFactor {
    /// That of air by wavelength.
    Air,
    /// One number for all wavelengths; 1 is for spheres.
    Constant(f64),
}

impl KingFactor {
    /// The factor at a wavelength.
    pub fn at(self, wavelength: Nanometers) -> f64 {
        match self {
            Self::Air => king_factor(wavelength),
            Self::Constant(factor) => factor,
        }
    }

    pub(crate) fn check(self) -> Result<(), Error> {
        match self {
            Self::Air => Ok(()),
            // Depolarization 0 to 0.5; that of air is 0.028.
            Self::Constant(factor) => within("King factor", factor, [1.0, 3.0]).map(|_| ()),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_constant_factor_knows_no_wavelength_and_lies_at_or_above_1() {
        let factor = KingFactor::Constant(1.0608);
        assert_eq!(factor.at(Nanometers(400.0)), factor.at(Nanometers(700.0)));
        assert!(factor.check().is_ok());
        assert!(KingFactor::Constant(0.9).check().is_err());
        assert!(KingFactor::Constant(f64::NAN).check().is_err());
    }
}
