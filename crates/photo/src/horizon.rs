//! The tilt of a camera from two points of the horizon.
//!
//! n = ± (d1 x d2)/|d1 x d2|, the vertical in the camera's frame, upwards:
//! sin(elevation) = −n_z,   roll = atan2(−n_x, n_y)
//! `d1`, `d2` view directions in the camera's frame (x right, y up, looking along −z). The horizon is
//! a great circle for an eye near the ground; from a height h it lies sqrt(2 h/R) lower (1.9 minutes
//! of arc for every square root of a metre), which is left out.

use glam::DVec3;
use niji_geometry::PinholeCamera;
use niji_radiometry::Radians;

use crate::circle_through_picks::angle_between;
use crate::error::Error;

/// Least angle between the two points, radians.
const LEAST_ANGLE_RAD: f64 = 1e-3;

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
