//! The root mean squares of the channels of a layer, which its header tells without its pixels.

use std::path::Path;

use crate::attributes::AttributeValue;
use crate::error::Error;
use crate::exr_read;
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

/// Name of the attribute of a channel.
pub(crate) fn attribute(channel: &str) -> String {
    format!("{RMS}{channel}")
}

/// The sum of the squares of samples, which are added one after the other to those before them.
pub(crate) fn add_squares(before: f64, samples: &Samples) -> f64 {
    (samples.iter()).fold(before, |sum, it| sum + f64::from(*it).powi(2))
}

/// The root of the mean of so many squares.
pub(crate) fn of_squares(sum: f64, n: usize) -> f64 {
    (sum / n.max(1) as f64).sqrt()
}

fn rms(samples: &Samples) -> f64 {
    of_squares(add_squares(0.0, samples), samples.len())
}
