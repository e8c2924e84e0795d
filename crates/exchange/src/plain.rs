//! EXR files as they lie, whoever wrote them: named channels of numbers, for comparisons.

use std::io::Seek;
use std::io::Write;
use std::path::Path;

use crate::error::Error;
use crate::exr_read;
use crate::exr_write;
use crate::exr_write::Codec;
use crate::part::Part;
use crate::table::Channel;

/// One part of a file without its attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainPart {
    /// Its name; empty in files of one unnamed part.
    pub name: String,
    /// Its channels, all of one size.
    pub channels: Vec<Channel>,
}

/// Reads all channels of all parts.
///
/// # Errors
/// If the file is missing, truncated or damaged, or holds a value that is not finite.
pub fn read_plain(path: &Path) -> Result<Vec<PlainPart>, Error> {
    let channel = |(name, values): (String, crate::part::Samples)| Channel {
        name,
        values: values.into_owned(),
    };
    let part = |part: Part<'static>| PlainPart {
        name: part.name,
        channels: part.channels.into_iter().map(channel).collect(),
    };
    Ok(exr_read::read_parts(path)?.into_iter().map(part).collect())
}

/// Writes parts without attributes.
///
/// ```
/// use ndarray::array;
/// use niji_exchange::{Channel, PlainPart, read_plain, write_plain};
///
/// let channels = vec![Channel { name: "Y".to_owned(), values: array![[0.5, 1.0]] }];
/// let unnamed = [PlainPart { name: String::new(), channels }];
/// let mut bytes = std::io::Cursor::new(Vec::new());
/// write_plain(&unnamed, &mut bytes)?;
///
/// let path = std::env::temp_dir().join(format!("niji-plain-{}.exr", std::process::id()));
/// std::fs::write(&path, bytes.get_ref())?;
/// assert_eq!(read_plain(&path)?, unnamed);
/// std::fs::remove_file(&path)?;
/// # Ok::<(), niji_exchange::Error>(())
/// ```
///
/// # Errors
/// A value that is not finite, two parts or channels of one name, one of several parts without a name, or a writer
/// that fails.
pub fn write_plain(parts: &[PlainPart], writer: impl Write + Seek) -> Result<(), Error> {
    let borrowed: Vec<Part> = parts.iter().map(borrow).collect();
    exr_write::write(&borrowed, Codec::Piz, writer)
}

fn borrow(plain: &PlainPart) -> Part<'_> {
    let channels = plain.channels.iter();
    let channels = channels.map(|channel| (channel.name.clone(), channel.values.view().into()));
    Part::new(&plain.name, channels.collect())
}
