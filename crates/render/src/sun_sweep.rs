//! Optical depth towards the sun on a sheared lattice, swept layer by layer away from the sun.
//!
//! tau(x) = tau(x + d w) + int_0^d pi M2(x + s w) ds
//!
//! `w` unit vector towards the sun, `d` the distance at which the line from a node crosses the layer
//! of nodes that is next on the sun's side. The nodes of a layer are shifted sideways so that there is a
//! node there: tau is handed on as it is, and a shadow stays as sharp as it was cast however far it
//! falls. On the way the integral takes two Gauss points a voxel of the drops, so that a node costs the
//! same however deep the volume is.
//!
//! At a face tau has a kink, and where the sun begins to come in by another one. So what is interpolated
//! is the mean extinction on the way out,
//!
//! tau(x) = D(x) sum_i w_i tau_i / sum_i w_i D_i
//!
//! `D` distance from a point to where its line leaves the box, 0 outside; `w_i` weights of the nodes
//! around, linear along the line and along two axes across. Away from kinks of D this is sum_i w_i tau_i;
//! where the extinction is the same everywhere it is exact.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use rayon::prelude::*;

use crate::error::Error;
use crate::lit_drops::finest_voxel_m;
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

/// By so little of a voxel a side may be longer than whole voxels: rounding.
const ROUNDING: f64 = 1e-9;

/// Cells of a lattice over a box.
fn n_cells(size_m: DVec3, voxel_m: f64) -> DVec3 {
    (size_m / voxel_m - ROUNDING).ceil().max(DVec3::ONE)
}

/// Nodes at most, whichever axis is swept along.
fn n_nodes(n_cells: DVec3) -> f64 {
    (n_cells + 2.0).element_product()
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
    lattice: SunLattice,
    /// [layer, row, column], columns fastest. f32: interpolated to 1e-4 at best.
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
        let lattice = SunLattice::over(bounds, n_cells, sun_direction);
        Ok(Self {
            depths: vec![0.0; (lattice.n_layers + 1) * lattice.layer_size()],
            lattice,
        })
    }

    /// Sweep through all modes.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub(crate) fn through(mut self, bricks: &[Bricks], progress: Progress) -> Result<Self, Error> {
        let finest_m = finest_voxel_m(bricks);
        let lattice = &mut self.lattice;
        lattice.n_stretches = (lattice.to_next.length() / finest_m)
            .ceil()
            .clamp(1.0, MAX_STRETCHES) as usize;
        let n_columns = lattice.across[1].n_nodes();
        // f64: equal terms added layer by layer round to the same side in f32, 3e-6 after 64.
        let mut before = vec![0.0; lattice.layer_size()];
        let mut values = before.clone();
        // On the first layer light comes in.
        let layers = self.depths.chunks_mut(lattice.layer_size());
        for (layer, stored) in layers.enumerate().skip(1) {
            tell(progress, 0)?;
            values
                .par_chunks_mut(n_columns)
                .zip(stored.par_chunks_mut(n_columns))
                .enumerate()
                .for_each(|(row, (values, stored))| {
                    lattice.depths_between(bricks, (layer, row), values);
                    lattice.add_depths_at_next(&before, (layer, row), values);
                    for (stored, value) in stored.iter_mut().zip(values) {
                        *stored = *value as f32;
                    }
                });
            std::mem::swap(&mut before, &mut values);
        }
        Ok(self)
    }

    /// Optical depth at a point; the nearest point of the box holds outside.
    pub(crate) fn at(&self, point: DVec3) -> f32 {
        let SunLattice {
            n_layers,
            across: [rows, columns],
            ..
        } = &self.lattice;
        let (layer, lines) = self.lattice.place(point);
        let above = (layer as usize).min(*n_layers - 1);
        let below = layer - above as f64;
        let [of_rows, of_columns] =
            [(rows, lines[0]), (columns, lines[1])].map(|(axis, line)| axis.around(line, above));
        let (mut depth, mut way) = (0.0, 0.0);
        for (layer, weight) in [1.0 - below, below].into_iter().enumerate() {
            if weight <= 0.0 {
                continue;
            }
            for row in &of_rows {
                for column in &of_columns {
                    let (row_node, column_node) = (row.nodes[layer], column.nodes[layer]);
                    // Beyond the nodes of a layer, what the others say holds.
                    if !(rows.has(row_node) && columns.has(column_node)) {
                        continue;
                    }
                    let weight = weight * row.weight * column.weight;
                    let leaves_at = row.leaves_at.max(column.leaves_at);
                    let layer = above + layer;
                    let place = layer * rows.n_nodes() + row_node as usize;
                    let place = place * columns.n_nodes() + column_node as usize;
                    depth += weight * f64::from(self.depths[place]);
                    way += weight * (layer as f64 - leaves_at).max(0.0);
                }
            }
        }
        let leaves_at = rows.leaves_at(lines[0]).max(columns.leaves_at(lines[1]));
        let way_out = (layer - leaves_at).max(0.0);
        if way > 0.0 {
            (depth * (way_out / way)) as f32
        } else {
            0.0
        }
    }
}

/// Layers of nodes across an axis, of which each follows the sun's lines from the one before.
#[derive(Clone, Debug)]
struct SunLattice {
    bounds: Aabb,
    /// The axis across the layers.
    swept: usize,
    /// Where layer 0 lies on it, on the sun's side (m), and the distance of the layers away from it.
    first_m: f64,
    spacing_m: f64,
    n_layers: usize,
    /// Of the rows in a layer and of the columns in a row.
    across: [Across; 2],
    /// From a node to that of the next layer on the sun's side (m).
    to_next: DVec3,
    /// Stretches of this way that have two Gauss points each.
    n_stretches: usize,
}

/// One of the two axes across. A line of the sun has the number of its place in layer 0, in nodes
/// from the lowest corner of the box; the nodes are at whole numbers.
#[derive(Clone, Debug)]
struct Across {
    axis: usize,
    spacing_m: f64,
    nodes_per_m: f64,
    n_cells: usize,
    /// Nodes from a place in a layer to that on the next one on the sun's side, -1 to 1.
    step: f64,
    /// Its inverse; 0 for 0, where no line leaves the box by a face of this axis.
    layers_per_node: f64,
    /// Place of that face (nodes).
    exit_place: f64,
    /// Lines of the lowest nodes of all layers.
    first_lines: Vec<f64>,
}

/// A line of nodes beside a place.
#[derive(Clone, Copy, Debug)]
struct Beside {
    weight: f64,
    /// Numbers of its nodes in the layer on the sun's side of the place and in the next, if they have them.
    nodes: [isize; 2],
    /// Layers from the first to where the line leaves the box by a face of this axis.
    leaves_at: f64,
}

impl Across {
    /// One more than corners of cells: shifted nodes still enclose the box.
    fn n_nodes(&self) -> usize {
        self.n_cells + 2
    }

    /// Line of the lowest node of a layer; it lies less than a cell outside of the box, or on its face.
    fn first_line(&self, layer: usize) -> f64 {
        self.first_lines[layer]
    }

    /// Place of that node in the layer (nodes).
    fn first_place(&self, layer: usize) -> f64 {
        self.first_line(layer) - self.step * layer as f64
    }

    /// Layers from the first to where a line leaves the box by a face of this axis.
    #[inline]
    fn leaves_at(&self, line: f64) -> f64 {
        // `max` takes the number where this is not one: a step of next to nothing.
        ((line - self.exit_place) * self.layers_per_node).max(0.0)
    }

    /// The two lines of nodes around a line that meets the box between a layer and the next one.
    #[inline]
    fn around(&self, line: f64, layer: usize) -> [Beside; 2] {
        let first_line = self.first_line(layer);
        // From -1 on: towards the sun, the line may have left the box before that layer.
        let place = line - first_line;
        let low = (place + 1.0) as isize - 1;
        let upper = place - low as f64;
        let shift = self.shift(layer + 1);
        [(low, 1.0 - upper), (low + 1, upper)].map(|(node, weight)| Beside {
            weight,
            nodes: [node, node - shift],
            leaves_at: self.leaves_at(first_line + node as f64),
        })
    }

    /// Whether a layer has a node of this number.
    fn has(&self, node: isize) -> bool {
        (0..self.n_nodes() as isize).contains(&node)
    }

    /// Nodes by which a line's number in a layer is larger than in the next one on the sun's side.
    fn shift(&self, layer: usize) -> isize {
        (self.first_line(layer) - self.first_line(layer - 1)) as isize
    }
}

impl SunLattice {
    fn over(bounds: Aabb, n_cells: DVec3, sun_direction: DVec3) -> Self {
        let spacing = (bounds.max - bounds.min) / n_cells;
        // Along the axis on which the sun's line passes most cells: it moves a cell aside at most.
        let passed = sun_direction / spacing;
        let swept = passed.abs().max_position();
        // Rows along z where that is not the swept axis: there the drops' nodes lie side by side.
        let across = [usize::from(swept == 0), 2 - usize::from(swept == 2)].map(|axis| {
            let step = passed[axis] / passed[swept].abs();
            let first_line = |layer: usize| (step * layer as f64).floor();
            Across {
                axis,
                spacing_m: spacing[axis],
                nodes_per_m: spacing[axis].recip(),
                n_cells: n_cells[axis] as usize,
                step,
                layers_per_node: if step == 0.0 { 0.0 } else { 1.0 / step },
                exit_place: if step > 0.0 { n_cells[axis] } else { 0.0 },
                first_lines: (0..=n_cells[swept] as usize).map(first_line).collect(),
            }
        });
        let (first_m, away) = if sun_direction[swept] > 0.0 {
            (bounds.max[swept], -1.0)
        } else {
            (bounds.min[swept], 1.0)
        };
        Self {
            bounds,
            swept,
            first_m,
            spacing_m: away * spacing[swept],
            n_layers: n_cells[swept] as usize,
            across,
            to_next: sun_direction / passed[swept].abs(),
            n_stretches: 1,
        }
    }

    fn layer_size(&self) -> usize {
        self.across.iter().map(Across::n_nodes).product()
    }

    /// Layers from the first to a point, and the line through it; the nearest point of the box holds
    /// outside.
    fn place(&self, point: DVec3) -> (f64, [f64; 2]) {
        let layer = (point[self.swept] - self.first_m) / self.spacing_m;
        let layer = layer.clamp(0.0, self.n_layers as f64);
        let lines = self.across.each_ref().map(|across| {
            let from_low_m = point[across.axis] - self.bounds.min[across.axis];
            let place = (from_low_m * across.nodes_per_m).clamp(0.0, across.n_cells as f64);
            place + across.step * layer
        });
        (layer, lines)
    }

    /// World position of the first node of a row.
    fn first_node(&self, (layer, row): (usize, usize)) -> DVec3 {
        let mut position = self.bounds.min;
        position[self.swept] = self.first_m + layer as f64 * self.spacing_m;
        for (across, node) in self.across.iter().zip([row, 0]) {
            let place = across.first_place(layer) + node as f64;
            position[across.axis] += place * across.spacing_m;
        }
        position
    }

    /// Add the optical depths that a row's nodes have in the next layer on the sun's side, where they
    /// have not left the box.
    fn add_depths_at_next(&self, next: &[f64], (layer, row): (usize, usize), depths: &mut [f64]) {
        let [rows, columns] = &self.across;
        let n_columns = columns.n_nodes();
        let at_next = row.checked_add_signed(rows.shift(layer));
        let Some(row) = at_next.filter(|row| *row < rows.n_nodes()) else {
            return;
        };
        let next = &next[row * n_columns..][..n_columns];
        let shift = columns.shift(layer);
        let (from, to) = (shift.max(0) as usize, (-shift).max(0) as usize);
        for (depth, at_next) in depths.iter_mut().skip(to).zip(&next[from..]) {
            *depth += at_next;
        }
    }

    /// Optical depths from the nodes of a row to the next layer on the sun's side, or to the face by which
    /// their lines leave the box before.
    fn depths_between(&self, bricks: &[Bricks], (layer, row): (usize, usize), depths: &mut [f64]) {
        let [rows, columns] = &self.across;
        let first = self.first_node((layer, row));
        depths.fill(0.0);
        for fraction in self.gauss_points() {
            let start = first + fraction * self.to_next;
            for mode in bricks {
                mode.add_m2_in_row(start, columns.axis, columns.spacing_m, depths);
            }
        }
        let row_leaves_at = rows.leaves_at(rows.first_line(layer) + row as f64);
        let first_line = columns.first_line(layer);
        let depth_per_m2 =
            EXTINCTION_PER_M2 * 0.5 * self.to_next.length() / self.n_stretches as f64;
        for (column, depth) in depths.iter_mut().enumerate() {
            let leaves_at = columns.leaves_at(first_line + column as f64);
            let way = layer as f64 - row_leaves_at.max(leaves_at);
            if way >= 1.0 {
                *depth *= depth_per_m2;
            } else if way > 0.0 {
                let mut node = first;
                node[columns.axis] += column as f64 * columns.spacing_m;
                *depth = way * depth_per_m2 * self.m2_between(bricks, node, way * self.to_next);
            } else {
                *depth = 0.0;
            }
        }
    }

    /// Sum of M2 over the Gauss points of a way.
    fn m2_between(&self, bricks: &[Bricks], from: DVec3, way: DVec3) -> f64 {
        self.gauss_points()
            .flat_map(|fraction| bricks.iter().map(move |mode| (mode, fraction)))
            .map(|(mode, fraction)| f64::from(mode.m2(from + fraction * way)))
            .sum()
    }

    /// Fractions of a way at which two Gauss points of each stretch stand.
    fn gauss_points(&self) -> impl Iterator<Item = f64> {
        let n = self.n_stretches;
        let of_stretch = move |stretch: usize| {
            [-GAUSS_OFFSET, GAUSS_OFFSET].map(|offset| (stretch as f64 + 0.5 + offset) / n as f64)
        };
        (0..n).flat_map(of_stretch)
    }
}

#[cfg(test)]
#[path = "sun_sweep_tests.rs"]
mod tests;
