//! The PNG that people look at.
//!
//! v = c 2^EV;   w = v for v <= 0.8,   w = 1 − 0.2 exp(−(v − 0.8)/0.2) above;   sRGB(w)
//! `c` linear Rec.709 relative to the white of the image, in half floats as its plain image has them, EV the exposure. The
//! curve is the identity up to 0.8 and then rolls off with a continuous slope, so that nothing clips hard.

use std::io::Write;
use std::path::Path;

use ndarray::Array3;
use ndarray::Axis;
use ndarray::Slice;
use niji_geometry::PixelRegion;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::srgb_decode;
use niji_radiometry::srgb_encode;

use crate::error::Error;
use crate::image_windows::ImageWindows;
use crate::layers_file::PART;
use crate::layers_file::RGB;
use crate::part::Part;
use crate::part::as_half;
use crate::provenance::Provenance;
use crate::spectral_image::SpectralImage;
use crate::strips::PartsReader;

/// Where the shoulder of the tone curve begins.
const SHOULDER: f64 = 0.8;

/// What cameras take the mean of a picture to, in parts of white: the grey of their cards.
const MID_GREY: f64 = 0.18;

/// Shades of white that are told apart where pixels are counted by their luminance.
const N_SHADES: usize = 1000;

/// The tone curve of previews, from linear to linear.
#[must_use]
pub fn tone_curve(value: f64) -> f64 {
    if value <= SHOULDER {
        return value.max(0.0);
    }
    let room = 1.0 - SHOULDER;
    1.0 - room * (-(value - SHOULDER) / room).exp()
}

/// A preview of the frame for people while the rows of its picture come from the top.
#[derive(Clone, Debug)]
pub struct Preview {
    shown: PixelRegion,
    exposure_ev: f64,
    codes: Vec<u8>,
    provenance: Provenance,
}

impl Preview {
    /// Of a picture with these windows, before its first row.
    pub fn new(windows: ImageWindows, exposure_ev: f64, provenance: Provenance) -> Self {
        Self {
            shown: windows.shown(),
            exposure_ev,
            codes: Vec::new(),
            provenance,
        }
    }

    /// That of a picture whose plain image, of Rec.709, stands in a file: all else is in the spectral image alone.
    ///
    /// # Errors
    /// A file that is missing, damaged or no plain image; an exposure or a value that is not finite.
    pub fn of_plain_image(
        path: &Path,
        exposure_ev: f64,
        provenance: Provenance,
    ) -> Result<Self, Error> {
        let mut reader = PartsReader::open(path, 1)?;
        let windows = reader.windows();
        let mut preview = Self::new(windows, exposure_ev, provenance);
        while let Some(rgb) = reader.next(|parts| plain_rgb(parts, windows, preview.shown)) {
            preview.append(&rgb?)?;
        }
        Ok(preview)
    }

    /// Adds the next rows.
    ///
    /// # Errors
    /// An exposure or a value that is not finite.
    pub fn add(&mut self, rows: &SpectralImage) -> Result<(), Error> {
        self.append(&shown_of(rows, self.shown))
    }

    fn append(&mut self, rgb: &Array3<f32>) -> Result<(), Error> {
        let first_row = self.codes.len() / (3 * self.shown.width_px.max(1) as usize);
        append_codes(&mut self.codes, (rgb, first_row), self.exposure_ev)
    }

    /// The exposure with which a camera would show it, in stops beside that of the preview: its mean is 18 % of white, or a
    /// hundredth of it is above the shoulder of the tone curve where that is less. `None` where all is black.
    #[must_use]
    pub fn usual_stops(&self) -> Option<f64> {
        let linear: [f64; 256] = std::array::from_fn(|code| srgb_decode(code as f64 / 255.0));
        let (mut sum, mut n_of) = (0.0, [0_usize; N_SHADES + 1]);
        for rgb in self.codes.chunks_exact(3) {
            let rgb = [rgb[0], rgb[1], rgb[2]].map(|code| linear[usize::from(code)]);
            let shown = RgbPrimaries::Rec709.luminance(rgb);
            sum += shown;
            n_of[(shown * N_SHADES as f64) as usize] += 1;
        }
        let n_pixels = self.codes.len() / 3;
        let mut n_left = n_pixels / 100;
        let brightest = n_of.iter().rposition(|n| {
            let is_among = *n > n_left;
            n_left = n_left.saturating_sub(*n);
            is_among
        })?;
        let of_mean = (MID_GREY * n_pixels as f64 / sum).log2();
        let of_brightest = (SHOULDER * N_SHADES as f64 / (brightest + 1) as f64).log2();
        (sum > 0.0).then(|| of_mean.min(of_brightest))
    }

    /// Writes it as 8-bit sRGB, with the provenance as text.
    ///
    /// # Errors
    /// No pixels, or an encoder or writer that fails.
    pub fn write(&self, writer: impl Write) -> Result<(), Error> {
        let size = [self.shown.width_px, self.shown.height_px].map(|it| it as usize);
        write_srgb_png(&self.codes, size, &self.provenance, writer)
    }
}

/// Pixels of rows of a plain image that lie in what is shown.
fn plain_rgb(
    parts: Vec<Part>,
    windows: ImageWindows,
    shown: PixelRegion,
) -> Result<Array3<f32>, Error> {
    let part = parts.into_iter().next();
    let mut part = part.ok_or_else(|| Error::missing("part", PART))?;
    let (height, width) = part.size();
    let mut rgb = Array3::zeros((3, height, width));
    for (mut plane, name) in rgb.outer_iter_mut().zip(RGB) {
        plane.assign(&part.take(name)?);
    }
    Ok(cropped(rgb, part.windows.unwrap_or(windows).data, shown))
}

/// Pixels, by channel, row and column, that lie in what is shown; none may.
fn cropped(mut rgb: Array3<f32>, pixels: PixelRegion, shown: PixelRegion) -> Array3<f32> {
    let none = PixelRegion {
        width_px: 0,
        height_px: 0,
        ..pixels
    };
    let shown = pixels.intersection(shown).unwrap_or(none);
    let slice = |start: i32, origin: i32, n: u32| {
        let first = start.abs_diff(origin) as usize;
        Slice::from(first..first + n as usize)
    };
    rgb.slice_axis_inplace(Axis(1), slice(shown.y_px, pixels.y_px, shown.height_px));
    rgb.slice_axis_inplace(Axis(2), slice(shown.x_px, pixels.x_px, shown.width_px));
    rgb
}

fn shown_of(image: &SpectralImage, shown: PixelRegion) -> Array3<f32> {
    let mut rgb = image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
    rgb.par_mapv_inplace(as_half);
    cropped(rgb, image.windows.data, shown)
}

impl SpectralImage {
    /// Linear Rec.709 of the frame as a preview shows it, before exposure and tone curve: by channel, row and column.
    #[must_use]
    pub fn shown(&self) -> Array3<f32> {
        shown_of(self, self.windows.shown())
    }

    /// Writes a preview of the frame for people: 8-bit sRGB, see [`tone_curve`].
    ///
    /// # Errors
    /// An exposure or a value that is not finite, or a writer that fails.
    pub fn write_png(&self, writer: impl Write, exposure_ev: f64) -> Result<(), Error> {
        self.check_shape()?;
        let mut preview = Preview::new(self.windows, exposure_ev, self.provenance.clone());
        self.strips().try_for_each(|rows| preview.add(&rows))?;
        preview.write(writer)
    }
}

/// Writes code values, red, green and blue of each pixel by rows, as an 8-bit sRGB PNG of a width
/// and a height, with the provenance as text.
///
/// # Errors
/// No pixels, or an encoder or writer that fails.
pub fn write_srgb_png(
    codes: &[u8],
    [width, height]: [usize; 2],
    provenance: &Provenance,
    writer: impl Write,
) -> Result<(), Error> {
    let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    // A photograph of 24 megapixels takes 5 s otherwise, to be a sixth smaller.
    encoder.set_compression(png::Compression::Fast);
    for (name, text) in provenance.to_text_items() {
        encoder.add_itxt_chunk(name, text).map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(codes).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// Appends the code values of linear Rec.709 by channel, row and column, whose first row is this one of the preview.
fn append_codes(
    codes: &mut Vec<u8>,
    (rgb, first_row): (&Array3<f32>, usize),
    exposure_ev: f64,
) -> Result<(), Error> {
    let (_, height, width) = rgb.dim();
    let gain = exposure_ev.exp2();
    if !(exposure_ev.is_finite() && gain.is_finite()) {
        return Err(Error::Exposure { found: exposure_ev });
    }
    codes.reserve(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            for (index, channel) in ["R", "G", "B"].into_iter().enumerate() {
                let value = rgb[[index, y, x]];
                if !value.is_finite() {
                    let (part, channel) = ("preview".to_owned(), channel.to_owned());
                    return Err(Error::NotFinite {
                        part,
                        channel,
                        x,
                        y: first_row + y,
                        value,
                    });
                }
                let encoded = srgb_encode(tone_curve(gain * f64::from(value)));
                codes.push((255.0 * encoded).round().clamp(0.0, 255.0) as u8);
            }
        }
    }
    Ok(())
}

fn failed(error: png::EncodingError) -> Error {
    match error {
        png::EncodingError::IoError(error) => Error::Io(error),
        other => Error::Png(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tone_curve_is_smooth_monotone_and_below_one() {
        let step = 1e-4;
        let mut last = tone_curve(0.0);
        for index in 1..40_000 {
            let value = tone_curve(step * f64::from(index));
            assert!(value > last && value < 1.0);
            assert!(value - last < step * 1.0001, "the slope never exceeds one");
            last = value;
        }
        assert_eq!(tone_curve(-1.0), 0.0);
        assert_eq!(tone_curve(0.18), 0.18);
    }

    /// What is asked for of a preview of grey pixels, `bright` of 1000 of them brighter.
    fn usual_stops(grey: f32, (bright, n_bright): (f32, usize)) -> Option<f64> {
        let provenance = Provenance {
            tool: "a test".to_owned(),
            version: "0.0".to_owned(),
            settings: "{}".to_owned(),
            inputs: std::collections::BTreeMap::new(),
        };
        let mut preview = Preview::new(ImageWindows::whole(40, 25), 0.0, provenance);
        let value = |(_, y, x): (usize, usize, usize)| {
            if 40 * y + x < n_bright { bright } else { grey }
        };
        preview
            .append(&Array3::from_shape_fn((3, 25, 40), value))
            .unwrap();
        preview.usual_stops()
    }

    #[test]
    fn a_camera_shows_the_mean_as_grey_and_spares_what_is_bright() {
        let near = |found: Option<f64>, expected: f64| {
            // Codes of dark grey are 2 % apart.
            assert!(
                (found.unwrap() - expected).abs() < 0.05,
                "{found:?} {expected}"
            );
        };
        near(usual_stops(0.045, (0.0, 0)), 2.0);
        near(usual_stops(0.18, (0.0, 0)), 0.0);
        near(usual_stops(0.72, (0.0, 0)), -2.0);
        // Few are let go, more are not.
        near(
            usual_stops(0.045, (0.4, 5)),
            (0.18_f64 / (0.995 * 0.045 + 0.002)).log2(),
        );
        near(usual_stops(0.045, (0.4, 20)), 1.0);
        assert_eq!(usual_stops(0.0, (0.0, 0)), None);
    }
}
