//! A box and its nodes: how a shape in space becomes a lattice.
//!
//! The box is cut into cells of `voxel_m` from its lowest corner on, and a node sits at the middle
//! of each cell. Where the box is not a whole number of cells, the last cell sticks out; its node
//! then carries the part of the drops that the box covers (see [`crate::DropMode::from_fn`]). The
//! trilinear interpolant over all nodes thus holds exactly number density times volume.

use glam::DVec3;
use niji_radiometry::memory_limit;

use crate::Error;

/// Most nodes that a volume may hold, whose copies in bricks count.
const NODE_LIMIT: u64 = 1 << 28;

/// Memory of a node, as drops and in bricks.
pub(crate) const NODE_BYTES: u64 = 32;

/// Nodes that a volume may hold within the memory that a file's content may take.
pub(crate) fn node_limit() -> u64 {
    let fit = memory_limit().0 / u128::from(NODE_BYTES);
    u64::try_from(fit).map_or(NODE_LIMIT, |fit| fit.min(NODE_LIMIT))
}

/// Cells that stick out by less than this part of a voxel are roundoff of the division.
const WHOLE_CELL_SLACK: f64 = 1e-9;

/// An axis-parallel box and the edge length of the voxels that fill it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridBox {
    /// Lowest corner (m).
    pub min: DVec3,
    /// Highest corner (m).
    pub max: DVec3,
    /// Edge length of a voxel (m).
    pub voxel_m: f64,
}

impl GridBox {
    /// Number of nodes along each axis.
    ///
    /// # Errors
    /// [`Error::BadBox`] if the box is empty, inside out or not finite, or the voxel size is not a
    /// finite number above zero; [`Error::TooManyNodes`] above 2^28 nodes, or
    /// more than fit into memory.
    pub fn n_nodes(&self) -> Result<[i32; 3], Error> {
        let size = self.max - self.min;
        let sound = size.is_finite() && size.min_element() > 0.0 && self.min.is_finite();
        if !(sound && self.voxel_m.is_finite() && self.voxel_m > 0.0) {
            let (min, max) = (self.min.to_array(), self.max.to_array());
            return Err(Error::BadBox {
                min,
                max,
                voxel_m: self.voxel_m,
            });
        }
        let counts = (size / self.voxel_m - WHOLE_CELL_SLACK)
            .ceil()
            .max(DVec3::ONE);
        let total = counts.x * counts.y * counts.z;
        if total > node_limit() as f64 || counts.max_element() > f64::from(i32::MAX / 4) {
            return Err(Error::too_many_nodes(total));
        }
        Ok([counts.x as i32, counts.y as i32, counts.z as i32])
    }

    /// Volume of the box (m³).
    pub fn volume_m3(&self) -> f64 {
        let size = self.max - self.min;
        size.x * size.y * size.z
    }

    /// World position of a node.
    pub(crate) fn node(&self, index: [i32; 3]) -> DVec3 {
        self.min + (DVec3::from(index.map(f64::from)) + 0.5) * self.voxel_m
    }

    /// Middle of the part of a cell that lies in the box, and that part's share of the cell.
    pub(crate) fn covered(&self, index: [i32; 3]) -> (DVec3, f64) {
        let low = self.min + DVec3::from(index.map(f64::from)) * self.voxel_m;
        let cell = DVec3::splat(self.voxel_m);
        let inside = (self.max - low).min(cell);
        let whole = (inside - cell).abs().max_element() <= WHOLE_CELL_SLACK * self.voxel_m;
        if whole {
            return (self.node(index), 1.0);
        }
        let share = inside / self.voxel_m;
        (low + 0.5 * inside, share.x * share.y * share.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(size_m: f64, voxel_m: f64) -> GridBox {
        GridBox {
            min: DVec3::ZERO,
            max: DVec3::splat(size_m),
            voxel_m,
        }
    }

    #[test]
    fn nodes_sit_in_the_middle_of_cells() {
        let grid = cube(10.0, 2.5);
        assert_eq!(grid.n_nodes().unwrap(), [4; 3]);
        assert_eq!(grid.node([0, 1, 3]), DVec3::new(1.25, 3.75, 8.75));
        assert_eq!(grid.covered([3; 3]), (DVec3::splat(8.75), 1.0));
    }

    #[test]
    fn roundoff_adds_no_layer_of_cells() {
        // 0.3/0.1 and 2.1/0.7 are a little above and below a whole number.
        assert_eq!(cube(0.3, 0.1).n_nodes().unwrap(), [3; 3]);
        assert_eq!(cube(2.1, 0.7).n_nodes().unwrap(), [3; 3]);
        assert_eq!(cube(0.1 + 0.2, 0.1).n_nodes().unwrap(), [3; 3]);
    }

    #[test]
    fn a_cell_that_sticks_out_counts_in_part() {
        let grid = cube(2.5, 1.0);
        assert_eq!(grid.n_nodes().unwrap(), [3; 3]);
        assert_eq!(grid.covered([2, 0, 0]), (DVec3::new(2.25, 0.5, 0.5), 0.5));
        assert!((grid.covered([2; 3]).1 - 0.125).abs() < 1e-15);
    }

    #[test]
    fn a_voxel_larger_than_the_box_is_one_node() {
        let grid = cube(0.5, 1.0);
        assert_eq!(grid.n_nodes().unwrap(), [1; 3]);
        assert!((grid.covered([0; 3]).1 - 0.125).abs() < 1e-15);
    }

    #[test]
    fn boxes_without_sense_are_refused() {
        for size_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                cube(size_m, 1.0).n_nodes(),
                Err(Error::BadBox { .. })
            ));
        }
        for voxel_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                cube(1.0, voxel_m).n_nodes(),
                Err(Error::BadBox { .. })
            ));
        }
    }

    #[test]
    fn a_lattice_that_would_not_fit_is_refused_with_its_size() {
        let error = cube(1e4, 1.0).n_nodes().unwrap_err();
        assert!(matches!(error, Error::TooManyNodes { .. }));
        let most = format!("{:.3e} nodes and", node_limit() as f64);
        for words in ["1.000e12 nodes", "need 29 TiB", &most] {
            assert!(error.to_string().contains(words), "{words} in {error}");
        }
        assert!(matches!(
            cube(1.0, 1e-300).n_nodes(),
            Err(Error::TooManyNodes { .. })
        ));
    }
}
