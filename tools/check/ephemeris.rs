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

use crate::failure::Failure;

/// Terrestrial less universal time, s: 69 in the 2020s. The sun moves along the ecliptic by a thousandth
/// of a degree in 90 s, so that other years do not matter here.
const DELTA_T_S: f64 = 69.0;
/// Hours in a day.
const DAY_H: f64 = 24.0;

/// A clock's time and where the clock hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeAndPlace {
    /// Year, month, day, hour, minute, second.
    pub(crate) local_time: [u32; 6],
    /// What the clock is ahead of UTC, hours.
    pub(crate) utc_offset_h: f64,
    /// Latitude and longitude, degrees, north and east positive.
    pub(crate) position_deg: [f64; 2],
}

impl TimeAndPlace {
    /// Unit vector to the sun.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a time or place that cannot be.
    pub(crate) fn sun(&self) -> Result<DVec3, Failure> {
        let [elevation, azimuth] = self.sun_deg()?.map(Radians::from_degrees);
        Ok(direction_from_azimuth_elevation(azimuth, elevation))
    }

    /// Apparent elevation of the sun and its azimuth clockwise from north, degrees.
    ///
    /// # Errors
    /// As [`Self::sun`].
    pub(crate) fn sun_deg(&self) -> Result<[f64; 2], Failure> {
        let usage = |error: solar_positioning::Error| Failure::Usage(error.to_string());
        let [year, month, day, hour, minute, second] = self.local_time;
        let local = JulianDate::from_utc(
            year as i32,
            month,
            day,
            hour,
            minute,
            f64::from(second.min(59)),
            DELTA_T_S,
        )
        .map_err(usage)?;
        let utc = JulianDate::new(local.julian_date() - self.utc_offset_h / DAY_H, DELTA_T_S)
            .map_err(usage)?;
        let [latitude, longitude] = self.position_deg;
        let location = Location {
            latitude,
            longitude,
        };
        let refraction = Some(RefractionCorrection::standard());
        let position = SolarPositions::new()
            .at_from_julian(utc, location, 0.0, refraction)
            .map_err(usage)?;
        Ok([position.elevation_angle(), position.azimuth()])
    }

    /// The whole hours by which the clock would have to be off for the sun to stand nearest to
    /// `sun`, and the angle that is left.
    ///
    /// # Errors
    /// As [`Self::sun`].
    pub(crate) fn best_shift_h(&self, sun: DVec3) -> Result<(i32, Radians), Failure> {
        let mut best = (0, Radians(f64::INFINITY));
        for shift_h in -12..=12 {
            let shifted = Self {
                utc_offset_h: self.utc_offset_h + f64::from(shift_h),
                ..*self
            };
            let angle = shifted.sun()?.angle_between(sun);
            if angle < best.1.0 {
                best = (shift_h, Radians(angle));
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of RA03: Golden, Colorado, 2003-10-17 12:30:30 at UTC-7.
    const EXAMPLE: TimeAndPlace = TimeAndPlace {
        local_time: [2003, 10, 17, 12, 30, 30],
        utc_offset_h: -7.0,
        position_deg: [39.742476, -105.1786],
    };

    #[test]
    fn the_published_example_is_met() {
        let sun = EXAMPLE.sun().unwrap();
        let elevation_deg = sun.y.asin().to_degrees();
        let azimuth_deg = sun.x.atan2(-sun.z).to_degrees().rem_euclid(360.0);
        // RA03: zenith 50.11162 with 820 hPa at 1830 m, azimuth 194.34024.
        assert!(
            (90.0 - elevation_deg - 50.11162).abs() < 0.01,
            "{elevation_deg}"
        );
        assert!((azimuth_deg - 194.34024).abs() < 0.002, "{azimuth_deg}");
    }

    #[test]
    fn a_clock_on_another_zone_is_told_by_whole_hours() {
        let sun = EXAMPLE.sun().unwrap();
        let wrong = TimeAndPlace {
            utc_offset_h: -4.0,
            ..EXAMPLE
        };
        let (shift_h, left) = wrong.best_shift_h(sun).unwrap();
        assert_eq!(shift_h, -3);
        assert!(left.0 < 1e-7);
    }
}
