//! A run after an edit goes on in the folder of the run before: what it made and nobody changed is made anew where it
//! no longer fits, and how a picture is shown costs no ray.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use serde_json::Value;
use support::niji_ends_with;
use support::text;
use support::variant;

/// A small shipped scene with changes, always under one name.
fn scene(folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let small = [
        ("camera.width_px", "48"),
        ("camera.height_px", "32"),
        (
            "spectrum",
            "{ first_nm = 450.0, step_nm = 100.0, n_wavelengths = 3 }",
        ),
    ];
    variant(
        "rain-shaft-5-mm-h.toml",
        folder,
        &[&small, changes].concat(),
    )
}

fn files(folder: &Path) -> [Vec<u8>; 3] {
    ["image.exr", "image.layers.exr", "image.png"].map(|name| fs::read(folder.join(name)).unwrap())
}

/// The stages that made something, by the report.
fn made(out: &Path) -> Vec<String> {
    let report = fs::read_to_string(out.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let stages = report["stages"].as_array().unwrap().iter();
    let made = stages.filter(|stage| stage["up_to_date"] == false);
    made.map(|stage| stage["stage"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn a_moved_sun_leaves_the_files_of_a_fresh_run_and_foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (out, fresh) = (folder.path().join("out"), folder.path().join("fresh"));
    let run = |scene: &Path, out: &Path, code| {
        let ended = niji_ends_with(code, &["run", text(scene), "-o", text(out), "-q"]);
        String::from_utf8(ended.stderr).unwrap()
    };
    run(&scene(folder.path(), &[]), &out, 0);
    let edited = scene(folder.path(), &[("sun.elevation_deg", "12.0")]);
    run(&edited, &out, 0);
    run(&edited, &fresh, 0);
    assert!(files(&out) == files(&fresh));
    assert!(
        !made(&out).contains(&"drops".to_owned()),
        "{:?}",
        made(&out)
    );

    // The plain image, as somebody painted it over; no ray is followed before it is refused.
    fs::write(out.join("image.layers.exr"), b"painted over").unwrap();
    let before = files(&out);
    let again = scene(folder.path(), &[("sun.elevation_deg", "14.0")]);
    let said = run(&again, &out, 2);
    assert!(said.contains("image.layers.exr"), "{said}");
    assert!(files(&out) == before);
}

#[test]
fn a_dark_picture_tells_how_a_camera_would_show_it() {
    let folder = tempfile::tempdir().unwrap();
    let said_at = |exposure_ev: &str| {
        let small = [
            ("camera.width_px", "32"),
            ("camera.height_px", "24"),
            ("sun.elevation_deg", "4.0"),
            ("picture.exposure_ev", exposure_ev),
        ];
        let scene = variant("clear-sky.toml", folder.path(), &small);
        let out = folder.path().join("out");
        let output = niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let hint = "dark: a camera would show it with about picture.exposure_ev = ";
    let dark = said_at("0.0");
    let usual_ev = dark.split_once(hint).unwrap().1.lines().next().unwrap();
    let found: f64 = usual_ev.parse().unwrap();
    assert!((1.0..=2.0).contains(&found), "{dark}");
    let bright = said_at(usual_ev);
    assert!(!bright.contains("a camera would"), "{bright}");
}

#[test]
fn another_exposure_shows_the_picture_that_is_there_until_its_error_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    let shown_at =
        |exposure_ev: &str| scene(folder.path(), &[("picture.exposure_ev", exposure_ev)]);
    let error = || {
        let report = fs::read_to_string(out.join("report.json")).unwrap();
        let report: Value = serde_json::from_str(&report).unwrap();
        report["accuracy"]["error"].as_f64().unwrap()
    };
    let run = |scene: &Path| {
        niji_ends_with(0, &["run", text(scene), "-o", text(&out), "-q"]);
    };
    run(&shown_at("0.0"));
    let (first, of_first) = (files(&out), error());
    let brighter = shown_at("1.0");
    run(&brighter);
    let shown = files(&out);
    assert!(shown[0] == first[0] && shown[2] != first[2]);
    assert_eq!(made(&out), ["render"]);
    assert!((error() / of_first - 2.0).abs() < 1e-6, "{}", error());

    // The choice makes the same files from nothing.
    let choice = out.join("choice.toml");
    let arguments = [
        "run",
        text(&brighter),
        "-o",
        text(&other),
        "-q",
        "--choice",
        text(&choice),
    ];
    niji_ends_with(0, &arguments);
    assert!(files(&other) == shown);

    // Until the errors of the picture that is there would be seen.
    let stops = (0.02 / of_first).log2().ceil();
    run(&shown_at(&format!("{stops:.1}")));
    assert!(files(&out)[0] != first[0]);
    assert!(error() < 0.01, "{}", error());
}
