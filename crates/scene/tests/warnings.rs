//! What a plan warns of and asks about, on scenes where it has a reason to and on others.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use support::planned;
use support::scene;

const RAIN_CELL: &str = include_str!("../../../data/scenes/rain-cell-8-km.toml");
const FIGURE_3: &str = include_str!("../../../data/scenes/paper-c-figure-3.toml");
const FLAT_RAIN: &str = include_str!("../../../data/scenes/rain-5-mm-h-flattened.toml");
const RAIN_SHAFT: &str = include_str!("../../../data/scenes/rain-shaft-5-mm-h.toml");

#[test]
fn drops_thinner_than_a_voxel_are_warned_of() {
    let warned = |voxel_m: &str| {
        let text = FIGURE_3.replace("voxel_m = 5.0", voxel_m);
        let warnings = planned(&scene(&text)).warnings;
        warnings.iter().any(|it| it.contains("less than a voxel"))
    };
    assert!(warned("voxel_m = 160.0"));
    assert!(!warned("voxel_m = 150.0"));
}

/// Whether a plan asks about something in one line, by some words of it.
fn asks(text: &str, words: &[&str]) -> bool {
    let warnings = planned(&scene(text)).warnings;
    let is_asked = |warning: &String| words.iter().all(|words| warning.contains(words));
    assert!(
        warnings.iter().all(|warning| !warning.contains('\n')),
        "{warnings:?}"
    );
    warnings.iter().any(is_asked)
}

#[test]
fn a_sun_that_may_be_given_in_radians_is_asked_about() {
    // 0.14 rad are 8 degrees.
    let low = RAIN_CELL.replacen("elevation_deg = 15.0", "elevation_deg = 0.14", 1);
    assert!(low != RAIN_CELL);
    assert!(asks(&low, &["sun.elevation_deg = 0.14", "8.0 degrees"]));
    for text in [RAIN_CELL, &low.replacen("= 0.14", "= 1.0", 1)] {
        assert!(!asks(text, &["radians"]));
    }
}

#[test]
fn rain_heavier_than_any_is_asked_about() {
    let of_rate = |rate: &str| RAIN_SHAFT.replacen("rain_rate_mm_h = 5.0", rate, 1);
    let words = ["8000 mm/h", "401 mm", "drops.rain_rate_mm_h"];
    assert!(asks(&of_rate("rain_rate_mm_h = 8000.0"), &words));
    let of_law = FLAT_RAIN.replacen("rain_rate_mm_h = 5.0", "rain_rate_mm_h = 8000.0", 1);
    assert!(asks(
        &of_law,
        &["8000 mm/h", "drops.law.marshall-palmer.rain_rate_mm_h"]
    ));
    // 75 dBZ are 1,800 mm/h by Marshall and Palmer.
    let radar = of_rate("reflectivity_dbz = 75.0");
    assert!(asks(&radar, &["drops.reflectivity_dbz"]));
    assert!(!asks(&of_rate("rain_rate_mm_h = 400.0"), &["mm/h"]));
}

#[test]
fn a_scene_over_ground_that_has_curved_away_is_told_how_far() {
    let moved = |away_m: f64| {
        let mut scene = scene(RAIN_CELL);
        scene.camera.position_m[0] += away_m;
        let warnings = planned(&scene).warnings;
        warnings
            .into_iter()
            .find(|warning| warning.contains("curved ground"))
    };
    // d^2/2R of 20 km: 31 m.
    let found = moved(2e4).unwrap();
    for words in ["20 km from the origin", "31.4 m below", "camera.position_m"] {
        assert!(found.contains(words), "{words} in {found}");
    }
    assert_eq!(moved(0.0), None);
    let mut vacuum = scene(FIGURE_3);
    vacuum.camera.position_m[0] += 1e6;
    assert!(
        !planned(&vacuum)
            .warnings
            .iter()
            .any(|it| it.contains("curved"))
    );
}

#[test]
fn a_camera_under_the_ground_is_warned_of_where_there_is_air() {
    let warned = |text: &str, height_m: f64| {
        let mut scene = scene(text);
        scene.camera.position_m[1] = height_m;
        let warnings = planned(&scene).warnings;
        warnings
            .iter()
            .any(|warning| warning.contains("below the ground"))
    };
    assert!(warned(RAIN_CELL, -50.0) && !warned(RAIN_CELL, 0.0));
    assert!(!warned(FIGURE_3, -50.0), "a vacuum has no ground");
}
