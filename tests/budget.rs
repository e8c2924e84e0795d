//! `niji run --budget`: a picture in the time there is, which a choice makes again without a clock.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use support::niji;
use support::niji_ends_with;
use support::text;
use support::variant;

/// A small picture of rain, some of whose pixels ask for more rays.
fn rain(folder: &Path) -> std::path::PathBuf {
    let small = [
        ("camera.width_px", "32"),
        ("camera.height_px", "24"),
        (
            "spectrum",
            "{ first_nm = 450.0, step_nm = 100.0, n_wavelengths = 3 }",
        ),
    ];
    variant("rain-shaft-5-mm-h.toml", folder, &small)
}

fn said(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_choice_of_a_budget_gives_the_same_bytes_and_a_second_run_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rain(folder.path());
    let run = |name: &str, flags: &[&str]| {
        let out = folder.path().join(name);
        let arguments = ["run", text(&scene), "-o", text(&out)];
        let output = niji_ends_with(0, &[&arguments[..], flags].concat());
        (said(&output), out)
    };
    // So short that no pixel gets more rays, and longer.
    for budget in ["1e-3s", "0.1min"] {
        let (first, out) = run(budget, &["--budget", budget]);
        let seconds = if budget == "0.1min" { "6 s" } else { "0.001 s" };
        assert!(first.contains(seconds), "{first}");
        let choice = out.join("choice.toml");
        let found: toml::Table = fs::read_to_string(&choice).unwrap().parse().unwrap();
        let coarser = found["afforded"]["coarser_rays"].as_float().unwrap();
        assert!(coarser > 1.0 || budget != "1e-3s", "{coarser}");
        let (_, again) = run(&format!("{budget}-again"), &["--choice", text(&choice)]);
        for file in ["image.exr", "scatter.exr", "choice.toml"] {
            let bytes = |folder: &Path| fs::read(folder.join(file)).unwrap();
            assert!(bytes(&out) == bytes(&again), "{file} in {budget}");
        }
        let (second, _) = run(budget, &["--budget", budget]);
        assert!(second.contains("everything is up to date"), "{second}");
        // Without a budget nothing is left out for one.
        let tolerance = found["afforded"]["tolerance"]
            .as_float()
            .unwrap()
            .to_string();
        let other = ["--tolerance", &tolerance, "--force"];
        let arguments = ["run", text(&scene), "-o", text(&out)];
        niji(&[&arguments[..], &other].concat());
        let choice = fs::read_to_string(&choice).unwrap();
        assert!(!choice.contains("afforded"), "{choice}");
    }
}

#[test]
fn a_budget_is_a_time_and_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rain(folder.path());
    let out = folder.path().join("out");
    for (flags, expected) in [
        (
            &["--budget", "soon"][..],
            "expected a time above 0, say 10s or 2min",
        ),
        (&["--budget", "0s"], "expected a time above 0"),
        (
            &["--budget", "1s", "--tolerance", "0.1"],
            "cannot be used with",
        ),
    ] {
        let arguments = ["run", text(&scene), "-o", text(&out)];
        let output = niji_ends_with(2, &[&arguments[..], flags].concat());
        assert!(said(&output).contains(expected), "{}", said(&output));
    }
    assert!(!out.exists());
}
