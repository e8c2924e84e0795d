//! Jobs of the program that are killed at random moments and go on until they are done.
//!
//! After every kill each file that stands there under its own name is the one of an undisturbed job, and every
//! picture is whole; once the job is done its folder holds what an undisturbed one leaves and nothing else.

#![allow(
    dead_code,
    unreachable_pub,
    unused_imports,
    reason = "each target uses its part"
)]
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

#[path = "killed_jobs.rs"]
mod jobs;
#[path = "../../crates/vdb/tests/common/mod.rs"]
mod vdb_files;

pub use jobs::jobs;
pub use jobs::rows;
pub use jobs::stages;

use vdb_files::Random;

/// Files whose bytes are told by the request alone; others hold times.
const TIMELESS: [&str; 4] = ["exr", "vdb", "png", "toml"];
/// Code of a program that was asked to end.
const INTERRUPTED: i32 = 130;

/// Where rows of a picture are saved.
const ROWS: &str = "image.exr.parts";
/// How often it is tried to ask a command to end before it is done.
const MOST_TRIES: usize = 20;

/// Commands that are run in one folder, one after the other.
pub struct Job {
    /// What it tries.
    pub name: &'static str,
    /// Scenes by their names.
    scenes: Vec<(&'static str, String)>,
    commands: Vec<Vec<&'static str>>,
}

/// What was done to a job.
#[derive(Default)]
pub struct Tally {
    /// Kills while a command was running.
    pub killed: u32,
    /// How many of them by a signal that asks.
    pub asked: u32,
    /// How many left saved rows behind.
    pub with_rows: u32,
    /// Times that the job was done to its end.
    pub done: u32,
}

impl Job {
    fn start(&self, index: usize, folder: &Path) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_niji"));
        command.current_dir(folder).args(&self.commands[index]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// A folder with its scenes.
    fn folder(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in &self.scenes {
            fs::write(folder.path().join(name), text).unwrap();
        }
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
        // A sweep keeps its runs, so that more kills find it elsewhere.
        let rest = if self.name == "sweep" { 12 } else { 3 };
        while tally.killed < n_kills {
            let folder = self.folder();
            for (index, time) in times.iter().enumerate() {
                // Some commands are killed again and again, others not at all.
                while tally.killed < n_kills
                    && random.below(rest) > 0
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
                        tally.with_rows += u32::from(folder.path().join(ROWS).exists());
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

    /// Asks each command to end while it works, and has it done then: how long each took to end.
    pub fn ask_each(&self, seed: u64) -> Vec<(String, Duration)> {
        let (expected, times) = self.undisturbed();
        let (mut random, folder) = (Random(seed), self.folder());
        let mut asked = Vec::new();
        for (index, time) in times.iter().enumerate() {
            let command = self.commands[index].join(" ");
            let before = files(folder.path());
            let mut try_it = || {
                let child = self.start(index, folder.path());
                let quarter_us = 1 + time.as_micros() as usize / 4;
                let moment_us = quarter_us + random.below(2 * quarter_us);
                std::thread::sleep(Duration::from_micros(moment_us as u64));
                let start = Instant::now();
                if self.killed(child, Signal::SIGTERM) {
                    return Some(start.elapsed());
                }
                // It was done: from the beginning once more.
                for name in files(folder.path()).keys() {
                    if !before.contains_key(name) {
                        fs::remove_file(folder.path().join(name)).unwrap();
                    }
                }
                None
            };
            let ended = (0..MOST_TRIES).find_map(|_| try_it());
            let ended = ended.unwrap_or_else(|| panic!("niji {command}: done before it is asked"));
            self.check_unfinished(folder.path(), &expected);
            self.end(index, self.start(index, folder.path()));
            asked.push((command, ended));
        }
        self.check_done(folder.path(), &expected);
        asked
    }

    /// Kills the last command once it has saved rows, and asks it to end while it writes its image: the rows stay, and
    /// it goes on with them.
    pub fn end_with_rows(&self) {
        let (expected, _) = self.undisturbed();
        let (folder, last) = (self.folder(), self.commands.len() - 1);
        for index in 0..last {
            self.end(index, self.start(index, folder.path()));
        }
        let [image, rows] = ["image.exr", ROWS].map(|name| folder.path().join(name));
        let is_writing = || {
            let mut entries = fs::read_dir(folder.path()).into_iter().flatten().flatten();
            entries.any(|it| it.file_name().to_string_lossy().ends_with(".part"))
        };
        let n_rows = || fs::read_dir(&rows).map_or(0, Iterator::count);
        // Whether it ended with as many rows as it had, and without its image.
        let ends_when = |is_due: &dyn Fn() -> bool, signal| {
            let mut child = self.start(last, folder.path());
            while !is_due() && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_micros(200));
            }
            let before = n_rows();
            let is_ended = self.killed(child, signal) && !image.exists();
            assert!(before > 0, "{}: no rows were saved", self.name);
            assert!(
                !is_ended || n_rows() >= before,
                "{}: rows are lost",
                self.name
            );
            self.check_unfinished(folder.path(), &expected);
            is_ended
        };
        assert!(ends_when(&|| n_rows() > 0, Signal::SIGKILL));
        let is_asked = (0..MOST_TRIES).any(|_| {
            let _ = fs::remove_file(&image);
            ends_when(&is_writing, Signal::SIGTERM)
        });
        assert!(
            is_asked,
            "{}: the image is there before it is asked",
            self.name
        );
        self.end(last, self.start(last, folder.path()));
        self.check_done(folder.path(), &expected);
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
