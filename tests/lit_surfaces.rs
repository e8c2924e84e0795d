//! Lit meshes and terrain of scenes: under the sky of all orders, from files that are sound and that are not.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use glam::DVec3;
use ndarray::Array3;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::ViewRay;
use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_picture::KeptParts;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::SurfaceFiles;
use niji_picture::unwatched;
use niji_scene::Effect;
use niji_scene::Scene;
use support::niji_ends_with;
use support::text;

use std::f64::consts::FRAC_1_PI;
use std::f64::consts::TAU;

/// A meter above the ground; the only drops are behind the eye.
const SCENE: &str = r#"
format = 1
name = "lit"
[sun]
elevation_deg = 25.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.0, 0.0]
azimuth_deg = 0.0
elevation_deg = -60.0
horizontal_fov_deg = 5.0
width_px = 4
height_px = 3
[spectrum]
first_nm = 450.0
step_nm = 100.0
n_wavelengths = 3
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, 200.0]
box_max_m = [50.0, 50.0, 300.0]
number_density_m3 = 1.0
law = { monodisperse = { radius_um = 500.0 } }
voxel_m = 50.0
[air]
constituents = ["rayleigh"]
[ground]
albedo = 0.25
[effects]
drop_shadow = "off"
"#;

const ALBEDO: f64 = 0.25;
const FLOOR: &str =
    "v -9000 0 -9000\nv 9000 0 -9000\nv 9000 0 9000\nv -9000 0 9000\nf 1 2 3\nf 1 3 4\n";

fn plan(text: &str, folder: &Path) -> Result<PlannedScene, niji_picture::Error> {
    let request = PlanRequest {
        folder,
        ..PlanRequest::default()
    };
    PlannedScene::new(Scene::from_toml(text).unwrap(), request)
}

fn planned(text: &str, folder: &Path) -> PlannedScene {
    plan(text, folder).unwrap()
}

/// Radiance of a scene, and its air.
fn seen(text: &str, folder: &Path) -> (Array3<f32>, AtmosphereTable) {
    let planned = planned(text, folder);
    let settings = PictureSettings::of(&planned);
    let whole = settings.whole().unwrap();
    let parts = KeptParts::default()
        .parts(&planned, ("", None), &unwatched)
        .unwrap();
    let air = parts.air.clone().unwrap();
    let work = PictureWork::new(settings, parts, &unwatched).unwrap();
    (work.render(whole, &unwatched).unwrap().radiance, air)
}

fn gray_png(path: &Path, size: [u32; 2], codes: impl Iterator<Item = u16>) {
    let file = fs::File::create(path).unwrap();
    let mut encoder = png::Encoder::new(file, size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let bytes: Vec<u8> = codes.flat_map(u16::to_be_bytes).collect();
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&bytes)
        .unwrap();
}

fn sun() -> DVec3 {
    let (sin, cos) = 25.0_f64.to_radians().sin_cos();
    DVec3::new(0.0, sin, cos)
}

/// Irradiance of sun and sky on the ground by wavelength [W m⁻² nm⁻¹].
fn irradiance_of_ground(air: &AtmosphereTable) -> Vec<f64> {
    let cos_sun = sun().y;
    let diffuse = air.diffuse.as_ref().unwrap().ground_irradiance(cos_sun);
    let irradiance = |(index, diffuse): (usize, &f32)| {
        let direct = cos_sun * (-air.optical_depth_at(index, 0.0, cos_sun)).exp();
        air.sun_irradiance[index] * (direct + f64::from(*diffuse))
    };
    diffuse.iter().enumerate().map(irradiance).collect()
}

#[test]
fn a_level_surface_sends_the_irradiance_of_sun_and_sky_over_pi() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
    gray_png(&folder.path().join("flat.png"), [9, 9], (0..81).map(|_| 0));
    let (ground, air) = seen(SCENE, folder.path());
    let irradiance = irradiance_of_ground(&air);
    let mesh = "[[occluders.meshes]]\nfile = \"floor.obj\"\nalbedo = 0.25\n";
    let painted = mesh.replace("0.25", "[0.25, 0.25, 0.25]");
    let terrain =
        "[terrain]\nfile = \"flat.png\"\nspacing_m = 500\nheight_m = [0, 800]\nalbedo = 0.25\n";
    for surfaces in [mesh, &painted, terrain] {
        let (lit, _) = seen(&format!("{SCENE}{surfaces}"), folder.path());
        for ((index, y, x), found) in lit.indexed_iter() {
            let found = f64::from(*found);
            let expected = ALBEDO * FRAC_1_PI * irradiance[index];
            // Measured 3e-5: a meter of air, and the level of the ways through the air.
            assert!(
                (found / expected - 1.0).abs() < 5e-4,
                "{surfaces}: {found} {expected}"
            );
            let as_ground = f64::from(ground[[index, y, x]]);
            assert!(
                (found / as_ground - 1.0).abs() < 5e-4,
                "{surfaces}: {found} {as_ground}"
            );
        }
    }
}

#[test]
fn ground_mesh_and_terrain_of_a_name_have_the_spectrum_that_was_measured() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
    gray_png(&folder.path().join("flat.png"), [9, 9], (0..81).map(|_| 0));
    // Sand, the fifth column of its table, by the trapezoid rule from 400 to 500 nm and so on.
    let sand: Vec<f64> = include_str!("../data/ground_reflectances.csv")
        .lines()
        .filter_map(|line| line.split(',').nth(5)?.parse().ok())
        .collect();
    let measured = [5, 15, 25].map(|from| {
        let inner: f64 = sand[from + 1..from + 10].iter().sum();
        0.1 * (0.5 * (sand[from] + sand[from + 10]) + inner)
    });
    let ground = SCENE.replace("albedo = 0.25", "albedo = \"sand\"");
    let mesh = "[[occluders.meshes]]\nfile = \"floor.obj\"\nalbedo = \"sand\"\n";
    let terrain =
        "[terrain]\nfile = \"flat.png\"\nspacing_m = 500\nheight_m = [0, 800]\nalbedo = \"sand\"\n";
    for surfaces in ["", mesh, terrain] {
        let (lit, air) = seen(&format!("{ground}{surfaces}"), folder.path());
        let irradiance = irradiance_of_ground(&air);
        for ((index, _, _), found) in lit.indexed_iter() {
            let expected = measured[index] * FRAC_1_PI * irradiance[index];
            assert!(
                (f64::from(*found) / expected - 1.0).abs() < 5e-4,
                "{surfaces}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_surface_has_the_light_of_the_sky_where_that_itself_is_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
    let mesh = "[[occluders.meshes]]\nfile = \"floor.obj\"\nalbedo = 0.25\n";
    let with = |effects: &str| {
        let switched = SCENE.replace("[effects]\n", &format!("[effects]\n{effects}\n"));
        seen(&format!("{switched}{mesh}"), folder.path()).0
    };
    let all = with("");
    // No effect but that of the surface needs air.
    let off = "sky = \"off\"\nair_inscatter = \"off\"\nair_extinction = \"off\"\nskylit_drops = \"off\"\n\
               sunlight_through_air = \"off\"";
    for (alone, all) in with(off).iter().zip(&all) {
        assert!((alone / all - 1.0).abs() < 1e-3, "{alone} {all}");
    }
}

/// Irradiance of sky and ground on a face, by the radiances of all directions in front of it (W m⁻² nm⁻¹).
fn irradiance_around(air: &AtmosphereTable, normal: DVec3) -> Vec<f64> {
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    let single = SingleScattering::new(air, InScattering::Quadrature { n_nodes: 12 });
    let diffuse = DiffuseSky::new(air).unwrap();
    let mut sum = vec![0.0; air.wavelengths.len()];
    let (n_elevations, n_azimuths) = (60, 48);
    for row in 0..n_elevations {
        let sine = -1.0 + 2.0 * (f64::from(row) + 0.5) / f64::from(n_elevations);
        let cosine = (1.0 - sine * sine).sqrt();
        for column in 0..n_azimuths {
            let (east, south) = (TAU * (f64::from(column) + 0.5) / f64::from(n_azimuths)).sin_cos();
            let direction = DVec3::new(cosine * east, sine, cosine * south);
            let towards = normal.dot(direction);
            if towards > 0.0 {
                let ray = ViewRay::new(planet, [DVec3::Y, direction, sun()], f64::INFINITY);
                let further = diffuse.radiance_per_sun(&ray);
                let share = towards * 2.0 * TAU / f64::from(n_elevations * n_azimuths);
                for (index, light) in single.sky_radiance(&ray).iter().enumerate() {
                    sum[index] += share * (light + further[index] * air.sun_irradiance[index]);
                }
            }
        }
    }
    sum
}

#[test]
fn a_tilted_face_has_the_light_of_the_sky_and_ground_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let (mut worst, mut of_share) = (0.0_f64, 0.0_f64);
    for tilt_deg in [30.0, 60.0, 90.0_f64] {
        // Faces that look away from the sun, and aslant of it, so that the sun adds nothing or what is known.
        for turn_deg in [0.0, 60.0, 150.0_f64] {
            let (sin, cos) = tilt_deg.to_radians().sin_cos();
            let (east, north) = turn_deg.to_radians().sin_cos();
            let normal = DVec3::new(sin * east, cos, -sin * north);
            let across = DVec3::new(north, 0.0, east);
            let along = normal.cross(across);
            let middle = DVec3::new(0.0, 1.0, 0.0) - 0.5 * normal;
            let corner = |a: f64, b: f64| {
                let corner = middle + a * across + b * along;
                format!("v {} {} {}\n", corner.x, corner.y, corner.z)
            };
            let corners = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)];
            let corners: String = corners.into_iter().map(|(a, b)| corner(a, b)).collect();
            fs::write(
                folder.path().join("face.obj"),
                corners + "f 1 2 3\nf 1 3 4\n",
            )
            .unwrap();
            let text = SCENE
                .replace(
                    "azimuth_deg = 0.0",
                    &format!("azimuth_deg = {}", turn_deg + 180.0),
                )
                .replace(
                    "elevation_deg = -60.0",
                    &format!("elevation_deg = {}", tilt_deg - 90.0),
                );
            let mesh = "[[occluders.meshes]]\nfile = \"face.obj\"\nalbedo = 0.25\n";
            let (lit, air) = seen(&format!("{text}{mesh}"), folder.path());
            let around = irradiance_around(&air, normal);
            let cos_sun = normal.dot(sun()).max(0.0);
            for (index, around) in around.iter().enumerate() {
                let direct = cos_sun * (-air.optical_depth_at(index, 0.0, sun().y)).exp();
                let found = f64::from(lit[[index, 1, 1]]) / (ALBEDO * FRAC_1_PI);
                let found = found - air.sun_irradiance[index] * direct;
                worst = worst.max((found / around - 1.0).abs());
                let diffuse = air.diffuse.as_ref().unwrap().ground_irradiance(sun().y);
                let beam = sun().y * (-air.optical_depth_at(index, 0.0, sun().y)).exp();
                let level = f64::from(diffuse[index]);
                let share = 0.5 * (1.0 + normal.y) * level
                    + 0.5 * (1.0 - normal.y) * ALBEDO * (level + beam);
                of_share = of_share.max((share * air.sun_irradiance[index] / around - 1.0).abs());
            }
        }
    }
    println!("{worst:.3} of the light, an even sky {of_share:.3}");
    // Worst found 0.090; by the share of sky and ground in view, both even, 0.27.
    assert!(worst < 0.1, "{worst}");
    assert!(worst < 0.5 * of_share, "{worst} {of_share}");
}

#[test]
fn terrain_that_is_none_is_refused_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    gray_png(
        &place("sound.png"),
        [40, 30],
        (0..1200).map(|code| code * 50),
    );
    let sound = fs::read(place("sound.png")).unwrap();
    fs::write(place("cut.png"), &sound[..sound.len() / 2]).unwrap();
    gray_png(&place("line.png"), [40, 1], (0..40).map(|code| code * 50));
    fs::write(place("no.exr"), &sound).unwrap();
    for (file, word) in [
        ("cut.png", "cut.png"),
        ("line.png", "found 40 x 1 heights, expected at least 2 x 2"),
        ("no.exr", "no.exr"),
        ("missing.png", "missing.png"),
    ] {
        let keys =
            format!("{SCENE}[terrain]\nfile = \"{file}\"\nspacing_m = 9\nheight_m = [0, 90]\n");
        let surfaces = plan(&keys, folder.path()).and_then(|it| it.surfaces(None));
        let message = surfaces.unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
        let scene = place("scene.toml");
        fs::write(&scene, keys).unwrap();
        niji_ends_with(3, &["run", text(&scene), "-o", text(&place("out")), "-q"]);
    }
}

#[test]
fn a_camera_below_the_terrain_is_told_how_high_that_is() {
    let folder = tempfile::tempdir().unwrap();
    gray_png(&folder.path().join("a.png"), [3, 3], (0..9).map(|_| 13_107));
    let terrain = "[terrain]\nfile = \"a.png\"\nspacing_m = 9\nheight_m = [0, 90]\n";
    let scene = folder.path().join("scene.toml");
    let at = |height_m: &str| {
        let camera = format!("position_m = [0.0, {height_m}, 0.0]");
        let text = SCENE.replace("position_m = [0.0, 1.0, 0.0]", &camera);
        plan(&format!("{text}{terrain}"), folder.path()).and_then(|it| it.surfaces(None))
    };
    // 0.2 of 90 m.
    let message = at("17.9").unwrap_err().to_string();
    assert!(message.contains("found camera.position_m[1] = 17.90, expected more than 18.00"));
    assert!(at("18.1").is_ok());
    fs::write(&scene, format!("{SCENE}{terrain}")).unwrap();
    let out = folder.path().join("out");
    niji_ends_with(4, &["run", text(&scene), "-o", text(&out), "-q"]);
}

#[test]
fn a_lit_wall_without_drops_or_air_is_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
    let vacuum = SCENE.replace("[air]\nconstituents = [\"rayleigh\"]\n", "");
    let mesh = "[[occluders.meshes]]\nfile = \"floor.obj\"\nalbedo = 0.5\n";
    let lit = planned(&format!("{vacuum}{mesh}"), folder.path());
    lit.check_light().unwrap();
    let image = lit.picture(&unwatched).unwrap();
    assert!(image.radiance.iter().all(|it| *it > 0.0));
    let dark = planned(&vacuum, folder.path()).check_light();
    assert!(
        dark.unwrap_err()
            .to_string()
            .contains("no drops are in view")
    );
}

#[test]
fn what_is_no_albedo_or_height_is_told_with_its_line() {
    let refused = |keys: &str| {
        Scene::from_toml(&format!("{SCENE}{keys}"))
            .unwrap_err()
            .to_string()
    };
    let mesh = "[[occluders.meshes]]\nfile = \"a.obj\"\nalbedo = ";
    for (albedo, words) in [
        ("1.5", "0 to 1"),
        ("[0.1, 0.2, -0.1]", "0 to 1"),
        ("[0.1, 0.2]", "red, green and blue"),
        (
            "\"gras\"",
            "a number, a list of red, green and blue, \"materials\", or one of \"grass\", \"dry-grass\"",
        ),
    ] {
        let message = refused(&format!("{mesh}{albedo}\n"));
        assert!(
            message.contains(words) && message.starts_with("line 33"),
            "{message}"
        );
    }
    let heights = refused("[terrain]\nfile = \"a.png\"\nspacing_m = 30\n");
    assert!(heights.contains("terrain.height_m"), "{heights}");
    let spacing = refused("[terrain]\nfile = \"a.exr\"\nspacing_m = 0\n");
    assert!(spacing.contains("terrain.spacing_m"), "{spacing}");
}

#[test]
fn the_effect_is_on_where_something_is_lit_or_shades_the_ground_and_the_terrain_counts_as_an_input()
{
    let folder = tempfile::tempdir().unwrap();
    gray_png(&folder.path().join("a.png"), [3, 3], (0..9).map(|_| 0));
    let terrain = "[terrain]\nfile = \"a.png\"\nspacing_m = 9\nheight_m = [0, 90]\n";
    let is_lit = |keys: &str| {
        let planned = planned(&format!("{SCENE}{keys}"), folder.path());
        planned.plan.is_on(Effect::LitSurfaces)
    };
    assert!(!is_lit("") && is_lit(terrain));
    // Where no ground is shown, black terrain shades nothing.
    let dark = format!("sky = \"off\"\n{terrain}");
    assert!(!is_lit(&dark) && is_lit(&format!("{dark}albedo = [0.2, 0.3, 0.1]\n")));
    let scene = Scene::from_toml(&format!("{SCENE}{terrain}albedo = 1\n")).unwrap();
    assert_eq!(scene.files(), ["a.png"]);
    let path = folder.path().join("a.png");
    let files = SurfaceFiles::of_scene(&scene, folder.path());
    assert_eq!(files.inputs(), [("terrain", &*path)]);
    let moved = Scene::from_toml(&format!(
        "{SCENE}{terrain}position_m = [0, 1, 0]\nalbedo = 1\n"
    ));
    let moved = SurfaceFiles::of_scene(&moved.unwrap(), folder.path());
    assert_ne!(files.settings(&()), moved.settings(&()));
    let again = Scene::from_json(&scene.canonical_json()).unwrap();
    assert_eq!(again, scene);
}
