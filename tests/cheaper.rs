//! What a run says would have taken less time is what happens.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
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

/// Luminance of the picture of a run in a folder.
fn luminance_of(folder: &Path) -> Array2<f64> {
    let image = SpectralImage::read_spectral(&folder.join("out/image.exr")).unwrap();
    luminance(&image.radiance, &image.wavelengths)
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
            run(name, &inside.join("without"), &[(key, value)]);
            let white = report["plan"]["display_white_cd_m2"].as_f64().unwrap();
            let change = luminance_of(&inside.join("without")) - luminance_of(&inside);
            let change = (change.mapv(|it| it * it).mean().unwrap()).sqrt() / white;
            let with = report["accuracy"]["error"].as_f64().unwrap();
            let (said, found) = (line["error"].as_f64().unwrap(), with.hypot(change));
            assert!(
                (said / found - 1.0).abs() < 0.1,
                "{name}: {said} said, {found}"
            );
            assert!(said > with, "{name}: less time for nothing");
            n_said += 1;
        }
    }
    assert!(n_said > 0, "no picture took more rays");
}
