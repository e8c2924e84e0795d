//! Densities, columns and segments from the table of one constituent.
//!
//! L(h, mu) = rho(h) * reach(h, mu)                     mu >= 0, interpolated
//! L(h, mu) = 2 L(p, 0) - L(h, -mu)                     mu < 0, p = height of the perigee
//! A segment of length s is integrated by Gauss-Legendre quadrature while the density on it varies
//! by less than a factor of e^3, and is the difference of two columns beyond: there the columns
//! themselves differ by so much that their difference keeps its digits. The logarithm that a density
//! between two nodes needs is taken once for a segment that stays between them.

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

/// The same for two nodes, which make L^4/4320 = 2e-10 of exp(-L x), in a single layer.
const TINY_LOG_RATIO: f64 = 0.03;

/// Gauss-Legendre nodes and weights of 2, 4 and 8 points on -1..1: the positive half, mirrored in use
/// (Abramowitz and Stegun, table 25.4). Eight integrate `exp` over three e-folds to 1e-14, and over
/// a level ray, where the exponent is a square, to 1e-8.
const HALF_RULE_OF_2: [(f64, f64); 1] = [(0.577350269189625765, 1.0)];
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
    if air.law == DensityLaw::Exponential {
        return Layer::at(air, height_m).density(height_m);
    }
    match Place::of(air, height_m) {
        Place::Below => air.density[0],
        Place::Above => 0.0,
        Place::Between(below) => {
            let t =
                (height_m - air.height_m[below]) / (air.height_m[below + 1] - air.height_m[below]);
            air.density[below] * (1.0 - t) + air.density[below + 1] * t
        }
    }
}

/// Where a height is among the nodes of the density.
enum Place {
    Below,
    /// Between a node and the next one.
    Between(usize),
    /// And where a height is not a number.
    Above,
}

impl Place {
    fn of(air: &AirConstituent, height_m: f64) -> Self {
        let last = air.height_m.len() - 1;
        if height_m > air.height_m[last] || height_m.is_nan() {
            return Self::Above;
        }
        if height_m <= air.height_m[0] {
            return Self::Below;
        }
        let above = air.height_m.partition_point(|&node| node < height_m);
        Self::Between(above.clamp(1, last) - 1)
    }
}

/// Heights between which the density is one exponential:  rho = rho_0 exp((h - h_0) s).
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// The heights (m).
    range_m: (f64, f64),
    /// `h_0` (m).
    from_m: f64,
    /// `rho_0`.
    density: f64,
    /// `s` [1/m].
    log_slope_m1: f64,
}

impl Layer {
    /// Around a height.
    fn at(air: &AirConstituent, height_m: f64) -> Self {
        let even = |density: f64, range_m: (f64, f64)| Self {
            range_m,
            from_m: 0.0,
            density,
            log_slope_m1: 0.0,
        };
        let (bottom_m, top_m) = (air.height_m[0], air.height_m[air.height_m.len() - 1]);
        match Place::of(air, height_m) {
            Place::Below => even(air.density[0], (f64::NEG_INFINITY, bottom_m)),
            Place::Above => even(0.0, (top_m, f64::INFINITY)),
            Place::Between(below) => {
                let (low_m, high_m) = (air.height_m[below], air.height_m[below + 1]);
                let log_ratio = (air.density[below + 1] / air.density[below]).ln();
                Self {
                    range_m: (low_m, high_m),
                    from_m: low_m,
                    density: air.density[below],
                    log_slope_m1: log_ratio / (high_m - low_m),
                }
            }
        }
    }

    fn holds(&self, height_m: f64) -> bool {
        self.range_m.0 <= height_m && height_m <= self.range_m.1
    }

    fn density(&self, height_m: f64) -> f64 {
        if self.log_slope_m1 == 0.0 {
            // Also where a height is infinite or not a number.
            return self.density;
        }
        self.density * ((height_m - self.from_m) * self.log_slope_m1).exp()
    }
}

/// Equivalent length to the top of the air, infinite for a ray that ends on the ground.
pub(super) fn column(air: &AirConstituent, radius_m: f64, height_m: f64, mu: f64) -> f64 {
    let ray = RayStart {
        planet: Planet { radius_m },
        height_m,
        mu,
    };
    if ray.planet.hits_ground(height_m, mu) {
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
            let mut layer = Layer::at(air, low.height_m);
            let is_of_layer = layer.holds(high.height_m);
            let log_ratio = if is_of_layer {
                (layer.log_slope_m1 * (high.height_m - low.height_m)).abs()
            } else {
                let ratio = layer.density(low.height_m) / density(air, high.height_m);
                ratio.ln().abs()
            };
            if log_ratio > LARGEST_LOG_RATIO {
                return rising_column(air, low) - rising_column(air, high);
            }
            let length_m = low.rising_distance_m(low.height_m, high.height_m);
            let half_rule: &[_] = if is_of_layer && log_ratio < TINY_LOG_RATIO {
                &HALF_RULE_OF_2
            } else if log_ratio < SMALL_LOG_RATIO {
                &HALF_RULE_OF_4
            } else {
                &HALF_RULE_OF_8
            };
            let density_after = |distance_m: f64| {
                let height_m = low.height_after_m(distance_m);
                if !layer.holds(height_m) {
                    layer = Layer::at(air, height_m);
                }
                layer.density(height_m)
            };
            gauss_legendre(density_after, length_m, half_rule)
        }
    }
}

/// Integral over a length of a ray, by pairs of nodes from the middle outwards; `density_after` says
/// what is there after a distance (m).
#[inline]
fn gauss_legendre(
    mut density_after: impl FnMut(f64) -> f64,
    length_m: f64,
    half_rule: &[(f64, f64)],
) -> f64 {
    let half_m = 0.5 * length_m;
    let mut at = |x: f64| density_after(half_m * (1.0 + x));
    let pairs = half_rule
        .iter()
        .map(|(x, weight)| weight * (at(-x) + at(*x)));
    half_m * pairs.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    const RADIUS_M: f64 = 6_371_000.0;

    /// Two layers, of scale heights 8 and 4 km; no reaches are asked for.
    fn two_layers() -> AirConstituent {
        let at_knee = (-1.25_f64).exp();
        AirConstituent {
            name: "air".to_owned(),
            extinction_m1: vec![1.0],
            scattering_m1: vec![1.0],
            law: DensityLaw::Exponential,
            height_m: vec![0.0, 10_000.0, 50_000.0],
            density: vec![1.0, at_knee, at_knee * (-10.0_f64).exp()],
            reach_height_m: Vec::new(),
            reach_mu: Vec::new(),
            reach_m: Array2::zeros((0, 0)),
            phase_angle_rad: vec![0.0],
            phase_sr1: Array2::zeros((1, 1)),
        }
    }

    #[test]
    fn a_vertical_segment_in_a_layer_has_its_closed_form_by_rules_of_two_four_and_eight() {
        let air = two_layers();
        for (log_ratio, most_error) in [(0.0299, 3e-10), (0.299, 2e-11), (1.1, 1e-13)] {
            for mu in [1.0, -1.0] {
                let (low_m, length_m) = (900.0, 8e3 * log_ratio);
                let from_m = if mu > 0.0 { low_m } else { low_m + length_m };
                let found = segment(&air, RADIUS_M, [from_m, mu, length_m]);
                let expected = -8e3 * (-low_m / 8e3).exp() * (-log_ratio).exp_m1();
                let error = (found / expected - 1.0).abs();
                // Heights after a distance carry rounding of the planet's radius.
                assert!(error < most_error + 1e-12, "{log_ratio} {mu}: {error:e}");
            }
        }
    }

    #[test]
    fn a_segment_knows_where_its_layer_ends() {
        // From one layer into the other; the parts on both sides of the knee are in one each.
        let air = two_layers();
        for mu in [0.3, 1.0, -0.7] {
            let ray = RayStart {
                planet: Planet { radius_m: RADIUS_M },
                height_m: 10_000.0,
                mu,
            };
            let [before, after] = [-400.0, 300.0].map(|distance_m| ray.advanced(distance_m));
            let whole = segment(&air, RADIUS_M, [before.height_m, before.mu, 700.0]);
            let first = segment(&air, RADIUS_M, [before.height_m, before.mu, 400.0]);
            let second = segment(&air, RADIUS_M, [10_000.0, mu, 300.0]);
            let error = (whole / (first + second) - 1.0).abs();
            // Four nodes across a change of the slope by 1/(8 km): measured 2.5e-4 at most.
            assert!(error < 1e-3, "{mu}: {error:e}");
            for point in [before, after] {
                let of_height = density(&air, point.height_m);
                let expected = if point.height_m < 10_000.0 {
                    (-point.height_m / 8e3).exp()
                } else {
                    (-1.25 - (point.height_m - 10_000.0) / 4e3).exp()
                };
                assert!((of_height / expected - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn density_is_held_below_the_nodes_and_nothing_is_above_them() {
        let air = two_layers();
        assert_eq!(density(&air, -100.0), 1.0);
        assert_eq!(density(&air, f64::NEG_INFINITY), 1.0);
        for nothing in [50_001.0, f64::INFINITY, f64::NAN] {
            assert_eq!(density(&air, nothing), 0.0);
        }
    }
}
