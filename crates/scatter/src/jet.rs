//! Taylor series to second order in three small quantities.
//!
//! f(h(x)) = f + f' h_j x_j + (f' h_jk + f'' h_j h_k) x_j x_k/2
//! Sums and products of jets, and functions of them, carry value, gradient and second derivatives
//! exactly: what differences of traced rays would give with half the digits lost.

use std::ops::Add;
use std::ops::Mul;
use std::ops::Sub;

/// The second derivatives that a jet keeps; the others are the same ones.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// A quantity with its derivatives by three variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet {
    pub(crate) value: f64,
    pub(crate) first: [f64; 3],
    /// By [`PAIRS`].
    second: [f64; 6],
}

impl Jet {
    pub(crate) fn constant(value: f64) -> Self {
        Self {
            value,
            first: [0.0; 3],
            second: [0.0; 6],
        }
    }

    /// The variable `index` at `value`.
    pub(crate) fn variable(index: usize, value: f64) -> Self {
        let mut jet = Self::constant(value);
        jet.first[index] = 1.0;
        jet
    }

    /// The second derivative by the variables `j` and `k`.
    pub(crate) fn second(&self, j: usize, k: usize) -> f64 {
        let pair = (j.min(k), j.max(k));
        // 0, 1, 2, 3, 4, 5 in the order of the pairs.
        self.second[pair.0 * (5 - pair.0) / 2 + pair.1]
    }

    /// f of the jet; `derivatives` are f, f' and f'' at its value.
    fn apply(self, derivatives: [f64; 3]) -> Self {
        let [value, slope, bend] = derivatives;
        let h = self.first;
        Self {
            value,
            first: h.map(|h| slope * h),
            second: PAIRS.map(|(j, k)| slope * self.second(j, k) + bend * h[j] * h[k]),
        }
    }

    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.apply([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    pub(crate) fn recip(self) -> Self {
        let r = self.value.recip();
        self.apply([r, -r * r, 2.0 * r * r * r])
    }

    pub(crate) fn acos(self) -> Self {
        let cosine = self.value;
        let sine = (1.0 - cosine * cosine).sqrt();
        self.apply([cosine.acos(), -1.0 / sine, -cosine / sine.powi(3)])
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        self.apply([factor * self.value, factor, 0.0])
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: [0, 1, 2].map(|j| self.first[j] + other.first[j]),
            second: PAIRS.map(|(j, k)| self.second(j, k) + other.second(j, k)),
        }
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other.scaled(-1.0)
    }
}

impl Mul for Jet {
    type Output = Self;

    #[allow(
        clippy::suspicious_arithmetic_impl,
        reason = "derivatives of products are sums"
    )]
    fn mul(self, other: Self) -> Self {
        let (f, g) = (self, other);
        let second = |(j, k): (usize, usize)| {
            let of_one = f.value * g.second(j, k) + g.value * f.second(j, k);
            of_one + f.first[j] * g.first[k] + f.first[k] * g.first[j]
        };
        Self {
            value: f.value * g.value,
            first: [0, 1, 2].map(|j| f.value * g.first[j] + g.value * f.first[j]),
            second: PAIRS.map(second),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(found: Jet, expected: Jet) {
        assert!((found.value - expected.value).abs() < 1e-14);
        for j in 0..3 {
            assert!((found.first[j] - expected.first[j]).abs() < 1e-13);
            for k in 0..3 {
                let off = found.second(j, k) - expected.second(j, k);
                assert!(off.abs() < 1e-12, "{j} {k}: {off}");
            }
        }
    }

    /// 0.3 + x + y z, at x = 0.1, y = 0.2, z = -0.5.
    fn sample() -> Jet {
        let [x, y, z] = [(0, 0.1), (1, 0.2), (2, -0.5)].map(|(j, at)| Jet::variable(j, at));
        Jet::constant(0.3) + x + y * z
    }

    #[test]
    fn products_have_the_derivatives_of_polynomials() {
        let square = sample() * sample();
        // Of g² are 2 g g_j and 2 g_j g_k + 2 g g_jk with g = 0.3, g_j = (1, -0.5, 0.2), g_yz = 1.
        let expected = Jet {
            value: 0.09,
            first: [0.6, -0.3, 0.12],
            second: [2.0, -1.0, 0.4, 0.5, 0.4, 0.08],
        };
        assert_close(square, expected);
    }

    #[test]
    fn functions_undo_each_other() {
        let jet = sample();
        assert_close(jet.sqrt() * jet.sqrt(), jet);
        assert_close(jet.recip() * jet, Jet::constant(1.0));
        assert_close(jet - jet, Jet::constant(0.0));
    }

    #[test]
    fn the_arc_of_a_cosine_has_the_derivatives_of_differences() {
        let arc = Jet::variable(0, 0.3).acos();
        let h = 1e-4;
        let [below, at, above] = [-h, 0.0, h].map(|step: f64| (0.3 + step).acos());
        assert_eq!(arc.value, at);
        // Measured 2e-9 and 2e-8, of the differences.
        assert!((arc.first[0] - (above - below) / (2.0 * h)).abs() < 1e-8);
        assert!((arc.second(0, 0) - (above - 2.0 * at + below) / (h * h)).abs() < 1e-6);
    }
}
