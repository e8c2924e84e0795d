//! Outputs that somebody or something changed.

use std::fs;
use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::support::niji_ends_with;
use crate::support::text;
use crate::world::AIR;
use crate::world::PHOTO;
use crate::world::PICKS;
use crate::world::SCENE;
use crate::world::SHAPE;
use crate::world::SUN;
use crate::world::World;
use crate::world::change;
use crate::world::files;
use crate::world::run;

/// Changes an output; the second path is another output of the run.
type Damage = fn(&Path, &Path);

/// Ways in which an output changes.
const DAMAGES: [(&str, Damage); 5] = [
    ("a byte", |path, _| {
        let mut bytes = fs::read(path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        // In place: the inode stays.
        fs::write(path, bytes).unwrap();
    }),
    ("cut short", |path, _| {
        let file = File::options().write(true).open(path).unwrap();
        file.set_len(file.metadata().unwrap().len() - 1).unwrap();
    }),
    ("emptied", |path, _| fs::write(path, "").unwrap()),
    ("replaced", |path, other| {
        let copy = path.with_extension("copy");
        fs::copy(other, &copy).unwrap();
        fs::rename(copy, path).unwrap();
    }),
    ("swapped", |path, other| {
        let between = path.with_extension("between");
        fs::rename(path, &between).unwrap();
        fs::rename(other, path).unwrap();
        fs::rename(between, other).unwrap();
    }),
];

/// Kinds of damage that each output meets; neighbors meet others.
const N_KINDS: usize = 2;

/// Until files are so old that no later change of them can look the same.
fn wait() {
    std::thread::sleep(Duration::from_millis(3100));
}

#[test]
fn outputs_that_were_damaged_are_made_again() {
    let world = World::with_inputs();
    let scene = SCENE.replace("[effects]", "[effects]\nsunlight_through_air = \"on\"");
    let scene = world.scene("s.toml", &[&scene, SHAPE, PHOTO, PICKS, AIR]);
    let fresh = world.path("fresh");
    run(&scene, &fresh);
    let expected = files(&fresh);
    let names: Vec<&String> = expected.keys().filter(|it| *it != "choice.toml").collect();
    assert_eq!(names.len(), 13, "{names:?}");
    let out = |name: &str| world.path(&format!("out {name}"));
    for name in &names {
        let copied = Command::new("cp")
            .arg("-r")
            .arg(&fresh)
            .arg(out(name))
            .status();
        assert!(copied.unwrap().success());
    }
    wait();
    let check = |index: usize| {
        let (name, out) = (names[index], out(names[index]));
        let other = out.join(names[(index + 1) % names.len()]);
        let said = run(&scene, &out);
        assert!(said.contains("everything is up to date"), "{said}");
        let note = fs::read_to_string(out.join(format!(".niji/{name}.json"))).unwrap();
        assert!(
            note.contains("inode"),
            "its look is enough from now on: {note}"
        );
        // The first kind meets a file that is known by its look, the others one that is too new for that.
        for (kind, damage) in (0..N_KINDS).map(|it| DAMAGES[(index + it) % DAMAGES.len()]) {
            change(&out.join(name), |path| damage(path, &other));
            let said = run(&scene, &out);
            assert!(
                !said.contains(&format!("{name} is up to date")),
                "{name} {kind}: {said}"
            );
            assert!(files(&out) == expected, "{name} {kind}: {said}");
        }
    };
    let (even, odd): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(|it| it % 2 == 0);
    std::thread::scope(|threads| {
        threads.spawn(|| even.into_iter().for_each(check));
        odd.into_iter().for_each(check);
    });
}

#[test]
fn neither_looks_nor_notes_hide_a_change_when_outputs_are_verified() {
    let world = World::new();
    let scene = world.scene("s.toml", &[SCENE, SUN, SHAPE]);
    let out = world.path("out");
    run(&scene, &out);
    let expected = files(&out);
    let (image, note) = (out.join("image.png"), out.join(".niji/image.png.json"));
    wait();
    run(&scene, &out);
    let damage = || change(&image, |path| DAMAGES[0].1(path, path));
    // As if a disk had changed a byte by itself.
    damage();
    let known = fs::read(&note).unwrap();
    let mut fitting: serde_json::Value = serde_json::from_slice(&known).unwrap();
    let found = fs::metadata(&image).unwrap();
    fitting["seen"]["changed_s"] = found.ctime().into();
    fitting["seen"]["changed_ns"] = found.ctime_nsec().into();
    fs::write(&note, fitting.to_string()).unwrap();
    let run = ["run", text(&scene), "-o", text(&out), "--force"];
    niji_ends_with(0, &run);
    assert!(
        files(&out) != expected,
        "the note is of a file that looks so"
    );
    niji_ends_with(0, &[&run[..], &["--verify"]].concat());
    assert!(files(&out) == expected);
    // Notes that are damaged, of another file, too long, or of this file before.
    let other = fs::read(out.join(".niji/image.exr.json")).unwrap();
    for found in [
        b"".to_vec(),
        b"{".to_vec(),
        b"null".to_vec(),
        other,
        vec![b' '; 9999],
        known,
    ] {
        damage();
        fs::write(&note, &found).unwrap();
        niji_ends_with(0, &run);
        assert!(
            files(&out) == expected,
            "{}",
            String::from_utf8_lossy(&found)
        );
    }
    fs::remove_dir_all(out.join(".niji")).unwrap();
    damage();
    niji_ends_with(0, &run);
    assert!(files(&out) == expected);
}
