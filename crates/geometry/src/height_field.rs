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
mod walk;

use glam::DVec2;
use glam::DVec3;

use self::walk::Block;
use self::walk::Walk;
use crate::aabb::Aabb;
use crate::error::Error;
use crate::mesh_triangle::ShearedRay;
use crate::ray::Ray;

/// Part of a height by which rounding may move where a ray is.
const SLACK: f64 = 16.0 * f64::EPSILON;

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
    /// From blocks of 2 x 2 cells to the one that holds all.
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

    /// Columns and rows of nodes.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.map.size
    }

    /// Distance of neighbors (m).
    #[must_use]
    pub fn spacing_m(&self) -> f64 {
        self.map.spacing_m
    }

    /// The nodes by column and row of the triangle above or below a point, with their barycentric weights there.
    #[must_use]
    pub fn nodes_around(&self, point: DVec3) -> [((usize, usize), f64); 3] {
        let ((x, right), (z, down)) = self.place(point);
        let [a, d] = [(x, z), (x + 1, z + 1)];
        if down >= right {
            [(a, 1.0 - down), ((x, z + 1), down - right), (d, right)]
        } else {
            [(a, 1.0 - right), ((x + 1, z), right - down), (d, down)]
        }
    }

    /// The smallest box around the field.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let (n_x, n_z) = self.map.size;
        let [low_m, high_m] = self.range_m(self.whole());
        let at = |x, z, height_m| self.at(x, z).with_y(height_m);
        Aabb {
            min: at(0, 0, low_m),
            max: at(n_x - 1, n_z - 1, high_m),
        }
    }

    /// The nearest point of the surface farther along the ray than `after_m`.
    #[must_use]
    pub fn nearest(&self, ray: &Ray, after_m: f64) -> Option<HeightHit> {
        let (distance_m, corners, is_from_below) = self.search(ray, after_m)?;
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
        self.search(ray, after_m).is_some()
    }

    /// Distance, triangle, and whether it is met from below.
    fn search(&self, ray: &Ray, after_m: f64) -> Option<(f64, [DVec3; 3], bool)> {
        let sheared = ShearedRay::new(ray)?;
        let line = [ray.origin, ray.direction].map(|it| DVec2::new(it.x, it.z));
        let (start_m, rise) = (ray.origin.y, ray.direction.y);
        let [lowest_m, highest_m] = self.range_m(self.whole());
        let mut walk = Walk::new(self, line, after_m)?;
        loop {
            // Rounding of the distances and of the height moves these by less.
            let [enter_m, leave_m] = [walk.enter(), walk.leave()].map(|it| rise * it);
            let slack_m = SLACK * (start_m.abs() + enter_m.abs().max(leave_m.abs()));
            let top_m = start_m + enter_m.max(leave_m) + slack_m;
            let bottom_m = start_m + enter_m.min(leave_m) - slack_m;
            let is_gone = if rise < 0.0 {
                top_m < lowest_m
            } else {
                bottom_m > highest_m
            };
            if is_gone {
                return None;
            }
            let [low_m, high_m] = self.range_m(walk.block());
            let may_meet = bottom_m <= high_m && top_m >= low_m;
            let by_corner = walk.leaves_by_corner();
            if walk.block().level > 0 && (may_meet || by_corner) {
                walk.open();
                continue;
            }
            let own = may_meet.then(|| walk.block());
            let beside = if by_corner {
                walk.neighbors()
            } else {
                [None; 2]
            };
            let cells = own.into_iter().chain(beside.into_iter().flatten());
            let mut best: Option<(f64, [DVec3; 3], bool)> = None;
            for triangle in cells.flat_map(|cell| self.triangles(cell)) {
                let Some((distance_m, is_from_below)) = sheared.meet(triangle) else {
                    continue;
                };
                let is_nearer = best.is_none_or(|(nearest_m, ..)| distance_m < nearest_m);
                if distance_m > after_m && is_nearer {
                    best = Some((distance_m, triangle, is_from_below));
                }
            }
            if best.is_some() || !walk.pass() {
                return best;
            }
        }
    }

    /// The block that holds all.
    fn whole(&self) -> Block {
        Block {
            level: self.levels.len() as u32,
            place: [0; 2],
        }
    }

    /// Smallest and largest height of a block (m).
    #[inline]
    fn range_m(&self, block: Block) -> [f64; 2] {
        let [x, z] = block.place.map(|place| place as usize);
        let corner_m = self.map.corner.y;
        if block.level == 0 {
            let [a, b, c, d] = self.heights_m(block);
            return [
                corner_m + a.min(b).min(c.min(d)),
                corner_m + a.max(b).max(c.max(d)),
            ];
        }
        let level = &self.levels[block.level as usize - 1];
        let (low_m, high_m) = level.range_m[z * level.size.0 + x];
        [corner_m + f64::from(low_m), corner_m + f64::from(high_m)]
    }

    /// The two triangles of a cell.
    fn triangles(&self, cell: Block) -> [[DVec3; 3]; 2] {
        let [x, z] = cell.place.map(|place| place as usize);
        let [a, b] = [self.node(x, z), self.node(x + 1, z)];
        let [c, d] = [self.node(x, z + 1), self.node(x + 1, z + 1)];
        [[a, c, d], [a, d, b]]
    }

    /// Heights of its corners a, b, c, d over that of the corner of the field (m).
    #[inline]
    fn heights_m(&self, cell: Block) -> [f64; 4] {
        let [x, z] = cell.place.map(|place| place as usize);
        let n_x = self.map.size.0;
        let north = z * n_x + x;
        let rows = &self.map.height_m[north..north + n_x + 2];
        [rows[0], rows[1], rows[n_x], rows[n_x + 1]].map(f64::from)
    }

    /// The node of a column and a row.
    ///
    /// # Panics
    /// Where there is none.
    #[must_use]
    pub fn node(&self, x: usize, z: usize) -> DVec3 {
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

    /// Column and row of the cell at a point, and how far in it.
    fn place(&self, point: DVec3) -> ((usize, f64), (usize, f64)) {
        let from = (point - self.map.corner) / self.map.spacing_m;
        let along = |at: f64, n: usize| {
            let cell = (at.max(0.0) as usize).min(n - 2);
            (cell, (at - cell as f64).clamp(0.0, 1.0))
        };
        let (n_x, n_z) = self.map.size;
        (along(from.x, n_x), along(from.z, n_z))
    }

    /// Unit normal of the smooth surface above or below a point.
    #[must_use]
    pub fn smooth_normal(&self, point: DVec3) -> DVec3 {
        let ((x, right), (z, down)) = self.place(point);
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
        Self::of_blocks((n_x - 1, n_z - 1), |xs, zs| {
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
            Self::of_blocks(self.size, |xs, zs| {
                let rows = (zs.0..zs.1).map(|z| &self.range_m[z * n_x + xs.0..z * n_x + xs.1]);
                rows.flatten().copied().reduce(wider)
            })
        })
    }

    /// Blocks of 2 x 2 of `n` cells, whose ranges are told by their first cells and those after their last.
    fn of_blocks(
        n: (usize, usize),
        range: impl Fn((usize, usize), (usize, usize)) -> Option<(f32, f32)>,
    ) -> Self {
        let size = (n.0.div_ceil(2), n.1.div_ceil(2));
        let ends = |place: usize, n: usize| (2 * place, (2 * place + 2).min(n));
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
