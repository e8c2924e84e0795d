//! `--tolerance` and `--budget`: levels are chosen, and keep what was asked for.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

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
    small("paper-c-figure-3.toml", folder, &own)
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_slice(&niji_ends_with(0, arguments).stdout).unwrap()
}

fn level<'a>(choice: &'a Value, decision: &str) -> &'a Value {
    let levels = choice["levels"].as_array().unwrap();
    let found = levels.iter().find(|level| level["decision"] == decision);
    found.unwrap()
}

#[test]
fn a_tolerance_out_of_reach_is_told_before_it_is_tried() {
    let folder = tempfile::tempdir().unwrap();
    let airy = ("accuracy.theory", "\"airy\"");
    let single = ("effects.multiple_scattering", "\"off\"");
    let scene = drizzle(folder.path(), &[airy, single]);
    let out = folder.path().join("out");
    let run = ["run", text(&scene), "-o", text(&out), "--tolerance", "1e-6"];
    let said = String::from_utf8(niji_ends_with(5, &run).stderr).unwrap();
    let (before, _) = said.split_once("\nstage ").unwrap();
    assert!(
        before.contains("the tolerance 1e-6 is out of reach"),
        "{said}"
    );
    // What it says can be kept is kept by what was measured, and two thirds of it are not.
    let (_, kept) = before.split_once("they keep a tolerance of ").unwrap();
    let kept: f64 = kept.split_whitespace().next().unwrap().parse().unwrap();
    let plan = |tolerance: f64| {
        let tolerance = tolerance.to_string();
        let plan = ["plan", text(&scene), "--tolerance", &tolerance];
        String::from_utf8(niji_ends_with(0, &plan).stdout).unwrap()
    };
    assert!(!plan(kept).contains("out of reach"), "{kept}");
    assert!(plan(0.67 * kept).contains("out of reach"), "{kept}");
}

#[test]
fn the_tolerance_is_kept_against_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    // One order: the reference would take its time over the others.
    let single = ("effects.multiple_scattering", "\"off\"");
    let mist = ("drops.law", "{ monodisperse = { radius_um = 30.0 } }");
    let scene = |name: &str, own: &[(&str, &str)]| {
        let inside = folder.path().join(name);
        fs::create_dir(&inside).unwrap();
        drizzle(&inside, own)
    };
    let scenes = [scene("drizzle", &[single]), scene("mist", &[single, mist])];
    let table = folder.path().join("tolerances.csv");
    let [first, second] = [0, 1].map(|index: usize| text(&scenes[index]));
    niji_ends_with(
        0,
        &[
            "calibrate",
            "--tolerances",
            "0.003,0.03",
            first,
            second,
            "--date",
            "2026-11-21",
            "-o",
            text(&table),
            "-q",
        ],
    );
    let mut reader = csv::Reader::from_path(&table).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    let number = |row: &csv::StringRecord, column: &str| -> f64 {
        let index = header.iter().position(|name| name == column).unwrap();
        row[index].parse().unwrap()
    };
    for row in &rows {
        let [tolerance, off] = ["tolerance", "true_error"].map(|column| number(row, column));
        assert!(off > 0.0 && off <= tolerance, "{row:?}");
        assert!(number(row, "predicted_error") <= 0.5 * tolerance, "{row:?}");
    }
}

/// How many times a tolerance may be missed at worst.
const WORST_MISS: f64 = 2.0;

#[test]
fn of_ten_shipped_scenes_nine_keep_their_tolerance_and_none_misses_it_twice() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let mut reader = csv::Reader::from_path(folder.join("measurements/tolerances.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() >= 30, "{} scenes", rows.len());
    let column = |name: &str| header.iter().position(|found| found == name).unwrap();
    let [name, tolerance, off] = ["scene", "tolerance", "true_error"].map(column);
    let misses = rows.iter().map(|row| {
        let scene = folder.join("scenes").join(format!("{}.toml", &row[name]));
        assert!(scene.exists(), "{} is no shipped scene", &row[name]);
        let [off, tolerance] = [off, tolerance].map(|index| row[index].parse::<f64>().unwrap());
        off / tolerance
    });
    let misses: Vec<f64> = misses.collect();
    let n_kept = misses.iter().filter(|miss| **miss <= 1.0).count();
    assert!(
        10 * n_kept >= 9 * misses.len(),
        "{n_kept} of {}",
        misses.len()
    );
    let worst = misses.iter().copied().fold(0.0, f64::max);
    assert!(worst <= WORST_MISS, "{worst}");
}

#[test]
fn a_sky_is_not_made_of_air_as_dense_everywhere_as_at_the_eye() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/clear-sky.toml");
    let plan = json(&["plan", text(&scene), "--json", "--tolerance", "0.5"]);
    assert_eq!(level(&plan["choice"], "air_path")["level"], "table");
}

#[test]
fn plan_run_and_chain_choose_alike() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let (run, chain) = (folder.path().join("run"), folder.path().join("chain"));
    let asked = ["--tolerance", "0.02"];
    let planned = json(&["plan", text(&scene), "--json", asked[0], asked[1]]);
    niji_ends_with(
        0,
        &[
            "run",
            text(&scene),
            "-o",
            text(&run),
            "-q",
            asked[0],
            asked[1],
        ],
    );
    let report = fs::read_to_string(run.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["choice"], planned["choice"]);
    assert!(report["accuracy"]["error"].as_f64().unwrap() <= 0.01);
    let script = niji_ends_with(
        0,
        &[
            "plan",
            text(&scene),
            "--script",
            "-o",
            text(&chain),
            asked[0],
            asked[1],
        ],
    );
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
fn a_looser_tolerance_takes_cheaper_levels() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let choice = |tolerance: &str| {
        json(&["plan", text(&scene), "--json", "--tolerance", tolerance])["choice"].clone()
    };
    let (loose, tight) = (choice("0.5"), choice("0.0005"));
    let seconds = |choice: &Value| choice["predicted_seconds"].as_f64().unwrap();
    assert!(seconds(&loose) <= seconds(&tight));
    // The scene leaves the other orders out, which Lorenz-Mie cannot.
    let exact = "debye max_order=7";
    assert_eq!(level(&tight, "theory")["level"], exact);
    assert_ne!(level(&loose, "theory")["level"], exact);
}

#[test]
fn levels_that_the_scene_names_stay_and_are_not_believed_in() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[("accuracy.theory", "\"airy-published\"")]);
    let out = folder.path().join("out");
    let asked = [
        "run",
        text(&scene),
        "-o",
        text(&out),
        "--tolerance",
        "0.001",
    ];
    let ended = niji_ends_with(5, &asked);
    let messages = String::from_utf8(ended.stderr).unwrap();
    assert!(messages.contains("named, so it stays"), "{messages}");
    assert!(messages.contains("theory = airy-published"), "{messages}");
    assert!(out.join("image.exr").exists(), "the picture is written");
}

#[test]
fn a_budget_is_kept_by_the_prediction_or_refused_with_the_least_time() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let choice = |budget: &str| {
        json(&["plan", text(&scene), "--json", "--budget", budget])["choice"].clone()
    };
    let (quick, slow) = (choice("2s"), choice("60m"));
    let number = |choice: &Value, key: &str| choice[key].as_f64().unwrap();
    assert!(number(&quick, "predicted_seconds") <= 2.0);
    assert!(number(&slow, "predicted_error") <= number(&quick, "predicted_error"));
    assert_eq!(level(&slow, "pixel_footprint")["level"], "grid n=4");
    let refused = niji_ends_with(2, &["plan", text(&scene), "--budget", "1ms"]);
    let messages = String::from_utf8(refused.stderr).unwrap();
    assert!(
        messages.contains("cheapest levels take an estimated"),
        "{messages}"
    );
    for wrong in [
        &["--budget", "2s", "--tolerance", "0.01"][..],
        &["--budget", "2"],
        &["--budget", "-2s"],
    ] {
        niji_ends_with(2, &[&["plan", text(&scene)], wrong].concat());
    }
}

#[test]
fn a_calibration_of_ones_own_is_read_and_a_missing_or_damaged_one_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = drizzle(folder.path(), &[]);
    let table = folder.path().join("levels.csv");
    let plan = |code: i32| {
        let arguments = [
            "plan",
            text(&scene),
            "--json",
            "--tolerance",
            "0.01",
            "--calibration",
            text(&table),
        ];
        niji_ends_with(code, &arguments).stdout
    };
    plan(3);
    fs::write(&table, "stage,level,scene\ntheory,mie,fog,1\n").unwrap();
    plan(3);
    // Two theories, of which one is free.
    fs::write(
        &table,
        "stage,level,scene,luminance_error,light,radius_um,relative_time,date\n\
         theory,airy,fog,0.0,1.0,10.0,0.5,2026-11-21\n\
         theory,mie,fog,0.0,1.0,10.0,1.0,2026-11-21\n",
    )
    .unwrap();
    let planned: Value = serde_json::from_slice(&plan(0)).unwrap();
    let choice = &planned["choice"];
    assert_eq!(level(choice, "sun_path")["origin"], "unmeasured");
    assert_eq!(level(choice, "theory")["origin"], "chosen");
    assert!(choice["predicted_seconds"].is_null());
}
