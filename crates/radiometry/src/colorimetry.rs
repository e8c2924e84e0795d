//! From spectral radiance to CIE XYZ.
//!
//! X = K int L(lambda) xbar(lambda) dlambda, same for Y and Z,  K = 683 lm/W
//! `L` spectral radiance in W m^-2 sr^-1 nm^-1, so that Y is a luminance in cd m^-2.
//! On bins of constant L the integral is a sum with weights K int_bin xbar dlambda, exact for the
//! broken line through the standard observer at 1 nm. Outside 360 to 830 nm the observer is blind.
//! [CIE] CIE 1931 2-degree standard observer, ISO/CIE 11664-1:2019.

use std::sync::LazyLock;

use crate::tabulated_spectrum::TabulatedSpectrum;
use crate::units::Nanometers;
use crate::wavelength_grid::WavelengthGrid;

/// Luminous efficacy at the peak of the photopic observer, lm/W (683 lm/W at 540 THz, SI).
const MAX_LUMINOUS_EFFICACY: f64 = 683.0;

/// First and last wavelength of the standard observer, nm.
pub const OBSERVER_RANGE_NM: (f64, f64) = (360.0, 830.0);

static OBSERVER: LazyLock<[TabulatedSpectrum; 3]> = LazyLock::new(|| {
    let table = include_str!("../../../data/cie_1931_2deg.csv");
    ["x_bar", "y_bar", "z_bar"].map(|column| {
        TabulatedSpectrum::from_csv(table, column)
            .expect("the embedded table is part of this program and parsed by every test below")
    })
});

/// The standard observer on a wavelength grid.
///
/// ```
/// use niji_radiometry::{Colorimetry, WavelengthGrid};
///
/// let observer = Colorimetry::new(&WavelengthGrid::visible());
/// let radiance = vec![1e-3; 41]; // W m^-2 sr^-1 nm^-1
/// let [_, luminance_cd_m2, _] = observer.xyz(&radiance);
/// assert!((luminance_cd_m2 - 72.98).abs() < 0.01);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Colorimetry {
    weights: Vec<[f64; 3]>,
}

impl Colorimetry {
    /// The observer integrated over every bin of `grid`.
    pub fn new(grid: &WavelengthGrid) -> Self {
        let weights_of = |index| {
            let (lo, hi) = grid.edges(index);
            let (lo_nm, hi_nm) = (lo.0.max(OBSERVER_RANGE_NM.0), hi.0.min(OBSERVER_RANGE_NM.1));
            if lo_nm >= hi_nm {
                return [0.0; 3];
            }
            let factor = MAX_LUMINOUS_EFFICACY * (hi_nm - lo_nm);
            [0, 1, 2].map(|c| factor * OBSERVER[c].bin_mean(Nanometers(lo_nm), Nanometers(hi_nm)))
        };
        Self {
            weights: (0..grid.len()).map(weights_of).collect(),
        }
    }

    /// XYZ of bin means of spectral radiance [W m^-2 sr^-1 nm^-1]; Y in cd m^-2.
    ///
    /// Irradiance [W m^-2 nm^-1] gives an illuminance in lux. Sums run from short to long
    /// wavelengths.
    ///
    /// # Panics
    /// If `radiance` has not one value for each bin of the grid.
    pub fn xyz(&self, radiance: &[f64]) -> [f64; 3] {
        assert_eq!(
            radiance.len(),
            self.weights.len(),
            "one radiance for each wavelength is needed"
        );
        let mut xyz = [0.0; 3];
        for (weight, value) in self.weights.iter().zip(radiance) {
            for (sum, w) in xyz.iter_mut().zip(weight) {
                *sum += w * value;
            }
        }
        xyz
    }

    /// Per bin, what a radiance of 1 W m^-2 sr^-1 nm^-1 adds to X, Y and Z, cd m^-2.
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "these results are exact")]

    use super::*;
    use crate::color_space::xy_chromaticity;
    use crate::solar_irradiance::solar_irradiance;

    fn xy_of(radiance: &[f64], grid: &WavelengthGrid) -> [f64; 2] {
        xy_chromaticity(Colorimetry::new(grid).xyz(radiance)).unwrap()
    }

    #[test]
    fn equal_energy_has_the_chromaticity_of_a_third() {
        // CIE 15: illuminant E is x = 0.33331, y = 0.33329 by the tables as printed.
        let grid = WavelengthGrid::new(365.0, 10.0, 47).unwrap();
        let [x, y] = xy_of(&[1.0; 47], &grid);
        assert!(
            (x - 1.0 / 3.0).abs() <= 5e-5 && (y - 1.0 / 3.0).abs() <= 5e-5,
            "{x} {y}"
        );
    }

    #[test]
    fn the_observer_integrates_to_106_857() {
        // CIE 15: the integral of ybar over wavelength is 106.857 nm.
        let grid = WavelengthGrid::new(595.0, 470.0, 1).unwrap();
        let [_, y, _] = Colorimetry::new(&grid).xyz(&[1.0]);
        assert!((y / MAX_LUMINOUS_EFFICACY - 106.857).abs() <= 1e-4, "{y}");
    }

    #[test]
    fn one_watt_at_555_nm_is_683_lumens() {
        let grid = WavelengthGrid::new(555.0, 0.01, 1).unwrap();
        let [_, y, _] = Colorimetry::new(&grid).xyz(&[100.0]);
        assert!((y - 683.0).abs() <= 0.1, "{y}");
    }

    #[test]
    fn monochromatic_light_lies_on_the_spectral_locus() {
        // CIE 15, chromaticity of the spectral locus.
        for (wavelength_nm, x, y) in [
            (450.0, 0.15664, 0.01771),
            (520.0, 0.07430, 0.83380),
            (600.0, 0.62704, 0.37249),
        ] {
            let grid = WavelengthGrid::new(wavelength_nm, 0.01, 1).unwrap();
            let found = xy_of(&[1.0], &grid);
            assert!(
                (found[0] - x).abs() <= 6e-5 && (found[1] - y).abs() <= 6e-5,
                "{found:?}"
            );
        }
    }

    #[test]
    fn sunlight_above_the_air_is_a_bluish_white() {
        // The same tables integrated by colour-science 0.4.7: x = 0.32338, y = 0.33266.
        for (step_nm, n_wavelengths) in [(10.0, 41), (5.0, 81), (1.0, 401)] {
            let grid = WavelengthGrid::new(380.0, step_nm, n_wavelengths).unwrap();
            let [x, y] = xy_of(&solar_irradiance(&grid), &grid);
            // Worst found 7e-5: observer and sun are not multiplied within a bin.
            assert!(
                (x - 0.32338).abs() <= 1e-4 && (y - 0.33266).abs() <= 1e-4,
                "{x} {y}"
            );
        }
    }

    #[test]
    fn light_the_observer_cannot_see_gives_zero() {
        let grid = WavelengthGrid::new(900.0, 10.0, 5).unwrap();
        assert_eq!(Colorimetry::new(&grid).xyz(&[1.0; 5]), [0.0; 3]);
        assert_eq!(Colorimetry::new(&grid).weights().len(), 5);
    }
}
