//! The horizon that heights make.
//!
//! tan e = max over d of (h(d) - y)/d
//! `d` horizontal distance along an azimuth, `h` height of the surface there, `y` that of the eye. Between the edges of
//! triangles h is linear in d and the slope of the sight monotonic, so the largest stands at an edge. A block is passed
//! over where its greatest height at its nearest point is not above what was found.

use glam::DVec2;
use glam::DVec3;

use super::Block;
use super::HeightField;
use super::Walk;
use crate::level_look::LevelLook;

/// What is nearer is the place itself, cells.
const LEAST: f64 = 1e-6;

impl HeightField {
    /// Tangent of the elevation up to which the surface stands, from a point along a horizontal unit vector; `least`,
    /// which is not below 0, where it stands no higher than that.
    #[must_use]
    pub fn horizon(&self, from: DVec3, along: DVec3, least: f64) -> f64 {
        let from = (from - self.map.corner) / self.map.spacing_m;
        let along = DVec2::new(along.x, along.z);
        let look = LevelLook::new(DVec2::new(from.x, from.z), along);
        let mut slope = least;
        let mut walk = Walk::through(self, along);
        while let Some(block) = walk.next() {
            let (_, high_m) = self.range_m(block);
            let rise = f64::from(high_m) / self.map.spacing_m - from.y;
            let (low, high) = self.nodes_of(block);
            let enter = look.within(low, high).map(|(enter, _)| enter);
            if enter.is_none_or(|enter| rise <= slope * enter) {
                continue;
            }
            if block.level > 0 {
                walk.look_into(block, self.levels[block.level - 1].size);
                continue;
            }
            let (xs, zs) = self.cells(block);
            for z in zs {
                for x in xs.clone() {
                    slope = slope.max(self.slope_in(&look, from.y, (x, z)));
                }
            }
        }
        slope
    }

    /// First and last node of a block, in cells.
    fn nodes_of(&self, block: Block) -> (DVec2, DVec2) {
        let ([x, z], [right, below]) = self.corners(block);
        (
            DVec2::new(x as f64, z as f64),
            DVec2::new(right as f64, below as f64),
        )
    }

    /// Largest slope of the sights to the surface within a cell.
    fn slope_in(&self, look: &LevelLook, y: f64, (x, z): (usize, usize)) -> f64 {
        let corner = DVec2::new(x as f64, z as f64);
        let Some((enter, leave)) = look.within(corner, corner + 1.0) else {
            return 0.0;
        };
        let height = |x, z| f64::from(self.height_m(x, z)) / self.map.spacing_m - y;
        let [a, b] = [height(x, z), height(x + 1, z)];
        let [c, d] = [height(x, z + 1), height(x + 1, z + 1)];
        let start = look.from - corner;
        // Where it crosses the diagonal from north-west to south-east.
        let diagonal = (start.y - start.x) / (look.along.x - look.along.y);
        let slope = |distance: f64| {
            let DVec2 { x: right, y: down } = start + distance * look.along;
            let rise = if down >= right {
                a + down * (c - a) + right * (d - c)
            } else {
                a + right * (b - a) + down * (d - b)
            };
            rise / distance
        };
        let is_seen = |it: &f64| *it > LEAST && *it >= enter && *it <= leave;
        let edges = [enter, diagonal, leave].into_iter().filter(is_seen);
        edges.map(slope).fold(0.0, f64::max)
    }
}
