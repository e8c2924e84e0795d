//! Nothing breaks it: streams that end, names that are no text, files of others, results that are stale.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "support/mutations.rs"]
mod mutations;
mod support;

use std::ffi::OsStr;
use std::fs;
use std::fs::File;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use std::process::Output;
use std::process::Stdio;

use support::TINY;
use support::niji_ends_with;
use support::text;

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_niji"))
}

/// Runs the program with arguments that need not be text, in a folder.
fn in_folder(folder: &Path, arguments: &[&OsStr]) -> Output {
    let output = program().current_dir(folder).args(arguments).output();
    output.expect("the program starts")
}

fn scene_in(folder: &Path, name: &OsStr) {
    fs::write(folder.join(name), TINY).unwrap();
}

#[test]
fn readers_that_stop_and_disks_that_are_full_end_it_quietly() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path(), OsStr::new("s.toml"));
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let code = |arguments: &[&str], out: Stdio, err: Stdio| {
        let mut command = program();
        command.current_dir(folder.path()).args(arguments);
        let status = command.stdout(out).stderr(err).status();
        status.expect("the program starts").code()
    };
    for arguments in [
        &["completions", "bash"][..],
        &["plan", "s.toml"],
        &["--help"],
        &["run", "s.toml", "-o", "out", "-q"],
    ] {
        assert_eq!(
            code(arguments, full().into(), Stdio::null()),
            Some(1),
            "{arguments:?}"
        );
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(
            code(arguments, writer.into(), Stdio::null()),
            Some(0),
            "{arguments:?}"
        );
    }
    for (arguments, expected) in [
        (&["plan", "missing.toml"][..], 3),
        (&["frobnicate"], 2),
        (&["run", "s.toml", "-o", "out"], 0),
    ] {
        assert_eq!(
            code(arguments, Stdio::null(), full().into()),
            Some(expected),
            "{arguments:?}"
        );
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(
            code(arguments, Stdio::null(), writer.into()),
            Some(expected),
            "{arguments:?}"
        );
    }
}

#[test]
fn pipes_devices_and_links_are_no_outputs_even_with_force() {
    let folder = tempfile::tempdir().unwrap();
    let (pipe, link) = (
        folder.path().join("pipe.exr"),
        folder.path().join("link.exr"),
    );
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let target = folder.path().join("target");
    fs::write(&target, "kept").unwrap();
    symlink(&target, &link).unwrap();
    scene_in(folder.path(), OsStr::new("s.toml"));
    let scene = folder.path().join("s.toml");
    for path in [&pipe, &link, Path::new("/dev/null")] {
        for arguments in [&["airy"][..], &["plan", text(&scene)]] {
            let arguments = [arguments, &["-o", text(path), "--force"]].concat();
            niji_ends_with(2, &arguments);
        }
    }
    for name in ["choice.toml", "report.json", "image.exr"] {
        let out = folder.path().join("out");
        fs::create_dir(&out).unwrap();
        fs::rename(&pipe, out.join(name)).unwrap();
        niji_ends_with(2, &["run", text(&scene), "-o", text(&out), "--force"]);
        fs::rename(out.join(name), &pipe).unwrap();
        fs::remove_dir_all(out).unwrap();
    }
    assert_eq!(fs::read_to_string(&link).unwrap(), "kept");
}

#[test]
fn pipes_are_no_inputs_that_are_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.vdb", "a.exr", "a.png", "a.obj"] {
        let pipe = folder.path().join(name);
        assert!(
            Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let out = folder.path().join("out.exr");
        let scene = folder.path().join("s.toml");
        let mesh = format!("{TINY}\n[[occluders.meshes]]\nfile = \"{name}\"\n");
        fs::write(&scene, mesh).unwrap();
        niji_ends_with(3, &["info", text(&pipe)]);
        niji_ends_with(
            3,
            &["depth", text(&pipe), "--fov-deg", "60", "-o", text(&out)],
        );
        niji_ends_with(3, &["run", text(&scene), "-o", text(folder.path()), "-q"]);
    }
}

#[test]
fn names_that_are_no_text_or_look_like_flags_are_names() {
    for (scene, out) in [
        (&b"s\xfe.toml"[..], &b"out\xfd"[..]),
        (b"-s.toml", b"-out"),
        (b"it's $HOME.toml", b"o"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (scene, out) = (OsStr::from_bytes(scene), OsStr::from_bytes(out));
        scene_in(folder.path(), scene);
        let to = [OsStr::new("--output="), out].map(OsStr::as_bytes).concat();
        let [dashes, plan, script] = ["--", "plan", "--script"].map(OsStr::new);
        let chain = [plan, script, OsStr::from_bytes(&to), dashes, scene];
        let chain = in_folder(folder.path(), &chain).stdout;
        let program = Path::new(env!("CARGO_BIN_EXE_niji")).parent().unwrap();
        let shell = Command::new("sh")
            .arg("-c")
            .arg(OsStr::from_bytes(&chain))
            .env("PATH", format!("{}:/usr/bin:/bin", program.display()))
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&shell.stderr);
        assert!(shell.status.success(), "{said}");
        // A run over the chain's files finds them up to date, and writes its report.
        let run = [OsStr::new("run"), OsStr::from_bytes(&to), dashes, scene];
        let run = in_folder(folder.path(), &run);
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(said.contains("everything is up to date"), "{said}");
        assert!(folder.path().join(out).join("report.json").is_file());
    }
}

#[test]
fn a_scene_without_end_is_refused() {
    let output = niji_ends_with(3, &["plan", "/dev/zero"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("16 MiB"), "{said}");
}

#[test]
fn files_of_others_are_neither_replaced_nor_removed() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path(), OsStr::new("s.toml"));
    let (scene, out) = (folder.path().join("s.toml"), folder.path().join("out"));
    let rows = out.join("image.exr.parts");
    fs::create_dir_all(&rows).unwrap();
    let others = [
        out.join(".niji-abc123.part"),
        rows.join("rows-mine.exr"),
        rows.join(".niji-abc123.part"),
        out.join("report.json"),
    ];
    for path in &others {
        fs::write(path, r#"{"mine": 1}"#).unwrap();
    }
    let run = ["run", text(&scene), "-o", text(&out), "-q"];
    niji_ends_with(2, &run);
    assert!(
        !out.join("image.exr").exists(),
        "nothing is run before it is refused"
    );
    fs::remove_file(&others[3]).unwrap();
    niji_ends_with(0, &run);
    // Its own report is written anew.
    niji_ends_with(0, &run);
    for path in &others[..3] {
        assert!(
            fs::read_to_string(path).unwrap().contains("mine"),
            "{}",
            path.display()
        );
    }
}

#[test]
fn a_picture_is_out_of_date_when_the_buffer_behind_its_mesh_changes() {
    let folder = tempfile::tempdir().unwrap();
    let corners = [[-5.0_f32, 0.0, -40.0], [5.0, 0.0, -40.0], [0.0, 9.0, -40.0]];
    let corners = corners.iter().flatten().flat_map(|it| it.to_le_bytes());
    let mut buffer: Vec<u8> = corners.collect();
    let place = folder.path().join("a.bin");
    fs::write(&place, &buffer).unwrap();
    let mesh = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": "a.bin", "byteLength": 36}]}"#;
    fs::write(folder.path().join("a.gltf"), mesh).unwrap();
    let scene = folder.path().join("s.toml");
    fs::write(
        &scene,
        format!("{TINY}\n[[occluders.meshes]]\nfile = \"a.gltf\"\n"),
    )
    .unwrap();
    let out = folder.path().join("out");
    let run = ["run", text(&scene), "-o", text(&out)];
    niji_ends_with(0, &run);
    let said = String::from_utf8(niji_ends_with(0, &run).stderr).unwrap();
    assert!(said.contains("everything is up to date"), "{said}");
    // The same length, at the same place, in the same second.
    buffer[..4].copy_from_slice(&(-4.0_f32).to_le_bytes());
    fs::write(&place, &buffer).unwrap();
    let said = String::from_utf8(niji_ends_with(0, &run).stderr).unwrap();
    assert!(!said.contains("image.exr is up to date"), "{said}");
    fs::remove_file(place).unwrap();
    niji_ends_with(3, &run);
}

#[test]
fn files_and_pictures_take_no_more_memory_than_they_may() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path(), OsStr::new("s.toml"));
    let place = |name: &str| text(&folder.path().join(name)).to_owned();
    let (scene, out) = (place("s.toml"), place("out"));
    niji_ends_with(0, &["run", &scene, "-o", &out, "-q", "--memory", "0.5 GiB"]);
    let large = TINY
        .replace("_px = 16", "_px = 1600")
        .replace("_px = 12", "_px = 1200");
    fs::write(place("large.toml"), large).unwrap();
    let fine = TINY.replace("voxel_m = 100.0", "voxel_m = 4.0");
    fs::write(place("fine.toml"), fine).unwrap();
    fs::write(
        place("a.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n",
    )
    .unwrap();
    let ice = fs::read_to_string(support::repository("data/scenes/ice-cube-0.1-m.toml")).unwrap();
    let ice = ice.replace(
        "shape = \"cube\"\nedge_m = 0.1",
        "shape = \"mesh\"\nfile = \"a.obj\"",
    );
    fs::write(place("ice.toml"), ice).unwrap();
    let (image, drops) = (place("out/image.exr"), place("out/drops.vdb"));
    let photo = text(&support::repository("data/photos/pavilion.jpg")).to_owned();
    let (to, ice, large) = (place("to.exr"), place("ice.toml"), place("large.toml"));
    let fine = place("fine.toml");
    for (code, limit, arguments) in [
        (1, "20 MiB", &["run", &large, "-o", &out][..]),
        // Before anything is laid out.
        (3, "100 MiB", &["plan", &fine]),
        (3, "10 KiB", &["diff", &image, &image]),
        (3, "0.01 MiB", &["info", &drops]),
        (
            3,
            "1.5 MiB",
            &["depth", &photo, "--fov-deg", "60", "-o", &to],
        ),
        (3, "32 bytes", &["ice", &ice, "-o", &to]),
    ] {
        let memory = match limit {
            "0.01 MiB" => "10KiB",
            "32 bytes" => "0.125KiB",
            limit => limit,
        };
        let said = niji_ends_with(code, &[arguments, &["--memory", memory]].concat()).stderr;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains(limit), "{limit}: {said}");
    }
    for size in ["4", "4GB", "-1GiB", "much"] {
        niji_ends_with(2, &["plan", &scene, &format!("--memory={size}")]);
    }
}

#[test]
fn any_file_as_a_depth_map_plate_matte_or_labels_is_taken_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path(), OsStr::new("s.toml"));
    let place = |name: &str| text(&folder.path().join(name)).to_owned();
    let (out, to) = (place("out"), place("to.exr"));
    niji_ends_with(0, &["run", &place("s.toml"), "-o", &out, "-q"]);
    let [image, plate, photo] =
        ["image.exr", "image.layers.exr", "image.png"].map(|name| place(&format!("out/{name}")));
    let kinds = mutations::readers();
    let mut files: Vec<(&str, Vec<u8>)> =
        vec![("empty.png", Vec::new()), ("empty.exr", Vec::new())];
    files.extend(
        kinds
            .iter()
            .map(|kind| (kind.file, kind.samples[0].clone())),
    );
    files.extend(kinds.iter().map(|kind| (kind.file, kind.mutated(1))));
    // A picture of 16384 x 16384 pixels in some hundred bytes.
    let mut bomb = fs::read(&photo).unwrap();
    bomb[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    mutations::mend_checksums(&mut bomb);
    files.push(("bomb.png", bomb));
    for (name, bytes) in &files {
        let file = place(name);
        fs::write(&file, bytes).unwrap();
        for used in [
            &[
                "depth",
                &photo,
                "--fov-deg",
                "60",
                "--kind",
                "metres",
                "--map",
                &file,
            ][..],
            &[
                "depth",
                &photo,
                "--fov-deg",
                "60",
                "--layers",
                &file,
                "--labels",
                &file,
            ],
            &["composite", &file, "--image", &image],
            &["composite", &plate, "--image", &image, "--depth", &file],
        ] {
            let output = support::niji(&[used, &["-o", &to, "-q", "--force"]].concat());
            let (code, said) = (
                output.status.code(),
                String::from_utf8_lossy(&output.stderr),
            );
            assert!(
                matches!(code, Some(0 | 2 | 3)),
                "{used:?}: {code:?}: {said}"
            );
            assert_eq!(
                code == Some(0),
                !said.contains("error: "),
                "{used:?}: {said}"
            );
        }
    }
}
