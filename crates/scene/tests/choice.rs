//! Levels are chosen by what was measured of them, and errors carried in proportion to the light.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use niji_scene::Choice;
use niji_scene::ChoiceError;
use niji_scene::ChoiceRequest;
use niji_scene::DECISIONS;
use niji_scene::Effect;
use niji_scene::Goal;
use niji_scene::MeasuredLevels;
use niji_scene::Origin;
use niji_scene::Plan;
use niji_scene::PlanInputs;
use niji_scene::Scene;
use niji_scene::Switch;
use niji_scene::calls_for_multiple_scattering;
use niji_scene::choose;
use niji_scene::light_of;
use niji_scene::plan;

/// Drops of 50 um in a vacuum, optical depth 0.08.
const SCENE: &str = "
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

/// All but the theory and the integration are free; light 1 throughout.
const CSV: &str =
    "stage,level,scene,luminance_error,light,radius_um,relative_time,seconds,work,date
drops,total,a,,,50,,0.1,1,d
airy,total,a,,,50,,0.1,1,d
scatter,total,a,,,50,,1.0,1,d
render,total,a,,,50,,1.0,1,d
theory,airy,a,0.1,1,50,0.5,,,d
theory,uniform,a,0.01,1,50,1,,,d
theory,mie,a,0,1,50,4,,,d
integration,fixed-step voxels=2.0,a,0.02,1,50,0.5,,,d
integration,cell-exact,a,0,1,50,1,,,d
";

fn scene(changes: &[(&str, &str)]) -> Scene {
    let text = changes
        .iter()
        .fold(SCENE.to_string(), |text, (from, to)| text.replace(from, to));
    Scene::from_toml(&text).unwrap()
}

fn planned(scene: &Scene, measured: &MeasuredLevels) -> Plan {
    let inputs = PlanInputs {
        measured,
        drops: None,
    };
    plan(scene, &inputs).unwrap()
}

fn chosen(scene: &Scene, goals: &[Goal]) -> Vec<Result<Choice, ChoiceError>> {
    chosen_by(CSV, scene, goals)
}

fn chosen_by(csv: &str, scene: &Scene, goals: &[Goal]) -> Vec<Result<Choice, ChoiceError>> {
    let measured = &MeasuredLevels::from_csv(csv).unwrap();
    let plan = &planned(scene, measured);
    let choice = |goal: &Goal| {
        choose(&ChoiceRequest {
            scene,
            plan,
            measured,
            goal: *goal,
        })
    };
    goals.iter().map(choice).collect()
}

fn chosen_for(scene: &Scene, goal: Goal) -> Choice {
    chosen(scene, &[goal]).remove(0).unwrap()
}

fn level(choice: &Choice, decision: &str) -> (String, Origin) {
    let found = choice.levels.iter().find(|it| it.decision == decision);
    let found = found.unwrap();
    (found.level.clone(), found.origin)
}

fn light(scene: &Scene, key: &str) -> f64 {
    let decision = DECISIONS.iter().find(|it| it.key == key).unwrap();
    light_of(decision, &planned(scene, &MeasuredLevels::default()))
}

#[test]
fn the_cheapest_levels_whose_errors_sum_to_half_of_the_tolerance_are_chosen() {
    let scene = scene(&[]);
    let light = light(&scene, "theory");
    assert!(light > 0.0);
    // In units of the light: airy 0.1, uniform 0.01, mie 0; fixed step 0.02.
    // The rays take longest, so that of what is left over their level is made cheaper first.
    let expected = [
        (0.121, "airy", "fixed-step step_m=10.0"),
        (0.119, "uniform", "fixed-step step_m=10.0"),
        (0.031, "uniform", "fixed-step step_m=10.0"),
        (0.029, "mie", "fixed-step step_m=10.0"),
        (0.019, "uniform", "cell-exact"),
        (0.009, "mie", "cell-exact"),
    ];
    let goals = expected.map(|(allowed, _, _)| Goal::Tolerance(2.0 * allowed * light));
    for ((allowed, theory, integration), choice) in expected.into_iter().zip(chosen(&scene, &goals))
    {
        let choice = choice.unwrap();
        assert_eq!(level(&choice, "theory").0, theory, "{allowed}");
        assert_eq!(level(&choice, "integration").0, integration, "{allowed}");
        assert!(choice.predicted_error <= allowed * light);
        assert_eq!(level(&choice, "sun_path").1, Origin::Unmeasured);
    }
}

#[test]
fn an_adaptive_integral_counts_with_the_error_it_is_allowed() {
    // On the drops of the calibration it erred twenty times less.
    let csv = format!("{CSV}integration,adaptive relative_error=0.02,a,0.001,1,50,0.1,,,d\n");
    let scene = scene(&[]);
    let light = light(&scene, "theory");
    let goals = [0.021, 0.019].map(|allowed| Goal::Tolerance(2.0 * allowed * light));
    let [large, small] = [0, 1].map(|index| {
        let choice = chosen_by(&csv, &scene, &goals)[index].clone();
        level(&choice.unwrap(), "integration").0
    });
    assert_eq!(large, "adaptive relative_error=0.02");
    assert_eq!(small, "cell-exact");
}

#[test]
fn an_error_grows_with_the_light_that_it_is_of() {
    let [dim, bright] = ["1e5", "2e5"].map(|number| scene(&[("1e5", number)]));
    let error = |scene: &Scene| {
        let choice = chosen_for(scene, Goal::Tolerance(1.0));
        let theory = choice.levels.iter().find(|it| it.decision == "theory");
        theory.unwrap().error.unwrap()
    };
    let ratio = light(&bright, "theory") / light(&dim, "theory");
    assert!((error(&bright) / error(&dim) - ratio).abs() < 1e-12);
    // Twice the drops in a thin cloud are nearly twice as bright.
    assert!((1.7..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn what_the_scene_names_stays() {
    let named = "name = \"mist\"\naccuracy = { theory = \"airy\" }";
    let scene = scene(&[("name = \"mist\"", named)]);
    let choice = chosen_for(&scene, Goal::Tolerance(1e-6));
    let theory = ("airy".to_string(), Origin::Named);
    assert_eq!(level(&choice, "theory"), theory);
    assert!(choice.predicted_error > 5e-7, "and its error is told");
}

#[test]
fn a_budget_buys_the_most_accurate_levels_that_fit() {
    let scene = scene(&[]);
    let all = chosen_for(&scene, Goal::Budget(1e9));
    assert_eq!(level(&all, "theory").0, "mie");
    let time = |choice: &Choice| choice.predicted_seconds.unwrap();
    let goals = [Goal::Budget(0.99 * time(&all)), Goal::Budget(1e-9)];
    let [less, refused] = chosen(&scene, &goals).try_into().unwrap();
    let less = less.unwrap();
    assert!(time(&less) < time(&all) && less.predicted_error > all.predicted_error);
    let Err(ChoiceError::OverBudget { least_seconds, .. }) = refused else {
        panic!("{refused:?}");
    };
    let least = chosen_for(&scene, Goal::Budget(least_seconds));
    assert_eq!(level(&least, "theory").0, "airy");
}

#[test]
fn light_of_all_orders_is_called_for_where_it_exceeds_half_of_the_tolerance() {
    let measured = MeasuredLevels::default();
    let asks = |scene: &Scene, tolerance| {
        calls_for_multiple_scattering(scene, &planned(scene, &measured), tolerance)
    };
    let mut mist = scene(&[]);
    let missed = planned(&mist, &measured).bound(Effect::MultipleScattering);
    let missed = missed.unwrap().rms;
    assert!(asks(&mist, 1.9 * missed) && !asks(&mist, 2.1 * missed));
    mist.effects.set(Effect::MultipleScattering, Switch::Off);
    assert!(!asks(&mist, 1e-9), "what the scene leaves out stays out");
}

#[test]
fn a_theory_without_orders_has_the_light_of_one_with_them() {
    let of_theory = |name: &str| {
        let named = format!("name = \"mist\"\naccuracy = {{ theory = \"{name}\" }}");
        light(&scene(&[("name = \"mist\"", &named)]), "theory")
    };
    // Each of the three orders counts as the light of all: root of three, times what they exceed the
    // sum of squares by.
    let ratio = of_theory("mie") / of_theory("uniform");
    assert!((1.0..1.9).contains(&ratio), "{ratio}");
}
