//! Pictures as files for people (PNG, JPEG) and for compositors (EXR).
//!
//! PNG and JPEG hold sRGB code values of min(c, 1); EXR holds linear Rec.709 or ACEScg as 32-bit floats
//! with their chromaticities, premultiplied: RGB may be above 0 where A is 0. Where a file comes from stands
//! in the text items of a PNG and in the comments of an EXR, whose further attributes the writer would
//! put in an order that changes from run to run. The same picture gives the same bytes.

use std::io::Seek;
use std::io::Write;

use exr::compression::Compression;
use exr::image::Blocks;
use exr::image::Encoding as ExrEncoding;
use exr::meta::attribute::LineOrder;
use exr::prelude::AnyChannel;
use exr::prelude::AnyChannels;
use exr::prelude::FlatSamples;
use exr::prelude::Image;
use exr::prelude::IntegerBounds;
use exr::prelude::Layer;
use exr::prelude::LayerAttributes;
use exr::prelude::SmallVec;
use exr::prelude::Text;
use exr::prelude::Vec2;
use exr::prelude::WritableImage;
use exr::prelude::attribute::Chromaticities;
use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::write_srgb_png;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::srgb_encode;
use rayon::prelude::*;

use crate::error::Error;
use crate::linear_picture::LinearPicture;

/// Quality of JPEG files, 1 to 100.
const JPEG_QUALITY: u8 = 92;
/// Entries of the table of code values for 8 bit.
const N_CODES: usize = 1 << 14;
/// A distance for what has none, m: compositors take it for infinity.
pub(crate) const NO_DEPTH_M: f32 = 1e10;

/// Writes an 8-bit sRGB PNG.
///
/// # Errors
/// A value that is not finite, or a writer that fails.
pub fn write_png(
    picture: &LinearPicture,
    provenance: &Provenance,
    writer: impl Write,
) -> Result<(), Error> {
    let codes = codes_8(picture)?;
    let (height, width) = picture.dim();
    write_srgb_png(&codes, [width, height], provenance, writer).map_err(unencoded)
}

/// Writes a JPEG.
///
/// # Errors
/// As [`write_png`], or sides above 65535 pixels.
pub fn write_jpeg(picture: &LinearPicture, writer: impl Write) -> Result<(), Error> {
    let codes = codes_8(picture)?;
    let (height, width) = picture.dim();
    JpegEncoder::new_with_quality(writer, JPEG_QUALITY)
        .write_image(&codes, width as u32, height as u32, ExtendedColorType::Rgb8)
        .map_err(unencoded)
}

/// What the pixels of an EXR picture are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// What R, G and B are.
    pub primaries: RgbPrimaries,
    /// Which pixels of the frame there are.
    pub windows: ImageWindows,
}

/// A premultiplied picture for compositors.
#[derive(Clone, Copy, Debug)]
pub struct PremultipliedPicture<'a> {
    /// Linear RGB; it may be above 0 where alpha is 0.
    pub light: &'a LinearPicture,
    /// Alpha, 0..1, if it has one.
    pub alpha: Option<&'a Array2<f32>>,
    /// What its pixels are.
    pub frame: Frame,
}

impl PremultipliedPicture<'_> {
    /// Writes an EXR: R, G, B and, where it is given, A.
    ///
    /// # Errors
    /// A value that is not finite, or a writer that fails.
    pub fn write_exr(
        &self,
        provenance: &Provenance,
        writer: impl Write + Seek,
    ) -> Result<(), Error> {
        check_finite(self.light)?;
        let mut channels = Vec::new();
        if let Some(alpha) = self.alpha {
            channels.push(("A", plane(alpha, |value| *value)));
        }
        for (index, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((name, plane(self.light, |pixel| pixel[index])));
        }
        let mut attributes = described(provenance);
        let data = self.frame.windows.data;
        attributes.layer_position = Vec2(data.x_px, data.y_px);
        let layer = Layer::new(
            (data.width_px as usize, data.height_px as usize),
            attributes,
            ExrEncoding {
                compression: Compression::ZIP16,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
            planes(channels),
        );
        let mut image = Image::from_layer(layer);
        let display = self.frame.windows.display;
        image.attributes.display_window = IntegerBounds {
            position: Vec2(display.x_px, display.y_px),
            size: Vec2(display.width_px as usize, display.height_px as usize),
        };
        image.attributes.chromaticities = Some(chromaticities(self.frame.primaries));
        image.write().to_buffered(writer).map_err(unencoded)
    }
}

/// A depth map as an EXR of one layer.
pub(crate) fn write_depth(
    depth_m: &Array2<f32>,
    provenance: &Provenance,
    writer: impl Write + Seek,
) -> Result<(), Error> {
    let (height, width) = depth_m.dim();
    let values = plane(depth_m, |depth| depth.min(NO_DEPTH_M));
    // Layers are plain: a hundredth of their size is left.
    let layer = Layer::new(
        (width, height),
        described(provenance),
        ExrEncoding::SMALL_LOSSLESS,
        planes(vec![("Z", values)]),
    );
    let image = Image::from_layer(layer);
    image.write().to_buffered(writer).map_err(unencoded)
}

fn planes(channels: Vec<(&'static str, Vec<f32>)>) -> AnyChannels<FlatSamples> {
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)))
        .collect();
    AnyChannels::sort(channels)
}

/// Where a file comes from.
fn described(provenance: &Provenance) -> LayerAttributes {
    let items = provenance.to_text_items().into_iter();
    let lines: Vec<String> = items.map(|(name, text)| format!("{name}={text}")).collect();
    LayerAttributes {
        software_name: Text::new_or_none(format!("niji {}", provenance.version)),
        comments: Text::new_or_none(lines.join("\n")),
        ..LayerAttributes::default()
    }
}

fn chromaticities(primaries: RgbPrimaries) -> Chromaticities {
    let [red, green, blue, white] = primaries
        .chromaticities()
        .map(|[x, y]| Vec2(x as f32, y as f32));
    Chromaticities {
        red,
        green,
        blue,
        white,
    }
}

/// Values as files hold them.
pub(crate) fn to_f32(rgb: [f64; 3]) -> [f32; 3] {
    rgb.map(|channel| channel as f32)
}

fn plane<T: Sync>(values: &Array2<T>, value: impl Fn(&T) -> f32 + Sync + Send) -> Vec<f32> {
    values.iter().map(value).collect()
}

/// sRGB code values of 8 bit, by a table: a powf for each of 72 million values takes seconds.
fn codes_8(picture: &LinearPicture) -> Result<Vec<u8>, Error> {
    check_finite(picture)?;
    // Entry i holds the code of (i/N)²: near black the curve is steep, and so is the root.
    let table: Vec<u8> = (0..=N_CODES)
        .map(|index| {
            let root = index as f64 / N_CODES as f64;
            (255.0 * srgb_encode(root * root)).round() as u8
        })
        .collect();
    let code = |value: f32| {
        let root = value.clamp(0.0, 1.0).sqrt();
        table[(root * N_CODES as f32 + 0.5) as usize]
    };
    let pixels: Vec<[f32; 3]> = picture.iter().copied().collect();
    Ok(pixels
        .into_par_iter()
        .with_min_len(1 << 12)
        .flat_map_iter(|pixel| pixel.map(code))
        .collect())
}

fn check_finite(picture: &LinearPicture) -> Result<(), Error> {
    for ((y, x), pixel) in picture.indexed_iter() {
        for (channel, value) in ["R", "G", "B"].into_iter().zip(pixel) {
            if !value.is_finite() {
                let value = *value;
                return Err(Error::NotFinite {
                    channel,
                    x,
                    y,
                    value,
                });
            }
        }
    }
    Ok(())
}

fn unencoded(error: impl std::fmt::Display) -> Error {
    Error::Encode(error.to_string())
}
