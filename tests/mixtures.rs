//! Several populations of drops in one scene, and several volumes in one, from files to a picture.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_dropfield::DropVolume;
use niji_exchange::SpectralImage;
use niji_vdb::VdbFile;

use support::niji_ends_with;
use support::repository;
use support::run_scene;
use support::text;

/// The shipped scene of two populations, small.
fn twinned() -> String {
    let path = repository("data/scenes/twinned-bow.toml");
    let text = fs::read_to_string(path).unwrap();
    let text = text.replace("width_px = 480", "width_px = 48");
    let text = text.replace("height_px = 320", "height_px = 32");
    // Rows of a table for every few per cent of radius are not needed here.
    text.replace(
        "preset = \"standard\"",
        "preset = \"draft\"\ntheory = \"geometric\"",
    )
}

/// The scene with one of its populations, written in another way.
fn with_only(name: &str, header: &str) -> String {
    let text = twinned();
    let start = text.find("[[drops]]").unwrap();
    let end = text.find("[air]").unwrap();
    let entries = text[start..end].split("[[drops]]");
    let line = format!("name = \"{name}\"\n");
    let entry = entries
        .into_iter()
        .find(|entry| entry.contains(&line))
        .unwrap();
    let entry = entry.replace(&line, "");
    format!("{}{header}{entry}{}", &text[..start], &text[end..])
}

fn written(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

/// Makes the drops of a scene.
fn drops(scene: &Path) -> PathBuf {
    let path = scene.with_extension("vdb");
    niji_ends_with(
        0,
        &["drops", "-q", "--scene", text(scene), "-o", text(&path)],
    );
    path
}

fn volume(path: &Path) -> DropVolume {
    DropVolume::from_vdb(&VdbFile::read(path).unwrap()).unwrap()
}

fn message(code: i32, arguments: &[&str]) -> String {
    String::from_utf8(niji_ends_with(code, arguments).stderr).unwrap()
}

#[test]
fn a_list_of_one_gives_the_bytes_of_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let table = written(folder.path(), "table.toml", &with_only("small", "[drops]"));
    let list = written(folder.path(), "list.toml", &with_only("small", "[[drops]]"));
    assert!(fs::read(drops(&table)).unwrap() == fs::read(drops(&list)).unwrap());
}

#[test]
fn modes_of_a_mixture_are_those_of_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    let both = volume(&drops(&written(folder.path(), "both.toml", &twinned())));
    assert_eq!(both.modes.len(), 2);
    for (mode, name) in both.modes.iter().zip(["small", "large"]) {
        let alone = with_only(name, "[drops]");
        let mut alone = volume(&drops(&written(
            folder.path(),
            &format!("{name}.toml"),
            &alone,
        )));
        name.clone_into(&mut alone.modes[0].name);
        assert_eq!(*mode, alone.modes[0]);
    }

    // From volumes, by the command line and as entries of a scene.
    let (small, large) = (inside("small.vdb"), inside("large.vdb"));
    let mixed = inside("mixed.vdb");
    let renamed = format!("small={}", text(&small));
    niji_ends_with(
        0,
        &[
            "drops",
            "mix",
            "-q",
            &renamed,
            text(&large),
            "-o",
            text(&mixed),
        ],
    );
    assert_eq!(volume(&mixed), both);
    let start = twinned().find("[[drops]]").unwrap();
    let end = twinned().find("[air]").unwrap();
    let of_files = format!(
        "{}[[drops]]\nfile = \"small.vdb\"\nname = \"small\"\n[[drops]]\nname = \"large\"\n\
         shape = \"from-vdb\"\nfile = \"large.vdb\"\ngrid = \"number_density\"\n\
         density_means = \"number\"\nscale = 1.0\neffective_radius_um = 510.0\n\
         effective_variance = 0.003\n\n{}",
        &twinned()[..start],
        &twinned()[end..]
    );
    let of_files = drops(&written(folder.path(), "files.toml", &of_files));
    assert_eq!(volume(&of_files), both);

    // Two volumes without different names, and a name that is none.
    let wrong = inside("wrong.vdb");
    let [small, large, to] = [&small, &large, &wrong].map(|path| text(path));
    let twice = format!("small={large}");
    let found = message(2, &["drops", "mix", small, &twice, "-o", to]);
    assert!(found.contains("`small`: is there twice"), "{found}");
    let bad = format!("number={large}");
    let found = message(2, &["drops", "mix", small, &bad, "-o", to]);
    assert!(
        found.contains("is \"number\", expected a letter"),
        "{found}"
    );
    assert!(!wrong.exists());
}

/// Light of the bows, of the whole picture.
fn bow_light(image: &SpectralImage) -> f64 {
    let bows = image.aovs.iter().filter(|aov| aov.name.starts_with("bow_"));
    let planes = bows.flat_map(|aov| &aov.channels).map(|(_, plane)| plane);
    planes.map(|plane| f64::from(plane.sum())).sum()
}

#[test]
fn the_bow_of_thin_mixtures_is_the_sum_of_the_bows_of_their_parts() {
    // So few drops that they hide nothing of each other.
    let thin = |text: String| {
        let text = text.replace("number_density_m3 = 707.4", "number_density_m3 = 0.7074");
        let text = text.replace("number_density_m3 = 123.5", "number_density_m3 = 0.1235");
        assert!(text.contains("0.7074") || text.contains("0.1235"));
        let effects = "[effects]\ndrop_flattening = \"off\"\nsky = \"off\"\nmultiple_scattering = \"off\"\n\n[accuracy]";
        // Nothing is too faint for one picture that another has.
        let faint = "preset = \"draft\"\ntolerance = 1e-6\npixel_footprint = \"center\"";
        let text = text.replace("preset = \"draft\"", faint);
        assert!(text.contains("1e-6"));
        text.replace("[accuracy]", effects)
    };
    let folder = tempfile::tempdir().unwrap();
    let light = |name: &str, scene: String| {
        let scene = written(folder.path(), &format!("{name}.toml"), &thin(scene));
        let (scene, image) = run_scene(&scene, &folder.path().join(name));
        assert!(!scene.drops.populations().is_empty());
        bow_light(&image)
    };
    let both = light("both", twinned());
    let each = ["small", "large"].map(|name| light(name, with_only(name, "[drops]")));
    let sum: f64 = each.iter().sum();
    assert!(each.iter().all(|light| *light > 0.1 * sum));
    // What they do take from each other, and f32 sums: measured 6e-5.
    assert!((both / sum - 1.0).abs() < 3e-4, "{both} {each:?}");
}

#[test]
fn a_sequence_changes_one_population_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let text = twinned() + "\n[sequence]\ndrops.large.number_density_m3 = [[1, 123.5], [3, 0.5]]\n";
    let scene = written(folder.path(), "sequence.toml", &text);
    let out = folder.path().join("out");
    let scene = support::text(&scene);
    niji_ends_with(
        0,
        &[
            "run",
            scene,
            "-q",
            "-o",
            support::text(&out),
            "--frames",
            "2",
        ],
    );
    let names = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let is_drops = |path: &PathBuf| path.extension().is_some_and(|it| it == "vdb");
    let drops: Vec<PathBuf> = names.filter(is_drops).collect();
    let [drops] = drops.as_slice() else {
        panic!("{drops:?}")
    };
    let found: Vec<f32> = volume(drops)
        .modes
        .iter()
        .map(|mode| mode.nodes().next().unwrap().1.number_density_m3)
        .collect();
    assert_eq!(found, [707.4, 62.0]);
}

#[test]
fn a_plan_says_how_the_volume_of_a_mixture_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let scene = written(folder.path(), "twinned.toml", &twinned());
    let printed = |arguments: &[&str]| {
        let arguments = [&["plan", text(&scene)], arguments].concat();
        String::from_utf8(niji_ends_with(0, &arguments).stdout).unwrap()
    };
    let script = printed(&["--script", "-o", "out"]);
    assert!(script.contains("niji drops --scene") && script.contains("--drops out/drops.vdb"));
    assert!(printed(&[]).contains("16000 voxels of 100 m (uniform, uniform)"));
    assert!(printed(&["--explain", "all"]).contains("drop_shadow"));
}
