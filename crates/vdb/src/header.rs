//! What a file says about its grids before their voxels.

use std::path::Path;

use crate::Error;
use crate::Metadata;
use crate::Transform;
use crate::input::open;
use crate::read;

/// A grid without its voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct GridHeader {
    /// Name; names need not differ inside a file.
    pub name: String,
    /// What the values mean, see [`crate::Grid::class`].
    pub class: String,
    /// Type of the tree as the file names it: `Tree_float_5_4_3`, for example, with `_HalfFloat`
    /// behind it if reals are stored as halves. Also types that are not read.
    pub grid_type: String,
    /// Name of the earlier grid whose voxels this one shares.
    pub instance_of: Option<String>,
    /// Further items: all but `name` and `class`.
    pub metadata: Metadata,
    /// Index space to world space; `None` if the map is not linear or cannot be inverted.
    pub transform: Option<Transform>,
}

/// The content of a VDB file without the voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct VdbHeader {
    /// Version of the file format.
    pub file_version: u32,
    /// Items that belong to the file as a whole.
    pub metadata: Metadata,
    /// The grids in the order of the file.
    pub grids: Vec<GridHeader>,
}

impl VdbHeader {
    /// Read what stands in front of the voxels: a few kilobytes, however large the file is. Only a
    /// file that was written to a stream, without offsets, must be decoded to the end.
    ///
    /// # Errors
    /// As for [`VdbHeader::parse`], and [`Error::Open`] if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let (file, length) = open(path)?;
        Ok(read::Archive::open(file, length)?.into_header())
    }

    /// The same for a file that lies in memory.
    ///
    /// # Errors
    /// Any [`Error`] that says why the bytes are not a VDB file. Grids of other types and maps that
    /// are not linear are no error, unless the file has no offsets.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let length = bytes.len() as u64;
        Ok(read::Archive::open(std::io::Cursor::new(bytes), length)?.into_header())
    }

    /// The first grid of that name.
    pub fn grid(&self, name: &str) -> Option<&GridHeader> {
        self.grids.iter().find(|grid| grid.name == name)
    }
}
