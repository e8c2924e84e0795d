//! What all wavelengths let pass on a way through ice, tabulated by its length.
//!
//! T_j(x) = exp(-alpha_j x),  linear in x between nodes x_i = x_1 q^(i-1), and from T = 1 at x = 0.
//! The error is at most max(y² exp(-y)) (q-1)²/8 = 0.068 (q-1)², 3e-5 for q = 1.02: far below the
//! noise of a picture, at a tenth of the time of 41 exponentials a path.

/// Ratio of neighboring nodes.
const NODE_RATIO: f64 = 1.02;
/// Optical depth, at the most absorbed wavelength, of the first node.
const FIRST_DEPTH: f64 = 1e-4;
/// Optical depth, at the least absorbed wavelength, behind which all is dark.
const LAST_DEPTH: f64 = 60.0;
/// Wavelengths absorbed less than this share of the most absorbed one decide nothing about lengths.
const LEAST_SHARE: f64 = 1e-6;

/// Transmittances by length of way.
#[derive(Debug, Clone)]
pub(crate) struct TransmittanceTable {
    first_m: f64,
    /// Nodes while a length grows by the factor e.
    steps_per_log: f64,
    n_wavelengths: usize,
    /// `[node, wavelength]`, the first at length 0. f32: see the error of the interpolation.
    values: Vec<f32>,
}

impl TransmittanceTable {
    /// The table of absorption coefficients in 1/m.
    pub(crate) fn new(absorption_per_m: &[f64]) -> Self {
        let most = absorption_per_m.iter().copied().fold(0.0, f64::max);
        let least = absorption_per_m.iter().copied().fold(most, |least, alpha| {
            least.min(alpha.max(LEAST_SHARE * most))
        });
        let n_wavelengths = absorption_per_m.len();
        let steps_per_log = NODE_RATIO.ln().recip();
        let mut values = vec![1.0; n_wavelengths];
        if most <= 0.0 {
            return Self {
                first_m: f64::INFINITY,
                steps_per_log,
                n_wavelengths,
                values,
            };
        }
        let first_m = FIRST_DEPTH / most;
        let n_nodes = ((LAST_DEPTH / least / first_m).ln() / NODE_RATIO.ln()).ceil() as i32;
        for node in 0..=n_nodes {
            let length_m = first_m * NODE_RATIO.powi(node);
            values.extend(
                absorption_per_m
                    .iter()
                    .map(|alpha| (-alpha * length_m).exp() as f32),
            );
        }
        Self {
            first_m,
            steps_per_log,
            n_wavelengths,
            values,
        }
    }

    /// Rows below and above a length, and the weight of the one above.
    pub(crate) fn rows(&self, length_m: f64) -> (&[f32], &[f32], f32) {
        let row = |index: usize| &self.values[index * self.n_wavelengths..][..self.n_wavelengths];
        let n_rows = self.values.len() / self.n_wavelengths;
        if length_m < self.first_m {
            let share = if self.first_m.is_finite() {
                length_m / self.first_m
            } else {
                0.0
            };
            return (row(0), row(1.min(n_rows - 1)), share as f32);
        }
        let steps = (length_m / self.first_m).ln() * self.steps_per_log;
        let below = steps as usize + 1;
        if below + 1 >= n_rows {
            return (row(n_rows - 1), row(n_rows - 1), 0.0);
        }
        // The share of the length, not of its logarithm.
        let from_node = steps.fract() / self.steps_per_log;
        let share = from_node.exp_m1() / (NODE_RATIO - 1.0);
        (row(below), row(below + 1), share as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookups_err_by_less_than_the_bound() {
        let absorption = [0.0, 7e-4, 0.05, 2.3];
        let table = TransmittanceTable::new(&absorption);
        let mut worst = 0.0_f64;
        for step in 0..100_000 {
            let length_m = 1e-6 * 1.0003_f64.powi(step);
            let (below, above, share) = table.rows(length_m);
            for (index, alpha) in absorption.iter().enumerate() {
                let found = below[index] * (1.0 - share) + above[index] * share;
                worst = worst.max((f64::from(found) - (-alpha * length_m).exp()).abs());
            }
        }
        // Worst found 2.7e-5.
        assert!(worst < 3e-5, "{worst}");
    }

    #[test]
    fn ice_that_absorbs_nothing_and_ways_of_no_length_let_all_pass() {
        let clear = TransmittanceTable::new(&[0.0, 0.0]);
        for length_m in [0.0, 1.0, 1e9] {
            let (below, above, _) = clear.rows(length_m);
            assert_eq!((below, above), (&[1.0, 1.0][..], &[1.0, 1.0][..]));
        }
        let table = TransmittanceTable::new(&[1.0]);
        let (below, _, share) = table.rows(0.0);
        assert_eq!((below, share), (&[1.0][..], 0.0));
    }
}
