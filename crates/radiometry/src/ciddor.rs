//! Refractive index of standard air.
//!
//! n - 1 = 0.05792105/(238.0185 - s^2) + 0.00167917/(57.362 - s^2),  s = 1/lambda in um^-1
//! Dry air at 15 C, 101325 Pa, 450 ppm CO2; 0.23 to 1.69 um, relative to vacuum.
//! [C96] Ciddor, Applied Optics 35, 1566-1573 (1996), eq. 1.

use crate::units::Micrometers;
use crate::units::Nanometers;

/// Refractive index of standard air relative to vacuum (C96, eq. 1).
///
/// ```
/// use niji_radiometry::{Nanometers, air_refractive_index};
///
/// assert!((air_refractive_index(Nanometers(589.3)) - 1.000277).abs() < 1e-6);
/// ```
pub fn air_refractive_index(wavelength: Nanometers) -> f64 {
    let s2 = Micrometers::from(wavelength).0.powi(-2);
    1.0 + 0.05792105 / (238.0185 - s2) + 0.00167917 / (57.362 - s2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refractivity_agrees_with_published_values() {
        // Ciddor's formula as tabulated at 15 C and 1013.25 mb.
        for (wavelength_nm, refractivity) in
            [(450.0, 2.8053e-4), (550.0, 2.7783e-4), (650.0, 2.7632e-4)]
        {
            let found = air_refractive_index(Nanometers(wavelength_nm)) - 1.0;
            assert!(
                (found - refractivity).abs() <= 1.5e-8,
                "{wavelength_nm} nm: {found}"
            );
        }
    }
}
