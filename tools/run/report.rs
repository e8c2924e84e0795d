//! `report.json`: what a run did and how long it took. Times stand here and in no other file.

use std::fs;
use std::path::Path;

use serde_json::Value;
use serde_json::json;

use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::run::frames::FrameDone;
use crate::stages::Done;
use crate::stages::accuracy::Cheaper;
use crate::stages::accuracy::Reached;
use crate::version;
use niji_picture::PlannedScene;

/// Name of the file in the folder of a run.
const FILE: &str = "report.json";

/// The report of a run.
pub(super) fn json(
    planned: &PlannedScene,
    done: &[Done],
    (reached, cheaper): (Option<&Reached>, &[Cheaper]),
) -> Value {
    json!({
        "version": version(),
        "command": arguments(),
        "scene": planned.scene,
        "plan": planned.plan,
        "accuracy": reached,
        "cheaper": cheaper,
        "stages": done,
        "seconds": done.iter().map(|done| done.seconds).sum::<f64>(),
    })
}

/// The report of frames.
pub(super) fn of_frames(frames: &[FrameDone]) -> Value {
    let stages = frames.iter().flat_map(|frame| &frame.stages);
    json!({
        "version": version(),
        "command": arguments(),
        "frames": frames,
        "seconds": stages.map(|done| done.seconds).sum::<f64>(),
    })
}

/// The command line, as far as it is text.
fn arguments() -> Vec<String> {
    let arguments = std::env::args_os();
    arguments
        .map(|it| it.to_string_lossy().into_owned())
        .collect()
}

/// Refuses a file that has the name of a report and is none, before anything is run.
///
/// # Errors
/// [`Failure::Usage`] if it may not be replaced.
pub(super) fn check_own(folder: &Path, existing: Existing) -> Result<(), Failure> {
    let path = folder.join(FILE);
    output::check_regular(&path)?;
    let text = fs::read_to_string(&path).unwrap_or_default();
    let found: Value = serde_json::from_str(&text).unwrap_or_default();
    let is_own = ["version", "command", "seconds"]
        .iter()
        .all(|key| found.get(key).is_some());
    if is_own {
        Ok(())
    } else {
        output::check_free(&path, existing)
    }
}

/// Writes a report beside the results.
pub(super) fn write(report: &Value, folder: &Path) -> Result<(), Failure> {
    let text = format!("{report:#}\n");
    output::write_text(&folder.join(FILE), &text)
}
