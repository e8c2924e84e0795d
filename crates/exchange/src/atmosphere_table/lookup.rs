//! Densities, columns and segments from the table of one constituent.
//!
//! L(h, mu) = rho(h) * reach(h, mu)                     mu >= 0, interpolated
//! L(h, mu) = 2 L(p, 0) - L(h, -mu)                     mu < 0, p = height of the perigee
//! A segment of length s is integrated by Gauss-Legendre quadrature while the density on it varies
//! by less than a factor of e^3, and is the difference of two columns beyond: there the columns
//! themselves differ by so much that their difference keeps its digits.

use niji_geometry::Planet;

use super::AirConstituent;
use super::DensityLaw;
use super::closed_form;
use super::interpolation::Stencil;
use super::ray_start::RayStart;

/// Largest |ln| of a ratio of densities on a segment that is integrated directly.
const LARGEST_LOG_RATIO: f64 = 3.0;

/// Largest |ln| of a ratio of densities on a segment for which four nodes are enough: 1e-11.
const SMALL_LOG_RATIO: f64 = 0.3;

/// Gauss-Legendre nodes and weights of 4 and 8 points on -1..1: the positive half, mirrored in use
/// (Abramowitz and Stegun, table 25.4). Eight integrate `exp` over three e-folds to 1e-14, and over
/// a level ray, where the exponent is a square, to 1e-8.
const HALF_RULE_OF_4: [(f64, f64); 2] = [
    (0.339981043584856265, 0.652145154862546143),
    (0.861136311594052575, 0.347854845137453857),
];
const HALF_RULE_OF_8: [(f64, f64); 4] = [
    (0.183434642495649805, 0.362683783378361983),
    (0.525532409916328986, 0.313706645877887287),
    (0.796666477413626740, 0.222381034453374471),
    (0.960289856497536232, 0.101228536290376259),
];

/// Relative density at a height.
pub(super) fn density(air: &AirConstituent, height_m: f64) -> f64 {
    let last = air.height_m.len() - 1;
    if height_m > air.height_m[last] || height_m.is_nan() {
        return 0.0;
    }
    if height_m <= air.height_m[0] {
        return air.density[0];
    }
    let above = air
        .height_m
        .partition_point(|&node| node < height_m)
        .clamp(1, last);
    let below = above - 1;
    let t = (height_m - air.height_m[below]) / (air.height_m[above] - air.height_m[below]);
    let (rho_below, rho_above) = (air.density[below], air.density[above]);
    match air.law {
        DensityLaw::Exponential => rho_below * ((rho_above / rho_below).ln() * t).exp(),
        DensityLaw::Linear => rho_below * (1.0 - t) + rho_above * t,
    }
}

/// Equivalent length to the top of the air, infinite for a ray that ends on the ground.
pub(super) fn column(air: &AirConstituent, radius_m: f64, height_m: f64, mu: f64) -> f64 {
    let ray = RayStart {
        planet: Planet { radius_m },
        height_m,
        mu,
    };
    if mu < 0.0 && ray.perigee().height_m < 0.0 {
        return f64::INFINITY;
    }
    column_through_the_ground(air, ray)
}

/// Equivalent length to the top of the air, as if the ground were air like the lowest node.
fn column_through_the_ground(air: &AirConstituent, ray: RayStart) -> f64 {
    if ray.mu >= 0.0 {
        return rising_column(air, ray);
    }
    2.0 * rising_column(air, ray.perigee()) - rising_column(air, ray.reversed())
}

/// Equivalent length to the top of the air along a ray that leads upwards or level.
fn rising_column(air: &AirConstituent, ray: RayStart) -> f64 {
    let (bottom_m, top_m) = (air.height_m[0], air.height_m[air.height_m.len() - 1]);
    if ray.height_m >= top_m {
        return 0.0;
    }
    match air.law {
        DensityLaw::Linear => closed_form::rising_length(air, ray, top_m),
        DensityLaw::Exponential if ray.height_m < bottom_m => {
            let below_m = ray.rising_distance_m(ray.height_m, bottom_m);
            air.density[0] * (below_m + reach(air, ray.rising_at(bottom_m)))
        }
        DensityLaw::Exponential => density(air, ray.height_m) * reach(air, ray),
    }
}

/// Interpolated reach. Along mu its reciprocal is interpolated, which is nearly linear in mu; along
/// height itself, which falls to 0 at the top.
fn reach(air: &AirConstituent, ray: RayStart) -> f64 {
    let along_height = Stencil::<4>::new(&air.reach_height_m, ray.height_m);
    let along_mu = Stencil::<4>::new(&air.reach_mu, ray.mu);
    let top = air.reach_height_m.len() - 1;
    along_height.sum(|row| {
        // The last row is 0 throughout: no air is left above it.
        if row == top {
            return 0.0;
        }
        let reaches = air.reach_m.row(row);
        1.0 / along_mu.sum(|node| 1.0 / reaches[node])
    })
}

/// Equivalent length of the first part of a ray: `[height_m, mu, length_m]`.
pub(super) fn segment(air: &AirConstituent, radius_m: f64, start: [f64; 3]) -> f64 {
    let [height_m, mu, length_m] = start;
    let ray = RayStart {
        planet: Planet { radius_m },
        height_m,
        mu,
    };
    if !length_m.is_finite() {
        return column_through_the_ground(air, ray);
    }
    let end = ray.advanced(length_m);
    if ray.mu < 0.0 && end.mu > 0.0 {
        let perigee = ray.perigee();
        return rising_segment(air, perigee, ray.reversed()) + rising_segment(air, perigee, end);
    }
    if ray.mu < 0.0 {
        rising_segment(air, end.reversed(), ray.reversed())
    } else {
        rising_segment(air, ray, end)
    }
}

/// Equivalent length between two points of a line that rises from `low` to `high`.
fn rising_segment(air: &AirConstituent, low: RayStart, high: RayStart) -> f64 {
    let top_m = air.height_m[air.height_m.len() - 1];
    if low.height_m >= top_m {
        return 0.0;
    }
    match air.law {
        DensityLaw::Linear => closed_form::rising_length(air, low, high.height_m),
        DensityLaw::Exponential if high.height_m > top_m => rising_column(air, low),
        DensityLaw::Exponential => {
            let ratio = density(air, low.height_m) / density(air, high.height_m);
            let log_ratio = ratio.ln().abs();
            if log_ratio > LARGEST_LOG_RATIO {
                return rising_column(air, low) - rising_column(air, high);
            }
            let length_m = low.rising_distance_m(low.height_m, high.height_m);
            if log_ratio < SMALL_LOG_RATIO {
                gauss_legendre(air, low, length_m, &HALF_RULE_OF_4)
            } else {
                gauss_legendre(air, low, length_m, &HALF_RULE_OF_8)
            }
        }
    }
}

/// Integral of the density over a length of a ray, by pairs of nodes from the middle outwards.
fn gauss_legendre(
    air: &AirConstituent,
    ray: RayStart,
    length_m: f64,
    half_rule: &[(f64, f64)],
) -> f64 {
    let half_m = 0.5 * length_m;
    let pair = |&(x, weight): &(f64, f64)| {
        let at = |x: f64| density(air, ray.height_after_m(half_m * (1.0 + x)));
        weight * (at(-x) + at(x))
    };
    half_m * half_rule.iter().map(pair).sum::<f64>()
}
