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
/// # Errors
/// A value that is not finite, two parts or channels of one name, or a writer that fails.
pub fn write_plain(parts: &[PlainPart], writer: impl Write + Seek) -> Result<(), Error> {
    let borrowed: Vec<Part> = parts.iter().map(borrow).collect();
    exr_write::write(&borrowed, Codec::Piz, writer)
}

fn borrow(plain: &PlainPart) -> Part<'_> {
    let channels = plain.channels.iter();
    let channels = channels.map(|channel| (channel.name.clone(), channel.values.view().into()));
    Part::new(&plain.name, channels.collect())
}
