//! The root mean squares of the channels of a layer, which its header tells without its pixels.

use std::path::Path;

use crate::attributes::AttributeValue;
use crate::error::Error;
use crate::exr_read;
use crate::part::Part;
use crate::part::Samples;
use crate::spectral_image::Aov;

/// Prefix of the attributes, before the name of the channel.
const RMS: &str = "niji:rms.";

/// Root mean squares over the pixels of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerRms {
    /// Name of the layer.
    pub name: String,
    /// By channel, in the unit of the layer; in the order of their names after reading.
    pub channels: Vec<(String, f64)>,
}

impl LayerRms {
    /// That of a layer in memory.
    #[must_use]
    pub fn of(layer: &Aov) -> Self {
        let channels = layer.channels.iter();
        let channels = channels.map(|(name, values)| (name.clone(), rms(&values.view().into())));
        Self {
            name: layer.name.clone(),
            channels: channels.collect(),
        }
    }

    /// Those of the layers of light of a spectral image, from its headers; none of a file by another program.
    ///
    /// # Errors
    /// If the file is missing, its headers are damaged, or it is shorter than they promise.
    pub fn read(path: &Path) -> Result<Vec<Self>, Error> {
        let headers = exr_read::read_headers(path)?.into_iter();
        let layers = headers.map(|(name, attributes)| {
            let numbers = attributes.into_iter().filter_map(|(name, value)| {
                let AttributeValue::Number(value) = value else {
                    return None;
                };
                Some((name.strip_prefix(RMS)?.to_owned(), value))
            });
            Self {
                name,
                channels: numbers.collect(),
            }
        });
        Ok(layers.filter(|it| !it.channels.is_empty()).collect())
    }

    /// That of a channel; 0 where there is none.
    #[must_use]
    pub fn of_channel(&self, name: &str) -> f64 {
        let mut channels = self.channels.iter();
        channels.find(|it| it.0 == name).map_or(0.0, |it| it.1)
    }
}

/// Tells in the header of a part what its channels are as they are written.
pub(crate) fn insert(part: &mut Part) {
    for (name, samples) in &part.channels {
        let rms = AttributeValue::Number(rms(samples));
        part.attributes.insert(format!("{RMS}{name}"), rms);
    }
}

fn rms(samples: &Samples) -> f64 {
    let squares: f64 = samples.iter().map(|it| f64::from(*it).powi(2)).sum();
    (squares / samples.len().max(1) as f64).sqrt()
}
