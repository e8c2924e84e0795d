//! f(z) in advance: nodes that are even in phase, and a Hermite look-up.
//!
//! s(z) = sign(z) (2/3) [(1 + |z|)^(3/2) − 1]
//! is the phase of f up to a factor, so nodes that are equidistant in s resolve every fringe alike;
//! equidistant nodes in z would waste points at the bow and starve far inside it. Between two nodes f
//! is the quintic through f, f' and f'' = −(π²/12) z f at both. The table is for files and for programs
//! that have no Ai: [`airy_integral_with_derivative`] itself takes two thirds of the time of a look-up
//! and is exact.

use crate::airy_integral::SECOND_DERIVATIVE;
use crate::airy_integral::airy_integral_with_derivative;

/// Lowest z of the usual table: f is below 1e-31 there, still normal in f32.
const LOWEST_Z: f64 = -24.0;
/// Highest z of the usual table: 10 degrees inside the primary bow of drops of 2 mm radius.
const HIGHEST_Z: f64 = 130.0;
/// Nodes of the usual table; the step in phase is 0.25.
const N_NODES: usize = 4096;

/// A table of the rainbow integral.
#[derive(Clone, Debug, PartialEq)]
pub struct AiryTable {
    /// Ascending arguments, even in s(z).
    pub z: Vec<f64>,
    /// f at the arguments.
    pub f: Vec<f64>,
    /// f' at the arguments.
    pub dfdz: Vec<f64>,
    /// s at the first node and nodes for each unit of s.
    place: (f64, f64),
}

/// What is wrong with a table from elsewhere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// The nodes are not those that the look-up relies on.
    #[error("found z = {found} at node {index}, expected {expected}: nodes even in s(z)")]
    Nodes {
        /// Index of the node.
        index: usize,
        /// Argument found.
        found: f64,
        /// Argument expected.
        expected: f64,
    },
    /// Fewer than two nodes, or columns of different lengths.
    #[error(
        "found {z} arguments, {f} values and {dfdz} derivatives, expected equally many, at least 2"
    )]
    Lengths {
        /// Number of arguments.
        z: usize,
        /// Number of values.
        f: usize,
        /// Number of derivatives.
        dfdz: usize,
    },
}

/// s(z), the coordinate in which the fringes of f are equally wide far inside the bow.
pub fn fringe_coordinate(z: f64) -> f64 {
    let beyond = 1.0 + z.abs();
    z.signum() * (beyond * beyond.sqrt() - 1.0) / 1.5
}

/// z(s), the inverse of [`fringe_coordinate`].
pub fn from_fringe_coordinate(s: f64) -> f64 {
    let root = (1.0 + 1.5 * s.abs()).cbrt();
    s.signum() * (root * root - 1.0)
}

impl AiryTable {
    /// Tabulates f over the range that drops up to 2 mm radius need.
    #[must_use]
    pub fn compute() -> Self {
        let (low, high) = (fringe_coordinate(LOWEST_Z), fringe_coordinate(HIGHEST_Z));
        let step = (high - low) / (N_NODES - 1) as f64;
        let z: Vec<f64> = (0..N_NODES)
            .map(|index| from_fringe_coordinate(low + step * index as f64))
            .collect();
        let (f, dfdz) = z.iter().map(|&z| airy_integral_with_derivative(z)).unzip();
        let place = (low, 1.0 / step);
        Self { z, f, dfdz, place }
    }

    /// Takes a table from elsewhere, a file say.
    ///
    /// # Errors
    /// If its nodes are not even in s(z), which the look-up relies on.
    pub fn from_nodes(z: Vec<f64>, f: Vec<f64>, dfdz: Vec<f64>) -> Result<Self, TableError> {
        let n = z.len();
        if n < 2 || f.len() != n || dfdz.len() != n {
            return Err(TableError::Lengths {
                z: n,
                f: f.len(),
                dfdz: dfdz.len(),
            });
        }
        let low = fringe_coordinate(z[0]);
        let step = (fringe_coordinate(z[n - 1]) - low) / (n - 1) as f64;
        for (index, &found) in z.iter().enumerate() {
            let expected = from_fringe_coordinate(low + step * index as f64);
            let tolerance = 1e-9 * (1.0 + expected.abs());
            if !((found - expected).abs() < tolerance && step > 0.0) {
                return Err(TableError::Nodes {
                    index,
                    found,
                    expected,
                });
            }
        }
        let place = (low, 1.0 / step);
        Ok(Self { z, f, dfdz, place })
    }

    /// f(z) by look-up; outside of the table by [`crate::airy_integral`].
    #[must_use]
    pub fn value(&self, z: f64) -> f64 {
        self.value_with_derivative(z).0
    }

    /// f(z) and f'(z) by look-up; outside of the table by [`airy_integral_with_derivative`].
    #[must_use]
    pub fn value_with_derivative(&self, z: f64) -> (f64, f64) {
        let last = self.z.len() - 1;
        if !(z >= self.z[0] && z <= self.z[last]) {
            return airy_integral_with_derivative(z);
        }
        let (low, per_unit) = self.place;
        let position = (fringe_coordinate(z) - low) * per_unit;
        let index = (position as usize).min(last - 1);
        let end = |index: usize| {
            let (z, f) = (self.z[index], self.f[index]);
            HermiteNode {
                at: z,
                value: f,
                slope: self.dfdz[index],
                curvature: -SECOND_DERIVATIVE * z * f,
            }
        };
        quintic_hermite(end(index), end(index + 1), z)
    }
}

/// What a function is at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HermiteNode {
    /// The place, z.
    pub at: f64,
    /// The function, f(z).
    pub value: f64,
    /// Its first derivative, f'(z).
    pub slope: f64,
    /// Its second derivative, f''(z).
    pub curvature: f64,
}

/// Value and slope at `z` of the quintic with given value, slope and curvature at both ends.
pub fn quintic_hermite(left: HermiteNode, right: HermiteNode, z: f64) -> (f64, f64) {
    let h = right.at - left.at;
    let t = (z - left.at) / h;
    let coefficients = quintic_coefficients(left, right);
    let [_, d0, k0, c3, c4, c5] = coefficients;
    let slope = d0 + t * (2.0 * k0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)));
    (quintic(coefficients, t), slope / h)
}

/// The same quintic by powers of t, which is 0 at the left end and 1 at the right one.
pub fn quintic_coefficients(left: HermiteNode, right: HermiteNode) -> [f64; 6] {
    let h = right.at - left.at;
    // Left end and its deviation from the Taylor parabola there: c3 t^3 + c4 t^4 + c5 t^5.
    let (f0, f1) = (left.value, right.value);
    let (d0, d1) = (h * left.slope, h * right.slope);
    let (k0, k1) = (0.5 * h * h * left.curvature, 0.5 * h * h * right.curvature);
    let rise = f1 - f0 - d0 - k0;
    let tilt = d1 - d0 - 2.0 * k0;
    let bend = k1 - k0;
    let c3 = 10.0 * rise - 4.0 * tilt + bend;
    let c4 = -15.0 * rise + 7.0 * tilt - 2.0 * bend;
    let c5 = 6.0 * rise - 3.0 * tilt + bend;
    [f0, d0, k0, c3, c4, c5]
}

/// Its value.
pub fn quintic([f0, d0, k0, c3, c4, c5]: [f64; 6], t: f64) -> f64 {
    f0 + t * (d0 + t * (k0 + t * (c3 + t * (c4 + t * c5))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airy_integral::airy_integral;

    /// Error of the look-up over max(|f|, envelope); measured worst 1.6e-8.
    const LOOK_UP_TOLERANCE: f64 = 2e-8;

    #[test]
    fn the_look_up_meets_the_integral_between_nodes_on_both_sides() {
        let table = AiryTable::compute();
        let mut worst = 0.0_f64;
        for pair in table.z.windows(2) {
            for part in [0.21, 0.5, 0.83] {
                let z = pair[0] + part * (pair[1] - pair[0]);
                let exact = airy_integral(z);
                let scale = if z > 0.0 {
                    exact.abs().max(0.3)
                } else {
                    exact.abs()
                };
                worst = worst.max((table.value(z) - exact).abs() / scale);
            }
        }
        assert!(worst < LOOK_UP_TOLERANCE, "worst {worst:e}");
    }

    #[test]
    fn outside_of_the_table_the_integral_answers() {
        let table = AiryTable::compute();
        for z in [-60.0, -24.5, 130.5, 400.0] {
            assert_eq!(table.value(z), airy_integral(z));
        }
        assert!(table.value(f64::NAN).is_nan());
    }

    #[test]
    fn a_round_trip_through_f32_keeps_six_digits_of_the_darkest_value() {
        let table = AiryTable::compute();
        let narrow = |values: &[f64]| {
            values
                .iter()
                .map(|&value| f64::from(value as f32))
                .collect()
        };
        let coarse =
            AiryTable::from_nodes(table.z.clone(), narrow(&table.f), narrow(&table.dfdz)).unwrap();
        for z in [-23.9, -12.3, -1.0, 0.4, 3.3, 99.9] {
            let exact = airy_integral(z);
            assert!(
                (coarse.value(z) - exact).abs() < 1e-6 * exact.abs().max(1e-3 * f64::from(z > 0.0))
            );
        }
    }

    #[test]
    fn other_nodes_are_refused() {
        let z: Vec<f64> = (0..5).map(f64::from).collect();
        let f = vec![0.0; 5];
        let error = AiryTable::from_nodes(z.clone(), f.clone(), f.clone());
        assert!(matches!(error, Err(TableError::Nodes { .. })));
        let error = AiryTable::from_nodes(z, f.clone(), vec![0.0; 4]);
        assert!(matches!(error, Err(TableError::Lengths { .. })));
        assert!(AiryTable::from_nodes(vec![1.0], vec![1.0], vec![1.0]).is_err());
    }
}
