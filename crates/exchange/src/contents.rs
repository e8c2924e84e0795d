//! What an EXR file holds, whoever wrote it: parts, channels with their extremes, attributes.

use std::path::Path;

use crate::attributes::Attributes;
use crate::error::Error;
use crate::exr_read;
use crate::part::Part;

/// A channel and the range of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelRange {
    /// Name of the channel.
    pub name: String,
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
    /// Mean of all values.
    pub mean: f64,
}

/// A part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartContents {
    /// Its name; empty in files of one unnamed part.
    pub name: String,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Its channels.
    pub channels: Vec<ChannelRange>,
    /// Texts and numbers of its header.
    pub attributes: Attributes,
}

/// Reads a file and says what it holds.
///
/// # Errors
/// If the file is missing, truncated or damaged, or holds a value that is not finite.
pub fn contents(path: &Path) -> Result<Vec<PartContents>, Error> {
    let parts = exr_read::read_parts(path)?;
    Ok(parts.into_iter().map(part_contents).collect())
}

fn part_contents(part: Part) -> PartContents {
    let (height, width) = part.size();
    let channels = part.channels.iter().map(|(name, values)| {
        let n = values.len().max(1) as f64;
        ChannelRange {
            name: name.clone(),
            min: values.iter().copied().fold(f32::INFINITY, f32::min),
            max: values.iter().copied().fold(f32::NEG_INFINITY, f32::max),
            mean: values.iter().map(|&value| f64::from(value)).sum::<f64>() / n,
        }
    });
    let channels = channels.collect();
    PartContents {
        name: part.name,
        width,
        height,
        channels,
        attributes: part.attributes,
    }
}
