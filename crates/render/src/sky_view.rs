//! How much of the sky a place sees between surfaces.
//!
//! V = sum_j I_j(h_j) / sum_j I_j(0),   I_j(h) = int_{e > h, n.s > 0} (n . s) cos e de
//!                                             = [a (e/2 + sin(2e)/4) + b sin^2(e)/2]
//! over azimuths j: `h_j` elevation up to which surfaces stand there, of meshes by halving, `s` direction of elevation e,
//! `a` and `b` components of the normal n along the azimuth and upwards. An estimate: 12 azimuths, an even sky, and
//! what stands free above the horizon of an azimuth, as a bridge, is taken for solid or for nothing.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;

use glam::DVec3;

/// Azimuths in which the horizon is looked for.
const N_AZIMUTHS: u32 = 12;

/// Elevation of the first look: what stays below it counts as level (rad).
const FIRST_RAD: f64 = 0.017;

/// Halvings of the elevations above: 1.4 degrees are left.
const N_HALVINGS: u32 = 6;

/// Share of the light of an even sky on a face with a normal that surfaces leave; 1 for a face that sees no sky.
///
/// `horizon_rad` gives the elevation up to which surfaces stand along a horizontal unit vector.
pub(crate) fn free_share(normal: DVec3, horizon_rad: impl Fn(DVec3) -> f64) -> f64 {
    let (mut free, mut all) = (0.0, 0.0);
    for azimuth in 0..N_AZIMUTHS {
        let (sin, cos) = (TAU * (f64::from(azimuth) + 0.5) / f64::from(N_AZIMUTHS)).sin_cos();
        let along = DVec3::new(sin, 0.0, -cos);
        let seen = Seen {
            a: normal.dot(along),
            b: normal.y,
        };
        let whole = seen.above(0.0);
        all += whole;
        if whole > 0.0 {
            free += seen.above(horizon_rad(along));
        }
    }
    if all > 0.0 { free / all } else { 1.0 }
}

/// Share of what lies below the horizon that surfaces are, weighed by the cosine to a normal; 0 for a level face.
///
/// `is_met` tells of a unit vector whether a surface stands there. An estimate by three rays an azimuth.
pub(crate) fn share_met_below(normal: DVec3, is_met: impl Fn(DVec3) -> bool) -> f64 {
    let (mut met, mut all) = (0.0, 0.0);
    for azimuth in 0..N_AZIMUTHS {
        let (sin, cos) = (TAU * (f64::from(azimuth) + 0.5) / f64::from(N_AZIMUTHS)).sin_cos();
        for down_rad in [1.0, 3.0, 5.0].map(|sixths| sixths / 6.0 * FRAC_PI_2) {
            let towards = DVec3::new(sin * down_rad.cos(), -down_rad.sin(), -cos * down_rad.cos());
            let weight = normal.dot(towards) * down_rad.cos();
            if weight > 0.0 {
                all += weight;
                met += if is_met(towards) { weight } else { 0.0 };
            }
        }
    }
    if all > 0.0 { met / all } else { 0.0 }
}

/// Elevation above a horizontal unit vector above which nothing stands, by halving.
pub(crate) fn horizon_by_halving_rad(along: DVec3, is_blocked: impl Fn(DVec3) -> bool) -> f64 {
    let at = |elevation: f64| elevation.cos() * along + elevation.sin() * DVec3::Y;
    let is_blocked = |elevation: f64| is_blocked(at(elevation));
    if !is_blocked(FIRST_RAD) {
        return 0.0;
    }
    let (mut low, mut high) = (FIRST_RAD, FRAC_PI_2);
    for _ in 0..N_HALVINGS {
        let middle = 0.5 * (low + high);
        if is_blocked(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// A face in the plane of an azimuth.
struct Seen {
    a: f64,
    b: f64,
}

impl Seen {
    /// Light of an even sky above an elevation.
    fn above(&self, horizon: f64) -> f64 {
        let Self { a, b } = *self;
        // n.s = 0 at this elevation, if it is one; above it light comes from in front of the face, or behind.
        let own = -(a / b).atan();
        let (from, to) = match (a > 0.0, b > 0.0) {
            (true, true) => (horizon, FRAC_PI_2),
            (false, true) => (horizon.max(own), FRAC_PI_2),
            (true, false) => (horizon, own.clamp(0.0, FRAC_PI_2)),
            (false, false) => return 0.0,
        };
        let up_to = |e: f64| a * (0.5 * e + 0.25 * (2.0 * e).sin()) + 0.5 * b * e.sin().powi(2);
        if from < to {
            up_to(to) - up_to(from)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_way_leaves_all_of_the_sky() {
        for normal in [DVec3::Y, DVec3::X, DVec3::new(0.6, 0.8, 0.0), -DVec3::Y] {
            assert_eq!(free_share(normal, |_| 0.0), 1.0, "{normal}");
        }
    }

    #[test]
    fn a_level_face_in_a_bowl_sees_the_square_of_the_cosine_of_its_rim() {
        for rim_deg in [10.0_f64, 30.0, 60.0] {
            let rim = rim_deg.to_radians();
            let found = free_share(DVec3::Y, |along| {
                horizon_by_halving_rad(along, |towards| towards.y < rim.sin())
            });
            // The last halving leaves 0.7 degrees.
            assert!(
                (found - rim.cos().powi(2)).abs() < 0.012,
                "{rim_deg}: {found}"
            );
        }
    }

    #[test]
    fn a_wall_takes_half_of_the_sky_from_a_level_face_beside_it_and_none_from_itself() {
        let wall = |along: DVec3| horizon_by_halving_rad(along, |towards: DVec3| towards.x > 0.0);
        assert!((free_share(DVec3::Y, wall) - 0.5).abs() < 0.01);
        assert_eq!(free_share(DVec3::NEG_X, wall), 1.0);
    }

    #[test]
    fn a_tilted_face_has_the_share_of_the_sky_that_geometry_gives() {
        // (1 + n.up)/2 of an even sphere: what lies above the level plane, over pi.
        for tilt_deg in [0.0_f64, 20.0, 50.0, 90.0, 120.0] {
            let (sin, cos) = tilt_deg.to_radians().sin_cos();
            let normal = DVec3::new(sin, cos, 0.0);
            let azimuths = (0..N_AZIMUTHS).map(|azimuth| {
                let (sin, cos) =
                    (TAU * (f64::from(azimuth) + 0.5) / f64::from(N_AZIMUTHS)).sin_cos();
                let along = DVec3::new(sin, 0.0, -cos);
                let seen = Seen {
                    a: normal.dot(along),
                    b: normal.y,
                };
                seen.above(0.0)
            });
            let found = azimuths.sum::<f64>() * TAU / f64::from(N_AZIMUTHS) / std::f64::consts::PI;
            // Twelve azimuths: worst found 0.006.
            assert!(
                (found - 0.5 * (1.0 + cos)).abs() < 0.01,
                "{tilt_deg}: {found}"
            );
        }
    }
}
