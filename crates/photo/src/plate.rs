//! EXR plates of other programs, and depth maps as EXR.
//!
//! Scan lines or tiles, any compression, the first layer that has the channels. What the header
//! promises is compared with the length of the file before any pixel is decoded.

use std::path::Path;

use exr::prelude::AnyChannels;
use exr::prelude::AttributeValue;
use exr::prelude::FlatSamples;
use exr::prelude::MetaData;
use exr::prelude::ReadChannels;
use exr::prelude::ReadLayers;
use exr::prelude::Text;
use exr::prelude::read as read_file;
use ndarray::Array2;

use crate::error::Error;
use crate::photograph::LinearPicture;
use crate::photograph::check_size;

/// Name of the attribute with the unit of a part, in the images of `niji render`.
const UNIT: &str = "niji:unit";
/// Names of the channels of a plate.
const COLORS: [&str; 3] = ["R", "G", "B"];

/// Reads R, G and B.
pub(crate) fn read_colors(path: &Path) -> Result<LinearPicture, Error> {
    let layers = layers(path)?;
    let [red, green, blue] = COLORS.map(|name| plane(&layers, name));
    let missing = |index: usize| Error::MissingChannel(COLORS[index]);
    let red = red.ok_or_else(|| missing(0))?;
    let green = green.ok_or_else(|| missing(1))?;
    let blue = blue.ok_or_else(|| missing(2))?;
    if green.dim() != red.dim() || blue.dim() != red.dim() {
        return Err(Error::Damaged(
            "found channels of different sizes".to_owned(),
        ));
    }
    for (name, plane) in COLORS.into_iter().zip([&red, &green, &blue]) {
        check_finite(name, plane)?;
    }
    Ok(Array2::from_shape_fn(red.dim(), |at| {
        [red[at], green[at], blue[at]]
    }))
}

/// Reads the channel Z of the first part that has one, or the only channel there is. Infinity and
/// NaN are the sky and allowed.
pub(crate) fn read_depth(path: &Path) -> Result<Array2<f32>, Error> {
    let layers = layers(path)?;
    if let Some(layer) = layers.iter().find(|layer| layer.holds("Z")) {
        if let Some(unit) = layer.unit.as_ref().filter(|unit| *unit != "m") {
            return Err(Error::DepthUnit(unit.clone()));
        }
        return plane(std::slice::from_ref(layer), "Z").ok_or(Error::NoDepthChannel);
    }
    match layers.as_slice() {
        [layer] if layer.channels.len() == 1 => Ok(layer.channels[0].1.clone()),
        _ => Err(Error::NoDepthChannel),
    }
}

struct Layer {
    channels: Vec<(String, Array2<f32>)>,
    /// Unit of its values, if it says so.
    unit: Option<String>,
}

impl Layer {
    fn holds(&self, name: &str) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|(channel, _)| channel.rsplit('.').next() == Some(name))
    }
}

fn plane(layers: &[Layer], name: &str) -> Option<Array2<f32>> {
    let is_it = |channel: &str| channel.rsplit('.').next() == Some(name);
    let mut channels = layers.iter().flat_map(|layer| &layer.channels);
    channels
        .find(|(channel, _)| is_it(channel))
        .map(|(_, values)| values.clone())
}

fn layers(path: &Path) -> Result<Vec<Layer>, Error> {
    let file_bytes = std::fs::metadata(path)?.len();
    let header = MetaData::read_from_file(path, false).map_err(damaged)?;
    for part in &header.headers {
        let size = part.layer_size;
        check_size(size.width() as u64, size.height() as u64, file_bytes)?;
    }
    let picture = read_file()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .map_err(damaged)?;
    picture
        .layer_data
        .into_iter()
        .map(|layer| {
            let size = (layer.size.height(), layer.size.width());
            let unit = layer.attributes.other.get(&Text::from(UNIT));
            let unit = match unit {
                Some(AttributeValue::Text(text)) => Some(text.to_string()),
                Some(_) | None => None,
            };
            channels(layer.channel_data, size).map(|channels| Layer { channels, unit })
        })
        .collect()
}

fn channels(
    data: AnyChannels<FlatSamples>,
    size: (usize, usize),
) -> Result<Vec<(String, Array2<f32>)>, Error> {
    data.list
        .into_iter()
        .map(|channel| {
            let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
            let plane = Array2::from_shape_vec(size, values)
                .map_err(|error| Error::Damaged(error.to_string()))?;
            Ok((channel.name.to_string(), plane))
        })
        .collect()
}

fn check_finite(channel: &'static str, plane: &Array2<f32>) -> Result<(), Error> {
    let found = plane.indexed_iter().find(|(_, value)| !value.is_finite());
    match found {
        Some(((y, x), &value)) => Err(Error::NotFinite {
            channel,
            x,
            y,
            value,
        }),
        None => Ok(()),
    }
}

fn damaged(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::Io(error)
        }
        other => Error::Damaged(other.to_string()),
    }
}
