//! Where the sun stands at a time and place: that of a photograph, or of a scene.
//!
//! The Solar Position Algorithm, ±0.0003 degrees, with the refraction of standard air.
//! [RA03] I. Reda, A. Andreas, Solar position algorithm, Solar Energy 76, 577-589 (2003).

use glam::DVec3;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::Radians;
use solar_positioning::Location;
use solar_positioning::RefractionCorrection;
use solar_positioning::SolarPositions;
use solar_positioning::time::JulianDate;

/// Terrestrial less universal time, s: 69 in the 2020s. The sun moves along the ecliptic by a thousandth
/// of a degree in 90 s, so that other years do not matter here.
const DELTA_T_S: f64 = 69.0;
/// Hours in a day.
const DAY_H: f64 = 24.0;

/// A moment, and the place on Earth from which the sun is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Year, month, day, hour, minute and second on the clock; years from 0 to 9999.
    pub local_time: [u32; 6],
    /// What the clock is ahead of UTC, hours.
    pub utc_offset_h: f64,
    /// Latitude, north positive, degrees.
    pub latitude_deg: f64,
    /// Longitude, east positive, degrees.
    pub longitude_deg: f64,
}

/// Where the sun is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunPosition {
    /// Apparent elevation above the horizon, refraction included, degrees.
    pub elevation_deg: f64,
    /// Azimuth, clockwise from north, degrees.
    pub azimuth_deg: f64,
}

/// A time or place that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoSuchMoment(String);

impl SunPosition {
    /// Unit vector to it.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        let [elevation, azimuth] =
            [self.elevation_deg, self.azimuth_deg].map(Radians::from_degrees);
        direction_from_azimuth_elevation(azimuth, elevation)
    }
}

impl Moment {
    /// Where the sun is seen.
    ///
    /// # Errors
    /// A time or place that cannot be.
    pub fn sun(&self) -> Result<SunPosition, NoSuchMoment> {
        let refused = |error: solar_positioning::Error| NoSuchMoment(error.to_string());
        let [year, month, day, hour, minute, second] = self.local_time;
        let second = f64::from(second.min(59));
        let local = JulianDate::from_utc(year as i32, month, day, hour, minute, second, DELTA_T_S)
            .map_err(refused)?;
        let utc = JulianDate::new(local.julian_date() - self.utc_offset_h / DAY_H, DELTA_T_S)
            .map_err(refused)?;
        let location = Location {
            latitude: self.latitude_deg,
            longitude: self.longitude_deg,
        };
        let refraction = Some(RefractionCorrection::standard());
        let position = SolarPositions::new()
            .at_from_julian(utc, location, 0.0, refraction)
            .map_err(refused)?;
        Ok(SunPosition {
            elevation_deg: position.elevation_angle(),
            azimuth_deg: position.azimuth(),
        })
    }

    /// The whole hours by which the clock would have to be off for the sun to stand nearest to
    /// `sun`, and the angle that is left.
    ///
    /// # Errors
    /// As [`Self::sun`].
    pub fn best_shift_h(&self, sun: DVec3) -> Result<(i32, Radians), NoSuchMoment> {
        let mut best = (0, Radians(f64::INFINITY));
        for shift_h in -12..=12 {
            let shifted = Self {
                utc_offset_h: self.utc_offset_h + f64::from(shift_h),
                ..*self
            };
            let angle = shifted.sun()?.direction().angle_between(sun);
            if angle < best.1.0 {
                best = (shift_h, Radians(angle));
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

    use super::*;

    /// The example of RA03: Golden, Colorado, 2003-10-17 12:30:30 at UTC-7.
    const EXAMPLE: Moment = Moment {
        local_time: [2003, 10, 17, 12, 30, 30],
        utc_offset_h: -7.0,
        latitude_deg: 39.742476,
        longitude_deg: -105.1786,
    };

    #[test]
    fn the_published_example_is_met() {
        let sun = EXAMPLE.sun().unwrap();
        // RA03: zenith 50.11162 with 820 hPa at 1830 m, azimuth 194.34024.
        let zenith_deg = 90.0 - sun.elevation_deg;
        assert!((zenith_deg - 50.11162).abs() < 0.01, "{zenith_deg}");
        assert!((sun.azimuth_deg - 194.34024).abs() < 0.002, "{sun:?}");
    }

    #[test]
    fn a_clock_on_another_zone_is_told_by_whole_hours() {
        let sun = EXAMPLE.sun().unwrap().direction();
        let wrong = Moment {
            utc_offset_h: -4.0,
            ..EXAMPLE
        };
        let (shift_h, left) = wrong.best_shift_h(sun).unwrap();
        assert_eq!(shift_h, -3);
        assert!(left.0 < 1e-7);
    }
}
