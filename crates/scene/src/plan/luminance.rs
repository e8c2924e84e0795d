//! How bright a unit of optical depth can look: luminance by scattering angle and order.
//!
//! P_p(theta) = pi 2^ev sum_l y_l E_l t_p,l(theta) / sum_l y_l E_l
//! is the luminance that drops of optical depth 1 (Q = 1, thin) add, over that of display white at exposure `ev`:
//! of a white plane facing the sun above the air where `ev` is 0. `t_p` = (dsigma/dOmega)/(pi <r^2>) (1/sr) of order `p`
//! in natural light, averaged over sizes and the sun's disc; `E_l` irradiance, `y_l` the observer.
//!
//! The stage that makes tables resolves fringes and lines that no bound needs: here wavelengths and
//! angles are coarse ([`niji_scatter::DropLight`]), and a margin on every maximum covers the difference.

use ndarray::ArrayView2;
use ndarray::ArrayView3;
use niji_scatter::Band;
use niji_scatter::DiscAverage;

use super::curve::Curve;

/// A wavelength with its weight: what one unit of t at it adds to the relative luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Index of the bin in the spectrum of bounds.
    pub(super) index: usize,
    /// The bin.
    pub(super) band: Band,
    /// Share of the sun's luminance times pi 2^ev.
    pub(super) weight: f64,
}

/// Relative luminance by size and angle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Luminance {
    pub(super) rows: Vec<Vec<f64>>,
}

impl Luminance {
    /// That of light in lines of some weights.
    pub(super) fn new(light: &ArrayView3<'_, f64>, weights: &[f64]) -> Self {
        let of_size = |bands: ArrayView2<'_, f64>| {
            let mut sum = vec![0.0; bands.ncols()];
            for (row, weight) in bands.rows().into_iter().zip(weights) {
                for (sum, value) in sum.iter_mut().zip(row) {
                    *sum += weight * value;
                }
            }
            sum
        };
        Self {
            rows: light.outer_iter().map(of_size).collect(),
        }
    }

    /// From a sun with a disc.
    pub(super) fn seen_from_disc(&self, disc: &DiscAverage) -> Self {
        Self {
            rows: self.rows.iter().map(|row| disc.of(row)).collect(),
        }
    }

    /// Size by size and angle by angle.
    pub(super) fn zip(&self, other: &Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        let rows = self.rows.iter().zip(&other.rows);
        let row = |(one, other): (&Vec<f64>, &Vec<f64>)| {
            let pairs = one.iter().zip(other);
            pairs.map(|(a, b)| combine(*a, *b)).collect()
        };
        Self {
            rows: rows.map(row).collect(),
        }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    /// The largest over the sizes, from the first angle on.
    pub(super) fn largest(&self, first_rad: f64) -> Curve {
        let mut values = self.rows.first().cloned().unwrap_or_default();
        for row in self.rows.iter().skip(1) {
            for (largest, value) in values.iter_mut().zip(row) {
                *largest = largest.max(*value);
            }
        }
        Curve { first_rad, values }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn lines_add_up_and_the_brightest_size_counts() {
        let light = array![[[1.0, 2.0], [3.0, 0.0]], [[0.0, 4.0], [1.0, 1.0]]];
        let luminance = Luminance::new(&light.view(), &[1.0, 0.5]);
        assert_eq!(luminance.rows, [[2.5, 2.0], [0.5, 4.5]]);
        assert_eq!(luminance.largest(1.0).values, [2.5, 4.5]);
        assert_eq!(luminance.plus(&luminance).rows[1], [1.0, 9.0]);
        let none = Luminance { rows: Vec::new() };
        assert!(none.largest(1.0).values.is_empty());
    }
}
