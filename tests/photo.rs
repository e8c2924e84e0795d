//! A bow in a photograph by the program: sun, depth, check, composite.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::path::Path;

use niji_photo::Photograph;
use niji_photo::read_depth_map;
use support::niji_ends_with;
use support::repository;
use support::text;
use support::variant;

/// Pixels of a primary bow's red edge in the shipped photograph for a sun 28 degrees high.
const PICKS: [&str; 3] = ["119,113", "320,72", "521,113"];

fn pavilion() -> String {
    text(&repository("data/photos/pavilion.jpg")).to_owned()
}

fn sun(extra: &[&str]) -> Vec<String> {
    let mut arguments = vec![
        "sun".to_owned(),
        pavilion(),
        "--fov-deg".to_owned(),
        "60".to_owned(),
    ];
    for pick in PICKS {
        arguments.extend(["--pick".to_owned(), pick.to_owned()]);
    }
    arguments.extend(extra.iter().map(|&flag| flag.to_owned()));
    arguments
}

fn run(code: i32, arguments: &[String]) -> String {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    String::from_utf8(niji_ends_with(code, &arguments).stdout).unwrap()
}

#[test]
fn picks_in_the_shipped_photograph_give_the_sun() {
    let report: serde_json::Value = serde_json::from_str(&run(0, &sun(&["--json"]))).unwrap();
    let best = &report["solutions"][0];
    assert_eq!(best["verdict"], "possible");
    // Picks are rounded to pixels: within three of the printed errors.
    let elevation_deg = best["elevation_deg"].as_f64().unwrap();
    let error_deg = best["errors"]["elevation_deg"].as_f64().unwrap();
    assert!(
        (elevation_deg - 28.0).abs() < 3.0 * error_deg,
        "{elevation_deg} ± {error_deg}"
    );
    assert_eq!(report["findings"].as_array().unwrap().len(), 0);
    assert!(run(0, &sun(&["--published", "1"])).starts_with("sun: elevation"));
}

#[test]
fn impossible_picks_end_with_code_4_and_a_missing_lens_with_2() {
    let upside_down = [
        "sun",
        &pavilion(),
        "--fov-deg",
        "60",
        "--pick",
        "119,314",
        "--pick",
        "320,355",
        "--pick",
        "521,314",
    ];
    let output = niji_ends_with(4, &upside_down);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("below the horizon"), "{message}");
    niji_ends_with(
        2,
        &[
            "sun",
            &pavilion(),
            "--pick",
            "1,2",
            "--pick",
            "3,4",
            "--pick",
            "5,9",
        ],
    );
    niji_ends_with(
        3,
        &["sun", "nowhere.jpg", "--fov-deg", "60", "--pick", "1,2"],
    );
}

#[test]
fn contradictions_are_told_with_code_4() {
    let check = |extra: &[&str], code| {
        let photo = pavilion();
        let mut arguments = vec![
            "check",
            &photo,
            "--fov-deg",
            "60",
            "--sun-azimuth-deg",
            "180",
        ];
        arguments.extend(extra);
        String::from_utf8(niji_ends_with(code, &arguments).stdout).unwrap()
    };
    let sound = check(&["--sun-elevation-deg", "28", "--cloud-cover", "0.5"], 0);
    assert!(!sound.contains("error:"), "{sound}");
    assert!(check(&["--sun-elevation-deg", "28", "--cloud-cover", "0"], 4).contains("cloudless"));
    assert!(check(&["--sun-elevation-deg", "70"], 4).contains("sun-too-high"));
    let (photo, fixed) = (pavilion(), ["--fov-deg=60", "--sun-azimuth-deg=180"]);
    for wrong in [
        "--sun-elevation-deg=100",
        "--cloud-cover=1.5",
        "--utc-offset-h=30",
    ] {
        let sun = ["--sun-elevation-deg=28", wrong];
        let sun = if wrong.starts_with("--sun") {
            &sun[1..]
        } else {
            &sun[..]
        };
        niji_ends_with(2, &[&["check", &photo], &fixed[..], sun].concat());
    }
    let once = ["--sun-elevation-deg=28", "--cloud-cover=0"];
    let told = niji_ends_with(4, &[&["check", &photo], &fixed[..], &once].concat());
    let told = String::from_utf8(told.stderr).unwrap();
    assert!(told.trim_end().ends_with("for 1 reason"), "{told}");
    // Noon in June at the equator: the sun stands in the north, 67 degrees high.
    let noon = [
        "--sun-elevation-deg",
        "28",
        "--time",
        "2024-06-21T12:00:00",
        "--utc-offset-h",
        "0",
        "--place-deg",
        "0,0",
    ];
    assert!(check(&noon, 4).contains("sun-elsewhere"));
}

#[test]
fn layers_are_proposed_corrected_and_hide_the_bow_behind_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let photo = pavilion();
    let (depth, corrected) = (at("depth.exr"), at("corrected.exr"));
    let common = ["depth", photo.as_str(), "--fov-deg", "60", "-q", "-o"];
    let with = |extra: &[&str]| niji_ends_with(0, &[&common[..], extra].concat());
    with(&[&depth, "--clusters", "5"]);
    // The same layers, all at 10 m.
    let toml = std::fs::read_to_string(at("depth.layers.toml")).unwrap();
    let lines = toml.lines().map(|line| {
        if line.starts_with("distance_m") {
            "distance_m = 10.0"
        } else {
            line
        }
    });
    std::fs::write(at("near.toml"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    with(&[
        &corrected,
        "--layers",
        &at("near.toml"),
        "--labels",
        &at("depth.labels.png"),
    ]);
    let near = read_depth_map(Path::new(&corrected)).unwrap();
    assert!(near.iter().all(|depth| (*depth - 10.0).abs() < 1e-6));

    // The camera of the photograph, a quarter of its size, and drops from 100 m on.
    let scene = variant(
        "paper-c-figure-3.toml",
        folder.path(),
        &[
            ("camera.width_px", "160"),
            ("camera.height_px", "107"),
            ("camera.elevation_deg", "0.0"),
            ("camera.horizontal_fov_deg", "60.0"),
            ("sun.elevation_deg", "28.0"),
        ],
    );
    let out = at("out");
    niji_ends_with(0, &["run", text(&scene), "-o", &out, "-q"]);
    let image = format!("{out}/image.exr");
    let composite = |name: &str, extra: &[&str]| {
        let to = at(name);
        let fixed = [
            "composite",
            &photo,
            "--image",
            &image,
            "--exposure",
            "50",
            "-q",
            "-o",
            &to,
        ];
        niji_ends_with(0, &[&fixed[..], extra].concat());
        Photograph::read(Path::new(&to)).unwrap()
    };
    let original = Photograph::read(Path::new(&photo)).unwrap();
    let bow = composite("bow.png", &[]);
    let sum = |photo: &Photograph| {
        photo
            .light
            .iter()
            .map(|pixel| f64::from(pixel[0]))
            .sum::<f64>()
    };
    assert!(sum(&bow) > 1.01 * sum(&original), "the bow is there");
    // Everything stands at 10 m, before the drops: the photograph comes out as it went in.
    let hidden = composite("hidden.png", &["--depth", &corrected]);
    assert_eq!(hidden.light, original.light);
    let element = composite("element.exr", &[]);
    assert!(element.light.iter().flatten().all(|value| *value >= 0.0));
    niji_ends_with(
        2,
        &["composite", &photo, "--image", &image, "-o", &at("bow.tif")],
    );
}

#[test]
fn numbers_of_a_depth_map_that_cannot_be_meant_are_usage() {
    let folder = tempfile::tempdir().unwrap();
    let depth = folder.path().join("depth.exr");
    let (photo, map) = (pavilion(), repository("data/photos/pavilion.labels.png"));
    let fixed = ["depth", &photo, "--fov-deg", "60", "-o", text(&depth)];
    let map = ["--map", text(&map), "--kind", "metres", "--unit-m"];
    for (flags, told) in [
        (vec!["--clusters", "0"], "clusters"),
        (vec!["--eye-height-m=-1"], "the eye"),
        ([&map[..], &["0"]].concat(), "the unit"),
        ([&map[..], &["nan"]].concat(), "the unit"),
    ] {
        let refused = niji_ends_with(2, &[&fixed[..], &flags].concat());
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.contains(told), "{message}");
        assert!(!depth.exists());
    }
}
