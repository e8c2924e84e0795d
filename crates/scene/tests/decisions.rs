//! What the plan decides by itself, on scenes whose answer is known.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use niji_scatter::DropMotion;
use niji_scene::BoundKind;
use niji_scene::DropSummary;
use niji_scene::Effect;
use niji_scene::EffectDecision;
use niji_scene::LEAST_TOLERANCE;
use niji_scene::Plan;
use niji_scene::PlanError;
use niji_scene::Stage;
use niji_scene::Switch;
use niji_scene::plan;
use support::all_auto;
use support::planned;
use support::scene;

/// The project's own scene files.
macro_rules! shipped {
    ($name:literal) => {
        include_str!(concat!("../../../data/scenes/", $name, ".toml"))
    };
}

const FOUNTAIN: &str = shipped!("garden-fountain");
const RAIN_CELL: &str = shipped!("rain-cell-8-km");
const FIGURE_3: &str = shipped!("paper-c-figure-3");
const FOG: &str = shipped!("fog-bank-fogbow");
const FLAT_RAIN: &str = shipped!("rain-5-mm-h-flattened");
const RAIN_SHAFT: &str = shipped!("rain-shaft-5-mm-h");

fn reason(plan: &Plan, effect: Effect) -> String {
    plan.effects
        .iter()
        .find(|decision| decision.effect == effect)
        .unwrap()
        .reason
        .clone()
}

#[test]
fn a_fountain_near_by_needs_no_air_in_front_of_it_but_air_above_it() {
    let plan = planned(&scene(FOUNTAIN));
    assert!(!plan.is_on(Effect::AirExtinction) && !plan.is_on(Effect::AirInscatter));
    assert!(plan.is_on(Effect::SunlightThroughAir) && plan.runs(Stage::Atmosphere));
    assert!(
        reason(&plan, Effect::AirExtinction).contains("m away"),
        "{plan}"
    );
    assert!(
        reason(&plan, Effect::SunlightThroughAir).contains("however near"),
        "{plan}"
    );
    assert!(plan.is_on(Effect::PrimaryBow) && !plan.is_dark());
}

#[test]
fn rain_eight_kilometres_away_needs_both() {
    let plan = planned(&scene(RAIN_CELL));
    for effect in [
        Effect::AirExtinction,
        Effect::AirInscatter,
        Effect::SunlightThroughAir,
    ] {
        assert!(plan.is_on(effect), "{effect}");
    }
    assert!(reason(&plan, Effect::AirInscatter).contains("km away"));
}

#[test]
fn a_view_inside_the_primary_drops_the_secondary_and_its_order() {
    let mut scene = all_auto(FOUNTAIN);
    // The center of the bow lies 38 degrees below the horizon; 20 degrees around it stay inside.
    scene.camera.elevation_deg = -38.0;
    scene.camera.horizontal_fov_deg = Some(20.0);
    scene.camera.position_m = [0.0, 12.0, 0.0];
    scene.effects.set(Effect::MultipleScattering, Switch::Off);
    let plan = planned(&scene);
    assert!(plan.view.theta_deg.unwrap().0 > 150.0, "{plan}");
    assert!(
        plan.is_on(Effect::PrimaryBow) && !plan.is_on(Effect::SecondaryBow),
        "{plan}"
    );
    assert!(!plan.scattering.unwrap().orders.contains(&3));
}

#[test]
fn a_view_of_the_secondary_keeps_it() {
    let plan = planned(&all_auto(&FIGURE_3.replace("m3 = 1000.0", "m3 = 100000.0")));
    assert!(plan.is_on(Effect::SecondaryBow), "{plan}");
    let orders = plan.scattering.unwrap().orders;
    assert!(orders.contains(&2) && orders.contains(&3), "{orders:?}");
}

#[test]
fn what_is_left_out_sums_to_half_of_the_tolerance_at_most() {
    for text in [FOUNTAIN, RAIN_CELL, FIGURE_3] {
        let mut n_off_before = usize::MAX;
        for tolerance in [0.3, 0.01, 1e-4, LEAST_TOLERANCE] {
            let mut scene = all_auto(text);
            scene.accuracy.tolerance = Some(tolerance);
            let plan = planned(&scene);
            let off: Vec<f64> = plan
                .effects
                .iter()
                .filter(|decision| !decision.on && !decision.effect.comes_with_theory())
                .map(EffectDecision::counted)
                .collect();
            let sum: f64 = off.iter().sum();
            assert!(sum <= 0.5 * tolerance, "{sum} {plan}");
            assert!((plan.left_out - sum).abs() <= 1e-12);
            assert!(
                off.len() <= n_off_before,
                "a tighter tolerance leaves less out"
            );
            n_off_before = off.len();
        }
    }
}

#[test]
fn what_is_left_out_is_told_by_place() {
    let mut n_told = 0;
    for text in [RAIN_CELL, RAIN_SHAFT, FOUNTAIN, FLAT_RAIN] {
        let mut scene = all_auto(text);
        scene.accuracy.tolerance = Some(0.1);
        let plan = planned(&scene);
        let left_out = plan.effects.iter().filter(|it| it.is_left_out);
        let bounds: Vec<_> = left_out
            .filter(|it| it.effect.is_bounded_by_place() && it.bound.value > 0.0)
            .map(|it| it.bound)
            .collect();
        let parts: Vec<f64> = plan
            .left_out_by_place
            .iter()
            .flatten()
            .map(|it| f64::from(*it))
            .collect();
        assert_eq!(parts.is_empty(), bounds.is_empty(), "{}", plan.scene);
        if bounds.is_empty() {
            continue;
        }
        n_told += 1;
        let largest = parts.iter().copied().fold(0.0, f64::max);
        let rms = (parts.iter().map(|it| it * it).sum::<f64>() / parts.len() as f64).sqrt();
        let sums = bounds
            .iter()
            .fold((0.0, 0.0), |sums, it| (sums.0 + it.value, sums.1 + it.rms));
        // Parts differ in size by a pixel.
        assert!(
            largest <= 1.0001 * sums.0 && rms <= 1.02 * sums.1,
            "{}",
            plan.scene
        );
        let most = bounds.iter().map(|it| it.rms).fold(0.0, f64::max);
        assert!(rms >= 0.98 * most, "{rms} {most}");
    }
    assert!(n_told > 1, "{n_told}");
}

#[test]
fn an_effect_that_is_off_is_absent_from_stages_and_tables() {
    let mut scene = scene(RAIN_CELL);
    for effect in Effect::ALL.into_iter().filter(|effect| effect.needs_air()) {
        scene.effects.set(effect, Switch::Off);
    }
    assert!(!planned(&scene).runs(Stage::Atmosphere));
    scene.effects.set(Effect::SunDisc, Switch::Off);
    scene.effects.set(Effect::SizeSpread, Switch::Off);
    scene.effects.set(Effect::PrimaryBow, Switch::Off);
    scene.effects.set(Effect::HigherOrders, Switch::Off);
    scene.effects.set(Effect::DropFlattening, Switch::Off);
    let plan = planned(&scene);
    let need = plan.scattering.clone().unwrap();
    assert_eq!((need.orders, need.effective_variance), (vec![3], vec![0.0]));
    assert_eq!(need.motion, None);
    assert!(need.sun_disc_diameter_rad.abs() < 1e-12);
    assert!(
        need.theta_range_rad.1.to_degrees() < 139.0,
        "angles inside the primary are not needed"
    );
    scene.effects.set(Effect::Supernumeraries, Switch::Off);
    assert!(
        !planned(&scene).runs(Stage::Airy),
        "rays need no table of Airy's integral"
    );
    scene.effects.set(Effect::SecondaryBow, Switch::Off);
    let plan = planned(&scene);
    assert!(plan.scattering.is_none() && !plan.runs(Stage::Scatter) && plan.is_dark());
}

#[test]
fn a_vacuum_has_no_air_and_no_bound_on_it() {
    let plan = planned(&scene(FIGURE_3));
    for effect in Effect::ALL.into_iter().filter(|effect| effect.needs_air()) {
        let bound = plan.bound(effect).unwrap();
        assert!(!plan.is_on(effect) && bound.value <= 0.0 && bound.kind == BoundKind::Proved);
        assert!(reason(&plan, effect).contains("vacuum"));
    }
    assert!(!plan.runs(Stage::Atmosphere));
}

#[test]
fn a_sun_that_nothing_receives_is_dark() {
    let mut scene = scene(RAIN_CELL);
    scene.sun.elevation_deg = -40.0;
    let plan = planned(&scene);
    assert!(plan.is_dark(), "{plan}");
    assert!(
        plan.warnings
            .iter()
            .any(|warning| warning.contains("below the horizon"))
    );
}

#[test]
fn a_camera_that_looks_away_needs_no_scattering_table() {
    let mut scene = scene(FIGURE_3);
    scene.camera.azimuth_deg = 180.0;
    let plan = planned(&scene);
    assert!(plan.scattering.is_none() && plan.view.theta_deg.is_none() && plan.is_dark());
    assert!(
        plan.warnings
            .iter()
            .any(|warning| warning.contains("no drops are in view"))
    );
}

#[test]
fn glory_and_corona_are_there_where_the_theory_has_them_and_they_are_seen() {
    let fog = scene(FOG);
    let exact = planned(&fog);
    assert!(exact.is_on(Effect::Glory), "{exact}");
    assert!(reason(&exact, Effect::Glory).contains("the theory mie has it"));
    // Nobody looks at the sun.
    assert!(
        !exact.is_on(Effect::Corona) && reason(&exact, Effect::Corona).contains("adds nothing")
    );
    let mut of_bows = fog.clone();
    of_bows.accuracy.theory = Some(niji_scatter::Theory::Uniform);
    let plan = planned(&of_bows);
    assert!(!plan.is_on(Effect::Glory));
    assert!(
        reason(&plan, Effect::Glory).starts_with("not simulated: the theory uniform lacks it"),
        "{plan}"
    );
    let bound = plan.bound(Effect::Glory).unwrap();
    assert!(
        bound.kind == BoundKind::Estimated && bound.value > 0.01,
        "{bound:?}"
    );
    // Rain makes rings narrower than the sun.
    let rain = planned(&scene(RAIN_CELL));
    assert!(!rain.is_on(Effect::Glory) && rain.bound(Effect::Glory).unwrap().value <= 0.0);
}

#[test]
fn nobody_takes_the_glory_out_of_the_exact_light() {
    let mut scene = scene(FOG);
    scene.effects.set(Effect::Glory, Switch::Off);
    let plan = planned(&scene);
    assert!(plan.is_on(Effect::Glory));
    assert!(
        reason(&plan, Effect::Glory).contains("is not without it"),
        "{plan}"
    );
}

#[test]
fn an_order_that_is_off_leaves_the_theory_as_it_is() {
    let mut scene = scene(FOG);
    let with = planned(&scene);
    scene.effects.set(Effect::SecondaryBow, Switch::Off);
    let without = planned(&scene);
    assert_eq!(without.levels.theory, with.levels.theory);
    let reason = reason(&without, Effect::SecondaryBow);
    assert!(reason.contains("exact light"), "{reason}");
}

#[test]
fn drops_above_a_millimetre_of_diameter_are_flat_and_those_of_fog_are_round() {
    let plan = planned(&all_auto(FLAT_RAIN));
    assert!(plan.is_on(Effect::DropFlattening), "{plan}");
    let bound = plan.bound(Effect::DropFlattening).unwrap();
    assert!(bound.value > 0.1 && bound.kind == BoundKind::Estimated);
    let need = plan.scattering.unwrap();
    assert_eq!(need.motion, Some(DropMotion::default()));
    // Single sizes as far as 5e-5 of the rain's cross-section reach on either side.
    assert_eq!(need.effective_variance, [0.0]);
    let (first_um, last_um) = (need.effective_radius_um[0], need.effective_radius_um.last());
    assert!(first_um < 30.0 && *last_um.unwrap() > 2000.0);
    // Drops of 18 um diameter.
    let fog = planned(&all_auto(FOG));
    assert!(!fog.is_on(Effect::DropFlattening), "{fog}");
    assert!(fog.bound(Effect::DropFlattening).unwrap().value < 1e-4);
    assert_eq!(fog.scattering.unwrap().motion, None);
}

#[test]
fn a_tighter_tolerance_asks_for_more_sizes_of_flat_drops() {
    let n_nodes = |table_relative_error: f64| {
        let mut scene = scene(FLAT_RAIN);
        scene.accuracy.table_relative_error = Some(table_relative_error);
        planned(&scene)
            .scattering
            .unwrap()
            .effective_radius_um
            .len()
    };
    let counts = [0.1, 1e-2, 1e-3].map(n_nodes);
    assert!(
        counts.is_sorted() && 2 * counts[1] < counts[2],
        "{counts:?}"
    );
    assert!(counts[2] < 300, "{counts:?}");
}

/// The effects that a plan says are missed, without a warning: that they are off was meant, or is told
/// at the end of the run.
fn missed(scene: &niji_scene::Scene) -> Vec<Effect> {
    let plan = planned(scene);
    assert!(plan.warnings.is_empty(), "{:?}", plan.warnings);
    plan.missed().map(|it| it.effect).collect()
}

#[test]
fn flat_drops_are_missed_only_where_they_show() {
    let is_missed = |text: &str| {
        let mut scene = scene(text);
        scene.effects.set(Effect::DropFlattening, Switch::Off);
        missed(&scene).contains(&Effect::DropFlattening)
    };
    assert!(is_missed(FLAT_RAIN) && !is_missed(FOG));
}

#[test]
fn what_is_off_although_large_is_missed() {
    let mut scene = scene(RAIN_CELL);
    // By itself the plan leaves nothing out that is large.
    assert_eq!(missed(&scene), []);
    let both = [Effect::AirInscatter, Effect::MultipleScattering];
    for effect in both {
        scene.effects.set(effect, Switch::Off);
    }
    assert!(both.iter().all(|effect| missed(&scene).contains(effect)));
    let light = |scene: &niji_scene::Scene| planned(scene).sky_level;
    scene.effects.set(Effect::Sky, Switch::On);
    assert!(light(&scene).is_some());
    scene.effects.set(Effect::Sky, Switch::Off);
    assert!(light(&scene).is_none(), "what is not shown is not solved");
}

#[test]
fn ground_that_is_seen_has_the_shadow_of_drops_where_that_may_be_seen() {
    let lit = |text: &str| planned(&scene(text)).is_on(Effect::LitSurfaces);
    let from_above = shipped!("full-circle-bow");
    assert!(lit(from_above));
    assert_eq!(
        reason(&planned(&scene(from_above)), Effect::LitSurfaces),
        "kept; ground in view may have a shadow"
    );
    // Black ground, none, and none in the sun.
    assert!(!lit(&format!("{from_above}[ground]\nalbedo = 0.0\n")));
    let without = |effect: &str| {
        let switches = "drop_flattening = \"off\"";
        assert!(from_above.contains(switches));
        from_above.replace(switches, &format!("{switches}\n{effect} = \"off\""))
    };
    assert!(!lit(&without("sky")) && !lit(&without("drop_shadow")));
    // Surfaces shade it whatever the drops do.
    let mesh = "[[occluders.meshes]]\nfile = \"a.obj\"\n";
    assert!(lit(&format!("{}{mesh}", without("drop_shadow"))));
}

#[test]
fn a_photograph_takes_the_place_of_sky_and_air() {
    let in_photo = format!("{RAIN_CELL}\n[photo]\npicture = \"p.jpg\"\n");
    let mut scene = scene(&in_photo);
    let of_photo = [Effect::AirInscatter, Effect::Sky, Effect::SkylitDrops];
    let plan = planned(&scene);
    for effect in of_photo {
        let decision = plan.effects.iter().find(|it| it.effect == effect).unwrap();
        assert!(!decision.on && !decision.is_left_out, "{effect:?}");
        assert!(
            decision.reason.starts_with("the photograph"),
            "{}",
            decision.reason
        );
    }
    assert!(plan.sky_level.is_none(), "what is not shown is not solved");
    assert!(!plan.missed().any(|it| of_photo.contains(&it.effect)));
    scene.effects.set(Effect::Sky, Switch::On);
    assert!(planned(&scene).is_on(Effect::Sky));
}

#[test]
fn the_other_orders_fill_the_band_and_what_is_seen_decides_which() {
    let mut towards_the_bows = scene(RAIN_CELL);
    towards_the_bows
        .effects
        .set(Effect::HigherOrders, Switch::On);
    // It would take all orders.
    (towards_the_bows.effects).set(Effect::MultipleScattering, Switch::Off);
    let plan = planned(&towards_the_bows);
    let bound = plan.bound(Effect::HigherOrders).unwrap();
    assert!(bound.kind == BoundKind::Proved && bound.value > 0.0);
    let orders = plan.scattering.unwrap().orders;
    assert!(orders.contains(&0) && orders.contains(&6), "{orders:?}");
    assert!(!orders.contains(&1) && !orders.contains(&5), "{orders:?}");
    // Looking at the sun through the shower: nearly all of the light goes straight through.
    let mut towards_the_sun = towards_the_bows.clone();
    towards_the_sun.camera.position_m = [4815.0, 2.0, -16_000.0];
    towards_the_sun.camera.azimuth_deg = 180.0;
    let orders = planned(&towards_the_sun).scattering.unwrap().orders;
    assert!(orders.contains(&0) && orders.contains(&1), "{orders:?}");
}

#[test]
fn light_of_other_orders_shows_without_any_bow() {
    let mut scene = scene(RAIN_CELL);
    for effect in [Effect::PrimaryBow, Effect::SecondaryBow] {
        scene.effects.set(effect, Switch::Off);
    }
    scene.effects.set(Effect::HigherOrders, Switch::On);
    let plan = planned(&scene);
    assert!(!plan.is_dark() && plan.render_effects().higher_orders.is_on());
    assert_eq!(plan.scattering.unwrap().orders.first(), Some(&0));
}

#[test]
fn a_brighter_exposure_sees_more() {
    let at = |exposure_ev: f64| {
        let mut scene = all_auto(FIGURE_3);
        scene.picture.exposure_ev = exposure_ev;
        planned(&scene)
    };
    let (dim, bright) = (at(0.0), at(6.5));
    let stops = (dim.display_white_cd_m2 / bright.display_white_cd_m2).log2();
    assert!((stops - 6.5).abs() < 1e-12);
    let n_on = |plan: &Plan| plan.effects.iter().filter(|decision| decision.on).count();
    assert!(n_on(&bright) > n_on(&dim), "{dim}\n{bright}");
}

#[test]
fn every_preset_has_its_theory_and_every_theory_a_name() {
    use niji_scatter::Theory;
    let theory = |preset: &str| {
        let text = FOUNTAIN.replace("\"standard\"", &format!("\"{preset}\""));
        scene(&text).levels(1.0).theory
    };
    let theories = ["draft", "standard", "reference"].map(theory);
    assert_eq!(theories, [Theory::Airy, Theory::BySize, Theory::Mie]);
    for name in [
        "geometric-published",
        "geometric",
        "airy-published",
        "airy",
        "uniform",
        "mie",
        "by-size",
    ] {
        let levels = format!("preset = \"standard\"\ntheory = \"{name}\"");
        let text = FOUNTAIN.replace("preset = \"standard\"", &levels);
        assert_eq!(scene(&text).levels(1.0).theory.name(), name);
    }
}

#[test]
fn drop_files_are_planned_from_their_figures() {
    let shape_scene = scene(FIGURE_3);
    let start = FIGURE_3.find("shape = ").unwrap();
    let end = FIGURE_3.find("[water]").unwrap();
    let text = format!(
        "{}file = \"drops.vdb\"\n{}",
        &FIGURE_3[..start],
        &FIGURE_3[end..]
    );
    let file_scene = scene(&text);
    let missing = plan(&file_scene, None);
    assert!(matches!(missing, Err(PlanError::NoDrops { file }) if file == "drops.vdb"));
    let volume = shape_scene.drops.shape().unwrap().volume().unwrap();
    let drops = DropSummary::of_volume(&volume);
    let plan = plan(&file_scene, drops).unwrap();
    let of_shape = planned(&shape_scene);
    assert!(!plan.runs(Stage::Drops) && of_shape.runs(Stage::Drops));
    let (a, b) = (
        plan.bound(Effect::PrimaryBow).unwrap(),
        of_shape.bound(Effect::PrimaryBow).unwrap(),
    );
    assert!((a.value / b.value - 1.0).abs() < 1e-5);
}

#[test]
fn plans_are_written_for_people_and_for_programs() {
    let mut scene = scene(FOUNTAIN);
    scene.effects.set(Effect::MultipleScattering, Switch::Off);
    let plan = planned(&scene);
    let text = plan.to_string();
    for part in [
        "garden-fountain",
        "secondary_bow",
        "proved",
        "stages",
        "atmosphere",
        "sun_path",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let json: serde_json::Value = serde_json::to_value(&plan).unwrap();
    assert_eq!(json["effects"][0]["effect"], "primary_bow");
    assert_eq!(json["effects"][0]["bound"]["kind"], "proved");
    assert_eq!(json["levels"]["pixel_footprint"], "prefiltered");
    assert_eq!(planned(&scene), plan, "a pure function");
}
