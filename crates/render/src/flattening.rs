//! How the flat shape of large drops moves the bow along a view ray, by T² and B².
//!
//! m = ((s + d).z)^2 / |s + d|^2 - ((s - d).z)^2 / |s - d|^2
//! `s` unit vector towards the sun, `d` unit direction of the view ray, `z` straight up (y of the
//! world, the upright short axis of a falling drop). T² and B² are the terms of
//! m, which lies in -1..1. To first order in the axis ratio q the rainbow angle of the primary moves by
//! m 16 (1 - q)/(1 + q) sin r0 cos^3 r0, `r0` the angle of refraction of the rainbow ray.
//!
//! A ray meets the drop symmetrically to the bisector B = (s - d)/|s - d| of its ways in and out,
//! in the plane that B spans with T = (s + d)/|s + d|. The section of a spheroid of small
//! eccentricity e by this plane, whose normal N tilts from the vertical, is an ellipse of
//! eccentricity e (1 - (N.z)^2) = e ((B.z)^2 + (T.z)^2) with its short axis along the projection of
//! z. Lengthening the path of all rays of one order in proportion to the cosine of twice the angle
//! chi between B and that projection moves the bow by the same factor:
//! m = -(1 - (N.z)^2) cos 2 chi = (T.z)^2 - (B.z)^2.
//!
//! Valid for any direction; the second order is a form in T² and B² (`niji_exchange::MovedBows`). At the top of a bow with
//! the sun on the horizon m is the cosine of the bow angle, at its feet 0. At the antisolar point T
//! has no direction, towards the sun B has none: around them it turns within a ray's width, and the
//! mean of its turns is taken. The tilt of the vertical between the eye and drops 10 km away, 0.1
//! degrees, is left out.
//! [M10] W. Möbius, Ann. Phys. 338, 1493-1558 (1910): the primary of an ellipse.
//! [LK17] J. A. Lock and G. P. Können, Appl. Opt. 56, G88-G97 (2017): all orders, along the bow.
//! [H20] A. Haußmann, Appl. Opt. 59, F20 (2020): shifts applied to the bows of spheres.

use glam::DVec3;

/// Straight up.
const VERTICAL: DVec3 = DVec3::Y;

/// Squared length of a sum or difference of unit vectors below which it has no direction: 1e-9 rad.
const NO_DIRECTION: f64 = 1e-18;

/// T² and B² along a view ray.
pub(crate) fn axis_squares(view_direction: DVec3, sun_direction: DVec3) -> [f64; 2] {
    let across = sun_direction + view_direction;
    let along = sun_direction - view_direction;
    // What is left for the vector that has no direction, on the mean over its turns.
    let mean = 0.5 * (1.0 - sun_direction.dot(VERTICAL).powi(2));
    let square = |vector: DVec3| {
        let length_squared = vector.length_squared();
        if length_squared > NO_DIRECTION {
            vector.dot(VERTICAL).powi(2) / length_squared
        } else {
            mean
        }
    };
    [square(across), square(along)]
}

#[cfg(test)]
mod tests {
    use niji_geometry::direction_from_azimuth_elevation;
    use niji_radiometry::Radians;

    use super::*;

    const PRIMARY_DEG: f64 = 42.0;

    /// m, from -1 to 1; 0 leaves the bow where spheres make it, to first order.
    fn flattening_along(view_direction: DVec3, sun_direction: DVec3) -> f64 {
        let [t2, b2] = axis_squares(view_direction, sun_direction);
        t2 - b2
    }

    fn direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
        direction_from_azimuth_elevation(
            Radians::from_degrees(azimuth_deg),
            Radians::from_degrees(elevation_deg),
        )
    }

    /// View of a bow `bow_deg` from the antisolar point, `clock_deg` from its top.
    fn view_of_bow(sun: DVec3, bow_deg: f64, clock_deg: f64) -> DVec3 {
        let right = (-sun).cross(DVec3::Y).normalize();
        let up = right.cross(-sun);
        let (bow, clock) = (bow_deg.to_radians(), clock_deg.to_radians());
        -sun * bow.cos() + (right * clock.sin() + up * clock.cos()) * bow.sin()
    }

    /// The same, written with the plane of scattering: -(1 - (N.z)^2) cos 2 chi.
    fn by_section(view: DVec3, sun: DVec3) -> f64 {
        let normal = sun.cross(view).normalize();
        let bisector = (sun - view).normalize();
        let projected = DVec3::Y - normal * normal.dot(DVec3::Y);
        let cos_chi = bisector.dot(projected.normalize());
        -(1.0 - normal.y * normal.y) * (2.0 * cos_chi * cos_chi - 1.0)
    }

    #[test]
    fn it_is_the_shift_of_the_elliptic_section() {
        for elevation_deg in [-5.0, 0.0, 20.0, 41.0, 70.0] {
            let sun = direction(200.0, elevation_deg);
            for bow_deg in [5.0, PRIMARY_DEG, 51.0, 90.0, 150.0] {
                for clock_deg in [3.0, 40.0, 90.0, 130.0, 181.0, 300.0] {
                    let view = view_of_bow(sun, bow_deg, clock_deg);
                    let found = flattening_along(view, sun);
                    assert!((found - by_section(view, sun)).abs() < 1e-12);
                    assert!(found.abs() <= 1.0 + 1e-15);
                }
            }
        }
    }

    #[test]
    fn nothing_moves_at_the_feet_of_the_bow_of_a_setting_sun() {
        let sun = direction(250.0, 0.0);
        for bow_deg in [PRIMARY_DEG, 51.0] {
            for clock_deg in [90.0, 270.0] {
                let m = flattening_along(view_of_bow(sun, bow_deg, clock_deg), sun);
                assert!(m.abs() < 1e-15, "{m}");
            }
        }
    }

    #[test]
    fn the_top_moves_down_most_where_the_sun_is_half_a_bow_angle_high() {
        let top = |elevation_deg: f64| {
            let sun = direction(250.0, elevation_deg);
            flattening_along(view_of_bow(sun, PRIMARY_DEG, 0.0), sun)
        };
        // cos(bow angle - 2 elevation), positive: to larger scattering angles.
        for elevation_deg in [0.0, 10.0, 21.0, 40.0] {
            let expected = (PRIMARY_DEG - 2.0 * elevation_deg).to_radians().cos();
            assert!((top(elevation_deg) - expected).abs() < 1e-14);
        }
        assert!((top(21.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_shift_of_drops_of_1_mm_is_that_of_traced_rays() {
        // Top of the primary of n = 1.333 at 1 mm diameter, against 42.08 of the sphere, traced
        // through the ellipse of Beard and Chuang's axis ratio, J. Atmos. Sci. 44, 1509 (1987).
        let eccentricity = (1.0 - 0.9826) / (1.0 + 0.9826);
        let incidence = ((1.333_f64 * 1.333 - 1.0) / 3.0).sqrt().acos();
        let refraction = (incidence.sin() / 1.333).asin();
        let scale = 16.0 * eccentricity * refraction.sin() * refraction.cos().powi(3);
        for (elevation_deg, traced_deg) in [(0.0, 40.31), (20.0, 39.74), (40.0, 40.30)] {
            let sun = direction(250.0, elevation_deg);
            let m = flattening_along(view_of_bow(sun, 42.08, 0.0), sun);
            let predicted_deg = 42.08 - (m * scale).to_degrees();
            // The second order that is left out; measured worst 0.06.
            assert!((predicted_deg - traced_deg).abs() < 0.08, "{predicted_deg}");
        }
    }

    #[test]
    fn at_the_sun_and_at_the_antisolar_point_it_is_the_mean_around_it() {
        for elevation_deg in [0.0, 30.0] {
            let sun = direction(10.0, elevation_deg);
            for bow_deg in [0.0, 180.0] {
                let n = 36;
                let around = (0..n).map(|step| {
                    let clock_deg = 10.0 * f64::from(step);
                    flattening_along(view_of_bow(sun, (bow_deg - 1e-4_f64).abs(), clock_deg), sun)
                });
                let mean = around.sum::<f64>() / f64::from(n);
                let found = flattening_along(view_of_bow(sun, bow_deg, 0.0), sun);
                assert!((found - mean).abs() < 1e-6, "{found} {mean}");
            }
        }
    }
}
