//! What a person should know before running a scene.

use crate::drops::Population;
use crate::effect::Effect;
use crate::effect::Switch;
use crate::scene::Scene;

use super::EffectDecision;
use super::facts::Situation;
use super::reasons::brief;

/// The warnings of a plan.
pub(super) fn warnings(
    scene: &Scene,
    situation: &Situation,
    effects: &[EffectDecision],
) -> Vec<String> {
    let mut warnings = of_view(scene, situation);
    let is_on = |effect: Effect| effects.iter().any(|it| it.effect == effect && it.on);
    if scene.photo.is_some() && is_on(Effect::AirInscatter) {
        warnings.push(
            "air_inscatter is on: a photograph holds the light of its air already, and gets it twice"
                .to_string(),
        );
    }
    warnings.extend(of_thin_drops(scene));
    let height_m = scene.camera.position_m[1];
    if height_m < 0.0 && [Effect::Sky, Effect::AirInscatter].into_iter().any(is_on) {
        warnings.push(format!(
            "the camera is {} m below the ground, which is at y = 0: the air and the sky that it sees \
             mean nothing",
            brief(-height_m)
        ));
    }
    warnings.extend(of_large_effects(scene, effects));
    warnings
}

/// Boxes that are thinner than a voxel.
fn of_thin_drops(scene: &Scene) -> Vec<String> {
    let names = scene.drops.mode_names();
    let warning = |(population, name): (&Population, String)| {
        let grid = population.source.shape()?.grid();
        let thickness_m = (grid.max - grid.min).min_element();
        let whose = if name.is_empty() {
            name
        } else {
            format!(" {name}")
        };
        (thickness_m < grid.voxel_m).then(|| {
            format!(
                "the drops{whose} fill {} m, less than a voxel of {} m: they will stand over two \
                 voxels, as many in all but thinner",
                brief(thickness_m),
                brief(grid.voxel_m)
            )
        })
    };
    let populations = scene.drops.populations().iter().zip(names);
    populations.filter_map(warning).collect()
}

/// What of the bows is seen.
fn of_view(scene: &Scene, situation: &Situation) -> Vec<String> {
    let mut warnings = Vec::new();
    let primary_deg = situation.bows_rad.0.to_degrees();
    match situation.view.theta_deg {
        None => warnings.push("no drops are in view of the camera".to_string()),
        Some((low, high)) if !(low..=high).contains(&primary_deg) => warnings.push(format!(
            "the primary bow, near a scattering angle of {primary_deg:.0} degrees, is not in view: \
             rays through the drops scatter by {low:.0} to {high:.0} degrees"
        )),
        Some(_) => (),
    }
    let highest_deg = 180.0 - primary_deg;
    if scene.sun.elevation_deg > highest_deg {
        warnings.push(format!(
            "with the sun above {highest_deg:.0} degrees the primary bow lies below the horizon"
        ));
    }
    if scene.sun.elevation_deg < 0.0 {
        warnings.push("the sun is below the horizon".to_string());
    }
    warnings
}

/// Effects that are off although they may change the picture by more than the tolerance.
fn of_large_effects(scene: &Scene, effects: &[EffectDecision]) -> Vec<String> {
    // A photograph has its own.
    let of_photo = [Effect::Sky, Effect::AirInscatter];
    let is_meant = |it: &EffectDecision| scene.photo.is_some() && of_photo.contains(&it.effect);
    let large: Vec<&EffectDecision> = effects
        .iter()
        .filter(|it| !it.on && it.bound.value > scene.accuracy.tolerance && !is_meant(it))
        .collect();
    let is_flattening = |it: &EffectDecision| it.effect == Effect::DropFlattening;
    let mut warnings = Vec::new();
    if large.iter().any(|it| is_flattening(it)) {
        warnings.push(
            "drop_flattening is off, but drops as large as these are flat: the top of their bow \
             stands elsewhere than the picture will show"
                .to_string(),
        );
    }
    let left_out = large
        .iter()
        .filter(|it| it.asked == Switch::Off && !is_flattening(it))
        .filter(|it| !it.effect.comes_with_theory())
        .map(|it| format!("{} ({})", it.effect, brief(it.bound.value)));
    let left_out: Vec<String> = left_out.collect();
    if !left_out.is_empty() {
        warnings.push(format!(
            "the scene leaves out what may change the picture by more than the tolerance {}: {}",
            brief(scene.accuracy.tolerance),
            left_out.join(", ")
        ));
    }
    for it in large.iter().filter(|it| it.asked != Switch::Off) {
        if it.effect == Effect::MultipleScattering {
            warnings.push(format!(
                "multiple_scattering may add up to {}, and only the preset reference weighs it: ask \
                 for it in [effects]",
                brief(it.bound.value)
            ));
        } else if it.effect.comes_with_theory() {
            warnings.push(format!(
                "the {} is not simulated and may add up to {}: the theories mie and debye have it",
                it.effect,
                brief(it.bound.value)
            ));
        }
    }
    warnings
}
