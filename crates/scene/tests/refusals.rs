//! What a later stage would refuse, the scene or its plan refuses first and in the same words.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use niji_radiometry::WavelengthGrid;
use niji_scene::Plan;
use niji_scene::PlanError;
use niji_scene::Scene;
use niji_scene::plan;
use support::scene;

const FIGURE_3: &str = include_str!("../../../data/scenes/paper-c-figure-3.toml");
const SPRAY: &str = include_str!("../../../data/scenes/sea-spray.toml");
const FLAT_RAIN: &str = include_str!("../../../data/scenes/rain-5-mm-h-flattened.toml");

fn planned(scene: &Scene) -> Result<Plan, PlanError> {
    plan(scene, None)
}

#[test]
fn more_drops_than_a_volume_holds_are_refused_at_their_key() {
    // It said that there were no drops.
    let dense = FIGURE_3.replace("number_density_m3 = 1000.0", "number_density_m3 = 1e18");
    assert_ne!(dense, FIGURE_3);
    let error = Scene::from_toml(&dense).unwrap_err().to_string();
    for words in [
        "drops.number_density_m3",
        "1000000000000000000",
        "0 to 1e15",
    ] {
        assert!(error.contains(words), "{words} in {error}");
    }
}

#[test]
fn drops_that_cannot_be_laid_out_are_refused_by_the_plan_with_the_reason() {
    // Water of which no law says before it is laid out that it is too many drops.
    let heavy = SPRAY.replace("surface_lwc_g_m3 = 0.5", "surface_lwc_g_m3 = 1e12");
    assert_ne!(heavy, SPRAY);
    let error = planned(&scene(&heavy)).unwrap_err();
    assert!(matches!(error, PlanError::Drops(_)), "{error:?}");
}

#[test]
fn tables_that_can_be_made_are_not_refused() {
    for text in [FIGURE_3, SPRAY, FLAT_RAIN] {
        assert_eq!(planned(&scene(text)).unwrap().table_refused, None);
    }
}

#[test]
fn a_table_that_its_stage_would_refuse_is_refused_by_the_plan() {
    let mut rain = scene(FLAT_RAIN);
    rain.spectrum = WavelengthGrid::new(400.0, 0.05, 6000).unwrap();
    rain.accuracy.table_relative_error = Some(1e-5);
    let refused = planned(&rain).unwrap().table_refused.unwrap();
    assert!(matches!(refused, niji_scatter::Error::TooLarge { .. }));
    let message = refused.to_string();
    for words in [
        "6000 wavelengths",
        "table_relative_error",
        "drop_flattening",
        "[spectrum]",
    ] {
        assert!(message.contains(words), "{words} in {message}");
    }
}

#[test]
fn drops_that_tumble_are_refused_at_their_section() {
    for (motion, words) in [
        ("tilt_sd_deg = 50.0", "tilt_sd_deg = 50"),
        ("axis_ratio_sd = -0.1", "axis_ratio_sd = -0.1"),
        ("tilt_sd_deg = nan", "tilt_sd_deg` is nan"),
    ] {
        let text = format!("{FLAT_RAIN}\n[drop_motion]\n{motion}\n");
        let error = Scene::from_toml(&text).unwrap_err().to_string();
        assert!(
            error.contains("drop_motion") && error.contains(words),
            "{error}"
        );
    }
}
