//! EXR plates of other programs, and depth maps as EXR.
//!
//! Scan lines or tiles, any compression, half or float, any data window, the first layer that has the
//! channels. The attribute `chromaticities` says what R, G and B are: Rec.709 where it is missing. What
//! the header promises is compared with the length of the file before any pixel is decoded.

use std::path::Path;

use exr::prelude::AnyChannels;
use exr::prelude::AttributeValue;
use exr::prelude::FlatSamples;
use exr::prelude::MetaData;
use exr::prelude::ReadChannels;
use exr::prelude::ReadLayers;
use exr::prelude::Text;
use exr::prelude::Vec2;
use exr::prelude::attribute::Chromaticities;
use exr::prelude::read as read_file;
use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::guarded;
use niji_geometry::PixelRegion;
use niji_radiometry::RgbPrimaries;

use crate::compositing::check_size as check_size_of_plane;
use crate::compositing::on_region;
use crate::depth_map::metres;
use crate::error::Error;
use crate::linear_picture::LinearPicture;
use crate::linear_picture::check_memory;
use crate::linear_picture::check_size;
use crate::photograph::opened;
use crate::picture_files::to_f32;

/// Name of the attribute with the unit of a part, in the images of `niji render`.
const UNIT: &str = "niji:unit";
/// Names of the channels of a plate.
const COLORS: [&str; 3] = ["R", "G", "B"];
const ALPHA: &str = "A";
const DEPTH: &str = "Z";

/// Memory that a value takes while a file is read: as it stands there, as a float, and in the picture.
const SAMPLE_BYTES: u128 = 12;

/// A picture of another program that a bow is set into.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Its light, scene-linear, premultiplied where there is an alpha.
    pub light: LinearPicture,
    /// What R, G and B are.
    pub primaries: RgbPrimaries,
    /// Which pixels of the frame it holds.
    pub windows: ImageWindows,
    /// Its channel A, if it has one.
    pub alpha: Option<Array2<f32>>,
    /// The channel Z beside its colors, if there is one: distances of its surfaces along the view ray,
    /// m, infinite for the sky.
    pub surface_m: Option<Array2<f32>>,
}

impl Plate {
    /// Reads an EXR file with channels R, G and B; `primaries` replace those that the file names.
    ///
    /// # Errors
    /// A missing or damaged file, one without the channels or with unknown chromaticities, a value
    /// that is not finite, or a distance below 0.
    pub fn read(path: &Path, primaries: Option<RgbPrimaries>) -> Result<Self, Error> {
        let file = layers(path)?;
        let layer = file.layers.iter().find(|layer| layer.holds(COLORS[0]));
        let layer = std::slice::from_ref(layer.ok_or(Error::MissingChannel(COLORS[0]))?);
        let primaries = primaries.map_or_else(|| known(file.chromaticities), Ok)?;
        let alpha = plane(layer, ALPHA);
        if let Some(alpha) = &alpha {
            check_finite(ALPHA, alpha)?;
        }
        let surface_m = depth_channel(layer)?;
        let surface_m = surface_m.map(|(_, values)| metres(values)).transpose()?;
        let light = colors(layer)?;
        let windows = ImageWindows {
            data: layer[0].data,
            display: file.display,
        };
        for (what, size) in [
            ("a channel A", alpha.as_ref().map(Array2::dim)),
            ("a channel Z", surface_m.as_ref().map(Array2::dim)),
        ] {
            check_size_of_plane(what, light.dim(), size.unwrap_or(light.dim()))?;
        }
        Ok(Self {
            light,
            primaries,
            windows,
            alpha,
            surface_m,
        })
    }
}

/// Reads R, G and B as linear Rec.709.
pub(crate) fn read_colors(path: &Path) -> Result<LinearPicture, Error> {
    let file = layers(path)?;
    let primaries = known(file.chromaticities)?;
    let mut light = colors(&file.layers)?;
    if primaries != RgbPrimaries::Rec709 {
        light.par_mapv_inplace(|rgb| to_f32(primaries.to_linear_rec709(rgb.map(f64::from))));
    }
    Ok(light)
}

fn colors(layers: &[Layer]) -> Result<LinearPicture, Error> {
    let [red, green, blue] = COLORS.map(|name| plane(layers, name));
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

/// The primaries that a file names.
fn known(chromaticities: Option<Chromaticities>) -> Result<RgbPrimaries, Error> {
    let Some(found) = chromaticities else {
        return Ok(RgbPrimaries::Rec709);
    };
    let corners = [found.red, found.green, found.blue, found.white];
    let corners = corners.map(|Vec2(x, y)| [f64::from(x), f64::from(y)]);
    RgbPrimaries::of_chromaticities(corners).ok_or(Error::Primaries(corners))
}

/// Reads the channel of distances, or the only channel there is. Infinity and NaN are the sky and allowed.
pub(crate) fn read_depth(path: &Path) -> Result<Array2<f32>, Error> {
    let layers = layers(path)?.layers;
    depth(&layers).map(|(_, values)| values.clone())
}

/// The same on the pixels of the frame (display window): what lies beside it is left out, and where the file holds none
/// is the sky.
pub(crate) fn read_depth_of_frame(path: &Path) -> Result<Array2<f32>, Error> {
    let file = layers(path)?;
    let (layer, values) = depth(&file.layers)?;
    if layer.data == file.display {
        return Ok(values.clone());
    }
    let frame = file.display;
    check_memory(SAMPLE_BYTES * u128::from(frame.width_px) * u128::from(frame.height_px))?;
    Ok(on_region(values, layer.data, frame, f32::INFINITY))
}

fn depth(layers: &[Layer]) -> Result<(&Layer, &Array2<f32>), Error> {
    // A rendered image, which begins with its light: its depth is that of drops.
    if let Some(first) = layers.iter().find(|layer| layer.holds(DEPTH)) {
        first.check_metres()?;
    }
    match (depth_channel(layers)?, layers) {
        (Some(found), _) => Ok(found),
        (None, [layer]) if layer.channels.len() == 1 => Ok((layer, &layer.channels[0].1)),
        (None, _) => Err(Error::NoDepthChannel),
    }
}

/// The channel of distances: `Z`, else that of a layer `depth`, else the only one whose name ends so. Beside an X of the
/// same layer a Z is part of a color, a normal or a place.
fn depth_channel(layers: &[Layer]) -> Result<Option<(&Layer, &Array2<f32>)>, Error> {
    let found: Vec<_> = layers
        .iter()
        .flat_map(|layer| layer.channels.iter().map(move |channel| (layer, channel)))
        .filter_map(|(layer, (name, values))| Some((layer.distances(name)?, layer, values)))
        .collect();
    let is_named = |prefix: &str| {
        let of_depth = prefix.trim_end_matches('.').rsplit('.').next();
        of_depth.is_some_and(|name| name.eq_ignore_ascii_case("depth"))
    };
    let plain = found.iter().find(|(prefix, ..)| prefix.is_empty());
    let named = || found.iter().find(|(prefix, ..)| is_named(prefix));
    let (_, layer, values) = match (plain.or_else(named), &found[..]) {
        (Some(found), _) | (None, [found]) => found,
        (None, []) => return Ok(None),
        (None, several) => {
            let names = several
                .iter()
                .map(|(prefix, ..)| format!("{prefix}{DEPTH}"));
            return Err(Error::DepthChannels(names.collect()));
        }
    };
    layer.check_metres()?;
    Ok(Some((layer, values)))
}

/// What a file holds.
struct File {
    layers: Vec<Layer>,
    chromaticities: Option<Chromaticities>,
    display: PixelRegion,
}

struct Layer {
    channels: Vec<(String, Array2<f32>)>,
    /// Unit of its values, if it says so.
    unit: Option<String>,
    /// Its data window.
    data: PixelRegion,
}

impl Layer {
    /// Refuses values in another unit than metres.
    fn check_metres(&self) -> Result<(), Error> {
        match &self.unit {
            Some(unit) if unit != "m" => Err(Error::DepthUnit(unit.clone())),
            Some(_) | None => Ok(()),
        }
    }

    /// What stands before the Z of a channel of distances.
    fn distances<'a>(&self, name: &'a str) -> Option<&'a str> {
        let prefix = name.strip_suffix(DEPTH)?;
        let beside = format!("{prefix}X");
        let is_distance = (prefix.is_empty() || prefix.ends_with('.'))
            && !self.channels.iter().any(|(other, _)| *other == beside);
        is_distance.then_some(prefix)
    }

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

fn layers(path: &Path) -> Result<File, Error> {
    guarded(Error::Damaged, || read_layers(path))
}

fn read_layers(path: &Path) -> Result<File, Error> {
    let file_bytes = opened(path)?.1;
    let header = MetaData::read_from_file(path, false).map_err(damaged)?;
    let mut n_samples = 0;
    for part in &header.headers {
        let size = part.layer_size;
        let sides = [size.width() as u64, size.height() as u64];
        check_size(sides, 8 * part.channels.bytes_per_pixel as u64, file_bytes)?;
        n_samples += size.area() as u128 * part.channels.list.len() as u128;
    }
    check_memory(SAMPLE_BYTES * n_samples)?;
    let picture = read_file()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        // A panic of a codec in a thread of the crate would end the program.
        .non_parallel()
        .from_file(path)
        .map_err(damaged)?;
    let shared = picture.attributes;
    let layers = picture.layer_data.into_iter().map(|layer| {
        let size = (layer.size.height(), layer.size.width());
        let unit = layer.attributes.other.get(&Text::from(UNIT));
        let unit = match unit {
            Some(AttributeValue::Text(text)) => Some(text.to_string()),
            Some(_) | None => None,
        };
        let data = region(layer.attributes.layer_position, layer.size)?;
        channels(layer.channel_data, size).map(|channels| Layer {
            channels,
            unit,
            data,
        })
    });
    Ok(File {
        layers: layers.collect::<Result<_, _>>()?,
        chromaticities: shared.chromaticities,
        display: region(shared.display_window.position, shared.display_window.size)?,
    })
}

fn region(position: Vec2<i32>, size: Vec2<usize>) -> Result<PixelRegion, Error> {
    let too_large = |_| Error::Damaged("found a window that no picture has".to_owned());
    let region = PixelRegion {
        x_px: position.x(),
        y_px: position.y(),
        width_px: u32::try_from(size.width()).map_err(too_large)?,
        height_px: u32::try_from(size.height()).map_err(too_large)?,
    };
    Ok(region.checked()?)
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
