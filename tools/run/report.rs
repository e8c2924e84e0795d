//! `report.json`: what a run did and how long it took. Times stand here and in no other file.
//!
//! Each frame of a sequence has its own, `report.0001.json`, so that processes in one folder overwrite nothing of each
//! other; `report.json` then holds those of all frames that are there. A run with `--choice` may be one of thousands
//! that share a sequence out: it writes none, for each of them would read what all others wrote.

use std::collections::BTreeMap;
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
use crate::stages::seconds_of;
use crate::version;
use niji_picture::PlannedScene;
use niji_scene::Scene;

/// Name of the file in the folder of a run.
const FILE: &str = "report.json";

/// The report of a run.
pub(super) fn json(
    planned: &PlannedScene,
    (plan_s, done): (f64, &[Done]),
    (reached, cheaper): (Option<&Reached>, &[Cheaper]),
) -> Value {
    json!({
        "version": version(),
        "command": arguments(),
        "scene": Scene { picture: planned.shown, ..planned.scene.clone() },
        "plan": planned.plan_as_shown(),
        "accuracy": reached,
        "cheaper": cheaper,
        "plan_seconds": plan_s,
        "stages": done,
        "seconds": seconds_of(done),
    })
}

/// The report of frames.
pub(super) fn of_frames(frames: &[&FrameDone]) -> Value {
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
pub(super) fn check_own(
    folder: &Path,
    frame: Option<u32>,
    existing: Existing,
) -> Result<(), Failure> {
    let path = folder.join(name(frame));
    output::check_regular(&path)?;
    let text = fs::read_to_string(&path).unwrap_or_default();
    let found: Value = serde_json::from_str(&text).unwrap_or_default();
    if is_own(&found) {
        Ok(())
    } else {
        output::check_free(&path, existing)
    }
}

fn is_own(report: &Value) -> bool {
    let keys = ["version", "command", "seconds"];
    keys.iter().all(|key| report.get(key).is_some())
}

/// The name of the report of a run, or of a frame.
fn name(frame: Option<u32>) -> String {
    frame.map_or(FILE.to_owned(), |frame| format!("report.{frame:04}.json"))
}

/// Writes a report beside the results.
pub(super) fn write(report: &Value, folder: &Path, frame: Option<u32>) -> Result<(), Failure> {
    let text = format!("{report:#}\n");
    output::write_text(&folder.join(name(frame)), &text)
}

/// Puts the reports of all frames that are in a folder together.
///
/// # Errors
/// A report that cannot be written.
pub(super) fn write_summary(folder: &Path) -> Result<(), Failure> {
    let frames = frames_in(folder);
    let seconds = frames.values().filter_map(|it| it["seconds"].as_f64());
    let summary = json!({
        "version": version(),
        "command": arguments(),
        "seconds": seconds.sum::<f64>(),
        "frames": frames.values().map(|it| &it["frames"][0]).collect::<Vec<_>>(),
    });
    write(&summary, folder, None)
}

/// The reports of the frames in a folder.
pub(crate) fn frames_in(folder: &Path) -> BTreeMap<u32, Value> {
    let mut frames = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let number = entry.file_name().into_string().ok().and_then(|file| {
            let number = file.strip_prefix("report.")?.strip_suffix(".json")?;
            number.parse::<u32>().ok()
        });
        let text = number.and_then(|_| fs::read_to_string(entry.path()).ok());
        let report: Value = serde_json::from_str(&text.unwrap_or_default()).unwrap_or_default();
        // What another process writes right now is told by its summary.
        if let (Some(number), true) = (number, is_own(&report)) {
            frames.insert(number, report);
        }
    }
    frames
}
