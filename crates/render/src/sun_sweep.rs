//! Optical depth towards the sun on a regular lattice, swept layer by layer away from the sun.
//!
//! tau(x) = tau(x + d w) + int_0^d pi M2(x + s w) ds
//!
//! `w` unit vector towards the sun, `d` the distance at which the line from a node crosses the layer
//! of nodes that is next on the sun's side, along the axis on which `w` is largest. There tau is
//! interpolated bilinearly; on the way the integral takes two Gauss points a voxel of the drops.
//! So a node costs the same however deep the volume is. Each bilinear interpolation spreads a shadow's
//! edge by a variance of f (1 - f) voxels², 1/6 on the mean over positions f: after n layers by about
//! 0.4 sqrt(n) voxels. A sun along an axis has none of it.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use rayon::prelude::*;

use crate::error::Error;
use crate::piece::EXTINCTION_PER_M2;

/// 256 MiB of f32.
const MAX_NODES: f64 = (1_u64 << 26) as f64;

/// Stretches of a layer's crossing; beyond, the sweep's voxels are far coarser than the drops'.
const MAX_STRETCHES: f64 = 64.0;

/// Offsets of the two Gauss points from the middle of a stretch, in units of its length.
const GAUSS_OFFSET: f64 = 0.288_675_134_594_812_9;

/// Optical depth at Q = 1 on a lattice over the drops' box.
pub(crate) struct SunSweep {
    origin: DVec3,
    spacing_m: DVec3,
    n_nodes: [usize; 3],
    /// The swept axis, then the other two.
    axes: [usize; 3],
    /// [swept axis, second, third], the third fastest. f32: interpolated to 1e-4 at best.
    depths: Vec<f32>,
}

impl SunSweep {
    /// Sweep through all modes.
    ///
    /// # Errors
    /// [`Error::SunVolumeTooLarge`] if the lattice would need more than 2^26 nodes.
    pub(crate) fn through(
        bricks: &[Bricks],
        bounds: Aabb,
        sun_direction: DVec3,
        voxel_m: f64,
    ) -> Result<Self, Error> {
        let size = bounds.max - bounds.min;
        let n_cells = (size / voxel_m).ceil().max(DVec3::ONE);
        let total = (n_cells.x + 1.0) * (n_cells.y + 1.0) * (n_cells.z + 1.0);
        if total > MAX_NODES {
            let smallest_m = voxel_m * (total / MAX_NODES).cbrt();
            return Err(Error::SunVolumeTooLarge {
                found_m: voxel_m,
                smallest_m,
            });
        }
        let swept = sun_direction.abs().max_position();
        let axes = [swept, (swept + 1) % 3, (swept + 2) % 3];
        let n_nodes = n_cells.to_array().map(|cells| cells as usize + 1);
        let mut sweep = Self {
            origin: bounds.min,
            spacing_m: size / n_cells,
            n_nodes,
            axes,
            depths: vec![0.0; n_nodes.iter().product()],
        };
        sweep.fill(bricks, sun_direction);
        Ok(sweep)
    }

    fn fill(&mut self, bricks: &[Bricks], sun_direction: DVec3) {
        let [swept, second, third] = self.axes;
        let (n_layers, n_rows, n_columns) = (
            self.n_nodes[swept],
            self.n_nodes[second],
            self.n_nodes[third],
        );
        let to_next = sun_direction * (self.spacing_m[swept] / sun_direction[swept].abs());
        let finest_m = bricks
            .iter()
            .map(Bricks::voxel_m)
            .fold(f64::INFINITY, f64::min);
        let n_stretches = (to_next.length() / finest_m)
            .ceil()
            .clamp(1.0, MAX_STRETCHES);
        let crossing = Crossing {
            to_next,
            to_column: self.node([0, 0, 1]) - self.node([0, 0, 0]),
            n_stretches: n_stretches as usize,
            row_step: to_next[second] / self.spacing_m[second],
            column_step: to_next[third] / self.spacing_m[third],
            n_rows,
            n_columns,
        };
        let layer_size = n_rows * n_columns;
        let mut depths = std::mem::take(&mut self.depths);
        // f64: equal terms added layer by layer round to the same side in f32, 3e-6 after 64.
        let mut before = vec![0.0; layer_size];
        let mut values = vec![0.0; layer_size];
        for step in 0..n_layers {
            let layer = if sun_direction[swept] > 0.0 {
                n_layers - 1 - step
            } else {
                step
            };
            values
                .par_chunks_mut(n_columns)
                .enumerate()
                .for_each(|(row, values)| {
                    let first = self.node([layer, row, 0]);
                    crossing.depths_between(bricks, first, values);
                    for (column, value) in values.iter_mut().enumerate() {
                        *value += crossing.depth_at_next(&before, row, column);
                    }
                });
            let stored = &mut depths[layer * layer_size..(layer + 1) * layer_size];
            for (stored, value) in stored.iter_mut().zip(&values) {
                *stored = *value as f32;
            }
            std::mem::swap(&mut before, &mut values);
        }
        self.depths = depths;
    }

    /// World position of a node in the order of the sweep's axes.
    fn node(&self, indices: [usize; 3]) -> DVec3 {
        let mut position = self.origin;
        for (axis, index) in self.axes.into_iter().zip(indices) {
            position[axis] += index as f64 * self.spacing_m[axis];
        }
        position
    }

    /// Trilinear interpolation; the nearest point of the box holds outside.
    pub(crate) fn at(&self, point: DVec3) -> f32 {
        let place = (point - self.origin) / self.spacing_m;
        let mut lower = [0; 3];
        let mut fraction = [0.0; 3];
        for (slot, axis) in self.axes.into_iter().enumerate() {
            let last = self.n_nodes[axis] - 1;
            let along = place[axis].clamp(0.0, last as f64);
            lower[slot] = (along as usize).min(last - 1);
            fraction[slot] = along - lower[slot] as f64;
        }
        let [_, second, third] = self.axes;
        let (rows, columns) = (self.n_nodes[second], self.n_nodes[third]);
        let mut sum = 0.0;
        for corner in 0..8_usize {
            let offsets = [corner >> 2, corner >> 1 & 1, corner & 1];
            let weight: f64 = (0..3)
                .map(|slot| {
                    if offsets[slot] == 1 {
                        fraction[slot]
                    } else {
                        1.0 - fraction[slot]
                    }
                })
                .product();
            let [a, b, c] = std::array::from_fn(|slot| lower[slot] + offsets[slot]);
            sum += weight * f64::from(self.depths[(a * rows + b) * columns + c]);
        }
        sum as f32
    }
}

/// The way from a node to the next layer on the sun's side.
struct Crossing {
    to_next: DVec3,
    /// The way to the next node of the row.
    to_column: DVec3,
    n_stretches: usize,
    row_step: f64,
    column_step: f64,
    n_rows: usize,
    n_columns: usize,
}

impl Crossing {
    /// Bilinear optical depth where the line crosses the next layer; 0 where it has left the box.
    fn depth_at_next(&self, layer: &[f64], row: usize, column: usize) -> f64 {
        let (row, column) = (row as f64 + self.row_step, column as f64 + self.column_step);
        let (last_row, last_column) = (self.n_rows as f64 - 1.0, self.n_columns as f64 - 1.0);
        let inside = (0.0..=last_row).contains(&row) && (0.0..=last_column).contains(&column);
        if !inside {
            return 0.0;
        }
        let (lower_row, lower_column) = (
            (row as usize).min(self.n_rows - 2),
            (column as usize).min(self.n_columns - 2),
        );
        let (up, right) = (row - lower_row as f64, column - lower_column as f64);
        let at = |row: usize, column: usize| layer[row * self.n_columns + column];
        let along =
            |row: usize| at(row, lower_column) * (1.0 - right) + at(row, lower_column + 1) * right;
        along(lower_row) * (1.0 - up) + along(lower_row + 1) * up
    }

    /// Optical depths from the nodes of a row to the next layer.
    fn depths_between(&self, bricks: &[Bricks], first: DVec3, depths: &mut [f64]) {
        let n = self.n_stretches as f64;
        depths.fill(0.0);
        for stretch in 0..self.n_stretches {
            for offset in [-GAUSS_OFFSET, GAUSS_OFFSET] {
                let fraction = (stretch as f64 + 0.5 + offset) / n;
                let start = first + fraction * self.to_next;
                for mode in bricks {
                    mode.add_m2_along(start, self.to_column, depths);
                }
            }
        }
        let depth_per_m2 = EXTINCTION_PER_M2 * 0.5 * self.to_next.length() / n;
        for depth in depths {
            *depth *= depth_per_m2;
        }
    }
}
