//! Shapes from scene files and from flags: their drops, their bows, and what stands where none are.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use glam::DVec3;
use niji_exchange::SpectralImage;
use niji_geometry::Aabb;
use niji_radiometry::Colorimetry;
use niji_radiometry::solar_irradiance;
use niji_scene::DropSource;
use niji_scene::Scene;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;
use serde_json::Value;
use support::niji_ends_with;
use support::repository;
use support::run_scene;
use support::text;
use support::variant;

const SMALL: [(&str, &str); 5] = [
    ("camera.width_px", "80"),
    ("camera.height_px", "60"),
    ("accuracy.preset", "\"draft\""),
    // Rows of a table for every few per cent of radius are not needed here.
    ("accuracy.theory", "\"geometric\""),
    ("accuracy.pixel_footprint", "\"center\""),
];

fn message(code: i32, arguments: &[&str]) -> String {
    String::from_utf8(niji_ends_with(code, arguments).stderr).unwrap()
}

fn summary(drops: &Path) -> Value {
    let json = niji_ends_with(0, &["info", text(drops), "--json"]).stdout;
    serde_json::from_slice(&json).unwrap()
}

/// Light of both bows at every pixel, and whether the ray through its center meets the box.
fn bow_light(scene: &Scene, image: &SpectralImage, bounds: &Aabb) -> Vec<(bool, f64)> {
    let camera = scene.camera.pinhole().unwrap();
    let bows = image.aovs.iter().filter(|aov| aov.name.starts_with("bow_"));
    let planes: Vec<_> = bows
        .flat_map(|aov| &aov.channels)
        .map(|(_, plane)| plane)
        .collect();
    assert_eq!(planes.len(), 6, "X, Y, Z of two bows");
    let (height, width) = planes[0].dim();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let light = |(x, y): (usize, usize)| {
        let ray = camera.ray(x as f64 + 0.5, y as f64 + 0.5);
        let meets = bounds.intersect(&ray).is_some();
        (
            meets,
            planes
                .iter()
                .map(|plane| f64::from(plane[[y, x]]).abs())
                .sum(),
        )
    };
    pixels.map(light).collect()
}

#[test]
fn there_is_no_bow_where_there_is_no_spray() {
    for name in ["garden-fountain.toml", "waterfall-gorge.toml"] {
        let folder = tempfile::tempdir().unwrap();
        // Wide enough for rays that miss the spray.
        let wide = [&SMALL[..], &[("camera.horizontal_fov_deg", "110.0")]].concat();
        let scene = variant(name, folder.path(), &wide);
        let (scene, image) = run_scene(&scene, &folder.path().join("out"));
        let grid = scene.drops.shape().unwrap().grid();
        // Trilinear drops fade out over the voxel beyond the outermost nodes.
        let (min, max) = (grid.min - grid.voxel_m, grid.max + grid.voxel_m);
        let pixels = bow_light(&scene, &image, &Aabb { min, max });
        let of = |inside: bool| pixels.iter().filter(move |(meets, _)| *meets == inside);
        let sum = |inside: bool| of(inside).map(|(_, light)| light).sum::<f64>();
        assert!(
            of(false).count() > 300,
            "{name}: {} pixels beside it",
            of(false).count()
        );
        assert_eq!(sum(false), 0.0, "{name}");
        assert!(sum(true) > 0.0, "{name}");
    }
}

/// Luminance and x, y against the bow angle in steps of half a degree.
fn colors(scene: &Scene, image: &SpectralImage) -> Vec<[f64; 3]> {
    let colorimetry = Colorimetry::new(&image.wavelengths);
    let camera = scene.camera.pinhole().unwrap();
    let antisolar = -scene.sun.direction();
    let mut sums = vec![[0.0; 4]; 120];
    let (n, height, width) = image.radiance.dim();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let direction = camera.ray(x as f64 + 0.5, y as f64 + 0.5).direction;
        let step = (2.0 * direction.angle_between(antisolar).to_degrees()) as usize;
        let spectrum: Vec<f64> = (0..n)
            .map(|i| f64::from(image.radiance[[i, y, x]]))
            .collect();
        let xyz = colorimetry.xyz(&spectrum);
        if let Some(sum) = sums.get_mut(step) {
            *sum = [
                sum[0] + xyz[0],
                sum[1] + xyz[1],
                sum[2] + xyz[2],
                sum[3] + 1.0,
            ];
        }
    }
    let color = |[x, y, z, n]: &[f64; 4]| [y / n, x / (x + y + z), y / (x + y + z)];
    sums.iter().map(color).collect()
}

#[test]
fn a_fogbow_is_broad_and_white() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("camera.width_px", "160"),
        ("camera.height_px", "120"),
        // Reddens the light before it meets the drops.
        ("effects.sunlight_through_air", "\"off\""),
        ("effects.air_inscatter", "\"off\""),
        // Brighter far from the bow than near it.
        ("effects.skylit_drops", "\"off\""),
    ];
    let scene = variant("fog-bank-fogbow.toml", folder.path(), &changes);
    let (scene, image) = run_scene(&scene, &folder.path().join("out"));
    let colors = colors(&scene, &image);
    let peak = (66..88)
        .max_by(|&a, &b| colors[a][0].total_cmp(&colors[b][0]))
        .unwrap();
    let half = 0.5 * colors[peak][0];
    let below = |step: &usize| colors[*step][0] < half;
    let outer = (peak..120).find(below).expect("dark outside the bow");
    let inner = (0..peak).rev().find(below).map_or(0, |step| step + 1);
    let width_deg = 0.5 * (outer - inner) as f64;
    assert!(width_deg > 4.0, "{width_deg} degrees");

    let sun = Colorimetry::new(&image.wavelengths).xyz(&solar_irradiance(&image.wavelengths));
    let total: f64 = sun.iter().sum();
    let [_, x, y] = colors[peak];
    let off = (x - sun[0] / total).hypot(y - sun[1] / total);
    assert!(off < 0.03, "chromaticity {x}, {y} is {off} from sunlight");
}

#[test]
fn the_depth_of_a_rain_shaft_follows_marshall_and_palmer() {
    let folder = tempfile::tempdir().unwrap();
    for (rate, name) in [(1.0_f64, "1"), (5.0, "5"), (25.0, "25")] {
        let scene = repository("data/scenes").join(format!("rain-shaft-{name}-mm-h.toml"));
        let drops = folder.path().join(format!("{name}.vdb"));
        niji_ends_with(
            0,
            &["drops", "--scene", text(&scene), "-o", text(&drops), "-q"],
        );
        let found = summary(&drops)["drops"]["optical_depth"][2]
            .as_f64()
            .unwrap();
        // pi N0/Lambda³ across 600 m, N0 = 8000 m⁻³ mm⁻¹, Lambda = 4.1 R^-0.21 mm⁻¹.
        let slope_per_mm = 4.1 * rate.powf(-0.21);
        let expected = 600.0 * 1e-6 * std::f64::consts::PI * 8000.0 / slope_per_mm.powi(3);
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{rate} mm/h: {found}, {expected}"
        );
    }
}

#[test]
fn every_scene_that_ships_can_be_planned() {
    let entries = fs::read_dir(repository("data/scenes")).unwrap();
    // Scenes of ice have no plan.
    let is_ice = |path: &PathBuf| {
        fs::read_to_string(path)
            .unwrap()
            .contains("\n[ice.shape]\n")
    };
    let scenes = entries.map(|entry| entry.unwrap().path());
    let scenes: Vec<_> = scenes.filter(|path| !is_ice(path)).collect();
    assert!(scenes.len() >= 19, "{}", scenes.len());
    for scene in scenes {
        niji_ends_with(0, &["plan", text(&scene)]);
    }
}

#[test]
fn flags_and_scene_make_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (by_scene, by_flags) = (
        folder.path().join("scene.vdb"),
        folder.path().join("flags.vdb"),
    );
    let scene = repository("data/scenes/rain-cell.toml");
    niji_ends_with(
        0,
        &[
            "drops",
            "--scene",
            text(&scene),
            "-o",
            text(&by_scene),
            "-q",
        ],
    );
    let flags = "drops rain-cell --max-rain-rate-mm-h 30 --radius-m 700 --center-xz-m=2430,-1760 \
                 --base-y-m 0 --top-y-m 1800 --wind-shear-xz-1-s 0.002,0 --turbulence-strength 0.6 \
                 --turbulence-eddy-m 400 --turbulence-seed 7 --voxel-m 60 -q -o";
    let mut arguments: Vec<&str> = flags.split_whitespace().collect();
    arguments.push(text(&by_flags));
    niji_ends_with(0, &arguments);
    assert!(fs::read(by_scene).unwrap() == fs::read(by_flags).unwrap());
}

#[test]
fn every_size_law_can_be_evaluated() {
    // Effective radius (um) by hand from the moments of each law.
    let slope_per_mm = 4.1 * 5.0_f64.powf(-0.21);
    let rain_um = 1500.0 / slope_per_mm;
    let ulbrich = format!("ulbrich --shape 0 --slope-per-mm {slope_per_mm}");
    let normal = "--radius-mean-um 50 --radius-standard-deviation-um 10";
    let cut = format!("truncated-normal {normal} --d-min-mm 0.001 --d-max-mm 1");
    for (law, radius_um) in [
        ("monodisperse --radius-um 10", 10.0),
        (
            "uniform --radius-min-um 10 --radius-max-um 90",
            50.0 * 4100.0 / (9100.0 / 3.0),
        ),
        (&format!("normal {normal}"), 140.0 / 2.6),
        (&cut, 140.0 / 2.6),
        (
            "modified-gamma --alpha 6 --b-per-um-gamma 1.5 --gamma 1",
            6.0,
        ),
        (
            "hansen-travis --effective-radius-um 10 --effective-variance 0.1",
            10.0,
        ),
        (&ulbrich, rain_um),
        (
            "lognormal --radius-median-um 50 --geometric-standard-deviation 1.5",
            50.0 * (2.5 * 1.5_f64.ln().powi(2)).exp(),
        ),
        // 1/Gamma(3/4) = 0.816049.
        (
            "rosin-rammler --diameter-mm 1 --spread 4",
            500.0 * 0.816_049,
        ),
    ] {
        // 0.1 g of water: 3 LWC/(2 rho r_e) of extinction, whatever the law.
        let bulk = sizes(&format!("{law} --lwc-g-m3 0.1"));
        assert!(
            (1e6 * bulk[3] / radius_um - 1.0).abs() < 1e-4,
            "{law}: {bulk:?}"
        );
        assert!(
            (bulk[2] * bulk[3] / 0.15e-6 - 1.0).abs() < 1e-12,
            "{law}: {bulk:?}"
        );
        let again = sizes(&format!("{law} --number-density-m3 {}", bulk[0]));
        assert!((again[1] / 0.1 - 1.0).abs() < 1e-12, "{law}: {again:?}");
    }
    for (law, number_density_m3) in [
        ("marshall-palmer --rain-rate-mm-h 5", 8000.0 / slope_per_mm),
        // Z = 296 R^1.47 at 5 mm/h.
        (
            "marshall-palmer-dbz --reflectivity-dbz 34.988",
            8000.0 / slope_per_mm,
        ),
        ("cloud --preset fog", 15e6),
    ] {
        let bulk = sizes(law);
        assert!(
            (bulk[0] / number_density_m3 - 1.0).abs() < 1e-3,
            "{law}: {bulk:?}"
        );
    }
    let arguments = "eval sizes --law cloud --preset fog --lwc-g-m3 0.1".split_whitespace();
    let found = message(2, &arguments.collect::<Vec<_>>());
    assert!(found.contains("--lwc-g-m3"), "{found}");
}

/// The numbers of `niji eval sizes`.
fn sizes(law: &str) -> Vec<f64> {
    let line = format!("eval sizes --law {law}");
    let arguments: Vec<&str> = line.split_whitespace().collect();
    let printed = String::from_utf8(niji_ends_with(0, &arguments).stdout).unwrap();
    let values = printed.lines().nth(1).unwrap().split(',');
    values.map(|value| value.parse().unwrap()).collect()
}

#[test]
fn wrong_flags_of_a_shape_are_named() {
    let spray = "drops sea-spray --box-min-m=0,0,0 --box-max-m=8,8,8 --voxel-m 1 \
                 --surface-lwc-g-m3 0.1 --scale-height-m 5 --median-radius-um 40 -o never.vdb";
    for (more, named) in [
        (
            "--geometric-standard-deviation 0.7",
            "--geometric-standard-deviation",
        ),
        ("", "--geometric-standard-deviation"),
        (
            "--geometric-standard-deviation nan",
            "--geometric-standard-deviation",
        ),
        (
            "--geometric-standard-deviation 1.5 --radius-um 10",
            "--radius-um",
        ),
        (
            "--geometric-standard-deviation 1.5 --turbulence-seed 1",
            "--turbulence-strength",
        ),
    ] {
        let line = format!("{spray} {more}");
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let found = message(2, &arguments);
        assert!(found.contains(named), "{more}: {found}");
    }
    assert!(!Path::new("never.vdb").exists());
}

#[test]
fn misspelt_keys_of_shapes_keep_their_line_at_any_depth() {
    let folder = tempfile::tempdir().unwrap();
    for (name, right, wrong) in [
        ("garden-fountain.toml", "spread_deg", "spraed_deg"),
        ("waterfall-gorge.toml", "mist_fraction", "mist_fracton"),
        ("sea-spray.toml", "strength", "strenght"),
        ("rain-cell.toml", "\"rain-cell\"\nmax", "\"rain-cel\"\nmax"),
        ("fog-bank-fogbow.toml", "\"even\"", "\"evn\""),
    ] {
        let sound = fs::read_to_string(repository("data/scenes").join(name)).unwrap();
        let misspelt = sound.replacen(right, wrong, 1);
        assert_ne!(sound, misspelt, "{name}");
        let same = |(a, b): &(&str, &str)| a == b;
        let line = 1 + sound.lines().zip(misspelt.lines()).take_while(same).count();
        let scene = folder.path().join(name);
        fs::write(&scene, misspelt).unwrap();
        let found = message(3, &["plan", text(&scene)]);
        let word = right.trim_matches('"').split('"').next().unwrap();
        let suggestion = format!("did you mean `{word}`");
        assert!(
            found.contains(&format!("line {line}:")) && found.contains(&suggestion),
            "{found}"
        );
    }
}

/// A ball of smoke as another program would write it, beside a grid of velocities.
fn smoke(path: &Path) {
    let transform = Transform::uniform_scale_translate(2.0, DVec3::new(-20.0, 0.0, -80.0));
    let mut leaves = Vec::new();
    for corner in 0..27 {
        let origin = [corner / 9 % 3, corner / 3 % 3, corner % 3].map(|step| 8 * step);
        let mut leaf = Leaf::new(origin, 0.0);
        for index in 0..512 {
            let voxel = leaf.voxel(index);
            let away = voxel.map(|i| f64::from(i) - 11.5);
            let r2: f64 = away.iter().map(|a| a * a).sum();
            if r2 < 100.0 {
                leaf.set(voxel, (1.0 - r2 / 100.0) as f32);
            }
        }
        leaves.push(leaf);
    }
    let tree = FloatTree::from_leaves(0.0, leaves).unwrap();
    let file = VdbFile::new(vec![Grid::new("smoke", FOG_VOLUME, transform, tree)]);
    let mut writer = fs::File::create(path).unwrap();
    file.write(&mut writer, Compression::Zip).unwrap();
}

#[test]
fn smoke_of_another_program_becomes_a_bow() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    smoke(&inside("smoke.vdb"));

    // A scene that takes the file for drops is told what to do, and does it.
    let sound = fs::read_to_string(repository("data/scenes/garden-fountain.toml")).unwrap();
    let start = sound.find("shape = ").unwrap();
    let end = sound.find("[air]").unwrap();
    let scene_with = |name: &str, drops: &str| {
        let scene = inside(name);
        let text = format!("{}{drops}\n\n{}", &sound[..start], &sound[end..]);
        let text = text.replace("azimuth_deg = -70.0", "azimuth_deg = 0.0");
        let text = text.replace("azimuth_deg = 110.0", "azimuth_deg = 180.0");
        fs::write(&scene, text.replace("480", "80").replace("360", "60")).unwrap();
        scene
    };
    let as_drops = scene_with("as-drops.toml", "file = \"smoke.vdb\"");
    let out = inside("out");
    for command in [&["plan"][..], &["run", "-o", text(&out)]] {
        let found = message(3, &[command, &[text(&as_drops)]].concat());
        assert_eq!(found.trim_end().lines().count(), 1, "{found}");
        assert!(
            found.contains("niji drops from-vdb") && found.contains("--grid=smoke"),
            "{found}"
        );
    }
    let found = message(3, &["plan", text(&as_drops)]);
    let advice = found.split("niji ").nth(1).unwrap().trim_end();
    let drops = inside("drops.vdb");
    let advice = advice.replace("-o drops.vdb", &format!("-q -o {}", text(&drops)));
    let arguments: Vec<&str> = advice.split_whitespace().collect();
    niji_ends_with(0, &arguments);
    let depths = &summary(&drops)["drops"]["optical_depth"];
    let deepest = (0..3)
        .map(|axis| depths[axis].as_f64().unwrap())
        .fold(0.0, f64::max);
    assert!((deepest - 1.0).abs() < 1e-3, "{depths}");

    // The same in a scene; the drops have the bytes of the command's.
    let from_vdb = "shape = \"from-vdb\"\nfile = \"smoke.vdb\"\ngrid = \"smoke\"\n\
                    density_means = \"optical-depth\"\nscale = 1\neffective_radius_um = 100";
    let scene = scene_with("from-vdb.toml", from_vdb);
    let (scene, image) = run_scene(&scene, &out);
    assert!(matches!(
        scene.drops.populations()[0].source,
        DropSource::FromVdb(_)
    ));
    assert!(fs::read(&drops).unwrap() == fs::read(out.join("drops.vdb")).unwrap());
    let bow = image
        .aovs
        .iter()
        .find(|aov| aov.name == "bow_primary")
        .unwrap();
    let light: f32 = bow.channels[1].1.iter().sum();
    assert!(light > 0.0);
    let misspelt = scene_with(
        "wrong.toml",
        &from_vdb.replace("density_means", "density_mean"),
    );
    assert!(message(3, &["plan", text(&misspelt)]).contains("did you mean `density_means`"));
}

#[test]
fn a_formula_or_a_grid_that_is_mistyped_is_told_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("smoke.vdb");
    smoke(&file);
    let drops = folder.path().join("drops.vdb");
    let made = |code, grid: &str, radius: &str| {
        let arguments = [
            "drops",
            "from-vdb",
            text(&file),
            "--grid",
            grid,
            "--density-means",
            "water",
            "--scale",
            "1",
            "--effective-radius-um",
            radius,
            "-o",
            text(&drops),
            "-q",
        ];
        message(code, &arguments)
    };
    for (code, grid, radius, expected) in [
        (3, "smok", "10", "grid `smok` is missing; the file holds"),
        (
            3,
            "smoke",
            "6 + heet/2",
            "names `heet` at column 5; the file holds the grids",
        ),
        (
            2,
            "smoke",
            "6 + * 2",
            "has '*' at column 5, expected a number",
        ),
        (
            2,
            "smoke",
            "0",
            "--effective-radius-um = 0, expected a radius above 0",
        ),
        (
            3,
            "smoke",
            "smoke - 1e9",
            "a formula that comes to a radius above 0",
        ),
    ] {
        let said = made(code, grid, radius);
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        assert!(said.contains(expected), "{said}");
    }
    assert!(!drops.exists());
    assert_eq!(made(0, "smoke", "10 + smoke"), "");
    let help = niji_ends_with(0, &["drops", "from-vdb", "--help"]).stdout;
    let help = String::from_utf8(help).unwrap();
    for flag in ["--up", "--units-per-m", "--voxel-m", "6 + 0.5*sqrt(age)"] {
        assert!(help.contains(flag), "{help}");
    }
}
