//! The field of view of a photograph.
//!
//! tan(fov/2) = w/(2 f)
//! `w` width of the picture on the sensor, `f` focal length, both in mm, for a lens without
//! distortion focused far away. The 35 mm equivalent of [EXIF] compares diagonals: it refers to film
//! of 36 mm x 24 mm with the diagonal d35 = 43.27 mm, so that a picture of another shape has the
//! width d35 W/sqrt(W² + H²) on that film. A cropped picture sees less: its width over that of the
//! original scales w.
//! [EXIF] CIPA DC-008, version 2.32, tag FocalLengthIn35mmFilm (2019).

use niji_radiometry::Radians;

use crate::error::Error;
use crate::exif_notes::ExifNotes;

/// Diagonal of 36 mm x 24 mm film, mm.
const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_87;
/// Two shapes of picture that differ by less are the same.
const SAME_SHAPE: f64 = 0.01;

/// Where a field of view comes from.
///
/// ```
/// use niji_photo::Lens;
///
/// // 50 mm on film of 36 mm x 24 mm: 39.6 degrees.
/// let fov = Lens::Film35 { focal_length_mm: 50.0 }.horizontal_fov(6000, 4000)?;
/// assert!((fov.to_degrees() - 39.6).abs() < 0.01);
/// # Ok::<(), niji_photo::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// The horizontal field of view itself.
    FieldOfView(Radians),
    /// Focal length and width of the sensor, both in mm.
    Sensor {
        /// Focal length, mm.
        focal_length_mm: f64,
        /// Width of the sensor along the picture's width, mm.
        width_mm: f64,
    },
    /// Focal length as on 35 mm film, mm.
    Film35 {
        /// Focal length, mm.
        focal_length_mm: f64,
    },
}

impl Lens {
    /// The lens by the camera's notes; `None` where they do not say enough.
    #[must_use]
    pub fn from_notes(notes: &ExifNotes) -> Option<Self> {
        notes
            .focal_length_35mm
            .map(|focal_length_mm| Self::Film35 { focal_length_mm })
    }

    /// Horizontal field of view of a picture of this size in pixels.
    ///
    /// # Errors
    /// Lengths that are not positive, or a field of view outside 0..180 degrees.
    pub fn horizontal_fov(self, width_px: usize, height_px: usize) -> Result<Radians, Error> {
        let (width_mm, focal_length_mm) = match self {
            Self::FieldOfView(fov) => return check_fov(fov),
            Self::Sensor {
                focal_length_mm,
                width_mm,
            } => (width_mm, focal_length_mm),
            Self::Film35 { focal_length_mm } => {
                let diagonal_px = (width_px as f64).hypot(height_px as f64);
                (
                    FILM_DIAGONAL_MM * width_px as f64 / diagonal_px,
                    focal_length_mm,
                )
            }
        };
        for (what, found) in [
            ("the focal length in mm", focal_length_mm),
            ("the width of the sensor in mm", width_mm),
        ] {
            if !(found > 0.0 && found.is_finite()) {
                let expected = "a length above 0";
                return Err(Error::Range {
                    what,
                    found,
                    expected,
                });
            }
        }
        check_fov(Radians(2.0 * (0.5 * width_mm / focal_length_mm).atan()))
    }
}

/// Has the picture another shape than the camera gave it, so that its notes tell a wrong field of
/// view?
#[must_use]
pub fn is_cropped(notes: &ExifNotes, width_px: usize, height_px: usize) -> bool {
    let Some([width, height]) = notes.original_px else {
        return false;
    };
    let shape = |a: f64, b: f64| a.max(b) / a.min(b);
    let found = shape(width_px as f64, height_px as f64);
    let original = shape(f64::from(width), f64::from(height));
    (found / original - 1.0).abs() > SAME_SHAPE
}

fn check_fov(fov: Radians) -> Result<Radians, Error> {
    let fov_deg = fov.to_degrees();
    if fov_deg > 0.0 && fov_deg < 180.0 {
        return Ok(fov);
    }
    Err(Error::Range {
        what: "the field of view in degrees",
        found: fov_deg,
        expected: "an angle above 0 and below 180",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few functions of an angle.
    const ROUNDING_DEG: f64 = 1e-12;

    fn film_deg(focal_length_mm: f64, width_px: usize, height_px: usize) -> f64 {
        let lens = Lens::Film35 { focal_length_mm };
        lens.horizontal_fov(width_px, height_px)
            .unwrap()
            .to_degrees()
    }

    #[test]
    fn lenses_on_35_mm_film_have_their_catalogue_fields_of_view() {
        // Makers print 73.7, 39.6 and 10.3 degrees for 24, 50 and 200 mm.
        for (focal_length_mm, fov_deg) in [(24.0, 73.7), (50.0, 39.6), (200.0, 10.3)] {
            assert!((film_deg(focal_length_mm, 6000, 4000) - fov_deg).abs() < 0.05);
        }
    }

    #[test]
    fn turning_a_picture_swaps_its_fields_of_view() {
        let (wide, tall) = (film_deg(28.0, 4000, 3000), film_deg(28.0, 3000, 4000));
        let ratio = (0.5 * wide).to_radians().tan() / (0.5 * tall).to_radians().tan();
        assert!((ratio - 4.0 / 3.0).abs() < ROUNDING_DEG);
    }

    #[test]
    fn a_sensor_as_wide_as_its_focal_length_sees_53_degrees() {
        let lens = Lens::Sensor {
            focal_length_mm: 36.0,
            width_mm: 36.0,
        };
        let fov_deg = lens.horizontal_fov(100, 100).unwrap().to_degrees();
        assert!((fov_deg - 53.130102354155978).abs() < ROUNDING_DEG);
    }

    #[test]
    fn impossible_lenses_are_refused() {
        for lens in [
            Lens::FieldOfView(Radians(0.0)),
            Lens::FieldOfView(Radians::from_degrees(180.0)),
            Lens::FieldOfView(Radians(f64::NAN)),
            Lens::Film35 {
                focal_length_mm: 0.0,
            },
            Lens::Sensor {
                focal_length_mm: 50.0,
                width_mm: f64::INFINITY,
            },
        ] {
            assert!(matches!(
                lens.horizontal_fov(3, 2),
                Err(Error::Range { .. })
            ));
        }
    }

    #[test]
    fn a_crop_shows_in_the_shape_and_a_turn_does_not() {
        let notes = ExifNotes {
            original_px: Some([4000, 3000]),
            ..ExifNotes::default()
        };
        assert!(!is_cropped(&notes, 800, 600));
        assert!(!is_cropped(&notes, 600, 800));
        assert!(is_cropped(&notes, 800, 500));
        assert!(!is_cropped(&ExifNotes::default(), 800, 500));
    }
}
