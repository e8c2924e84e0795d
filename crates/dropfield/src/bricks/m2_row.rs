//! M2 at points of a row along an axis.
//!
//! On such a row the place between the nodes is the same along the two other axes. So a brick's 9 nodes
//! of the row are interpolated once, and each point between them is linear in two of these.

use glam::DVec3;
use glam::IVec3;

use super::BRICK_DIM;
use super::BRICK_NODES;
use super::Bricks;
use super::Interpolation;
use super::NO_BRICK;
use super::STRIDE_X;
use super::STRIDE_Y;
use super::cell_base;
use super::lerp;

/// Points along an axis, in voxels from node 0.
#[derive(Clone, Copy)]
struct Row {
    axis: usize,
    start: DVec3,
    step: f64,
}

/// The points of a row that lie in one brick.
#[derive(Clone, Copy)]
struct RowInBrick {
    row: Row,
    /// Number of the first of them in the row.
    first: usize,
    /// The row's lowest cell in the brick, and the place of its lowest corner there.
    low: IVec3,
    base: usize,
}

impl Bricks {
    /// Add M2 (um²/m³) at the points `start + i step_m` along an axis to each of `sums`; to rounding
    /// that of [`Bricks::m2`]. `step_m` is above 0.
    pub fn add_m2_in_row(&self, start: DVec3, axis: usize, step_m: f64, sums: &mut [f64]) {
        let row = Row {
            axis,
            start: self.to_lattice(start),
            step: step_m * self.inverse_voxel_m,
        };
        let size = (self.n_slots * BRICK_DIM).as_dvec3();
        let inside = |axis: usize| (0.0..size[axis]).contains(&row.start[axis]);
        let beside = !(inside((axis + 1) % 3) && inside((axis + 2) % 3));
        if beside || row.start.is_nan() {
            return;
        }
        // Numbers below 0 convert to 0.
        let mut next = row.n_before(0.0);
        while next < sums.len() {
            let along = row.at(next);
            if along >= size[axis] {
                return;
            }
            let mut cell = row.start.as_ivec3();
            cell[axis] = along as i32 & -BRICK_DIM;
            let brick_end = f64::from(cell[axis] + BRICK_DIM);
            let end = row.n_before(brick_end).clamp(next + 1, sums.len());
            let brick = self.brick_of(cell);
            if brick != NO_BRICK {
                let part = RowInBrick {
                    row,
                    first: next,
                    low: cell,
                    base: cell_base(brick, cell),
                };
                self.add_in_brick(part, &mut sums[next..end]);
            }
            next = end;
        }
    }

    /// At the points of one brick.
    fn add_in_brick(&self, part: RowInBrick, sums: &mut [f64]) {
        let RowInBrick {
            row,
            first,
            low,
            base,
        } = part;
        let Row { axis, start, .. } = row;
        let mut local = (start - low.as_dvec3()).as_vec3();
        // Cell within the brick, and the place in it.
        let place = |index: usize| {
            let along = row.at(first + index) - f64::from(low[axis]);
            let cell = (along as usize).min(BRICK_NODES - 2);
            (cell, (along - cell as f64) as f32)
        };
        match self.interpolation {
            Interpolation::Moments => {
                let m2 = &self.m2[base..];
                let nodes = match axis {
                    0 => nodes_in_row::<STRIDE_X, STRIDE_Y, 1>(m2, local.y, local.z),
                    1 => nodes_in_row::<STRIDE_Y, STRIDE_X, 1>(m2, local.x, local.z),
                    _ => nodes_in_row::<1, STRIDE_X, STRIDE_Y>(m2, local.x, local.y),
                };
                for (index, sum) in sums.iter_mut().enumerate() {
                    let (cell, along) = place(index);
                    *sum += f64::from(lerp(nodes[cell], nodes[cell + 1], along));
                }
            }
            Interpolation::RadiusDensity => {
                let stride = [STRIDE_X, STRIDE_Y, 1][axis];
                for (index, sum) in sums.iter_mut().enumerate() {
                    let cell;
                    (cell, local[axis]) = place(index);
                    let sample = self.sample_cell(base + cell * stride, local);
                    *sum += f64::from(sample.m2);
                }
            }
        }
    }
}

impl Row {
    fn at(&self, index: usize) -> f64 {
        self.start[self.axis] + index as f64 * self.step
    }

    /// Points before a place.
    fn n_before(&self, place: f64) -> usize {
        ((place - self.start[self.axis]) / self.step).ceil() as usize
    }
}

/// The field on a brick's edge-to-edge line, at the places of the nodes. `ALONG`, `FIRST` and `SECOND`
/// are distances in memory of nodes along the line and along the two axes across it.
#[inline]
fn nodes_in_row<const ALONG: usize, const FIRST: usize, const SECOND: usize>(
    m2: &[f32],
    first: f32,
    second: f32,
) -> [f32; BRICK_NODES] {
    let m2 = &m2[..=(BRICK_NODES - 1) * ALONG + FIRST + SECOND];
    std::array::from_fn(|node| {
        let low = node * ALONG;
        let edge = |low: usize| lerp(m2[low], m2[low + FIRST], first);
        lerp(edge(low), edge(low + SECOND), second)
    })
}
