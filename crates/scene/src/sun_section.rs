//! The section `[sun]` as it is written: where the sun stands, or when and where it is looked at.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use toml::value::Datetime;
use toml::value::Offset;

use crate::check::Check;
use crate::error::SceneError;
use crate::moment::Moment;
use crate::moment::SunPosition;
use crate::sections::Body;
use crate::sections::Sun;

/// What a date must look like.
const DATE_TIME: &str = "a date and time with its zone, as 2026-06-21T18:30:00+02:00";
/// The two ways to say where the sun stands.
const EITHER: &str =
    "either elevation_deg and azimuth_deg, or date_time, latitude_deg and longitude_deg";

/// The section `[sun]` as it is written: where the sun stands, or when and where it is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {
        "required": ["elevation_deg", "azimuth_deg"],
        "properties": { "date_time": false, "latitude_deg": false, "longitude_deg": false },
    },
    {
        "required": ["date_time", "latitude_deg", "longitude_deg"],
        "properties": { "elevation_deg": false, "azimuth_deg": false },
    },
]))]
pub struct SunSection {
    /// What shines.
    #[serde(default)]
    body: Body,
    /// Phase angle of the moon, 0 at full moon, degrees: 0 where it is left out.
    #[serde(default)]
    #[schemars(range(min = -150.0, max = 150.0))]
    phase_angle_deg: Option<f64>,
    /// Apparent elevation above the horizon, degrees.
    #[serde(default)]
    #[schemars(range(min = -90.0, max = 90.0))]
    elevation_deg: Option<f64>,
    /// Azimuth, clockwise from north, degrees.
    #[serde(default)]
    #[schemars(range(min = -3600.0, max = 3600.0))]
    azimuth_deg: Option<f64>,
    /// Date and time with its zone, in quotes, as 2026-06-21T18:30:00+02:00: in the place of elevation
    /// and azimuth.
    #[serde(default)]
    date_time: Option<String>,
    /// Latitude of the eye, north positive, degrees.
    #[serde(default)]
    #[schemars(range(min = -90.0, max = 90.0))]
    latitude_deg: Option<f64>,
    /// Longitude of the eye, east positive, degrees.
    #[serde(default)]
    #[schemars(range(min = -180.0, max = 180.0))]
    longitude_deg: Option<f64>,
}

impl SunSection {
    /// The sun of the section.
    pub(crate) fn placed(self, check: &Check<'_>) -> Result<Sun, SceneError> {
        let stands = self.elevation_deg.is_some() || self.azimuth_deg.is_some();
        let is_timed =
            self.date_time.is_some() || self.latitude_deg.is_some() || self.longitude_deg.is_some();
        let position = match (stands, is_timed) {
            (true, false) => SunPosition {
                elevation_deg: given(self.elevation_deg, "elevation_deg", check)?,
                azimuth_deg: given(self.azimuth_deg, "azimuth_deg", check)?,
            },
            (false, true) => self.at_moment(check)?,
            (true, true) => {
                return Err(check.out_of_range("sun", "given twice".to_string(), EITHER));
            }
            (false, false) => {
                return Err(check.out_of_range("sun", "without a position".to_string(), EITHER));
            }
        };
        Ok(Sun {
            body: self.body,
            phase_angle_deg: self.phase_angle_deg,
            elevation_deg: position.elevation_deg,
            azimuth_deg: position.azimuth_deg,
        })
    }

    fn at_moment(&self, check: &Check<'_>) -> Result<SunPosition, SceneError> {
        let text = given(self.date_time.as_deref(), "date_time", check)?;
        match self.body {
            Body::Sun => {}
            Body::Moon => {
                let expected = "elevation_deg and azimuth_deg: the moon has no almanac here";
                return Err(check.out_of_range("sun.date_time", text.to_string(), expected));
            }
        }
        let latitude_deg = given(self.latitude_deg, "latitude_deg", check)?;
        let longitude_deg = given(self.longitude_deg, "longitude_deg", check)?;
        check.number("sun.latitude_deg", latitude_deg, (-90.0, 90.0))?;
        check.number("sun.longitude_deg", longitude_deg, (-180.0, 180.0))?;
        let wrong = |found: String| check.out_of_range("sun.date_time", found, DATE_TIME);
        let (local_time, utc_offset_h) = clock(text).map_err(wrong)?;
        let moment = Moment {
            local_time,
            utc_offset_h,
            latitude_deg,
            longitude_deg,
        };
        moment
            .sun()
            .map_err(|reason| wrong(format!("\"{text}\" ({reason})")))
    }
}

/// A key that must be there.
fn given<T>(value: Option<T>, key: &str, check: &Check<'_>) -> Result<T, SceneError> {
    value.ok_or_else(|| SceneError::MissingKey {
        line: check.line("sun"),
        section: "[sun]".to_string(),
        key: key.to_string(),
        other: None,
        also: Vec::new(),
    })
}

/// Time on the clock, fractions of a second left out, and what the clock is ahead of UTC in hours;
/// otherwise what is wrong.
fn clock(text: &str) -> Result<([u32; 6], f64), String> {
    let read = Datetime::from_str(text).map_err(|_| format!("\"{text}\""))?;
    let (Some(date), Some(time)) = (read.date, read.time) else {
        return Err(format!("\"{text}\", only a part of it"));
    };
    let minutes = match read.offset {
        None => return Err(format!("\"{text}\" without a time zone")),
        Some(Offset::Z) => 0,
        Some(Offset::Custom { minutes }) => minutes,
    };
    let local_time = [
        u32::from(date.year),
        u32::from(date.month),
        u32::from(date.day),
        u32::from(time.hour),
        u32::from(time.minute),
        u32::from(time.second.unwrap_or(0)),
    ];
    Ok((local_time, f64::from(minutes) / 60.0))
}
