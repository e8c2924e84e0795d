//! Jobs of the program that are killed at random moments and go on until they are done.
//!
//! After every kill each file that stands there under its own name is the one of an undisturbed job, and every
//! picture is whole; once the job is done its folder holds what an undisturbed one leaves and nothing else.

#![allow(dead_code, unreachable_pub, reason = "each target uses its part")]
#![allow(clippy::unwrap_used, reason = "what cannot be set up ends the test")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Child;
use std::process::Command;
use std::process::ExitStatus;
use std::process::Stdio;
use std::time::Duration;
use std::time::Instant;

use nix::sys::signal::Signal;
use nix::sys::signal::kill;
use nix::unistd::Pid;

#[path = "../../crates/vdb/tests/common/mod.rs"]
mod vdb_files;

use vdb_files::Random;

use super::support::TINY;
use super::support::repository;

/// Files whose bytes are told by the request alone; others hold times.
const TIMELESS: [&str; 4] = ["exr", "vdb", "png", "toml"];
/// Code of a program that was asked to end.
const INTERRUPTED: i32 = 130;

/// Commands that are run in one folder, one after the other.
pub struct Job {
    /// What it tries.
    pub name: &'static str,
    scene: String,
    commands: Vec<Vec<&'static str>>,
}

/// What was done to a job.
#[derive(Default)]
pub struct Tally {
    /// Kills while a command was running.
    pub killed: u32,
    /// How many of them by a signal that asks.
    pub asked: u32,
    /// Times that the job was done to its end.
    pub done: u32,
}

/// The jobs: a run, a sequence, tiles that are merged, ice, a sweep.
pub fn jobs() -> Vec<Job> {
    let words = |line: &'static str| line.split(' ').collect::<Vec<_>>();
    let job = |name, scene: &str, lines: &[&'static str]| Job {
        name,
        scene: scene.to_owned(),
        commands: lines.iter().map(|line| words(line)).collect(),
    };
    // The stage of the air beside the others.
    let dark = "sky = \"off\"\nair_inscatter = \"off\"\nair_extinction = \"off\"\nsunlight_through_air = \"off\"\n";
    let air = "[air]\nconstituents = [\"rayleigh\"]\n[accuracy]\nsky = \"single-scattering\"\n";
    let rain = TINY.replace(dark, "").replace("[accuracy]\n", air);
    let rising = format!("{TINY}\n[sequence]\nsun.elevation_deg = [[1, 19.5], [3, 20.5]]\n");
    let ice = fs::read_to_string(repository("data/scenes/ice-cube-0.1-m.toml")).unwrap();
    let ice = ice
        .replace("width_px = 640", "width_px = 32")
        .replace("height_px = 480", "height_px = 24");
    let least = TINY
        .replace("width_px = 16", "width_px = 4")
        .replace("height_px = 12", "height_px = 3")
        .replace("voxel_m = 100.0", "voxel_m = 300.0");
    vec![
        job("run", &rain, &["run s.toml -o out -q"]),
        job("sequence", &rising, &["run s.toml -o out --frames 1-3 -q"]),
        job(
            "tiles",
            &TINY.replace("height_px = 12", "height_px = 24"),
            &[
                "drops --scene s.toml -o d.vdb -q",
                "airy -o a.exr -q",
                "scatter --scene s.toml --airy a.exr -o t.exr -q",
                "render --scene s.toml --drops d.vdb --table t.exr --tiles 1/3 -o 1.exr -q",
                "render --scene s.toml --drops d.vdb --table t.exr --tiles 2/3 -o 2.exr -q",
                "render --scene s.toml --drops d.vdb --table t.exr --tiles 3/3 -o 3.exr -q",
                "merge 1.exr 2.exr 3.exr -o image.exr -q",
            ],
        ),
        job("ice", &ice, &["ice s.toml -o ice.exr -q"]),
        job("sweep", &least, &["sweep s.toml -o out -q"]),
    ]
}

impl Job {
    fn start(&self, index: usize, folder: &Path) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_niji"));
        command.current_dir(folder).args(&self.commands[index]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// A folder with its scene.
    fn folder(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("s.toml"), &self.scene).unwrap();
        folder
    }

    /// Does the job undisturbed: what it leaves, and how long each command takes.
    fn undisturbed(&self) -> (BTreeMap<String, Vec<u8>>, Vec<Duration>) {
        let folder = self.folder();
        let time = |index| {
            let start = Instant::now();
            self.end(index, self.start(index, folder.path()));
            start.elapsed()
        };
        let times = (0..self.commands.len()).map(time).collect();
        (files(folder.path()), times)
    }

    /// Waits for a command that is left alone.
    fn end(&self, index: usize, child: Child) {
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let command = self.commands[index].join(" ");
        assert!(output.status.success(), "niji {command}: {said}");
    }

    /// Kills the job that often, at moments of a seed, and has it done again and again.
    pub fn kill(&self, n_kills: u32, seed: u64) -> Tally {
        let (expected, times) = self.undisturbed();
        let (mut random, mut tally) = (Random(seed), Tally::default());
        while tally.killed < n_kills {
            let folder = self.folder();
            for (index, time) in times.iter().enumerate() {
                // Some commands are killed again and again, others not at all.
                while tally.killed < n_kills
                    && random.below(3) > 0
                    && !self.is_over(folder.path(), &expected)
                {
                    let child = self.start(index, folder.path());
                    let most_us = 1 + 11 * time.as_micros() as usize / 10;
                    std::thread::sleep(Duration::from_micros(random.below(most_us) as u64));
                    let signal = [Signal::SIGKILL, Signal::SIGTERM][random.below(2)];
                    if self.killed(child, signal) {
                        tally.killed += 1;
                        tally.asked += u32::from(signal == Signal::SIGTERM);
                        self.check_unfinished(folder.path(), &expected);
                    }
                }
                // Whatever was left behind, and also if it is done already.
                if !self.is_over(folder.path(), &expected) {
                    self.end(index, self.start(index, folder.path()));
                }
            }
            self.check_done(folder.path(), &expected);
            tally.done += 1;
        }
        tally
    }

    /// Whether the job is done and would refuse to be done again: a sweep, whose files tell times.
    fn is_over(&self, folder: &Path, expected: &BTreeMap<String, Vec<u8>>) -> bool {
        self.name == "sweep" && files(folder).keys().eq(expected.keys())
    }

    /// Sends a signal to a command; whether that ended it before it was done.
    fn killed(&self, mut child: Child, signal: Signal) -> bool {
        kill(Pid::from_raw(child.id() as i32), signal).unwrap();
        let status = child.wait().unwrap();
        let ended = |status: ExitStatus| (status.code(), status.signal());
        match ended(status) {
            (Some(0), None) => false,
            // Before the program listens, the signal ends it itself.
            (None, Some(found)) if found == signal as i32 => true,
            (Some(INTERRUPTED), None) if signal == Signal::SIGTERM => true,
            other => {
                let mut said = String::new();
                let _ = child.stderr.unwrap().read_to_string(&mut said);
                panic!("{}: {signal} gave {other:?}: {said}", self.name)
            }
        }
    }

    fn check_unfinished(&self, folder: &Path, expected: &BTreeMap<String, Vec<u8>>) {
        for (name, bytes) in files(folder) {
            let Some(whole) = expected.get(&name) else {
                let path = folder.join(&name);
                let is_temporary = name.contains(".niji-");
                let is_picture = path.extension().is_some_and(|end| end == "exr");
                if is_picture && !is_temporary {
                    niji_exchange::read_plain(&path).unwrap_or_else(|error| {
                        panic!("{}: {name} is torn: {error}", self.name);
                    });
                }
                continue;
            };
            assert!(
                bytes == *whole,
                "{}: {name} differs after a kill",
                self.name
            );
        }
    }

    fn check_done(&self, folder: &Path, expected: &BTreeMap<String, Vec<u8>>) {
        let found = files(folder);
        let (names, expected_names): (Vec<_>, Vec<_>) =
            (found.keys().collect(), expected.keys().collect());
        assert_eq!(names, expected_names, "{}: files that are left", self.name);
        for (name, bytes) in &found {
            assert!(*bytes == expected[name], "{}: {name} differs", self.name);
        }
    }
}

/// All files below a folder by their names in it; what holds times is empty.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).unwrap();
            let end = path.extension().unwrap_or_default();
            let is_timeless = TIMELESS.iter().any(|timeless| end == *timeless);
            let bytes = if is_timeless {
                fs::read(&path).unwrap()
            } else {
                Vec::new()
            };
            found.insert(name.to_string_lossy().into_owned(), bytes);
        }
    }
    found
}
