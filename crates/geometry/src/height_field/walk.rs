//! The blocks of a field along a line, seen from above, nearest first.
//!
//! A block in which nothing that is looked for can lie is passed: the line goes on in the block behind it, or in that
//! of twice the size where one begins there. Another is opened: the line goes on in the quarter of it where it is.
//! Nothing waits, and every distance is that of a line of nodes, computed one way: what leaves a block enters the next.

use glam::DVec2;

use super::HeightField;
use super::HeightMap;

/// Steepest of what a line may be across lines of nodes: others run along them, without infinities.
const STEEPEST: f64 = 1e200;

/// Distances that are nearer to each other than this part of them may be the same.
const SAME: f64 = 16.0 * f64::EPSILON;

/// Part of a cell by which a line along the last nodes is taken to lie within the field.
const INWARDS: f64 = 1e-9;

/// 2^level x 2^level cells, or what the field has of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) level: u32,
    /// Columns and rows of blocks of its size.
    // u32: files of heights have at most 2^31.
    pub(super) place: [u32; 2],
}

/// A way through a field, of which one block is looked at.
pub(super) struct Walk {
    /// Columns and rows of cells.
    n_cells: [u32; 2],
    n_levels: u32,
    corner: [f64; 2],
    spacing_m: f64,
    from: [f64; 2],
    inverse: [f64; 2],
    is_forward: [bool; 2],
    block: Block,
    /// Distance at which the line enters the block, in lengths of its direction.
    enter: f64,
    /// Distances at which it crosses the last column and row of nodes of the block.
    ends: [f64; 2],
}

impl Walk {
    /// The way along a line from a distance on, at the block that holds all; `None` where it passes by the field.
    pub(super) fn new(field: &HeightField, [from, along]: [DVec2; 2], after: f64) -> Option<Self> {
        let HeightMap {
            size: (n_x, n_z),
            corner,
            spacing_m,
            ..
        } = field.map;
        let n_cells = [n_x, n_z].map(|n| n as u32 - 1);
        // Without -0.
        let along = along + DVec2::ZERO;
        let steepest = DVec2::splat(STEEPEST);
        let block = field.whole();
        let mut walk = Self {
            n_cells,
            n_levels: block.level,
            corner: [corner.x, corner.z],
            spacing_m,
            from: from.to_array(),
            inverse: along.recip().clamp(-steepest, steepest).to_array(),
            is_forward: along.cmpge(DVec2::ZERO).into(),
            block,
            enter: after,
            ends: [0.0; 2],
        };
        for axis in 0..2 {
            if along[axis] == 0.0 && walk.distance(axis, n_cells[axis]) == 0.0 {
                walk.from[axis] -= INWARDS * spacing_m;
            }
            let first = if walk.is_forward[axis] {
                0
            } else {
                n_cells[axis]
            };
            walk.enter = walk.enter.max(walk.distance(axis, first));
            walk.find_end(axis);
        }
        (walk.enter <= walk.leave()).then_some(walk)
    }

    /// The block.
    pub(super) fn block(&self) -> Block {
        self.block
    }

    /// Distance at which the line enters the block.
    pub(super) fn enter(&self) -> f64 {
        self.enter
    }

    /// Distance at which the line leaves the block.
    pub(super) fn leave(&self) -> f64 {
        self.ends[0].min(self.ends[1])
    }

    /// Whether the line leaves the block by a corner, to within rounding: it may as well go by the block at one side of
    /// that as by the one at the other.
    #[inline]
    pub(super) fn leaves_by_corner(&self) -> bool {
        (self.ends[0] - self.ends[1]).abs() <= SAME * self.leave().abs()
    }

    /// The blocks next to it forward, along either axis; `None` where the field ends.
    pub(super) fn neighbors(&self) -> [Option<Block>; 2] {
        [0, 1].map(|axis| self.behind(axis))
    }

    /// Go on behind the block; whether the field goes on there.
    #[inline]
    pub(super) fn pass(&mut self) -> bool {
        let axis = self.next_axis();
        let Some(next) = self.behind(axis) else {
            return false;
        };
        self.enter = self.ends[axis];
        let has_same_parent = next.place[axis] >> 1 == self.block.place[axis] >> 1;
        self.block = next;
        if has_same_parent || next.level == self.n_levels {
            self.find_end(axis);
        } else {
            self.block.level += 1;
            self.block.place = next.place.map(|place| place >> 1);
            self.find_end(0);
            self.find_end(1);
        }
        true
    }

    /// Look into a block that is no cell.
    #[inline]
    pub(super) fn open(&mut self) {
        let level = self.block.level - 1;
        self.block.level = level;
        for axis in 0..2 {
            let first = self.block.place[axis] << 1;
            let middle = (first + 1) << level;
            let middle_end = self.distance(axis, middle);
            let has_second = middle < self.n_cells[axis];
            let is_behind = self.enter >= middle_end;
            let is_second = has_second && is_behind == self.is_forward[axis];
            self.block.place[axis] = first + u32::from(is_second);
            if has_second && !is_behind {
                self.ends[axis] = middle_end;
            }
        }
    }

    #[inline]
    fn next_axis(&self) -> usize {
        usize::from(self.ends[1] < self.ends[0])
    }

    #[inline]
    fn behind(&self, axis: usize) -> Option<Block> {
        let mut block = self.block;
        let place = block.place[axis];
        block.place[axis] = if self.is_forward[axis] {
            place + 1
        } else {
            place.wrapping_sub(1)
        };
        let last = (self.n_cells[axis] - 1) >> block.level;
        (block.place[axis] <= last).then_some(block)
    }

    #[inline]
    fn find_end(&mut self, axis: usize) {
        let Block { level, place } = self.block;
        let node = (place[axis] + u32::from(self.is_forward[axis])) << level;
        self.ends[axis] = self.distance(axis, node.min(self.n_cells[axis]));
    }

    /// Distance at which the line crosses a column or row of nodes.
    #[inline]
    fn distance(&self, axis: usize, node: u32) -> f64 {
        // As nodes are placed, to the last bit.
        let place = self.corner[axis] + self.spacing_m * f64::from(node);
        (place - self.from[axis]) * self.inverse[axis]
    }
}
