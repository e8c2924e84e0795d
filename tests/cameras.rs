//! Cameras other than a pinhole, and meshes before the drops, by the program.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use niji_exchange::AttributeValue;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_exchange::TableFile;
use niji_scene::Scene;
use support::niji_ends_with;
use support::profile;
use support::text;
use support::variant;

/// Bows alone, coarse drops, three wavelengths.
const QUICK: [(&str, &str); 8] = [
    ("spectrum.first_nm", "450.0"),
    ("spectrum.step_nm", "100.0"),
    ("spectrum.n_wavelengths", "3"),
    ("effects.sky", "\"off\""),
    ("effects.air_inscatter", "\"off\""),
    ("effects.skylit_drops", "\"off\""),
    ("effects.multiple_scattering", "\"off\""),
    ("drops.voxel_m", "150.0"),
];

/// Bow angle of the table's largest value around the primary bow at its wavelength `index` [deg].
fn bow_of_table_deg(table: &ScatteringTable, index: usize) -> f64 {
    let value = |angle: usize| {
        table.values[[0, 0, 0, index, angle]] + table.values[[1, 0, 0, index, angle]]
    };
    let bow_deg = |angle: usize| 180.0 - table.theta_rad[angle].to_degrees();
    let angles = 0..table.theta_rad.len();
    let near = angles.filter(|angle| (38.0..44.0).contains(&bow_deg(*angle)));
    bow_deg(near.max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap())
}

#[test]
fn the_whole_circle_of_the_shipped_scene_stands_where_its_table_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let side = [("camera.width_px", "480"), ("camera.height_px", "480")];
    let changes = [&QUICK[..], &side].concat();
    let file = variant("full-circle-bow.toml", folder.path(), &changes);
    let run = folder.path().join("run");
    niji_ends_with(0, &["run", text(&file), "-o", text(&run), "-q"]);
    let scene = Scene::from_toml(&fs::read_to_string(&file).unwrap()).unwrap();
    let image = SpectralImage::read_spectral(&run.join("image.exr")).unwrap();
    let table = TableFile::read(&run.join("scatter.exr")).unwrap();
    let table = ScatteringTable::from_file(table).unwrap();
    // Each quarter of the circle by itself, so that a circle that is no circle shows.
    for [right, low] in [[false, false], [true, false], [false, true], [true, true]] {
        let quarter = |x: usize, y: usize| [x >= 240, y >= 240] == [right, low];
        for (index, wavelength_nm) in [450.0, 550.0, 650.0].into_iter().enumerate() {
            let found_deg = profile(&image, &scene, wavelength_nm, quarter).peak_deg(38.0, 44.0);
            let expected_deg = bow_of_table_deg(&table, index);
            // A pixel spans 0.27 degrees, a step of the profile 0.1; measured 0.026.
            let away_deg = (found_deg - expected_deg).abs();
            assert!(
                away_deg < 0.1,
                "{wavelength_nm} nm: {found_deg} {expected_deg}"
            );
        }
    }
    let corner = image.radiance[[1, 2, 2]];
    assert_eq!(corner.to_bits(), 0, "outside the image circle");
    let name = AttributeValue::Text("fisheye-equidistant".to_owned());
    assert_eq!(image.attributes.get("niji:projection"), Some(&name));
    assert!(image.world_to_camera.is_some());
}

/// A wall as OBJ.
fn wall(folder: &Path, name: &str, corners: [[f64; 3]; 4]) -> String {
    let lines = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let path = folder.join(name);
    fs::write(&path, lines + "f 1 2 3 4\n").unwrap();
    text(&path).to_owned()
}

fn lit(image: &Path) -> f64 {
    let image = SpectralImage::read_spectral(image).unwrap();
    image.radiance.iter().map(|light| f64::from(*light)).sum()
}

#[test]
fn meshes_hide_the_rain_behind_them_and_bad_ones_end_with_code_3() {
    let folder = tempfile::tempdir().unwrap();
    let small = [("camera.width_px", "32"), ("camera.height_px", "24")];
    let changes = [&QUICK[..], &small].concat();
    let scene = variant("rain-shaft-5-mm-h.toml", folder.path(), &changes);
    let run = folder.path().join("run");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&run), "-q"]);
    let inside = |name: &str| text(&run.join(name)).to_owned();
    let stages = [
        inside("drops.vdb"),
        inside("scatter.exr"),
        inside("atmosphere.exr"),
    ];
    let render = |code: i32, scene: &Path, name: &str, more: &[&str]| {
        let image = folder.path().join(name);
        let [drops, table, air] = &stages;
        let mut arguments = vec!["render", "--scene", text(scene), "--drops", drops];
        arguments.extend(["--table", table, "--air", air, "-q", "-o", text(&image)]);
        arguments.extend(more);
        let output = niji_ends_with(code, &arguments);
        (image, String::from_utf8(output.stderr).unwrap())
    };
    let open = lit(&run.join("image.exr"));
    assert!(open > 0.0);
    let far = 1e4;
    let near = [
        [-far, -far, -500.0],
        [far, -far, -500.0],
        [far, far, -500.0],
        [-far, far, -500.0],
    ];
    let near = wall(folder.path(), "near.obj", near);
    let (image, _) = render(0, &scene, "near.exr", &["--mesh", &near]);
    assert!(lit(&image).abs() < f64::MIN_POSITIVE, "all of it is hidden");
    let behind = [
        [-far, -far, -9e3],
        [far, -far, -9e3],
        [far, far, -9e3],
        [-far, far, -9e3],
    ];
    let behind = wall(folder.path(), "behind.obj", behind);
    let (image, _) = render(0, &scene, "behind.exr", &["--mesh", &behind]);
    assert!((lit(&image) / open - 1.0).abs() < 1e-12);

    // The same wall in a scene: half of it, in kilometres, lying, with z up.
    let half = [
        [-10.0, 0.0, -10.0],
        [0.0, 0.0, -10.0],
        [0.0, 0.0, 10.0],
        [-10.0, 0.0, 10.0],
    ];
    wall(folder.path(), "half.obj", half);
    let section = "\n[[occluders.meshes]]\nfile = \"half.obj\"\nup = \"z\"\nscale = 1000.0\n\
                   position_m = [0.0, 0.0, -500.0]\n";
    let with_mesh = folder.path().join("with-mesh.toml");
    let text_of = fs::read_to_string(&scene).unwrap() + section;
    fs::write(&with_mesh, text_of).unwrap();
    let (image, _) = render(0, &with_mesh, "half.exr", &[]);
    let image = SpectralImage::read_spectral(&image).unwrap();
    let [left, right] = [4, 27].map(|x| image.radiance[[1, 12, x]]);
    assert!(left.abs() < f32::MIN_POSITIVE && right > 0.0);
    let surface = image.aovs.iter().find(|aov| aov.name == "surface").unwrap();
    let distance_m = surface.channels[0].1[[12, 4]];
    assert!(distance_m > 500.0 && distance_m < 800.0, "{distance_m}");

    let nan = folder.path().join("nan.obj");
    fs::write(&nan, "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n").unwrap();
    let empty = folder.path().join("empty.obj");
    fs::write(&empty, "").unwrap();
    for (mesh, found) in [
        (text(&nan), "nan.obj"),
        (text(&empty), "without a triangle"),
        ("no-such-mesh.obj", "no-such-mesh.obj"),
        (text(&scene), "expected a mesh named"),
    ] {
        let (image, message) = render(3, &scene, "never.exr", &["--mesh", mesh]);
        assert!(message.contains(found), "{message}");
        assert!(!image.exists());
    }
}
