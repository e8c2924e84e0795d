//! Photographs as linear light.
//!
//! PNG (8 and 16 bit) and JPEG hold sRGB code values (IEC 61966-2-1), or what their
//! [color profile](crate::color_profile) says; they become linear Rec.709. EXR plates are linear already; ACEScg
//! becomes Rec.709. The orientation that a camera writes is applied, so that row 0 is the top of the
//! scene. Transparency is dropped.

use std::fs::File;
use std::io::BufRead;
use std::io::BufReader;
use std::io::Cursor;
use std::io::Read;
use std::io::Seek;
use std::io::SeekFrom;
use std::path::Path;

use image::DynamicImage;
use image::ImageDecoder;
use image::ImageFormat;
use image::ImageReader;
use image::Limits;
use image::metadata::Orientation;
use ndarray::Array2;
use niji_exchange::guarded;
use niji_radiometry::open_file;
use rayon::prelude::*;

use crate::color_profile::Colors;
use crate::color_profile::Profile;
use crate::error::Error;
use crate::exif_notes::ExifNotes;
use crate::jpeg_end::has_end_of_image;
use crate::linear_picture::LinearPicture;
use crate::linear_picture::MOST_PIXELS;
use crate::linear_picture::check_memory;
use crate::linear_picture::check_size;
use crate::plate;

/// Memory that a decoder may ask for, in bytes: 16 for each of [`MOST_PIXELS`].
const MOST_DECODER_BYTES: u64 = 16 * MOST_PIXELS;
/// Memory that a pixel takes as linear light and where it is worked on.
const LIGHT_BYTES: u128 = 64;
/// First bytes of an EXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// What the values of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// 8 bit: 0..1 after decoding, above 1 where a profile has more saturated colors than Rec.709.
    Srgb8,
    /// 16 bit, likewise.
    Srgb16,
    /// Scene-referred linear light of an EXR plate, without an upper end.
    Linear,
}

/// A photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// Its light, upright.
    pub light: LinearPicture,
    /// What its values were.
    pub encoding: Encoding,
    /// What the camera noted.
    pub notes: ExifNotes,
    /// Its color profile, if it has one.
    pub profile: Option<Profile>,
}

impl Photograph {
    /// Reads a PNG, JPEG or EXR picture, told apart by their first bytes.
    ///
    /// # Errors
    /// A missing, empty, truncated or damaged file, one of another kind, or a header that promises
    /// more pixels than the file can hold.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let (mut file, file_bytes) = opened(path)?;
        if is_exr(&mut file)? {
            return Ok(Self {
                light: plate::read_colors(path)?,
                encoding: Encoding::Linear,
                notes: ExifNotes::default(),
                profile: None,
            });
        }
        read_coded(file, file_bytes)
    }

    /// Width and height in pixels of one in a file, of a PNG or JPEG without decoding it.
    ///
    /// # Errors
    /// As [`Self::read`], but for damage of the pixels.
    pub fn size_in(path: &Path) -> Result<[usize; 2], Error> {
        let (mut file, file_bytes) = opened(path)?;
        if is_exr(&mut file)? {
            let (height, width) = plate::read_colors(path)?.dim();
            return Ok([width, height]);
        }
        guarded(Error::Damaged, || {
            let mut decoder = decoder(BufReader::new(file), file_bytes)?;
            let (width, height) = decoder.dimensions();
            let [width, height] = [width, height].map(|n| n as usize);
            let is_turned = [
                Orientation::Rotate90,
                Orientation::Rotate270,
                Orientation::Rotate90FlipH,
                Orientation::Rotate270FlipH,
            ]
            .contains(&decoder.orientation().map_err(damaged)?);
            Ok(if is_turned {
                [height, width]
            } else {
                [width, height]
            })
        })
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.light.ncols()
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.light.nrows()
    }
}

/// Linear light of a PNG or JPEG in memory as its rows stand there, whatever way up a camera was held: a texture.
///
/// # Errors
/// As [`Photograph::read`].
pub fn read_texture(bytes: &[u8]) -> Result<LinearPicture, Error> {
    if bytes.is_empty() {
        return Err(Error::Empty);
    }
    let stored = guarded(Error::Damaged, || {
        Stored::decode(Cursor::new(bytes), bytes.len() as u64)
    })?;
    Ok(linearize(&stored.picture, &Colors::Srgb)?.0)
}

/// A file that is not empty and ends, and its length.
pub(crate) fn opened(path: &Path) -> Result<(File, u64), Error> {
    let (file, file_bytes) = open_file(path)?;
    if file_bytes == 0 {
        return Err(Error::Empty);
    }
    Ok((file, file_bytes))
}

/// Whether a file begins as EXR; it is at its start again.
fn is_exr(file: &mut File) -> Result<bool, Error> {
    let mut magic = [0; 4];
    let n_bytes = file.read(&mut magic)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(n_bytes == 4 && magic == EXR_MAGIC)
}

fn read_coded(mut file: File, file_bytes: u64) -> Result<Photograph, Error> {
    let gamma = guarded(Error::Damaged, || Ok(gamma_of_png(BufReader::new(&file))))?;
    file.rewind()?;
    let stored = decode(file, file_bytes)?;
    let (colors, profile) = match &stored.profile {
        Some(bytes) => {
            let (colors, profile) = guarded(Error::Damaged, || Ok(Colors::of_profile(bytes)))?;
            (colors, Some(profile))
        }
        None => (gamma.map_or(Colors::Srgb, Colors::of_gamma), None),
    };
    let (light, encoding) = linearize(&stored.picture, &colors)?;
    Ok(Photograph {
        light,
        encoding,
        notes: stored.exif.map(ExifNotes::parse).unwrap_or_default(),
        profile,
    })
}

/// The code values, upright, and what is said of them.
pub(crate) fn decode(file: File, file_bytes: u64) -> Result<Stored, Error> {
    guarded(Error::Damaged, || {
        let source = BufReader::with_capacity(1 << 18, file);
        let mut stored = Stored::decode(source, file_bytes)?;
        stored.picture.apply_orientation(stored.orientation);
        Ok(stored)
    })
}

/// A picture as a file has it.
pub(crate) struct Stored {
    pub(crate) picture: DynamicImage,
    orientation: Orientation,
    exif: Option<Vec<u8>>,
    /// Color profile.
    profile: Option<Vec<u8>>,
}

/// What decodes a PNG or JPEG of so many bytes, which could hold as many pixels as it promises.
fn decoder<'a>(
    mut source: impl BufRead + Seek + 'a,
    n_bytes: u64,
) -> Result<impl ImageDecoder + 'a, Error> {
    let format = ImageReader::new(&mut source)
        .with_guessed_format()?
        .format();
    if format == Some(ImageFormat::Jpeg) {
        source.seek(SeekFrom::Start(0))?;
        if !has_end_of_image(&mut source)? {
            return Err(Error::Damaged(
                "found no end of the JPEG picture".to_owned(),
            ));
        }
    }
    source.seek(SeekFrom::Start(0))?;
    let mut reader = ImageReader::new(source);
    match format {
        Some(format) if [ImageFormat::Jpeg, ImageFormat::Png].contains(&format) => {
            reader.set_format(format);
        }
        Some(_) | None => return Err(Error::UnknownFormat),
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_DECODER_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    // A pixel of a PNG may be one bit.
    check_size([width, height].map(u64::from), 1, n_bytes)?;
    let n_pixels = u128::from(width) * u128::from(height);
    check_memory(2 * u128::from(decoder.total_bytes()) + LIGHT_BYTES * n_pixels)?;
    Ok(decoder)
}

impl Stored {
    fn decode(source: impl BufRead + Seek, n_bytes: u64) -> Result<Self, Error> {
        let mut decoder = decoder(source, n_bytes)?;
        Ok(Self {
            orientation: decoder.orientation().map_err(damaged)?,
            exif: decoder.exif_metadata().map_err(damaged)?,
            profile: decoder.icc_profile().map_err(damaged)?,
            picture: DynamicImage::from_decoder(decoder).map_err(damaged)?,
        })
    }
}

/// The exponent that a PNG names, if it names neither profile nor sRGB. A header that cannot be read names none: who
/// reads the pixels says what is wrong.
fn gamma_of_png(source: impl BufRead + Seek) -> Option<f64> {
    let reader = png::Decoder::new(source).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() || info.icc_profile.is_some() {
        return None;
    }
    info.gama_chunk.map(|gamma| f64::from(gamma.into_value()))
}

fn damaged(error: image::ImageError) -> Error {
    match error {
        image::ImageError::IoError(error)
            if error.kind() != std::io::ErrorKind::UnexpectedEof
                && error.kind() != std::io::ErrorKind::InvalidData =>
        {
            Error::Io(error)
        }
        other => Error::Damaged(other.to_string()),
    }
}

fn linearize(picture: &DynamicImage, colors: &Colors) -> Result<(LinearPicture, Encoding), Error> {
    let size = (picture.height() as usize, picture.width() as usize);
    let is_deep = picture.color().bytes_per_pixel() / picture.color().channel_count() > 1;
    let (pixels, encoding) = if is_deep {
        let code = picture.to_rgb16();
        (light_of(code.as_raw(), colors)?, Encoding::Srgb16)
    } else if let Some(code) = picture.as_rgb8() {
        (light_of(code.as_raw(), colors)?, Encoding::Srgb8)
    } else {
        let code = picture.to_rgb8();
        (light_of(code.as_raw(), colors)?, Encoding::Srgb8)
    };
    let light =
        Array2::from_shape_vec(size, pixels).map_err(|error| Error::Damaged(error.to_string()))?;
    Ok((light, encoding))
}

/// Code values to linear light through a table of all of them.
fn light_of<T: Copy + Into<usize> + Bounded + Sync>(
    codes: &[T],
    colors: &Colors,
) -> Result<Vec<[f32; 3]>, Error> {
    let mut tables = [const { Vec::new() }; 3];
    for (channel, table) in tables.iter_mut().enumerate() {
        let values = colors.table(channel, T::HIGHEST);
        *table = values.ok_or_else(|| Error::Damaged("found no curve".to_owned()))?;
    }
    let pixels = codes.par_chunks_exact(3).with_min_len(1 << 12);
    let light = pixels.map(|pixel| {
        let light = [0, 1, 2].map(|channel: usize| tables[channel][pixel[channel].into()]);
        colors.in_rec709(light)
    });
    Ok(light.collect())
}

/// A code value.
trait Bounded {
    /// The highest that there is.
    const HIGHEST: u32;
}

impl Bounded for u8 {
    const HIGHEST: u32 = u8::MAX as u32;
}

impl Bounded for u16 {
    const HIGHEST: u32 = u16::MAX as u32;
}
