//! How far a picture is from the reference, as numbers and as a map.
//!
//! relative RMSE  of spectral radiance over the RMS of the reference
//! largest        difference of luminance over the luminance of white
//! CIEDE2000      of linear Rec.709 at the exposure of the preview, held in 0..1, seen on a screen

use niji_exchange::SpectralImage;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use palette::FromColor;
use palette::Lab;
use palette::LinSrgb;
use palette::color_difference::Ciede2000;
use plotters::style::colors::colormaps::ViridisRGB;

use crate::timed_run::relative_rmse;

/// CIEDE2000 at the bright end of a map.
const MAP_END: f64 = 10.0;

/// The distance of a picture.
pub(super) struct PictureDistance {
    pub(super) relative_rmse: f64,
    pub(super) max_over_white: f64,
    pub(super) mean_color_difference: f64,
    pub(super) max_color_difference: f64,
    /// CIEDE2000 as colors by rows, from dark blue (0) to yellow (10 and more).
    pub(super) map: Vec<u8>,
}

/// Compares two pictures of the same size.
pub(super) fn picture_distance(
    found: &SpectralImage,
    reference: &SpectralImage,
    exposure_ev: f64,
) -> PictureDistance {
    let rgb = |image: &SpectralImage| image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
    let (found_rgb, reference_rgb) = (rgb(found), rgb(reference));
    let gain = exposure_ev.exp2();
    let (_, height, width) = found_rgb.dim();
    let mut distance = PictureDistance {
        relative_rmse: relative_rmse(&found.radiance, &reference.radiance),
        max_over_white: 0.0,
        mean_color_difference: 0.0,
        max_color_difference: 0.0,
        map: Vec::with_capacity(3 * width * height),
    };
    for y in 0..height {
        for x in 0..width {
            let [a, b] = [&found_rgb, &reference_rgb]
                .map(|rgb| [0, 1, 2].map(|c| f64::from(rgb[[c, y, x]])));
            let off = (RgbPrimaries::Rec709.luminance(a) - RgbPrimaries::Rec709.luminance(b)).abs();
            distance.max_over_white = distance.max_over_white.max(off);
            let [a, b] = [a, b].map(|rgb| lab(rgb, gain));
            let seen = a.difference(b);
            distance.mean_color_difference += seen / (width * height) as f64;
            distance.max_color_difference = distance.max_color_difference.max(seen);
            // f32: a color of 8 bits.
            let color = ViridisRGB::get_color((seen / MAP_END).min(1.0) as f32);
            distance.map.extend([color.0, color.1, color.2]);
        }
    }
    distance
}

fn lab(rgb: [f64; 3], gain: f64) -> Lab<palette::white_point::D65, f64> {
    let [red, green, blue] = rgb.map(|value| (gain * value).clamp(0.0, 1.0));
    Lab::from_color(LinSrgb::new(red, green, blue))
}
