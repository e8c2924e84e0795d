//! `niji eval sun`: where the sun stands at a time and place.

use clap::Args;
use niji_scene::Moment;

use super::csv::line;
use crate::check::time;
use crate::failure::Failure;
use crate::flags::within;

/// Elevation and azimuth of the sun by date, time and place.
///
/// Elevations are apparent, lifted by the refraction of standard air; they are what scenes take.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  niji eval sun --date 2026-11-21T15:00:00,2026-11-21T16:30:00 --utc-offset-h 9 \\
      --latitude-deg 35.0 --longitude-deg 135.8

Columns: latitude_deg,longitude_deg,utc_offset_h,hour,elevation_deg,azimuth_deg
(hour of the day on the clock; azimuth clockwise from north)")]
pub(super) struct SunArguments {
    /// Days and times on the clock.
    #[arg(
        long,
        value_name = "YYYY-MM-DDThh:mm:ss,…",
        value_delimiter = ',',
        value_parser = time,
        required = true
    )]
    date: Vec<[u32; 6]>,
    /// What the clock is ahead of UTC.
    #[arg(
        long,
        value_name = "H",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = within(-18.0, 18.0)
    )]
    utc_offset_h: f64,
    /// Latitude, north positive.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    latitude_deg: f64,
    /// Longitude, east positive.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    longitude_deg: f64,
}

pub(super) fn csv(arguments: &SunArguments) -> Result<String, Failure> {
    let header = "latitude_deg,longitude_deg,utc_offset_h,hour,elevation_deg,azimuth_deg\n";
    let mut csv = header.to_owned();
    for &local_time in &arguments.date {
        let at = Moment {
            local_time,
            utc_offset_h: arguments.utc_offset_h,
            latitude_deg: arguments.latitude_deg,
            longitude_deg: arguments.longitude_deg,
        };
        let sun = at.sun()?;
        let [_, _, _, hour, minute, second] = local_time.map(f64::from);
        csv += &line(&[
            arguments.latitude_deg,
            arguments.longitude_deg,
            arguments.utc_offset_h,
            hour + minute / 60.0 + second / 3600.0,
            sun.elevation_deg,
            sun.azimuth_deg,
        ]);
    }
    Ok(csv)
}
