//! What flat drops change, coarsely: a bound before any table is made.
//!
//! P(theta; C) = sum_i w_i P(theta - delta_i),   delta = mean shift of [`niji_exchange::FallingDrops`]
//! T = c S + s C,   B = s S - c C,   c = cos(theta/2),  s = sin(theta/2)
//! is the light of a law whose sizes i, with shares w_i of it, send each the bow of the whole law,
//! moved: their fringes have averaged out, and the peaks of all sizes lie together. The shift depends on
//! the components T and B of the vertical along s + d and s - d, `s` towards the sun, `d` from the eye: on
//! `S`, how high the sun stands (sine), and `C`, the rise of the view (`view`), -1 to 1. It is taken at
//! the angle of the bow of spheres, in green light.

use niji_exchange::BowShift;
use niji_exchange::FARTHEST_SHIFT_RAD;
use niji_exchange::FallingDrops;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;
use niji_scatter::DropMotion;
use niji_scatter::bow_shift;
use niji_scatter::dark_band_rad;
use niji_sizes::gamma_area_quadrature;
use niji_sizes::law_support;

use super::curve::STEP_RAD;
use super::directed_curve::HALF_STEP;
use super::directed_curve::rise_of;

/// Orders that make the primary and the secondary bow.
pub(super) const BOWS: [u32; 2] = [2, 3];

/// Green light, whose bow stands for all where it is asked how far one moves.
const GREEN: Nanometers = Nanometers(550.0);

/// Sizes that stand for a law.
const N_SIZES: usize = 32;

/// Share of the cross-section in drops whose bows are not followed beyond the angles in view.
const NOT_FOLLOWED: f64 = 1e-3;

/// How both bows of flat drops move.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatDrops {
    /// S.
    sun_height: f64,
    motion: DropMotion,
    /// Scattering angle of the bow of spheres (rad) and its shift, of each bow.
    bows: [(f64, BowShift); 2],
}

/// Steps of angle by which light moves, with its shares.
pub(super) type Kernel = Vec<(i64, f64)>;

impl FlatDrops {
    /// Drops of water that move so, under a sun whose height is the sine of its elevation.
    pub(super) fn new(sun_height: f64, motion: DropMotion, water: Water) -> Self {
        let index = water.refractive_index(GREEN);
        // An order without a bow stays.
        let shift = |order| bow_shift(index, order).unwrap_or_default();
        let [primary_rad, secondary_rad] = dark_band_rad(water);
        Self {
            sun_height,
            motion,
            bows: [
                (primary_rad, shift(BOWS[0])),
                (secondary_rad, shift(BOWS[1])),
            ],
        }
    }

    /// Shift in radians of a bow, 0 the primary, 1 the secondary, where the view rises so.
    fn shift_rad(&self, bow: usize, drops: &FallingDrops, rise: f64) -> f64 {
        let (theta_rad, shift) = &self.bows[bow];
        let [t2, b2] = axis_squares(*theta_rad, self.sun_height, rise);
        let shift_rad = drops.mean_shift_rad(shift, t2, b2);
        shift_rad.clamp(-FARTHEST_SHIFT_RAD, FARTHEST_SHIFT_RAD)
    }

    /// How the light of a law of effective radius (um) and variance moves at a node of the rise.
    pub(super) fn kernel(&self, bow: usize, node: i32, law: (f64, f64)) -> Kernel {
        let (radius_um, variance) = law;
        let sizes = gamma_area_quadrature(Micrometers(radius_um), variance, N_SIZES);
        let sizes = sizes.unwrap_or_else(|_| vec![(radius_um, 1.0)]);
        // The peak of a drop's bow over its area goes with the cube root of its radius.
        let light = |(radius_um, area): &(f64, f64)| area * radius_um.cbrt();
        let total: f64 = sizes.iter().map(light).sum();
        let mut kernel = Kernel::new();
        for size in &sizes {
            let drops = self.motion.drops(Micrometers(size.0));
            let steps = self.shift_rad(bow, &drops, rise_of(node)) / STEP_RAD;
            let (whole, part) = (steps.floor() as i64, steps - steps.floor());
            let share = light(size) / total;
            for (step, share) in [(whole, share * (1.0 - part)), (whole + 1, share * part)] {
                match kernel.iter_mut().find(|(known, _)| *known == step) {
                    Some((_, sum)) => *sum += share,
                    None => kernel.push((step, share)),
                }
            }
        }
        kernel
    }

    /// How far the bow of drops of these laws' effective radii moves at most between a node of the rise and
    /// halfway to the next.
    pub(super) fn between_nodes_rad(&self, bow: usize, node: i32, laws: &[(f64, f64)]) -> f64 {
        let of_law = |(radius_um, _): &(f64, f64)| {
            let drops = self.motion.drops(Micrometers(*radius_um));
            let shift = |rise: f64| self.shift_rad(bow, &drops, rise);
            let at = shift(rise_of(node));
            let beside =
                [-HALF_STEP, HALF_STEP].map(|away| (shift(rise_of(node) + away) - at).abs());
            beside[0].max(beside[1])
        };
        laws.iter().map(of_law).fold(0.0, f64::max)
    }

    /// Smallest and largest shift of either bow of the largest drops of these laws, none among them.
    pub(super) fn range_rad(&self, laws: &[(f64, f64)], nodes: &[i32]) -> (f64, f64) {
        let mut range_rad = (0.0_f64, 0.0_f64);
        for law in laws {
            let drops = self.motion.drops(largest(*law));
            for (bow, node) in [0, 1]
                .into_iter()
                .flat_map(|bow| nodes.iter().map(move |n| (bow, *n)))
            {
                let shift_rad = self.shift_rad(bow, &drops, rise_of(node));
                range_rad = (range_rad.0.min(shift_rad), range_rad.1.max(shift_rad));
            }
        }
        range_rad
    }

    /// How far the bows of the largest drops of a law move, seen from wherever.
    pub(super) fn farthest_rad(&self, law: (f64, f64)) -> f64 {
        let e = self.motion.drops(largest(law)).eccentricity;
        let [primary, secondary] = self.bows.map(|(_, shift)| shift.largest_rad(e));
        primary.max(secondary)
    }
}

/// The largest drops of a law whose bows are followed.
fn largest((radius_um, variance): (f64, f64)) -> Micrometers {
    let support = law_support(Micrometers(radius_um), variance, NOT_FOLLOWED);
    Micrometers(support.map_or(radius_um, |(_, high_um)| high_um))
}

/// T² and B².
fn axis_squares(theta_rad: f64, sun_height: f64, rise: f64) -> [f64; 2] {
    let (sine, cosine) = (0.5 * theta_rad).sin_cos();
    // No view rises more than the sun's own direction leaves of the vertical.
    let steepest = (1.0 - sun_height * sun_height).max(0.0).sqrt();
    let rise = rise.clamp(-steepest, steepest);
    let [t, b] = [
        cosine * sun_height + sine * rise,
        sine * sun_height - cosine * rise,
    ];
    [t * t, b * b]
}

/// A row that has moved. Its ends hold beyond it.
pub(super) fn moved(row: &[f64], kernel: &Kernel) -> Vec<f64> {
    let mut sum = vec![0.0; row.len()];
    let (Some(first), Some(last)) = (row.first(), row.last()) else {
        return sum;
    };
    let n = row.len() as i64;
    for (steps, share) in kernel {
        // The light of `begin` to `end` of the row is within the row after its move.
        let (begin, end) = (
            (-steps).clamp(0, n) as usize,
            (n - steps).clamp(0, n) as usize,
        );
        let (from, to) = (
            (begin as i64 + steps).clamp(0, n) as usize,
            (end as i64 + steps).clamp(0, n) as usize,
        );
        for sum in &mut sum[..from] {
            *sum += share * first;
        }
        for (sum, light) in sum[from..to].iter_mut().zip(&row[begin..end]) {
            *sum += share * light;
        }
        for sum in &mut sum[to..] {
            *sum += share * last;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::plan::directed_curve::nodes;
    use crate::plan::view::rise;

    const WATER: Water = Water::pure(15.0);
    const STILL: DropMotion = DropMotion {
        tilt_sd_deg: 0.0,
        axis_ratio_sd: 0.0,
    };

    fn flat(elevation_deg: f64) -> FlatDrops {
        FlatDrops::new(elevation_deg.to_radians().sin(), STILL, WATER)
    }

    #[test]
    fn components_of_the_vertical_are_those_of_sums_and_differences_of_directions() {
        for (elevation_deg, view) in [
            (0.0, DVec3::new(0.3, 0.5, -0.8)),
            (20.0, DVec3::new(-0.4, -0.3, -0.7)),
            (70.0, DVec3::new(0.1, 0.9, 0.2)),
        ] {
            let (height, across) = f64::to_radians(elevation_deg).sin_cos();
            let (sun, view) = (DVec3::new(0.0, height, across), view.normalize());
            let theta_rad = sun.dot(view).acos();
            let square = |vector: DVec3| vector.normalize().y.powi(2);
            let found = axis_squares(theta_rad, height, rise(view, sun));
            for (found, expected) in found
                .into_iter()
                .zip([square(sun + view), square(sun - view)])
            {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }

    #[test]
    fn the_shift_is_that_of_traced_rays() {
        // Top of the primary of the ellipse of Beard and Chuang's axis ratio, n = 1.333, the sun at
        // 20 degrees: from 42.08 degrees of the sphere.
        for (diameter_mm, traced_deg) in [(1.0, 2.34), (1.5, 5.76), (2.0, 10.17)] {
            let drops = STILL.drops(Micrometers(500.0 * diameter_mm));
            let rise = f64::to_radians(20.0).cos();
            let found_deg = flat(20.0).shift_rad(0, &drops, rise).to_degrees();
            assert!((found_deg / traced_deg - 1.0).abs() < 0.03, "{found_deg}");
        }
        let giant = STILL.drops(Micrometers(4e3));
        assert_eq!(
            flat(20.0).shift_rad(0, &giant, 1.0).abs(),
            FARTHEST_SHIFT_RAD
        );
        assert!(flat(20.0).shift_rad(0, &STILL.drops(Micrometers(50.0)), 1.0) < 1e-4);
    }

    #[test]
    fn kernels_share_all_of_the_light_and_lie_within_the_range() {
        let (flat, laws) = (
            flat(10.0),
            [(200.0, 0.0), (500.0, 0.05), (500.0, 1.0 / 3.0)],
        );
        let all: Vec<i32> = nodes((-1.0, 1.0)).collect();
        let (low_rad, high_rad) = flat.range_rad(&laws, &all);
        for (bow, law) in [0, 1]
            .into_iter()
            .flat_map(|bow| laws.map(|law| (bow, law)))
        {
            assert!(flat.farthest_rad(law) <= FARTHEST_SHIFT_RAD);
            for node in &all {
                let kernel = flat.kernel(bow, *node, law);
                let light: f64 = kernel.iter().map(|(_, share)| share).sum();
                assert!((light - 1.0).abs() < 1e-12);
                let outside = kernel.iter().filter(|(steps, _)| {
                    let shift_rad = STEP_RAD * *steps as f64;
                    !(low_rad - STEP_RAD..high_rad + STEP_RAD).contains(&shift_rad)
                });
                // The largest drops are not followed.
                assert!(outside.map(|(_, share)| share).sum::<f64>() < 5e-3);
            }
        }
    }

    #[test]
    fn a_row_moves_by_its_shift_and_stays_where_there_is_none() {
        let row: Vec<f64> = (0..200)
            .map(|i| (-0.01 * f64::from(i - 60).powi(2)).exp())
            .collect();
        let still = moved(&row, &vec![(0, 1.0)]);
        assert_eq!(row, still);
        for steps in [30, -30] {
            let by_30 = moved(&row, &vec![(steps, 1.0)]);
            let at = (60 + steps) as usize;
            assert!((by_30[at] - 1.0).abs() < 1e-9 && by_30[60] < 1e-3);
        }
        let far = moved(&row, &vec![(300, 0.5), (-300, 0.5)]);
        let ends = 0.5 * (row[0] + row[199]);
        assert!(far.iter().all(|value| (value - ends).abs() < 1e-12));
        assert!(moved(&[], &vec![(3, 1.0)]).is_empty());
    }
}
