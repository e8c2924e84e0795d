//! What can be wrong with a file between two stages.

/// A file that cannot be read or written. The path is known to the caller.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The bytes are no sound EXR file.
    #[error("not a sound EXR file ({0}): it is truncated or damaged, make it again")]
    Damaged(String),
    /// The header promises more pixels than the file can hold.
    #[error(
        "the header promises {promised_bytes} bytes of pixels in a file of {file_bytes} bytes: it is \
         damaged, make it again"
    )]
    TooLarge {
        /// Bytes of pixels that the header describes.
        promised_bytes: u128,
        /// Length of the file.
        file_bytes: u64,
    },
    /// A value that may not enter a file.
    #[error("found {value} in part {part:?}, channel {channel:?}, pixel ({x}, {y}), expected a finite number")]
    NotFinite {
        /// Part of the file.
        part: String,
        /// Channel of the part.
        channel: String,
        /// Column, from 0 at the left.
        x: usize,
        /// Row, from 0 at the top.
        y: usize,
        /// What was found.
        value: f32,
    },
    /// An attribute is missing or has another type.
    #[error("found no {kind} attribute {name:?} in part {part:?}: this file was not written by niji, or by another version")]
    Attribute {
        /// Part of the file.
        part: String,
        /// Name of the attribute.
        name: String,
        /// `text` or `number`.
        kind: &'static str,
    },
    /// A part or a channel is missing.
    #[error("found no {kind} {name:?}")]
    Missing {
        /// `part` or `channel`.
        kind: &'static str,
        /// Its name.
        name: String,
    },
    /// Another kind of table.
    #[error("found a table of {found:?}, expected {expected:?}")]
    Quantity {
        /// What the file holds.
        found: String,
        /// What was asked for.
        expected: &'static str,
    },
    /// Two sizes that must agree do not.
    #[error("found {found} {what}, expected {expected}")]
    Shape {
        /// What is counted.
        what: String,
        /// The count found.
        found: usize,
        /// The count expected.
        expected: usize,
    },
    /// An axis that is empty, not ascending or not made of numbers.
    #[error("axis {name:?}: {problem}, expected ascending finite numbers")]
    Axis {
        /// Name of the axis.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// The wavelengths of a file are not equidistant or lie outside 300..1000 nm.
    #[error("wavelengths: {0}")]
    Wavelengths(String),
    /// The PNG encoder refused.
    #[error("cannot encode the preview: {0}")]
    Png(String),
}

impl From<exr::error::Error> for Error {
    fn from(error: exr::error::Error) -> Self {
        match error {
            exr::error::Error::Io(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                Self::Io(error)
            }
            other => Self::Damaged(other.to_string()),
        }
    }
}
