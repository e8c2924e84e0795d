//! Pictures of the grids of a VDB file: what is in it, at a glance.
//!
//! A row for each grid of floats: three projections (means along x, y and z) and three slices through
//! the middle of what is active, each from black (0 or the smallest value) to yellow (the largest).
//! Along x one sees −z to the right, along y +x right and +z down, along z +x right; up is up.

use std::path::Path;

use ndarray::Array2;
use niji_vdb::FloatTree;
use niji_vdb::VdbFile;
use plotters::style::colors::colormaps::ViridisRGB;

use crate::failure::Failure;
use crate::output;
use crate::progress::Verbosity;

/// Longest edge of a panel in pixels; larger ones are averaged down.
const PANEL_PX: usize = 320;
/// Pixels between panels.
const GAP_PX: usize = 6;

/// A picture of one grid along one axis.
type Panel = Array2<f64>;

/// Writes the picture.
///
/// # Errors
/// No grid of floats with an active voxel, or a file that cannot be written.
pub(super) fn write(
    file: &VdbFile,
    (source, to): (&Path, &Path),
    verbosity: Verbosity,
) -> Result<(), Failure> {
    let mut rows: Vec<Vec<Panel>> = Vec::new();
    for grid in &file.grids {
        let Some(views) = grid.tree.as_float().and_then(views) else {
            continue;
        };
        if views.n_not_finite > 0 {
            verbosity.warn(format_args!(
                "{}: {} active values are no finite numbers, and are drawn as 0",
                grid.name, views.n_not_finite
            ));
        }
        rows.push(views.panels);
    }
    if rows.is_empty() {
        let none = "found no float grid with active voxels, expected one to draw";
        return Err(Failure::bad_input(source, none));
    }
    let (width, height, bytes) = sheet(&rows);
    output::write_rgb_png(to, [width, height], &bytes)
}

/// What a grid shows.
struct Views {
    /// Projections along the three axes, then slices.
    panels: Vec<Panel>,
    /// Active values that are no numbers, which are not drawn.
    n_not_finite: u64,
}

/// The views of a grid; `None` for an empty one.
fn views(tree: &FloatTree) -> Option<Views> {
    let bounds = tree.active_bounds()?;
    let mut sums: Vec<Sum> = (0..3).map(|axis| Sum::new(bounds, axis)).collect();
    let mut n_not_finite = 0;
    let mut add = |origin: [i32; 3], dim: i64, value: f32| {
        if value.is_finite() {
            let origin = origin.map(i64::from);
            for sum in &mut sums {
                sum.add(origin, dim, f64::from(value));
            }
        } else {
            n_not_finite += dim.pow(3) as u64;
        }
    };
    for leaf in tree.leaves() {
        for (index, value) in leaf.active() {
            add(leaf.voxel(index), 1, value);
        }
    }
    for tile in tree.tiles().iter().filter(|tile| tile.active) {
        add(tile.origin, i64::from(tile.level.dim()), tile.value);
    }
    let projections = sums.iter().map(|sum| sum.panel(&sum.projection));
    let slices = sums.iter().map(|sum| sum.panel(&sum.slice));
    Some(Views {
        panels: projections.chain(slices).collect(),
        n_not_finite,
    })
}

/// The view along an axis while voxels arrive: sums over blocks of voxels, so that the longest edge of a
/// panel fits however far apart voxels lie.
struct Sum {
    axis: usize,
    rows: Edge,
    columns: Edge,
    /// Voxels along the axis, and the middle one.
    depth: i64,
    middle: i64,
    /// Voxels along the edge of a block.
    block: i64,
    projection: Panel,
    slice: Panel,
}

/// An edge of a panel.
struct Edge {
    axis: usize,
    low: i64,
    high: i64,
    /// Whether it runs from high to low.
    is_turned: bool,
}

impl Sum {
    fn new((low, high): ([i32; 3], [i32; 3]), axis: usize) -> Self {
        let edge = |axis: usize, is_turned| Edge {
            axis,
            low: i64::from(low[axis]),
            high: i64::from(high[axis]),
            is_turned,
        };
        // Up is up; along y one sees +z down.
        let (rows, columns) = match axis {
            0 => (edge(1, true), edge(2, true)),
            1 => (edge(2, false), edge(0, false)),
            _ => (edge(1, true), edge(0, false)),
        };
        let depth = edge(axis, false);
        let block = rows.len().max(columns.len()).unsigned_abs();
        let block = block.div_ceil(PANEL_PX as u64) as i64;
        let shape = [&rows, &columns].map(|edge| ((edge.len() - 1) / block + 1) as usize);
        Self {
            axis,
            depth: depth.len(),
            middle: (depth.low + depth.high).div_euclid(2),
            block,
            projection: Array2::zeros(shape),
            slice: Array2::zeros(shape),
            rows,
            columns,
        }
    }

    /// Adds a cube of voxels of one value.
    fn add(&mut self, origin: [i64; 3], dim: i64, value: f64) {
        let along = origin[self.axis];
        let is_in_slice = (along..along + dim).contains(&self.middle);
        for (row, n_rows) in self.rows.parts(origin, dim, self.block) {
            for (column, n_columns) in self.columns.parts(origin, dim, self.block) {
                let sum = value * (n_rows * n_columns) as f64;
                self.projection[[row, column]] += sum * dim as f64 / self.depth as f64;
                if is_in_slice {
                    self.slice[[row, column]] += sum;
                }
            }
        }
    }

    /// Means over the blocks; small grids are enlarged.
    fn panel(&self, sums: &Panel) -> Panel {
        let (rows, columns) = sums.dim();
        let enlarge = if self.block == 1 {
            PANEL_PX / rows.max(columns)
        } else {
            1
        };
        let inside = |edge: &Edge, index: usize| {
            let first = index as i64 * self.block;
            (first + self.block).min(edge.len()) - first
        };
        Array2::from_shape_fn((rows * enlarge, columns * enlarge), |(row, column)| {
            let (row, column) = (row / enlarge, column / enlarge);
            let n = inside(&self.rows, row) * inside(&self.columns, column);
            sums[[row, column]] / n as f64
        })
    }
}

impl Edge {
    fn len(&self) -> i64 {
        self.high - self.low + 1
    }

    /// The blocks that a cube lies in, and how many of its voxels in each.
    fn parts(
        &self,
        origin: [i64; 3],
        dim: i64,
        block: i64,
    ) -> impl Iterator<Item = (usize, i64)> + use<> {
        let first = if self.is_turned {
            self.high - (origin[self.axis] + dim - 1)
        } else {
            origin[self.axis] - self.low
        };
        let end = first + dim;
        (first / block..=(end - 1) / block).map(move |index| {
            let inside = end.min((index + 1) * block) - first.max(index * block);
            (index as usize, inside)
        })
    }
}

/// All panels on one sheet: width, height and RGB.
fn sheet(rows: &[Vec<Panel>]) -> (usize, usize, Vec<u8>) {
    let row_width = |row: &Vec<Panel>| -> usize {
        row.iter()
            .map(|panel| panel.ncols() + GAP_PX)
            .sum::<usize>()
            + GAP_PX
    };
    let row_height = |row: &Vec<Panel>| row.iter().map(Array2::nrows).max().unwrap_or(0) + GAP_PX;
    let width = rows.iter().map(row_width).max().unwrap_or(0);
    let height = rows.iter().map(row_height).sum::<usize>() + GAP_PX;
    let mut bytes = vec![255; 3 * width * height];
    let mut top = GAP_PX;
    for row in rows {
        let mut left = GAP_PX;
        for panel in row {
            let largest = panel.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let smallest = panel.iter().copied().fold(0.0, f64::min);
            for ((y, x), &value) in panel.indexed_iter() {
                let range = largest - smallest;
                let part = if range > 0.0 {
                    (value - smallest) / range
                } else {
                    0.0
                };
                // f32: a color of 8 bits.
                let color = ViridisRGB::get_color(part as f32);
                let at = 3 * ((top + y) * width + left + x);
                bytes[at..at + 3].copy_from_slice(&[color.0, color.1, color.2]);
            }
            left += panel.ncols() + GAP_PX;
        }
        top += row_height(row);
    }
    (width, height, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voxel_stands_where_it_is_in_every_view() {
        let mut leaf = niji_vdb::Leaf::new([0, 0, 0], 0.0);
        leaf.set([0, 0, 0], 1.0);
        leaf.set([3, 1, 2], 4.0);
        let tree = FloatTree::from_leaves(0.0, vec![leaf]).unwrap();
        let views = views(&tree).unwrap().panels;
        // The box is 4 x 2 x 3 voxels; along z the one at +x, +y is on top at the right.
        let front = &views[2];
        let (rows, columns) = front.dim();
        assert!(front[[0, columns - 1]] > 0.0 && front[[rows - 1, 0]] > 0.0);
        assert_eq!(front[[0, 0]], 0.0);
        assert_eq!(front[[0, columns - 1]], 4.0 / 3.0, "mean along z");
    }
    #[test]
    fn voxels_that_are_no_numbers_or_far_apart_are_drawn_without_a_panic() {
        let leaf = |origin: [i32; 3], value| {
            let mut leaf = niji_vdb::Leaf::new(origin, 0.0);
            leaf.set(origin, value);
            leaf
        };
        let far = 1 << 30;
        let leaves = [
            leaf([0, 0, 0], f32::NAN),
            leaf([8, 0, 0], f32::INFINITY),
            leaf([-far, -far, -far], 1.0),
            leaf([far, far, far], 2.0),
        ];
        let tree = FloatTree::from_leaves(0.0, leaves.to_vec()).unwrap();
        let views = views(&tree).unwrap();
        assert_eq!(views.n_not_finite, 2);
        let (_, _, bytes) = sheet(&[views.panels]);
        assert!(bytes.len() < 6 * 3 * (PANEL_PX + GAP_PX) * (PANEL_PX + 2 * GAP_PX) + 8000);
    }
}
