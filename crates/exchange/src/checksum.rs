//! Notices damage that the format cannot see.
//!
//! checksum = SHA-256(name, attributes `niji:…`, white, camera, place in the frame unless (0, 0),
//!            SHA-256 of every channel)
//! EXR itself protects only deflated blocks; a flipped bit in an uncompressed table would pass as
//! another number. Channels are hashed in parallel and combined in the order of their names.
//! [FIPS180] NIST FIPS 180-4, Secure Hash Standard (2015).

use std::fmt::Write as _;

use rayon::prelude::*;
use sha2::Digest;
use sha2::Sha256;

use crate::attributes::AttributeValue;
use crate::error::Error;
use crate::part::Part;
use crate::part::Samples;
use crate::part::append;

/// Name of the attribute.
pub(crate) const NAME: &str = "niji:checksum";
/// Attributes that other programs add or change are not covered.
const COVERED: &str = "niji:";

/// The channels of a part, as far as their rows have come.
pub(crate) struct ChannelHashes(Vec<Sha256>);

impl ChannelHashes {
    /// Of as many channels, before the first row.
    pub(crate) fn new(n_channels: usize) -> Self {
        Self(vec![Sha256::new(); n_channels])
    }

    /// Adds the next rows of all channels.
    pub(crate) fn add(&mut self, channels: &[(String, Samples)]) {
        let hashes = self.0.par_iter_mut().zip(channels);
        hashes.for_each(|(hasher, (_, samples))| {
            let mut bytes = Vec::with_capacity(size_of::<f32>() * samples.ncols());
            for row in samples.rows() {
                bytes.clear();
                append(&mut bytes, &row, f32::to_le_bytes);
                hasher.update(&bytes);
            }
        });
    }

    /// The checksum in hexadecimal of a part of so many rows and columns, whose channels these are.
    pub(crate) fn checksum(&self, part: &Part, (height, width): (usize, usize)) -> String {
        let mut channels: Vec<(&String, &Sha256)> = (part.channels.iter())
            .map(|(name, _)| name)
            .zip(&self.0)
            .collect();
        channels.sort_by_key(|(name, _)| *name);
        let mut hasher = Sha256::new();
        let mut add = |bytes: &[u8]| {
            // Lengths keep neighbors apart.
            hasher.update((bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        add(part.name.as_bytes());
        for (name, value) in &part.attributes {
            if name.starts_with(COVERED) && name != NAME {
                add(name.as_bytes());
                match value {
                    AttributeValue::Text(text) => add(text.as_bytes()),
                    AttributeValue::Number(number) => add(&number.to_le_bytes()),
                }
            }
        }
        let standard = part
            .white_luminance_cd_m2
            .iter()
            .chain(part.world_to_camera.iter().flatten());
        for number in standard {
            add(&number.to_le_bytes());
        }
        let place = part.windows.map_or((0, 0), |w| (w.data.x_px, w.data.y_px));
        if place != (0, 0) {
            add(&place.0.to_le_bytes());
            add(&place.1.to_le_bytes());
        }
        for (name, hash) in channels {
            add(name.as_bytes());
            add(&(height as u64).to_le_bytes());
            add(&(width as u64).to_le_bytes());
            add(&hash.clone().finalize());
        }
        hexadecimal(&hasher.finalize())
    }
}

/// The checksum of a part in hexadecimal.
fn of(part: &Part) -> String {
    let mut hashes = ChannelHashes::new(part.channels.len());
    hashes.add(&part.channels);
    hashes.checksum(part, part.size())
}

/// Compares a part with the checksum in its header, if there is one.
pub(crate) fn verify(part: &Part) -> Result<(), Error> {
    match part.attributes.get(NAME) {
        Some(AttributeValue::Text(stated)) if *stated != of(part) => Err(Error::Checksum {
            part: part.name.clone(),
        }),
        Some(_) | None => Ok(()),
    }
}

/// Bytes in hexadecimal.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
