//! Photo scenes: a bow behind, in and before the surfaces of a photograph, by the program.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use niji_exchange::Channel;
use niji_exchange::PlainPart;
use niji_exchange::SpectralImage;
use niji_exchange::write_plain;
use niji_photo::Photograph;
use niji_photo::read_depth_map;
use niji_photo::write_labels;
use support::niji_ends_with;
use support::repository;
use support::text;
use support::variant;

/// Writes a depth map that is the same everywhere.
fn write_depth(path: &Path, size: (usize, usize), distance_m: f32) {
    let parts = [PlainPart {
        name: "depth".to_owned(),
        channels: vec![Channel {
            name: "Z".to_owned(),
            values: Array2::from_elem(size, distance_m),
        }],
    }];
    write_plain(&parts, std::fs::File::create(path).unwrap()).unwrap();
}

/// Runs a scene, whose sun may follow from picks, and reads the spectral image.
fn rendered(scene: &Path, out: &Path) -> SpectralImage {
    niji_ends_with(0, &["run", text(scene), "-o", text(out), "-q"]);
    SpectralImage::read_spectral(&out.join("image.exr")).unwrap()
}

/// A copy of a shipped photo scene, small, with the paths of what ships beside it.
fn photo_scene(name: &str, folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let shipped = |file: &str| {
        format!(
            "{:?}",
            repository("data/photos").join(file).to_string_lossy()
        )
    };
    let paths = [
        "pavilion.jpg",
        "pavilion.layers.toml",
        "pavilion.labels.png",
    ]
    .map(shipped);
    let mut all = vec![
        ("photo.picture", paths[0].as_str()),
        ("photo.layers", &paths[1]),
        ("photo.labels", &paths[2]),
        ("camera.width_px", "160"),
        ("camera.height_px", "107"),
    ];
    all.extend(changes);
    variant(name, folder, &all)
}

/// The camera at half the size of the photograph.
const HALF: [(&str, &str); 2] = [("camera.width_px", "320"), ("camera.height_px", "214")];

/// Nearest drops of the scene with rain (m).
const RAIN_M: f32 = 500.0;

#[test]
fn a_scene_with_picks_that_are_off_is_planned_by_the_nearest_bow_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let picks = (
        "photo.picks_px",
        "[[200.0, 109.6], [440.0, 88.7], [620.0, 76.7]]",
    );
    let scene = photo_scene("photo-pavilion-rain.toml", folder.path(), &[picks]);
    let output = niji_ends_with(0, &["plan", text(&scene)]);
    let plan = String::from_utf8(output.stdout).unwrap();
    let told = plan.matches("no bow goes through photo.picks_px, the nearest misses them by 1.");
    assert_eq!(told.count(), 1, "{plan}");
}

#[test]
fn a_photo_scene_runs_from_picks_to_composite_and_keeps_what_fits() {
    let folder = tempfile::tempdir().unwrap();
    let scene = photo_scene("photo-pavilion-rain.toml", folder.path(), &[]);
    let out = folder.path().join("out");
    let run = || niji_ends_with(0, &["run", text(&scene), "-o", text(&out)]);
    let printed = String::from_utf8(run().stdout).unwrap();
    assert!(printed.trim_end().ends_with("composite.png"), "{printed}");
    let read = |name: &str| {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    };
    let sun = &read("sun.json")["report"]["solutions"][0];
    let elevation_deg = sun["elevation_deg"].as_f64().unwrap();
    assert!((elevation_deg - 27.0).abs() < 0.5, "{elevation_deg}");
    assert_eq!(
        read("report.json")["scene"]["sun"]["elevation_deg"],
        *sun.get("elevation_deg").unwrap()
    );
    let findings = read("check.json");
    let findings = findings["report"].as_array().unwrap();
    assert!(
        findings
            .iter()
            .all(|finding| finding["severity"] != "error"),
        "{findings:?}"
    );
    assert!(out.join("sun.png").is_file());
    let second = String::from_utf8(run().stderr).unwrap();
    assert!(second.contains("everything is up to date"), "{second}");
}

#[test]
fn the_printed_chain_of_a_photo_scene_gives_the_files_around_its_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let scene = photo_scene("photo-pavilion-rain.toml", folder.path(), &[]);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let names = [
        "depth.exr",
        "depth.png",
        "sun.json",
        "sun.png",
        "check.json",
        "composite.png",
    ];
    let read = || names.map(|name| std::fs::read(out.join(name)).unwrap());
    let of_run = read();
    for name in names {
        std::fs::remove_file(out.join(name)).unwrap();
    }
    let script = niji_ends_with(0, &["plan", text(&scene), "--script", "-o", text(&out)]).stdout;
    let script = String::from_utf8(script).unwrap();
    // What else the chain has stands there already.
    let lines = script.lines().filter_map(|line| line.strip_prefix("niji "));
    for line in lines {
        niji_ends_with(0, &line.split(' ').collect::<Vec<_>>());
    }
    assert!(read() == of_run);
}

#[test]
fn no_bow_light_lands_on_what_is_nearer_than_the_drops() {
    let folder = tempfile::tempdir().unwrap();
    let scene = photo_scene("photo-pavilion-rain.toml", folder.path(), &[]);
    let image = rendered(&scene, &folder.path().join("out"));
    let plane = |name: &str, channel: usize| {
        let aov = image.aovs.iter().find(|aov| aov.name == name).unwrap();
        aov.channels[channel].1.clone()
    };
    let surface_m = plane("surface", 0);
    let (light, through) = (plane("bow_primary", 1), plane("transmittance", 0));
    let mut n_hidden = 0;
    for ((at, surface_m), light) in surface_m.indexed_iter().zip(&light) {
        if *surface_m < RAIN_M {
            n_hidden += 1;
            assert_eq!((*light, through[at]), (0.0, 1.0), "{at:?}");
        }
    }
    // Pavilion, trees and the near lake take about half of the picture.
    let share = f64::from(n_hidden) / light.len() as f64;
    assert!((0.4..0.7).contains(&share), "{share}");
    assert!(light.iter().any(|light| *light > 0.0));

    // In the composite the same pixels at the photograph's own size are those of the photograph.
    let original = Photograph::read(&repository("data/photos/pavilion.jpg")).unwrap();
    let composite = Photograph::read(&folder.path().join("out/composite.png")).unwrap();
    let depth_m = read_depth_map(&folder.path().join("out/depth.exr")).unwrap();
    let mut n_changed = 0;
    for (at, depth_m) in depth_m.indexed_iter() {
        let is_same = composite.light[at] == original.light[at];
        assert!(is_same || *depth_m >= RAIN_M, "{at:?}");
        n_changed += usize::from(!is_same);
    }
    assert!(n_changed > depth_m.len() / 3, "{n_changed}");
}

/// Light of the bow in units of E t, which is 1 - T in homogeneous drops without shadow and air.
#[test]
fn moving_a_layer_changes_the_bow_as_the_line_integral_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // One layer of all: a wall.
    let label = ndarray::Array2::zeros((427, 640));
    let png = std::fs::File::create(at("labels.png")).unwrap();
    write_labels(&label, 1, png).unwrap();
    let run = |distance_m: f64| {
        let layers = format!("[[layer]]\ndistance_m = {distance_m:?}\n");
        std::fs::write(at("layers.toml"), layers).unwrap();
        let scene = photo_scene(
            "photo-pavilion-rain.toml",
            folder.path(),
            &[
                ("photo.layers", "\"layers.toml\""),
                ("photo.labels", "\"labels.png\""),
                (
                    "drops",
                    "{ shape = \"uniform\", box_min_m = [-900.0, -600.0, -900.0], box_max_m = [900.0, \
                     900.0, -300.0], voxel_m = 50.0, law = { monodisperse = { radius_um = 500.0 } }, \
                     number_density_m3 = 800.0 }",
                ),
                ("effects.drop_extinction", "\"on\""),
                ("effects.drop_shadow", "\"off\""),
                ("effects.skylit_drops", "\"off\""),
                ("effects.sunlight_through_air", "\"off\""),
                ("effects.air_extinction", "\"off\""),
                ("effects.sky", "\"off\""),
            ],
        );
        let out = at(&format!("out-{distance_m}"));
        let image = rendered(&scene, &out);
        let values = ["bow_primary", "transmittance"].map(|name| {
            let aov = image.aovs.iter().find(|aov| aov.name == name).unwrap();
            let channel = usize::from(name == "bow_primary");
            // A pixel in the bow, above the middle.
            f64::from(aov.channels[channel].1[[20, 110]])
        });
        (values[0], values[1])
    };
    let (open, through_open) = run(f64::INFINITY);
    let mut last = (0.0, 1.0);
    for distance_m in [400.0, 500.0, 700.0] {
        let (light, through) = run(distance_m);
        assert!(light > last.0 && through < last.1 && light < open);
        // Found: 2e-5.
        let expected = open * (1.0 - through) / (1.0 - through_open);
        assert!(
            (light / expected - 1.0).abs() < 2e-4,
            "{distance_m}: {light} {expected}"
        );
        if last.0 > 0.0 {
            // Beyond the near face every metre takes pi r² n.
            let step_m: f64 = if distance_m > 600.0 { 200.0 } else { 100.0 };
            let tau = std::f64::consts::PI * 5e-4_f64.powi(2) * 800.0 * step_m;
            assert!((last.1 * (-tau).exp() / through - 1.0).abs() < 2e-4);
        }
        last = (light, through);
    }
    assert_eq!(run(200.0), (0.0, 1.0), "before the drops there is nothing");
}

#[test]
fn edges_of_the_pavilion_show_no_halo() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let scene = photo_scene("photo-pavilion-rain.toml", folder.path(), &HALF);
    niji_ends_with(0, &["run", text(&scene), "-o", &at("out"), "-q"]);
    let photo = text(&repository("data/photos/pavilion.jpg")).to_owned();
    let element = |card: &str, (image, extra): (&str, &[&str])| {
        let (image, to) = (at(image), at("element.exr"));
        let fixed = ["composite", &photo, "--image", &image, "-q", "-o", &to];
        let card = ["--exposure", card, "--force"];
        niji_ends_with(0, &[&fixed[..], &card, extra].concat());
        Photograph::read(Path::new(&to)).unwrap().light
    };
    // What a brighter sun adds is the bow alone.
    let bow = |image: &str, extra: &[&str]| {
        let [bright, dim] = ["2", "1"].map(|card| element(card, (image, extra)));
        let pairs = bright.iter().zip(&dim);
        let green = pairs.map(|(bright, dim)| bright[1] - dim[1]).collect();
        (Array2::from_shape_vec(bright.dim(), green).unwrap(), dim)
    };
    let depth = at("out/depth.exr");
    let (shown, with_surroundings) = bow("out/image.exr", &["--depth", &depth]);
    // The same bow with nothing in front of it.
    let open = photo_scene("photo-pavilion-rain.toml", folder.path(), &HALF);
    let (drops, table, air) = (
        at("out/drops.vdb"),
        at("out/scatter.exr"),
        at("out/atmosphere.exr"),
    );
    write_depth(Path::new(&at("sky.exr")), (214, 320), 1e10);
    let (sky, image) = (at("sky.exr"), at("open.exr"));
    niji_ends_with(
        0,
        &[
            "render",
            "--scene",
            text(&open),
            "--drops",
            &drops,
            "--table",
            &table,
            "--air",
            &air,
            "--depth",
            &sky,
            "-o",
            &image,
            "-q",
        ],
    );
    let (open, _) = bow("open.exr", &[]);
    let depth_m = read_depth_map(Path::new(&depth)).unwrap();
    let largest = open.iter().copied().fold(0.0, f32::max);
    let (mut n_edges, mut squares, mut worst) = (0.0, 0.0, 0.0_f32);
    for ((y, x), depth) in depth_m.indexed_iter() {
        if *depth < RAIN_M {
            assert_eq!(with_surroundings[[y, x]], [0.0; 3], "{x} {y}");
            continue;
        }
        let near = |x: usize| depth_m[[y, x]] < RAIN_M;
        let is_edge = (x > 0 && near(x - 1)) || (x + 1 < 640 && near(x + 1));
        if depth.is_infinite() && is_edge {
            let error = (shown[[y, x]] - open[[y, x]]).abs() / largest;
            n_edges += 1.0;
            squares += error * error;
            worst = worst.max(error);
        }
    }
    assert!(n_edges > 300.0, "{n_edges}");
    // Found 0.022 and 0.49: single pixels of sky between leaves, of which the image saw nothing, take
    // the light of the sky two pixels of the image away.
    let rms = (squares / n_edges).sqrt();
    assert!(rms < 0.03 && worst < 0.6, "{rms} {worst}");
}

#[test]
fn depth_maps_that_cannot_be_are_refused_with_code_3() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let scene = variant(
        "paper-c-figure-3.toml",
        folder.path(),
        &[("camera.width_px", "32"), ("camera.height_px", "24")],
    );
    niji_ends_with(0, &["run", text(&scene), "-o", &at("out"), "-q"]);
    let write = |name: &str, size, distance_m| write_depth(Path::new(&at(name)), size, distance_m);
    write("near.exr", (24, 32), 1.0);
    write("fine.exr", (48, 64), 1.0);
    write("tall.exr", (32, 24), 1.0);
    write("negative.exr", (24, 32), -1.0);
    let (drops, table) = (at("out/drops.vdb"), at("out/scatter.exr"));
    let render = |code: i32, depth: &str| {
        let (depth, to) = (at(depth), at("image.exr"));
        let arguments = [
            "render",
            "--scene",
            text(&scene),
            "--drops",
            &drops,
            "--table",
            &table,
            "--depth",
            &depth,
            "-o",
            &to,
            "-q",
            "--force",
        ];
        String::from_utf8(niji_ends_with(code, &arguments).stderr).unwrap()
    };
    for name in ["near.exr", "fine.exr"] {
        render(0, name);
        let image = SpectralImage::read_spectral(Path::new(&at("image.exr"))).unwrap();
        assert!(image.radiance.iter().all(|light| *light == 0.0), "{name}");
    }
    assert!(render(3, "tall.exr").contains("24 x 32"));
    assert!(render(3, "negative.exr").contains("depth -1"));
    assert!(render(3, "missing.exr").contains("missing.exr"));
    // The first Z of a rendered image is CIE Z.
    assert!(render(3, "out/image.exr").contains("cd/m^2"));
    // A scene names its surfaces by itself, along the axis too.
    let named = variant(
        "paper-c-figure-3.toml",
        folder.path(),
        &[
            ("camera.width_px", "32"),
            ("camera.height_px", "24"),
            ("occluders.depth", "\"near.exr\""),
            ("occluders.along", "\"axis\""),
        ],
    );
    let image = rendered(&named, &folder.path().join("named"));
    assert!(image.radiance.iter().all(|light| *light == 0.0));
}
