//! What can be wrong with a drop volume or with the file that should hold one.

use niji_radiometry::Bytes;

use crate::grid_box::NODE_BYTES;
use crate::grid_box::node_limit;

/// Every failure of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A box without volume, or voxels without size.
    #[error(
        "no lattice fits the box from {min:?} to {max:?} m with voxels of {voxel_m} m: expected \
         finite corners, max above min on every axis, and a voxel size above zero"
    )]
    BadBox {
        /// Lowest corner (m).
        min: [f64; 3],
        /// Highest corner (m).
        max: [f64; 3],
        /// Edge length of a voxel (m).
        voxel_m: f64,
    },
    /// The lattice would not fit into memory.
    #[error(
        "the volume would have {nodes:.3e} nodes and need {needed}, expected at most {limit:.3e} nodes and \
         {most}: take larger voxels or a smaller box"
    )]
    TooManyNodes {
        /// Number of nodes asked for.
        nodes: f64,
        /// Memory that they would need.
        needed: Bytes,
        /// Largest number of nodes.
        limit: f64,
        /// Memory that these need.
        most: Bytes,
    },
    /// A shape gave drops that cannot be.
    #[error("{quantity} = {value} at node {node:?}, expected {expected}")]
    BadDrops {
        /// Which of the three numbers of a node.
        quantity: &'static str,
        /// What was found.
        value: f32,
        /// Index of the node.
        node: [i32; 3],
        /// What would have been right.
        expected: &'static str,
    },
    /// A mode name that cannot be told apart in a file.
    #[error("mode name `{name}`: {reason}")]
    BadModeName {
        /// The name.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A grid that a drop volume needs is not in the file.
    #[error("grid `{expected}` is missing; the file holds {found:?}")]
    MissingGrid {
        /// Name of the missing grid.
        expected: String,
        /// Names of the grids that are there.
        found: Vec<String>,
    },
    /// Two grids of a name of which there can be one.
    #[error(
        "grid `{grid}` is there twice, expected once: give one of them a prefix, as in `mist_{grid}`"
    )]
    GridTwice {
        /// Name of both.
        grid: String,
    },
    /// A grid of the right name with values of the wrong type.
    #[error("grid `{grid}` does not hold floats")]
    NotFloat {
        /// Name of the grid.
        grid: String,
    },
    /// Grids of one mode lie on different lattices.
    #[error("grid `{grid}` and grid `{reference}` have different transforms")]
    TransformMismatch {
        /// Name of the deviating grid.
        grid: String,
        /// Name of the grid that it was compared with.
        reference: String,
    },
    /// A lattice that is not made of axis-parallel cubes.
    #[error(
        "grid `{grid}`: the transform is not a uniform scale and a translation, so that its voxels \
         are no axis-parallel cubes; resample it to such a lattice first (`resampleToMatch` in \
         OpenVDB, the node VDB Resample in Houdini)"
    )]
    NotCubic {
        /// Name of the grid.
        grid: String,
    },
    /// A voxel that describes no possible drops.
    #[error("grid `{grid}`: {value} at voxel {voxel:?}, expected {expected}")]
    BadVoxel {
        /// Name of the grid.
        grid: String,
        /// Index of the voxel.
        voxel: [i32; 3],
        /// What was found.
        value: f32,
        /// What would have been right.
        expected: &'static str,
    },
    /// Space outside all voxels is not empty.
    #[error("grid `{grid}` has the background {value}, expected 0")]
    Background {
        /// Name of the grid.
        grid: String,
        /// What was found.
        value: f32,
    },
    /// Voxels too far from the origin of the lattice.
    #[error("grid `{grid}` has voxels with an index above {farthest} or below -{farthest}")]
    TooFar {
        /// Name of the grid.
        grid: String,
        /// The largest index.
        farthest: i32,
    },
    /// A grid in other units.
    #[error("grid `{grid}` is in units of `{found}`, expected `{expected}`")]
    Units {
        /// Name of the grid.
        grid: String,
        /// The unit in the file.
        found: String,
        /// The unit that is read.
        expected: &'static str,
    },
    /// A grid of signed distances where a density is asked for.
    #[error(
        "grid `{grid}` is a level set, whose values are distances to a surface; convert it to a fog \
         volume first (`sdfToFogVolume` in OpenVDB, the node Convert VDB in Houdini)"
    )]
    LevelSet {
        /// Name of the grid.
        grid: String,
    },
    /// Values that are no densities: vectors.
    #[error("grid `{grid}` holds vectors, expected one number a voxel")]
    NotScalar {
        /// Name of the grid.
        grid: String,
    },
    /// A formula that is none.
    #[error("the formula `{formula}` has {found} at column {column}, expected {expected}")]
    BadFormula {
        /// As it was given.
        formula: String,
        /// From 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What could.
        expected: String,
    },
    /// A name in a formula that no grid has.
    #[error(
        "the formula `{formula}` names `{name}` at column {column}; the file holds the grids {grids:?}"
    )]
    UnknownName {
        /// As it was given.
        formula: String,
        /// From 1.
        column: usize,
        /// The name.
        name: String,
        /// Those that there are.
        grids: Vec<String>,
    },
    /// A setting of an import outside its range.
    #[error("{parameter} = {found}, expected {expected}")]
    BadSetting {
        /// Name of the setting, with its unit.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// Written by a later version of this program.
    #[error("drop volume format {found} is newer than {newest}, the newest that is read")]
    FormatVersion {
        /// The version in the file.
        found: i32,
        /// The newest version that is read.
        newest: i32,
    },
    /// The tree itself is not sound.
    #[error("the volume cannot be laid out as a VDB tree")]
    Vdb(#[from] niji_vdb::Error),
}

impl Error {
    pub(crate) fn too_many_nodes(nodes: f64) -> Self {
        let limit = node_limit() as f64;
        let [needed, most] = [nodes, limit].map(|nodes| Bytes::of(nodes * NODE_BYTES as f64));
        Self::TooManyNodes {
            nodes,
            needed,
            limit,
            most,
        }
    }
}
