//! What can be wrong with a file between two stages.

use niji_radiometry::Bytes;

/// A file that cannot be read or written. The path is known to the caller.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The bytes are no sound EXR file.
    #[error("not a sound EXR file ({0}): it is truncated or damaged, make it again")]
    Damaged(String),
    /// The header promises more than the file can hold.
    #[error(
        "the header promises pixels that need at least {}, found a file of {}: it is truncated or damaged, \
         make it again", Bytes(*needed_bytes), Bytes(u128::from(*file_bytes))
    )]
    TooLarge {
        /// Fewest bytes that the promised pixels can take in a file.
        needed_bytes: u128,
        /// Length of the file.
        file_bytes: u64,
    },
    /// More pixels than may be held.
    #[error("found {needed} of pixels, expected at most {limit}, or there is no memory for them")]
    Memory {
        /// Size of the pixels.
        needed: Bytes,
        /// Size that they may have.
        limit: Bytes,
    },
    /// A sound EXR file of a kind that is not read here.
    #[error("found {found}, expected {expected}")]
    Layout {
        /// What the file holds.
        found: &'static str,
        /// What is read here.
        expected: &'static str,
    },
    /// Pixels or header values that are not those that were written.
    #[error(
        "part {part:?} does not fit its checksum: it is damaged or was edited by another program; \
         make it again, or remove the attribute niji:checksum to accept it"
    )]
    Checksum {
        /// Part of the file.
        part: String,
    },
    /// A name that EXR cannot hold.
    #[error("found {name:?} as the name of {}, expected 1 to 255 bytes without a zero", with_article(.kind))]
    Name {
        /// `part`, `channel` or `attribute`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Two of one name.
    #[error("found two {} of the name {name:?}, expected different names", plural(.kind))]
    Duplicate {
        /// `part`, `channel` or `axis`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A part without pixels.
    #[error("found no pixels in part {part:?}, expected at least one")]
    Empty {
        /// Part of the file.
        part: String,
    },
    /// Something that EXR cannot hold.
    #[error("this cannot be written as EXR: {0}")]
    Unwritable(String),
    /// A value that may not enter a file.
    #[error(
        "found {value} in part {part:?}, channel {channel:?}, pixel ({x}, {y}), expected a finite number"
    )]
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
    /// A number of a header that may not enter a file.
    #[error("found {value} in part {part:?}, attribute {name:?}, expected a finite number")]
    AttributeNotFinite {
        /// Part of the file.
        part: String,
        /// Name of the attribute.
        name: String,
        /// What was found.
        value: f64,
    },
    /// An exposure whose factor is no number.
    #[error("found an exposure of {found} EV, expected a finite number below 1024")]
    Exposure {
        /// What was found.
        found: f64,
    },
    /// A value below zero where there can be none.
    #[error(
        "found {value} in part {part:?}, channel {channel:?}, pixel ({x}, {y}), expected none below 0"
    )]
    Negative {
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
    #[error(
        "found no {kind} attribute {name:?} in part {part:?}: this file was not written by niji, or by another version"
    )]
    Attribute {
        /// Part of the file.
        part: String,
        /// Name of the attribute.
        name: String,
        /// `text` or `number`.
        kind: &'static str,
    },
    /// A part, a channel or an axis is missing.
    #[error("found no {kind} {name:?}")]
    Missing {
        /// `part`, `channel` or `axis`.
        kind: &'static str,
        /// Its name.
        name: String,
    },
    /// A picture of colors alone where spectra are needed.
    #[error(
        "found colors without spectra, expected spectra: render it with picture.spectral = \"full\" or \"half\" \
         (or --spectral)"
    )]
    NoSpectra,
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
    /// An axis that leaves its range.
    #[error("found {found} on axis {axis:?}, expected values from {min} to {max}")]
    Range {
        /// Name of the axis.
        axis: String,
        /// A value on it.
        found: f64,
        /// Smallest value that makes sense.
        min: f64,
        /// Largest value that makes sense.
        max: f64,
    },
    /// An axis in another unit.
    #[error("found axis {axis:?} in {found:?}, expected {expected:?}")]
    Unit {
        /// Name of the axis.
        axis: String,
        /// Its unit.
        found: String,
        /// The unit that was asked for.
        expected: &'static str,
    },
    /// The wavelengths of a file are not equidistant or lie outside 300..1000 nm.
    #[error("wavelengths: {0}")]
    Wavelengths(String),
    /// The PNG encoder refused.
    #[error("cannot encode the preview: {0}")]
    Png(String),
}

impl Error {
    pub(crate) fn missing(kind: &'static str, name: &str) -> Self {
        Self::Missing {
            kind,
            name: name.to_owned(),
        }
    }
}

fn with_article(kind: &str) -> String {
    let article = if kind.starts_with('a') { "an" } else { "a" };
    format!("{article} {kind}")
}

fn plural(kind: &str) -> String {
    match kind {
        "axis" => "axes".to_owned(),
        kind => format!("{kind}s"),
    }
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
