//! What is killed at any moment goes on to the same files; `cargo bench --bench killed_runs` kills more often.

#![cfg(unix)]

#[path = "support/killed.rs"]
mod killed;
mod support;

use std::fs;
use std::process::Command;

use support::TINY;
use support::niji_ends_with;
use support::repository;
use support::text;

/// Kills of each job: some seconds in all.
const N_KILLS: u32 = 5;

#[test]
fn what_is_killed_at_any_moment_goes_on_to_the_same_files() {
    // Those that take longer are ended below.
    let is_short = |job: &&killed::Job| !["rows", "sweep"].contains(&job.name);
    for job in killed::jobs().iter().filter(is_short) {
        let tally = job.kill(N_KILLS, 1);
        assert!(tally.done > 0, "{}", job.name);
    }
}

#[test]
fn every_stage_ends_when_it_is_asked_to_and_goes_on() {
    killed::stages().ask_each(1);
}

#[test]
fn rows_stay_until_their_image_is_there() {
    killed::rows().end_with_rows();
}

#[test]
fn files_without_a_place_for_their_request_are_known_again() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let photo = repository("data/photos/pavilion.jpg");
    let image = place("depth.exr");
    let depth = [
        "depth",
        text(&photo),
        "--fov-deg",
        "60",
        "-q",
        "-o",
        text(&image),
    ];
    niji_ends_with(0, &depth);
    let whole = fs::read(&image).unwrap();
    // As if it had been ended before the picture.
    fs::remove_file(&image).unwrap();
    niji_ends_with(0, &depth);
    assert!(fs::read(&image).unwrap() == whole);
    // What somebody edited is theirs.
    fs::remove_file(&image).unwrap();
    let layers = place("depth.layers.toml");
    let edited = fs::read_to_string(&layers).unwrap() + "# mine\n";
    fs::write(&layers, &edited).unwrap();
    let said = String::from_utf8(niji_ends_with(2, &depth).stderr).unwrap();
    assert!(said.contains("depth.layers.toml exists already"), "{said}");
    assert_eq!(fs::read_to_string(&layers).unwrap(), edited);
}

#[test]
fn two_that_race_for_one_table_both_end_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    fs::write(place("s.toml"), TINY).unwrap();
    niji_ends_with(0, &["airy", "-q", "-o", text(&place("a.exr"))]);
    let make = |to: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_niji"));
        let scene = [
            "scatter", "--scene", "s.toml", "--airy", "a.exr", "-q", "-o", to,
        ];
        program.args(scene).current_dir(folder.path());
        program.spawn().unwrap()
    };
    assert!(make("alone.exr").wait().unwrap().success());
    for wait_ms in [0, 5, 20, 40] {
        let to = format!("{wait_ms}.exr");
        let first = make(&to);
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        for mut process in [make(&to), first] {
            assert!(process.wait().unwrap().success(), "{wait_ms} ms later");
        }
        assert!(fs::read(place(&to)).unwrap() == fs::read(place("alone.exr")).unwrap());
    }
}
