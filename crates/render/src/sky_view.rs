//! How much of the sky a place sees between surfaces.
//!
//! V = sum_j sum_k [I_j(e_k) - I_j(f_k)] / sum_j I_j(0),   I_j(h) = int_{e > h, n.s > 0} (n . s) cos e de
//!                                                            = [a (e/2 + sin(2e)/4) + b sin^2(e)/2]
//! over azimuths j and the gaps between surfaces there: `e_k` and `f_k` elevations from and up to which the sky is
//! seen, `s` direction of elevation e, `a` and `b` components of the normal n along the azimuth and upwards. An
//! estimate: 12 azimuths and an even sky.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;
use niji_geometry::CoveredSlopes;

/// Azimuths in which the horizon is looked for.
pub(crate) const N_AZIMUTHS: usize = 12;

/// One of the azimuths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Azimuth {
    /// Which, in a turn from north by east.
    pub(crate) index: usize,
    /// Horizontal unit vector along it.
    pub(crate) along: DVec3,
}

/// The azimuths in which the horizon is looked for.
pub(crate) fn azimuths() -> impl Iterator<Item = Azimuth> {
    (0..N_AZIMUTHS).map(|index| {
        let (sin, cos) = (TAU * (index as f64 + 0.5) / N_AZIMUTHS as f64).sin_cos();
        let along = DVec3::new(sin, 0.0, -cos);
        Azimuth { index, along }
    })
}

/// Share of the light of an even sky on a face with a normal that surfaces leave; 1 for a face that sees no sky.
///
/// `side` is the normal of the flat triangle there, behind which nothing is seen; `cover` covers the slopes of sights
/// along an azimuth in which surfaces stand.
pub(crate) fn free_share(
    (side, normal): (DVec3, DVec3),
    cover: impl Fn(Azimuth, &mut CoveredSlopes),
) -> f64 {
    let (mut free, mut all) = (0.0, 0.0);
    for azimuth in azimuths() {
        let along = azimuth.along;
        let seen = Seen {
            a: normal.dot(along),
            b: normal.y,
        };
        let whole = seen.above(0.0);
        all += whole;
        let in_front = slopes_in_front(side, along).filter(|_| whole > 0.0);
        let Some(slopes) = in_front else { continue };
        let mut covered = CoveredSlopes::all_but(slopes);
        cover(azimuth, &mut covered);
        for gap in covered.gaps() {
            free += seen.above(gap.start.atan()) - seen.above(gap.end.atan());
        }
    }
    if all > 0.0 { free / all } else { 1.0 }
}

/// Share of what lies below the horizon that surfaces are, weighed by the cosine to a normal; 0 for a level face.
///
/// `is_met` tells of a unit vector whether a surface stands there. An estimate by three rays an azimuth.
pub(crate) fn share_met_below(normal: DVec3, is_met: impl Fn(DVec3) -> bool) -> f64 {
    let (mut met, mut all) = (0.0, 0.0);
    for Azimuth { along, .. } in azimuths() {
        for down_rad in [1.0, 3.0, 5.0].map(|sixths| sixths / 6.0 * FRAC_PI_2) {
            let towards = down_rad.cos() * along - down_rad.sin() * DVec3::Y;
            let weight = normal.dot(towards) * down_rad.cos();
            if weight > 0.0 {
                all += weight;
                met += if is_met(towards) { weight } else { 0.0 };
            }
        }
    }
    if all > 0.0 { met / all } else { 0.0 }
}

/// Tangents of the elevations, from 0 on, between which a flat face sees along a horizontal unit vector: above its plane
/// or, of one that is turned downwards, below; `None` where it sees nothing.
fn slopes_in_front(side: DVec3, along: DVec3) -> Option<Range<f64>> {
    let (across, up) = (side.dot(along), side.y);
    if up > 0.0 {
        Some((-across / up).max(0.0)..f64::INFINITY)
    } else {
        (across > 0.0).then(|| 0.0..(across / up).abs())
    }
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
            assert_eq!(free_share((normal, normal), |_, _| {}), 1.0, "{normal}");
        }
    }

    #[test]
    fn a_level_face_in_a_bowl_sees_the_square_of_the_cosine_of_its_rim() {
        for rim_deg in [10.0_f64, 30.0, 60.0] {
            let rim = rim_deg.to_radians();
            let up_to_rim = [0.0, rim.tan()];
            let found = free_share((DVec3::Y, DVec3::Y), |_, covered| covered.add(up_to_rim));
            assert!(
                (found - rim.cos().powi(2)).abs() < 1e-12,
                "{rim_deg}: {found}"
            );
        }
    }

    #[test]
    fn a_wall_takes_half_of_the_sky_from_a_level_face_beside_it_and_none_from_itself() {
        let wall = |azimuth: Azimuth, covered: &mut CoveredSlopes| {
            if azimuth.along.x > 0.0 {
                covered.add([0.0, f64::INFINITY]);
            }
        };
        assert!((free_share((DVec3::Y, DVec3::Y), wall) - 0.5).abs() < 0.01);
        assert_eq!(free_share((DVec3::NEG_X, DVec3::NEG_X), wall), 1.0);
    }

    #[test]
    fn under_a_bridge_the_sky_is_what_lies_below_it() {
        for (low_deg, high_deg) in [(0.0_f64, 40.0_f64), (20.0, 50.0), (30.0, 90.0)] {
            let [low, high] = [low_deg, high_deg].map(f64::to_radians);
            let bridge = [low.tan(), high.tan()];
            let found = free_share((DVec3::Y, DVec3::Y), |_, covered| covered.add(bridge));
            let expected = 1.0 - (high.sin().powi(2) - low.sin().powi(2));
            assert!((found - expected).abs() < 1e-12, "{low_deg} {found}");
        }
    }

    #[test]
    fn a_face_sees_along_the_slopes_that_lie_in_front_of_it() {
        for tilt_deg in [0.0_f64, 30.0, 90.0, 100.0, 150.0, 180.0] {
            let (sin, cos) = tilt_deg.to_radians().sin_cos();
            let side = DVec3::new(0.6 * sin, cos, 0.8 * sin);
            for along in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)] {
                let seen = slopes_in_front(side, along);
                for tangent in [0.013, 0.2, 1.1, 4.7, 90.0] {
                    let is_in_front = side.dot(along + tangent * DVec3::Y) > 1e-9;
                    let is_seen = seen.as_ref().is_some_and(|it| it.contains(&tangent));
                    assert_eq!(is_seen, is_in_front, "{tilt_deg} {along} {tangent}");
                }
            }
        }
    }

    #[test]
    fn a_tilted_face_has_the_share_of_the_sky_that_geometry_gives() {
        // (1 + n.up)/2 of an even sphere: what lies above the level plane, over pi.
        for tilt_deg in [0.0_f64, 20.0, 50.0, 90.0, 120.0] {
            let (sin, cos) = tilt_deg.to_radians().sin_cos();
            let normal = DVec3::new(sin, cos, 0.0);
            let all = azimuths().map(|Azimuth { along, .. }| {
                let seen = Seen {
                    a: normal.dot(along),
                    b: normal.y,
                };
                seen.above(0.0)
            });
            let found = all.sum::<f64>() * TAU / N_AZIMUTHS as f64 / std::f64::consts::PI;
            // Twelve azimuths: worst found 0.006.
            assert!(
                (found - 0.5 * (1.0 + cos)).abs() < 0.01,
                "{tilt_deg}: {found}"
            );
        }
    }
}
