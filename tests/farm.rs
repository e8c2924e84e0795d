//! Jobs for farms: every engine is handed the same tasks, and what is done is seen from the files.
//!
//! `tests/farm/run.sh` runs such jobs on real engines.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use support::TINY;
use support::niji;
use support::niji_ends_with;
use support::text;

const SEQUENCE: &str = "\n[sequence]\nsun.elevation_deg = [[1, 19.5], [5, 20.5]]\n";

/// A name that shells, templates and Python would all take for something else.
const NAME: &str = "-it's {{Param.Out}} \"$(exit 3)\" %a";

fn scene(folder: &Path, name: &str, more: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, TINY.to_owned() + more).unwrap();
    path
}

/// Writes a job for an engine and gives the folder of its files.
fn bundle(engine: &str, scene: &Path, out: &Path, flags: &[&str]) -> PathBuf {
    let job = [
        "farm",
        "--engine",
        engine,
        "-q",
        text(scene),
        "-o",
        text(out),
    ];
    niji_ends_with(0, &[&job[..], flags].concat());
    out.join("farm").join(engine)
}

/// The arguments of the program in every task of a step, as its batch script has them.
fn tasks_of_slurm(folder: &Path, step: &str, n_tasks: usize) -> Vec<Vec<String>> {
    // In place of the program one that tells its arguments.
    let teller = folder.join("teller");
    program(&teller, "#!/bin/sh\nprintf '%s\\n' \"$@\"\n");
    let task = |index: usize| {
        // Every second task is of a later array.
        let (first, own) = (index / 2 * 2, index % 2);
        let told = Command::new("bash")
            .arg(folder.join(format!("{step}.sbatch")))
            .arg(first.to_string())
            .env("NIJI", &teller)
            .env("SLURM_ARRAY_TASK_ID", own.to_string())
            .env("SLURM_CPUS_PER_TASK", "1")
            .output()
            .unwrap();
        assert!(
            told.status.success(),
            "{}",
            String::from_utf8_lossy(&told.stderr)
        );
        let told = String::from_utf8(told.stdout).unwrap();
        told.lines().map(str::to_owned).collect()
    };
    (0..n_tasks).map(task).collect()
}

#[test]
fn names_of_files_reach_the_program_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), &format!("{NAME}.toml"), SEQUENCE);
    let out = folder.path().join(NAME);
    let flags = [
        "--frames",
        "1-3,5",
        "--tiles",
        "4",
        "--chunk",
        "3",
        "--tolerance",
        "0.02",
    ];
    let slurm = bundle("slurm", &scene, &out, &flags);
    let tiles = tasks_of_slurm(&slurm, "tiles", 8);
    let expected = |frame: &str, tiles: &str| {
        let choice = out.join("choice.toml");
        let words = [
            "run",
            text(&scene),
            "-o",
            text(&out),
            "--tolerance",
            "0.02",
            "--frames",
            frame,
            "--tiles",
            tiles,
            "--choice",
            text(&choice),
            "--threads",
            "1",
        ];
        words.map(str::to_owned).to_vec()
    };
    for (index, frame) in ["1", "2", "3", "5"].into_iter().enumerate() {
        assert_eq!(tiles[2 * index], expected(frame, "1-3/4"));
        assert_eq!(tiles[2 * index + 1], expected(frame, "4/4"));
    }
    let merged = tasks_of_slurm(&slurm, "merge", 1);
    assert_eq!(merged, [["merge", text(&out), "--frames", "1-3,5"]]);
    // What submits is a script of bash in any case.
    let submit = Command::new("bash")
        .arg("-n")
        .arg(slurm.join("submit.sh"))
        .status();
    assert!(submit.unwrap().success());
    // Paths are no text of a template, which would take braces for its own.
    let openjd = bundle("openjd", &scene, &out, &flags);
    let json = |name: &str| -> Value {
        serde_json::from_slice(&fs::read(openjd.join(name)).unwrap()).unwrap()
    };
    let values = &json("parameter_values.json")["parameterValues"];
    assert_eq!(values[0]["value"], text(&scene));
    assert_eq!(values[1]["value"], text(&out));
    let template = json("template.json");
    assert_eq!(
        template["name"],
        format!("niji {}", NAME.replace(['{', '}'], ""))
    );
    let step = &template["steps"][1];
    let words = step["script"]["actions"]["onRun"]["args"]
        .as_array()
        .unwrap();
    let in_task = |word: &Value| {
        let word = word.as_str().unwrap().replace("{{Task.Param.Frames}}", "5");
        let word = word.replace("{{Task.Param.Tiles}}", "4");
        let word = word.replace("{{Param.Out}}", text(&out));
        word.replace("{{Param.Scene}}", text(&scene))
    };
    let words: Vec<String> = words.iter().map(in_task).collect();
    assert_eq!(words, expected("5", "4/4"));
    // A string of Python is one of JSON.
    let python = fs::read_to_string(bundle("hyperqueue", &scene, &out, &flags).join("submit.py"));
    let python = python.unwrap();
    let value = |key: &str| {
        let line = python
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{key} = ")));
        serde_json::from_str::<String>(line.unwrap()).unwrap()
    };
    assert_eq!(
        (value("SCENE"), value("OUT")),
        (text(&scene).to_owned(), text(&out).to_owned())
    );
}

/// Writes a script that can be run.
fn program(path: &Path, script: &str) {
    fs::write(path, script).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_slurm_of_small_arrays_gets_several_and_one_of_few_jobs_none() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    let bin = folder.path().join("a bin");
    fs::create_dir(&bin).unwrap();
    let submit = |name: &str, most_jobs: u32| {
        let limits = format!("#!/bin/sh\necho MaxArraySize = 3\necho MaxJobCount = {most_jobs}\n");
        program(&bin.join("scontrol"), &limits);
        // Numbers from 11 on, and what was asked.
        let told = bin.join(name);
        let sbatch = "#!/bin/bash\necho \"${@: -2:1}\" \"${@: -1}\" \"$@\" >> TOLD\necho $((10 + $(wc -l < TOLD)))\n";
        program(
            &bin.join("sbatch"),
            &sbatch.replace("TOLD", &format!("'{}'", text(&told))),
        );
        let path = format!("{}:{}", text(&bin), std::env::var("PATH").unwrap());
        let out = folder.path().join(name);
        let submitted = Command::new(env!("CARGO_BIN_EXE_niji"))
            .args([
                "farm",
                text(&scene),
                "-o",
                text(&out),
                "--frames",
                "1-12",
                "--chunk",
                "3",
            ])
            .args(["--engine", "slurm", "--submit"])
            .env("PATH", path)
            .output()
            .unwrap();
        let asked = fs::read_to_string(told).unwrap_or_default();
        let said = String::from_utf8(submitted.stderr).unwrap();
        (submitted.status.code(), asked, said)
    };
    // One job for tables, two arrays for four tasks, one that checks.
    let (code, asked, said) = submit("enough", 100);
    assert_eq!(code, Some(0), "{said}");
    let expected = [
        ("tables.sbatch 0 ", "--array=0-0", ""),
        (
            "frames.sbatch 0 ",
            "--array=0-2",
            "--dependency=afterok:11 ",
        ),
        (
            "frames.sbatch 3 ",
            "--array=0-0",
            "--dependency=afterok:11 ",
        ),
        (
            "check.sbatch 0 ",
            "--array=0-0",
            "--dependency=afterany:12:13 ",
        ),
    ];
    assert_eq!(asked.lines().count(), expected.len(), "{asked}");
    for (asked, (script, array, dependency)) in asked.lines().zip(expected) {
        for word in [script, array, dependency, "--kill-on-invalid-dep=yes"] {
            assert!(asked.contains(word), "{word} in {asked}");
        }
        assert_eq!(asked.contains("--dependency"), !dependency.is_empty());
    }
    // sbatch would wait for ever.
    let (code, asked, said) = submit("few", 6);
    assert_eq!((code, &*asked), (Some(1), ""));
    assert!(
        said.contains("MaxJobCount") && said.contains("--chunk"),
        "{said}"
    );
}

#[test]
fn frames_of_a_job_are_those_asked_for_each_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    let out = folder.path().join("out");
    let slurm = bundle(
        "slurm",
        &scene,
        &out,
        &["--frames", "1-3,7,10-20:2", "--chunk", "4"],
    );
    let tasks = tasks_of_slurm(&slurm, "frames", 3);
    let frames = tasks.iter().map(|task| {
        let flag = task.iter().position(|word| word == "--frames").unwrap();
        task[flag + 1].as_str()
    });
    assert!(frames.eq(["1-3,7", "10-16:2", "18,20"]));
}

#[test]
fn a_job_of_ten_thousand_frames_in_tiles_is_some_tens_of_kilobytes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    for engine in ["slurm", "openjd", "hyperqueue"] {
        let out = folder.path().join(engine);
        let files = bundle(
            engine,
            &scene,
            &out,
            &["--frames", "1-10000", "--tiles", "12"],
        );
        let files: Vec<_> = fs::read_dir(files).unwrap().collect();
        let bytes = files
            .iter()
            .map(|file| file.as_ref().unwrap().metadata().unwrap().len());
        let (n_files, bytes) = (files.len(), bytes.sum::<u64>());
        assert!(
            n_files <= 5 && bytes < 100_000,
            "{engine}: {n_files} files, {bytes} bytes"
        );
    }
}

/// What `niji farm status` prints and ends with.
fn status(out: &Path) -> (String, Option<i32>) {
    let told = niji(&["farm", "status", text(out), "-q"]);
    (String::from_utf8(told.stdout).unwrap(), told.status.code())
}

#[test]
fn lost_and_damaged_frames_are_named_and_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    let out = folder.path().join("out");
    bundle("slurm", &scene, &out, &["--frames", "1-5"]);
    assert_eq!(status(&out), ("1-5\n".to_owned(), Some(6)));
    let run = |frames: &str| {
        niji_ends_with(
            0,
            &[
                "run",
                text(&scene),
                "-o",
                text(&out),
                "--frames",
                frames,
                "-q",
                "--force",
            ],
        );
    };
    run("1-4");
    assert_eq!(status(&out), ("5\n".to_owned(), Some(6)));
    run("5");
    assert_eq!(status(&out), (String::new(), Some(0)));
    let image = |frame: u32| out.join(format!("image.000{frame}.exr"));
    let whole: Vec<Vec<u8>> = (1..=5)
        .map(|frame| fs::read(image(frame)).unwrap())
        .collect();
    // One is gone, one has another byte, one ends too soon; of one the preview is another picture.
    fs::remove_file(image(1)).unwrap();
    let mut damaged = whole[1].clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(image(2), damaged).unwrap();
    fs::write(image(3), &whole[2][..middle]).unwrap();
    fs::copy(out.join("image.0005.png"), out.join("image.0004.png")).unwrap();
    assert_eq!(status(&out), ("1-4\n".to_owned(), Some(6)));
    let told = niji_ends_with(6, &["farm", "status", text(&out), "--json"]);
    let told: Value = serde_json::from_slice(&told.stdout).unwrap();
    let frames = &told["frames"];
    assert_eq!(
        (&frames["done"], &frames["missing"], &frames["damaged"]),
        (&1.into(), &"1".into(), &"2-4".into())
    );
    run("1-4");
    assert_eq!(status(&out), (String::new(), Some(0)));
    let again: Vec<Vec<u8>> = (1..=5)
        .map(|frame| fs::read(image(frame)).unwrap())
        .collect();
    assert!(again == whole);
}

#[test]
fn a_folder_counts_the_frames_of_all_its_jobs_and_takes_no_other_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (
        scene(folder.path(), "one.toml", SEQUENCE),
        scene(folder.path(), "other.toml", SEQUENCE),
    );
    let out = folder.path().join("out");
    bundle("slurm", &one, &out, &["--frames", "1-3"]);
    bundle("openjd", &one, &out, &["--frames", "3-5:2,9", "--force"]);
    assert_eq!(status(&out).0, "1-3,5,9\n");
    let job = [
        "farm",
        text(&other),
        "-o",
        text(&out),
        "--engine",
        "slurm",
        "--frames",
        "1",
    ];
    let refused = niji_ends_with(2, &job);
    let refused = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.contains("job.json is of another job"), "{refused}");
    niji_ends_with(0, &[&job[..], &["--force"]].concat());
    assert_eq!(status(&out).0, "1\n");
    niji_ends_with(3, &["farm", "status", text(folder.path())]);
}

#[test]
fn tiles_of_a_run_become_the_pictures_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    let [one, out] = ["one", "out"].map(|name| folder.path().join(name));
    let run = |out: &Path, flags: &[&str]| {
        let run = [
            "run",
            text(&scene),
            "-o",
            text(out),
            "--frames",
            "2-3",
            "-q",
        ];
        niji_ends_with(0, &[&run[..], flags].concat());
    };
    run(&one, &[]);
    bundle("slurm", &scene, &out, &["--frames", "2-3", "--tiles", "4"]);
    run(&out, &["--tiles", "1,3-4/4"]);
    let told = niji_ends_with(6, &["farm", "status", text(&out)]);
    let told = String::from_utf8(told.stderr).unwrap();
    assert!(
        told.contains("frame 3, tiles: 3 of 4 done, 1 missing (2)"),
        "{told}"
    );
    niji_ends_with(2, &["merge", text(&out), "--frames", "2-3"]);
    run(&out, &["--tiles", "2/4"]);
    niji_ends_with(0, &["merge", text(&out), "--frames", "2-3", "-q"]);
    assert_eq!(status(&out), (String::new(), Some(0)));
    for frame in [2, 3] {
        for end in ["exr", "layers.exr", "png"] {
            let name = format!("image.000{frame}.{end}");
            assert!(
                fs::read(out.join(&name)).unwrap() == fs::read(one.join(&name)).unwrap(),
                "{name}"
            );
        }
    }
    // A run finds them up to date.
    run(&out, &[]);
}

#[test]
fn steps_and_needs_are_shown_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "scene.toml", SEQUENCE);
    let out = folder.path().join("out");
    let shown = |flags: &[&str]| -> Value {
        let job = [
            "farm",
            text(&scene),
            "-o",
            text(&out),
            "--frames",
            "1-240",
            "--dry-run",
            "--json",
        ];
        let told = niji_ends_with(0, &[&job[..], flags].concat());
        serde_json::from_slice(&told.stdout).unwrap()
    };
    let names = |shown: &Value| -> BTreeSet<String> {
        let steps = shown["steps"].as_array().unwrap().iter();
        steps
            .map(|step| step["name"].as_str().unwrap().to_owned())
            .collect()
    };
    let frames = shown(&["--threads", "3", "--memory", "5GiB"]);
    assert_eq!(
        names(&frames),
        BTreeSet::from(["tables", "frames", "check"].map(str::to_owned))
    );
    assert_eq!(
        (&frames["needs"]["threads"], &frames["needs"]["memory_mib"]),
        (&3.into(), &5120.into())
    );
    assert_eq!(frames["chunk"]["most"], 10);
    // A task that takes the memory of three threads asks for three.
    assert_eq!(shown(&["--memory", "5GiB"])["needs"]["threads"], 3);
    assert!(!out.exists());
    // The slowest frame that was made before took 40 s: fifteen of them in ten minutes.
    fs::create_dir(&out).unwrap();
    let stage = |stage: &str, seconds: f64| {
        format!(r#"{{"stage":"{stage}","up_to_date":false,"seconds":{seconds}}}"#)
    };
    for (frame, seconds) in [(3, 40.0), (4, 25.0)] {
        let stages = [stage("scatter", 500.0), stage("render", seconds)].join(",");
        let report = format!(
            r#"{{"version":"","command":[],"seconds":0,"frames":[{{"stages":[{stages}]}}]}}"#
        );
        fs::write(out.join(format!("report.{frame:04}.json")), report).unwrap();
    }
    assert_eq!(shown(&[])["chunk"]["most"], 15);
    assert_eq!(shown(&["--chunk", "7"])["chunk"]["most"], 7);
    // What a scene is refused for is told before it is handed out.
    let tiles = niji(&[
        "farm",
        text(&scene),
        "-o",
        text(&out),
        "--frames",
        "1",
        "--tiles",
        "13",
        "--dry-run",
    ]);
    assert_eq!(tiles.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&tiles.stderr).contains("13 tiles of 12 rows"));
}
