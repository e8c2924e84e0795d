//! The tilt of a camera from two points of the horizon, or at least from the sky.
//!
//! n = ± (d1 x d2)/|d1 x d2|, the vertical in the camera's frame, upwards:
//! sin(elevation) = −n_z,   roll = atan2(−n_x, n_y)
//! `d1`, `d2` view directions in the camera's frame (x right, y up, looking along −z). The horizon is
//! a great circle for an eye near the ground; from a height h it lies sqrt(2 h/R) lower (1.9 minutes
//! of arc for every square root of a metre), which is left out.
//!
//! No sky lies below the horizon: a level camera that sees some below its middle looks up by
//! elevation = −asin(d_y)  at least, `d` the view direction to the lowest row of it.

use glam::DVec3;
use ndarray::Array2;
use niji_geometry::PinholeCamera;
use niji_radiometry::Radians;

use crate::circle_through_picks::angle_between;
use crate::error::Error;

/// Least angle between the two points, radians.
const LEAST_ANGLE_RAD: f64 = 1e-3;

/// Part of a row that is sky in the lowest one that counts.
const LEAST_SKY: f64 = 0.05;

/// How far a camera looks up that would see sky below its horizon if it were level; `None` where it would not.
///
/// `level` is the camera without tilt.
#[must_use]
pub fn tilt_from_sky(level: &PinholeCamera, is_sky: &Array2<bool>) -> Option<Radians> {
    let least = LEAST_SKY * is_sky.ncols() as f64;
    let is_low = |row: &usize| {
        let n_sky = is_sky.row(*row).iter().filter(|is_sky| **is_sky).count();
        n_sky as f64 > least
    };
    let lowest = (0..is_sky.nrows()).rev().find(is_low)?;
    let below = level.ray(0.5 * is_sky.ncols() as f64, lowest as f64 + 1.0);
    let elevation = -below.direction.y.asin();
    (elevation > 0.0).then_some(Radians(elevation))
}

/// Elevation of the axis and roll of a camera that sees two points of the horizon.
///
/// `level` is the camera without tilt: azimuth, elevation and roll 0.
///
/// # Errors
/// Points that coincide.
pub fn tilt_from_horizon(
    level: &PinholeCamera,
    points_px: [[f64; 2]; 2],
) -> Result<(Radians, Radians), Error> {
    let [d1, d2] = points_px.map(|[x_px, y_px]| level.ray(x_px, y_px).direction);
    let angle = angle_between(d1, d2);
    // False for NaN too.
    let is_sound = angle > LEAST_ANGLE_RAD;
    if !is_sound {
        return Err(Error::Range {
            what: "the angle between two points of the horizon in radians",
            found: angle,
            expected: "at least 0.001",
        });
    }
    let normal = d1.cross(d2).normalize();
    let up = if normal.dot(DVec3::Y) < 0.0 {
        -normal
    } else {
        normal
    };
    let elevation = (-up.z).clamp(-1.0, 1.0).asin();
    Ok((Radians(elevation), Radians((-up.x).atan2(up.y))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_geometry::PinholeRequest;

    fn camera(elevation_deg: f64, roll_deg: f64) -> PinholeCamera {
        PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians::from_degrees(elevation_deg),
            roll: Radians::from_degrees(roll_deg),
            horizontal_fov: Radians::from_degrees(70.0),
            width_px: 1000,
            height_px: 700,
        })
        .unwrap()
    }

    #[test]
    fn sky_below_the_middle_tilts_a_camera_up_to_its_lowest_row() {
        let tilted = camera(12.0, 0.0);
        let is_above = |y: usize, x: usize| {
            let ray = tilted.ray(x as f64 + 0.5, y as f64 + 0.5);
            ray.direction.y > 0.0
        };
        let sky = Array2::from_shape_fn((700, 1000), |(y, x)| is_above(y, x));
        let found = tilt_from_sky(&camera(0.0, 0.0), &sky).unwrap();
        assert!((found.to_degrees() - 12.0).abs() < 0.05, "{found:?}");
        // A few pixels are none, and hills may hide a horizon.
        let sky = Array2::from_shape_fn((700, 1000), |(y, x)| y < 300 || (y < 500 && x < 40));
        assert_eq!(tilt_from_sky(&camera(0.0, 0.0), &sky), None);
        assert_eq!(tilt_from_sky(&camera(0.0, 0.0), &sky.mapv(|_| false)), None);
    }

    #[test]
    fn the_horizon_gives_the_tilt_back() {
        for (elevation_deg, roll_deg) in [(0.0, 0.0), (15.0, 0.0), (-20.0, 8.0), (5.0, -30.0)] {
            let tilted = camera(elevation_deg, roll_deg);
            let points = [-20.0_f64, 25.0].map(|azimuth_deg| {
                let (sin, cos) = azimuth_deg.to_radians().sin_cos();
                let (x, y) = tilted.project(DVec3::new(sin, 0.0, -cos)).unwrap();
                [x, y]
            });
            let (elevation, roll) = tilt_from_horizon(&camera(0.0, 0.0), points).unwrap();
            assert!((elevation.to_degrees() - elevation_deg).abs() < 1e-11);
            assert!((roll.to_degrees() - roll_deg).abs() < 1e-11);
        }
        assert!(tilt_from_horizon(&camera(0.0, 0.0), [[3.0, 4.0]; 2]).is_err());
    }
}
