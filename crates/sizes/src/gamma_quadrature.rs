//! Quadrature nodes for averages over a gamma law.
//!
//! `<f>` = sum_j w_j f(r_j),   w_j the share of the cross-section at r_j, sum w_j = 1
//!
//! What is averaged oscillates with the radius (supernumerary bows), many times within the width of
//! the law, and its average is small because the oscillations cancel. A Gauss rule spends its nodes
//! on the far tails and fails as soon as half a period is shorter than its node spacing; nodes of
//! equal probability converge as 1/n only. Best is the trapezoidal rule in a variable in which the
//! density is close to a normal one: it converges faster than any power of n for every integrand
//! that it resolves. That variable is the cube root of the radius:
//! x = r/a = (1 - b/9 + (sqrt(b)/3) t)³,   t nearly standard normal
//! `a` effective radius, `b` effective variance; the density in t is p(x) dx/dt, exactly.
//! [WH31] Wilson and Hilferty, Proc. Nat. Acad. Sci. 17, 684-688 (1931);
//! [TW14] Trefethen and Weideman, SIAM Review 56, 385-458 (2014), on the rule.
//!
//! The range of t is -L..L. What lies outside weighs exp(-L²/2); what the spacing h = 2L/n misses of
//! an oscillation with `omega` radians per standard deviation weighs exp(-(2 pi/h - omega)²/2).
//! L = -3 + sqrt(9 + pi n) makes both equal for one period per standard deviation, omega = 6; beyond
//! L = 5.5 nothing is gained.
//!
//! Error of the mean of exp(i omega r), the largest over b = 1e-4..0.49 and over omega up to
//! 2 / 6 / 12 / 24 per standard deviation, and that of generalized Gauss-Laguerre for b = 0.02..0.49
//! (an error near 1 is no answer at all):
//! n = 16:  3e-6 / 1e-1 / 1e+0 / 1e+0      Gauss 1e-6 / 3e-1 / 9e-1 / 9e-1
//! n = 32:  6e-8 / 2e-4 / 1e-1 / 1e+0      Gauss 8e-14 / 4e-2 / 9e-1 / 9e-1
//! n = 64:  7e-8 / 7e-8 / 9e-5 / 9e-2      Gauss 4e-15 / 1e-4 / 2e-1 / 8e-1
//! n = 128: 7e-8 / 7e-8 / 7e-8 / 6e-5      Gauss 4e-15 / 1e-9 / 2e-2 / 7e-1

use niji_radiometry::Micrometers;

use crate::Error;
use crate::GammaSizes;

/// Periods of the integrand per standard deviation for which the range is balanced, in radians.
const BALANCED_OMEGA: f64 = 6.0;

/// Largest half range in standard deviations: 4e-8 of the cross-section lies outside.
const LARGEST_HALF_RANGE: f64 = 5.5;

/// Radii (um) and weights of a mean over the cross-section of a gamma law.
///
/// A law of a single size, or a single node, gives the effective radius. For the mean over drop
/// *numbers* weight with 1/r² as well.
///
/// ```
/// use niji_radiometry::Micrometers;
/// use niji_sizes::gamma_area_quadrature;
///
/// let nodes = gamma_area_quadrature(Micrometers(100.0), 0.1, 32)?;
/// let mean: f64 = nodes.iter().map(|(radius_um, weight)| radius_um * weight).sum();
/// assert!((mean - 100.0).abs() < 1e-4);
/// # Ok::<(), niji_sizes::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] if the radius is not above 0 or the variance is not in 0..1/2.
pub fn gamma_area_quadrature(
    effective_radius: Micrometers,
    effective_variance: f64,
    n_nodes: usize,
) -> Result<Vec<(f64, f64)>, Error> {
    let law = GammaSizes::new(effective_radius, effective_variance)?;
    // Against the exact 0 that stands for a single size.
    if effective_variance == 0.0 || n_nodes <= 1 {
        return Ok(vec![(effective_radius.0, 1.0)]);
    }
    let (center, scale) = (-effective_variance / 9.0, effective_variance.sqrt() / 3.0);
    let (low, high) = range(center, scale, n_nodes);
    let step = (high - low) / n_nodes as f64;
    let mut nodes: Vec<(f64, f64)> = (0..n_nodes)
        .map(|index| {
            // c = x^(1/3) - 1, from which x - 1 follows without cancellation.
            let c = center + scale * (low + (index as f64 + 0.5) * step);
            let relative_radius_minus_1 = c * (3.0 + c * (3.0 + c));
            let slope = (1.0 + c).powi(2);
            let weight = law.ln_area_density(relative_radius_minus_1).exp() * slope;
            (effective_radius.0 * (1.0 + relative_radius_minus_1), weight)
        })
        .collect();
    let total: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    for (_, weight) in &mut nodes {
        *weight /= total;
    }
    Ok(nodes)
}

/// Range of t; not beyond the radius 0, at t = -(1 + center)/scale.
fn range(center: f64, scale: f64, n_nodes: usize) -> (f64, f64) {
    let half_omega = 0.5 * BALANCED_OMEGA;
    let balanced = (half_omega * half_omega + std::f64::consts::PI * n_nodes as f64).sqrt();
    let half = (balanced - half_omega).min(LARGEST_HALF_RANGE);
    ((-half).max(-(1.0 + center) / scale), half)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes, largest omega, tolerance. Measured worst 6.1e-8, 1.8e-4 (b = 0.49), 6.7e-8.
    const CASES: [(usize, f64, f64); 3] = [(32, 2.0, 1e-7), (32, 6.0, 4e-4), (64, 6.0, 1e-7)];

    /// |<exp(i omega r)>| of the rule against (1 - i omega a b)^(-1/b), omega per standard deviation.
    fn error_of_oscillation(b: f64, n_nodes: usize, omega: f64) -> f64 {
        let nodes = gamma_area_quadrature(Micrometers(1.0), b, n_nodes).unwrap();
        let phase = omega / b.sqrt();
        let (re, im) = nodes.iter().fold((0.0, 0.0), |(re, im), (r, w)| {
            // The phase is taken from the mean, so that narrow laws keep their digits.
            let angle = phase * (r - 1.0);
            (re + w * angle.cos(), im + w * angle.sin())
        });
        let modulus = (-(phase * b).powi(2).ln_1p() / (2.0 * b)).exp();
        let angle = (phase * b).atan() / b - phase;
        (re - modulus * angle.cos()).hypot(im - modulus * angle.sin())
    }

    #[test]
    fn means_of_oscillations_match_the_characteristic_function() {
        for (n_nodes, largest_omega, tolerance) in CASES {
            for b in [1e-4, 1e-2, 0.1, 1.0 / 3.0, 0.49] {
                for step in 0..=60 {
                    let omega = largest_omega * f64::from(step) / 60.0;
                    let error = error_of_oscillation(b, n_nodes, omega);
                    assert!(
                        error < tolerance,
                        "b {b}, n {n_nodes}, omega {omega}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_law_down_to_1e_minus_12() {
        // Measured worst 9.7e-8 of a standard deviation and 1.2e-6 of the variance.
        for b in [1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0 / 3.0, 0.49] {
            let nodes = gamma_area_quadrature(Micrometers(1.0), b, 64).unwrap();
            let mean: f64 = nodes.iter().map(|(r, w)| w * (r - 1.0)).sum();
            let variance: f64 = nodes.iter().map(|(r, w)| w * (r - 1.0).powi(2)).sum();
            assert!((mean / b.sqrt()).abs() < 2e-7, "b {b}: mean {mean:e}");
            assert!(
                (variance / b - 1.0).abs() < 2e-6,
                "b {b}: variance {variance:e}"
            );
        }
    }

    #[test]
    fn number_moments_of_the_law_come_out() {
        // <r^-2> over the area is 1/<r²> over the drops: 1/(a² (1 - b)(1 - 2b)).
        for b in [0.01, 0.1, 1.0 / 3.0] {
            let nodes = gamma_area_quadrature(Micrometers(2.0), b, 128).unwrap();
            let mean: f64 = nodes.iter().map(|(r, w)| w / (r * r)).sum();
            let exact = 0.25 / ((1.0 - b) * (1.0 - 2.0 * b));
            // Measured worst 6.4e-7, at b = 0.1.
            assert!((mean / exact - 1.0).abs() < 1e-6, "b {b}: {mean} {exact}");
        }
    }

    #[test]
    fn weights_are_positive_and_sum_to_one() {
        for b in [1e-12, 0.02, 0.499_999] {
            for n_nodes in [2, 3, 8, 500] {
                let nodes = gamma_area_quadrature(Micrometers(10.0), b, n_nodes).unwrap();
                let sum: f64 = nodes.iter().map(|(_, weight)| weight).sum();
                assert_eq!(nodes.len(), n_nodes);
                assert!((sum - 1.0).abs() < 1e-14);
                assert!(
                    nodes
                        .iter()
                        .all(|(radius, weight)| *radius > 0.0 && *weight >= 0.0)
                );
                assert!(nodes.is_sorted_by(|a, b| a.0 < b.0));
            }
        }
    }

    #[test]
    fn a_single_size_has_a_single_node() {
        assert_eq!(
            gamma_area_quadrature(Micrometers(7.0), 0.0, 64),
            Ok(vec![(7.0, 1.0)])
        );
        assert_eq!(
            gamma_area_quadrature(Micrometers(7.0), 0.1, 0),
            Ok(vec![(7.0, 1.0)])
        );
    }

    #[test]
    fn laws_without_finite_number_are_refused() {
        for (radius, variance) in [
            (1.0, 0.5),
            (1.0, -0.1),
            (1.0, f64::NAN),
            (0.0, 0.1),
            (f64::NAN, 0.1),
            (-3.0, 0.1),
        ] {
            let result = gamma_area_quadrature(Micrometers(radius), variance, 8);
            assert!(
                matches!(result, Err(Error::Parameter { .. })),
                "{radius} {variance}"
            );
        }
    }
}
