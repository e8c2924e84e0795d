//! Refractive index of sea water.
//!
//! n = n0 + (n1 + n2 T + n3 T^2) S + n4 T^2 + (n5 + n6 S + n7 T)/lambda + n8/lambda^2 + n9/lambda^3
//! `T` temperature in C, `S` salinity in per mille, `lambda` in nm.
//! Holds for 400 to 700 nm, 0 to 30 C, 0 to 35 per mille, to 1.5e-5; the index is relative to air.
//! [QF95] Quan and Fry, Applied Optics 34, 3477-3480 (1995), eq. 3.

use crate::units::Nanometers;
use crate::water::Water;

/// Refractive index of sea water relative to air (QF95, eq. 3).
///
/// ```
/// use niji_radiometry::{Nanometers, sea_water_refractive_index, water_refractive_index};
///
/// // Salt makes the bow of spray 0.9 degrees smaller: its index is higher by 0.0065.
/// let yellow = Nanometers(589.3);
/// let sea = sea_water_refractive_index(yellow, 20.0, 35.0);
/// assert!((sea - water_refractive_index(yellow, 20.0) - 0.0065).abs() < 3e-4);
/// ```
pub fn sea_water_refractive_index(
    wavelength: Nanometers,
    temperature_c: f64,
    salinity_per_mille: f64,
) -> f64 {
    let lambda = wavelength.0;
    let (t, s) = (temperature_c, salinity_per_mille);
    1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t
        + (15.868 + 0.01155 * s - 0.00423 * t) / lambda
        - 4382.0 / lambda.powi(2)
        + 1.1455e6 / lambda.powi(3)
}

/// What the salt alone adds to the index: the terms in S of eq. 3, exactly 0 without salt.
pub(crate) fn index_of_salt(wavelength: Nanometers, water: Water) -> f64 {
    let (t, s) = (water.temperature_c, water.salinity_per_mille);
    (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s + 0.01155 * s / wavelength.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iapws_r9_97::water_refractive_index;

    #[test]
    fn agrees_with_evaluations_of_five_public_codes() {
        let n = |salinity| sea_water_refractive_index(Nanometers(550.0), 20.0, salinity);
        assert!((n(0.0) - 1.334338).abs() <= 5e-7, "{}", n(0.0));
        assert!((n(35.0) - 1.340789).abs() <= 5e-7, "{}", n(35.0));
    }

    #[test]
    fn salt_is_all_that_tells_sea_water_from_fresh() {
        for (temperature_c, salinity_per_mille) in [(0.0, 35.0), (15.0, 10.0), (30.0, 40.0)] {
            let n =
                |salinity| sea_water_refractive_index(Nanometers(450.0), temperature_c, salinity);
            let water = Water {
                temperature_c,
                salinity_per_mille,
            };
            let salt = index_of_salt(Nanometers(450.0), water);
            assert!((n(salinity_per_mille) - n(0.0) - salt).abs() < 1e-15);
        }
    }

    #[test]
    fn without_salt_it_is_fresh_water_in_air() {
        // Worst found 3.5e-5; relative to vacuum the two would differ by 3e-4.
        for wavelength_nm in [400.0, 500.0, 600.0, 700.0] {
            for temperature_c in [0.0, 10.0, 20.0, 30.0] {
                let wavelength = Nanometers(wavelength_nm);
                let difference = sea_water_refractive_index(wavelength, temperature_c, 0.0)
                    - water_refractive_index(wavelength, temperature_c);
                assert!(
                    difference.abs() <= 5e-5,
                    "{wavelength_nm} {temperature_c}: {difference}"
                );
            }
        }
    }
}
