//! The sun from three or more pixels, or two of a known bow angle, where a bow is or should be.
//!
//! The sun lies opposite to the antisolar point s. Every fit ([`fit_bow`]) from three kinds of start
//! is listed: the circle through the first, middle and last pick, and the two circles of the expected
//! bow angle that touch the picks from either side,
//!   s = cos(theta_0) m ± sin(theta_0) b,   m the mean pick, b = m x (last − first), normalised.
//! The second of them is the mirror solution: a bow that bends the other way. For short arcs it fits
//! almost as well, and only its sun below the horizon tells it apart.

use std::f64::consts::PI;

use glam::DVec3;
use niji_radiometry::Radians;

use crate::bow_fit::BowFit;
use crate::bow_fit::FitRequest;
use crate::bow_fit::fit_bow;
use crate::circle_through_picks::angle_between;
use crate::circle_through_picks::circle_through_picks;
use crate::error::Error;

/// Fits closer than this are one, radians.
const SAME_RAD: f64 = 1e-4;
/// A bow angle from which circles start where none is known: the primary's, 42 degrees.
const START_RAD: f64 = 0.733;
/// Fewest picks; one less where the bow angle is known.
const FEWEST_PICKS: usize = 3;

/// A place for the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSolution {
    /// The fit of its antisolar point.
    pub fit: BowFit,
    /// Elevation of the sun above the horizon.
    pub elevation: Radians,
    /// Azimuth of the sun, clockwise from north, 0 to 2π.
    pub azimuth: Radians,
    /// Can it be?
    pub verdict: Verdict,
}

/// Can the sun stand there?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing speaks against it.
    Possible,
    /// The sun would be below the horizon; this is the mirror solution of a bow seen from above, or
    /// the bow was picked upside down.
    BelowHorizon,
    /// The picks miss this bow by more than their noise explains.
    Misfit,
    /// The circle is so wide that it is no bow.
    NoBow,
    /// The picks do not determine it: they are too close together.
    Undetermined,
}

/// All places for the sun that fit the picks, the best first: possible ones before others, then by
/// misfit.
///
/// # Errors
/// Too few picks, a noise that is not positive, or offsets of another number.
pub fn sun_from_picks(request: &FitRequest) -> Result<Vec<SunSolution>, Error> {
    check(request)?;
    let mut solutions: Vec<SunSolution> = Vec::new();
    for start in starts(request) {
        let found = solution(request, fit_bow(request, start));
        let is_known = solutions
            .iter()
            .any(|known| angle_between(known.fit.antisolar, found.fit.antisolar) < SAME_RAD);
        if !is_known && found.fit.antisolar.is_finite() {
            solutions.push(found);
        }
    }
    let rank = |solution: &SunSolution| u8::from(solution.verdict != Verdict::Possible);
    solutions.sort_by(|a, b| {
        let by_rank = rank(a).cmp(&rank(b));
        by_rank.then(a.fit.misfit.total_cmp(&b.fit.misfit))
    });
    Ok(solutions)
}

fn check(request: &FitRequest) -> Result<(), Error> {
    let found = request.picks_px.len();
    let expected = FEWEST_PICKS - usize::from(request.prior.is_some());
    if found < expected || request.offsets_rad.len() != found {
        return Err(Error::TooFewPicks {
            found: found.min(request.offsets_rad.len()),
            expected,
        });
    }
    let finite = request.picks_px.iter().flatten();
    for (what, found) in finite
        .map(|value| ("a picked pixel", *value))
        .chain([("the noise of picks in pixels", request.noise_px)])
    {
        let expected = "a finite number, the noise above 0";
        if !found.is_finite() || (what.starts_with("the noise") && found <= 0.0) {
            return Err(Error::Range {
                what,
                found,
                expected,
            });
        }
    }
    Ok(())
}

fn directions(request: &FitRequest) -> Vec<DVec3> {
    let picks = request.picks_px.iter();
    picks
        .map(|[x_px, y_px]| request.camera.ray(*x_px, *y_px).direction)
        .collect()
}

/// The two picks that are farthest apart, and the one that is farthest from both.
pub(crate) fn widest_three(picks: &[DVec3]) -> [DVec3; 3] {
    let (mut first, mut last, mut widest) = (picks[0], picks[0], -1.0);
    for (index, a) in picks.iter().enumerate() {
        for b in &picks[index + 1..] {
            if a.distance(*b) > widest {
                (first, last, widest) = (*a, *b, a.distance(*b));
            }
        }
    }
    let reach = |pick: &DVec3| pick.distance(first).min(pick.distance(last));
    let middle = picks.iter().copied().fold(first, |best, pick| {
        if reach(&pick) > reach(&best) {
            pick
        } else {
            best
        }
    });
    [first, middle, last]
}

fn starts(request: &FitRequest) -> Vec<DVec3> {
    let picks = directions(request);
    let three = widest_three(&picks);
    let mut starts: Vec<DVec3> = circle_through_picks(three)
        .map(|circle| circle.antisolar)
        .into_iter()
        .collect();
    let mean = picks.iter().copied().sum::<DVec3>().normalize();
    let chord = three[2] - three[0];
    // Coincident picks have no chord: any way across will do.
    let across = mean.cross(chord).try_normalize();
    let across = across.unwrap_or_else(|| mean.any_orthonormal_vector());
    let theta = request.prior.map_or(START_RAD, |prior| prior.angle.0);
    for side in [1.0, -1.0] {
        starts.push(theta.cos() * mean + side * theta.sin() * across);
    }
    starts
}

fn solution(request: &FitRequest, fit: BowFit) -> SunSolution {
    let sun = -fit.antisolar;
    let elevation = Radians(sun.y.clamp(-1.0, 1.0).asin());
    SunSolution {
        fit,
        elevation,
        azimuth: Radians(sun.x.atan2(-sun.z).rem_euclid(2.0 * PI)),
        verdict: verdict(request, &fit, elevation),
    }
}

fn verdict(request: &FitRequest, fit: &BowFit, elevation: Radians) -> Verdict {
    let Some(errors) = fit.errors else {
        return Verdict::Undetermined;
    };
    // Half of the sun's disc and refraction let it shine from a degree below.
    if elevation.0 + 3.0 * errors.up.0 < -0.015 {
        return Verdict::BelowHorizon;
    }
    if fit.bow_angle.0 >= 0.5 * PI - 0.02 {
        return Verdict::NoBow;
    }
    // As many terms as picks and prior, less three unknowns; 16 is four standard errors of one.
    let n_terms = request.picks_px.len() + usize::from(request.prior.is_some());
    if fit.misfit > 16.0 + 2.0 * (n_terms - 3) as f64 {
        return Verdict::Misfit;
    }
    Verdict::Possible
}
