//! Gauss-Legendre quadrature.
//!
//! ∫ f over −1..1 = Σ w_i f(x_i),   P_n(x_i) = 0,   w_i = 2/((1 − x_i²) P_n'(x_i)²)
//! exact for polynomials of degree 2n − 1. Newton's rule from x ≈ cos(π (i + 3/4)/(n + 1/2)).
//! [AS64] Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 25.4.29, 22.7.10 and 22.16.6.

use std::f64::consts::PI;

/// Steps of Newton's rule, which doubles the digits.
const MOST_STEPS: usize = 20;

/// The `n` nodes and weights on −1..1, ascending.
///
/// ```
/// let square: f64 = niji_radiometry::gauss_legendre(2).iter().map(|(x, w)| w * x * x).sum();
/// assert!((square - 2.0 / 3.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let node = |index: usize| {
        let mut x = -(PI * (index as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..MOST_STEPS {
            let (value, slope) = legendre(n, x);
            let step = value / slope;
            x -= step;
            if step.abs() < f64::EPSILON {
                break;
            }
        }
        let (_, slope) = legendre(n, x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// P_n and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (
            value,
            ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0),
        );
    }
    (value, n as f64 * (before - x * value) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_nodes_are_met() {
        // AS64, table 25.4.
        for (n, index, x, weight) in [
            (1, 0, 0.0, 2.0),
            (3, 2, 0.774596669241483, 0.555555555555556),
            (10, 9, 0.973906528517172, 0.066671344308688),
            (96, 95, 0.999689503883230, 0.000796792065552),
        ] {
            let found = gauss_legendre(n)[index];
            assert!(
                (found.0 - x).abs() < 1e-15 && (found.1 - weight).abs() < 1e-15,
                "{n}: {found:?}"
            );
        }
    }

    #[test]
    fn polynomials_are_integrated_exactly_and_nodes_ascend() {
        for n in [1, 2, 7, 40, 200] {
            let rule = gauss_legendre(n);
            assert!(rule.is_sorted_by(|a, b| a.0 < b.0));
            let degree = 2 * n as i32 - 2;
            let integral: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree)).sum();
            assert!(
                (integral * f64::from(degree + 1) / 2.0 - 1.0).abs() < 1e-12,
                "{n}: {integral}"
            );
        }
    }
}
