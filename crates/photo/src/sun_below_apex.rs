//! The sun that puts the top of a bow at a place.
//!
//! azimuth = azimuth(d) + 180°,   elevation = theta − elevation(d)
//! `d` the view direction to the top, `theta` the bow angle: the antisolar point lies straight below the top. A sun
//! below the horizon makes no bow; whoever asks is told its elevation.

use glam::DVec3;
use niji_radiometry::Radians;

/// Azimuth, clockwise from north, 0 to 2π, and elevation of the sun.
#[must_use]
pub fn sun_below_apex(apex: DVec3, bow_angle: Radians) -> [Radians; 2] {
    let azimuth = (-apex.x).atan2(apex.z).rem_euclid(std::f64::consts::TAU);
    let top = apex.y.clamp(-1.0, 1.0).asin();
    [Radians(azimuth), Radians(bow_angle.0 - top)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_geometry::direction_from_azimuth_elevation;

    #[test]
    fn the_apex_is_the_highest_direction_at_the_bow_angle() {
        let theta = Radians::from_degrees(42.0);
        for (azimuth_deg, top_deg) in [(0.0, 15.0), (77.0, 41.0), (200.0, -5.0), (359.0, 30.0)] {
            let [azimuth, top] = [azimuth_deg, top_deg].map(Radians::from_degrees);
            let apex = direction_from_azimuth_elevation(azimuth, top);
            let [sun_azimuth, sun_elevation] = sun_below_apex(apex, theta);
            let antisolar = -direction_from_azimuth_elevation(sun_azimuth, sun_elevation);
            assert!((apex.angle_between(antisolar) - theta.0).abs() < 1e-9);
            // Beside it, as high, the bow is farther out.
            for beside_deg in [-1.0, 1.0] {
                let beside = Radians::from_degrees(azimuth_deg + beside_deg);
                let beside = direction_from_azimuth_elevation(beside, top);
                assert!(beside.angle_between(antisolar) > theta.0);
            }
        }
    }
}
