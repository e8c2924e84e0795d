//! A picture in tiles is the picture of one run; what was interrupted goes on.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Output;

use niji_exchange::SpectralImage;
use support::niji;
use support::niji_ends_with;
use support::text;
use support::variant;

/// A picture of a few rows with air, sky and overscan.
const SCENE: &str = "paper-b-sun-20-inscatter.toml";
const SMALL: [(&str, &str); 3] = [
    ("camera.width_px", "40"),
    ("camera.height_px", "30"),
    ("camera.overscan_px", "2"),
];

/// A run, and what renders parts of it.
struct World {
    folder: tempfile::TempDir,
    scene: PathBuf,
    run: PathBuf,
}

impl World {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let scene = variant(SCENE, folder.path(), &SMALL);
        let run = folder.path().join("run");
        niji_ends_with(0, &["run", text(&scene), "-o", text(&run), "-q"]);
        Self { folder, scene, run }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Renders with flags; `to` is a name in the folder.
    fn render(&self, flags: &[&str], to: &str) -> Output {
        let inputs = ["drops.vdb", "scatter.exr", "atmosphere.exr"].map(|name| self.run.join(name));
        let to = self.path(to);
        let [drops, table, air] = inputs.each_ref().map(|path| text(path));
        let fixed = [
            "render",
            "--scene",
            text(&self.scene),
            "--drops",
            drops,
            "--table",
            table,
        ];
        niji(&[&fixed[..], &["--air", air, "-o", text(&to), "-q"], flags].concat())
    }

    fn tile(&self, flags: &[&str], to: &str) -> PathBuf {
        let output = self.render(flags, to);
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        self.path(to)
    }

    /// Four tiles, made with as many threads as their number.
    fn tiles(&self) -> Vec<PathBuf> {
        let tile = |number: u32| {
            let (part, threads) = (format!("{number}/4"), number.to_string());
            let flags = ["--tiles", &part, "--threads", &threads];
            self.tile(&flags, &format!("tile.{number}.exr"))
        };
        (1..=4).map(tile).collect()
    }

    fn merge(&self, tiles: &[&Path]) -> Output {
        let merged = self.path("merged.exr");
        let tiles: Vec<&str> = tiles.iter().map(|path| text(path)).collect();
        niji(&[&["merge"], &tiles[..], &["-o", text(&merged), "-q"]].concat())
    }

    /// Merges, and what that says.
    fn merge_says(&self, tiles: &[&Path]) -> String {
        let merged = self.path("merged.exr");
        let tiles: Vec<&str> = tiles.iter().map(|path| text(path)).collect();
        let output = niji_ends_with(
            0,
            &[&["merge"], &tiles[..], &["-o", text(&merged)]].concat(),
        );
        String::from_utf8(output.stderr).unwrap()
    }

    fn assert_refused(&self, tiles: &[&Path], code: i32, words: &[&str]) {
        let output = self.merge(tiles);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{message}");
        for word in words {
            assert!(message.contains(word), "{word:?} in {message}");
        }
        assert!(!self.path("merged.exr").exists());
    }
}

fn assert_same_picture(one: &Path, other: &Path) {
    for extension in ["exr", "layers.exr", "png"] {
        let bytes = [one, other].map(|path| fs::read(path.with_extension(extension)).unwrap());
        assert!(bytes[0] == bytes[1], "{extension} differs");
    }
}

#[test]
fn tiles_merge_to_the_bytes_of_one_run() {
    let world = World::new();
    let mut tiles = world.tiles();
    tiles.reverse();
    // Overlaps all of them, overscan included.
    tiles.push(world.tile(&["--region", "-2,3,9,20"], "region.exr"));
    let paths: Vec<_> = tiles.iter().map(PathBuf::as_path).collect();
    let output = world.merge(&paths);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_same_picture(&world.path("merged.exr"), &world.run.join("image.exr"));
    assert!(world.merge_says(&paths).contains("is up to date"));
    // A damaged picture is made again.
    let mut bytes = fs::read(world.path("merged.exr")).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(world.path("merged.exr"), bytes).unwrap();
    assert!(!world.merge_says(&paths).contains("up to date"));
    assert_same_picture(&world.path("merged.exr"), &world.run.join("image.exr"));
    // A merge that was killed between two of its files makes them again.
    for missing in ["exr", "layers.exr", "png"] {
        fs::remove_file(world.path("merged.exr").with_extension(missing)).unwrap();
        assert!(world.merge(&paths).status.success(), "without {missing}");
        assert_same_picture(&world.path("merged.exr"), &world.run.join("image.exr"));
    }
    // A file that is not its own stays.
    fs::write(world.path("merged.png"), "a painting").unwrap();
    let again = world.merge(&paths);
    assert_eq!(again.status.code(), Some(2));
    // One tile of one is the picture itself, and up to date in the folder of the run.
    let whole = world.tile(&["--tiles", "1/1"], "whole.exr");
    assert_same_picture(&whole, &world.run.join("image.exr"));
}

#[test]
fn a_merge_notices_tiles_that_changed() {
    let world = World::new();
    let tiles = world.tiles();
    let mut paths: Vec<_> = tiles.iter().map(PathBuf::as_path).collect();
    world.merge_says(&paths);
    // In any order, and where they lie matters as little.
    paths.reverse();
    assert!(world.merge_says(&paths).contains("is up to date"));
    let mut image = SpectralImage::read_spectral(paths[0]).unwrap();
    image.radiance[[3, 1, 2]] += 1.0;
    let file = fs::File::create(paths[0]).unwrap();
    image.write_spectral(file).unwrap();
    assert!(!world.merge_says(&paths).contains("up to date"));
    let merged = SpectralImage::read_spectral(&world.path("merged.exr")).unwrap();
    let run = SpectralImage::read_spectral(&world.run.join("image.exr")).unwrap();
    assert!(merged.radiance != run.radiance);
}

#[test]
fn the_preview_shows_the_frame_without_its_overscan() {
    let world = World::new();
    let size = |path: &Path| {
        let file = std::io::BufReader::new(fs::File::open(path).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        (reader.info().width, reader.info().height)
    };
    assert_eq!(size(&world.run.join("image.png")), (40, 30));
    let image = SpectralImage::read_spectral(&world.run.join("image.exr")).unwrap();
    assert_eq!(image.radiance.dim().1, 34);
    assert_eq!(image.windows.data.to_string(), "-2,-2,44,34");
    let tile = world.tile(&["--region", "5,-2,7,12"], "tile.exr");
    assert_eq!(size(&tile.with_extension("png")), (7, 10));
}

#[test]
fn missing_foreign_and_changed_tiles_are_named() {
    let world = World::new();
    let tiles = world.tiles();
    let [one, two, three, four] = [0, 1, 2, 3].map(|index| tiles[index].as_path());
    world.assert_refused(&[one, two, four], 2, &["--tiles 3/4", "tile.4.exr"]);
    world.assert_refused(
        &[one],
        2,
        &[
            "3 tiles are missing",
            "--tiles 2/4, --tiles 3/4, --tiles 4/4",
        ],
    );
    let region = world.tile(&["--region", "-2,-2,44,30"], "region.exr");
    world.assert_refused(&[&region], 2, &["-2,28,44,4", "--region -2,28,44,4"]);
    let none = world.path("nothing.exr");
    world.assert_refused(
        &[one, two, three, &none],
        3,
        &["nothing.exr", "no such file"],
    );
    world.assert_refused(
        &[one, two, three, &world.run.join("airy.exr")],
        3,
        &["airy.exr"],
    );
    let plain = three.with_extension("layers.exr");
    world.assert_refused(&[&plain], 2, &["*.layers.exr"]);
    // A tile of the scene at another exposure.
    let other = variant(
        SCENE,
        world.folder.path(),
        &[SMALL[0], SMALL[1], SMALL[2], ("picture.exposure_ev", "1.5")],
    );
    assert_eq!(other, world.scene);
    let foreign = world.tile(&["--tiles", "3/4"], "foreign.exr");
    let words = ["foreign.exr", "picture.exposure_ev is 1.5"];
    world.assert_refused(&[&foreign, one, two, four], 3, &words);
    // Another value where two tiles are.
    let mut image = SpectralImage::read_spectral(two).unwrap();
    image.radiance[[3, 1, 2]] += 1.0;
    let changed = world.path("changed.exr");
    image
        .write_spectral(fs::File::create(&changed).unwrap())
        .unwrap();
    world.assert_refused(
        &[one, two, three, four, &changed],
        3,
        &["changed.exr", "(0, 7)"],
    );
    // Half a file.
    let bytes = fs::read(four).unwrap();
    let torn = world.path("torn.exr");
    fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
    world.assert_refused(&[one, two, three, &torn], 3, &["torn.exr"]);
}

#[test]
fn impossible_regions_and_tiles_are_refused() {
    let world = World::new();
    for (flags, word) in [
        (["--region", "0,0,45,10"], "overscan_px"),
        (["--region", "0,0,10"], "X,Y,WIDTH,HEIGHT"),
        (["--region", "0,0,0,10"], "at least one pixel"),
        (["--tiles", "0/4"], "I from 1 to N"),
        (["--tiles", "1/35"], "35 tiles of 34 rows"),
    ] {
        let output = world.render(&flags, "refused.exr");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {message}");
        assert!(message.contains(word), "{word:?} in {message}");
    }
    let both = world.render(&["--tiles", "1/2", "--region", "0,0,4,4"], "refused.exr");
    assert_eq!(both.status.code(), Some(2));
}

/// Contents of the files of a folder but the report and what is under a temporary name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_file() && !name.starts_with(".niji-") && name != "report.json" {
            files.insert(name, fs::read(&path).unwrap());
        }
    }
    files
}

#[test]
fn a_run_that_was_killed_between_two_files_writes_them_again() {
    let world = World::new();
    let expected = files(&world.run);
    let run = || niji(&["run", text(&world.scene), "-o", text(&world.run), "-q"]);
    let remove = |name: &str| fs::remove_file(world.run.join(name)).unwrap();
    // The image is the last of its three.
    for missing in [
        &["image.exr"][..],
        &["image.exr", "image.layers.exr"],
        &["image.png"],
    ] {
        for name in missing {
            remove(name);
        }
        assert!(run().status.success(), "without {missing:?}");
        assert!(files(&world.run) == expected, "without {missing:?}");
    }
    // A file that is not its own stays.
    remove("image.exr");
    fs::write(world.run.join("image.png"), "a painting").unwrap();
    assert_eq!(run().status.code(), Some(2));
    let kept = fs::read(world.run.join("image.png")).unwrap();
    assert_eq!(kept, b"a painting");
}

#[test]
fn an_image_and_its_preview_have_names_of_their_own() {
    let world = World::new();
    let found = world.render(&[], "x.png");
    assert_eq!(found.status.code(), Some(2));
    let said = String::from_utf8(found.stderr).unwrap();
    assert!(said.contains("x.png is the name of two outputs"), "{said}");
    assert!(!world.path("x.png").exists());
}
