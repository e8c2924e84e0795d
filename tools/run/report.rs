//! `report.json`: what a run did and how long it took. Times stand here and in no other file.

use std::io::Write;
use std::path::Path;

use serde_json::Value;
use serde_json::json;

use crate::failure::Failure;
use crate::output;
use crate::scene_file::Planned;
use crate::stages::Done;

/// Name of the file in the folder of a run.
const FILE: &str = "report.json";

/// The report of a run.
pub(super) fn json(planned: &Planned, done: &[Done]) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": std::env::args().collect::<Vec<_>>(),
        "scene": planned.scene,
        "plan": planned.plan,
        "stages": done,
        "seconds": done.iter().map(|done| done.seconds).sum::<f64>(),
    })
}

/// Writes the report beside the results.
pub(super) fn write(planned: &Planned, done: &[Done], folder: &Path) -> Result<(), Failure> {
    let text = format!("{:#}\n", json(planned, done));
    output::write_file(&folder.join(FILE), |writer| {
        writer.write_all(text.as_bytes())
    })
}
