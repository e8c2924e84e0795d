//! The largest optical depth of drops on any ray of a bundle, Q = 1.
//!
//! tau <= min(sum_i beta_i l_i, L int max_(i: t in T_i) beta_i dt),   modes added
//! over the boxes i of drops, `beta_i` the largest extinction in one and `l_i` the longest way of a ray
//! inside. `T_i` are the ray parameters at which some ray of the bundle is in box i, so that at each t
//! a ray meets no more than the densest box that any of them is in; `L` is the length that a unit of t
//! stands for at most. The first is smaller where rays differ along their way, the second where they
//! run side by side.

use std::collections::BinaryHeap;

use glam::DVec3;
use niji_geometry::Aabb;

use super::drop_parts::DropPart;

/// Rays w t from somewhere in a box, w of components within ranges.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bundle {
    /// Where they start.
    pub(super) origin: Aabb,
    /// Smallest and largest component of w along each axis.
    pub(super) components: [(f64, f64); 3],
    /// Largest length of w; none is below 1.
    pub(super) longest: f64,
}

/// A box that rays of a bundle cross.
#[derive(Debug, Clone, Copy)]
struct Crossed {
    mode: usize,
    extinction_m1: f64,
    /// Ray parameters of the first entry and the last exit.
    range: (f64, f64),
    /// Longest way of a ray inside (m).
    length_m: f64,
}

impl Bundle {
    /// Earliest entry into and latest exit from a box, as ray parameters; `None` if no ray meets it.
    pub(super) fn range(&self, bounds: &Aabb) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let near = bounds.min[axis] - self.origin.max[axis];
            let far = bounds.max[axis] - self.origin.min[axis];
            let (axis_enter, axis_leave) = slab((near, far), self.components[axis])?;
            enter = enter.max(axis_enter);
            leave = leave.min(axis_leave);
            if enter >= leave {
                return None;
            }
        }
        // No w is shorter than 1.
        Some((enter, leave.min(self.farthest_m(bounds).max(enter))))
    }

    /// Distance to the farthest corner of a box.
    pub(super) fn farthest_m(&self, bounds: &Aabb) -> f64 {
        let low = (bounds.min - self.origin.max).abs();
        let high = (bounds.max - self.origin.min).abs();
        low.max(high).length()
    }

    /// Rays in one direction, a unit vector.
    pub(super) fn parallel(origin: Aabb, direction: DVec3) -> Self {
        Self {
            origin,
            components: direction.to_array().map(|it| (it, it)),
            longest: 1.0,
        }
    }

    /// Largest optical depth of the drops in boxes on any of the rays.
    pub(super) fn largest_depth(&self, parts: &[DropPart]) -> f64 {
        let mut crossed = Vec::new();
        self.cross(parts, &mut crossed);
        // Stable, and modes stand in order but for where large boxes of several mix.
        crossed.sort_by_key(|part| part.mode);
        crossed
            .chunk_by(|a, b| a.mode == b.mode)
            .map(|mode| self.depth_of_mode(mode))
            .sum()
    }

    fn cross(&self, parts: &[DropPart], crossed: &mut Vec<Crossed>) {
        for part in parts {
            let Some(range) = self.range(&part.bounds) else {
                continue;
            };
            if part.within.is_empty() {
                let length_m = (range.1 - range.0) * self.longest;
                crossed.push(Crossed {
                    mode: part.mode,
                    extinction_m1: part.max_extinction_m1_q1,
                    range,
                    length_m: length_m.min(part.bounds.size().length()),
                });
            } else {
                self.cross(&part.within, crossed);
            }
        }
    }

    fn depth_of_mode(&self, crossed: &[Crossed]) -> f64 {
        let one_by_one = crossed.iter().map(|it| it.extinction_m1 * it.length_m);
        one_by_one.sum::<f64>().min(self.longest * densest(crossed))
    }
}

/// int max beta dt: the boxes are laid over one another, the densest on top.
fn densest(crossed: &[Crossed]) -> f64 {
    let mut ends: Vec<f64> = crossed
        .iter()
        .flat_map(|part| [part.range.0, part.range.1])
        .collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    // Of every interval between ends the next that nothing covers yet.
    let mut open: Vec<usize> = (0..=ends.len()).collect();
    let mut by_density: Vec<&Crossed> = crossed.iter().collect();
    by_density.sort_by(|a, b| b.extinction_m1.total_cmp(&a.extinction_m1));
    let mut sum = 0.0;
    for part in by_density {
        let [first, last] =
            [part.range.0, part.range.1].map(|end| ends.partition_point(|other| *other < end));
        let mut interval = first_open(&mut open, first);
        while interval < last {
            sum += part.extinction_m1 * (ends[interval + 1] - ends[interval]);
            open[interval] = interval + 1;
            interval = first_open(&mut open, interval);
        }
    }
    sum
}

/// The first open interval at or after one; the way there is shortened for whoever asks next.
fn first_open(open: &mut [usize], mut interval: usize) -> usize {
    while open[interval] != interval {
        open[interval] = open[open[interval]];
        interval = open[interval];
    }
    interval
}

/// Earliest entry into and latest exit from a slab at `near..far` relative to the eye, for all
/// components `low..high` of the direction; `None` if every ray leads away from it.
fn slab((near, far): (f64, f64), (low, high): (f64, f64)) -> Option<(f64, f64)> {
    if near <= 0.0 && far >= 0.0 {
        // A ray of component 0 never leaves, and there is one among components of both signs.
        let leave = if low > 0.0 {
            far / low
        } else if high < 0.0 {
            near / high
        } else {
            f64::INFINITY
        };
        return Some((0.0, leave));
    }
    // Mirror a slab on the negative side.
    let (near, far, low, high) = if near > 0.0 {
        (near, far, low, high)
    } else {
        (-far, -near, -high, -low)
    };
    if high <= 0.0 {
        return None;
    }
    let leave = if low > 0.0 { far / low } else { f64::INFINITY };
    Some((near / high, leave))
}

/// Squares along each side of the shadow that are looked at first.
const N_FIRST: i32 = 8;

/// Squares that are cut in four.
const N_CUT: usize = 150;

/// A square of the plane that sunlight crosses at right angles, by what the drops on its rays are at
/// most.
struct Square {
    depth: f64,
    /// Middle, in units of `half` along both sides of the plane.
    place: [f64; 2],
    half_m: f64,
}

impl PartialEq for Square {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Square {}
impl PartialOrd for Square {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Square {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.depth.total_cmp(&other.depth)
    }
}

/// Largest optical depth of the drops in boxes towards the sun: the plane across sunlight is cut into
/// squares, and the deepest of them again and again.
pub(super) fn largest_sun_depth(parts: &[DropPart], whole: &Aabb, sun: DVec3) -> f64 {
    let (across, up) = sun.any_orthonormal_pair();
    let radius_m = 0.5 * whole.size().length();
    let middle = 0.5 * (whole.min + whole.max) - radius_m * sun;
    let square = |place: [f64; 2], half_m: f64| {
        let center = middle + place[0] * across + place[1] * up;
        let reach = half_m * (across.abs() + up.abs());
        let origin = Aabb {
            min: center - reach,
            max: center + reach,
        };
        Square {
            depth: Bundle::parallel(origin, sun).largest_depth(parts),
            place,
            half_m,
        }
    };
    let half_m = radius_m / f64::from(N_FIRST);
    let mut squares = BinaryHeap::new();
    for row in 0..N_FIRST {
        for column in 0..N_FIRST {
            let place = [row, column].map(|index| f64::from(2 * index + 1 - N_FIRST) * half_m);
            squares.push(square(place, half_m));
        }
    }
    for _ in 0..N_CUT {
        let Some(deepest) = squares.pop() else { break };
        let half_m = 0.5 * deepest.half_m;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let [a, b] = deepest.place;
            squares.push(square([a + x * half_m, b + y * half_m], half_m));
        }
    }
    squares.peek().map_or(0.0, |deepest| deepest.depth)
}

#[cfg(test)]
mod tests {
    use niji_dropfield::Bricks;
    use niji_dropfield::Interpolation;
    use niji_geometry::PixelRegion;

    use super::super::drop_summary::DropSummary;
    use super::super::view::Extent;
    use super::super::view::blocks;
    use crate::scene::Scene;

    use super::*;

    fn part(low: [f64; 3], high: [f64; 3], extinction_m1: f64) -> DropPart {
        DropPart {
            bounds: Aabb {
                min: DVec3::from(low),
                max: DVec3::from(high),
            },
            max_extinction_m1_q1: extinction_m1,
            mode: 0,
            within: Vec::new(),
        }
    }

    fn towards_z() -> Bundle {
        Bundle {
            origin: Aabb {
                min: DVec3::ZERO,
                max: DVec3::ZERO,
            },
            components: [(-0.1, 0.1), (-0.1, 0.1), (1.0, 1.0)],
            longest: 1.02_f64.sqrt(),
        }
    }

    #[test]
    fn boxes_behind_each_other_add_up_and_boxes_side_by_side_do_not() {
        let behind = [
            part([-9.0, -9.0, 10.0], [9.0, 9.0, 12.0], 0.1),
            part([-9.0, -9.0, 12.0], [9.0, 9.0, 15.0], 0.3),
        ];
        let longest = towards_z().longest;
        let expected = longest * (2.0 * 0.1 + 3.0 * 0.3);
        let found = towards_z().largest_depth(&behind);
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        let beside = [
            part([-9.0, -9.0, 10.0], [0.0, 9.0, 12.0], 0.1),
            part([0.0, -9.0, 10.0], [9.0, 9.0, 12.0], 0.3),
        ];
        let found = towards_z().largest_depth(&beside);
        assert!((found / (longest * 2.0 * 0.3) - 1.0).abs() < 1e-12);
        // Modes are in one place.
        let mut modes = beside;
        modes[1].mode = 1;
        let found = towards_z().largest_depth(&modes);
        assert!((found / (longest * 2.0 * 0.4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_box_that_overlaps_denser_ones_counts_where_they_are_not() {
        let cross = |low, high, extinction_m1| Crossed {
            mode: 0,
            extinction_m1,
            range: (low, high),
            length_m: high - low,
        };
        let crossed = [
            cross(0.0, 10.0, 1.0),
            cross(2.0, 3.0, 5.0),
            cross(6.0, 12.0, 2.0),
            cross(2.5, 7.0, 3.0),
        ];
        // 0-2: 1, 2-3: 5, 3-7: 3, 7-12: 2.
        assert_eq!(densest(&crossed), 2.0 + 5.0 + 12.0 + 10.0);
        assert_eq!(densest(&[]), 0.0);
    }

    /// Shipped scenes whose drops are far from even.
    const UNEVEN: [&str; 3] = [
        include_str!("../../../../data/scenes/waterfall-gorge.toml"),
        include_str!("../../../../data/scenes/garden-fountain.toml"),
        include_str!("../../../../data/scenes/sea-spray.toml"),
    ];

    /// Optical depth by sampling every quarter of a voxel.
    fn marched(modes: &[Bricks], (origin, direction): (DVec3, DVec3), range_m: (f64, f64)) -> f64 {
        let step_m = 0.25 * modes[0].voxel_m();
        let n = ((range_m.1 - range_m.0) / step_m) as u32;
        let at = |index: u32| origin + (range_m.0 + step_m * (f64::from(index) + 0.5)) * direction;
        let extinction = |point: DVec3| -> f64 {
            modes
                .iter()
                .map(|mode| f64::from(mode.sample(point).moments().extinction_m1_q1() as f32))
                .sum()
        };
        (0..n).map(|index| step_m * extinction(at(index))).sum()
    }

    /// Most that the bound of a scene is above the depth of its deepest ray, towards the picture and
    /// towards the sun; measured 3.0, 4.1, 2.3 and 11.8, 2.8, 3.0. The foot of a fall is far denser
    /// than what lies a voxel away.
    const LOOSEST: [(f64, f64); 3] = [(4.0, 14.0), (5.0, 4.0), (3.0, 4.0)];

    #[test]
    fn no_ray_is_deeper_than_its_bound_and_the_bound_is_close() {
        for (text, (loosest, loosest_sun)) in UNEVEN.into_iter().zip(LOOSEST) {
            let scene = Scene::from_toml(text).unwrap();
            let volume = scene.drops.shape().unwrap().volume().unwrap();
            let summary = DropSummary::of_volume(&volume).unwrap();
            let modes = volume.modes.iter();
            let build = |mode| Bricks::build(mode, Interpolation::RadiusDensity).unwrap();
            let modes: Vec<Bricks> = modes.map(build).collect();
            let whole = summary.bounds();
            let extent = Extent {
                whole,
                extinction_m1: summary.max_extinction_m1_q1,
                parts: &summary.parts,
            };
            let camera = scene.camera.camera().unwrap();
            let region = PixelRegion::frame(camera.width_px(), camera.height_px());
            let sun = scene.sun.direction();
            let (mut deepest, mut bound) = (0.0_f64, 0.0_f64);
            for block in blocks(&camera, region, sun, &extent) {
                let Some(chord) = block.drops else { continue };
                bound = bound.max(block.depth);
                for direction in block.samples {
                    let ray = (camera.position(), direction);
                    let found = marched(&modes, ray, (chord.enter_m, chord.leave_m));
                    // Half of a percent for the steps.
                    assert!(found <= 1.005 * block.depth, "{found} {}", block.depth);
                    deepest = deepest.max(found);
                }
            }
            assert!(bound <= loosest * deepest, "{bound} {deepest}");
            let sun_bound = largest_sun_depth(&summary.parts, &whole, sun);
            let mut deepest = 0.0_f64;
            // From the ground, in lines so close that no sheet of water falls between them.
            for index in 0..10 * 160_u32 {
                let u = (f64::from(index % 10) + 0.5) / 10.0;
                let v = (f64::from(index / 10) + 0.5) / 160.0;
                let size = whole.size();
                let place = whole.min + DVec3::new(u * size.x, 0.0, v * size.z);
                let found = marched(&modes, (place, sun), (0.0, size.length()));
                assert!(found <= 1.005 * sun_bound, "{found} {sun_bound}");
                deepest = deepest.max(found);
            }
            assert!(sun_bound <= loosest_sun * deepest, "{sun_bound} {deepest}");
        }
    }
}
