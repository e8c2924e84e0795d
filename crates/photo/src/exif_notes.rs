//! What a camera noted beside the picture.
//!
//! Only what later stages use, each on its own: a note that is missing or makes no sense is `None`,
//! never an error, because half of all pictures have been through a program that drops them.
//! [EXIF] CIPA DC-008, Exchangeable image file format, version 2.32 (2019).

use exif::Exif;
use exif::In;
use exif::Rational;
use exif::Reader;
use exif::SRational;
use exif::Tag;
use exif::Value;

/// Notes of the camera; all of them may be missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExifNotes {
    /// Focal length of the lens, mm.
    pub focal_length_mm: Option<f64>,
    /// Focal length that has this field of view on 36 mm x 24 mm film, mm.
    pub focal_length_35mm: Option<f64>,
    /// Size of the picture as the camera wrote it, pixels, before any turning.
    pub original_px: Option<[u32; 2]>,
    /// Time of exposure on the camera's clock: year, month, day, hour, minute, second.
    pub local_time: Option<[u32; 6]>,
    /// What that clock was ahead of UTC, hours.
    pub utc_offset_h: Option<f64>,
    /// Latitude and longitude, degrees, north and east positive.
    pub position_deg: Option<[f64; 2]>,
    /// Azimuth of the optical axis from true north, degrees.
    pub azimuth_deg: Option<f64>,
    /// f-number.
    pub f_number: Option<f64>,
    /// Exposure time, s.
    pub exposure_s: Option<f64>,
    /// Speed by ISO 12232.
    pub iso_speed: Option<f64>,
}

impl ExifNotes {
    /// Reads the notes of a raw EXIF block; a damaged block gives none.
    #[must_use]
    pub fn parse(block: Vec<u8>) -> Self {
        let mut reader = Reader::new();
        // A damaged field must not hide the sound ones.
        reader.continue_on_error(true);
        let parsed = reader
            .read_raw(block)
            .or_else(|error| error.distill_partial_result(|_| ()));
        parsed
            .map(|exif| Self::from_exif(&exif))
            .unwrap_or_default()
    }

    fn from_exif(exif: &Exif) -> Self {
        let positive = |tag| number(exif, tag).filter(|value| *value > 0.0);
        let side = |tag| uint(exif, tag).filter(|side| *side > 0);
        let size = side(Tag::PixelXDimension).zip(side(Tag::PixelYDimension));
        Self {
            focal_length_mm: positive(Tag::FocalLength),
            focal_length_35mm: positive(Tag::FocalLengthIn35mmFilm),
            original_px: size.map(|(width, height)| [width, height]),
            local_time: text(exif, Tag::DateTimeOriginal).and_then(|text| time(&text)),
            utc_offset_h: text(exif, Tag::OffsetTimeOriginal).and_then(|text| offset_h(&text)),
            position_deg: position_deg(exif),
            azimuth_deg: azimuth_deg(exif),
            f_number: positive(Tag::FNumber),
            exposure_s: positive(Tag::ExposureTime),
            iso_speed: positive(Tag::PhotographicSensitivity),
        }
    }
}

fn uint(exif: &Exif, tag: Tag) -> Option<u32> {
    exif.get_field(tag, In::PRIMARY)?.value.get_uint(0)
}

fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    let value = match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(values) => values.first().map(Rational::to_f64)?,
        Value::SRational(values) => values.first().map(SRational::to_f64)?,
        other => f64::from(other.get_uint(0)?),
    };
    value.is_finite().then_some(value)
}

fn text(exif: &Exif, tag: Tag) -> Option<String> {
    let Value::Ascii(lines) = &exif.get_field(tag, In::PRIMARY)?.value else {
        return None;
    };
    let line = lines.first()?;
    Some(String::from_utf8_lossy(line).trim().to_owned())
}

/// `2024:06:01 18:30:05`.
fn time(text: &str) -> Option<[u32; 6]> {
    let numbers: Option<Vec<u32>> = text
        .split([':', ' ', '-', 'T'])
        .map(|entry| entry.parse().ok())
        .collect();
    let time: [u32; 6] = numbers?.try_into().ok()?;
    let [_, month, day, hour, minute, second] = time;
    let is_sound = (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && hour < 24
        && minute < 60
        && second <= 60;
    is_sound.then_some(time)
}

/// `+05:30`.
fn offset_h(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let (hours, minutes) = rest.split_once(':')?;
    let hours = hours.parse::<u32>().ok().filter(|hours| *hours <= 14)?;
    let minutes = minutes.parse::<u32>().ok().filter(|m| *m < 60)?;
    Some(sign * (f64::from(hours) + f64::from(minutes) / 60.0))
}

fn position_deg(exif: &Exif) -> Option<[f64; 2]> {
    let angle = |tag, reference, negative: &str| {
        let Value::Rational(parts) = &exif.get_field(tag, In::PRIMARY)?.value else {
            return None;
        };
        let [degrees, minutes, seconds] = parts.first_chunk::<3>()?;
        let angle_deg = degrees.to_f64() + minutes.to_f64() / 60.0 + seconds.to_f64() / 3600.0;
        let is_negative = text(exif, reference)? == negative;
        angle_deg
            .is_finite()
            .then_some(if is_negative { -angle_deg } else { angle_deg })
    };
    let latitude = angle(Tag::GPSLatitude, Tag::GPSLatitudeRef, "S")?;
    let longitude = angle(Tag::GPSLongitude, Tag::GPSLongitudeRef, "W")?;
    (latitude.abs() <= 90.0 && longitude.abs() <= 180.0).then_some([latitude, longitude])
}

/// Magnetic bearings are off by the declination, which is not known here: only true ones count.
fn azimuth_deg(exif: &Exif) -> Option<f64> {
    let is_true = text(exif, Tag::GPSImgDirectionRef)? == "T";
    let azimuth_deg = number(exif, Tag::GPSImgDirection)?;
    (is_true && (0.0..=360.0).contains(&azimuth_deg)).then_some(azimuth_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_offsets_are_read_or_left_out() {
        assert_eq!(time("2024:06:01 18:30:05"), Some([2024, 6, 1, 18, 30, 5]));
        for text in [
            "",
            "2024:06:01",
            "2024:13:01 00:00:00",
            "    :  :     :  :  ",
        ] {
            assert_eq!(time(text), None, "{text}");
        }
        assert_eq!(offset_h("-03:30"), Some(-3.5));
        assert_eq!(offset_h("+09:00"), Some(9.0));
        for text in ["", "Z", "+25:00", "+01:75"] {
            assert_eq!(offset_h(text), None, "{text}");
        }
    }

    #[test]
    fn a_block_of_rubbish_has_no_notes() {
        assert_eq!(ExifNotes::parse(Vec::new()), ExifNotes::default());
        assert_eq!(ExifNotes::parse(vec![7; 999]), ExifNotes::default());
        // A sound TIFF header that points beyond its end.
        let block = b"II\x2a\x00\xff\xff\xff\x7f".to_vec();
        assert_eq!(ExifNotes::parse(block), ExifNotes::default());
    }
}
