//! The program itself.

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

use crate::build::identity;
use crate::build::sources;
use crate::support::niji_ends_with;
use crate::support::text;
use crate::world::SCENE;
use crate::world::SHAPE;
use crate::world::SUN;
use crate::world::World;
use crate::world::run;

/// The program as other sources would have made it: with another digit in its version.
fn other_program(path: PathBuf) -> PathBuf {
    let version = env!("NIJI_VERSION").as_bytes();
    let mut program = fs::read(env!("CARGO_BIN_EXE_niji")).unwrap();
    let mut at = 0;
    while let Some(found) = program[at..]
        .windows(version.len())
        .position(|it| it == version)
    {
        at += found + version.len();
        let last = &mut program[at - 1];
        *last = if *last == b'0' { b'1' } else { b'0' };
    }
    // Which may be run.
    fs::copy(env!("CARGO_BIN_EXE_niji"), &path).unwrap();
    fs::write(&path, program).unwrap();
    path
}

#[test]
fn results_of_another_program_are_not_up_to_date() {
    let world = World::new();
    let scene = world.scene("s.toml", &[SCENE, SUN, SHAPE]);
    let (out, program) = (world.path("out"), other_program(world.path("niji")));
    run(&scene, &out);
    let other = || {
        let arguments = ["run", text(&scene), "-o", text(&out), "--force"];
        let output = Command::new(&program).args(arguments).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(!other().contains("up to date"));
    assert!(other().contains("everything is up to date"));
    assert!(!run(&scene, &out).contains("up to date"));
}

#[test]
fn a_choice_of_another_program_is_refused_with_both_versions() {
    let world = World::new();
    let scene = world.scene("s.toml", &[SCENE, SUN, SHAPE]);
    let (choice, program) = (world.path("choice.toml"), other_program(world.path("niji")));
    let plan = ["plan", text(&scene), "-o", text(&choice)];
    assert!(Command::new(program).args(plan).status().unwrap().success());
    let found: toml::Table = fs::read_to_string(&choice).unwrap().parse().unwrap();
    let (other, own) = (found["version"].as_str().unwrap(), env!("NIJI_VERSION"));
    assert_ne!(other, own);
    let out = world.path("out");
    let run = [
        "run",
        text(&scene),
        "-o",
        text(&out),
        "--choice",
        text(&choice),
    ];
    let refused = niji_ends_with(2, &run);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains(other) && said.contains(own), "{said}");
}

#[test]
fn what_a_program_is_built_from_is_told_by_its_sources_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = identity(root);
    assert!(env!("NIJI_VERSION").ends_with(&format!("+{own:016x}")));
    let folder = tempfile::tempdir().unwrap();
    for name in sources(root) {
        let to = folder.path().join(&name);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(root.join(name), to).unwrap();
    }
    assert_eq!(identity(folder.path()), own);
    for name in [
        "Cargo.lock",
        "tools/main.rs",
        "crates/airy/src/airy.rs",
        "data/cie_1931_2deg.csv",
    ] {
        let path = folder.path().join(name);
        let kept = fs::read(&path).unwrap();
        fs::write(&path, [&kept[..], b"\n"].concat()).unwrap();
        assert_ne!(identity(folder.path()), own, "{name}");
        fs::write(&path, kept).unwrap();
    }
    fs::write(folder.path().join("tools/new.rs"), "").unwrap();
    assert_ne!(identity(folder.path()), own);
}
