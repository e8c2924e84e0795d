//! What `niji sun` says.

use niji_photo::DirectionExample;
use niji_photo::Finding;
use niji_photo::Severity;
use niji_photo::SunSolution;
use niji_photo::Verdict;
use niji_picture::PickedSuns;
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::sun::camera_flags::Camera;

/// Everything of one call.
#[derive(Serialize)]
pub(crate) struct Report<'a> {
    camera: &'a Camera,
    solutions: Vec<Solution>,
    findings: Vec<FindingText>,
}

#[derive(Serialize)]
struct Solution {
    elevation_deg: f64,
    azimuth_deg: f64,
    bow_angle_deg: f64,
    /// Standard errors; none where the picks leave it open.
    errors: Option<Errors>,
    residual_deg: f64,
    verdict: &'static str,
    explanation: &'static str,
}

#[derive(Serialize)]
struct Errors {
    /// Along the horizon, as an angle on the sky.
    across_deg: f64,
    elevation_deg: f64,
    correlation: f64,
    bow_angle_deg: f64,
}

/// A finding as scripts read it.
#[derive(Serialize)]
pub(crate) struct FindingText {
    /// Its name.
    pub(crate) code: &'static str,
    /// `error`, `warning` or `info`.
    pub(crate) severity: &'static str,
    /// What was found and why it matters.
    pub(crate) reason: String,
    /// What to do about it.
    pub(crate) suggestion: String,
}

impl From<&Finding> for FindingText {
    fn from(finding: &Finding) -> Self {
        Self {
            code: finding.code,
            severity: match finding.severity {
                Severity::Info => "info",
                Severity::Warning => "warning",
                Severity::Error => "error",
            },
            reason: finding.reason.clone(),
            suggestion: finding.suggestion.clone(),
        }
    }
}

impl FindingText {
    /// One finding on two lines.
    pub(crate) fn text(&self) -> String {
        let Self {
            code,
            severity,
            reason,
            suggestion,
        } = self;
        format!("{severity}: {reason} [{code}]\n  {suggestion}\n")
    }
}

impl<'a> Report<'a> {
    /// Gathers what there is to say.
    pub(crate) fn new(camera: &'a Camera, suns: &PickedSuns) -> Self {
        Self {
            camera,
            solutions: suns.solutions.iter().map(Solution::from).collect(),
            findings: suns.findings.iter().map(FindingText::from).collect(),
        }
    }
}

impl From<&SunSolution> for Solution {
    fn from(solution: &SunSolution) -> Self {
        let fit = &solution.fit;
        let (verdict, explanation) = match solution.verdict {
            Verdict::Possible => ("possible", "nothing speaks against it"),
            Verdict::BelowHorizon => (
                "below-horizon",
                "its sun is below the horizon: the bow bends the other way than one from the ground",
            ),
            Verdict::Misfit => ("misfit", "the picks miss this bow by more than their noise"),
            Verdict::Undetermined => (
                "undetermined",
                "the picks are too close together to determine it",
            ),
            Verdict::NoBow => (
                "no-bow",
                "the picks lie on a straight line, which no bow is",
            ),
        };
        Self {
            elevation_deg: solution.elevation.to_degrees(),
            azimuth_deg: solution.azimuth.to_degrees(),
            bow_angle_deg: fit.bow_angle.to_degrees(),
            errors: fit.errors.map(|errors| Errors {
                across_deg: errors.across.to_degrees(),
                elevation_deg: errors.up.to_degrees(),
                // The sun is opposite to the antisolar point: what is up there is down here.
                correlation: -errors.correlation,
                bow_angle_deg: errors.bow_angle.to_degrees(),
            }),
            residual_deg: fit.residual.to_degrees(),
            verdict,
            explanation,
        }
    }
}

/// A report as scripts read it.
///
/// # Errors
/// [`Failure::Failed`] for a number that JSON cannot hold.
pub(crate) fn json_text(report: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(report);
    let text = text.map_err(|error| Failure::Failed(format!("no JSON: {error}")))?;
    Ok(text + "\n")
}

/// A report as people read it.
pub(crate) fn text(report: &Report) -> String {
    let camera = report.camera;
    let mut text = format!(
        "camera: {} x {} pixels, {:.2} degrees across ({}), azimuth {:.2}, elevation {:.2}, roll {:.2}\n",
        camera.width_px,
        camera.height_px,
        camera.horizontal_fov_deg,
        camera.fov_source,
        camera.azimuth_deg,
        camera.elevation_deg,
        camera.roll_deg
    );
    if camera.cropped {
        text += "warning: the picture was cropped, so EXIF tells a wrong field of view: give --fov-deg\n";
    }
    for solution in &report.solutions {
        text += &solution.text();
    }
    for finding in &report.findings {
        text += &finding.text();
    }
    text
}

impl Solution {
    fn text(&self) -> String {
        let errors = match &self.errors {
            Some(errors) => format!(
                "{:.3} across, {:.3} in elevation (correlation {:.2}), {:.3} of the bow angle; residual \
                 {:.4}",
                errors.across_deg,
                errors.elevation_deg,
                errors.correlation,
                errors.bow_angle_deg,
                self.residual_deg
            ),
            None => "unknown, the picks do not determine it".to_owned(),
        };
        format!(
            "sun: elevation {:.3}, azimuth {:.3} degrees, bow angle {:.3} ({}: {})\n  standard errors: \
             {errors}\n",
            self.elevation_deg,
            self.azimuth_deg,
            self.bow_angle_deg,
            self.verdict,
            self.explanation
        )
    }
}

/// The examples of the published search.
///
/// # Errors
/// As [`json_text`].
pub(crate) fn examples_text(
    examples: &[DirectionExample],
    as_json: bool,
) -> Result<String, Failure> {
    let degrees = |example: &DirectionExample| {
        let sun = example.sun;
        let elevation_deg = sun.y.clamp(-1.0, 1.0).asin().to_degrees();
        let azimuth_deg = sun.x.atan2(-sun.z).to_degrees().rem_euclid(360.0);
        (elevation_deg, azimuth_deg, example.spread.to_degrees())
    };
    if as_json {
        let list = examples.iter().map(|example| {
            let (elevation_deg, azimuth_deg, spread_deg) = degrees(example);
            json!({
                "elevation_deg": elevation_deg,
                "azimuth_deg": azimuth_deg,
                "spread_deg": spread_deg,
                "n_directions": example.n_directions,
            })
        });
        return json_text(&json!({ "examples": list.collect::<Vec<_>>() }));
    }
    let lines = examples.iter().map(|example| {
        let (elevation_deg, azimuth_deg, spread_deg) = degrees(example);
        format!(
            "sun: elevation {elevation_deg:.2}, azimuth {azimuth_deg:.2} degrees, within {spread_deg:.2} \
             ({} directions)\n",
            example.n_directions
        )
    });
    Ok(lines.collect())
}
