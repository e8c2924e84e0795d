//! Pixels between the rays of a lattice.
//!
//! L(x) = sum_k w_k L(x_k),   w = (-1, 9, 9, -1)/16   along a row, a column, or both
//! `x_k` the four nearest nodes of a lattice twice as coarse: Lagrange's sum, exact for cubic polynomials. Light of drops
//! and air hardly changes from pixel to pixel: a volume has nothing finer than its voxels, and the sun smears every bow
//! over half a degree. So rays are followed for pixels some way apart, and for those between only where the sum does
//! not hold. Nodes half as far apart that were followed all the same say by how much it errs. At half the distance it
//! errs by a sixteenth of that where light is smooth, by a half at a kink, and by as much where voxels are hardly
//! wider than the lattice, which is what is told.
//!
//! A sum stands for a ray
//! * where its nodes and the ray meet the same open place, sky or level ground without shadows of surfaces, through drops
//!   or through none, and all on one side of the angle between the bows; or water that sends them on to the same, facet by
//!   facet, to such places where it is still;
//! * where nodes lie no farther apart than the sun is wide, and than the voxels of all drops on the way look where these
//!   end, straight or in water, and, as a shadow, on the ground and on water that shows the sun, whose depth a grazing
//!   sight sees closer together;
//! * where what is told is at most a quarter of what a pixel may err by before it gets more rays: of errors that add up
//!   by their squares next to nothing.
//!
//! Lattices stand still in the frame, so that a pixel is the same whatever region it is rendered in.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::Vec4;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::PixelRegion;
use rayon::prelude::*;

use crate::error_parts::together;
use crate::footprint_cuts::Met;
use crate::footprint_cuts::alike;
use crate::levels::PixelFootprint;
use crate::pixel::Pixel;
use crate::ray_light::OnGround;
use crate::ray_tracer::RayTracer;
use crate::ray_tracer::Room;
use crate::surfaces::Sight;

/// Weights of four nodes in a row for the place in their middle, and of the two inner ones alone.
const CUBIC: [f32; 4] = [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0];
const LINEAR: [f32; 4] = [0.0, 0.5, 0.5, 0.0];

/// What half the distance leaves at a kink of what a node misses.
const LEFT: f64 = 0.5;

/// Nodes from which others follow lie no farther apart than this angle (rad), about the sun's diameter, nor than so many
/// pixels: more save next to nothing.
const SMOOTH_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
const FARTHEST_PX: i32 = 8;

/// The most that a sum may miss, over what a pixel may err by before it gets more rays.
pub(crate) const OF_TOLERANCE: f64 = 0.25;

/// Nodes that are made at a time by a thread.
const TOGETHER: usize = 16;

/// A place in the frame, column and row.
type Place = (i32, i32);

/// A pixel that others may follow from.
#[derive(Clone)]
struct Node {
    pixel: Pixel,
    /// What its ray meets, where that is an open place.
    met: Option<Met>,
    /// Where its ray ends (m).
    surface_m: f64,
    /// What a sum over nodes twice as far apart misses of it; infinite where there was none to compare with.
    missed_cd_m2: f64,
    is_lit: bool,
}

/// Nodes that lie equally far apart, some rows of them.
struct Level {
    spacing_px: i32,
    /// How far from a pixel its nodes may lie, and theirs (px).
    reach_px: i32,
    /// The columns of all rows, counted in nodes.
    columns: Range<i32>,
    /// By row, counted in nodes.
    rows: BTreeMap<i32, Vec<Node>>,
}

/// Lattices of nodes around the pixels of a region.
pub(crate) struct RayLattice {
    /// The coarsest first; none where each pixel has a ray of its own.
    levels: Vec<Level>,
}

impl RayLattice {
    /// Lattices for a region, without nodes.
    pub(crate) fn over(tracer: &RayTracer, region: PixelRegion) -> Self {
        let farthest_px = tracer.farthest_nodes_px();
        let mut levels = Vec::new();
        // Those of the coarsest are what the others are compared with: alone it saves nothing.
        if farthest_px == 1 {
            return Self { levels };
        }
        let columns = region.x_px..region.x_px.saturating_add_unsigned(region.width_px);
        let (mut spacing_px, mut reach_px) = (2, 0);
        while spacing_px <= 2 * farthest_px {
            reach_px += 3 * spacing_px / 2;
            levels.push(Level {
                spacing_px,
                reach_px,
                columns: around(columns.clone(), reach_px, spacing_px),
                rows: BTreeMap::new(),
            });
            spacing_px *= 2;
        }
        levels.reverse();
        Self { levels }
    }

    /// Make the nodes that rows of pixels follow from, and forget those above.
    pub(crate) fn reach(&mut self, tracer: &RayTracer, rows: &Range<i32>) {
        for index in 0..self.levels.len() {
            let (coarser, finer) = self.levels.split_at_mut(index);
            let level = &mut finer[0];
            let wanted = around(rows.clone(), level.reach_px, level.spacing_px);
            level.rows.retain(|row, _| wanted.contains(row));
            let missing: Vec<i32> = wanted.filter(|it| !level.rows.contains_key(it)).collect();
            let columns: Vec<i32> = level.columns.clone().collect();
            let parts: Vec<(i32, &[i32])> = (missing.iter())
                .flat_map(|row| columns.chunks(TOGETHER).map(|part| (*row, part)))
                .collect();
            let spacing_px = level.spacing_px;
            let nodes: Vec<Vec<Node>> = parts
                .par_iter()
                .map_init(
                    || Room::new(tracer),
                    |room, (row, columns)| {
                        let place = |column: &i32| (column * spacing_px, row * spacing_px);
                        let columns = columns.iter().map(place);
                        let node = |place| tracer.node(coarser.last(), place, room);
                        columns.map(node).collect()
                    },
                )
                .collect();
            for ((row, _), part) in parts.into_iter().zip(nodes) {
                level.rows.entry(row).or_default().extend(part);
            }
        }
    }

    /// Leave a pixel of the rows that were reached in a room; whether it has light.
    pub(crate) fn pixel(&self, tracer: &RayTracer, place: Place, room: &mut Room) -> bool {
        match self.levels.last() {
            None => tracer.trace_pixel(f64::from(place.0), f64::from(place.1), room),
            Some(finest) => match finest.node(place) {
                Some(node) => {
                    room.pixel.clone_from(&node.pixel);
                    room.surface_m = node.surface_m;
                    node.is_lit
                }
                None => tracer.leave(Some(finest), place, room).is_lit,
            },
        }
    }
}

/// Rows or columns of nodes, counted in nodes, that lie no farther from pixels than a reach.
fn around(pixels: Range<i32>, reach_px: i32, spacing_px: i32) -> Range<i32> {
    let first = pixels.start.saturating_sub(reach_px);
    let last = (pixels.end - 1).saturating_add(reach_px);
    -((-first).div_euclid(spacing_px))..last.div_euclid(spacing_px) + 1
}

/// Nodes along an axis that a place follows from: where the first stands, and how many there are.
#[derive(Clone, Copy)]
struct Along {
    first_px: i32,
    n: usize,
}

impl Along {
    fn of(place_px: i32, spacing_px: i32) -> Self {
        if place_px.rem_euclid(spacing_px) == 0 {
            return Self {
                first_px: place_px,
                n: 1,
            };
        }
        Self {
            first_px: place_px - 3 * spacing_px / 2,
            n: CUBIC.len(),
        }
    }

    /// Weight of a node among them.
    fn weight(self, weights: [f32; 4], index: usize) -> f32 {
        if self.n == 1 { 1.0 } else { weights[index] }
    }

    /// Their numbers and where they stand.
    fn nodes(self, spacing_px: i32) -> impl Iterator<Item = (usize, i32)> {
        (0..self.n).map(move |index| (index, self.first_px + index as i32 * spacing_px))
    }

    /// Nodes that tell how a sum over these errs: themselves, or the three around the one.
    fn beside(self, spacing_px: i32) -> impl Iterator<Item = i32> {
        let (from, n) = if self.n == 1 { (-1, 3) } else { (0, 4) };
        (from..from + n).map(move |step| self.first_px + step * spacing_px)
    }
}

/// What is known of a sum over nodes.
#[derive(Clone, Copy)]
struct Sum {
    /// What it may err by.
    told_cd_m2: f64,
    is_lit: bool,
}

/// What is known of a pixel that was left in a room.
struct Left {
    met: Option<Met>,
    /// Of the sum that might stand for it.
    sum: Option<Sum>,
    is_sum: bool,
    is_lit: bool,
}

impl Level {
    fn node(&self, (x, y): Place) -> Option<&Node> {
        let spacing = self.spacing_px;
        if x.rem_euclid(spacing) != 0 || y.rem_euclid(spacing) != 0 {
            return None;
        }
        let row = self.rows.get(&y.div_euclid(spacing))?;
        let column = x.div_euclid(spacing) - self.columns.start;
        row.get(usize::try_from(column).ok()?)
    }

    /// What a sum over the nodes around a place tells where these and its own ray meet the same; `None` elsewhere.
    fn told(&self, place: Place, met: Option<Met>) -> Option<Sum> {
        met?;
        let spacing = self.spacing_px;
        let [across, down] = self.along(place);
        let (mut is_lit, mut has_primary, mut has_secondary) = (false, false, false);
        for (_, y) in down.nodes(spacing) {
            for (_, x) in across.nodes(spacing) {
                let node = self.node((x, y)).filter(|node| alike(node.met, met))?;
                is_lit |= node.is_lit;
                has_primary |= node.pixel.bow_primary != Vec4::ZERO;
                has_secondary |= node.pixel.bow_secondary != Vec4::ZERO;
            }
        }
        if has_primary && has_secondary {
            return None;
        }
        let missed = |place| {
            let node = self.node(place);
            node.map_or(f64::INFINITY, |it| it.missed_cd_m2)
        };
        let beside = down.beside(spacing);
        let beside = beside.flat_map(|y| across.beside(spacing).map(move |x| (x, y)));
        let told_cd_m2 = beside.map(missed).fold(0.0, f64::max);
        Some(Sum { told_cd_m2, is_lit })
    }

    /// Leave the sum over the nodes around a place.
    fn sum(&self, place: Place, sum: &mut Pixel) {
        let [across, down] = self.along(place);
        sum.clear();
        for (row, y) in down.nodes(self.spacing_px) {
            for (column, x) in across.nodes(self.spacing_px) {
                if let Some(node) = self.node((x, y)) {
                    let weight = |of: [f32; 4]| across.weight(of, column) * down.weight(of, row);
                    sum.add_pixel(&node.pixel, weight(CUBIC), weight(LINEAR));
                }
            }
        }
        sum.keep_positive();
    }

    /// The nodes around a place, across and down.
    fn along(&self, (x, y): Place) -> [Along; 2] {
        [x, y].map(|at_px| Along::of(at_px, self.spacing_px))
    }
}

impl RayTracer<'_> {
    /// The largest power of two of pixels by which nodes lie apart, and 1 where each pixel needs rays of its own.
    pub(crate) fn farthest_nodes_px(&self) -> i32 {
        let has_own_rays = matches!(self.footprint, PixelFootprint::Grid { .. });
        if has_own_rays || self.most_missed_cd_m2 <= 0.0 {
            return 1;
        }
        let powers = std::iter::successors(Some(1), |px| Some(2 * px));
        let is_near =
            |px: &i32| *px <= FARTHEST_PX && f64::from(*px) * self.pixel_rad <= SMOOTH_RAD;
        powers.take_while(is_near).last().unwrap_or(1)
    }

    /// The node at a place, which is that of a coarser lattice or follows from its nodes where it can.
    fn node(&self, coarser: Option<&Level>, place: Place, room: &mut Room) -> Node {
        if let Some(node) = coarser.and_then(|coarser| coarser.node(place)) {
            let missed_cd_m2 = LEFT * node.missed_cd_m2;
            return Node {
                // Where nothing is known those beside it tell.
                missed_cd_m2: if missed_cd_m2.is_finite() {
                    missed_cd_m2
                } else {
                    0.0
                },
                ..node.clone()
            };
        }
        let left = self.leave(coarser, place, room);
        let missed_cd_m2 = match (coarser, left.sum) {
            (Some(_), Some(sum)) if left.is_sum => sum.told_cd_m2,
            (Some(coarser), Some(_)) => {
                coarser.sum(place, &mut room.between);
                room.pixel.differs(&room.between, self.most_missed_cd_m2)
            }
            _ => f64::INFINITY,
        };
        Node {
            pixel: room.pixel.clone(),
            met: left.met,
            surface_m: room.surface_m,
            missed_cd_m2,
            is_lit: left.is_lit,
        }
    }

    /// Leave a pixel in a room, by a ray or by the nodes of a lattice.
    fn leave(&self, coarser: Option<&Level>, place: Place, room: &mut Room) -> Left {
        let (x, y) = (f64::from(place.0), f64::from(place.1));
        let sight = self.eye.sight(x + 0.5, y + 0.5);
        let in_water = |sight| self.frame.sights_in_water(sight);
        let in_water = sight.as_ref().map_or(Vec::new(), in_water);
        let in_the_open = |sight: &Sight| Met::in_the_open(sight, &in_water, &self.frame);
        let met = sight.as_ref().and_then(in_the_open);
        let sum = coarser.and_then(|level| level.told(place, met));
        if let (Some(known), Some(sight), Some(level)) = (sum, &sight, coarser)
            && known.told_cd_m2 <= self.most_missed_cd_m2
            && f64::from(level.spacing_px) <= self.voxel_px(sight, &in_water, met)
        {
            level.sum(place, &mut room.pixel);
            let quadrature = &mut room.pixel.errors.quadrature;
            *quadrature = together(&[*quadrature, known.told_cd_m2]);
            room.surface_m = sight.surface_m;
            let (is_sum, is_lit) = (true, known.is_lit);
            return Left {
                met,
                sum,
                is_sum,
                is_lit,
            };
        }
        let (is_sum, is_lit) = (false, self.trace_sight(sight, (x, y), room));
        Left {
            met,
            sum,
            is_sum,
            is_lit,
        }
    }

    /// How large voxels look where drops end on a sight and in water at its end, and their shadow on the ground and on
    /// water that shows the sun, pixels: the finest; infinite where there are none.
    fn voxel_px(&self, sight: &Sight, in_water: &[Sight], met: Option<Met>) -> f64 {
        let frame = &self.frame;
        let shadow = match sight.foot {
            Some(foot) => met.is_some_and(Met::shows_sun).then(|| OnGround {
                distance_m: sight.surface_m,
                sine: -foot.up.dot(sight.ray.direction),
            }),
            None => frame.shadow_of_drops(&sight.ray),
        };
        let shadow_m = shadow.map(|it| it.distance_m / it.sine);
        let looks_px = |drops: &Bricks| {
            let (min, max) = drops.world_bounds()?;
            // Nodes lie up to one and a half steps aside, and a step may look as large as a voxel.
            let margin_m = 1.5 * drops.voxel_m();
            let bounds = Aabb {
                min: min - margin_m,
                max: max + margin_m,
            };
            let among_drops = |sight: &Sight| {
                let (_, leave_m) = bounds.intersect(&sight.ray)?;
                let (_, last_m) = frame.range_m(sight)?;
                Some(leave_m.min(last_m))
            };
            let mirrored = in_water.iter();
            let mirrored = mirrored.filter_map(|it| Some(sight.surface_m + among_drops(it)?));
            let apart_m = among_drops(sight).into_iter().chain(mirrored);
            let farthest_m = apart_m.chain(shadow_m).fold(0.0, f64::max);
            Some(drops.voxel_m() / (farthest_m * self.pixel_rad))
        };
        let all_px = self.drops.iter().filter_map(looks_px);
        all_px.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_for_cubic_polynomials() {
        let light = |x: f64| 2.0 - 3.0 * x + 0.5 * x * x - 0.25 * x * x * x;
        for spacing_px in [2, 4, 8, 16] {
            for half in [-7, -1, 1, 3, 101] {
                let place_px = half * spacing_px / 2;
                let nodes = Along::of(place_px, spacing_px);
                let at = |px: i32| f64::from(px) / 50.0;
                let terms = nodes.nodes(spacing_px).map(|(index, px)| {
                    assert_eq!(px.rem_euclid(spacing_px), 0);
                    f64::from(nodes.weight(CUBIC, index)) * light(at(px))
                });
                let (sum, expected) = (terms.sum::<f64>(), light(at(place_px)));
                assert!(
                    (sum - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                    "{spacing_px} {place_px}"
                );
            }
        }
    }

    #[test]
    fn a_node_stands_for_itself_and_those_beside_it_tell() {
        let nodes = Along::of(-12, 4);
        assert_eq!(nodes.nodes(4).collect::<Vec<_>>(), [(0, -12)]);
        assert_eq!(nodes.weight(CUBIC, 0), 1.0);
        assert_eq!(nodes.beside(4).collect::<Vec<_>>(), [-16, -12, -8]);
        let between = Along::of(-10, 4);
        assert_eq!(between.beside(4).collect::<Vec<_>>(), [-16, -12, -8, -4]);
    }

    #[test]
    fn lattices_reach_all_that_pixels_follow_from() {
        // Places of the next finer lattice within the reach of its own have their nodes within this one's.
        let mut finer_px = 0;
        for spacing_px in [2, 4, 8, 16] {
            let reach_px = finer_px + 3 * spacing_px / 2;
            for start in [-33, -8, 0, 5] {
                let pixels = start..start + 7;
                let nodes = around(pixels.clone(), reach_px, spacing_px);
                for place_px in pixels.start - finer_px..pixels.end + finer_px {
                    if place_px.rem_euclid(spacing_px / 2) == 0 {
                        let along = Along::of(place_px, spacing_px);
                        let mut needed = along
                            .nodes(spacing_px)
                            .map(|it| it.1)
                            .chain(along.beside(spacing_px));
                        assert!(needed.all(|px| nodes.contains(&px.div_euclid(spacing_px))));
                    }
                }
            }
            finer_px = reach_px;
        }
    }
}
