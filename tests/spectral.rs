//! What the file of a picture keeps of its spectra: all, half floats, or colors alone.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use support::niji_ends_with;
use support::text;
use support::variant;

const FILES: [&str; 3] = ["image.exr", "image.layers.exr", "image.png"];

struct World {
    folder: tempfile::TempDir,
}

impl World {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A small shipped scene with changes, always under one name.
    fn scene(&self, changes: &[(&str, &str)]) -> PathBuf {
        let small = [("camera.width_px", "48"), ("camera.height_px", "36")];
        variant(
            "paper-b-sun-20-inscatter.toml",
            self.folder.path(),
            &[&small, changes].concat(),
        )
    }

    fn run(&self, scene: &Path, out: &str, flags: &[&str]) -> String {
        let out = self.path(out);
        let run = ["run", text(scene), "-o", text(&out)];
        let ended = niji_ends_with(0, &[&run, flags].concat());
        String::from_utf8(ended.stderr).unwrap()
    }

    fn files(&self, out: &str) -> [Vec<u8>; 3] {
        FILES.map(|name| fs::read(self.path(out).join(name)).unwrap())
    }

    fn image(&self, out: &str) -> SpectralImage {
        SpectralImage::read_picture(&self.path(out).join(FILES[0])).unwrap()
    }
}

#[test]
fn an_edited_switch_makes_the_picture_anew_and_flag_and_key_are_one() {
    let world = World::new();
    world.run(&world.scene(&[]), "out", &[]);
    let (full, full_files) = (world.image("out"), world.files("out"));
    let mut bytes = full_files[0].len();
    for (name, kept) in [("half", Spectra::Half), ("none", Spectra::Left)] {
        let quoted = format!("\"{name}\"");
        let edited = world.scene(&[("picture.spectral", &quoted)]);
        let said = world.run(&edited, "out", &[]);
        assert!(!said.contains("image.exr is up to date"), "{said}");
        assert_eq!(world.image("out"), full_as(&world, "out", &full, kept));
        let files = world.files("out");
        assert!(files[0].len() < bytes, "{name}");
        bytes = files[0].len();
        world.run(&world.scene(&[]), name, &["--spectral", name, "-q"]);
        assert!(world.files(name) == files, "{name}");
        let edited = world.scene(&[("picture.spectral", &quoted)]);
        let said = world.run(&edited, "out", &[]);
        assert!(said.contains("image.exr is up to date"), "{said}");
    }
    world.run(&world.scene(&[]), "out", &["-q"]);
    assert!(world.files("out") == full_files);
}

/// The picture with as much of its spectra, as that file says where it comes from.
fn full_as(world: &World, out: &str, full: &SpectralImage, kept: Spectra) -> SpectralImage {
    SpectralImage {
        provenance: world.image(out).provenance,
        ..full.clone().keeping(kept)
    }
}

#[test]
fn tiles_without_spectra_merge_to_the_bytes_of_one_run() {
    for kept in ["half", "none"] {
        let world = World::new();
        let scene = world.scene(&[]);
        let flags = ["--spectral", kept, "-q"];
        world.run(&scene, "one", &flags);
        let tiles = [&flags[..], &["--tiles", "1-3/3"]].concat();
        world.run(&scene, "tiled", &tiles);
        let tiled = world.path("tiled");
        niji_ends_with(0, &["merge", text(&tiled), "-q"]);
        assert!(world.files("tiled") == world.files("one"), "{kept}");
    }
}

#[test]
fn colors_are_enough_to_show_a_picture_otherwise_and_to_composite_it() {
    let world = World::new();
    let flags = ["--spectral", "none", "-q"];
    world.run(&world.scene(&[]), "out", &flags);
    let before = world.files("out");
    let other = [
        ("picture.exposure_ev", "1.0"),
        ("picture.primaries", "\"acescg\""),
    ];
    let brighter = world.scene(&other);
    world.run(&brighter, "out", &flags);
    let after = world.files("out");
    assert!(after[0] == before[0] && after[1] != before[1] && after[2] != before[2]);
    let plate = world.path("plate.png");
    fs::write(&plate, &after[2]).unwrap();
    let image = world.path("out").join(FILES[0]);
    let output = world.path("bow.png");
    let composite = ["composite", text(&plate), "--image", text(&image)];
    let output = ["-o", text(&output), "--exposure", "1", "-q"];
    niji_ends_with(0, &[&composite[..], &output].concat());
}

#[test]
fn who_needs_spectra_is_told_what_to_type() {
    let world = World::new();
    let scene = world.scene(&[]);
    world.run(&scene, "full", &["-q"]);
    world.run(&scene, "none", &["--spectral", "none", "-q"]);
    let [full, none] = ["full", "none"].map(|out| world.path(out).join(FILES[0]));
    let said = niji_ends_with(6, &["diff", text(&none), text(&full)]);
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(
        said.contains("different parts") && said.contains("color"),
        "{said}"
    );
    let wrong = ["run", text(&scene), "-o", "x", "--spectral", "float"];
    let said = niji_ends_with(2, &wrong);
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(
        ["full", "half", "none"].iter().all(|it| said.contains(it)),
        "{said}"
    );
}
