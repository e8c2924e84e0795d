//! The sun's disc in water: a mirrored disc where it is still, the glitter of waves where it is not.
//!
//! L = R E/(pi r²) (v . n)/(v_up n_up) G P,   P = int_disc p(z) d²z,   G = 1/(1 + L(v) + L(w))
//! `E` irradiance of the sun on a surface that faces it, `r` its angular radius, `v` and `w` towards eye and sun, `n` normal
//! of the facets that mirror its middle, `p` Gaussian density of slopes, `P` share of the slopes that mirror any of the
//! disc into the eye, `G` what of these facets is neither hidden nor in shadow (Smith, see `sun_streak`). Slopes z = n_level/n_up
//! of the disc are an ellipse: across its middle n turns by r/2 in the plane of incidence, by r/(2 v . n) across it. Of an
//! ellipse small beside the waves this is R E p/(4 v_up n_up⁴) [CM54, eq. 9]; in still water it is R E/(pi r²) in the disc, up to
//! half of the way from its middle over its height: 6 % at the rim of a sun of 2 degrees.
//! [CM54] Cox and Munk, J. Opt. Soc. Am. 44, 838-850 (1954).

use std::f64::consts::FRAC_1_SQRT_2;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use glam::DVec2;
use glam::DVec3;

use crate::sun_streak::smith_lambda;

/// Angular radius of the sun (rad): half of 0.533 degrees.
pub(crate) const SUN_RADIUS_RAD: f64 = 0.004_651;

/// Places across the disc; beyond so many standard deviations no facets are looked for.
const N_PLACES: usize = 48;
const REACH: f64 = 7.0;

/// The sun in water, towards an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Glint {
    /// L/(R E) [1/sr].
    pub(crate) light: f64,
    /// v . n.
    pub(crate) cos_incidence: f64,
}

/// What an eye sees of the sun in water of a slope; `None` where that is nothing.
pub(crate) fn glint(
    slope: f64,
    up: DVec3,
    [towards_eye, towards_sun]: [DVec3; 2],
) -> Option<Glint> {
    let (rise, sun_rise) = (towards_eye.dot(up), towards_sun.dot(up));
    if rise <= 0.0 || sun_rise <= 0.0 {
        return None;
    }
    let normal = (towards_eye + towards_sun).normalize();
    let cos_incidence = towards_eye.dot(normal);
    let tilted = normal.dot(up);
    // Slopes along two axes of the level.
    let axes = [
        up.any_orthonormal_vector(),
        up.any_orthonormal_vector().cross(up),
    ];
    let level = |vector: DVec3| DVec2::from(axes.map(|axis| vector.dot(axis)));
    let middle = level(normal) / tilted;
    let along = (towards_sun - towards_eye).normalize_or(axes[0]);
    let turn = |by: DVec3| (level(by) - middle * by.dot(up)) / tilted;
    let radii = [
        0.5 * SUN_RADIUS_RAD * turn(along),
        0.5 * SUN_RADIUS_RAD / cos_incidence * turn(normal.cross(along)),
    ];
    let share = share_in_ellipse(slope, middle, radii);
    if share <= 0.0 {
        return None;
    }
    let hidden = |sine: f64| smith_lambda(slope, sine);
    let seen = 1.0 / (1.0 + hidden(rise) + hidden(sun_rise));
    let disc_sr = PI * SUN_RADIUS_RAD * SUN_RADIUS_RAD;
    Some(Glint {
        light: cos_incidence / (rise * tilted) * seen * share / disc_sr,
        cos_incidence,
    })
}

/// Share of Gaussian slopes in an ellipse around a middle, by two radii of it that its turning makes of a circle's.
fn share_in_ellipse(slope: f64, middle: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    // Its principal axes: eigenvectors of a a^T + b b^T.
    let (xx, xy, yy) = (
        a.x * a.x + b.x * b.x,
        a.x * a.y + b.x * b.y,
        a.y * a.y + b.y * b.y,
    );
    let axis = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
    let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (long, short) = ((mean + half).sqrt(), (mean - half).max(0.0).sqrt());
    let (x, y) = (middle.dot(axis), middle.dot(axis.perp()));
    if slope <= 0.0 {
        let is_inside = (x / long).powi(2) + (y / short).powi(2) <= 1.0;
        return if is_inside { 1.0 } else { 0.0 };
    }
    let end = |at: f64| (at / long).clamp(-1.0, 1.0).asin();
    let (from, to) = (end(-x - REACH * slope), end(-x + REACH * slope));
    if from >= to || y.abs() > short + REACH * slope {
        return 0.0;
    }
    debug_assert!(to - from <= 2.0 * FRAC_PI_2 + 1e-12);
    let up_to = |at: f64| 0.5 * libm::erf(at * FRAC_1_SQRT_2 / slope);
    let step = (to - from) / N_PLACES as f64;
    let sum: f64 = (0..N_PLACES)
        .map(|place| {
            let (sine, cosine) = (from + (place as f64 + 0.5) * step).sin_cos();
            let across = up_to(y + short * cosine) - up_to(y - short * cosine);
            (-0.5 * ((x + long * sine) / slope).powi(2)).exp() * cosine * across
        })
        .sum();
    sum * step * long / (slope * (2.0 * PI).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn towards(elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (sine, cosine) = elevation_deg.to_radians().sin_cos();
        let (east, north) = azimuth_deg.to_radians().sin_cos();
        DVec3::new(cosine * east, sine, -cosine * north)
    }

    fn light(slope: f64, eye: DVec3, sun: DVec3) -> f64 {
        glint(slope, DVec3::Y, [eye, sun]).map_or(0.0, |it| it.light)
    }

    #[test]
    fn still_water_shows_the_disc_itself() {
        let disc = 1.0 / (PI * SUN_RADIUS_RAD * SUN_RADIUS_RAD);
        for elevation_deg in [2.0, 20.0, 70.0] {
            let sun = towards(elevation_deg, 0.0);
            for (off_deg, aside_deg, is_seen) in [
                (0.0, 0.0, true),
                (0.26, 0.0, true),
                (-0.26, 0.0, true),
                (0.275, 0.0, false),
                (0.0, 0.26, true),
                (0.0, 0.275, false),
                (0.2, 0.2, false),
            ] {
                let aside_deg = aside_deg / elevation_deg.to_radians().cos();
                let eye = towards(elevation_deg + off_deg, 180.0 + aside_deg);
                let found = light(0.0, eye, sun);
                let expected = if is_seen { disc } else { 0.0 };
                // The facets that mirror the middle of the disc stand for those of its rim.
                let off: f64 = (0.5 * off_deg / elevation_deg).abs();
                assert!(
                    (found - expected).abs() < (1.2 * off + 5e-3) * disc,
                    "{elevation_deg} {off_deg} {}",
                    found / disc
                );
            }
        }
    }

    #[test]
    fn over_waves_it_is_the_form_of_cox_and_munk() {
        for (slope, sun_deg) in [(0.1_f64, 30.0), (0.2, 60.0), (0.15, 45.0)] {
            for (eye_deg, azimuth_deg) in
                [(40.0, 180.0), (60.0, 150.0), (35.0, 195.0), (70.0, 20.0)]
            {
                let (eye, sun) = (towards(eye_deg, azimuth_deg), towards(sun_deg, 0.0));
                let normal = (eye + sun).normalize();
                let tan2 = normal.y.powi(-2) - 1.0;
                let density = (-0.5 * tan2 / slope.powi(2)).exp() / (2.0 * PI * slope * slope);
                // What hills hide is no part of theirs; here the eye and the sun stand above them.
                let expected = density / (4.0 * eye.y * normal.y.powi(4));
                let found = light(slope, eye, sun);
                // The disc blurs; beyond seven standard deviations nothing is looked for.
                assert!(
                    (found - expected).abs() < 2e-3 * expected + 1e-9,
                    "{slope} {eye_deg} {found} {expected}"
                );
            }
        }
    }

    /// Light that goes up from water that reflects all, over what falls on it.
    fn sent_up(slope: f64, sun_deg: f64) -> f64 {
        let sun = towards(sun_deg, 0.0);
        // Around the mirrored sun, as far as slopes lead.
        let reach = (14.0 * slope + 3.0 * SUN_RADIUS_RAD).min(1.5);
        let n = 900;
        let step = 2.0 * reach / f64::from(n);
        let mirrored = towards(sun_deg, 180.0);
        let across = mirrored.any_orthonormal_vector();
        let other = mirrored.cross(across);
        let mut sum = 0.0;
        for row in 0..n {
            for column in 0..n {
                let [a, b] = [row, column].map(|at| -reach + (f64::from(at) + 0.5) * step);
                // A gnomonic map: dOmega = da db/(1 + a² + b²)^(3/2), a = tan.
                let vector = mirrored + a * across + b * other;
                let eye = vector.normalize();
                let share = step * step / vector.length().powi(3);
                sum += light(slope, eye, sun) * eye.y.max(0.0) * share;
            }
        }
        sum / sun.y
    }

    #[test]
    fn all_that_falls_on_the_water_is_sent_up_again() {
        for (slope, sun_deg) in [
            (0.0, 20.0),
            (0.0, 60.0),
            (1e-3, 30.0),
            (0.01, 30.0),
            (0.05, 60.0),
        ] {
            let found = sent_up(slope, sun_deg);
            assert!((found - 1.0).abs() < 3e-3, "{slope} {sun_deg} {found}");
        }
        // A low sun: hills keep what they send down, and none is made.
        let low = sent_up(0.05, 5.0);
        assert!((0.8..1.005).contains(&low), "{low}");
    }

    #[test]
    fn waves_that_settle_leave_the_disc() {
        let sun = towards(25.0, 0.0);
        for off_deg in [0.0, 0.1, 0.2, 0.35, 0.5] {
            let eye = towards(25.0 + off_deg, 180.0);
            let (still, settled) = (light(0.0, eye, sun), light(1e-6, eye, sun));
            assert!(
                (still - settled).abs() < 1e-3 * light(0.0, towards(25.0, 180.0), sun),
                "{off_deg}"
            );
        }
    }

    #[test]
    fn there_is_none_of_a_sun_or_eye_below_the_water_and_all_of_it_is_finite() {
        assert!(glint(0.1, DVec3::Y, [towards(20.0, 0.0), towards(-1.0, 180.0)]).is_none());
        assert!(glint(0.1, DVec3::Y, [towards(-1.0, 0.0), towards(20.0, 180.0)]).is_none());
        for slope in [0.0, 1e-9, 0.35] {
            for deg in [1e-9, 0.1, 90.0] {
                let found = light(slope, towards(deg, 180.0), towards(deg, 0.0));
                assert!(found.is_finite() && found >= 0.0, "{slope} {deg}");
            }
        }
    }
}
