//! Absorption of pure ice.
//!
//! alpha = 4 pi k / lambda  [1/m],  I = I_0 exp(-alpha x)
//! `k` imaginary part of the refractive index (radiometry, Warren and Brandt 2008), `lambda` vacuum
//! wavelength, `x` way through ice. 300 to 1000 nm. Violet passes best, 0.0007 per metre at 400 nm;
//! red dies first, 0.5 per metre at 700 nm.

use std::f64::consts::PI;

use niji_radiometry::Meters;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::ice_refractive_index;

/// Absorption coefficient of pure ice, 1/m.
///
/// ```
/// use niji_ice::ice_absorption_per_m;
/// use niji_radiometry::Nanometers;
/// let alpha = ice_absorption_per_m(Nanometers(550.0));
/// assert!((alpha - 0.0523).abs() < 1e-4);
/// ```
pub fn ice_absorption_per_m(wavelength: Nanometers) -> f64 {
    let (_, k) = ice_refractive_index(wavelength);
    4.0 * PI * k / Meters::from(wavelength).0
}

/// Absorption coefficient at the center of every bin, 1/m.
pub fn ice_absorption_spectrum(wavelengths: &WavelengthGrid) -> Vec<f64> {
    wavelengths.centers().map(ice_absorption_per_m).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_is_that_of_the_table_of_2008() {
        // 4 pi k/lambda from the printed k. The table of 1984 has 0.085 at 400 nm, 115 times as much.
        for (wavelength_nm, alpha_per_m) in [
            (400.0, 7.43e-4),
            (520.0, 0.0260),
            (550.0, 0.0523),
            (590.0, 0.1050),
            (700.0, 0.5206),
        ] {
            let found = ice_absorption_per_m(Nanometers(wavelength_nm));
            // Worst found 9e-4, the rounding of the printed values.
            assert!(
                (found / alpha_per_m - 1.0).abs() < 2e-3,
                "{wavelength_nm} nm: {found}"
            );
        }
    }

    #[test]
    fn beyond_thirty_metres_no_red_is_left() {
        let left = |wavelength_nm| (-30.0 * ice_absorption_per_m(Nanometers(wavelength_nm))).exp();
        assert!(left(700.0) < 1e-6 && left(450.0) > 0.9 && left(400.0) > left(450.0));
    }
}
