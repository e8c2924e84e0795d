//! Inputs of every kind, and keys of a scene.

use std::collections::BTreeMap;
use std::fs;

use crate::support::text;
use crate::world::AIR;
use crate::world::PHOTO;
use crate::world::PICKS;
use crate::world::SCENE;
use crate::world::SHAPE;
use crate::world::SUN;
use crate::world::World;
use crate::world::again;
use crate::world::change;
use crate::world::files;
use crate::world::run;

const FROM_FILE: &str = "[drops]\nfile = \"drops.vdb\"\n";
const FROM_FRAMES: &str = "[drops]\nfile = \"drops.##.vdb\"\n";
const FROM_DENSITY: &str = "[drops]\nshape = \"from-vdb\"\nfile = \"drops.vdb\"\nscale = 1.0\n\
    density_means = \"optical-depth\"\neffective_radius_um = 400.0\n";
const GLTF: &str = "[[occluders.meshes]]\nfile = \"a.gltf\"\n";
const OBJ: &str = "[[occluders.meshes]]\nfile = \"a.obj\"\n";
const DEPTH: &str = "[occluders]\ndepth = \"depth.exr\"\n";
const PLAIN_PHOTO: &str = "[photo]\npicture = \"photo.png\"\n";
const ICE: &str = r#"
format = 1
name = "ice"
[camera]
position_m = [6.0, 4.0, 12.0]
azimuth_deg = -26.0
elevation_deg = -15.0
horizontal_fov_deg = 40.0
width_px = 8
height_px = 6
[spectrum]
first_nm = 500.0
step_nm = 100.0
n_wavelengths = 2
[ice.surface]
level = "diffuse"
outer_reflectance = 0.063
inner_reflectance = 0.0
[ice.shape]
shape = "mesh"
file = "ice.obj"
[sky]
irradiance_share = 0.4
[ground]
level = "land"
albedo = 0.5
[accuracy]
transport = { level = "path-traced", paths_per_pixel = 4, wavelengths = "all" }
"#;

/// A command that works from sections of a scene, and an input file that changes.
type Case = (&'static str, &'static [&'static str], &'static str);

const CASES: [Case; 14] = [
    ("run s.toml", &[SCENE, SUN, FROM_FILE], "drops.vdb"),
    ("run s.toml", &[SCENE, SUN, FROM_DENSITY], "drops.vdb"),
    ("run s.toml", &[SCENE, SUN, SHAPE, GLTF], "a.gltf"),
    ("run s.toml", &[SCENE, SUN, SHAPE, GLTF], "a.bin"),
    ("run s.toml", &[SCENE, SUN, SHAPE, OBJ], "a.obj"),
    ("run s.toml", &[SCENE, SUN, SHAPE, DEPTH], "depth.exr"),
    (
        "run s.toml",
        &[SCENE, SUN, SHAPE, PLAIN_PHOTO, DEPTH],
        "depth.exr",
    ),
    ("run s.toml", &[SCENE, SUN, SHAPE, PLAIN_PHOTO], "photo.png"),
    ("run s.toml", &[SCENE, SHAPE, PHOTO, PICKS], "photo.png"),
    (
        "run s.toml",
        &[SCENE, SHAPE, PHOTO, PICKS],
        "depth.layers.toml",
    ),
    (
        "run s.toml",
        &[SCENE, SHAPE, PHOTO, PICKS],
        "depth.labels.png",
    ),
    (
        "run s.toml --table table.exr",
        &[SCENE, SUN, SHAPE],
        "table.exr",
    ),
    (
        "run s.toml --frames 1-2",
        &[SCENE, SUN, FROM_FRAMES],
        "drops.02.vdb",
    ),
    ("ice s.toml", &[ICE, SUN], "ice.obj"),
];

#[test]
fn inputs_that_changed_are_noticed() {
    let world = World::with_inputs();
    for (index, (command, sections, name)) in CASES.into_iter().enumerate() {
        world.scene("s.toml", sections);
        let input = world.path(name);
        let [kept, other] =
            [name, &format!("other-{name}")].map(|it| fs::read(world.path(it)).unwrap());
        let make = |out: &str| {
            let folder = world.path(&format!("{index} {out}"));
            let to = if command.starts_with("ice") {
                folder.join("ice.exr")
            } else {
                folder.clone()
            };
            let absolute = |word: &str| match world.path(word) {
                path if path.is_file() => text(&path).to_owned(),
                _ => word.to_owned(),
            };
            let words: Vec<String> = command.split(' ').map(absolute).collect();
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            again(&[&words[..], &["-o", text(&to)]].concat());
            files(&folder)
        };
        let before = make("out");
        change(&input, |path| fs::write(path, other).unwrap());
        let expected = make("fresh");
        assert!(expected != before, "{command} {name}: it matters");
        // A file that only the other input needs may stay.
        let holds = |found: &BTreeMap<String, Vec<u8>>, all: &BTreeMap<String, Vec<u8>>| {
            all.iter()
                .all(|(name, bytes)| found.get(name) == Some(bytes))
        };
        assert!(holds(&make("out"), &expected), "{command} {name}");
        change(&input, |path| fs::write(path, kept).unwrap());
        assert!(holds(&make("out"), &before), "{command} {name} back again");
    }
}

#[test]
fn keys_of_a_scene_that_changed_are_noticed() {
    let world = World::new();
    let base = [SCENE, SUN, SHAPE, AIR].concat();
    let out = world.path("out");
    run(&world.scene("s.toml", &[&base]), &out);
    let before = files(&out);
    for (key, value) in [
        ("elevation_deg = 20.0", "elevation_deg = 20.5"),
        ("position_m = [0.0, 60.0", "position_m = [0.0, 61.0"),
        ("first_nm = 450.0", "first_nm = 451.0"),
        ("number_density_m3 = 30.0", "number_density_m3 = 31.0"),
        ("voxel_m = 300.0", "voxel_m = 150.0"),
        ("[\"rayleigh\"]", "[\"rayleigh\", \"ozone\"]"),
        ("air_inscatter = \"off\"", "air_inscatter = \"on\""),
        ("theory = \"airy\"", "theory = \"uniform\""),
        ("[effects]", "[picture]\nexposure_ev = 1.0\n[effects]"),
        ("[effects]", "[water]\ntemperature_c = 20.0\n[effects]"),
        ("[effects]", "[ground]\nalbedo = 0.7\n[effects]"),
    ] {
        assert!(base.contains(key), "{key}");
        let scene = world.scene("s.toml", &[&base.replace(key, value)]);
        let fresh = world.path("fresh");
        run(&scene, &fresh);
        let expected = files(&fresh);
        assert!(expected != before, "{value}: it matters");
        run(&scene, &out);
        // Beside what the scene needed before.
        let found = files(&out);
        assert!(
            expected.iter().all(|(name, bytes)| found[name] == *bytes),
            "{value}"
        );
        fs::remove_dir_all(fresh).unwrap();
    }
}
