//! `niji diff`: equal files are equal, what differs is found where it is, thresholds end with code 6.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::path::PathBuf;

use serde_json::Value;
use support::niji_ends_with;
use support::text;
use tempfile::TempDir;

fn drops(folder: &TempDir, name: &str, radius_um: &str, top_m: &str) -> PathBuf {
    let path = folder.path().join(name);
    let top = format!("--box-max-m=8,{top_m},8");
    niji_ends_with(
        0,
        &[
            "drops",
            "uniform",
            "--box-min-m=0,0,0",
            &top,
            "--voxel-m",
            "1",
            "--law",
            "monodisperse",
            "--radius-um",
            radius_um,
            "--number-density-m3",
            "1000",
            "-q",
            "-o",
            text(&path),
        ],
    );
    path
}

fn table(folder: &TempDir, name: &str, theory: &str) -> PathBuf {
    let path = folder.path().join(name);
    niji_ends_with(
        0,
        &[
            "scatter",
            "--theory",
            theory,
            "--effective-radius-um",
            "100",
            "--theta-deg",
            "137,139",
            "--spectrum",
            "500,100,2",
            "-q",
            "-o",
            text(&path),
        ],
    );
    path
}

/// The rows of `niji diff --json` by name: (relative RMSE, largest difference).
fn rows(arguments: &[&str]) -> Vec<(String, f64, f64)> {
    let output = niji_ends_with(0, &[&["diff", "--json"], arguments].concat());
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let row = |row: &Value| {
        let number = |name: &str| row[name].as_f64().unwrap();
        let name = row["name"].as_str().unwrap().to_owned();
        (name, number("relative_rmse"), number("largest_difference"))
    };
    json.as_array().unwrap().iter().map(row).collect()
}

#[test]
fn voxels_that_differ_are_measured_also_where_only_one_file_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let reference = drops(&folder, "a.vdb", "100", "8");
    let larger = drops(&folder, "b.vdb", "110", "8");
    let higher = drops(&folder, "c.vdb", "100", "16");
    for (_, relative, largest) in rows(&[text(&reference), text(&reference)]) {
        assert_eq!((relative, largest), (0.0, 0.0));
    }
    for (name, relative, largest) in rows(&[text(&reference), text(&larger)]) {
        match name.as_str() {
            "number_density" => assert_eq!(relative, 0.0),
            "effective_radius" => {
                assert!((relative - 0.1).abs() < 1e-6 && (largest - 1e-5).abs() < 1e-11);
            }
            // Extinction goes with the square of the radius.
            "density" => assert!((relative - 0.21).abs() < 1e-6),
            other => panic!("{other}"),
        }
    }
    // As many voxels again that the reference does not have.
    let (_, relative, largest) = rows(&[text(&reference), text(&higher)])[0];
    assert_eq!((relative, largest), (1.0, 1000.0));
}

#[test]
fn wavelengths_count_together_and_the_difference_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let airy = table(&folder, "airy.exr", "airy");
    let uniform = table(&folder, "uniform.exr", "uniform");
    let zero = folder.path().join("zero.exr");
    let same = rows(&[text(&airy), text(&airy), "-o", text(&zero)]);
    assert_eq!(same.len(), 2, "s and p: {same:?}");
    assert!(same.iter().all(|row| row.1 == 0.0));
    niji_ends_with(
        0,
        &["info", text(&zero), "-q", "--assert", "max(s.500nm) <= 0"],
    );
    // Their angles differ, as do the numbers of them: that is no difference of values.
    let output = niji_ends_with(6, &["diff", text(&airy), text(&uniform)]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("pixels"), "{said}");
}

#[test]
fn thresholds_and_files_of_two_kinds_end_with_their_codes() {
    let folder = tempfile::tempdir().unwrap();
    let reference = drops(&folder, "a.vdb", "100", "8");
    let larger = drops(&folder, "b.vdb", "110", "8");
    let pair = [text(&reference), text(&larger)];
    let ends_with = |code: i32, flags: &[&str]| {
        niji_ends_with(code, &[&["diff", "-q"], &pair[..], flags].concat());
    };
    ends_with(0, &["--max-relative-rmse", "0.22"]);
    ends_with(6, &["--max-relative-rmse", "0.2"]);
    ends_with(0, &["--max-difference", "1e-3"]);
    ends_with(6, &["--max-difference", "1e-6"]);
    ends_with(2, &["-o", "difference.exr"]);
    let airy = table(&folder, "airy.exr", "airy");
    niji_ends_with(2, &["diff", text(&airy), text(&reference)]);
    niji_ends_with(3, &["diff", text(&airy), "nowhere.exr"]);
}
