//! The PNG that people look at.
//!
//! v = c 2^EV;   w = v for v <= 0.8,   w = 1 − 0.2 exp(−(v − 0.8)/0.2) above;   sRGB(w)
//! `c` linear Rec.709 relative to the white of the image, EV the exposure. The curve is the identity
//! up to 0.8 and then rolls off with a continuous slope, so that nothing clips hard.

use std::io::Write;

use ndarray::Array3;
use niji_radiometry::srgb_encode;

use crate::error::Error;

/// Where the shoulder of the tone curve begins.
const SHOULDER: f64 = 0.8;

/// The tone curve of previews, from linear to linear.
#[must_use]
pub fn tone_curve(value: f64) -> f64 {
    if value <= SHOULDER {
        return value.max(0.0);
    }
    let room = 1.0 - SHOULDER;
    1.0 - room * (-(value - SHOULDER) / room).exp()
}

/// Writes linear Rec.709 by channel, row and column as 8-bit sRGB.
///
/// # Errors
/// If the encoder or the writer fails.
pub fn write_png(rgb: &Array3<f32>, exposure_ev: f64, writer: impl Write) -> Result<(), Error> {
    let (_, height, width) = rgb.dim();
    let gain = exposure_ev.exp2();
    let mut bytes = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let linear = tone_curve(gain * f64::from(rgb[[channel, y, x]]));
                bytes.push((255.0 * srgb_encode(linear)).round().clamp(0.0, 255.0) as u8);
            }
        }
    }
    let failed = |error: png::EncodingError| Error::Png(error.to_string());
    let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&bytes).map_err(failed)?;
    writer.finish().map_err(failed)
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
}
