//! The water that drops are made of: pure or salt, and how warm.
//!
//! n = n_fresh(lambda, T) + n_salt(lambda, T, S) - n_salt(lambda, T, 0)
//! `n_fresh` of pure water (IAPWS R9-97), `n_salt` of sea water (QF95), both relative to air, `T`
//! temperature in C, `S` salinity in per mille. Of sea water only what the salt adds is taken, linear
//! in `S`: n is that of pure water, to the last bit, where there is no salt.
//! Pure from -20 to 100 C, as far as the density is known; salt from 0 to 30 C and to 40 per mille, the
//! range of MS90 and the saltiest of open seas: QF95 end at 35, and their straight line is drawn on.
//! [QF95] Quan and Fry, Applied Optics 34, 3477-3480 (1995), eq. 3.
//! [MS90] Millard and Seaver, Deep-Sea Research 37, 1909-1926 (1990).

use std::fmt;
use std::ops::RangeInclusive;

use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::iapws_r9_97::water_refractive_index;
use crate::quan_fry::index_of_salt;
use crate::units::Nanometers;

/// Pure water, supercooled to boiling, degrees Celsius.
const PURE_C: RangeInclusive<f64> = -20.0..=100.0;
/// Salt water, degrees Celsius (QF95, MS90).
const SALT_C: RangeInclusive<f64> = 0.0..=30.0;
/// From pure water to the saltiest of open seas, per mille (MS90).
const SALINITY_PER_MILLE: RangeInclusive<f64> = 0.0..=40.0;
/// Standard sea water (Practical Salinity Scale 1978), per mille.
const SEA_PER_MILLE: f64 = 35.0;

/// Water by its temperature and its salt.
///
/// ```
/// use niji_radiometry::{Nanometers, Water};
///
/// // Sea water at 15 degrees bends green light by 1.3413, pure water by 1.3347.
/// let green = Nanometers(550.0);
/// assert!((Water::of_the_sea(15.0).refractive_index(green) - 1.3413).abs() < 1e-4);
/// assert!((Water::pure(15.0).refractive_index(green) - 1.3347).abs() < 1e-4);
/// assert!(Water::of_the_sea(80.0).check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Water {
    /// Temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Salt by mass, per mille; left out of what is written where there is none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub salinity_per_mille: f64,
}

impl Water {
    /// Water without salt.
    pub const fn pure(temperature_c: f64) -> Self {
        Self {
            temperature_c,
            salinity_per_mille: 0.0,
        }
    }

    /// Water of the open sea.
    pub const fn of_the_sea(temperature_c: f64) -> Self {
        Self {
            temperature_c,
            salinity_per_mille: SEA_PER_MILLE,
        }
    }

    /// Refractive index relative to air, as a drop in air has it.
    pub fn refractive_index(self, wavelength: Nanometers) -> f64 {
        water_refractive_index(wavelength, self.temperature_c) + index_of_salt(wavelength, self)
    }

    /// Refuses water of which nobody measured the index.
    ///
    /// # Errors
    /// [`Error::Water`] outside of -20 to 100 degrees Celsius without salt, of 0 to 30 and 40 per mille
    /// with it.
    pub fn check(self) -> Result<(), Error> {
        let sound_c = if is_zero(&self.salinity_per_mille) {
            PURE_C
        } else {
            SALT_C
        };
        if sound_c.contains(&self.temperature_c)
            && SALINITY_PER_MILLE.contains(&self.salinity_per_mille)
        {
            return Ok(());
        }
        Err(Error::Water { found: self })
    }
}

impl fmt::Display for Water {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} degrees Celsius", self.temperature_c)?;
        if is_zero(&self.salinity_per_mille) {
            return Ok(());
        }
        write!(f, " and {} per mille of salt", self.salinity_per_mille)
    }
}

/// Compared with the value that stands for pure water.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_zero(salinity_per_mille: &f64) -> bool {
    *salinity_per_mille == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest difference of the two formulas without salt, found 3.5e-5.
    const BETWEEN_SOURCES: f64 = 5e-5;

    #[test]
    fn without_salt_it_is_pure_water_to_the_last_bit() {
        for temperature_c in [-20.0, 0.0, 15.0, 20.0, 100.0] {
            for nm in [300.0, 380.0, 550.0, 1000.0] {
                let found = Water::pure(temperature_c).refractive_index(Nanometers(nm));
                let expected = water_refractive_index(Nanometers(nm), temperature_c);
                assert_eq!(found.to_bits(), expected.to_bits(), "{temperature_c} {nm}");
            }
        }
    }

    #[test]
    fn sea_water_has_the_published_index() {
        // QF95, eq. 3, as five public codes evaluate it.
        let sea = Water::of_the_sea(20.0).refractive_index(Nanometers(550.0));
        assert!((sea - 1.340789).abs() < BETWEEN_SOURCES, "{sea}");
    }

    #[test]
    fn every_per_mille_bends_light_as_much_more() {
        let n = |salinity_per_mille| {
            let water = Water {
                temperature_c: 15.0,
                salinity_per_mille,
            };
            water.refractive_index(Nanometers(550.0))
        };
        let (half, whole) = (n(17.5) - n(0.0), n(35.0) - n(0.0));
        assert!((2.0 * half - whole).abs() < 1e-15, "{half} {whole}");
        assert!((0.0064..0.0067).contains(&whole), "{whole}");
    }

    #[test]
    fn water_that_nobody_measured_is_refused() {
        let water = |temperature_c, salinity_per_mille| {
            let water = Water {
                temperature_c,
                salinity_per_mille,
            };
            water.check()
        };
        for (temperature_c, salinity) in [(-20.0, 0.0), (100.0, 0.0), (0.0, 40.0), (30.0, 1e-9)] {
            assert_eq!(water(temperature_c, salinity), Ok(()));
        }
        for (temperature_c, salinity) in [
            (-20.1, 0.0),
            (100.1, 0.0),
            (-0.1, 35.0),
            (30.1, 1e-9),
            (15.0, 40.1),
            (15.0, -1e-9),
            (f64::NAN, 0.0),
            (15.0, f64::NAN),
        ] {
            let error = water(temperature_c, salinity).unwrap_err().to_string();
            assert!(error.contains("0 to 40 per mille"), "{error}");
        }
    }
}
