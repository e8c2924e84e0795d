//! Levels for a tolerance follow from what they say of their own errors, and what a scene names stays.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::BRIGHT_DROPS;
use niji_scene::Effect;
use niji_scene::Goal;
use niji_scene::LEAST_TOLERANCE;
use niji_scene::Levels;
use niji_scene::Preset;
use niji_scene::SHARE_FOR_LEVELS;
use niji_scene::Scene;
use niji_scene::Switch;
use niji_scene::most_error_of_orders;
use niji_scene::most_error_of_rays;
use niji_scene::tolerance_for_rays;
use niji_scene::tolerance_for_sky;
use niji_scene::tolerance_for_spacing;
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

fn asked(scene: Scene, tolerance: f64) -> Scene {
    let goal = Goal {
        preset: None,
        tolerance: Some(tolerance),
    };
    goal.of(scene)
}

fn errors(levels: &Levels) -> [f64; 2] {
    let Integration::Adaptive { relative_error } = levels.integration else {
        panic!("{levels:?}");
    };
    [levels.table_relative_error, relative_error]
}

#[test]
fn squares_of_what_levels_may_err_by_add_up_to_half_of_the_tolerance() {
    for tolerance in [0.003, 1e-3, 2e-4] {
        let mist = asked(scene(MIST), tolerance);
        let of_light = errors(&mist.levels(2.0)).map(|error| error * BRIGHT_DROPS);
        let rays = tolerance_for_rays(tolerance);
        // Where effects left out leave nothing to them.
        let orders = most_error_of_orders(tolerance, tolerance, 0.0);
        let light = of_light[0].powi(2) + of_light[1].powi(2) + orders.powi(2);
        let sum = (light + rays * rays).sqrt();
        assert!((sum / (SHARE_FOR_LEVELS * tolerance) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn light_scattered_more_than_once_has_what_effects_leave_of_the_tolerance() {
    let tolerance = 0.01;
    let of_sky = |left_out| tolerance_for_sky(tolerance, left_out) / tolerance;
    let of_orders =
        |left_out, sky| most_error_of_orders(tolerance, left_out, sky * tolerance) / tolerance;
    assert!((of_sky(0.0) - 0.5).abs() < 1e-12);
    assert!(
        (of_orders(0.0, 0.48) - 0.64).abs() < 1e-12,
        "0.48² + 0.64² = 0.8²"
    );
    assert!((of_orders(0.5 * tolerance, 0.0) - 0.4).abs() < 1e-12);
    // No less than their part of a tolerance of whose half nothing is left.
    let least = SHARE_FOR_LEVELS / 6.0_f64.sqrt();
    for (left_out, sky) in [(tolerance, 0.0), (2.0 * tolerance, 0.0), (0.0, 0.9)] {
        assert!((of_orders(left_out, sky) - least).abs() < 1e-12);
    }
    assert!((of_sky(tolerance) - SHARE_FOR_LEVELS * 0.5_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn rays_have_what_light_of_further_orders_does_not_take() {
    let tolerance = 0.01;
    for (left_out, sky) in [(0.0, 0.0), (0.002, 0.001), (0.0, 0.0048)] {
        let rays = most_error_of_rays(tolerance, left_out, sky);
        assert_eq!(rays, most_error_of_orders(tolerance, left_out, sky));
        let table = errors(&asked(scene(MIST), tolerance).levels(2.0))[0] * BRIGHT_DROPS;
        let all = [sky, table, tolerance_for_spacing(tolerance)];
        let all = all.into_iter().fold(rays, f64::hypot);
        assert!(left_out + all < tolerance, "{left_out} {all}");
    }
    let own = tolerance_for_rays(tolerance);
    assert_eq!(most_error_of_rays(tolerance, tolerance, 0.0), own);
}

#[test]
fn no_level_is_coarser_than_that_of_the_preset_that_keeps_the_tolerance() {
    // The table of `standard`, 0.005 of light of 0.18 of white, is half of 0.0018; pictures of 0.1 and more are rough.
    for (tolerance, preset) in [
        (1.0, Preset::Draft),
        (0.1, Preset::Draft),
        (0.0999, Preset::Standard),
        (0.0018, Preset::Standard),
        (0.00179, Preset::Reference),
        (1e-6, Preset::Reference),
    ] {
        let levels = asked(scene(MIST), tolerance).levels(2.0);
        let own = preset.levels(2.0);
        assert_eq!(levels.theory, Theory::BySize);
        assert_eq!(levels.sun_path, own.sun_path, "{tolerance}");
        assert_eq!(levels.sky, own.sky);
        assert_eq!(levels.drop_orders, own.drop_orders);
        assert_eq!(levels.pixel_footprint, PixelFootprint::Prefiltered);
        // Half of a coarse tolerance, as much as `draft` has, and more in rough pictures.
        let [least, draft] =
            [Preset::Standard, Preset::Draft].map(|preset| preset.levels(2.0).table_relative_error);
        let is_rough = preset == Preset::Draft;
        let most = if is_rough {
            0.05
        } else {
            (0.5 * tolerance).clamp(least, draft)
        };
        assert!(errors(&levels).iter().all(|error| *error <= most));
    }
}

#[test]
fn presets_are_tolerances_and_a_named_one_is_kept() {
    let mut mist = scene(MIST);
    assert_eq!(mist.accuracy.tolerance(), 0.01);
    mist.accuracy.preset = Preset::Draft;
    assert_eq!(mist.accuracy.tolerance(), 0.05);
    assert_eq!(mist.levels(2.0), Preset::Draft.levels(2.0));
    mist.accuracy.tolerance = Some(0.3);
    assert_eq!(mist.accuracy.tolerance(), 0.3);
    // A tolerance on the command line is more than looking.
    let asked = asked(mist, 0.02);
    assert_eq!(asked.accuracy.preset, Preset::Standard);
    assert_eq!(asked.accuracy.tolerance(), 0.02);
}

#[test]
fn levels_for_any_tolerance_are_ones_that_a_scene_may_name() {
    for tolerance in [1.0, 1e-3, LEAST_TOLERANCE] {
        let mut mist = asked(scene(MIST), tolerance);
        let levels = mist.levels(2.0);
        mist.accuracy.table_relative_error = Some(levels.table_relative_error);
        mist.accuracy.integration = Some(levels.integration);
        mist.accuracy.pixel_footprint = Some(levels.pixel_footprint);
        let read = Scene::from_json(&mist.canonical_json());
        assert_eq!(read.unwrap().accuracy, mist.accuracy, "{tolerance}");
    }
}

#[test]
fn what_the_scene_names_stays() {
    let named = "name = \"mist\"\n[accuracy]\ntheory = \"airy\"\ntable_relative_error = 0.1\n\
                 integration = \"cell-exact\"\npixel_footprint = \"center\"";
    let mist = scene(&MIST.replace("name = \"mist\"", named));
    let levels = asked(mist, 1e-6).levels(2.0);
    assert_eq!(levels.theory, Theory::Airy);
    assert_eq!(levels.table_relative_error, 0.1);
    assert_eq!(levels.integration, Integration::CellExact);
    assert_eq!(levels.pixel_footprint, PixelFootprint::Center);
}

#[test]
fn light_of_all_orders_is_on_where_it_exceeds_half_of_the_tolerance() {
    let is_on = |scene: &Scene, tolerance| {
        let plan = planned(&asked(scene.clone(), tolerance));
        assert_eq!(
            plan.levels.drop_orders != DropOrders::SingleScattering,
            plan.is_on(Effect::MultipleScattering)
        );
        plan.is_on(Effect::MultipleScattering)
    };
    let mut mist = scene(MIST);
    let missed = planned(&mist).bound(Effect::MultipleScattering).unwrap();
    // Others are left out beside it.
    assert!(is_on(&mist, 1.9 * missed.rms) && !is_on(&mist, 20.0 * missed.rms));
    mist.effects.set(Effect::MultipleScattering, Switch::Off);
    assert!(!is_on(&mist, 1e-6), "what the scene leaves out stays out");
}

#[test]
fn a_table_errs_by_its_part_of_the_tolerance_over_the_light_that_it_is_seen_by() {
    let part = SHARE_FOR_LEVELS / 6.0_f64.sqrt();
    let errors = |tolerance, bright| {
        let mist = asked(scene(MIST), tolerance);
        mist.table_errors(bright).unwrap()
    };
    let of_some = errors(0.001, 0.02);
    // 0.0051 at most.
    assert!((of_some.table / 0.005 - 1.0).abs() < 1e-12);
    assert!((errors(0.001, 0.021).table / 0.0025 - 1.0).abs() < 1e-12);
    assert!((of_some.theory / (part * 0.001 / 0.06) - 1.0).abs() < 1e-12);
    let error = |tolerance, bright| errors(tolerance, bright).table;
    let [draft, standard] = [Preset::Draft, Preset::Standard].map(|it| it.levels(1.0));
    // No coarser, however little there is of it, and as if nobody had looked where there is much.
    for bright in [0.0, 1e-300, 1e-3] {
        assert_eq!(error(0.001, bright), standard.table_relative_error);
        assert_eq!(errors(0.01, bright).theory, draft.table_relative_error);
    }
    for bright in [1.0, 1e3, f64::INFINITY] {
        assert_eq!(error(0.01, bright), standard.table_relative_error);
    }
    let mut named = scene(MIST);
    named.accuracy.table_relative_error = Some(0.003);
    let mut preset = scene(MIST);
    preset.accuracy.preset = Preset::Reference;
    assert_eq!([named, preset].map(|it| it.table_errors(0.1)), [None; 2]);
}
