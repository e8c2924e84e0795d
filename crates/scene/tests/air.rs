//! The sections `[air]` and `[sun]`: what their keys mean, and what they refuse.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use niji_atmosphere::AirModel;
use niji_radiometry::Reflectance;
use niji_scene::Scene;

const SCENE: &str = r#"
format = 1
name = "air"
[sun]
elevation_deg = 10.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 90.0
width_px = 64
height_px = 48
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, -120.0]
box_max_m = [50.0, 50.0, -20.0]
voxel_m = 5.0
law = { monodisperse = { radius_um = 20.0 } }
number_density_m3 = 1e7
"#;

/// The scene with a section `[air]`, and with another `[sun]` where one is given.
fn scene(sun: &str, air: &str) -> Result<Scene, String> {
    let text = SCENE.replace("elevation_deg = 10.0\nazimuth_deg = 180.0", sun);
    Scene::from_toml(&format!("{text}[air]\n{air}")).map_err(|error| error.to_string())
}

const SUN: &str = "elevation_deg = 10.0\nazimuth_deg = 180.0";

fn model(sun: &str, air: &str) -> AirModel {
    let scene = scene(sun, air).unwrap();
    let grid = scene.spectrum;
    let air = scene.air.unwrap();
    air.model(grid, Reflectance::Even(0.2), &scene.sun).unwrap()
}

/// Vertical optical depths of the only constituent.
fn depths(sun: &str, air: &str) -> Vec<f64> {
    let model = model(sun, air);
    let constituent = &model.constituents[0];
    constituent.vertical_optical_depth()
}

#[test]
fn vapor_and_oxygen_are_tabulated_for_the_path_of_the_sun() {
    let air = "constituents = [\"water-vapor\"]\nprecipitable_water_cm = 2.0";
    let low = SUN.replace("10.0", "2.0");
    // 720 nm: a longer path through black lines loses less light for each metre.
    let [high, low] = [SUN, &low].map(|sun| depths(sun, air)[34]);
    assert!(low > 0.0 && low < 0.7 * high, "{low}, {high}");
    let scene = scene(SUN, air).unwrap();
    assert!(scene.air.unwrap().depends_on(&scene.sun));
}

#[test]
fn layers_move_haze_and_keep_its_amount() {
    let plain = "constituents = [\"aerosol\"]\naerosol = \"rural\"";
    let layer = "\n[[air.layers]]\nconstituent = \"aerosol\"\nheight_m = [0, 1000, 1500]\n\
                 density = [2, 2, 0]";
    let [without, with] =
        [plain.to_owned(), format!("{plain}{layer}")].map(|air| depths(SUN, &air));
    for (without, with) in without.iter().zip(with) {
        assert!((with / without - 1.0).abs() < 1e-12);
    }
    // With a visibility its extinction at sea level stays.
    let visible = format!("{plain}\nvisibility_km = 10");
    let ground = |air: &str| {
        let model = model(SUN, air);
        let constituent = &model.constituents[0];
        constituent.extinction_m1[17] * constituent.profile.at_sea_level()
    };
    let ratio = ground(&format!("{visible}{layer}")) / ground(&visible);
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
    let table = model(SUN, &format!("{visible}{layer}")).tabulate().unwrap();
    assert!(
        table.density_at(0, 2000.0) <= 0.0,
        "nothing above the layer"
    );
}

#[test]
fn moonlight_is_sunlight_400_000_times_weaker() {
    let moon = format!("body = \"moon\"\n{SUN}");
    let air = "constituents = [\"rayleigh\"]";
    let ratio = model(&moon, air).sun_scale / model(SUN, air).sun_scale;
    assert!((4.0e5 * ratio - 1.0).abs() < 0.01, "{ratio}");
    let half = format!("phase_angle_deg = 90\n{moon}");
    assert!(model(&half, air).sun_scale < 0.1 * ratio);
}

#[test]
fn what_no_air_and_no_moon_can_be_is_refused_by_name() {
    let refused = |sun: &str, air: &str, named: &str| {
        let error = scene(sun, air).unwrap_err();
        assert!(error.contains(named), "{error}");
    };
    let air = "constituents = [\"rayleigh\"]";
    let layer = |text: &str| format!("constituents = [\"aerosol\"]\n[[air.layers]]\n{text}");
    refused(
        SUN,
        &format!("{air}\nprecipitable_water_cm = 1"),
        "water-vapor",
    );
    refused(
        SUN,
        "constituents = [\"water-vapor\"]\nprecipitable_water_cm = -1",
        "precipitable_water_cm",
    );
    refused(
        SUN,
        &layer("constituent = \"ozone\"\nheight_m = [0, 1]\ndensity = [1, 0]"),
        "layers",
    );
    refused(
        SUN,
        &layer("constituent = \"aerosol\"\nheight_m = [0, 1]\ndensity = [1]"),
        "expected pairs",
    );
    refused(
        SUN,
        &layer("constituent = \"aerosol\"\nheight_m = [10, 0]\ndensity = [1, 1]"),
        "expected rising",
    );
    refused(
        SUN,
        &layer("constituent = \"aerosol\"\nheight_m = [0, 1]\ndensty = [1, 1]"),
        "did you mean",
    );
    refused(
        &format!("phase_angle_deg = 3\n{SUN}"),
        air,
        "phase_angle_deg",
    );
    let thin = format!("body = \"moon\"\nphase_angle_deg = 170\n{SUN}");
    refused(&thin, air, "phase_angle_deg");
}
