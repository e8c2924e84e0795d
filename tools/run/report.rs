//! `report.json`: what a run did and how long it took. Times stand here and in no other file.

use std::path::Path;

use serde_json::Value;
use serde_json::json;

use crate::failure::Failure;
use crate::output;
use crate::run::frames::FrameDone;
use crate::stages::Done;
use crate::stages::accuracy::Reached;
use niji_picture::PlannedScene;

/// Name of the file in the folder of a run.
const FILE: &str = "report.json";

/// The report of a run.
pub(super) fn json(planned: &PlannedScene, done: &[Done], reached: Option<&Reached>) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": arguments(),
        "scene": planned.scene,
        "plan": planned.plan,
        "accuracy": reached,
        "stages": done,
        "seconds": done.iter().map(|done| done.seconds).sum::<f64>(),
    })
}

/// The report of frames.
pub(super) fn of_frames(frames: &[FrameDone]) -> Value {
    let stages = frames.iter().flat_map(|frame| &frame.stages);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
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

/// Writes a report beside the results.
pub(super) fn write(report: &Value, folder: &Path) -> Result<(), Failure> {
    let text = format!("{report:#}\n");
    output::write_text(&folder.join(FILE), &text)
}
