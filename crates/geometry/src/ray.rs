//! Rays, and directions in the world frame: y up, north −z, east +x.

use glam::DVec3;
use niji_radiometry::Radians;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, in metres.
    pub origin: DVec3,
    /// Unit vector along it.
    pub direction: DVec3,
}

impl Ray {
    /// The point at `distance_m` from the origin.
    #[must_use]
    #[inline]
    pub fn at(&self, distance_m: f64) -> DVec3 {
        self.origin + distance_m * self.direction
    }
}

/// Unit vector at an azimuth (clockwise from north, seen from above) and an elevation.
#[must_use]
pub fn direction_from_azimuth_elevation(azimuth: Radians, elevation: Radians) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth.0.sin_cos();
    let (sin_elevation, cos_elevation) = elevation.0.sin_cos();
    DVec3::new(
        cos_elevation * sin_azimuth,
        sin_elevation,
        -cos_elevation * cos_azimuth,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_east_and_zenith_point_where_the_conventions_say() {
        let direction = |azimuth_deg, elevation_deg| {
            direction_from_azimuth_elevation(
                Radians::from_degrees(azimuth_deg),
                Radians::from_degrees(elevation_deg),
            )
        };
        assert!(direction(0.0, 0.0).distance(DVec3::NEG_Z) < 1e-15);
        assert!(direction(90.0, 0.0).distance(DVec3::X) < 1e-15);
        assert!(direction(12.0, 90.0).distance(DVec3::Y) < 1e-15);
    }
}
