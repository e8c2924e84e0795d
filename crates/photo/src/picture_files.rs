//! Pictures as files for people (PNG, JPEG) and for compositors (EXR).
//!
//! PNG and JPEG hold sRGB code values of min(c, 1); EXR holds linear Rec.709 as 32-bit floats with
//! its chromaticities, premultiplied: RGB may be above 0 where A is 0. Where a file comes from stands
//! in the text items of a PNG and in the comments of an EXR, whose further attributes the writer would
//! put in an order that changes from run to run. The same picture gives the same bytes.

use std::io::Seek;
use std::io::Write;

use exr::image::Encoding as ExrEncoding;
use exr::prelude::AnyChannel;
use exr::prelude::AnyChannels;
use exr::prelude::FlatSamples;
use exr::prelude::Image;
use exr::prelude::Layer;
use exr::prelude::LayerAttributes;
use exr::prelude::SmallVec;
use exr::prelude::Text;
use exr::prelude::WritableImage;
use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use ndarray::Array2;
use niji_exchange::Provenance;
use niji_exchange::write_srgb_png;
use niji_radiometry::srgb_encode;
use rayon::prelude::*;

use crate::error::Error;
use crate::photograph::LinearPicture;

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

/// Writes a premultiplied EXR: R, G, B, A.
///
/// # Errors
/// A value that is not finite, or a writer that fails.
pub fn write_premultiplied(
    picture: &LinearPicture,
    alpha: &Array2<f32>,
    provenance: &Provenance,
    writer: impl Write + Seek,
) -> Result<(), Error> {
    check_finite(picture)?;
    let mut channels = vec![("A", plane(alpha, |value| *value))];
    for (index, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push((name, plane(picture, |pixel| pixel[index])));
    }
    let encoding = ExrEncoding::FAST_LOSSLESS;
    write_exr(picture.dim(), channels, (encoding, provenance), writer)
}

/// Writes planes as an EXR of one layer.
pub(crate) fn write_exr(
    (height, width): (usize, usize),
    channels: Vec<(&'static str, Vec<f32>)>,
    (encoding, provenance): (ExrEncoding, &Provenance),
    writer: impl Write + Seek,
) -> Result<(), Error> {
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)))
        .collect();
    let items = provenance.to_text_items().into_iter();
    let lines: Vec<String> = items.map(|(name, text)| format!("{name}={text}")).collect();
    let attributes = LayerAttributes {
        software_name: Text::new_or_none(format!("niji {}", provenance.version)),
        comments: Text::new_or_none(lines.join("\n")),
        ..LayerAttributes::default()
    };
    let layer = Layer::new(
        (width, height),
        attributes,
        encoding,
        AnyChannels::sort(channels),
    );
    Image::from_layer(layer)
        .write()
        .to_buffered(writer)
        .map_err(unencoded)
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
