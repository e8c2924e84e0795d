//! OpenVDB files: read and write, grids, trees and metadata.
//!
//! A sparse volume is a [`SparseTree`]: leaves of 8³ voxels and constant [`Tile`]s of 8³, 128³ or
//! 4096³ voxels over a background value. A [`Grid`] gives a tree a name and a [`Transform`] from
//! index space to world space; a [`VdbFile`] holds any number of grids.
//!
//! Reads file versions 222 to 225 (OpenVDB 2.0 to 13) with float, double, half, vec3s, int32 and
//! bool grids, reals also saved as halves, uncompressed, zip or Blosc, with any linear map; a
//! [`VdbHeader`] reads what stands in front of the voxels alone, and [`VdbFile::read_grids`] some of
//! the grids. Writes version 224 (225 for halves), uncompressed or zip, with a UUID made from the
//! content, so that equal volumes give equal bytes. A [`FrameSequence`] names the files of an
//! animation. Leaves are decoded and encoded in parallel. Everything else is a typed [`Error`] that names the grid.
//!
//! The layout follows the OpenVDB library, <https://github.com/AcademySoftwareFoundation/openvdb>,
//! and \[Mus13\] K. Museth, "VDB: High-Resolution Sparse Volumes with Dynamic Topology",
//! ACM Transactions on Graphics 32(3), 27 (2013).
//!
//! ```
//! use niji_vdb::{Compression, FOG_VOLUME, FloatTree, Grid, Leaf, Transform, VdbFile};
//! use glam::DVec3;
//!
//! let mut leaf = Leaf::new([0, 8, -16], 0.0);
//! leaf.set([3, 9, -10], 0.25);
//! let tree = FloatTree::from_leaves(0.0, vec![leaf])?;
//! let transform = Transform::uniform_scale_translate(0.5, DVec3::new(100.0, 0.0, 0.0));
//! let file = VdbFile::new(vec![Grid::new("density", FOG_VOLUME, transform, tree)]);
//!
//! let mut bytes = std::io::Cursor::new(Vec::new());
//! file.write(&mut bytes, Compression::None)?;
//! let again = VdbFile::parse(bytes.get_ref())?;
//! let density = again.grid("density").and_then(|grid| grid.tree.as_float()).expect("just written");
//! assert_eq!(density.get([3, 9, -10]), 0.25);
//! # Ok::<(), niji_vdb::Error>(())
//! ```

mod blosc;
mod decode;
mod encode;
mod error;
mod grid;
mod header;
mod input;
mod items;
mod maps;
mod metadata;
mod output;
mod read;
mod read_tree;
mod sequence;
mod source;
mod transform;
mod tree;
mod value;
mod write;
mod write_tree;

pub use error::Error;
pub use grid::Compression;
pub use grid::FOG_VOLUME;
pub use grid::Grid;
pub use grid::LEVEL_SET;
pub use grid::Tree;
pub use grid::VdbFile;
pub use header::GridHeader;
pub use header::VdbHeader;
pub use metadata::MetaValue;
pub use metadata::Metadata;
pub use sequence::FrameSequence;
pub use transform::Transform;
pub use tree::FloatTree;
pub use tree::LEAF_DIM;
pub use tree::LEAF_VOXELS;
pub use tree::Leaf;
pub use tree::SparseTree;
pub use tree::Tile;
pub use tree::TileLevel;
pub use value::Value;
