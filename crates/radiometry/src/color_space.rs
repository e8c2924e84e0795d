//! CIE XYZ, linear Rec.709, sRGB, and colors that a display cannot show.
//!
//! RGB = M XYZ, with M from the Rec.709 primaries (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) and the
//! white point D65 (0.3127, 0.3290); its entries here are that definition in 30-digit arithmetic.
//! Bow colors are more saturated than any display: they have negative channels and need a gamut
//! policy, by name, before they become a picture.
//! [BT709] ITU-R BT.709-6 (2015); [SRGB] IEC 61966-2-1:1999.

use crate::rgb_primaries::RgbPrimaries;

/// Rec.709 from XYZ [BT709].
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [
        3.24096994190452134,
        -1.53738317757009346,
        -0.498610760293003284,
    ],
    [
        -0.969243636280879826,
        1.87596750150772067,
        0.0415550574071756125,
    ],
    [
        0.0556300796969936085,
        -0.203976958888976564,
        1.05697151424287856,
    ],
];

/// XYZ from Rec.709 [BT709]; the middle row is the luminance of the three primaries.
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [
        0.412390799265959481,
        0.357584339383877964,
        0.180480788401834288,
    ],
    [
        0.212639005871510358,
        0.715168678767755927,
        0.072192315360733715,
    ],
    [
        0.0193308187155918507,
        0.119194779794625988,
        0.950532152249660581,
    ],
];

/// What becomes of a color with negative channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GamutPolicy {
    /// Mix with the grey of equal luminance until no channel is negative. Luminance and dominant
    /// wavelength stay; only saturation is lost.
    Desaturate,
    /// Set negative channels to zero. Brightens the color and shifts its hue; kept for comparison.
    Clip,
}

/// Linear Rec.709 of CIE XYZ. White of luminance 1 becomes (1, 1, 1); no channel is clipped.
pub fn xyz_to_linear_rec709(xyz: [f64; 3]) -> [f64; 3] {
    multiply(&RGB_FROM_XYZ, xyz)
}

/// CIE XYZ of linear Rec.709.
pub fn linear_rec709_to_xyz(rgb: [f64; 3]) -> [f64; 3] {
    multiply(&XYZ_FROM_RGB, rgb)
}

/// Chromaticity (x, y) of a color; none for black or for a sum that is not positive.
pub fn xy_chromaticity(xyz: [f64; 3]) -> Option<[f64; 2]> {
    let [x, y, z] = xyz;
    let sum = x + y + z;
    (sum > 0.0 && sum.is_finite()).then(|| [x / sum, y / sum])
}

/// The color that stands for `rgb` of some primaries where channels cannot be negative.
///
/// Channels above 1 are left alone: how bright the display is, is not a question of gamut. A color
/// without positive luminance becomes black. NaN stays NaN, for the writer to reject.
pub fn into_gamut(rgb: [f64; 3], primaries: RgbPrimaries, policy: GamutPolicy) -> [f64; 3] {
    if lowest(rgb) >= 0.0 || rgb.iter().any(|channel| channel.is_nan()) {
        return rgb;
    }
    match policy {
        GamutPolicy::Desaturate => desaturate(rgb, primaries),
        GamutPolicy::Clip => rgb.map(|channel| channel.max(0.0)),
    }
}

/// sRGB code value of a linear channel, 0..1 to 0..1; the straight piece goes on below 0.
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.0031308 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Linear channel of an sRGB code value, 0..1 to 0..1; the straight piece goes on below 0.
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// How much of its saturation a color keeps by [`GamutPolicy::Desaturate`], Y/(Y - lowest channel): 1 where no channel
/// is negative, 0 of one without positive luminance.
pub fn kept_saturation(rgb: [f64; 3], primaries: RgbPrimaries) -> f64 {
    let lowest = lowest(rgb);
    if lowest >= 0.0 {
        return 1.0;
    }
    let luminance = primaries.luminance(rgb).max(0.0);
    luminance / (luminance - lowest)
}

fn lowest([red, green, blue]: [f64; 3]) -> f64 {
    red.min(green).min(blue)
}

/// Moves `rgb` along the line to its grey just far enough that the lowest channel becomes zero.
fn desaturate(rgb: [f64; 3], primaries: RgbPrimaries) -> [f64; 3] {
    let luminance = primaries.luminance(rgb);
    if luminance <= 0.0 {
        return [0.0; 3];
    }
    let kept = kept_saturation(rgb, primaries);
    // Rounding may leave the lowest channel at -1e-17.
    rgb.map(|channel| (luminance + kept * (channel - luminance)).max(0.0))
}

pub(crate) fn multiply(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "these results are exact")]

    use super::*;
    use crate::colorimetry::Colorimetry;
    use crate::wavelength_grid::WavelengthGrid;

    /// Worst found 1.7e-16 over the colors below.
    const ROUND_TRIP: f64 = 1e-15;

    const REC709: RgbPrimaries = RgbPrimaries::Rec709;

    fn spectral_color(wavelength_nm: f64) -> [f64; 3] {
        let grid = WavelengthGrid::new(wavelength_nm, 1.0, 1).unwrap();
        xyz_to_linear_rec709(Colorimetry::new(&grid).xyz(&[1e-2]))
    }

    #[test]
    fn white_is_d65_and_primaries_are_those_of_rec709() {
        let xy = |rgb| xy_chromaticity(linear_rec709_to_xyz(rgb)).unwrap();
        for (rgb, x, y) in [
            ([1.0, 1.0, 1.0], 0.3127, 0.3290),
            ([1.0, 0.0, 0.0], 0.64, 0.33),
            ([0.0, 1.0, 0.0], 0.30, 0.60),
            ([0.0, 0.0, 1.0], 0.15, 0.06),
        ] {
            let [found_x, found_y] = xy(rgb);
            assert!((found_x - x).abs() <= ROUND_TRIP && (found_y - y).abs() <= ROUND_TRIP);
        }
        assert!((linear_rec709_to_xyz([1.0; 3])[1] - 1.0).abs() <= ROUND_TRIP);
    }

    #[test]
    fn color_spaces_survive_a_round_trip() {
        for rgb in [[0.2, 0.5, 0.9], [-0.3, 0.7, 0.1], [1.0, 0.0, 0.0]] {
            let back = xyz_to_linear_rec709(linear_rec709_to_xyz(rgb));
            for (b, c) in back.iter().zip(rgb) {
                assert!((b - c).abs() <= ROUND_TRIP, "{back:?}");
            }
        }
        for code in 0..=1000 {
            let linear = f64::from(code) / 1000.0;
            // Worst found 3.3e-16.
            assert!(
                (srgb_decode(srgb_encode(linear)) - linear).abs() <= 1e-15,
                "{linear}"
            );
        }
    }

    #[test]
    fn srgb_agrees_with_the_standard() {
        assert!((srgb_encode(0.5) - 0.735356983052449).abs() <= 1e-14);
        assert!((srgb_decode(0.5) - 0.214041140482232).abs() <= 1e-14);
        assert!((srgb_encode(1.0) - 1.0).abs() <= 1e-15);
        assert!(srgb_encode(0.0).abs() <= 0.0);
        // The middle grey of photographers, 18 %, is 118 of 255.
        assert_eq!((255.0 * srgb_encode(0.18)).round(), 118.0);
    }

    #[test]
    fn desaturation_keeps_luminance_and_leaves_no_negative_channel() {
        for step in 0..36 {
            let wavelength_nm = 400.0 + 10.0 * f64::from(step);
            let rgb = spectral_color(wavelength_nm);
            assert!(
                rgb.iter().any(|c| *c < 0.0),
                "{wavelength_nm} nm is outside the gamut"
            );
            let shown = into_gamut(rgb, REC709, GamutPolicy::Desaturate);
            assert!(
                shown.iter().all(|c| *c >= 0.0),
                "{wavelength_nm} nm: {shown:?}"
            );
            let luminance = |c| linear_rec709_to_xyz(c)[1];
            // Worst found 4.4e-16.
            assert!((luminance(shown) / luminance(rgb) - 1.0).abs() <= 2e-15);
        }
    }

    #[test]
    fn desaturation_moves_straight_towards_white() {
        let xy = |rgb| xy_chromaticity(linear_rec709_to_xyz(rgb)).unwrap();
        let pure = xy(spectral_color(500.0));
        let shown = xy(into_gamut(
            spectral_color(500.0),
            REC709,
            GamutPolicy::Desaturate,
        ));
        let cross =
            (pure[0] - 0.3127) * (shown[1] - 0.3290) - (pure[1] - 0.3290) * (shown[0] - 0.3127);
        assert!(cross.abs() <= 1e-12, "{cross}");
    }

    #[test]
    fn clipping_brightens_what_desaturation_keeps() {
        let rgb = spectral_color(500.0);
        let clipped = into_gamut(rgb, REC709, GamutPolicy::Clip);
        assert!(clipped.iter().all(|c| *c >= 0.0));
        assert!(linear_rec709_to_xyz(clipped)[1] > 1.2 * linear_rec709_to_xyz(rgb)[1]);
    }

    #[test]
    fn colors_in_gamut_black_and_negative_light_are_settled() {
        for policy in [GamutPolicy::Desaturate, GamutPolicy::Clip] {
            assert_eq!(
                into_gamut([0.0, 0.5, 40.0], REC709, policy),
                [0.0, 0.5, 40.0]
            );
            assert_eq!(into_gamut([0.0; 3], REC709, policy), [0.0; 3]);
            assert_eq!(into_gamut([-1.0, -2.0, -3.0], REC709, policy), [0.0; 3]);
            assert!(into_gamut([-1.0, f64::NAN, 1.0], REC709, policy)[1].is_nan());
        }
        assert_eq!(xy_chromaticity([0.0; 3]), None);
        assert_eq!(xy_chromaticity([f64::NAN, 1.0, 1.0]), None);
    }
}
