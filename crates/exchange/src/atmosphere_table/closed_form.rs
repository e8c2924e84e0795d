//! Equivalent length through layers of linear density, in closed form.
//!
//! On a line with perigee radius p, x = distance from the perigee, r = sqrt(p^2 + x^2):
//!   integral (r - a) dx = ½ [x r + p^2 asinh(x/p)] - a x
//! so a layer of density  alpha + beta (r - a)  is integrated exactly. The two large terms cancel to
//! 1e-9 of the length at most, for a planet of the Earth's size.

use super::AirConstituent;
use super::ray_start::RayStart;

/// Equivalent length of a rising ray from its start up to a height.
pub(super) fn rising_length(air: &AirConstituent, ray: RayStart, end_height_m: f64) -> f64 {
    let below = below_the_first_node(air, ray, end_height_m);
    let layers = air.height_m.windows(2).zip(air.density.windows(2));
    let inside = layers.map(|(heights, densities)| {
        let low_m = heights[0].max(ray.height_m);
        let high_m = heights[1].min(end_height_m);
        if low_m >= high_m {
            return 0.0;
        }
        let slope_m1 = (densities[1] - densities[0]) / (heights[1] - heights[0]);
        let low_density = densities[0] + slope_m1 * (low_m - heights[0]);
        let length_m = ray.rising_distance_m(low_m, high_m);
        low_density * length_m + slope_m1 * integral_of_height(ray, low_m, high_m)
    });
    below + inside.sum::<f64>()
}

/// The part below the first node, where the density is held.
fn below_the_first_node(air: &AirConstituent, ray: RayStart, end_height_m: f64) -> f64 {
    let high_m = air.height_m[0].min(end_height_m);
    if ray.height_m >= high_m {
        return 0.0;
    }
    air.density[0] * ray.rising_distance_m(ray.height_m, high_m)
}

/// Integral of (h - low) ds along a rising line between two heights, m^2.
///
/// The closed form loses digits on short pieces, where Simpson's rule in the height's own factored
/// form is exact enough: the height is a parabola of the distance up to terms (s/R)^2.
fn integral_of_height(line: RayStart, low_m: f64, high_m: f64) -> f64 {
    let low = line.rising_at(low_m);
    let length_m = line.rising_distance_m(low_m, high_m);
    if length_m < SHORT_LENGTH * line.planet.radius_m {
        let middle_m = low.height_after_m(0.5 * length_m);
        return length_m / 6.0 * (4.0 * (middle_m - low_m) + (high_m - low_m));
    }
    let r0 = low.radius_m();
    let p2 = r0 * r0 * (1.0 - low.mu) * (1.0 + low.mu);
    let (x0, x1) = (r0 * low.mu, r0 * low.mu + length_m);
    let r1 = line.planet.radius_m + high_m;
    // asinh(x/p) = ln((x + r)/p): the difference of two is one logarithm, in which p has gone.
    let bend = p2 * ((length_m + high_m - low_m) / (x0 + r0)).ln_1p();
    0.5 * (x1 * r1 - x0 * r0 + bend) - r0 * length_m
}

/// Pieces shorter than this share of the radius, 6 km on Earth, are integrated by Simpson's rule.
const SHORT_LENGTH: f64 = 1e-3;
