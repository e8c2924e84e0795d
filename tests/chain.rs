//! A chain by hand gives the bytes of a run; runs repeat themselves; what is off costs nothing.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use niji_exchange::SpectralImage;
use niji_radiometry::Colorimetry;
use serde_json::Value;
use support::niji_ends_with;
use support::run_scene;
use support::text;
use support::variant;

const SMALL: [(&str, &str); 2] = [("camera.width_px", "96"), ("camera.height_px", "72")];

/// Contents of all files of a folder but the report, which holds times.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("the folder exists");
    let paths = entries.map(|entry| entry.expect("the folder can be read").path());
    let files = paths.filter(|path| path.is_file()).map(|path| {
        let name = path
            .file_name()
            .expect("files have names")
            .to_string_lossy()
            .into_owned();
        (name, fs::read(&path).expect("files can be read"))
    });
    files.filter(|(name, _)| name != "report.json").collect()
}

fn assert_same(one: &Path, other: &Path) {
    let (one, other) = (files(one), files(other));
    assert_eq!(
        one.keys().collect::<Vec<_>>(),
        other.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &one {
        assert!(*bytes == other[name], "{name} differs");
    }
}

#[test]
fn the_printed_chain_gives_the_bytes_of_a_run() {
    for name in ["paper-c-figure-3.toml", "paper-b-sun-20-inscatter.toml"] {
        let folder = tempfile::tempdir().unwrap();
        let scene = variant(name, folder.path(), &SMALL);
        let (run, chain) = (folder.path().join("run"), folder.path().join("chain"));
        niji_ends_with(0, &["run", text(&scene), "-o", text(&run), "-q"]);
        let script =
            niji_ends_with(0, &["plan", text(&scene), "--script", "-o", text(&chain)]).stdout;
        let program = Path::new(env!("CARGO_BIN_EXE_niji"));
        let path = std::env::join_paths([
            program.parent().unwrap(),
            Path::new("/usr/bin"),
            Path::new("/bin"),
        ]);
        let shell = Command::new("sh")
            .arg("-c")
            .arg(String::from_utf8(script).unwrap())
            .env("PATH", path.unwrap())
            .output()
            .expect("there is a shell");
        assert!(
            shell.status.success(),
            "{}",
            String::from_utf8_lossy(&shell.stderr)
        );
        assert_same(&run, &chain);
    }
}

#[test]
fn a_second_run_is_up_to_date_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &SMALL);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
    let times = |name: &str| fs::metadata(out.join(name)).unwrap().modified().unwrap();
    let before = ["drops.vdb", "scatter.exr", "image.exr"].map(times);
    let second = niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
    assert!(String::from_utf8_lossy(&second.stderr).contains("up to date"));
    assert_eq!(before, ["drops.vdb", "scatter.exr", "image.exr"].map(times));

    // A file lost in between is made again with those written beside it, and nothing else.
    for lost in ["image.exr", "image.png", "image.layers.exr"] {
        fs::remove_file(out.join(lost)).unwrap();
        niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
        assert!(out.join(lost).is_file());
        assert_eq!(before[..2], ["drops.vdb", "scatter.exr"].map(times)[..]);
    }

    // An edited scene goes on with what it has.
    let other = variant(
        "paper-c-figure-3.toml",
        folder.path(),
        &[SMALL[0], ("camera.height_px", "70")],
    );
    niji_ends_with(0, &["run", text(&other), "-o", text(&out)]);
    assert_eq!(before[..1], ["drops.vdb"].map(times)[..]);
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-b-sun-10-inscatter.toml", folder.path(), &SMALL);
    let run = |threads: &str| {
        let out = folder.path().join(threads);
        niji_ends_with(
            0,
            &[
                "run",
                text(&scene),
                "-o",
                text(&out),
                "-q",
                "--threads",
                threads,
            ],
        );
        out
    };
    let one = run("1");
    assert_same(&one, &run("2"));
    assert_same(&one, &run("7"));
}

fn plan(scene: &Path) -> Value {
    let output = niji_ends_with(0, &["plan", text(scene), "--json"]);
    serde_json::from_slice(&output.stdout).expect("the plan is JSON")
}

fn stages(plan: &Value) -> Vec<String> {
    let stages = plan["stages"].as_array().expect("a plan lists its stages");
    stages
        .iter()
        .map(|stage| stage["stage"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn an_effect_that_is_off_is_absent_from_stages_tables_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let all = variant("paper-b-sun-20-inscatter.toml", folder.path(), &SMALL);
    assert!(stages(&plan(&all)).contains(&"atmosphere".to_owned()));
    let off: Vec<(&str, &str)> = [
        "sunlight_through_air",
        "air_extinction",
        "air_inscatter",
        "sky",
    ]
    .map(|effect| match effect {
        "sunlight_through_air" => "effects.sunlight_through_air",
        "air_extinction" => "effects.air_extinction",
        "air_inscatter" => "effects.air_inscatter",
        _ => "effects.sky",
    })
    .map(|path| (path, "\"off\""))
    .into_iter()
    .chain(SMALL)
    .chain([
        ("effects.secondary_bow", "\"off\""),
        ("effects.skylit_drops", "\"off\""),
    ])
    .collect();
    let folder = tempfile::tempdir().unwrap();
    let less = variant("paper-b-sun-20-inscatter.toml", folder.path(), &off);
    let plan = plan(&less);
    assert!(!stages(&plan).contains(&"atmosphere".to_owned()));
    assert_eq!(plan["scattering"]["orders"], serde_json::json!([2]));
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&less), "-o", text(&out), "-q"]);
    assert!(!out.join("atmosphere.exr").exists());
    assert!(out.join("image.exr").exists());
}

/// Largest change of luminance between two pictures, relative to `reference_cd_m2`.
fn largest_change(one: &SpectralImage, other: &SpectralImage, reference_cd_m2: f64) -> f64 {
    let colorimetry = Colorimetry::new(&one.wavelengths);
    let (n, height, width) = one.radiance.dim();
    let luminance = |image: &SpectralImage, y: usize, x: usize| {
        let spectrum: Vec<f64> = (0..n)
            .map(|i| f64::from(image.radiance[[i, y, x]]))
            .collect();
        colorimetry.xyz(&spectrum)[1]
    };
    let mut largest = 0.0_f64;
    for y in 0..height {
        for x in 0..width {
            largest = largest.max((luminance(one, y, x) - luminance(other, y, x)).abs());
        }
    }
    largest / reference_cd_m2
}

/// Few colors and round drops: what is proved holds for any of them, and these are quick.
const QUICK: [(&str, &str); 8] = [
    SMALL[0],
    SMALL[1],
    ("spectrum.first_nm", "420.0"),
    ("spectrum.step_nm", "60.0"),
    ("spectrum.n_wavelengths", "5"),
    ("effects.drop_flattening", "\"off\""),
    // Rays and pieces that are added in one picture and not in the other are no effect.
    ("accuracy.pixel_footprint", "\"prefiltered\""),
    ("accuracy.integration", "\"cell-exact\""),
];

#[test]
fn proved_bounds_hold_when_an_effect_that_is_off_is_forced_on() {
    let names = [
        "paper-c-figure-3.toml",
        "paper-b-sun-10-attenuation.toml",
        "garden-fountain.toml",
    ];
    let mut n_checked = 0;
    for name in names {
        let folder = tempfile::tempdir().unwrap();
        let base = variant(name, folder.path(), &QUICK);
        let plan = plan(&base);
        let reference = plan["display_white_cd_m2"].as_f64().unwrap();
        let (_, image) = run_scene(&base, &folder.path().join("base"));
        for decision in plan["effects"].as_array().unwrap() {
            let effect = decision["effect"].as_str().unwrap();
            let proved = decision["bound"]["kind"] == "proved";
            if decision["on"] == true || !proved {
                continue;
            }
            let bound = decision["bound"]["value"].as_f64().unwrap();
            let path = format!("effects.{effect}");
            let forced_folder = tempfile::tempdir().unwrap();
            let mut changes = QUICK.to_vec();
            changes.push((path.as_str(), "\"on\""));
            let forced = variant(name, forced_folder.path(), &changes);
            let out = forced_folder.path().join("forced");
            let run = support::niji(&["run", text(&forced), "-o", text(&out), "-q"]);
            if !run.status.success() {
                // Some effects cannot be on in this scene at all: air in a vacuum, water where none is, a shutter of
                // a single picture.
                let message = String::from_utf8_lossy(&run.stderr).into_owned();
                let absent = ["air", "[water_surface]", "[sequence]"];
                let is_absent = absent.iter().any(|it| message.contains(it));
                assert!(is_absent, "{name}, {effect}: {message}");
                continue;
            }
            let forced = SpectralImage::read_spectral(&out.join("image.exr")).unwrap();
            let change = largest_change(&image, &forced, reference);
            assert!(
                change <= bound * (1.0 + 1e-6),
                "{name}, {effect}: {change} above {bound}"
            );
            if change > 1.8e-5 {
                assert!(
                    bound <= 20.0 * change,
                    "{name}, {effect}: {bound} is loose for {change}"
                );
            }
            n_checked += 1;
        }
    }
    assert!(n_checked >= 4, "only {n_checked} bounds were checked");
}
