//! Scenes of strangers read nothing outside of the folders that they are given.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use support::niji_ends_with;
use support::repository;
use support::text;

const SCENE: &str = r#"
format = 1
name = "stranger"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 60.0
width_px = 12
height_px = 8
[spectrum]
first_nm = 450.0
step_nm = 100.0
n_wavelengths = 3
[accuracy]
preset = "draft"
"#;
const SHAPE: &str = r#"
[drops]
shape = "uniform"
box_min_m = [-600.0, 0.0, -1200.0]
box_max_m = [600.0, 1000.0, -300.0]
number_density_m3 = 300.0
law = { monodisperse = { radius_um = 500.0 } }
voxel_m = 300.0
"#;
const MESH: &str = "v -5 0 -40\nv 5 0 -40\nv 0 9 -40\nf 1 2 3\n";
const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"uri": "a.bin", "byteLength": 36}]}"#;

/// A folder `given` for the files of scenes, and one `secret` beside it with files of all kinds.
fn world() -> tempfile::TempDir {
    let world = tempfile::tempdir().unwrap();
    let place = |name: &str| world.path().join(name);
    for folder in ["secret", "given", "given/deep"] {
        fs::create_dir(place(folder)).unwrap();
        fs::write(place(folder).join("a.obj"), MESH).unwrap();
        fs::write(place(folder).join("a.gltf"), GLTF).unwrap();
        let corners = [-5.0_f32, 0.0, -40.0, 5.0, 0.0, -40.0, 0.0, 9.0, -40.0];
        let bytes = corners.iter().flat_map(|it| it.to_le_bytes());
        fs::write(place(folder).join("a.bin"), bytes.collect::<Vec<u8>>()).unwrap();
    }
    for name in [
        "pavilion.jpg",
        "pavilion.labels.png",
        "pavilion.layers.toml",
    ] {
        fs::copy(
            repository("data/photos").join(name),
            place("secret").join(name),
        )
        .unwrap();
    }
    symlink(place("secret/a.obj"), place("given/link.obj")).unwrap();
    symlink("../secret", place("given/linked")).unwrap();
    symlink("deep/a.obj", place("given/within.obj")).unwrap();
    symlink(place("given/a.gltf"), place("secret/back.gltf")).unwrap();
    world
}

fn mesh(file: &str) -> String {
    format!("{SCENE}{SHAPE}[[occluders.meshes]]\nfile = \"{file}\"\n")
}

/// Runs a scene that stands in `given`, which alone it may read; what is said.
fn run(world: &Path, code: i32, scene: &str) -> String {
    let file = world.join("given/s.toml");
    fs::write(&file, scene).unwrap();
    let (given, out) = (world.join("given"), world.join("out"));
    let arguments = [
        "plan",
        text(&file),
        "--sandbox",
        text(&given),
        "-o",
        text(&out),
        "--force",
    ];
    String::from_utf8(niji_ends_with(code, &arguments).stderr).unwrap()
}

#[test]
fn no_link_and_no_name_leads_out_of_the_sandbox() {
    let world = world();
    let root = world.path();
    let absolute = text(&root.join("secret/a.obj")).to_owned();
    let photo = |keys: &str| format!("{SCENE}{SHAPE}[photo]\n{keys}");
    let without_sun =
        |scene: String| scene.replace("[sun]\nelevation_deg = 20.0\nazimuth_deg = 180.0\n", "");
    let picks = "picture = \"../secret/pavilion.jpg\"\npicks_px = [[200.0, 109.6], [440.0, 48.7], [620.0, 76.7]]\n";
    for (scene, file) in [
        (mesh("../secret/a.obj"), "../secret/a.obj"),
        (mesh("deep/../../secret/a.obj"), "../../secret/a.obj"),
        (mesh(&absolute), "secret/a.obj"),
        (mesh("link.obj"), "link.obj"),
        (mesh("linked/a.obj"), "linked/a.obj"),
        // The file is within, but its buffers would be looked for beside the link.
        (mesh("../secret/back.gltf"), "back.gltf"),
        (mesh("/dev/zero"), "/dev/zero"),
        (
            format!("{SCENE}{SHAPE}[occluders]\ndepth = \"../secret/a.exr\"\n"),
            "a.exr",
        ),
        (
            format!("{SCENE}{SHAPE}[terrain]\nfile = \"../secret/a.exr\"\nspacing_m = 9\n"),
            "a.exr",
        ),
        (
            format!("{SCENE}[drops]\nfile = \"/etc/passwd\"\n"),
            "/etc/passwd",
        ),
        (
            photo("picture = \"../secret/pavilion.jpg\"\n"),
            "pavilion.jpg",
        ),
        (without_sun(photo(picks)), "pavilion.jpg"),
    ] {
        let said = run(root, 3, &scene);
        assert!(said.contains(file), "{file}: {said}");
        if !file.ends_with("a.exr") {
            let given = root.join("given").canonicalize().unwrap();
            let expected = format!(
                "outside of the sandbox, expected one in {}",
                given.display()
            );
            assert!(said.contains(&expected), "{said}");
        }
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    assert!(!root.join("out").exists());
}

#[test]
fn what_lies_in_the_sandbox_is_read_and_what_the_user_names_too() {
    let world = world();
    let root = world.path();
    for file in [
        "a.obj",
        "deep/a.obj",
        "deep/../a.gltf",
        "within.obj",
        "../given/a.obj",
    ] {
        run(root, 0, &mesh(file));
    }
    // A second folder, and a scene that stands in neither.
    let (scene, drops) = (root.join("s.toml"), root.join("secret/drops.vdb"));
    fs::write(&scene, mesh("secret/a.obj")).unwrap();
    let plan = ["plan", text(&scene), "--sandbox"];
    let [given, secret] = ["given", "secret"].map(|name| text(&root.join(name)).to_owned());
    niji_ends_with(3, &[&plan[..], &[&given]].concat());
    niji_ends_with(0, &[&plan[..], &[&given, "--sandbox", &secret]].concat());
    niji_ends_with(3, &[&plan[..], &[text(&root.join("missing"))]].concat());
    // Files on the command line are the user's word.
    fs::write(&scene, [SCENE, SHAPE].concat()).unwrap();
    let common = ["--sandbox", &given, "--scene", text(&scene), "-q"];
    niji_ends_with(
        0,
        &[&["drops"], &common[..], &["-o", text(&drops)]].concat(),
    );
}

#[test]
fn frames_and_scenes_of_ice_are_held_too() {
    let world = world();
    let root = world.path();
    let (scene, given, out) = (
        root.join("given/s.toml"),
        root.join("given"),
        root.join("out"),
    );
    fs::write(
        &scene,
        format!("{SCENE}[drops]\nfile = \"../secret/drops.##.vdb\"\n"),
    )
    .unwrap();
    let flags = ["--sandbox", text(&given), "-o", text(&out)];
    let frames = [&["run", text(&scene), "--frames", "1-2"], &flags[..]].concat();
    let said = String::from_utf8(niji_ends_with(3, &frames).stderr).unwrap();
    assert!(said.contains("drops.01.vdb"), "{said}");
    let ice = fs::read_to_string(repository("data/scenes/ice-cube-0.1-m.toml")).unwrap();
    let ice = ice.replace(
        "shape = \"cube\"\nedge_m = 0.1",
        "shape = \"mesh\"\nfile = \"../secret/a.obj\"",
    );
    fs::write(&scene, ice).unwrap();
    let said = niji_ends_with(3, &[&["ice", text(&scene)], &flags[..]].concat()).stderr;
    assert!(
        String::from_utf8(said)
            .unwrap()
            .contains("outside of the sandbox")
    );
    assert!(!out.exists());
}
