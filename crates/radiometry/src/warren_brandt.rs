//! Complex refractive index of ice.
//!
//! n + i k, absorption coefficient 4 pi k / lambda; 300 to 1000 nm, ice Ih at 266 K.
//! n is interpolated linearly; k spans four decades, so ln k is linear in ln lambda.
//! As tabulated: n to four decimals, with no statement that tells vacuum from air (3e-4 apart).
//! [WB08] Warren and Brandt, J. Geophysical Research 113, D14220 (2008).

use std::sync::LazyLock;

use crate::piecewise_linear::PiecewiseLinear;
use crate::tabulated_spectrum::TabulatedSpectrum;
use crate::units::Nanometers;

const TABLE: &str = include_str!("../../../data/ice_warren_2008.csv");

static REAL_PART: LazyLock<TabulatedSpectrum> = LazyLock::new(|| column("n"));

static LOG_IMAGINARY_PART: LazyLock<PiecewiseLinear> = LazyLock::new(|| {
    let log_log = |&(wavelength_nm, k): &(f64, f64)| (wavelength_nm.ln(), k.ln());
    PiecewiseLinear::new(column("k").points().iter().map(log_log).collect())
});

/// Refractive index `n` and absorption index `k` >= 0 of ice (WB08).
///
/// Outside 300 to 1000 nm the values of the nearest end.
///
/// ```
/// use niji_radiometry::{Nanometers, ice_refractive_index};
///
/// // The index that makes the halo of 22 degrees; blue goes much farther through ice than red.
/// let (n, k) = ice_refractive_index(Nanometers(589.0));
/// assert!((n - 1.3098).abs() < 5e-4);
/// assert!(k > 10.0 * ice_refractive_index(Nanometers(420.0)).1);
/// ```
pub fn ice_refractive_index(wavelength: Nanometers) -> (f64, f64) {
    (
        REAL_PART.at(wavelength),
        LOG_IMAGINARY_PART.at(wavelength.0.ln()).exp(),
    )
}

fn column(name: &str) -> TabulatedSpectrum {
    TabulatedSpectrum::from_csv(TABLE, name)
        .expect("the embedded table is part of this program and parsed by every test below")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_table_of_warren_and_brandt() {
        for (wavelength_nm, n, k) in [
            (400.0, 1.3194, 2.365e-11),
            (450.0, 1.3157, 9.24e-11),
            (500.0, 1.3130, 5.89e-10),
            (550.0, 1.3110, 2.289e-9),
            (600.0, 1.3094, 5.73e-9),
            (650.0, 1.3080, 1.43e-8),
            (700.0, 1.3069, 2.9e-8),
        ] {
            let (found_n, found_k) = ice_refractive_index(Nanometers(wavelength_nm));
            assert!((found_n - n).abs() <= 5e-5, "{wavelength_nm} nm: {found_n}");
            assert!(
                (found_k / k - 1.0).abs() <= 1e-3,
                "{wavelength_nm} nm: {found_k}"
            );
        }
    }

    #[test]
    fn absorption_is_interpolated_in_logarithms() {
        // Geometric mean of the neighbours at the geometric mean of their wavelengths.
        let k = |wavelength_nm| ice_refractive_index(Nanometers(wavelength_nm)).1;
        let between = k((400.0_f64 * 410.0).sqrt());
        assert!((between / (k(400.0) * k(410.0)).sqrt() - 1.0).abs() <= 1e-12);
    }

    #[test]
    fn ends_of_the_table_hold_outside() {
        assert_eq!(
            ice_refractive_index(Nanometers(200.0)),
            ice_refractive_index(Nanometers(300.0))
        );
        assert!(ice_refractive_index(Nanometers(5000.0)).1.is_finite());
    }
}
