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

use std::ops::Range;

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use rayon::prelude::*;

use crate::error::Error;
use crate::piece::EXTINCTION_PER_M2;
use crate::progress::Progress;
use crate::progress::tell;

/// 256 MiB of f32.
const MAX_NODES: f64 = (1_u64 << 26) as f64;

/// By so much a voxel grows at least, until it fits.
const WIDENING: f64 = 1.001;

/// Stretches of a layer's crossing; beyond, the sweep's voxels are far coarser than the drops'.
const MAX_STRETCHES: f64 = 64.0;

/// Offsets of the two Gauss points from the middle of a stretch, in units of its length.
const GAUSS_OFFSET: f64 = 0.288_675_134_594_812_9;

/// Cells of a lattice over a box.
fn n_cells(size_m: DVec3, voxel_m: f64) -> DVec3 {
    (size_m / voxel_m).ceil().max(DVec3::ONE)
}

fn n_nodes(n_cells: DVec3) -> f64 {
    (n_cells + DVec3::ONE).element_product()
}

/// The voxel (m), or a larger one by which a box has no more nodes than fit.
pub(crate) fn fitting_voxel_m(size_m: DVec3, mut voxel_m: f64) -> f64 {
    loop {
        let excess = n_nodes(n_cells(size_m, voxel_m)) / MAX_NODES;
        if excess <= 1.0 || !excess.is_finite() {
            return voxel_m;
        }
        voxel_m *= excess.cbrt().max(WIDENING);
    }
}

/// Optical depth at Q = 1 on a lattice over the drops' box.
pub(crate) struct SunSweep {
    origin: DVec3,
    spacing_m: DVec3,
    n_nodes: [usize; 3],
    sun_direction: DVec3,
    /// The swept axis, then the other two.
    axes: [usize; 3],
    /// [swept axis, second, third], the third fastest. f32: interpolated to 1e-4 at best.
    depths: Vec<f32>,
}

impl SunSweep {
    /// The lattice without any drops.
    ///
    /// # Errors
    /// [`Error::SunVolumeTooLarge`] if it would need more than 2^26 nodes.
    pub(crate) fn over(bounds: Aabb, sun_direction: DVec3, voxel_m: f64) -> Result<Self, Error> {
        let size = bounds.max - bounds.min;
        let n_cells = n_cells(size, voxel_m);
        if n_nodes(n_cells) > MAX_NODES {
            return Err(Error::SunVolumeTooLarge {
                found_m: voxel_m,
                smallest_m: fitting_voxel_m(size, voxel_m),
            });
        }
        let swept = sun_direction.abs().max_position();
        // Rows along z where that is not the swept axis: there the drops' nodes lie side by side.
        let axes = [swept, usize::from(swept == 0), 2 - usize::from(swept == 2)];
        let n_nodes = n_cells.to_array().map(|cells| cells as usize + 1);
        Ok(Self {
            origin: bounds.min,
            spacing_m: size / n_cells,
            n_nodes,
            sun_direction,
            axes,
            depths: vec![0.0; n_nodes.iter().product()],
        })
    }

    /// Sweep through all modes.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub(crate) fn through(mut self, bricks: &[Bricks], progress: Progress) -> Result<Self, Error> {
        let sun_direction = self.sun_direction;
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
            column_axis: third,
            column_m: self.spacing_m[third],
            n_stretches: n_stretches as usize,
            row_step: to_next[second] / self.spacing_m[second],
            column_step: to_next[third] / self.spacing_m[third],
            n_columns,
        };
        let layer_size = n_rows * n_columns;
        let mut depths = std::mem::take(&mut self.depths);
        // f64: equal terms added layer by layer round to the same side in f32, 3e-6 after 64.
        let mut before = vec![0.0; layer_size];
        let mut values = vec![0.0; layer_size];
        for step in 0..n_layers {
            tell(progress, 0)?;
            let layer = if sun_direction[swept] > 0.0 {
                n_layers - 1 - step
            } else {
                step
            };
            let stored = &mut depths[layer * layer_size..(layer + 1) * layer_size];
            values
                .par_chunks_mut(n_columns)
                .zip(stored.par_chunks_mut(n_columns))
                .enumerate()
                .for_each(|(row, (values, stored))| {
                    let first = self.node([layer, row, 0]);
                    crossing.depths_between(bricks, first, values);
                    crossing.add_depths_at_next(&before, row, values);
                    for (stored, value) in stored.iter_mut().zip(values) {
                        *stored = *value as f32;
                    }
                });
            std::mem::swap(&mut before, &mut values);
        }
        self.depths = depths;
        Ok(self)
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
        let (mut low, mut strides, mut fractions) = (0, [0; 3], [0.0; 3]);
        let mut stride = 1;
        // From the fastest axis to the slowest.
        for (slot, axis) in self.axes.into_iter().enumerate().rev() {
            let last = self.n_nodes[axis] - 1;
            let along = place[axis].clamp(0.0, last as f64);
            let lower = (along as usize).min(last - 1);
            fractions[slot] = along - lower as f64;
            strides[slot] = stride;
            low += lower * stride;
            stride *= last + 1;
        }
        let [a, b, _] = strides;
        let between = |low: f64, high: f64, slot: usize| {
            low * (1.0 - fractions[slot]) + high * fractions[slot]
        };
        let depth = |place: usize| f64::from(self.depths[place]);
        let row = |low: usize| between(depth(low), depth(low + 1), 2);
        let face = |low: usize| between(row(low), row(low + b), 1);
        between(face(low), face(low + a), 0) as f32
    }
}

/// The way from a node to the next layer on the sun's side.
struct Crossing {
    to_next: DVec3,
    column_axis: usize,
    column_m: f64,
    n_stretches: usize,
    /// The same way in nodes.
    row_step: f64,
    column_step: f64,
    n_columns: usize,
}

impl Crossing {
    /// Add bilinear optical depths where the lines from the nodes of a row cross the next layer; 0
    /// where they have left the box.
    fn add_depths_at_next(&self, layer: &[f64], row: usize, depths: &mut [f64]) {
        let n_rows = layer.len() / self.n_columns;
        let rows = Shift::new(self.row_step, n_rows);
        let columns = Shift::new(self.column_step, self.n_columns);
        if !rows.inside.contains(&row) || columns.inside.is_empty() {
            return;
        }
        let (first, n) = (columns.inside.start, columns.inside.len());
        let of_row = |row: usize| &layer[row * self.n_columns..(row + 1) * self.n_columns];
        let (lower, upper) = (of_row(rows.lower(row)), of_row(rows.upper(row)));
        let (left, right) = (columns.lower(first), columns.upper(first));
        let corners = [
            &lower[left..left + n],
            &lower[right..right + n],
            &upper[left..left + n],
            &upper[right..right + n],
        ];
        let (up, along) = (rows.fraction, columns.fraction);
        for (column, depth) in depths[columns.inside.clone()].iter_mut().enumerate() {
            let [a, b, c, d] = corners.map(|corner| corner[column]);
            let between = |low: f64, high: f64| low * (1.0 - along) + high * along;
            *depth += between(a, b) * (1.0 - up) + between(c, d) * up;
        }
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
                    mode.add_m2_in_row(start, self.column_axis, self.column_m, depths);
                }
            }
        }
        let depth_per_m2 = EXTINCTION_PER_M2 * 0.5 * self.to_next.length() / n;
        for depth in depths {
            *depth *= depth_per_m2;
        }
    }
}

/// The same step from each of a line of nodes to a place between two of them.
struct Shift {
    /// Nodes from which the step stays among the nodes.
    inside: Range<usize>,
    /// Whole nodes of the step.
    whole: isize,
    /// What is left of it, from 0 to 1.
    fraction: f64,
}

impl Shift {
    fn new(step: f64, n_nodes: usize) -> Self {
        let whole = step.floor();
        let fraction = step - whole;
        // Also onto the lowest and the highest node. Numbers below 0 convert to 0.
        let first = (-whole as usize).min(n_nodes);
        let end = ((n_nodes as f64 - step.ceil()) as usize).min(n_nodes);
        Self {
            inside: first..end.max(first),
            whole: whole as isize,
            fraction,
        }
    }

    fn lower(&self, node: usize) -> usize {
        node.saturating_add_signed(self.whole)
    }

    /// The node on the other side of the place, or at it.
    fn upper(&self, node: usize) -> usize {
        self.lower(node) + usize::from(self.fraction > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bilinear at one place; 0 outside.
    fn at(layer: &[f64], [n_rows, n_columns]: [usize; 2], row: f64, column: f64) -> f64 {
        let inside = |place: f64, n: usize| (0.0..=n as f64 - 1.0).contains(&place);
        if !(inside(row, n_rows) && inside(column, n_columns)) {
            return 0.0;
        }
        // Hats: 1 at their node, 0 at all others.
        let hat = |place: f64, node: usize| (1.0 - (place - node as f64).abs()).max(0.0);
        let nodes = (0..n_rows).flat_map(|a| (0..n_columns).map(move |b| (a, b)));
        nodes
            .map(|(a, b)| hat(row, a) * hat(column, b) * layer[a * n_columns + b])
            .sum()
    }

    #[test]
    fn a_row_is_found_between_the_nodes_of_the_next_layer() {
        let [n_rows, n_columns] = [4, 7];
        let layer: Vec<f64> = (0..28).map(|node| 1.0 + f64::from(node * node)).collect();
        let steps = [
            0.0, -0.0, 1.0, -1.0, 0.25, -0.25, 2.5, -2.75, 3.0, -3.0, 6.0, -6.0, 50.5, -50.5,
        ];
        for (row_step, column_step) in steps.iter().flat_map(|a| steps.map(|b| (*a, b))) {
            let crossing = Crossing {
                to_next: DVec3::X,
                column_axis: 2,
                column_m: 1.0,
                n_stretches: 1,
                row_step,
                column_step,
                n_columns,
            };
            for row in 0..n_rows {
                let mut depths = vec![10.0; n_columns];
                crossing.add_depths_at_next(&layer, row, &mut depths);
                for (column, depth) in depths.into_iter().enumerate() {
                    let place = (row as f64 + row_step, column as f64 + column_step);
                    let expected = 10.0 + at(&layer, [n_rows, n_columns], place.0, place.1);
                    assert_eq!(depth, expected, "{row_step} {column_step} {row} {column}");
                }
            }
        }
    }
}
