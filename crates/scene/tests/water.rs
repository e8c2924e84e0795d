//! The water of a scene: the sea's in its spray, pure water elsewhere, and how far that moves the bow.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use std::f64::consts::PI;

use niji_exchange::ScatteringTable;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::Theory;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::canonical_json;
use support::planned;

const SPRAY: &str = include_str!("../../../data/scenes/sea-spray.toml");
const FOG: &str = include_str!("../../../data/scenes/fog-bank-fogbow.toml");

/// Degrees by which the primary of sea water is smaller at 15 C and 35 per mille: Descartes' ray for the
/// published indices 1.3413 and 1.3347.
const SMALLER_DEG: f64 = 0.945;

fn need(text: &str) -> ScatteringNeed {
    let scene = Scene::from_toml(text).unwrap();
    planned(&scene).scattering.unwrap()
}

fn with_water(text: &str, water: &str) -> String {
    format!("{text}\n[water]\n{water}\n")
}

#[test]
fn spray_is_of_the_sea_and_all_else_of_pure_water_unless_the_scene_says_so() {
    assert_eq!(need(SPRAY).water, Water::of_the_sea(15.0));
    assert_eq!(need(FOG).water, Water::pure(15.0));
    let lake = with_water(SPRAY, "salinity_per_mille = 0.0");
    assert_eq!(need(&lake).water, Water::pure(15.0));
    let warm = with_water(SPRAY, "temperature_c = 28.0");
    assert_eq!(need(&warm).water, Water::of_the_sea(28.0));
    let brackish = "temperature_c = 8.0\nsalinity_per_mille = 7.5";
    let water = need(&with_water(FOG, brackish)).water;
    assert_eq!((water.temperature_c, water.salinity_per_mille), (8.0, 7.5));
}

#[test]
fn a_table_of_pure_water_is_asked_for_in_the_words_of_before_there_was_salt() {
    let pure = canonical_json(&need(FOG));
    assert!(pure.contains("\"temperature_c\":15.0"), "{pure}");
    assert!(!pure.contains("salinity"), "{pure}");
    assert!(canonical_json(&need(SPRAY)).contains("\"salinity_per_mille\":35.0"));
}

#[test]
fn the_bow_of_the_sea_is_smaller_in_plan_and_table() {
    let lake = with_water(SPRAY, "salinity_per_mille = 0.0");
    let [salt, fresh] = [need(SPRAY), need(&lake)].map(|need| table(&need));
    let smaller_deg = primary_deg(&fresh) - primary_deg(&salt);
    assert!(
        (smaller_deg - SMALLER_DEG).abs() < 0.05,
        "{smaller_deg} in the table"
    );
    // Both bows move away from the band between them: half of what the secondary moves more.
    let wider_deg = (salt.split_theta_rad - fresh.split_theta_rad).to_degrees();
    assert!((-0.5..-0.2).contains(&wider_deg), "{wider_deg}");
}

/// The table of a plan for one size and color.
fn table(need: &ScatteringNeed) -> ScatteringTable {
    let one_size = ScatteringNeed {
        theory: Theory::Uniform,
        theta_range_rad: (0.7 * PI, 0.8 * PI),
        effective_radius_um: vec![300.0],
        effective_variance: vec![0.0],
        rows: SizeRows::Laws,
        motion: None,
        ..need.clone()
    };
    let green = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
    scattering_table(&one_size.request(green, None), &unwatched).unwrap()
}

/// Where the primary is brightest, from the antisolar point.
fn primary_deg(table: &ScatteringTable) -> f64 {
    let light = |index: usize| table.values[[0, 0, 0, 0, index]];
    let beyond_split = |index: &usize| table.theta_rad[*index] > table.split_theta_rad;
    let angles = (0..table.theta_rad.len()).filter(beyond_split);
    let peak = angles.max_by(|a, b| light(*a).total_cmp(&light(*b)));
    180.0 - table.theta_rad[peak.unwrap()].to_degrees()
}

#[test]
fn published_indices_reach_the_plan() {
    let green = Nanometers(550.0);
    let water = need(SPRAY).water;
    assert!((water.refractive_index(green) - 1.3413).abs() < 1e-4);
    assert!((need(FOG).water.refractive_index(green) - 1.3347).abs() < 1e-4);
}

#[test]
fn water_that_nobody_measured_is_refused_where_it_stands() {
    for water in [
        "temperature_c = 101.0",
        "salinity_per_mille = 41.0",
        "salinity_per_mille = -1.0",
        "temperature_c = -5.0\nsalinity_per_mille = 35.0",
    ] {
        let error = Scene::from_toml(&with_water(FOG, water)).unwrap_err();
        let line = with_water(FOG, "").lines().count() - 1;
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("line {line}: `water`")),
            "{message}"
        );
        assert!(message.contains("expected -20 to 100 degrees"), "{message}");
    }
    // The sea does not boil: whoever wants hot spray has to take the salt out.
    let error = Scene::from_toml(&with_water(SPRAY, "temperature_c = 80.0")).unwrap_err();
    assert!(
        error.to_string().contains("35 per mille of salt"),
        "{error}"
    );
    let pure = with_water(SPRAY, "temperature_c = 80.0\nsalinity_per_mille = 0.0");
    assert!(Scene::from_toml(&pure).is_ok());
}
