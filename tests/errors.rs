//! Bad input: one clear message, the right exit code, nothing half-written.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use support::niji;
use support::niji_ends_with;
use support::text;
use support::variant;

const SMALL: [(&str, &str); 2] = [("camera.width_px", "48"), ("camera.height_px", "36")];

/// The message of a failure, which is one line.
fn message(code: i32, arguments: &[&str]) -> String {
    let output = niji_ends_with(code, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.starts_with("error: "), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    message
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).map(|entries| {
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    });
    entries.unwrap_or_default()
}

#[test]
fn a_missing_scene_is_named() {
    let found = message(
        3,
        &["run", "nowhere.toml", "-o", "out-of-a-missing-scene", "-q"],
    );
    assert!(found.contains("nowhere.toml"));
    assert!(!Path::new("out-of-a-missing-scene").exists());
}

#[test]
fn a_misspelt_key_gets_its_line_and_a_suggestion() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &[]);
    let text_of = fs::read_to_string(&scene)
        .unwrap()
        .replace("elevation_deg = 20.0", "elevaton_deg = 20.0");
    fs::write(&scene, &text_of).unwrap();
    let line = 1 + text_of
        .lines()
        .position(|line| line.contains("elevaton_deg"))
        .unwrap();
    let found = message(3, &["plan", text(&scene)]);
    assert!(
        found.contains(&format!("line {line}")) && found.contains("elevation_deg"),
        "{found}"
    );
}

#[test]
fn impossible_values_are_refused() {
    for (path, value) in [
        ("camera.horizontal_fov_deg", "181.0"),
        ("camera.width_px", "0"),
        ("sun.elevation_deg", "nan"),
        ("drops.voxel_m", "-1.0"),
        ("drops.law", "{ monodisperse = { radius_um = -5.0 } }"),
        ("drops.number_density_m3", "-1.0"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let scene = variant("paper-c-figure-3.toml", folder.path(), &[(path, value)]);
        let out = folder.path().join("out");
        message(3, &["run", text(&scene), "-o", text(&out), "-q"]);
        assert_eq!(names(&out), Vec::<String>::new(), "{path}");
    }
}

#[test]
fn a_scene_without_any_light_is_impossible() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("effects.primary_bow", "\"off\""),
        ("effects.secondary_bow", "\"off\""),
    ];
    let scene = variant("paper-c-figure-3.toml", folder.path(), &changes);
    let out = folder.path().join("out");
    let found = message(4, &["run", text(&scene), "-o", text(&out), "-q"]);
    assert!(found.contains("light"), "{found}");
    assert!(!out.exists());
}

#[test]
fn an_output_that_exists_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("airy.exr");
    fs::write(&path, "somebody's work").unwrap();
    let found = message(2, &["airy", "-o", text(&path), "-q"]);
    assert!(found.contains("--force"), "{found}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "somebody's work");
    niji_ends_with(0, &["airy", "-o", text(&path), "-q", "--force"]);
    niji_ends_with(0, &["airy", "-o", text(&path), "-q"]);
}

#[test]
fn damaged_files_are_refused_at_every_stage() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &SMALL);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let cut = |name: &str| {
        let bytes = fs::read(out.join(name)).unwrap();
        let path = folder.path().join(format!("cut-{name}"));
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        path
    };
    let (drops, table, airy) = (
        out.join("drops.vdb"),
        out.join("scatter.exr"),
        out.join("airy.exr"),
    );
    let image = folder.path().join("image.exr");
    let render = |drops: &Path, table: &Path| {
        let arguments = [
            "render",
            "--scene",
            text(&scene),
            "--drops",
            text(drops),
            "--table",
            text(table),
            "-o",
            text(&image),
            "-q",
        ];
        message(3, &arguments)
    };
    assert!(render(&cut("drops.vdb"), &table).contains("cut-drops.vdb"));
    assert!(render(&drops, &cut("scatter.exr")).contains("cut-scatter.exr"));
    // A table of another quantity, and a missing one.
    let other = render(&drops, &airy);
    assert!(
        other.contains("airy") && other.contains("scattering"),
        "{other}"
    );
    assert!(render(&drops, &folder.path().join("none.exr")).contains("none.exr"));
    assert!(
        render(&table, &table).contains("scatter.exr"),
        "an EXR is no VDB"
    );
    let airy_cut = cut("airy.exr");
    let table_out = folder.path().join("table.exr");
    let arguments = [
        "scatter",
        "--scene",
        text(&scene),
        "--airy",
        text(&airy_cut),
        "-o",
        text(&table_out),
        "-q",
    ];
    message(3, &arguments);
    message(3, &["info", text(&airy_cut)]);
    assert!(!image.exists() && !table_out.exists());
    assert!(
        names(folder.path())
            .iter()
            .all(|name| !name.contains(".part"))
    );
}

#[test]
fn what_an_earlier_run_left_damaged_is_neither_kept_nor_called_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &SMALL);
    let out = folder.path().join("out");
    let run = ["run", text(&scene), "-o", text(&out), "-q"];
    niji_ends_with(0, &run);
    let half = |name: &str| {
        let bytes = fs::read(out.join(name)).unwrap();
        bytes[..bytes.len() / 2].to_vec()
    };
    for (name, bytes) in [
        ("scatter.exr", half("scatter.exr")),
        ("image.exr", half("image.exr")),
        ("drops.vdb", half("drops.vdb")),
        ("image.layers.exr", b"rubbish".to_vec()),
        ("image.png", b"rubbish".to_vec()),
    ] {
        let path = out.join(name);
        let sound = fs::read(&path).unwrap();
        fs::write(&path, bytes).unwrap();
        let found = message(2, &run);
        for words in [name, "cannot be read", "--force"] {
            assert!(found.contains(words), "{words} of {name} in {found}");
        }
        fs::write(&path, sound).unwrap();
    }
    niji_ends_with(0, &run);
}

#[test]
fn air_of_another_scene_is_taken_but_not_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let base = "paper-b-sun-20-inscatter.toml";
    let out = folder.path().join("out");
    let scene = variant(base, folder.path(), &SMALL);
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let files = ["drops.vdb", "scatter.exr", "atmosphere.exr"].map(|name| out.join(name));
    let said_with = |code: i32, name: &str, changes: &[(&str, &str)]| {
        let scene = variant(base, folder.path(), &[&SMALL[..], changes].concat());
        let image = folder.path().join(name);
        let arguments = [
            "render",
            "--scene",
            text(&scene),
            "--drops",
            text(&files[0]),
            "--table",
            text(&files[1]),
            "--air",
            text(&files[2]),
            "-o",
            text(&image),
        ];
        String::from_utf8(niji_ends_with(code, &arguments).stderr).unwrap()
    };
    let said = |name: &str, changes: &[(&str, &str)]| said_with(0, name, changes);
    assert!(!said("same.exr", &[]).contains("warning"));
    let found = said("ground.exr", &[("ground.albedo", "0.9")]);
    for words in ["atmosphere.exr", "[ground]", "0.9"] {
        assert!(found.contains(words), "{words} in {found}");
    }
    let found = said("air.exr", &[("air.rayleigh", "\"bodhaine\"")]);
    for words in ["atmosphere.exr", "[air]", "bodhaine"] {
        assert!(found.contains(words), "{words} in {found}");
    }
    // What it lacks cannot be done without.
    let found = said_with(3, "sky.exr", &[("accuracy.sky", "\"multiple-scattering\"")]);
    for words in ["atmosphere.exr: ", "diffuse light", "`niji atmosphere`"] {
        assert!(found.contains(words), "{words} in {found}");
    }
}

#[test]
fn a_table_without_the_sizes_of_the_drops_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &SMALL);
    let (drops, table) = (
        folder.path().join("drops.vdb"),
        folder.path().join("table.exr"),
    );
    niji_ends_with(
        0,
        &["drops", "--scene", text(&scene), "-o", text(&drops), "-q"],
    );
    let arguments = [
        "scatter",
        "--theory",
        "airy",
        "--effective-radius-um",
        "300",
        "--theta-deg",
        "90,180",
        "-o",
        text(&table),
        "-q",
    ];
    niji_ends_with(0, &arguments);
    let image = folder.path().join("image.exr");
    let arguments = [
        "render",
        "--scene",
        text(&scene),
        "--drops",
        text(&drops),
        "--table",
        text(&table),
        "-o",
        text(&image),
        "-q",
    ];
    let found = message(3, &arguments);
    for words in ["table.exr: ", "300", "100", "`niji scatter`"] {
        assert!(found.contains(words), "{words} in {found}");
    }
}

#[test]
fn wrong_usage_ends_with_2_and_the_help_with_0() {
    for arguments in [
        &["frobnicate"][..],
        &["run"],
        &["drops", "uniform"],
        &["eval", "scatter", "--theory", "mie"],
        &[
            "eval",
            "scatter",
            "--theory",
            "mie",
            "--x",
            "-1",
            "--index",
            "1.333",
            "--angles-deg",
            "0",
        ],
        &[
            "eval",
            "scatter",
            "--theory",
            "mie",
            "--x",
            "1",
            "--index",
            "1.333-0.1i",
            "--angles-deg",
            "0",
        ],
        &[
            "eval",
            "scatter",
            "--theory",
            "mie",
            "--x",
            "1",
            "--index",
            "1.333",
            "--angles-deg",
            "181",
        ],
        &[
            "eval",
            "sizes",
            "--law",
            "monodisperse",
            "--number-density-m3",
            "1",
        ],
        &[
            "eval",
            "index",
            "--material",
            "water",
            "--wavelengths-nm",
            "100",
        ],
        &["airy", "-o", "x.exr", "--threads", "0"],
    ] {
        assert_eq!(niji(arguments).status.code(), Some(2), "{arguments:?}");
    }
    let help = niji(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let help = String::from_utf8(help.stdout).unwrap();
    for group in ["Whole scenes:", "Stages, in order:", "Looking:", "Shell:"] {
        assert!(help.contains(group), "{help}");
    }
}

#[test]
fn a_tolerance_below_the_digits_of_a_picture_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("rain-shaft-5-mm-h.toml", folder.path(), &SMALL);
    let out = folder.path().join("out");
    let run = ["run", text(&scene), "-o", text(&out), "-q"];
    let found = message(5, &[&run[..], &["--tolerance", "1e-9"]].concat());
    for words in ["--tolerance 1e-9", "at least 1e-6"] {
        assert!(found.contains(words), "{words} in {found}");
    }
    let key = [SMALL[0], SMALL[1], ("accuracy.tolerance", "1e-9")];
    let scene = variant("rain-shaft-5-mm-h.toml", folder.path(), &key);
    let found = message(3, &["run", text(&scene), "-o", text(&out), "-q"]);
    assert!(
        found.contains("accuracy.tolerance") && found.contains("0.000001"),
        "{found}"
    );
    assert!(!out.exists());
}

#[test]
fn moonlight_without_an_exposure_names_the_key() {
    let folder = tempfile::tempdir().unwrap();
    let dark = [SMALL[0], SMALL[1], ("picture.exposure_ev", "0.0")];
    let scene = variant("moonbow.toml", folder.path(), &dark);
    let out = folder.path().join("out");
    let found = message(4, &["run", text(&scene), "-o", text(&out), "-q"]);
    for words in ["moon", "picture.exposure_ev = 0", "expected about 19"] {
        assert!(found.contains(words), "{words} in {found}");
    }
    let bright = variant("moonbow.toml", folder.path(), &SMALL);
    let plan = niji_ends_with(0, &["plan", text(&bright)]).stdout;
    assert!(
        !String::from_utf8(plan)
            .unwrap()
            .contains("fainter than the sun")
    );
}
