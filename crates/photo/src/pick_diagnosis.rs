//! What the picks themselves say about how they were made.
//!
//! A fit without prior yields its own bow angle. Where it is known well enough to differ from the
//! expected one, the difference has a cause: another order (the secondary bow, 49 to 54 degrees), an
//! ice halo (21 to 23.5 and 45 to 47 degrees, around the sun itself), a straight line (90 degrees), picks on
//! edges of different colors, or a wrong field of view. Mixed edges are looked for by fitting every
//! assignment of two edges to the picks.

use niji_radiometry::Radians;

use crate::bow_fit::BowAnglePrior;
use crate::bow_fit::BowFit;
use crate::bow_fit::FitRequest;
use crate::bow_fit::fit_bow;
use crate::circle_through_picks::PickCircle;
use crate::circle_through_picks::circle_through_picks;
use crate::finding::Finding;
use crate::finding::Severity;
use crate::sun_from_picks::SunSolution;
use crate::sun_from_picks::Verdict;
use crate::sun_from_picks::widest_three;

/// Standard errors that make a difference.
const N_SIGMA: f64 = 3.0;
/// Above this error of the direction the sun is hardly known, degrees.
const POOR_DEG: f64 = 2.0;
/// Above this error it is not known at all, degrees.
const HOPELESS_DEG: f64 = 20.0;
/// An assignment of edges explains the picks below this sum of squares.
const EXPLAINED: f64 = 9.0;
/// Most picks for which all assignments are tried.
const MOST_ASSIGNED: usize = 10;

/// What the user says was picked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedEdge {
    /// Order of the bow: 2 primary, 3 secondary.
    pub order: u32,
    /// Bow angle of the picked edge.
    pub expected: BowAnglePrior,
    /// By how much the bow's other color edge lies outside, negative for inside.
    pub other_edge: Radians,
}

/// Everything that the picks give reason to say, the worst first.
#[must_use]
pub fn diagnose_picks(
    request: &FitRequest,
    edge: PickedEdge,
    solutions: &[SunSolution],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    findings.extend(closeness(solutions));
    findings.extend(bow_angle(request, edge));
    findings.extend(horizon(solutions));
    findings.extend(ambiguity(solutions));
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

fn closeness(solutions: &[SunSolution]) -> Option<Finding> {
    let errors = solutions.first().and_then(|solution| solution.fit.errors);
    let error_deg = errors.map_or(f64::INFINITY, |errors| errors.direction().to_degrees());
    if error_deg < POOR_DEG {
        return None;
    }
    let (severity, known) = if error_deg < HOPELESS_DEG {
        (
            Severity::Warning,
            format!("known to within {error_deg:.1} degrees only"),
        )
    } else {
        (Severity::Error, "not known at all".to_owned())
    };
    Some(Finding::new(
        "picks-too-close",
        severity,
        format!("the picks are too close together: with these the sun is {known}"),
        "spread the picks over at least 40 degrees of the bow, at different places",
    ))
}

fn free_circle(request: &FitRequest) -> Option<PickCircle> {
    let picks = request.picks_px.iter();
    let directions: Vec<_> = picks
        .map(|[x_px, y_px]| request.camera.ray(*x_px, *y_px).direction)
        .collect();
    circle_through_picks(widest_three(&directions))
}

/// The fit without a prior from the circle through three picks.
fn free_fit(request: &FitRequest, offsets_rad: &[f64]) -> Option<BowFit> {
    let circle = free_circle(request)?;
    let free = FitRequest {
        offsets_rad,
        prior: None,
        ..*request
    };
    Some(fit_bow(&free, circle.antisolar))
}

fn bow_angle(request: &FitRequest, edge: PickedEdge) -> Option<Finding> {
    let fit = free_fit(request, request.offsets_rad)?;
    let error_deg = fit.errors?.bow_angle.to_degrees();
    let found_deg = fit.bow_angle.to_degrees();
    let expected_deg = edge.expected.angle.to_degrees();
    let tolerance_deg = N_SIGMA * error_deg.hypot(edge.expected.standard_error.to_degrees());
    let misfit_allowed = 16.0 + 2.0 * request.picks_px.len() as f64;
    let is_expected = (found_deg - expected_deg).abs() <= tolerance_deg;
    if is_expected && fit.misfit <= misfit_allowed {
        return None;
    }
    let reason = |what: &str| {
        format!(
            "the picks lie on a circle of {found_deg:.1} ± {error_deg:.1} degrees, expected \
             {expected_deg:.1}: {what}"
        )
    };
    let within = |low: f64, high: f64| found_deg >= low && found_deg <= high;
    let is_good = fit.misfit <= misfit_allowed;
    let (code, what, suggestion) = if is_good && (found_deg - 90.0).abs() <= tolerance_deg.max(1.0)
    {
        (
            "straight-line",
            "they lie on a straight line, a great circle of the sky",
            "pick points of a curve; a bow is straight in no picture",
        )
    } else if is_good && edge.order == 2 && within(49.0, 54.0) {
        (
            "secondary-bow",
            "that is the secondary bow",
            "say --bow secondary if the outer, fainter bow was picked",
        )
    } else if is_good && edge.order == 3 && within(39.0, 43.5) {
        (
            "primary-bow",
            "that is the primary bow",
            "say --bow primary if the inner, brighter bow was picked",
        )
    } else if is_good && (within(21.0, 23.5) || within(45.0, 47.0)) {
        (
            "ice-halo",
            "that is an ice halo, whose middle is the sun itself",
            "a halo says where the sun is without any fit: in the middle of the circle",
        )
    } else if explained_by_mixed_edges(request, edge) {
        (
            "mixed-colors",
            "picks on both color edges of the bow explain that",
            "pick all points on the same color edge",
        )
    } else {
        (
            "wrong-angle",
            "no bow has this angle",
            "check the field of view (--fov-deg), cropping and lens distortion, and the picks",
        )
    };
    Some(Finding::new(
        code,
        Severity::Error,
        reason(what),
        suggestion,
    ))
}

/// Does an assignment of both edges to the picks lead to the expected bow angle?
fn explained_by_mixed_edges(request: &FitRequest, edge: PickedEdge) -> bool {
    let n_picks = request.picks_px.len();
    if n_picks > MOST_ASSIGNED {
        return false;
    }
    // The first and the last of these are picks of one color.
    (1..(1_usize << n_picks) - 1).any(|assignment| {
        let is_other = |index: usize| assignment >> index & 1 == 1;
        let offsets: Vec<f64> = (0..n_picks)
            .map(|index| {
                if is_other(index) {
                    edge.other_edge.0
                } else {
                    0.0
                }
            })
            .collect();
        free_fit(request, &offsets).is_some_and(|fit| {
            let away = fit.bow_angle.0 - edge.expected.angle.0;
            fit.misfit + (away / edge.expected.standard_error.0).powi(2) < EXPLAINED
        })
    })
}

fn horizon(solutions: &[SunSolution]) -> Option<Finding> {
    let best = solutions.first()?;
    let by_misfit = |a: &&SunSolution, b: &&SunSolution| a.fit.misfit.total_cmp(&b.fit.misfit);
    let closest = solutions.iter().min_by(by_misfit)?;
    if best.verdict != Verdict::Possible && closest.verdict == Verdict::BelowHorizon {
        return Some(Finding::new(
            "sun-below-horizon",
            Severity::Error,
            "the sun would stand below the horizon: no bow is possible there",
            "check that the bow bends the right way, and the tilt of the camera (--elevation-deg, \
             --horizon)",
        ));
    }
    (best.elevation.0 > best.fit.bow_angle.0).then(|| {
        Finding::new(
            "bow-below-horizon",
            Severity::Warning,
            format!(
                "the sun stands {:.1} degrees high, so the whole bow of {:.1} degrees lies below the \
                 horizon",
                best.elevation.to_degrees(),
                best.fit.bow_angle.to_degrees()
            ),
            "only spray below the eye or a view from above shows such a bow",
        )
    })
}

fn ambiguity(solutions: &[SunSolution]) -> Option<Finding> {
    let possible = solutions.iter();
    let n_possible = possible.filter(|s| s.verdict == Verdict::Possible).count();
    (n_possible > 1).then(|| {
        Finding::new(
            "mirror-solutions",
            Severity::Warning,
            format!("{n_possible} places for the sun fit these picks"),
            "choose one of them, or spread the picks over a longer arc",
        )
    })
}
