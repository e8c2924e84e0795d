//! Sequences: what does not change is made once, and a frame that is there is kept.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "support/film.rs"]
mod film;
#[path = "support/plume.rs"]
mod plume;
mod support;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Output;

use niji_dropfield::DropVolume;
use niji_exchange::AttributeValue;
use niji_exchange::SpectralImage;
use niji_vdb::VdbFile;
use serde_json::Value;

use film::Film;
use film::Volumes;
use plume::Plume;
use support::niji;
use support::niji_ends_with;
use support::text;
use support::variant;

const SCENE: &str = "paper-b-sun-20-inscatter.toml";
const SMALL: [(&str, &str); 2] = [("camera.width_px", "24"), ("camera.height_px", "18")];

/// A sun that rises from frame 1 to 5 by a degree, and a camera that turns.
const SEQUENCE: &str = "\n[sequence]
sun.elevation_deg = [[1, 19.5], [5, 20.5]]
camera.azimuth_deg = [[1, 0.0], [3, 1.0]]
";

/// A small scene with more text at its end.
fn scene(folder: &Path, more: &str) -> PathBuf {
    let path = variant(SCENE, folder, &SMALL);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text + more).unwrap();
    path
}

fn run(scene: &Path, out: &Path, flags: &[&str]) -> Output {
    niji(
        &[
            &["run", text(scene), "-o", text(out), "-q", "--json"],
            flags,
        ]
        .concat(),
    )
}

/// The report of a run that succeeded.
fn report(scene: &Path, out: &Path, flags: &[&str]) -> Value {
    let output = run(scene, out, flags);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The stages that ran in each frame, others being up to date.
fn made(report: &Value) -> Vec<(u64, Vec<String>)> {
    let frames = report["frames"].as_array().unwrap().iter();
    frames
        .map(|frame| {
            let stages = frame["stages"].as_array().unwrap().iter();
            let made = stages.filter(|stage| stage["up_to_date"] == false);
            let names = made.map(|stage| stage["stage"].as_str().unwrap().to_owned());
            (frame["frame"].as_u64().unwrap(), names.collect())
        })
        .collect()
}

fn names(folder: &Path, start: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(start)).collect()
}

#[test]
fn tables_are_made_once_and_frames_that_are_there_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), SEQUENCE);
    let out = folder.path().join("out");
    let first = report(&scene, &out, &["--frames", "1-3"]);
    let all = ["drops", "airy", "scatter", "atmosphere", "render"].map(str::to_owned);
    let render = || vec!["render".to_owned()];
    assert_eq!(
        made(&first),
        [(1, all.to_vec()), (2, render()), (3, render())]
    );
    for table in ["scatter.", "atmosphere.", "drops."] {
        assert_eq!(names(&out, table).len(), 1, "{table}");
    }
    let images = [1, 2, 3].map(|n| fs::read(out.join(format!("image.{n:04}.exr"))).unwrap());
    assert!(images[0] != images[1] && images[1] != images[2]);
    assert_eq!(
        names(&out, "image.0002."),
        BTreeSet::from(["exr", "png", "layers.exr"].map(|end| format!("image.0002.{end}")))
    );
    // Each is told how accurate it is.
    for frame in first["frames"].as_array().unwrap() {
        assert!(
            frame["accuracy"]["error"].as_f64().unwrap() > 0.0,
            "{frame}"
        );
    }
    // A second run keeps all, one of more frames makes only those.
    let again = report(&scene, &out, &["--frames", "1-3:2,5"]);
    assert_eq!(made(&again), [(1, vec![]), (3, vec![]), (5, render())]);
    // Each frame has a report of its own, and one is of all.
    let written = |name: &str| -> Value {
        serde_json::from_slice(&fs::read(out.join(name)).unwrap()).unwrap()
    };
    assert_eq!(made(&written("report.0005.json")), [(5, render())]);
    assert_eq!(
        made(&written("report.json")),
        [(1, vec![]), (2, render()), (3, vec![]), (5, render())]
    );
    // A frame does not depend on which others are made with it.
    let alone = folder.path().join("alone");
    report(&scene, &alone, &["--frames", "2"]);
    assert!(fs::read(alone.join("image.0002.exr")).unwrap() == images[1]);
    let said = niji(&["run", text(&scene), "-o", text(&out), "--frames", "1-3"]);
    let said = String::from_utf8_lossy(&said.stderr).into_owned();
    let verdicts = said
        .lines()
        .filter(|it| it.trim_start().starts_with("error "));
    assert_eq!(verdicts.count(), 3, "{said}");
}

#[test]
fn a_changed_key_makes_only_what_depends_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = scene(folder.path(), SEQUENCE);
    let out = folder.path().join("out");
    report(&path, &out, &["--frames", "1-2"]);
    // What is decided for all frames depends on all; the tables stay as they were.
    let changed = SEQUENCE.replace("[3, 1.0]", "[3, 2.0]");
    scene(folder.path(), &changed);
    let again = report(&path, &out, &["--frames", "1-2"]);
    let render = || vec!["render".to_owned()];
    assert_eq!(made(&again), [(1, render()), (2, render())]);
    // Whoever has only a share of the frames replaces nothing.
    scene(folder.path(), SEQUENCE);
    let choice = folder.path().join("choice.toml");
    let plan = ["plan", text(&path), "--frames", "1-2", "-o", text(&choice)];
    niji_ends_with(0, &plan);
    let refused = run(&path, &out, &["--frames", "1-2", "--choice", text(&choice)]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(
        message.contains("frame 1") && message.contains("--force"),
        "{message}"
    );
}

#[test]
fn drops_of_another_program_are_read_frame_by_frame() {
    let folder = tempfile::tempdir().unwrap();
    let still = variant(
        "garden-fountain.toml",
        folder.path(),
        &[SMALL[0], SMALL[1], ("drops.voxel_m", "0.3")],
    );
    let drops = folder.path().join("spray.0007.vdb");
    niji_ends_with(
        0,
        &["drops", "--scene", text(&still), "-o", text(&drops), "-q"],
    );
    let written = fs::read_to_string(&still).unwrap();
    let mut table: toml::Table = written.parse().unwrap();
    let named: toml::Table = "file = \"spray.####.vdb\"".parse().unwrap();
    table.insert("drops".to_owned(), named.into());
    fs::write(&still, table.to_string()).unwrap();
    let out = folder.path().join("out");
    report(&still, &out, &["--frames", "7"]);
    assert!(out.join("image.0007.exr").is_file());
    let missing = run(&still, &out, &["--frames", "7-8"]);
    let message = String::from_utf8_lossy(&missing.stderr);
    assert_eq!(missing.status.code(), Some(3), "{message}");
    assert!(message.contains("spray.0008.vdb"), "{message}");
}

#[test]
fn what_is_wrong_with_the_last_frame_is_told_before_the_first_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let path = scene(folder.path(), &SEQUENCE.replace("20.5", "120.0"));
    let refused = run(&path, &out, &["--frames", "1-5"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(3), "{message}");
    // 19.5 + 100.5/4 k degrees: above 90 from frame 4 on.
    assert!(message.contains("frame 4: line"), "{message}");
    assert!(!out.exists());
}

#[test]
fn a_camera_turns_over_north_and_its_picture_widens() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let turn = "\n[sequence]
camera.azimuth_deg = [[1, 350.0], [3, 370.0]]
camera.width_px = [[1, 24], [3, 26]]
";
    report(
        &scene(folder.path(), turn),
        &out,
        &["--frames", "2-3", "--accuracy", "draft"],
    );
    let read = |number: u32| {
        let image = SpectralImage::read_spectral(&out.join(format!("image.{number:04}.exr")));
        let image = image.unwrap();
        let [_, _, axis_x, _, _, _, axis_y, _, _, _, axis_z, ..] = image.world_to_camera.unwrap();
        (image.radiance.dim().2, [axis_x, axis_y, axis_z])
    };
    let (width_px, back) = read(2);
    assert_eq!(width_px, 25);
    // Halfway it looks north: nothing of its axis points east.
    assert!(back[0].abs() < 1e-6 && back[2] > 0.9, "{back:?}");
    assert_eq!(read(3).0, 26);
    // No picture has half a pixel.
    let halves = turn.replace("26]", "25]");
    let refused = run(&scene(folder.path(), &halves), &out, &["--frames", "1-3"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(3), "{message}");
    assert!(
        message.contains("frame 2: line") && message.contains("whole number"),
        "{message}"
    );
}

#[test]
fn what_is_no_sequence_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let refused = |more: &str, flags: &[&str], code: i32, words: &[&str]| {
        let path = scene(folder.path(), more);
        let output = run(&path, &out, flags);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{message}");
        for word in words {
            assert!(message.contains(word), "{word:?} in {message}");
        }
    };
    refused(
        "",
        &["--frames", "1-2"],
        2,
        &["nothing changes", "[sequence]", "####"],
    );
    refused(SEQUENCE, &[], 2, &["is a sequence", "--frames"]);
    refused(SEQUENCE, &["--frames", "3-1"], 2, &["1-240", "ascending"]);
    refused(SEQUENCE, &["--frames", "1-3,2"], 2, &["1-240", "twice"]);
    let misspelt = SEQUENCE.replace("elevation", "elevaton");
    refused(
        &misspelt,
        &["--frames", "1"],
        3,
        &["did you mean `sun.elevation_deg`"],
    );
    // The range of a key is that of the scene, and the frame is named.
    let high = SEQUENCE.replace("20.5", "120.0");
    refused(
        &high,
        &["--frames", "5"],
        3,
        &["frame 5", "sun.elevation_deg"],
    );
    // Other commands take the scene as it stands.
    let path = scene(folder.path(), SEQUENCE);
    niji_ends_with(0, &["plan", text(&path)]);
}

/// Densities of a plume that grows, one file a frame from 1 to 4; the first has none.
fn plume(folder: &Path) {
    for (number, top_m) in [(1, 0.0), (2, 20.0), (3, 60.0), (4, 35.0)] {
        let plume = Plume {
            top_m,
            phase_rad: 0.0,
        };
        plume.write_density(&folder.join(format!("plume.{number:04}.vdb")));
    }
}

const PLUME: &str = r#"
format = 1
name = "growing plume"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 2.0, 0.0]
azimuth_deg = 0.0
elevation_deg = 15.0
horizontal_fov_deg = 60.0
width_px = 24
height_px = 18
[drops]
shape = "from-vdb"
file = "plume.####.vdb"
density_means = "optical-depth"
scale = 2.0
effective_radius_um = 150.0
effective_variance = 0.1
[air]
constituents = ["rayleigh"]
[sequence]
frames_per_second = 25
sun.elevation_deg = [[1, 15.0], [4, 24.0]]
camera.azimuth_deg = [[1, -5.0], [4, 5.0]]
"#;

#[test]
fn files_of_frames_ask_for_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("plume.toml");
    let (text, _) = PLUME.split_once("[sequence]").unwrap();
    fs::write(&scene, text).unwrap();
    let refused = run(&scene, &folder.path().join("out"), &[]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(3), "{message}");
    assert!(
        message.contains("plume.####.vdb") && message.contains("--frames"),
        "{message}"
    );
}

#[test]
fn frames_have_the_same_bytes_at_once_in_shares_and_alone() {
    let folder = tempfile::tempdir().unwrap();
    plume(folder.path());
    let scene = folder.path().join("plume.toml");
    fs::write(&scene, PLUME).unwrap();
    let out = |name: &str| folder.path().join(name);
    report(&scene, &out("all"), &["--frames", "1-4"]);
    let image =
        |name: &str, number: u32| fs::read(out(name).join(format!("image.{number:04}.exr")));
    let same = |name: &str, numbers: &[u32]| {
        for number in numbers {
            assert!(
                image(name, *number).unwrap() == image("all", *number).unwrap(),
                "{name} {number}"
            );
        }
    };
    // Decided first, without a picture; then frames in any shares.
    let tables = [&["--frames", "1-4"][..], &["--until", "tables"]].concat();
    report(&scene, &out("shares"), &tables);
    let choice = out("shares").join("choice.toml");
    let made = names(&out("shares"), "");
    let is_table = |name: &&String| name.starts_with("scatter.") || name.starts_with("atmosphere.");
    assert_eq!(made.iter().filter(is_table).count(), 2, "{made:?}");
    assert!(
        !made.iter().any(|name| name.starts_with("image")),
        "{made:?}"
    );
    for frames in ["3-4", "1-2"] {
        report(
            &scene,
            &out("shares"),
            &["--frames", frames, "--choice", text(&choice)],
        );
    }
    same("shares", &[1, 2, 3, 4]);
    // Shares of a sequence write a report of each frame, and none of all, for which they would read those of others.
    let reports = names(&out("shares"), "report.");
    assert_eq!(reports, names(&out("all"), "report.0"));
    // Alone, without a choice: what is decided depends on the sequence.
    report(&scene, &out("alone"), &["--frames", "2"]);
    same("alone", &[2]);
    let planned = out("planned.toml");
    let plan = [
        "plan",
        text(&scene),
        "--frames",
        "1-4",
        "-o",
        text(&planned),
    ];
    niji_ends_with(0, &plan);
    assert!(fs::read(&planned).unwrap() == fs::read(&choice).unwrap());
    // A choice of another sequence is refused.
    fs::write(&scene, PLUME.replace("[4, 5.0]", "[4, 6.0]")).unwrap();
    let refused = run(
        &scene,
        &out("other"),
        &["--frames", "2", "--choice", text(&choice)],
    );
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(
        message.contains("niji plan") && message.contains("--frames"),
        "{message}"
    );
}

#[test]
fn a_plume_that_grows_has_one_scale() {
    let folder = tempfile::tempdir().unwrap();
    plume(folder.path());
    let scene = folder.path().join("plume.toml");
    fs::write(&scene, PLUME).unwrap();
    let out = folder.path().join("out");
    report(&scene, &out, &["--frames", "1-4", "--accuracy", "draft"]);
    let mut drops: Vec<DropVolume> = Vec::new();
    for name in names(&out, "drops.") {
        let file = VdbFile::read(&out.join(name)).unwrap();
        drops.extend(
            DropVolume::from_vdb(&file)
                .ok()
                .filter(|it| it.summary().n_nodes > 0),
        );
    }
    // Of frame 2 to 4 with drops, the same number of them where the density is the same.
    assert_eq!(drops.len(), 3);
    let base = drops
        .iter()
        .map(|it| it.modes[0].drops([12, 1, 12]).number_density_m3);
    let base: Vec<f32> = base.collect();
    assert!(
        base[0] > 0.0 && base.iter().all(|it| *it == base[0]),
        "{base:?}"
    );
    // The densest frame has the depth that the scene says.
    let depth = |it: &DropVolume| {
        2.0 * it
            .summary()
            .optical_depth_q1
            .into_iter()
            .fold(0.0, f64::max)
    };
    let depths: Vec<f64> = drops.iter().map(depth).collect();
    let largest = depths.iter().copied().fold(0.0, f64::max);
    assert!((largest - 2.0).abs() < 1e-5, "{depths:?}");
    // An image knows when it is shown.
    let image = SpectralImage::read_spectral(&out.join("image.0004.exr")).unwrap();
    let told = |name: &str| image.attributes[name].clone();
    assert_eq!(told("framesPerSecond"), AttributeValue::Number(25.0));
    assert_eq!(
        told("timeCode"),
        AttributeValue::Text("00:00:00:04".to_owned())
    );
}

#[test]
fn frames_of_a_plume_that_grows_do_not_flicker() {
    let folder = tempfile::tempdir().unwrap();
    let film = Film {
        volumes: Volumes::Density,
        folder: folder.path(),
        n_frames: 6,
        size_px: [32, 18],
        finest: 0.005,
    };
    for beside in film.beside_references() {
        let largest = beside.off.abs().max(beside.change_off.abs());
        assert!(largest < 2e-3, "{beside:?}");
    }
}

#[test]
fn the_frames_with_the_smallest_and_largest_drops_are_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    for frame in 1..=12 {
        let radius_um = match frame {
            4 => 900.0,
            7 => 15.0,
            _ => 120.0,
        };
        let plume = Plume::at(12, 12);
        let file = folder.path().join(format!("plume.{frame:04}.vdb"));
        plume.write_drops(&file, |_| radius_um);
    }
    let scene = folder.path().join("plume.toml");
    let text = PLUME.replace("[4, ", "[12, ");
    let (before, after) = (text.find("shape = ").unwrap(), text.find("[air]").unwrap());
    let text = format!(
        "{}file = \"plume.####.vdb\"\n{}",
        &text[..before],
        &text[after..]
    );
    fs::write(&scene, text).unwrap();
    let choice = folder.path().join("choice.toml");
    let plan = [
        "plan",
        support::text(&scene),
        "--frames",
        "4",
        "-o",
        support::text(&choice),
    ];
    niji_ends_with(0, &plan);
    let choice: toml::Table = fs::read_to_string(&choice).unwrap().parse().unwrap();
    let frames = choice["frames"].as_array().unwrap();
    let frames: Vec<i64> = frames.iter().filter_map(toml::Value::as_integer).collect();
    // Ends and quarters in any case.
    assert_eq!(frames, [1, 3, 4, 6, 7, 9, 12]);
}
