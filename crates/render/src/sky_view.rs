//! How much of the sky a place sees between surfaces.
//!
//! V = sum_j sum_k [I_j(e_k) - I_j(f_k)] / sum_j I_j(0),   I_j(h) = int_{e > h, n.s > 0} (n . s) cos e de
//!                                                            = [a (e/2 + sin(2e)/4) + b sin^2(e)/2]
//! over azimuths j and the gaps between surfaces there: `e_k` and `f_k` elevations from and up to which the sky is
//! seen, `s` direction of elevation e, `a` and `b` components of the normal n along the azimuth and upwards. An
//! estimate: 12 azimuths and an even sky. What is hidden, and what lies below the horizon, has a few looks an azimuth, each
//! for as much of the light.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;
use niji_geometry::CoveredSlopes;

/// Azimuths in which the horizon is looked for.
pub(crate) const N_AZIMUTHS: usize = 12;

/// How often an azimuth is looked along above the horizon, at most, and below.
const MOST_LOOKS: u32 = 3;

/// Nobody looks for less than this of all light.
const LEAST_SHARE: f64 = 1e-4;

/// Halvings of a right angle in which a direction is looked for.
const N_HALVINGS: u32 = 6;

/// One of the azimuths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Azimuth {
    /// Which, in a turn from north by east.
    pub(crate) index: usize,
    /// Horizontal unit vector along it.
    pub(crate) along: DVec3,
}

impl Azimuth {
    /// Past which part of the light from a range of elevations it looks, 0 to 1: each elsewhere, lest they all see an edge
    /// at once.
    fn place(&self) -> f64 {
        ((5 * self.index) % N_AZIMUTHS) as f64 / N_AZIMUTHS as f64 + 0.5 / N_AZIMUTHS as f64
    }
}

/// The azimuths in which the horizon is looked for.
pub(crate) fn azimuths() -> impl Iterator<Item = Azimuth> {
    (0..N_AZIMUTHS).map(|index| {
        let (sin, cos) = (TAU * (index as f64 + 0.5) / N_AZIMUTHS as f64).sin_cos();
        let along = DVec3::new(sin, 0.0, -cos);
        Azimuth { index, along }
    })
}

/// A direction in which a face looks at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Look {
    /// Index of its azimuth.
    pub(crate) azimuth: usize,
    /// A number of its own among all looks of a place.
    pub(crate) number: u32,
    /// Unit vector.
    pub(crate) towards: DVec3,
    /// Share of an even sphere's light on the face that comes from about there.
    pub(crate) share: f64,
}

/// Share of the light of an even sky on a face with a normal that surfaces leave; 1 for a face that sees no sky.
///
/// `side` is the normal of the flat triangle there, behind which nothing is seen; `cover` covers the slopes of sights
/// along an azimuth in which surfaces stand, `hide` is told of these.
pub(crate) fn free_share(
    (side, normal): (DVec3, DVec3),
    cover: impl Fn(Azimuth, &mut CoveredSlopes),
    mut hide: impl FnMut(&Hidden),
) -> f64 {
    let all: f64 = sides(normal).map(|(_, _, whole)| whole).sum();
    if all <= 0.0 {
        return 1.0;
    }
    let of_sphere = 0.5 * (1.0 + normal.y) / all;
    let mut free = 0.0;
    for (azimuth, seen, whole) in sides(normal) {
        let in_front = slopes_in_front(side, azimuth.along).filter(|_| whole > 0.0);
        let Some(slopes) = in_front else { continue };
        let in_front = elevations(&slopes);
        let mut covered = CoveredSlopes::all_but(slopes);
        cover(azimuth, &mut covered);
        let open: f64 = covered
            .gaps()
            .map(|gap| seen.within(elevations(&gap)))
            .sum();
        free += open;
        let light = seen.within(in_front) - open;
        if light > LEAST_SHARE * all {
            hide(&Hidden {
                azimuth,
                seen,
                in_front,
                covered,
                light,
                of_sphere,
            });
        }
    }
    free / all
}

/// Share of what lies below the horizon of a face with a normal that surfaces are; 0 for a level face.
///
/// `is_met` tells whether a surface stands in a direction. An estimate by a few rays an azimuth.
pub(crate) fn share_met_below(normal: DVec3, mut is_met: impl FnMut(Look) -> bool) -> f64 {
    let sides = || sides(normal * (DVec3::ONE - 2.0 * DVec3::Y));
    let all: f64 = sides().map(|(_, _, whole)| whole).sum();
    if all <= 0.0 {
        return 0.0;
    }
    let of_sphere = 0.5 * (1.0 - normal.y) / all;
    let mut met = 0.0;
    for (azimuth, seen, whole) in sides().filter(|(_, _, whole)| *whole > LEAST_SHARE * all) {
        let n_looks = n_looks(whole);
        for mut look in looks((azimuth, whole), |light| {
            seen.elevation([0.0, FRAC_PI_2], light)
        }) {
            // Upside down.
            look.number += MOST_LOOKS * N_AZIMUTHS as u32;
            look.towards.y = -look.towards.y;
            look.share *= of_sphere;
            if is_met(look) {
                met += whole / f64::from(n_looks);
            }
        }
    }
    met / all
}

/// A face along all azimuths, with the light that it has there of an even sky.
fn sides(normal: DVec3) -> impl Iterator<Item = (Azimuth, Seen, f64)> {
    azimuths().map(move |azimuth| {
        let seen = Seen::new(normal.dot(azimuth.along), normal.y);
        let whole = seen.within([0.0, FRAC_PI_2]);
        (azimuth, seen, whole)
    })
}

fn elevations(slopes: &Range<f64>) -> [f64; 2] {
    [slopes.start, slopes.end].map(f64::atan)
}

/// What surfaces hide along an azimuth.
pub(crate) struct Hidden {
    azimuth: Azimuth,
    seen: Seen,
    /// Elevations that the face sees.
    in_front: [f64; 2],
    covered: CoveredSlopes,
    /// Light of an even sky there, and the part of an even sphere's that a unit of it is.
    light: f64,
    of_sphere: f64,
}

impl Hidden {
    /// Directions in which it is looked at.
    pub(crate) fn looks(&self) -> impl Iterator<Item = Look> {
        looks((self.azimuth, self.light), |light| self.elevation(light)).map(|look| Look {
            share: look.share * self.of_sphere,
            ..look
        })
    }

    /// Up to where so much light is hidden.
    fn elevation(&self, mut light: f64) -> f64 {
        let [mut low, mut high] = self.in_front;
        for gap in self.covered.gaps() {
            let [start, end] = elevations(&gap);
            let piece = self.seen.within([low, start]);
            if light < piece {
                high = start;
                break;
            }
            light -= piece;
            low = end;
        }
        self.seen.elevation([low, high], light)
    }
}

/// Looks along an azimuth from where light comes, each for as much, where its parts come from up to elevations.
fn looks(
    (azimuth, light): (Azimuth, f64),
    elevation: impl Fn(f64) -> f64,
) -> impl Iterator<Item = Look> {
    let n_looks = n_looks(light);
    (0..n_looks).map(move |part| {
        let up_to = light * (f64::from(part) + azimuth.place()) / f64::from(n_looks);
        let (sin, cos) = elevation(up_to).sin_cos();
        Look {
            azimuth: azimuth.index,
            number: MOST_LOOKS * azimuth.index as u32 + part,
            towards: cos * azimuth.along + sin * DVec3::Y,
            share: light / f64::from(n_looks),
        }
    })
}

/// How often an azimuth is looked along for so much light, of which a level face has 1/2 from all of it.
fn n_looks(share: f64) -> u32 {
    ((f64::from(2 * MOST_LOOKS) * share).ceil() as u32).min(MOST_LOOKS)
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
    /// Elevations that lie in front of it; none of a face that turns away.
    in_front: [f64; 2],
}

impl Seen {
    /// A face whose normal has these components along the azimuth and upwards.
    fn new(a: f64, b: f64) -> Self {
        // n.s = 0 at this elevation, if it is one; above it light comes from in front of the face, or behind.
        let own = (a / b).abs().atan();
        let in_front = match (a > 0.0, b > 0.0) {
            (true, true) => [0.0, FRAC_PI_2],
            (false, true) => [own, FRAC_PI_2],
            (true, false) => [0.0, own],
            (false, false) => [0.0, 0.0],
        };
        Self { a, b, in_front }
    }

    /// Light of an even sky between two elevations.
    fn within(&self, [low, high]: [f64; 2]) -> f64 {
        let [from, to] = self.in_front;
        let [low, high] = [low.max(from), high.min(to)];
        if low < high {
            self.up_to(high) - self.up_to(low)
        } else {
            0.0
        }
    }

    fn up_to(&self, elevation: f64) -> f64 {
        let (sin, cos) = elevation.sin_cos();
        0.5 * (self.a * (elevation + sin * cos) + self.b * sin * sin)
    }

    /// Up to which elevation of two so much light comes, from the first on.
    fn elevation(&self, [low, high]: [f64; 2], share: f64) -> f64 {
        let [from, to] = self.in_front;
        let (mut from, mut to) = (low.max(from), high.min(to));
        let light = self.up_to(from) + share;
        for _ in 0..N_HALVINGS {
            let middle = 0.5 * (from + to);
            if self.up_to(middle) < light {
                from = middle;
            } else {
                to = middle;
            }
        }
        0.5 * (from + to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_way_leaves_all_of_the_sky() {
        for normal in [DVec3::Y, DVec3::X, DVec3::new(0.6, 0.8, 0.0), -DVec3::Y] {
            assert_eq!(
                free_share((normal, normal), |_, _| {}, |_| {}),
                1.0,
                "{normal}"
            );
        }
    }

    #[test]
    fn a_level_face_in_a_bowl_sees_the_square_of_the_cosine_of_its_rim() {
        for rim_deg in [10.0_f64, 30.0, 60.0] {
            let rim = rim_deg.to_radians();
            let up_to_rim = [0.0, rim.tan()];
            let found = free_share((DVec3::Y, DVec3::Y), |_, it| it.add(up_to_rim), |_| {});
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
        assert!((free_share((DVec3::Y, DVec3::Y), wall, |_| {}) - 0.5).abs() < 0.01);
        assert_eq!(free_share((DVec3::NEG_X, DVec3::NEG_X), wall, |_| {}), 1.0);
        // A face across such a wall has half of its sky; what is upright may have a y of either zero.
        for normal in [DVec3::Z, DVec3::new(0.0, -0.0, 1.0)] {
            let free = free_share((normal, normal), wall, |_| {});
            assert!((free - 0.5).abs() < 0.01, "{normal}: {free}");
        }
    }

    #[test]
    fn looks_share_what_is_hidden_among_them() {
        // A bowl whose rim stands 30 degrees high around a tilted face, on ground that is all surface.
        let (sin, cos) = 0.6_f64.sin_cos();
        let normal = DVec3::new(sin, cos, 0.0);
        let (mut above, mut below) = (0.0, 0.0);
        let rim = |_, covered: &mut CoveredSlopes| covered.add([0.0, 30_f64.to_radians().tan()]);
        let free = free_share((normal, normal), rim, |hidden| {
            for look in hidden.looks() {
                assert!((0.0..=0.5).contains(&look.towards.y), "{look:?}");
                above += look.share;
            }
        });
        let met = share_met_below(normal, |look| {
            assert!(look.towards.y < 0.0 && look.share > 0.0, "{look:?}");
            below += look.share;
            true
        });
        assert!(
            (above - (1.0 - free) * 0.5 * (1.0 + cos)).abs() < 1e-12,
            "{above} {free}"
        );
        assert!(
            (below - 0.5 * (1.0 - cos)).abs() < 1e-12 && met == 1.0,
            "{below} {met}"
        );
    }

    #[test]
    fn under_a_bridge_the_sky_is_what_lies_below_it() {
        for (low_deg, high_deg) in [(0.0_f64, 40.0_f64), (20.0, 50.0), (30.0, 90.0)] {
            let [low, high] = [low_deg, high_deg].map(f64::to_radians);
            let bridge = [low.tan(), high.tan()];
            let found = free_share((DVec3::Y, DVec3::Y), |_, it| it.add(bridge), |_| {});
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
            let all = sides(normal).map(|(_, _, whole)| whole);
            let found = all.sum::<f64>() * TAU / N_AZIMUTHS as f64 / std::f64::consts::PI;
            // Twelve azimuths: worst found 0.006.
            assert!(
                (found - 0.5 * (1.0 + cos)).abs() < 0.01,
                "{tilt_deg}: {found}"
            );
        }
    }
}
