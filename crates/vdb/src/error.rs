//! What can be wrong with a VDB file, or with a tree that is to be written.

use std::path::PathBuf;

/// Every failure of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be opened or read.
    #[error("cannot read {}: {reason}", path.display())]
    Open {
        /// The file as it was named by the caller.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The output or input stream failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The first eight bytes are not those of a VDB file.
    #[error("not a VDB file: it starts with {found:#018x}, expected {expected:#018x}")]
    NotVdb {
        /// The first eight bytes, little-endian.
        found: u64,
        /// The magic number of a VDB file.
        expected: u64,
    },
    /// A file version outside the supported range.
    #[error("file version {found} is not supported, expected {oldest} to {newest}")]
    Version {
        /// The version of the file.
        found: u32,
        /// The oldest version that is read.
        oldest: u32,
        /// The newest version that is read.
        newest: u32,
    },
    /// The file ends inside something.
    #[error("the file ends at byte {length} inside {what}, which needs {needed} bytes more")]
    Truncated {
        /// What was being read.
        what: &'static str,
        /// Length of the file in bytes.
        length: u64,
        /// Bytes that are missing.
        needed: u64,
    },
    /// A stored number cannot be right.
    #[error("damaged at byte {position}: {what}")]
    Damaged {
        /// Where reading stood.
        position: u64,
        /// What was found and what was expected.
        what: String,
    },
    /// The decoded volume would need more memory than a sound file of this length can describe, or than may be used.
    #[error(
        "decoding needs more than {:.2} MiB, the most that may be used, or that a sound file of this length can need",
        *limit as f64 / 1_048_576.0
    )]
    TooLarge {
        /// The limit in bytes.
        limit: u64,
    },
    /// A grid that is an instance of a grid which the file has not yet shown.
    #[error("an instance of `{parent}`, which is no earlier grid of the file")]
    MissingParent {
        /// Unique name of the grid whose tree is to be shared.
        parent: String,
    },
    /// Valid for OpenVDB, but not read here.
    #[error("{what} `{found}` is not supported, expected {expected}")]
    Unsupported {
        /// The kind of thing: grid type, map, compression codec.
        what: &'static str,
        /// What the file holds.
        found: String,
        /// What would have been read.
        expected: &'static str,
    },
    /// A failure inside a grid.
    #[error("grid `{grid}`: {reason}")]
    InGrid {
        /// Name of the grid.
        grid: String,
        /// The failure itself.
        reason: Box<Error>,
    },
    /// A leaf or tile that does not lie on the lattice of its level.
    #[error("node origin {origin:?} is not a multiple of {dim}")]
    Misaligned {
        /// The lowest voxel of the leaf or tile.
        origin: [i32; 3],
        /// The edge length of the leaf or tile in voxels.
        dim: i32,
    },
    /// Two leaves or tiles that cover the same voxels.
    #[error("two nodes cover voxel {origin:?}")]
    Overlap {
        /// The lowest voxel that is covered twice.
        origin: [i32; 3],
    },
    /// A transform that cannot be inverted.
    #[error(
        "the transform has the determinant {determinant}, expected a finite number other than 0"
    )]
    SingularTransform {
        /// The determinant of the linear part.
        determinant: f64,
    },
}

impl Error {
    /// Whether a map was read, but is not one that can be used.
    pub(crate) fn is_of_a_map(&self) -> bool {
        matches!(
            self,
            Self::Unsupported { .. } | Self::SingularTransform { .. }
        )
    }

    /// Put the name of a grid around an error.
    pub(crate) fn in_grid(self, grid: &str) -> Self {
        Self::InGrid {
            grid: grid.to_owned(),
            reason: Box::new(self),
        }
    }
}
