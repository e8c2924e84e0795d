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

/// Changes of the scattering angle where the unit direction changes by one of `slopes`. At the
/// antisolar point itself, where it grows on all sides, 0.
pub(crate) fn scattering_angle_slopes(
    view_direction: DVec3,
    sun_direction: DVec3,
    slopes: [DVec3; 2],
) -> [f64; 2] {
    let sine = sun_direction.cross(view_direction).length();
    slopes.map(|slope| {
        if sine > 0.0 {
            // Rounding must not make the angle change faster than the direction.
            let most = slope.length();
            (-sun_direction.dot(slope) / sine).clamp(-most, most)
        } else {
            0.0
        }
    })
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

    #[test]
    fn its_slope_is_the_difference_of_angles_and_never_above_that_of_the_direction() {
        let sun = DVec3::new(0.3, 0.5, -0.2).normalize();
        let across = sun.any_orthonormal_vector();
        for off in [1e-9, 1e-3, 0.7, 1.5] {
            let view = (across * f64::sin(off) - sun * f64::cos(off)).normalize();
            let turns = [view.cross(across), view.cross(sun)];
            let slopes = turns.map(|turn| 1e-3 * turn.cross(view));
            let found = scattering_angle_slopes(view, sun, slopes);
            for (slope, found) in slopes.into_iter().zip(found) {
                assert!(found.abs() <= slope.length());
                let ends = [-0.5, 0.5].map(|part| (view + part * slope).normalize());
                let [from, to] = ends.map(|end| scattering_angle_rad(end, sun));
                // Within the step of the antisolar point the angle has a kink.
                if off > 0.1 {
                    // Of a step of 1e-3: the third difference.
                    assert!((found - (to - from)).abs() < 1e-9, "{off}");
                }
            }
        }
        let slopes = [1e-3 * across; 2];
        assert_eq!(scattering_angle_slopes(-sun, sun, slopes), [0.0; 2]);
    }
}
