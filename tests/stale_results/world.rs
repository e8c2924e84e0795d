//! Small scenes with files of all kinds, and what runs leave.

use std::collections::BTreeMap;
use std::fs;
use std::fs::File;
use std::path::Path;
use std::path::PathBuf;
use std::process::Output;

use crate::support::niji;
use crate::support::niji_ends_with;
use crate::support::text;

/// A picture of some milliseconds, to which sections are added.
pub(crate) const SCENE: &str = r#"
format = 1
name = "small"
[camera]
position_m = [0.0, 60.0, 0.0]
azimuth_deg = 0.0
elevation_deg = -0.9
horizontal_fov_deg = 60.0
width_px = 16
height_px = 11
[spectrum]
first_nm = 450.0
step_nm = 100.0
n_wavelengths = 3
[effects]
air_inscatter = "off"
sky = "off"
drop_flattening = "off"
[accuracy]
preset = "draft"
theory = "airy"
table_relative_error = 0.1
"#;
pub(crate) const SUN: &str = "[sun]\nelevation_deg = 20.0\nazimuth_deg = 180.0\n";
pub(crate) const SHAPE: &str = r#"
[drops]
shape = "uniform"
box_min_m = [-600.0, 0.0, -1200.0]
box_max_m = [600.0, 1000.0, -300.0]
number_density_m3 = 30.0
law = { monodisperse = { radius_um = 500.0 } }
voxel_m = 300.0
"#;
pub(crate) const PHOTO: &str = r#"
[photo]
picture = "photo.png"
layers = "depth.layers.toml"
labels = "depth.labels.png"
"#;
pub(crate) const PICKS: &str = "picks_px = [[20.0, 10.96], [44.0, 4.87], [62.0, 7.67]]\n";
pub(crate) const AIR: &str = "[air]\nconstituents = [\"rayleigh\"]\n";

/// A folder with input files of scenes, each twice: `NAME` and `other-NAME`.
pub(crate) struct World(tempfile::TempDir);

impl World {
    /// Without any.
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With all.
    pub(crate) fn with_inputs() -> Self {
        let world = Self::new();
        world.add("", ["10.0", "500.0", "600.0"]);
        world.add("other-", ["-20.0", "300.0", "400.0"]);
        for (name, error) in [("table.exr", "0.1"), ("other-table.exr", "0.05")] {
            let scene = SCENE.replace("error = 0.1", &format!("error = {error}"));
            let scene = world.scene("made.toml", &[&scene, SUN, SHAPE]);
            let airy = world.path("made/airy.exr");
            let flags = ["--scene", text(&scene), "--airy", text(&airy)];
            let to = world.path(name);
            niji_ends_with(
                0,
                &[&["scatter", "-q", "-o", text(&to)], &flags[..]].concat(),
            );
        }
        world
    }

    fn add(&self, start: &str, [azimuth_deg, radius_um, layer_m]: [&str; 3]) {
        let file = |name: &str| self.path(&format!("{start}{name}"));
        let scene = SCENE.replace("azimuth_deg = 0.0", &format!("azimuth_deg = {azimuth_deg}"));
        let scene = scene
            .replace("_px = 16", "_px = 64")
            .replace("_px = 11", "_px = 43");
        let scene = self.scene(
            "made.toml",
            &[&scene, SUN, &SHAPE.replace("500.0", radius_um), AIR],
        );
        let (made, photo, depth) = (file("made"), file("photo.png"), file("depth.exr"));
        niji_ends_with(0, &["run", text(&scene), "-o", text(&made), "-q"]);
        for (from, to) in [
            ("image.png", "photo.png"),
            ("drops.vdb", "drops.vdb"),
            ("drops.vdb", "drops.02.vdb"),
        ] {
            fs::copy(made.join(from), file(to)).unwrap();
        }
        fs::copy(made.join("drops.vdb"), self.path("drops.01.vdb")).unwrap();
        let layers = [
            "depth",
            text(&photo),
            "--fov-deg",
            "60",
            "--clusters",
            "2",
            "-q",
        ];
        niji_ends_with(0, &[&layers[..], &["-o", text(&depth)]].concat());
        let layers = format!("[[layer]]\ndistance_m = inf\n[[layer]]\ndistance_m = {layer_m}\n");
        fs::write(file("depth.layers.toml"), layers).unwrap();
        self.add_meshes(start, layer_m.parse().unwrap());
    }

    /// A triangle as glTF with its buffer, one as OBJ, and a body of ice.
    fn add_meshes(&self, start: &str, width_m: f32) {
        let write = |name: &str, bytes: &[u8]| {
            fs::write(self.path(&format!("{start}{name}")), bytes).unwrap();
        };
        let corners = [
            [-0.2 * width_m, 0.0, -200.0],
            [80.0, 0.0, -200.0],
            [0.0, 90.0, -200.0],
        ];
        let bytes = corners.iter().flatten().flat_map(|it| it.to_le_bytes());
        write("a.bin", &bytes.collect::<Vec<u8>>());
        let json = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [MOVED, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"uri": "a.bin", "byteLength": 36}]}"#;
        write(
            "a.gltf",
            json.replace("MOVED", &width_m.to_string()).as_bytes(),
        );
        let lines = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        write("a.obj", format!("{lines}f 1 2 3\n").as_bytes());
        let x = 0.01 * width_m;
        let body =
            format!("v 0 0 0\nv {x} 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        write("ice.obj", body.as_bytes());
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn scene(&self, name: &str, sections: &[&str]) -> PathBuf {
        fs::write(self.path(name), sections.concat()).unwrap();
        self.path(name)
    }
}

/// Contents of the files of a folder but the reports, which hold times.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let is_report = |path: &PathBuf| {
        path.file_name()
            .unwrap()
            .to_str()
            .unwrap()
            .starts_with("report.")
    };
    let files = entries.filter(|path| path.is_file() && !is_report(path));
    let named = files.map(|path| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, fs::read(path).unwrap())
    });
    named.collect()
}

/// Changes a file, and sets its time of modification back.
pub(crate) fn change(path: &Path, change: impl FnOnce(&Path)) {
    let modified = fs::metadata(path).unwrap().modified().unwrap();
    change(path);
    let file = File::options().write(true).open(path).unwrap();
    file.set_modified(modified).unwrap();
}

/// Runs a command over results of an earlier one, and returns what it says. What it does not replace unasked it is
/// told to replace.
pub(crate) fn again(arguments: &[&str]) -> String {
    let said = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let output = niji(arguments);
    if output.status.code() == Some(2) {
        assert!(said(&output).contains("--force"), "{}", said(&output));
        return said(&niji_ends_with(0, &[arguments, &["--force"]].concat()));
    }
    assert!(output.status.success(), "{}", said(&output));
    said(&output)
}

pub(crate) fn run(scene: &Path, out: &Path) -> String {
    again(&["run", text(scene), "-o", text(out)])
}
