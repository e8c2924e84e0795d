//! The scattering angle of a view ray.
//!
//! Sunlight travels along -w, light to the eye along -d, so cos theta = w . d:
//! theta = atan2(|w x d|, w . d)
//! `w` unit vector towards the sun, `d` unit direction of the view ray. Towards the sun theta = 0, at
//! the antisolar point 180 degrees. The arc cosine would lose half of the digits at both.

use glam::DVec3;

/// Scattering angle on a view ray, constant along it because the sun is far.
pub(crate) fn scattering_angle_rad(view_direction: DVec3, sun_direction: DVec3) -> f64 {
    sun_direction
        .cross(view_direction)
        .length()
        .atan2(sun_direction.dot(view_direction))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn it_is_zero_towards_the_sun_and_pi_away_from_it() {
        let sun = DVec3::new(0.3, 0.5, -0.2).normalize();
        assert!(scattering_angle_rad(sun, sun).abs() < 1e-15);
        assert_eq!(scattering_angle_rad(-sun, sun), PI);
        assert_eq!(scattering_angle_rad(DVec3::X, DVec3::Y), FRAC_PI_2);
    }

    #[test]
    fn it_keeps_its_digits_next_to_the_antisolar_point() {
        let view = DVec3::new(1e-9, -1.0, 0.0);
        let off = PI - scattering_angle_rad(view, DVec3::Y);
        // The spacing of f64 at pi is 4e-16.
        assert!((off - 1e-9).abs() < 1e-15);
    }
}
