//! What the code values of a photograph mean, by its own color profile.
//!
//!   rgb = M (f_r(R), f_g(G), f_b(B)),   M = M_709⁻¹ M_profile
//! `f` curves of the profile, `M_profile` its matrix to XYZ under D50, `M_709` that of Rec.709 with the white it is
//! seen under, adapted as profiles are. What Rec.709 cannot show is mixed with grey. A profile of tables instead of
//! curves and a matrix is left alone, as one that cannot be read: then, and without any, code values are sRGB. A PNG
//! without a profile may name the exponent of its curve instead (gAMA).
//! [ICC.1] Specification ICC.1:2022, Image technology colour management, sections 8.3 and 9.2; [PNG] Portable Network
//! Graphics (third edition), W3C 2025, section 4.3.

use moxcms::ColorProfile;
use moxcms::DataColorSpace;
use moxcms::LocalizableString;
use moxcms::ProfileText;
use moxcms::ToneReprCurve;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::into_gamut;
use niji_radiometry::srgb_decode;

/// Entries of the matrix within which a profile has the primaries of Rec.709: profiles are rounded to 1/65536, and some
/// were made with other figures for D65.
const SAME_MATRIX: f64 = 2e-3;
/// How far white may lie from that of Rec.709: a matrix farther off is adapted to no white, or missing.
const WHITE: f64 = 0.05;
/// Linear light within which a curve is that of sRGB: less than half a code value of 8 bit at the dark end.
const SAME_CURVE: f64 = 2e-4;
/// Points at which that is looked at.
const N_CURVE: u32 = 256;
/// The exponent of a PNG that stands for the curve of sRGB.
const SRGB_GAMMA: f64 = 1.0 / 2.2;

/// The color profile of a photograph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// Whether colors were read by it; else they were taken for sRGB.
    pub is_used: bool,
}

/// How code values become linear light.
pub(crate) enum Colors {
    /// As IEC 61966-2-1 says.
    Srgb,
    /// By the curves of a channel each, with the matrix to Rec.709 where they have other primaries.
    Curves {
        curves: [ToneReprCurve; 3],
        to_rec709: Option<[[f64; 3]; 3]>,
    },
}

impl Colors {
    /// Of the profile of a file, and what is to be said of it.
    pub(crate) fn of_profile(bytes: &[u8]) -> (Self, Profile) {
        let unused = |name: String| {
            let profile = Profile {
                name,
                is_used: false,
            };
            (Self::Srgb, profile)
        };
        let Ok(profile) = ColorProfile::new_from_slice(bytes) else {
            return unused("a damaged one".to_owned());
        };
        let name = name(&profile);
        match Self::of_curves(&profile) {
            Some(colors) => {
                let profile = Profile {
                    name,
                    is_used: true,
                };
                (colors, profile)
            }
            None => unused(name),
        }
    }

    /// Of a PNG that names the exponent that was applied to linear light.
    pub(crate) fn of_gamma(gamma: f64) -> Self {
        if (gamma / SRGB_GAMMA - 1.0).abs() < 0.01 || !(gamma > 0.05 && gamma < 20.0) {
            return Self::Srgb;
        }
        // f32: what curves of profiles are evaluated in.
        let curve = ToneReprCurve::Parametric(vec![(1.0 / gamma) as f32]);
        Self::Curves {
            curves: [curve.clone(), curve.clone(), curve],
            to_rec709: None,
        }
    }

    fn of_curves(profile: &ColorProfile) -> Option<Self> {
        let (curves, to_rec709) = match profile.color_space {
            DataColorSpace::Gray => {
                let curve = profile.gray_trc.clone()?;
                ([curve.clone(), curve.clone(), curve], None)
            }
            DataColorSpace::Rgb => {
                // A profile may have both; tables say more than curves and a matrix.
                if profile.lut_a_to_b_perceptual.is_some() {
                    return None;
                }
                let curves = [
                    profile.red_trc.clone()?,
                    profile.green_trc.clone()?,
                    profile.blue_trc.clone()?,
                ];
                let matrix = profile.transform_matrix(&ColorProfile::new_srgb()).v;
                let white = matrix.map(|row| row.iter().sum::<f64>());
                if !white.iter().all(|it| (it - 1.0).abs() < WHITE) {
                    return None;
                }
                let off = (0..9)
                    .map(|index| (index / 3, index % 3))
                    .map(|(row, column)| {
                        let own = f64::from(u8::from(row == column));
                        (matrix[row][column] - own).abs()
                    });
                let off = off.fold(0.0, f64::max);
                (curves, (off > SAME_MATRIX).then_some(matrix))
            }
            _ => return None,
        };
        let colors = Self::Curves { curves, to_rec709 };
        let tables = [0, 1, 2].map(|channel| colors.table(channel, N_CURVE - 1));
        let is_srgb = |table: &Option<Vec<f32>>| {
            let table = table.as_ref()?;
            let mut points = table.iter().zip(curve_of_srgb(N_CURVE - 1));
            Some(points.all(|(own, srgb)| (f64::from(*own) - srgb).abs() < SAME_CURVE))
        };
        let mut are_srgb = to_rec709.is_none();
        for table in &tables {
            are_srgb &= is_srgb(table)?;
        }
        Some(if are_srgb { Self::Srgb } else { colors })
    }

    /// Linear light of each code value of a channel; `None` for a curve that cannot be.
    pub(crate) fn table(&self, channel: usize, highest: u32) -> Option<Vec<f32>> {
        let Self::Curves { curves, .. } = self else {
            // f32: half a code value of 16 bit is 8e-6 of full scale, f32 resolves 6e-8.
            return Some(curve_of_srgb(highest).map(|it| it as f32).collect());
        };
        let curve = curves[channel].make_linear_evaluator().ok()?;
        let values: Vec<f32> = (0..=highest)
            .map(|code| curve.evaluate_value((f64::from(code) / f64::from(highest)) as f32))
            // Powers are rounded below 0 at 0.
            .map(|value| if value < 0.0 { 0.0 } else { value })
            .collect();
        let can_be = values.iter().all(|it| it.is_finite());
        can_be.then_some(values)
    }

    /// The linear light of a pixel in Rec.709.
    pub(crate) fn in_rec709(&self, pixel: [f32; 3]) -> [f32; 3] {
        let Self::Curves {
            to_rec709: Some(matrix),
            ..
        } = self
        else {
            return pixel;
        };
        let rgb = matrix.map(|row| {
            let terms = row.iter().zip(pixel);
            terms
                .map(|(factor, channel)| factor * f64::from(channel))
                .sum()
        });
        let rgb = into_gamut(rgb, RgbPrimaries::Rec709, GamutPolicy::Desaturate);
        // f32: what pictures hold.
        rgb.map(|channel| channel as f32)
    }
}

fn curve_of_srgb(highest: u32) -> impl Iterator<Item = f64> {
    (0..=highest).map(move |code| srgb_decode(f64::from(code) / f64::from(highest)))
}

fn name(profile: &ColorProfile) -> String {
    let name = match &profile.description {
        Some(ProfileText::PlainString(text)) => text.clone(),
        Some(ProfileText::Localizable(texts)) => texts
            .first()
            .map(|LocalizableString { value, .. }| value.clone())
            .unwrap_or_default(),
        Some(ProfileText::Description(text)) => text.ascii_string.clone(),
        None => String::new(),
    };
    // What a file says goes to a terminal.
    let name: String = name
        .chars()
        .filter(|it| !it.is_control())
        .take(60)
        .collect();
    if name.trim().is_empty() {
        "one without a name".to_owned()
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colors(profile: &ColorProfile) -> (Colors, Profile) {
        Colors::of_profile(&profile.encode().unwrap())
    }

    #[test]
    fn srgb_is_srgb_and_display_p3_is_as_published() {
        let (srgb, profile) = colors(&ColorProfile::new_srgb());
        assert!(matches!(srgb, Colors::Srgb) && profile.is_used);
        let (p3, profile) = colors(&ColorProfile::new_display_p3());
        assert!(
            profile.is_used && profile.name.contains("P3"),
            "{profile:?}"
        );
        // CSS Color Module Level 4, section 10.3: Display P3 has the curve of sRGB.
        let table = p3.table(1, 255).unwrap();
        assert!((f64::from(table[188]) - srgb_decode(188.0 / 255.0)).abs() < 1e-4);
        for (pixel, expected) in [
            ([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
            ([0.4, 0.4, 0.4], [0.4, 0.4, 0.4]),
            // Within Rec.709: no channel is below 0. From the matrices of the two (SMPTE EG 432-1, IEC 61966-2-1).
            ([0.5, 0.4, 0.3], [0.52249, 0.39579, 0.28821]),
        ] {
            for (found, expected) in p3.in_rec709(pixel).into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{pixel:?} {found} {expected}"
                );
            }
        }
        // The red of P3 has a luminance of 0.22897, and Rec.709 cannot show it.
        let red = p3.in_rec709([1.0, 0.0, 0.0]);
        assert!(red.iter().all(|it| *it >= 0.0));
        assert!((crate::exposure::luminance(red) - 0.22897).abs() < 1e-3);
    }

    #[test]
    fn other_curves_are_theirs_and_what_cannot_be_read_is_srgb() {
        let (adobe, profile) = colors(&ColorProfile::new_adobe_rgb());
        assert!(profile.is_used);
        // Adobe RGB (1998): exponent 563/256.
        let code = 128.0 / 255.0_f64;
        let table = adobe.table(0, 255).unwrap();
        assert!((f64::from(table[128]) - code.powf(563.0 / 256.0)).abs() < 1e-4);
        let (found, profile) = Colors::of_profile(b"no profile");
        assert!(matches!(found, Colors::Srgb) && !profile.is_used);
        let linear = Colors::of_gamma(1.0).table(2, 255).unwrap();
        assert!((linear[64] - 64.0 / 255.0).abs() < 1e-6);
        for gamma in [0.45455, 0.0, -1.0, f64::NAN] {
            assert!(matches!(Colors::of_gamma(gamma), Colors::Srgb), "{gamma}");
        }
    }
}
