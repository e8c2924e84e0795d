//! What a run says would have taken less time is what happens.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use serde_json::Value;
use support::niji_ends_with;
use support::text;
use support::variant;

/// A run of a shipped scene, small: its report.
fn run(name: &str, folder: &Path, changes: &[(&str, &str)]) -> Value {
    let small = [
        ("camera.width_px", "64"),
        ("camera.height_px", "48"),
        (
            "spectrum",
            "{ first_nm = 450.0, step_nm = 100.0, n_wavelengths = 3 }",
        ),
    ];
    fs::create_dir(folder).unwrap();
    let scene = variant(name, folder, &[&small, changes].concat());
    let out = folder.join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    serde_json::from_str(&fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

#[test]
fn a_picture_without_more_rays_errs_as_its_line_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut n_said = 0;
    for name in ["full-circle-bow.toml", "waterfall-gorge.toml"] {
        let inside = folder.path().join(name);
        let report = run(name, &inside, &[]);
        let key = "accuracy.pixel_footprint";
        for line in report["cheaper"].as_array().unwrap() {
            let change = line["change"].as_str().unwrap();
            let Some(value) = change.strip_prefix(&format!("{key} = ")) else {
                continue;
            };
            let without = run(name, &inside.join("without"), &[(key, value)]);
            let error = |report: &Value| report["accuracy"]["error"].as_f64().unwrap();
            let said = line["error"].as_f64().unwrap();
            assert!(
                (said / error(&without) - 1.0).abs() < 0.1,
                "{name}: {said} said, {}",
                error(&without)
            );
            assert!(said > error(&report), "{name}: less time for nothing");
            n_said += 1;
        }
    }
    assert!(n_said > 0, "no picture took more rays");
}
