//! Heights on a lattice as a surface: where a ray meets it, without a mesh.
//!
//! Four neighbors a (north-west), b (north-east), c (south-west), d (south-east) make the triangles a c d and
//! a d b, which rays meet as those of a mesh, without gaps. Smallest and largest heights stand in a pyramid
//! over blocks of 2 x 2 cells: a ray looks into a block only if it meets the box of its heights.
//! [TIS08] A. Tevs, I. Ihrke, H.-P. Seidel, Proc. Symposium on Interactive 3D Graphics and Games, 183-190 (2008):
//! the pyramid, there of maxima alone.
//!
//! Light sees a smooth surface: gradients by central differences at the nodes, linear along both axes between.

mod horizon;

use std::ops::Range;

use glam::DVec2;
use glam::DVec3;

use crate::aabb::Aabb;
use crate::error::Error;
use crate::mesh_bvh::Wanted;
use crate::mesh_triangle::ShearedRay;
use crate::ray::Ray;
use crate::slabs::Slabs;

/// Cells along a side of the smallest blocks.
const BLOCK: usize = 2;

/// Blocks that wait: three a level, of which 2^64 cells have 31.
const MAX_WAITING: usize = 96;

/// Heights by row from the north and column from the west, and where they lie.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Row by row, over the height of the corner (m).
    // f32: 64 MiB for 4096 x 4096.
    pub height_m: Vec<f32>,
    /// Distance of neighbors (m).
    pub spacing_m: f64,
    /// Where height 0 of the first row and column lies (m).
    pub corner: DVec3,
}

/// A surface through heights, with what finds where rays meet it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    map: HeightMap,
    /// From the smallest blocks to the one that holds all.
    levels: Vec<Level>,
}

/// Smallest and largest heights of the blocks of a size, row by row.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: (usize, usize),
    range_m: Vec<(f32, f32)>,
}

/// Where a ray meets a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightHit {
    /// Distance from the origin of the ray, in lengths of its direction, m for a unit vector.
    pub distance_m: f64,
    /// Unit normal of the triangle, upwards.
    pub normal: DVec3,
    /// Unit normal of the smooth surface, upwards.
    pub smooth_normal: DVec3,
    /// Whether the ray comes from below.
    pub is_from_below: bool,
}

/// A block of a level.
#[derive(Clone, Copy)]
struct Block {
    level: usize,
    /// Columns and rows of blocks of its size.
    // u32: fields of 2^64 cells have no more, and a stack of them is set up for every ray.
    place: [u32; 2],
}

impl Block {
    fn x(self) -> usize {
        self.place[0] as usize
    }

    fn z(self) -> usize {
        self.place[1] as usize
    }
}

/// Blocks on a way that are still to be looked into, nearest first.
struct Walk {
    waiting: [Block; MAX_WAITING],
    n_waiting: usize,
    /// Of four children the one that the way comes from is looked at first.
    far: [u32; 2],
}

impl Walk {
    /// All of a field, along a horizontal direction.
    fn through(field: &HeightField, along: DVec2) -> Self {
        let far = along.cmpge(DVec2::ZERO);
        Self {
            waiting: [field.whole(); MAX_WAITING],
            n_waiting: 1,
            far: [u32::from(far.x), u32::from(far.y)],
        }
    }

    /// The nearest block that waits.
    fn next(&mut self) -> Option<Block> {
        self.n_waiting = self.n_waiting.checked_sub(1)?;
        Some(self.waiting[self.n_waiting])
    }

    /// Has the children of a block wait, by the number of columns and rows of their level.
    fn look_into(&mut self, block: Block, size: (usize, usize)) {
        let far = self.far;
        for (dx, dz) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let child = Block {
                level: block.level - 1,
                place: [
                    2 * block.place[0] + (far[0] ^ dx),
                    2 * block.place[1] + (far[1] ^ dz),
                ],
            };
            if child.x() < size.0 && child.z() < size.1 {
                self.waiting[self.n_waiting] = child;
                self.n_waiting += 1;
            }
        }
    }
}

impl HeightField {
    /// Finds the ranges of heights.
    ///
    /// # Errors
    /// Fewer than 2 x 2 heights, other than one for each place, or one that is not finite.
    pub fn new(map: HeightMap) -> Result<Self, Error> {
        let (n_x, n_z) = map.size;
        if n_x < 2 || n_z < 2 || n_x.checked_mul(n_z) != Some(map.height_m.len()) {
            return Err(Error::HeightCount { n_x, n_z });
        }
        if let Some(place) = map.height_m.iter().position(|height| !height.is_finite()) {
            let (x, z) = (place % n_x, place / n_x);
            return Err(Error::HeightNotFinite { x, z });
        }
        let mut levels = vec![Level::of_heights(&map)];
        while let Some(coarser) = levels.last().and_then(Level::coarser) {
            levels.push(coarser);
        }
        Ok(Self { map, levels })
    }

    /// The smallest box around the field.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds_of(self.whole())
    }

    /// The nearest point of the surface farther along the ray than `after_m`.
    #[must_use]
    pub fn nearest(&self, ray: &Ray, after_m: f64) -> Option<HeightHit> {
        let (distance_m, corners, is_from_below) = self.search(ray, after_m, Wanted::Nearest)?;
        let [a, b, c] = corners;
        Some(HeightHit {
            distance_m,
            normal: (b - a).cross(c - a).normalize(),
            smooth_normal: self.smooth_normal(ray.origin + distance_m * ray.direction),
            is_from_below,
        })
    }

    /// Whether the ray meets the surface farther along than `after_m`: what a shadow asks.
    #[must_use]
    pub fn is_met(&self, ray: &Ray, after_m: f64) -> bool {
        self.search(ray, after_m, Wanted::Any).is_some()
    }

    /// Distance, triangle, and whether it is met from below.
    fn search(&self, ray: &Ray, after_m: f64, wanted: Wanted) -> Option<(f64, [DVec3; 3], bool)> {
        let sheared = ShearedRay::new(ray)?;
        let slabs = Slabs::new(ray);
        let mut best: Option<(f64, [DVec3; 3], bool)> = None;
        let along = DVec2::new(ray.direction.x, ray.direction.z);
        let mut walk = Walk::through(self, along);
        while let Some(block) = walk.next() {
            let nearest_m = best.map_or(f64::INFINITY, |(distance_m, ..)| distance_m);
            if !slabs.meets(&self.bounds_of(block), after_m, nearest_m) {
                continue;
            }
            if block.level > 0 {
                walk.look_into(block, self.levels[block.level - 1].size);
                continue;
            }
            // Loops: iterators that hand over triangles took a third longer.
            let (xs, zs) = self.cells(block);
            for z in zs {
                let mut west = [self.node(xs.start, z), self.node(xs.start, z + 1)];
                for x in xs.clone() {
                    let east = [self.node(x + 1, z), self.node(x + 1, z + 1)];
                    let ([a, c], [b, d]) = (west, east);
                    west = east;
                    let around = Aabb {
                        min: a.min(b).min(c.min(d)),
                        max: a.max(b).max(c.max(d)),
                    };
                    if !slabs.meets(&around, after_m, f64::INFINITY) {
                        continue;
                    }
                    for triangle in [[a, c, d], [a, d, b]] {
                        let Some((distance_m, is_from_below)) = sheared.meet(triangle) else {
                            continue;
                        };
                        let is_nearer = best.is_none_or(|(nearest_m, ..)| distance_m < nearest_m);
                        if distance_m > after_m && is_nearer {
                            best = Some((distance_m, triangle, is_from_below));
                            if wanted == Wanted::Any {
                                return best;
                            }
                        }
                    }
                }
            }
        }
        best
    }

    /// The block that holds all.
    fn whole(&self) -> Block {
        Block {
            level: self.levels.len() - 1,
            place: [0; 2],
        }
    }

    /// Smallest and largest height of a block, over that of the corner (m).
    fn range_m(&self, block: Block) -> (f32, f32) {
        let level = &self.levels[block.level];
        level.range_m[block.z() * level.size.0 + block.x()]
    }

    /// Columns and rows of the cells of a smallest block.
    fn cells(&self, block: Block) -> (Range<usize>, Range<usize>) {
        let ends = |place: usize, n: usize| BLOCK * place..(BLOCK * (place + 1)).min(n - 1);
        let (n_x, n_z) = self.map.size;
        (ends(block.x(), n_x), ends(block.z(), n_z))
    }

    fn node(&self, x: usize, z: usize) -> DVec3 {
        let height_m = f64::from(self.height_m(x, z));
        self.at(x, z) + DVec3::Y * height_m
    }

    /// Where height 0 of a node lies.
    fn at(&self, x: usize, z: usize) -> DVec3 {
        self.map.corner + self.map.spacing_m * DVec3::new(x as f64, 0.0, z as f64)
    }

    fn height_m(&self, x: usize, z: usize) -> f32 {
        self.map.height_m[z * self.map.size.0 + x]
    }

    fn bounds_of(&self, block: Block) -> Aabb {
        let (low_m, high_m) = self.range_m(block);
        let ([x, z], [right, below]) = self.corners(block);
        Aabb {
            min: self.at(x, z) + DVec3::Y * f64::from(low_m),
            max: self.at(right, below) + DVec3::Y * f64::from(high_m),
        }
    }

    /// Columns and rows of the first and the last node of a block.
    fn corners(&self, block: Block) -> ([usize; 2], [usize; 2]) {
        let side = BLOCK << block.level;
        let end = |place: usize, n: usize| ((place + 1) * side).min(n - 1);
        let (n_x, n_z) = self.map.size;
        (
            [block.x() * side, block.z() * side],
            [end(block.x(), n_x), end(block.z(), n_z)],
        )
    }

    /// Unit normal of the smooth surface above a point.
    fn smooth_normal(&self, point: DVec3) -> DVec3 {
        let from = (point - self.map.corner) / self.map.spacing_m;
        let place = |at: f64, n: usize| {
            let cell = (at.max(0.0) as usize).min(n - 2);
            (cell, (at - cell as f64).clamp(0.0, 1.0))
        };
        let (n_x, n_z) = self.map.size;
        let ((x, right), (z, down)) = (place(from.x, n_x), place(from.z, n_z));
        let along = |z| self.gradient(x, z).lerp(self.gradient(x + 1, z), right);
        let gradient = along(z).lerp(along(z + 1), down);
        DVec3::new(-gradient.x, 1.0, -gradient.y).normalize()
    }

    /// Rise of the surface at a node, eastwards and southwards.
    fn gradient(&self, x: usize, z: usize) -> DVec2 {
        let around = |place: usize, n: usize| (place.saturating_sub(1), (place + 1).min(n - 1));
        let rise = |(low, high): (usize, usize), height_m: &dyn Fn(usize) -> f32| {
            let rise_m = f64::from(height_m(high)) - f64::from(height_m(low));
            rise_m / ((high - low) as f64 * self.map.spacing_m)
        };
        let (n_x, n_z) = self.map.size;
        DVec2::new(
            rise(around(x, n_x), &|x| self.height_m(x, z)),
            rise(around(z, n_z), &|z| self.height_m(x, z)),
        )
    }
}

impl Level {
    fn of_heights(map: &HeightMap) -> Self {
        let (n_x, n_z) = map.size;
        Self::of_blocks((n_x - 1, n_z - 1), BLOCK, |xs, zs| {
            // Blocks share the nodes of their borders.
            let rows = (zs.0..=zs.1).map(|z| &map.height_m[z * n_x + xs.0..=z * n_x + xs.1]);
            rows.flatten()
                .map(|height_m| (*height_m, *height_m))
                .reduce(wider)
        })
    }

    /// The blocks of twice the size; `None` for one that holds all.
    fn coarser(&self) -> Option<Self> {
        let (n_x, _) = self.size;
        (self.range_m.len() > 1).then(|| {
            Self::of_blocks(self.size, 2, |xs, zs| {
                let rows = (zs.0..zs.1).map(|z| &self.range_m[z * n_x + xs.0..z * n_x + xs.1]);
                rows.flatten().copied().reduce(wider)
            })
        })
    }

    /// Blocks of `side` x `side` of `n` cells, whose ranges are told by their first cells and those after their last.
    fn of_blocks(
        n: (usize, usize),
        side: usize,
        range: impl Fn((usize, usize), (usize, usize)) -> Option<(f32, f32)>,
    ) -> Self {
        let size = (n.0.div_ceil(side), n.1.div_ceil(side));
        let ends = |place: usize, n: usize| (place * side, ((place + 1) * side).min(n));
        let blocks = (0..size.1).flat_map(|z| (0..size.0).map(move |x| (x, z)));
        let ranges = blocks.filter_map(|(x, z)| range(ends(x, n.0), ends(z, n.1)));
        Self {
            size,
            range_m: ranges.collect(),
        }
    }
}

fn wider(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    (a.0.min(b.0), a.1.max(b.1))
}

#[cfg(test)]
#[path = "height_field_tests.rs"]
mod tests;
