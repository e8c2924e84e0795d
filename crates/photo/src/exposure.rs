//! How bright a sunlit white card is in a photograph.
//!
//! Grey world:  g = Y_mean/0.18, Y the linear luminance: the mean of a scene reflects 18 %.
//! Camera:      g = L_card/L_white,  L_white = 10 N²/(0.65 · 0.18 S t)  [cd/m²]
//! `N` f-number, `t` exposure time in s, `S` standard output sensitivity: an exposure of 10/S lx s
//! becomes the code value 118, which is 18 % of white, and a scene of luminance L exposes the sensor
//! to 0.65 L t/N². `L_card` luminance of the card, cd/m². The camera's way holds for pictures that
//! were not processed afterwards, within a stop.
//! [ISO12232] ISO 12232:2019, Photography, digital still cameras, determination of sensitivity.

use ndarray::Array2;
use ndarray::parallel::prelude::*;

use crate::compositing::check_gain;
use crate::error::Error;
use crate::exif_notes::ExifNotes;
use crate::linear_picture::LinearPicture;

/// Reflectance of the mean scene, that of a grey card.
const GREY: f64 = 0.18;
/// Exposure times sensitivity of the code value 118, lx s (ISO12232, standard output sensitivity).
const STANDARD_OUTPUT_LX_S: f64 = 10.0;
/// Transmission, vignetting and geometry of a lens (ISO12232).
const LENS: f64 = 0.65;

/// Where the exposure comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the mean of the photograph.
    GreyWorld,
    /// From f-number, time and sensitivity that the camera noted, for a card of this luminance.
    Camera {
        /// Luminance of a sunlit white card, cd/m².
        card_cd_m2: f64,
    },
    /// The value itself.
    Card(f64),
}

/// Linear luminance of Rec.709.
pub(crate) fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// The value of a sunlit white card in the photograph.
///
/// # Errors
/// Notes that are missing, or a value that is not a finite number of at least 0.
pub fn card_value(
    exposure: Exposure,
    photo: &LinearPicture,
    notes: &ExifNotes,
) -> Result<f64, Error> {
    let gain = match exposure {
        Exposure::GreyWorld => mean_luminance(photo) / GREY,
        Exposure::Camera { card_cd_m2 } => {
            let settings = notes.f_number.zip(notes.exposure_s).zip(notes.iso_speed);
            let Some(((f_number, exposure_s), iso_speed)) = settings else {
                return Err(Error::Range {
                    what: "the number of exposure notes (f-number, time, speed) in EXIF",
                    found: [notes.f_number, notes.exposure_s, notes.iso_speed]
                        .iter()
                        .flatten()
                        .count() as f64,
                    expected: "3",
                });
            };
            let grey_cd_m2 =
                STANDARD_OUTPUT_LX_S * f_number * f_number / (LENS * iso_speed * exposure_s);
            card_cd_m2 * GREY / grey_cd_m2
        }
        Exposure::Card(value) => value,
    };
    check_gain(gain)?;
    Ok(gain)
}

/// Mean luminance, summed by rows from the top.
pub(crate) fn mean_luminance(photo: &LinearPicture) -> f64 {
    let rows: Vec<f64> = photo
        .outer_iter()
        .into_par_iter()
        .map(|row| row.iter().map(|pixel| luminance(*pixel)).sum())
        .collect();
    rows.iter().sum::<f64>() / photo.len().max(1) as f64
}

/// Mean luminance of the pixels at which a mask has this value; 0 where it has none.
#[must_use]
pub fn mean_luminance_where(photo: &LinearPicture, mask: &Array2<bool>, value: bool) -> f64 {
    let pixels = photo.iter().zip(mask).filter(|(_, it)| **it == value);
    let (sum, n) = pixels.fold((0.0, 0.0), |(sum, n), (pixel, _)| {
        (sum + luminance(*pixel), n + 1.0)
    });
    sum / f64::max(n, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grey_card_makes_white_one() {
        let photo = Array2::from_elem((4, 5), [0.18; 3]);
        let gain = card_value(Exposure::GreyWorld, &photo, &ExifNotes::default()).unwrap();
        assert!((gain - 1.0).abs() < 1e-6);
    }

    #[test]
    fn sunny_sixteen_makes_a_sunlit_card_nearly_white() {
        // f/16 at 1/100 s and ISO 100 is the old rule for sunlight, where a white card has about
        // 30000 cd/m²; 0.65 is the same rule by ISO 12232, which leaves room for highlights.
        let notes = ExifNotes {
            f_number: Some(16.0),
            exposure_s: Some(0.01),
            iso_speed: Some(100.0),
            ..ExifNotes::default()
        };
        let photo = Array2::from_elem((1, 1), [0.5; 3]);
        let exposure = Exposure::Camera {
            card_cd_m2: 30_000.0,
        };
        let gain = card_value(exposure, &photo, &notes).unwrap();
        assert!((gain - 1.371).abs() < 1e-3, "{gain}");
        // One stop less light halves it.
        let darker = ExifNotes {
            exposure_s: Some(0.005),
            ..notes
        };
        let halved = card_value(exposure, &photo, &darker).unwrap();
        assert!((2.0 * halved - gain).abs() < 1e-12);
    }

    #[test]
    fn missing_notes_and_impossible_values_are_refused() {
        let photo = Array2::from_elem((1, 1), [0.5; 3]);
        let camera = Exposure::Camera { card_cd_m2: 3e4 };
        assert!(card_value(camera, &photo, &ExifNotes::default()).is_err());
        for value in [-1.0, f64::NAN] {
            let exposure = Exposure::Card(value);
            assert!(card_value(exposure, &photo, &ExifNotes::default()).is_err());
        }
    }
}
