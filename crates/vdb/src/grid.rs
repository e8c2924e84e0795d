//! A file, its grids, and the types of their trees.

use std::io::Cursor;
use std::io::Seek;
use std::io::Write;
use std::path::Path;

use half::f16;

use crate::Error;
use crate::FloatTree;
use crate::GridHeader;
use crate::Metadata;
use crate::SparseTree;
use crate::Transform;
use crate::input::open;
use crate::read::Archive;

/// Class of a grid whose values are densities: 0 outside, above 0 inside.
pub const FOG_VOLUME: &str = "fog volume";

/// Class of a grid whose values are signed distances to a surface.
pub const LEVEL_SET: &str = "level set";

/// How the voxels of a file are stored; in either case only active voxels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// As they are: fast, and the right choice for noisy values, which do not shrink.
    None,
    /// Deflated, one leaf at a time.
    Zip,
}

/// A tree of one of the types that are read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Tree {
    /// `float`, in the file as 32 or 16 bits.
    Float(FloatTree),
    /// `double`, in the file as 64 or 16 bits.
    Double(SparseTree<f64>),
    /// `half`: 16 bits in memory and in the file, which then is of version 225.
    Half(SparseTree<f16>),
    /// `vec3s`, in the file as three times 32 or 16 bits.
    Vec3s(SparseTree<[f32; 3]>),
    /// `int32`.
    Int32(SparseTree<i32>),
    /// `bool`.
    Bool(SparseTree<bool>),
}

impl Tree {
    /// The tree, if its values are floats.
    pub fn as_float(&self) -> Option<&FloatTree> {
        match self {
            Self::Float(tree) => Some(tree),
            Self::Double(_) | Self::Half(_) | Self::Vec3s(_) | Self::Int32(_) | Self::Bool(_) => {
                None
            }
        }
    }

    /// Bytes that the leaves and tiles take in memory.
    pub(crate) fn memory(&self) -> u64 {
        match self {
            Self::Float(tree) => tree.memory(),
            Self::Double(tree) => tree.memory(),
            Self::Half(tree) => tree.memory(),
            Self::Vec3s(tree) => tree.memory(),
            Self::Int32(tree) => tree.memory(),
            Self::Bool(tree) => tree.memory(),
        }
    }
}

impl From<FloatTree> for Tree {
    fn from(tree: FloatTree) -> Self {
        Self::Float(tree)
    }
}

impl From<SparseTree<f64>> for Tree {
    fn from(tree: SparseTree<f64>) -> Self {
        Self::Double(tree)
    }
}

impl From<SparseTree<f16>> for Tree {
    fn from(tree: SparseTree<f16>) -> Self {
        Self::Half(tree)
    }
}

impl From<SparseTree<[f32; 3]>> for Tree {
    fn from(tree: SparseTree<[f32; 3]>) -> Self {
        Self::Vec3s(tree)
    }
}

impl From<SparseTree<i32>> for Tree {
    fn from(tree: SparseTree<i32>) -> Self {
        Self::Int32(tree)
    }
}

impl From<SparseTree<bool>> for Tree {
    fn from(tree: SparseTree<bool>) -> Self {
        Self::Bool(tree)
    }
}

/// A named volume in world space.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Name; names need not differ inside a file.
    pub name: String,
    /// What the values mean: [`FOG_VOLUME`], [`LEVEL_SET`], `staggered` or `unknown`.
    pub class: String,
    /// Further items. Those that OpenVDB derives from the grid (`name`, `class`, `file_…`,
    /// `is_saved_as_half_float`) are read as they are and replaced when written.
    pub metadata: Metadata,
    /// Index space to world space.
    pub transform: Transform,
    /// The voxels.
    pub tree: Tree,
}

impl Grid {
    /// A grid without further metadata.
    pub fn new(
        name: impl Into<String>,
        class: impl Into<String>,
        transform: Transform,
        tree: impl Into<Tree>,
    ) -> Self {
        let metadata = Metadata::new();
        Self {
            name: name.into(),
            class: class.into(),
            metadata,
            transform,
            tree: tree.into(),
        }
    }
}

/// The content of a VDB file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VdbFile {
    /// Items that belong to the file as a whole.
    pub metadata: Metadata,
    /// The grids in the order of the file.
    pub grids: Vec<Grid>,
}

impl VdbFile {
    /// A file without metadata of its own.
    pub fn new(grids: Vec<Grid>) -> Self {
        Self {
            metadata: Metadata::new(),
            grids,
        }
    }

    /// The first grid of that name.
    pub fn grid(&self, name: &str) -> Option<&Grid> {
        self.grids.iter().find(|grid| grid.name == name)
    }

    /// Read a file, in pieces: memory is needed for the voxels, not for the file beside them.
    /// Leaves are decoded in parallel, with the same result for any number of threads.
    ///
    /// # Errors
    /// [`Error::Open`] if the file cannot be read, else as for [`VdbFile::parse`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::read_grids(path, |_| true)
    }

    /// Read the grids that are wanted; the voxels of the others are passed over, and may be of types
    /// that are not read.
    ///
    /// # Errors
    /// As for [`VdbFile::read`].
    pub fn read_grids(path: &Path, wanted: impl Fn(&GridHeader) -> bool) -> Result<Self, Error> {
        Self::read_within(path, u64::MAX, wanted)
    }

    /// The same in so much memory at most, however long the file is.
    ///
    /// # Errors
    /// As for [`VdbFile::read`].
    pub fn read_within(
        path: &Path,
        most_bytes: u64,
        wanted: impl Fn(&GridHeader) -> bool,
    ) -> Result<Self, Error> {
        let (file, length) = open(path)?;
        let mut archive = Archive::open(file, length)?;
        archive.limit_memory(most_bytes);
        archive.grids(wanted)
    }

    /// Read a file that lies in memory.
    ///
    /// # Errors
    /// Any [`Error`] that says why the bytes are not a VDB file of a supported kind.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let length = bytes.len() as u64;
        Archive::open(Cursor::new(bytes), length)?.grids(|_| true)
    }

    /// Write a file of version 224. The same content always gives the same bytes.
    ///
    /// # Errors
    /// [`Error::Io`] if the stream fails.
    pub fn write(&self, output: impl Write + Seek, compression: Compression) -> Result<(), Error> {
        crate::write::file(self, output, compression)
    }
}
