//! Sunlight above the air.
//!
//! E_i = mean over bin i of E(lambda), W m^-2 nm^-1, at 1 AU and normal incidence, 300 to 1000 nm.
//! The table is the extraterrestrial column of ASTM G173-03 at 0.5 and 1 nm.
//! Point samples would be wrong by the sun's lines, 12 % at 400 nm: hence means.
//! [G173] ASTM G173-03, Reference Solar Spectral Irradiances (2003); Gueymard, Solar Energy 71,
//! 325-346 (2001).

use std::sync::LazyLock;

use crate::tabulated_spectrum::TabulatedSpectrum;
use crate::wavelength_grid::WavelengthGrid;

static SUN: LazyLock<TabulatedSpectrum> = LazyLock::new(|| {
    let table = include_str!("../../../data/solar_irradiance_g173.csv");
    TabulatedSpectrum::from_csv(table, "irradiance_w_m2_nm")
        .expect("the embedded table is part of this program and parsed by every test below")
});

/// Mean solar irradiance of every bin of `grid` above the air at 1 AU, W m^-2 nm^-1.
///
/// ```
/// use niji_radiometry::{WavelengthGrid, solar_irradiance};
///
/// let green = solar_irradiance(&WavelengthGrid::new(500.0, 10.0, 1)?)[0];
/// assert!((green - 1.92).abs() < 0.03);
/// # Ok::<(), niji_radiometry::Error>(())
/// ```
pub fn solar_irradiance(grid: &WavelengthGrid) -> Vec<f64> {
    SUN.on(grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Nanometers;

    fn mean_around(center_nm: f64, width_nm: f64) -> f64 {
        solar_irradiance(&WavelengthGrid::new(center_nm, width_nm, 1).unwrap())[0]
    }

    #[test]
    fn bin_means_agree_with_the_published_spectrum() {
        // G173 averaged over +-5 nm, W m^-2 nm^-1; printed to three decimals.
        for (center_nm, mean) in [
            (400.0, 1.504),
            (450.0, 1.991),
            (500.0, 1.919),
            (550.0, 1.867),
            (600.0, 1.767),
            (650.0, 1.583),
            (700.0, 1.423),
        ] {
            let found = mean_around(center_nm, 10.0);
            assert!(
                (found - mean).abs() <= 6e-4,
                "{center_nm} nm: {found}, expected {mean}"
            );
        }
    }

    #[test]
    fn a_point_sample_at_400_nm_would_be_12_percent_too_bright() {
        let point = SUN.at(Nanometers(400.0));
        assert!((point - 1.689).abs() <= 6e-4, "{point}");
        assert!((point / mean_around(400.0, 10.0) - 1.123).abs() <= 1e-3);
    }

    #[test]
    fn fine_bins_add_up_to_coarse_bins() {
        let fine = solar_irradiance(&WavelengthGrid::new(380.5, 1.0, 400).unwrap());
        let coarse = solar_irradiance(&WavelengthGrid::new(385.0, 10.0, 40).unwrap());
        for (index, mean) in coarse.iter().enumerate() {
            let sum: f64 = fine[10 * index..10 * (index + 1)].iter().sum();
            assert!((sum / 10.0 - mean).abs() <= 1e-14 * mean);
        }
    }

    #[test]
    fn the_band_of_the_table_carries_the_tabulated_power() {
        // W m^-2 from 300 to 1000 nm: the trapezoid rule over the 801 rows of the file in Python.
        let total = 700.0 * mean_around(650.0, 700.0);
        assert!((total - 935.93233).abs() <= 1e-9 * total, "{total}");
    }
}
