//! What flat drops change, coarsely: a bound before any table is made.
//!
//! P(theta; m) = sum_i w_i P(theta - m delta_i)
//! `delta_i` how far the primary bow of the size i moves where m = 1, [`niji_scatter::bow_shift`];
//! `m` from -1 to 1 by direction ([`niji_render::flattening_along`]).
//! is the light of a law whose sizes i, with shares w_i of it, send each the bow of the whole law,
//! moved: their fringes have averaged out, and the peaks of all sizes lie together.

use std::sync::LazyLock;

use niji_exchange::BowShift;
use niji_radiometry::Micrometers;
use niji_scatter::bow_shift;
use niji_scatter::eccentricity;
use niji_sizes::gamma_area_quadrature;

use super::curve::STEP_RAD;

/// Index of water for green light.
const INDEX: f64 = 1.333;

/// The shift of the primary.
static PRIMARY: LazyLock<BowShift> =
    LazyLock::new(|| bow_shift(INDEX, 2).expect("water has a primary bow"));

/// Shift of the secondary over that of the primary, which is in the other direction.
pub(super) const OF_SECONDARY: f64 = -0.055;

/// No bow is followed farther, rad; tables do not either.
const LARGEST_SHIFT_RAD: f64 = 0.8;

/// Sizes that stand for a law.
const N_SIZES: usize = 32;

/// Standard deviations of a law's radii that count as its largest drops: beyond are 0.1 % of the area
/// of a Marshall-Palmer rain.
const DEVIATIONS: f64 = 4.0;

/// Shift of the primary bow of drops of a radius where m = 1.
pub(super) fn shift_rad(radius_um: f64) -> f64 {
    let shift_rad = PRIMARY.shift_rad(eccentricity(Micrometers(radius_um)), 1.0, 0.0);
    shift_rad.min(LARGEST_SHIFT_RAD)
}

/// Shift of the primary bow of the largest drops of laws (effective radius (um), effective variance)
/// where m = 1.
pub(super) fn largest_shift_rad(sizes: &[(f64, f64)]) -> f64 {
    let largest = |(radius_um, variance): &(f64, f64)| {
        shift_rad(radius_um * (1.0 + DEVIATIONS * variance.sqrt()))
    };
    sizes.iter().map(largest).fold(0.0, f64::max)
}

/// A law as classes: shift where m = 1, and share of the light.
pub(super) type Classes = Vec<(f64, f64)>;

/// The classes of a law of effective radius (um) and variance.
pub(super) fn classes((radius_um, variance): (f64, f64)) -> Classes {
    let sizes = gamma_area_quadrature(Micrometers(radius_um), variance, N_SIZES);
    let sizes = sizes.unwrap_or_else(|_| vec![(radius_um, 1.0)]);
    // The peak of a drop's bow over its area goes with the cube root of its radius.
    let light = |(radius_um, area): &(f64, f64)| area * radius_um.cbrt();
    let total: f64 = sizes.iter().map(light).sum();
    sizes
        .iter()
        .map(|size| (shift_rad(size.0), light(size) / total))
        .collect()
}

/// The light of one law in flat drops: every class moved by `m` times its shift. The ends hold
/// beyond the row.
pub(super) fn moved(row: &[f64], classes: &Classes, m: f64) -> Vec<f64> {
    let mut sum = vec![0.0; row.len()];
    let Some(last) = row.len().checked_sub(1) else {
        return sum;
    };
    for (shift_rad, share) in classes {
        let steps = m * shift_rad / STEP_RAD;
        // Light comes from `whole` steps below, and by a part from one step further.
        let (whole, part) = (steps.floor() as i64, steps - steps.floor());
        let at = |index: i64| row[index.clamp(0, last as i64) as usize];
        let (upper, lower) = (share * (1.0 - part), share * part);
        for (index, sum) in sum.iter_mut().enumerate() {
            let from = index as i64 - whole;
            *sum += upper * at(from) + lower * at(from - 1);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shift_is_close_to_that_of_traced_rays() {
        // Top of the primary of the ellipse of Beard and Chuang's axis ratio, n = 1.333, the sun at
        // 20 degrees: from 42.08 degrees of the sphere. m = cos(42.08 - 40 degrees).
        for (diameter_mm, traced_deg) in [(1.0, 2.34), (1.5, 5.76), (2.0, 10.17)] {
            let found_deg = shift_rad(500.0 * diameter_mm).to_degrees();
            assert!((found_deg / traced_deg - 1.0).abs() < 0.1, "{found_deg}");
        }
        assert!(shift_rad(50.0) < 1e-4 && shift_rad(1e4) <= LARGEST_SHIFT_RAD);
    }

    #[test]
    fn classes_share_all_of_the_light() {
        for variance in [0.0, 0.05, 1.0 / 3.0] {
            let classes = classes((500.0, variance));
            let sum: f64 = classes.iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-12);
            assert!(largest_shift_rad(&[(500.0, variance)]) >= classes[0].0);
        }
        // Half of the bow of rain at 5 mm/h comes from drops above 1 mm.
        let moved: f64 = classes((513.0, 1.0 / 3.0))
            .iter()
            .filter(|(shift, _)| *shift > shift_rad(500.0))
            .map(|(_, share)| share)
            .sum();
        assert!((0.4..0.7).contains(&moved), "{moved}");
    }

    #[test]
    fn a_row_moves_by_its_shift_and_stays_where_there_is_none() {
        let row: Vec<f64> = (0..200)
            .map(|i| (-0.01 * f64::from(i - 60).powi(2)).exp())
            .collect();
        let still = moved(&row, &vec![(0.1, 0.25), (0.0, 0.75)], 0.0);
        assert!(row.iter().zip(&still).all(|(a, b)| (a - b).abs() < 1e-15));
        let by_30 = moved(&row, &vec![(30.0 * STEP_RAD, 1.0)], 1.0);
        assert!((by_30[90] - 1.0).abs() < 1e-9 && by_30[60] < 1e-3);
        assert!(moved(&[], &vec![(0.1, 1.0)], 1.0).is_empty());
    }
}
