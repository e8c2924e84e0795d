//! `--tolerance`: levels follow from it, pictures are judged by their own estimate and keep it in truth.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

use ndarray::Axis;
use niji_exchange::SpectralImage;
use niji_radiometry::Colorimetry;
use serde_json::Value;
use support::niji_ends_with;
use support::text;
use support::variant;

/// Small enough for every level.
const SMALL: [(&str, &str); 5] = [
    ("camera.width_px", "40"),
    ("camera.height_px", "30"),
    ("spectrum.first_nm", "450.0"),
    ("spectrum.step_nm", "100.0"),
    ("spectrum.n_wavelengths", "2"),
];

/// A small copy of a shipped scene with some values of its own.
fn small(name: &str, folder: &Path, own: &[(&str, &str)]) -> PathBuf {
    let changes: Vec<(&str, &str)> = SMALL.iter().chain(own).copied().collect();
    variant(name, folder, &changes)
}

/// Drops of one size, in a vacuum.
fn drizzle(folder: &Path, own: &[(&str, &str)]) -> PathBuf {
    let coarse = [("drops.voxel_m", "25.0")];
    let own: Vec<(&str, &str)> = coarse.iter().chain(own).copied().collect();
    let path = small("paper-c-figure-3.toml", folder, &own);
    // The theory is to be chosen.
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("theory = \"uniform\"\n", "")).unwrap();
    path
}

/// The levels that a plan has.
fn levels(scene: &Path, more: &[&str]) -> Value {
    let arguments = [&["plan", text(scene), "--json"], more].concat();
    let plan: Value = serde_json::from_slice(&niji_ends_with(0, &arguments).stdout).unwrap();
    plan["levels"].clone()
}

fn report(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("report.json")).unwrap()).unwrap()
}

/// Luminance of every pixel of a run, over display white.
fn luminance(folder: &Path) -> Vec<f64> {
    let image = SpectralImage::read_spectral(&folder.join("image.exr")).unwrap();
    let reference = report(folder)["plan"]["display_white_cd_m2"].clone();
    let observer = Colorimetry::new(&image.wavelengths);
    let weights: Vec<f64> = observer.weights().iter().map(|[_, y, _]| *y).collect();
    let pixels = image.radiance.lanes(Axis(0)).into_iter();
    let of_pixel = |spectrum: ndarray::ArrayView1<f32>| -> f64 {
        let spectrum = spectrum.iter().zip(&weights);
        spectrum.map(|(value, y)| f64::from(*value) * y).sum()
    };
    pixels
        .map(|pixel| of_pixel(pixel) / reference.as_f64().unwrap())
        .collect()
}

#[test]
fn the_tolerance_is_kept_against_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    // One order: the reference would take its time over the others.
    let single = ("effects.multiple_scattering", "\"off\"");
    let mist = ("drops.law", "{ monodisperse = { radius_um = 30.0 } }");
    for (name, own) in [("drizzle", vec![single]), ("mist", vec![single, mist])] {
        let inside = folder.path().join(name);
        fs::create_dir(&inside).unwrap();
        let exact = ("accuracy.theory", "{ level = \"debye\", max_order = 7 }");
        let grid = ("accuracy.pixel_footprint", "{ level = \"grid\", n = 12 }");
        let reference = drizzle(&inside, &[own.as_slice(), &[exact, grid]].concat());
        let out = inside.join("reference");
        let run = ["run", text(&reference), "-o", text(&out), "-q"];
        niji_ends_with(0, &[&run[..], &["--accuracy", "reference"]].concat());
        let expected = luminance(&out);
        let scene = drizzle(&inside, &own);
        for tolerance in ["0.004", "0.03"] {
            let out = inside.join(tolerance);
            let run = ["run", text(&scene), "-o", text(&out), "-q"];
            niji_ends_with(0, &[&run[..], &["--tolerance", tolerance]].concat());
            let found = luminance(&out);
            let squares: f64 = (found.iter().zip(&expected))
                .map(|(found, expected)| (found - expected).powi(2))
                .sum();
            let off = (squares / found.len() as f64).sqrt();
            let allowed: f64 = tolerance.parse().unwrap();
            assert!(off > 0.0 && off <= allowed, "{name}: {off} of {allowed}");
            let told = report(&out)["accuracy"]["error"].as_f64().unwrap();
            assert!(told <= allowed, "{name}: {told} told of {allowed}");
        }
    }
}

#[test]
fn no_tolerance_is_loose_enough_for_a_sky_of_air_as_dense_everywhere_as_at_the_eye() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/clear-sky.toml");
    let levels = levels(&scene, &["--tolerance", "0.5"]);
    assert_eq!(levels["air_path"], "table");
    assert_eq!(levels["sky"], "multiple-scattering");
}

#[test]
fn plan_run_and_chain_choose_alike() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let (run, chain) = (folder.path().join("run"), folder.path().join("chain"));
    let asked = ["--tolerance", "0.02"];
    let planned = levels(&scene, &asked);
    let arguments = ["run", text(&scene), "-o", text(&run), "-q"];
    niji_ends_with(0, &[&arguments[..], &asked].concat());
    assert_eq!(report(&run)["plan"]["levels"], planned);
    let arguments = ["plan", text(&scene), "--script", "-o", text(&chain)];
    let script = niji_ends_with(0, &[&arguments[..], &asked].concat());
    fs::create_dir_all(&chain).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_niji")).parent().unwrap();
    let path = std::env::join_paths([program, Path::new("/usr/bin"), Path::new("/bin")]).unwrap();
    let script = String::from_utf8(script.stdout).unwrap();
    let status = Command::new("sh")
        .env("PATH", path)
        .args(["-c", &script])
        .status();
    assert!(status.unwrap().success());
    let bytes = |folder: &Path| fs::read(folder.join("image.exr")).unwrap();
    assert!(bytes(&run) == bytes(&chain), "the chain's picture differs");
}

#[test]
fn a_looser_tolerance_takes_cheaper_levels_and_a_preset_by_name_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let (loose, tight) = ("0.5", "0.0001");
    let levels = |more: &[&str]| levels(&scene, more);
    let table = |levels: &Value| levels["table_relative_error"].as_f64().unwrap();
    let [of_loose, of_tight] = [loose, tight].map(|it| levels(&["--tolerance", it]));
    assert!(table(&of_loose) > 10.0 * table(&of_tight));
    assert_ne!(of_loose["sun_path"], of_tight["sun_path"]);
    assert_eq!(
        levels(&["--tolerance", tight, "--accuracy", "draft"]),
        levels(&["--accuracy", "draft"])
    );
}

#[test]
fn a_preset_beside_a_tolerance_keeps_its_levels_and_is_judged_by_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let out = folder.path().join("out");
    let run = [
        "run",
        text(&scene),
        "-o",
        text(&out),
        "-q",
        "--accuracy",
        "draft",
    ];
    niji_ends_with(0, &run);
    niji_ends_with(5, &[&run[..], &["--tolerance", "1e-5", "--force"]].concat());
    assert_eq!(report(&out)["plan"]["tolerance"], 1e-5);
    let drafted = levels(&scene, &["--accuracy", "draft"]);
    assert_eq!(report(&out)["plan"]["levels"], drafted);
}

#[test]
fn levels_that_the_scene_names_stay_and_a_missed_tolerance_ends_with_its_cause() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = [
        ("accuracy.theory", "\"airy-published\""),
        ("accuracy.table_relative_error", "0.5"),
    ];
    let scene = drizzle(folder.path(), &coarse);
    let out = folder.path().join("out");
    let run = ["run", text(&scene), "-o", text(&out)];
    let ended = niji_ends_with(5, &[&run[..], &["--tolerance", "1e-5"]].concat());
    let messages = String::from_utf8(ended.stderr).unwrap();
    assert!(
        messages.contains("accuracy.table_relative_error"),
        "{messages}"
    );
    assert!(out.join("image.exr").exists(), "the picture is written");
    assert_eq!(report(&out)["plan"]["levels"]["theory"], "airy-published");
}

#[test]
fn a_run_ends_with_its_seconds_what_it_left_out_and_one_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let fog = [
        ("effects.multiple_scattering", "\"off\""),
        ("drops.voxel_m", "10.0"),
    ];
    let scene = small("fog-bank-fogbow.toml", folder.path(), &fog);
    let out = folder.path().join("out");
    let ended = niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
    let said = String::from_utf8(ended.stderr).unwrap();
    let closing: Vec<&str> = said.split_once("\n\n").unwrap().1.lines().collect();
    let orders = "effects.multiple_scattering = \"on\" adds it";
    let n_lines = |words: &str| closing.iter().filter(|line| line.contains(words)).count();
    assert_eq!(n_lines(orders), 1, "{said}");
    assert_eq!(n_lines("of display white, "), 1, "{said}");
    assert!(n_lines("left out") <= 2 && !said.contains('?'), "{said}");
    let verdict = closing.iter().find(|line| line.starts_with("error "));
    assert!(verdict.unwrap().ends_with(" s"), "{said}");
    // Nothing that is rendered is told to be left out.
    let on = [("effects.multiple_scattering", "\"auto\""), fog[1]];
    let scene = small("fog-bank-fogbow.toml", folder.path(), &on);
    let ended = niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "--force"]);
    assert!(!String::from_utf8(ended.stderr).unwrap().contains(orders));
}

#[test]
fn what_a_scene_cannot_have_is_not_told_as_left_out_by_the_plan() {
    // Without shadows there is no light of further orders, whose estimate is above the tolerance.
    let folder = tempfile::tempdir().unwrap();
    let scene = small("paper-b-sun-20-inscatter.toml", folder.path(), &[]);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let report = report(&out);
    assert_eq!(report["accuracy"]["left_out"], 0.0);
    let (error, tolerance) = (
        &report["accuracy"]["error"],
        &report["accuracy"]["tolerance"],
    );
    assert!(error.as_f64() <= tolerance.as_f64(), "{error}");
}
