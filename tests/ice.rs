//! `niji ice` and `niji eval ice`: files, colors and errors that people rely on.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use niji_exchange::SpectralImage;
use niji_radiometry::Colorimetry;
use niji_radiometry::xy_chromaticity;
use support::niji_ends_with;
use support::text;

const WHITE_CUBE: &str = include_str!("../data/scenes/ice-cube-0.1-m.toml");
const BLUE_CUBE: &str = include_str!("../data/scenes/ice-cube-50-m.toml");

/// A shipped scene in a small picture.
fn small(scene: &str) -> String {
    scene
        .replace("width_px = 640", "width_px = 32")
        .replace("height_px = 480", "height_px = 24")
        .replace("paths_per_pixel = 192", "paths_per_pixel = 64")
        .replace("paths_per_pixel = 128", "paths_per_pixel = 64")
}

fn write(folder: &Path, name: &str, content: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, content).unwrap();
    text(&path).to_owned()
}

/// Chromaticity of a pixel.
fn xy_at(image: &SpectralImage, [x, y]: [usize; 2]) -> [f64; 2] {
    let spectrum = image.radiance.slice(ndarray::s![.., y, x]);
    let spectrum: Vec<f64> = spectrum.iter().map(|&value| value.into()).collect();
    xy_chromaticity(Colorimetry::new(&image.wavelengths).xyz(&spectrum)).unwrap()
}

#[test]
fn ten_centimetres_are_white_and_fifty_metres_blue() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene, is_blue) in [("white", WHITE_CUBE, false), ("blue", BLUE_CUBE, true)] {
        let scene = write(folder.path(), &format!("{name}.toml"), &small(scene));
        let image = folder.path().join(format!("{name}.exr"));
        niji_ends_with(0, &["ice", &scene, "-o", text(&image)]);
        for companion in ["layers.exr", "png"] {
            assert!(image.with_extension(companion).is_file());
        }
        let image = SpectralImage::read_spectral(&image).unwrap();
        let names: Vec<&str> = image.aovs.iter().map(|aov| aov.name.as_str()).collect();
        assert_eq!(names, ["error", "depth", "paths"]);
        // Light of the G173 sun has (0.325, 0.334).
        let [x, _] = xy_at(&image, [15, 12]);
        assert_eq!(x < 0.27, is_blue, "{name}: {x}");
        assert!(is_blue || x > 0.31, "{name}: {x}");
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write(folder.path(), "cube.toml", &small(BLUE_CUBE));
    let bytes = |n_threads: &str| {
        let image = folder.path().join(format!("{n_threads}.exr"));
        niji_ends_with(
            0,
            &["ice", &scene, "-o", text(&image), "--threads", n_threads],
        );
        fs::read(&image).unwrap()
    };
    assert_eq!(bytes("1"), bytes("3"));
}

#[test]
fn a_tolerance_out_of_reach_writes_the_picture_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write(folder.path(), "cube.toml", &small(BLUE_CUBE));
    let image = folder.path().join("cube.exr");
    let output = niji_ends_with(
        5,
        &["ice", &scene, "-o", text(&image), "--tolerance", "1e-5"],
    );
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("needs more paths_per_pixel"), "{message}");
    assert!(image.is_file());
}

#[test]
fn an_open_or_damaged_mesh_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let shape = "shape = \"mesh\"\nfile = \"ice.obj\"\nlength_m = 50.0";
    let scene = small(BLUE_CUBE).replace("shape = \"cube\"\nedge_m = 50.0", shape);
    let scene = write(folder.path(), "mesh.toml", &scene);
    let image = folder.path().join("mesh.exr");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let render = |exit_code, faces: &str| {
        write(folder.path(), "ice.obj", &format!("{corners}{faces}"));
        let output = niji_ends_with(exit_code, &["ice", &scene, "-o", text(&image)]);
        String::from_utf8(output.stderr).unwrap()
    };
    let open = render(3, "f 1 3 2\nf 1 2 4\nf 2 3 4\n");
    assert!(
        open.contains("ice.obj") && open.contains("without a partner"),
        "{open}"
    );
    let empty = render(3, "");
    assert!(empty.contains("ice.obj"), "{empty}");
    let missing_corner = render(3, "f 1 3 9\n");
    assert!(missing_corner.contains("ice.obj"), "{missing_corner}");
    render(0, "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    assert!(image.is_file());
}

#[test]
fn wrong_keys_and_scenes_without_light_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("cube.exr");
    let refused = |exit_code, changes: &[[&str; 2]]| {
        let mut scene = small(BLUE_CUBE);
        for [from, to] in changes {
            assert!(scene.contains(from));
            scene = scene.replace(from, to);
        }
        let scene = write(folder.path(), "cube.toml", &scene);
        let output = niji_ends_with(exit_code, &["ice", &scene, "-o", text(&image)]);
        String::from_utf8(output.stderr).unwrap()
    };
    let misspelt = refused(3, &[["edge_m", "egde_m"]]);
    assert!(misspelt.contains("did you mean `edge_m`?"), "{misspelt}");
    let night = [
        ["elevation_deg = 35.0", "elevation_deg = -35.0"],
        ["irradiance_share = 0.4", "irradiance_share = 0.0"],
    ];
    let night = refused(4, &night);
    assert!(night.contains("nothing shines"), "{night}");
}

#[test]
fn one_crossing_of_a_cube_is_printed_with_its_standard_error() {
    let flags = [
        "eval",
        "ice",
        "--cube-m",
        "50",
        "--wavelengths-nm",
        "400,520,700",
    ];
    let output = String::from_utf8(niji_ends_with(0, &flags).stdout).unwrap();
    let mut lines = output.lines();
    assert_eq!(
        lines.next(),
        Some("wavelength_nm,absorption_per_m,transmittance,standard_error")
    );
    // From an independent Monte Carlo over chords: exp(-33.3 alpha) would be low by 14 % at 520 nm.
    for (line, [nm, alpha, passed]) in lines.zip([[400.0, 7.43e-4, 0.9757], [520.0, 0.0260, 0.477]])
    {
        let values: Vec<f64> = line
            .split(',')
            .map(|field| field.parse().unwrap())
            .collect();
        assert_eq!(values[0], nm);
        assert!((values[1] / alpha - 1.0).abs() < 2e-3);
        assert!((values[2] / passed - 1.0).abs() < 5e-3, "{line}");
        assert!(values[3] > 0.0 && values[3] < 1e-4);
    }
    niji_ends_with(
        2,
        &["eval", "ice", "--cube-m", "0", "--wavelengths-nm", "400"],
    );
    niji_ends_with(
        2,
        &["eval", "ice", "--cube-m", "1", "--wavelengths-nm", "5000"],
    );
}

#[test]
fn the_stages_say_which_command_makes_a_scene_of_ice() {
    for stage in [&["plan"][..], &["run", "-o", "nowhere"]] {
        let scene = support::repository("data/scenes/ice-cube-50-m.toml");
        let output = niji_ends_with(3, &[stage, &[text(&scene)]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains("`niji ice "), "{message}");
    }
}

#[test]
fn the_example_sets_an_iceberg_under_a_rainbow() {
    let folder = tempfile::tempdir().unwrap();
    let [examples, scenes] = ["examples", "data/scenes"].map(|name| folder.path().join(name));
    fs::create_dir(&examples).unwrap();
    fs::create_dir_all(&scenes).unwrap();
    let script = examples.join("iceberg_under_a_rainbow.sh");
    let shipped = support::repository("examples/iceberg_under_a_rainbow.sh");
    fs::copy(shipped, &script).unwrap();
    let small = [("camera.width_px", "64"), ("camera.height_px", "40")];
    let few_paths = r#"{ level = "path-traced", paths_per_pixel = 8 }"#;
    let ice = [
        ("accuracy.transport", few_paths),
        ("spectrum.step_nm", "50.0"),
    ];
    let rain = [
        ("accuracy.preset", "\"draft\""),
        ("spectrum.step_nm", "50.0"),
    ];
    let grid = [
        ("spectrum.first_nm", "400.0"),
        ("spectrum.n_wavelengths", "7"),
    ];
    support::variant(
        "ice-iceberg-rainbow.toml",
        &scenes,
        &[&small[..], &ice, &grid].concat(),
    );
    let rain = [&small[..], &rain, &grid].concat();
    support::variant("ice-iceberg-rainbow-rain.toml", &scenes, &rain);
    let out = folder.path().join("out");
    let run = std::process::Command::new("sh")
        .args([text(&script), text(&out), env!("CARGO_BIN_EXE_niji")])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{message}");
    let picture = niji_photo::Photograph::read(&out.join("rainbow.png")).unwrap();
    let (ice, bow) = (out.join("ice.exr"), out.join("image.exr"));
    let ice = niji_photo::Photograph::read(&ice).unwrap();
    // The ice hides the rain behind it, and the sky has a bow.
    let bow = SpectralImage::read_spectral(&bow).unwrap();
    let primary = bow
        .aovs
        .iter()
        .find(|aov| aov.name == "bow_primary")
        .unwrap();
    let luminance = &primary.channels[1].1;
    let brightest = luminance.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 0.0 && luminance[[20, 30]] < 0.01 * brightest);
    // Snow in the sun is nearly white; nothing is black.
    let greens = || picture.light.iter().map(|rgb| rgb[1]);
    assert!(greens().fold(0.0, f32::max) > 0.8);
    let mean = greens().sum::<f32>() / greens().count() as f32;
    assert!(mean > 0.08 && mean < 0.6, "{mean}");
    assert_eq!(ice.light.dim(), (40, 64));
}
