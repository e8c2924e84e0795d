//! Levels for a tolerance follow from what they say of their own errors, and what a scene names stays.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Effect;
use niji_scene::Preset;
use niji_scene::SHARE_FOR_LEVELS;
use niji_scene::Scene;
use niji_scene::Switch;
use niji_scene::calls_for_multiple_scattering;
use niji_scene::levels_for_tolerance;
use niji_scene::tolerance_for_rays;
use support::planned;
use support::scene;

/// Drops of 50 um in a vacuum, optical depth 0.08.
const MIST: &str = "
format = 1
name = \"mist\"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 90.0
width_px = 64
height_px = 48
[drops]
shape = \"uniform\"
box_min_m = [-50.0, 0.0, -120.0]
box_max_m = [50.0, 50.0, -20.0]
voxel_m = 5.0
law = { monodisperse = { radius_um = 50.0 } }
number_density_m3 = 1e5
[spectrum]
first_nm = 450.0
step_nm = 100.0
n_wavelengths = 3
";

fn errors(accuracy: &Accuracy) -> [f64; 2] {
    let Some(Integration::Adaptive { relative_error }) = accuracy.integration else {
        panic!("{accuracy:?}");
    };
    [accuracy.table_relative_error.unwrap(), relative_error]
}

#[test]
fn squares_of_what_levels_may_err_by_add_up_to_half_of_the_tolerance() {
    let mist = scene(MIST);
    for tolerance in [0.03, 0.01, 1e-3, 1e-5] {
        let [table, integral] = errors(&levels_for_tolerance(&mist, tolerance));
        let rays = tolerance_for_rays(tolerance);
        let sum = (table * table + integral * integral + rays * rays).sqrt();
        assert!((sum / (SHARE_FOR_LEVELS * tolerance) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn no_level_is_coarser_than_that_of_the_preset_that_keeps_the_tolerance() {
    let mist = scene(MIST);
    for (tolerance, preset) in [
        (1.0, Preset::Standard),
        (0.01, Preset::Standard),
        (0.0099, Preset::Reference),
        (1e-6, Preset::Reference),
    ] {
        let accuracy = levels_for_tolerance(&mist, tolerance);
        assert_eq!(accuracy.preset, preset, "{tolerance}");
        let (levels, own) = (accuracy.levels(2.0), preset.levels(2.0));
        assert_eq!(levels.theory, own.theory);
        assert_eq!(levels.sky, own.sky);
        assert_eq!(levels.drop_orders, own.drop_orders);
        assert_eq!(levels.pixel_footprint, PixelFootprint::Prefiltered);
        let [table, _] = errors(&accuracy);
        assert!(table <= Preset::Draft.levels(2.0).table_relative_error);
    }
}

#[test]
fn levels_for_any_tolerance_are_ones_that_a_scene_may_name() {
    for tolerance in [1.0, 1e-12, f64::MIN_POSITIVE] {
        let mut mist = scene(MIST);
        mist.accuracy = levels_for_tolerance(&mist, tolerance);
        let read = Scene::from_json(&mist.canonical_json());
        assert_eq!(read.unwrap().accuracy, mist.accuracy, "{tolerance}");
    }
}

#[test]
fn what_the_scene_names_stays() {
    let named = "name = \"mist\"\n[accuracy]\ntheory = \"airy\"\ntable_relative_error = 0.1\n\
                 integration = \"cell-exact\"\npixel_footprint = \"center\"";
    let mist = scene(&MIST.replace("name = \"mist\"", named));
    let accuracy = levels_for_tolerance(&mist, 1e-6);
    assert_eq!(accuracy.theory, Some(Theory::Airy));
    assert_eq!(accuracy.table_relative_error, Some(0.1));
    assert_eq!(accuracy.integration, Some(Integration::CellExact));
    assert_eq!(accuracy.pixel_footprint, Some(PixelFootprint::Center));
    assert_eq!(accuracy.tolerance, mist.accuracy.tolerance);
}

#[test]
fn without_one_of_its_orders_the_exact_theory_is_the_debye_series() {
    let mut mist = scene(MIST);
    mist.effects.set(Effect::SecondaryBow, Switch::Off);
    let accuracy = levels_for_tolerance(&mist, 1e-3);
    assert_eq!(accuracy.theory, Some(Theory::Debye { max_order: 7 }));
}

#[test]
fn light_of_all_orders_is_called_for_where_it_exceeds_half_of_the_tolerance() {
    let asks =
        |scene: &Scene, tolerance| calls_for_multiple_scattering(scene, &planned(scene), tolerance);
    let mut mist = scene(MIST);
    let missed = planned(&mist)
        .bound(Effect::MultipleScattering)
        .unwrap()
        .rms;
    assert!(asks(&mist, 1.9 * missed) && !asks(&mist, 2.1 * missed));
    mist.effects.set(Effect::MultipleScattering, Switch::Off);
    assert!(!asks(&mist, 1e-9), "what the scene leaves out stays out");
}
