//! Disks that are full, have no names left or may not be written: told, and nothing is lost or half-written.
//!
//! Where the system lets a process mount, disks of little room are mounted for it alone; files that may not grow
//! long, which needs no right, stand for them everywhere.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;
use std::process::Output;
use std::process::Stdio;

use support::TINY;
use support::niji_ends_with;
use support::repository;
use support::text;

/// Sizes that are tried of each kind of disk.
const N_SIZES: u64 = 20;
/// Every so many small disks the run goes on where there is room.
const MENDED: u64 = 4;
/// Names that a disk has at least: its own, and the folder of the run.
const FEWEST_NAMES: u64 = 2;
/// Bytes of a block of `ulimit -f`.
const BLOCK: u64 = 512;
/// A command whose files may have so many blocks: writing on is an error, not the end.
const SHORT_FILES: &str = r#"trap '' XFSZ; ulimit -f "$1"; shift; exec "$@""#;
/// A command on a disk of so many bytes and names; what it left stands in `kept`.
const SMALL_DISK: &str = r#"
mount -t tmpfs -o "size=$1,nr_inodes=$2" none disk || exit 98
shift 2
"$@"; code=$?
mkdir kept && cp disk/out/* disk/out/.niji* kept 2>/dev/null
exit $code"#;
/// A command on a disk that may not be written.
const READ_ONLY: &str = "mount -t tmpfs -o ro none disk || exit 98; exec \"$@\"";
const RUN: [&str; 5] = ["run", "s.toml", "-q", "-o", "disk/out"];

/// Files that may not be longer.
fn with_short_files(folder: &Path, most_bytes: u64, arguments: &[&str]) -> Output {
    let blocks = (most_bytes / BLOCK).to_string();
    let start = ["-c", SHORT_FILES, "sh", &blocks, env!("CARGO_BIN_EXE_niji")];
    let mut shell = Command::new("sh");
    shell.current_dir(folder).args(start).args(arguments);
    shell.output().unwrap()
}

/// Runs a script that mounts, where nobody else sees it; `None` where the system does not let it.
fn with_mounts(folder: &Path, script: &str, arguments: &[&str]) -> Option<Output> {
    // As root, or as whoever may be root in a namespace of users.
    ["-m", "-rm"].into_iter().find_map(|flag| {
        let mut shell = Command::new("unshare");
        shell
            .current_dir(folder)
            .args([flag, "sh", "-c", script, "sh"]);
        let output = shell.args(arguments).output().ok()?;
        let said = String::from_utf8_lossy(&output.stderr);
        let is_mounted = output.status.code() != Some(98) && !said.contains("unshare failed");
        is_mounted.then_some(output)
    })
}

/// A folder with a scene and a place for a disk.
fn folder_with(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("disk")).unwrap();
    fs::write(folder.path().join("s.toml"), scene).unwrap();
    folder
}

/// The files of a run; the report holds times. Records of when they were read may be missing.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let paths = entries.map(|entry| entry.unwrap().path());
    let file = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let bytes = if name == "report.json" {
            Vec::new()
        } else {
            fs::read(path).unwrap()
        };
        (name, bytes)
    };
    paths.filter(|path| path.is_file()).map(file).collect()
}

/// What an undisturbed run leaves.
fn expected(scene: &str) -> BTreeMap<String, Vec<u8>> {
    let folder = folder_with(scene);
    let (scene, out) = (folder.path().join("s.toml"), folder.path().join("out"));
    niji_ends_with(0, &["run", text(&scene), "-q", "-o", text(&out)]);
    files(&out)
}

/// Holds what a run on a full disk said and left to what it should.
fn check(output: &Output, kept: &Path, expected: &BTreeMap<String, Vec<u8>>, what: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    let found = files(kept);
    for (name, bytes) in &found {
        assert!(expected.get(name) == Some(bytes), "{what}: {name}");
    }
    match output.status.code() {
        Some(0) => assert_eq!(found.len(), expected.len(), "{what}"),
        Some(1) => assert!(
            said.contains("error: cannot write disk/out/"),
            "{what}: {said}"
        ),
        other => panic!("{what}: {other:?}: {said}"),
    }
}

/// Runs on where there is room.
fn mend(scene: &Path, kept: &Path, expected: &BTreeMap<String, Vec<u8>>) {
    niji_ends_with(0, &["run", text(scene), "-q", "-o", text(kept)]);
    assert!(files(kept) == *expected, "{}", kept.display());
}

#[test]
fn a_full_disk_is_told_and_what_is_there_is_whole() {
    let expected = expected(TINY);
    let n_bytes: usize = expected.values().map(Vec::len).sum();
    let longest = expected.values().map(Vec::len).max().unwrap();
    let mut n_mounted = 0;
    for step in 0..N_SIZES {
        // The last has room for all.
        let size = (2 * n_bytes as u64 * step / (N_SIZES - 1))
            .max(1)
            .to_string();
        // Two names more at a time are soon enough for all.
        let disks = [(&*size, 1000), ("64m", FEWEST_NAMES + 2 * step)];
        for (size, names) in disks.into_iter().take(if step < 5 { 2 } else { 1 }) {
            let folder = folder_with(TINY);
            let names = names.to_string();
            let arguments = [&[size, &names, env!("CARGO_BIN_EXE_niji")], &RUN[..]].concat();
            let Some(output) = with_mounts(folder.path(), SMALL_DISK, &arguments) else {
                continue;
            };
            n_mounted += 1;
            let what = format!("{size} bytes, {names} names");
            let kept = folder.path().join("kept");
            check(&output, &kept, &expected, &what);
            if step % MENDED == 0 {
                mend(&folder.path().join("s.toml"), &kept, &expected);
            }
        }
    }
    // All kinds of disks in turn cost time: where there are small ones, a few short files will do.
    let n_sizes = if n_mounted > 0 { 4 } else { N_SIZES };
    for step in 0..n_sizes {
        let most_bytes = longest as u64 * step / (n_sizes - 1) + BLOCK;
        let folder = folder_with(TINY);
        let output = with_short_files(folder.path(), most_bytes, &RUN);
        let (out, what) = (
            folder.path().join("disk/out"),
            format!("files of {most_bytes}"),
        );
        check(&output, &out, &expected, &what);
        mend(&folder.path().join("s.toml"), &out, &expected);
    }
}

#[test]
fn a_full_disk_leaves_what_was_to_be_replaced() {
    let brighter = TINY.replace("elevation_deg = 20.0", "elevation_deg = 21.0");
    let (old, new) = (expected(TINY), expected(&brighter));
    for most_bytes in [0, 3 * BLOCK, 6 * BLOCK] {
        let folder = folder_with(&brighter);
        let out = folder.path().join("disk/out");
        fs::create_dir(&out).unwrap();
        for (name, bytes) in &old {
            fs::write(out.join(name), bytes).unwrap();
        }
        fs::remove_file(out.join("report.json")).unwrap();
        let arguments = [&RUN[..], &["--force"]].concat();
        let output = with_short_files(folder.path(), most_bytes, &arguments);
        assert_eq!(output.status.code(), Some(1), "{most_bytes}");
        for (name, bytes) in files(&out) {
            let is_whole = old[&name] == bytes || new[&name] == bytes;
            assert!(is_whole, "{most_bytes}: {name}");
        }
    }
}

#[test]
fn every_command_that_writes_a_file_tells_that_it_cannot() {
    let folder = folder_with(TINY);
    let ice = repository("data/scenes/ice-cube-0.1-m.toml");
    let ice = fs::read_to_string(ice).unwrap();
    let ice = ice
        .replace("_px = 640", "_px = 8")
        .replace("_px = 480", "_px = 6");
    fs::write(folder.path().join("ice.toml"), ice).unwrap();
    let photo = repository("data/photos/pavilion.jpg");
    for command in [
        "drops --scene s.toml -o a.vdb",
        "airy -o a.exr",
        "plan s.toml -o a.toml",
        "ice ice.toml -o a.exr",
        "lee --size-px 16,16 -o a.exr",
        "depth PHOTO --fov-deg 60 -o a.exr",
        "sweep s.toml -o out",
    ] {
        let words = command.split(' ');
        let words: Vec<_> = words
            .map(|word| if word == "PHOTO" { text(&photo) } else { word })
            .collect();
        let output = with_short_files(folder.path(), 0, &words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command}: {said}");
        assert!(said.contains("error: cannot write "), "{command}: {said}");
        let left = files_below(folder.path());
        assert_eq!(left, ["ice.toml", "s.toml"], "{command}");
    }
}

/// Names of the files in a folder and its folders.
fn files_below(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = entries
        .flat_map(|path| {
            if path.is_dir() {
                return files_below(&path);
            }
            vec![path.file_name().unwrap().to_str().unwrap().to_owned()]
        })
        .collect();
    names.sort();
    names
}

#[test]
fn a_folder_that_may_not_be_written_is_told() {
    let folder = folder_with(TINY);
    // Nobody makes a folder in /proc, not even root.
    let scene = folder.path().join("s.toml");
    let output = niji_ends_with(1, &["run", text(&scene), "-q", "-o", "/proc/niji"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("error: cannot write /proc/niji/"), "{said}");
    let arguments = [&[env!("CARGO_BIN_EXE_niji")], &RUN[..]].concat();
    if let Some(output) = with_mounts(folder.path(), READ_ONLY, &arguments) {
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("error: cannot write disk/out/"), "{said}");
    }
}

#[test]
fn a_folder_that_is_removed_meanwhile_is_told_or_made_again() {
    let expected = expected(TINY);
    for awaited in ["drops.vdb", "scatter.exr", "image.png"] {
        let folder = folder_with(TINY);
        let out = folder.path().join("disk/out");
        let mut run = Command::new(env!("CARGO_BIN_EXE_niji"));
        run.current_dir(folder.path()).args(RUN);
        let mut child = run
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        while !out.join(awaited).exists() && child.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        // A file may come while others go.
        while fs::remove_dir_all(&out).is_err() && out.exists() {}
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        match output.status.code() {
            Some(0) => (),
            Some(1 | 3) => assert!(said.contains("disk/out/"), "{awaited}: {said}"),
            other => panic!("{awaited}: {other:?}: {said}"),
        }
        for (name, bytes) in files(&out) {
            assert!(expected.get(&name) == Some(&bytes), "{awaited}: {name}");
        }
        mend(&folder.path().join("s.toml"), &out, &expected);
    }
}
