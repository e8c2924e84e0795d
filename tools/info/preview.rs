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
pub(super) fn write(file: &VdbFile, source: &Path, to: &Path) -> Result<(), Failure> {
    let trees = file.grids.iter().filter_map(|grid| grid.tree.as_float());
    let rows: Vec<Vec<Panel>> = trees.filter_map(panels).collect();
    if rows.is_empty() {
        let none = "found no float grid with active voxels, expected one to draw";
        return Err(Failure::bad_input(source, none));
    }
    let (width, height, bytes) = sheet(&rows);
    output::write_file(to, |writer| {
        let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()
    })
}

/// Projections along the three axes, then slices; `None` for an empty grid.
fn panels(tree: &FloatTree) -> Option<Vec<Panel>> {
    let (low, high) = tree.active_bounds()?;
    let size = [0, 1, 2].map(|axis| (high[axis] - low[axis] + 1) as usize);
    let middle = [0, 1, 2].map(|axis| i32::midpoint(low[axis], high[axis]));
    let shape = |axis: usize| match axis {
        0 => (size[1], size[2]),
        1 => (size[2], size[0]),
        _ => (size[1], size[0]),
    };
    // Row and column of a voxel in the view along an axis, up being up.
    let place = |axis: usize, voxel: [i32; 3]| {
        let from_low = |axis: usize| (voxel[axis] - low[axis]) as usize;
        let from_high = |axis: usize| (high[axis] - voxel[axis]) as usize;
        match axis {
            0 => (from_high(1), from_high(2)),
            1 => (from_low(2), from_low(0)),
            _ => (from_high(1), from_low(0)),
        }
    };
    let mut views: Vec<Panel> = (0..6).map(|view| Array2::zeros(shape(view % 3))).collect();
    for_each_active(tree, |voxel, value| {
        for axis in 0..3 {
            let (row, column) = place(axis, voxel);
            views[axis][[row, column]] += value / size[axis] as f64;
            if voxel[axis] == middle[axis] {
                views[3 + axis][[row, column]] = value;
            }
        }
    });
    Some(views.iter().map(reduced).collect())
}

fn for_each_active(tree: &FloatTree, mut visit: impl FnMut([i32; 3], f64)) {
    for leaf in tree.leaves() {
        for (index, value) in leaf.active() {
            visit(leaf.voxel(index), f64::from(value));
        }
    }
    for tile in tree.tiles().iter().filter(|tile| tile.active) {
        let dim = tile.level.dim();
        for offset in 0..i64::from(dim).pow(3) {
            let dim = i64::from(dim);
            let within = [offset / (dim * dim), offset / dim % dim, offset % dim];
            let voxel = [0, 1, 2].map(|axis| tile.origin[axis] + within[axis] as i32);
            visit(voxel, f64::from(tile.value));
        }
    }
}

/// Means over blocks, so that the longest edge fits.
fn reduced(panel: &Panel) -> Panel {
    let (rows, columns) = panel.dim();
    let block = rows.max(columns).div_ceil(PANEL_PX);
    // Small grids are enlarged.
    let enlarge = if block == 1 {
        PANEL_PX / rows.max(columns)
    } else {
        1
    };
    let shape = (
        rows.div_ceil(block) * enlarge,
        columns.div_ceil(block) * enlarge,
    );
    Array2::from_shape_fn(shape, |(row, column)| {
        let (first_row, first_column) = (row / enlarge * block, column / enlarge * block);
        let (mut sum, mut n) = (0.0, 0.0);
        for y in first_row..(first_row + block).min(rows) {
            for x in first_column..(first_column + block).min(columns) {
                sum += panel[[y, x]];
                n += 1.0;
            }
        }
        sum / n
    })
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
        let views = panels(&tree).unwrap();
        // The box is 4 x 2 x 3 voxels; along z the one at +x, +y is on top at the right.
        let front = &views[2];
        let (rows, columns) = front.dim();
        assert!(front[[0, columns - 1]] > 0.0 && front[[rows - 1, 0]] > 0.0);
        assert_eq!(front[[0, 0]], 0.0);
        assert_eq!(front[[0, columns - 1]], 4.0 / 3.0, "mean along z");
    }
}
