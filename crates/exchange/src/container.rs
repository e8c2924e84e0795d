//! EXR files as this crate sees them: parts with named f32 channels and attributes.
//!
//! Tables and images share this layer. It checks what a header promises against the length of the
//! file before any pixel is read, so that a damaged header can neither panic nor exhaust memory.

use std::fs::File;
use std::io::BufReader;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;
use std::path::Path;

use exr::image::AnyChannel;
use exr::image::AnyChannels;
use exr::image::Encoding;
use exr::image::FlatImage;
use exr::image::FlatSamples;
use exr::image::Image;
use exr::image::Layer;
use exr::image::read::read;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::write::WritableImage;
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue as ExrValue;
use exr::meta::attribute::Chromaticities;
use exr::meta::attribute::IntegerBounds;
use exr::meta::attribute::Text;
use exr::meta::header::ImageAttributes;
use exr::meta::header::LayerAttributes;
use ndarray::Array2;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::canonical_header::CanonicalHeader;
use crate::error::Error;

/// Pixels that a small file may unpack to, whatever its length: 64 MiB.
const ALWAYS_ALLOWED_BYTES: u128 = 64 << 20;
/// How often the pixels may be longer than the file: deflate packs at most about 1030 to 1.
const MAX_EXPANSION: u128 = 2000;
/// Bytes of a sample in memory.
const SAMPLE_BYTES: u128 = 4;

/// Codec of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    /// For tables, which are read often.
    None,
    /// For noisy pictures: smaller than deflate and three times as fast to write.
    Piz,
}

/// One part of a file.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) channels: Vec<(String, Array2<f32>)>,
    pub(crate) attributes: Attributes,
    pub(crate) white_luminance_cd_m2: Option<f64>,
    pub(crate) world_to_camera: Option<[f32; 16]>,
}

impl Part {
    pub(crate) fn new(name: &str, channels: Vec<(String, Array2<f32>)>) -> Self {
        Self {
            name: name.to_owned(),
            channels,
            attributes: Attributes::new(),
            white_luminance_cd_m2: None,
            world_to_camera: None,
        }
    }

    /// Takes a channel out of the part.
    pub(crate) fn take(&mut self, name: &str) -> Result<Array2<f32>, Error> {
        let missing = || Error::Missing { kind: "channel", name: name.to_owned() };
        let index = self.channels.iter().position(|channel| channel.0 == name);
        Ok(self.channels.swap_remove(index.ok_or_else(missing)?).1)
    }

    pub(crate) fn text(&self, name: &str) -> Result<&str, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Text(text)) => Ok(text),
            Some(AttributeValue::Number(_)) | None => Err(self.no_attribute(name, "text")),
        }
    }

    pub(crate) fn number(&self, name: &str) -> Result<f64, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Number(number)) => Ok(*number),
            Some(AttributeValue::Text(_)) | None => Err(self.no_attribute(name, "number")),
        }
    }

    fn no_attribute(&self, name: &str, kind: &'static str) -> Error {
        Error::Attribute { part: self.name.clone(), name: name.to_owned(), kind }
    }
}

/// Linear Rec.709 with a D65 white.
fn rec709() -> Chromaticities {
    Chromaticities {
        red: exr::math::Vec2(0.64, 0.33),
        green: exr::math::Vec2(0.30, 0.60),
        blue: exr::math::Vec2(0.15, 0.06),
        white: exr::math::Vec2(0.3127, 0.3290),
    }
}

/// Writes parts in their order.
///
/// # Errors
/// A value that is not finite, a channel of another size than the first of its part, or whatever
/// the encoder or the writer reports.
pub(crate) fn write(parts: Vec<Part>, codec: Codec, writer: impl Write + Seek) -> Result<(), Error> {
    for part in &parts {
        check(part)?;
    }
    let window = parts.iter().map(size).fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(window));
    attributes.chromaticities = Some(rec709());
    let layers = parts.into_iter().map(|part| layer(part, codec)).collect::<Vec<_>>();
    let image = Image::from_layers(attributes, layers);
    let mut writer = CanonicalHeader::new(writer);
    // Readers of layered files want each part's window inside the display window: it is.
    image.write().to_buffered(&mut writer)?;
    Ok(writer.finish()?)
}

fn size(part: &Part) -> (usize, usize) {
    let (height, width) = part.channels.first().map_or((1, 1), |(_, values)| values.dim());
    (width, height)
}

fn check(part: &Part) -> Result<(), Error> {
    let (width, height) = size(part);
    for (name, values) in &part.channels {
        if values.dim() != (height, width) {
            let what = format!("pixels in channel {name:?} of part {:?}", part.name);
            return Err(Error::Shape { what, found: values.len(), expected: width * height });
        }
        let not_finite = values.indexed_iter().find(|(_, value)| !value.is_finite());
        if let Some(((y, x), &value)) = not_finite {
            let (part, channel) = (part.name.clone(), name.clone());
            return Err(Error::NotFinite { part, channel, x, y, value });
        }
    }
    Ok(())
}

fn layer(part: Part, codec: Codec) -> Layer<AnyChannels<FlatSamples>> {
    let (width, height) = size(&part);
    let mut attributes = LayerAttributes::named(part.name.as_str());
    attributes.white_luminance = part.white_luminance_cd_m2.map(|luminance| luminance as f32);
    attributes.world_to_camera = part.world_to_camera;
    for (name, value) in &part.attributes {
        let value = match value {
            AttributeValue::Text(text) => ExrValue::Text(Text::from(text.as_str())),
            AttributeValue::Number(number) => ExrValue::F64(*number),
        };
        attributes.other.insert(Text::from(name.as_str()), value);
    }
    let encoding = match codec {
        Codec::None => Encoding::UNCOMPRESSED,
        Codec::Piz => Encoding {
            compression: exr::compression::Compression::PIZ,
            ..Encoding::FAST_LOSSLESS
        },
    };
    let channels = part.channels.into_iter().map(|(name, values)| {
        let values = values.as_standard_layout().into_owned();
        let (values, _) = values.into_raw_vec_and_offset();
        AnyChannel::new(name.as_str(), FlatSamples::F32(values))
    });
    let channels = AnyChannels::sort(channels.collect());
    Layer::new((width, height), attributes, encoding, channels)
}

/// Reads all parts of a file.
///
/// # Errors
/// A missing, truncated or damaged file, or a header that promises more than the file can hold.
pub(crate) fn read_parts(path: &Path) -> Result<Vec<Part>, Error> {
    let mut file = File::open(path)?;
    let file_bytes = file.metadata()?.len();
    let meta = MetaData::read_from_buffered(BufReader::new(&file), false)?;
    let promised_bytes: u128 = meta
        .headers
        .iter()
        .map(|header| header.layer_size.area() as u128 * header.channels.list.len() as u128)
        .sum::<u128>()
        * SAMPLE_BYTES;
    if promised_bytes > ALWAYS_ALLOWED_BYTES.max(MAX_EXPANSION * u128::from(file_bytes)) {
        return Err(Error::TooLarge { promised_bytes, file_bytes });
    }
    file.seek(SeekFrom::Start(0))?;
    let image: FlatImage = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(BufReader::with_capacity(1 << 20, file))?;
    image.layer_data.into_iter().map(part).collect()
}

fn part(layer: Layer<AnyChannels<FlatSamples>>) -> Result<Part, Error> {
    let name = layer.attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
    let (width, height) = (layer.size.width(), layer.size.height());
    let mut channels = Vec::with_capacity(layer.channel_data.list.len());
    for channel in layer.channel_data.list {
        let samples = match channel.sample_data {
            FlatSamples::F32(samples) => samples,
            FlatSamples::F16(samples) => samples.into_iter().map(|value| value.to_f32()).collect(),
            // Integers above 2^24 lose digits; no file of ours holds any.
            FlatSamples::U32(samples) => samples.into_iter().map(|value| value as f32).collect(),
        };
        let found = samples.len();
        let values = Array2::from_shape_vec((height, width), samples).map_err(|_| {
            let what = format!("pixels in channel {} of part {name:?}", channel.name);
            Error::Shape { what, found, expected: width * height }
        })?;
        channels.push((channel.name.to_string(), values));
    }
    let mut attributes = Attributes::new();
    for (name, value) in layer.attributes.other {
        let value = match value {
            ExrValue::Text(text) => AttributeValue::Text(text.to_string()),
            ExrValue::F64(number) => AttributeValue::Number(number),
            ExrValue::F32(number) => AttributeValue::Number(f64::from(number)),
            // Attributes of other tools that this crate has no use for.
            _ => continue,
        };
        attributes.insert(name.to_string(), value);
    }
    Ok(Part {
        name,
        channels,
        attributes,
        white_luminance_cd_m2: layer.attributes.white_luminance.map(f64::from),
        world_to_camera: layer.attributes.world_to_camera,
    })
}
