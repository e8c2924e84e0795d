//! What was decided for a scene serves the next command that plans it, and only as it was decided.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::text_hash;
use support::TINY;
use support::niji_ends_with;
use support::text;

fn planned(scene: &Path, cache: &Path) -> String {
    let arguments = ["plan", text(scene), "--cache", text(cache)];
    String::from_utf8(niji_ends_with(0, &arguments).stdout).unwrap()
}

fn kept(cache: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(cache.join("choices"));
    let mut kept: Vec<PathBuf> = entries
        .into_iter()
        .flatten()
        .map(|it| it.unwrap().path())
        .collect();
    kept.sort();
    kept
}

#[test]
fn the_next_command_decides_as_the_first_and_measures_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (scene, cache) = (at("scene.toml"), at("cache"));
    fs::write(&scene, TINY).unwrap();
    let first = planned(&scene, &cache);
    let [file] = &kept(&cache)[..] else {
        panic!("one scene, one file");
    };
    let choice = fs::read_to_string(file).unwrap();
    assert_eq!(planned(&scene, &cache), first);

    // It is the file that is read: what it says of what is left out is told.
    let (head, body) = choice.split_once("\n\n").unwrap();
    let (intro, hash) = head.rsplit_once(' ').unwrap();
    assert_eq!(hash, text_hash(body));
    let key = "left_out = ";
    let (before, after) = body.split_once(key).unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    let other = format!("{before}{key}0.125\n{after}");
    fs::write(file, format!("{intro} {}\n\n{other}", text_hash(&other))).unwrap();
    assert_ne!(planned(&scene, &cache), first);

    // Damaged it is decided anew, and mended.
    fs::write(file, choice.replacen(key, "left_out = 1", 1)).unwrap();
    assert_eq!(planned(&scene, &cache), first);
    assert_eq!(fs::read_to_string(file).unwrap(), choice);

    // A run decides the same, and another scene is another file.
    let run = ["run", text(&scene), "--cache", text(&cache), "-o"];
    niji_ends_with(0, &[&run[..], &[text(&at("out"))]].concat());
    assert_eq!(
        fs::read_to_string(at("out/choice.toml")).unwrap(),
        choice,
        "the choice of a run"
    );
    assert_eq!(kept(&cache).len(), 1);
    fs::write(&scene, TINY.replace("500.0", "400.0")).unwrap();
    planned(&scene, &cache);
    assert_eq!(kept(&cache).len(), 2);
}

#[test]
fn a_folder_that_cannot_be_written_and_none_keep_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (scene, cache) = (at("scene.toml"), at("cache"));
    fs::write(&scene, TINY).unwrap();
    let first = planned(&scene, Path::new("none"));
    assert!(!Path::new("none").exists());
    fs::write(&cache, "a file where a folder should be").unwrap();
    assert_eq!(planned(&scene, &cache), first);
}
