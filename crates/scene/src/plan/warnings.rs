//! What a person should know before running a scene: where it contradicts itself.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::drops::Population;
use crate::effect::Effect;
use crate::effect::Role;
use crate::figures::brief;
use crate::scene::Scene;

use super::doubtful::doubts;
use super::facts::Situation;

/// The warnings of a plan.
pub(super) fn warnings(scene: &Scene, situation: &Situation, on: &BTreeSet<Effect>) -> Vec<String> {
    let misfit = scene.photo.iter().filter_map(|it| it.misfit.clone());
    let mut warnings: Vec<String> = misfit.collect();
    warnings.extend(doubts(scene, situation));
    warnings.extend(of_view(scene, situation));
    let is_on = |effect: Effect| on.contains(&effect);
    if scene.photo.is_some() && is_on(Effect::AirInscatter) {
        warnings.push(
            "air_inscatter is on: a photograph holds the light of its air already, and gets it twice"
                .to_string(),
        );
    }
    warnings.extend(of_thin_drops(scene));
    let height_m = scene.camera.position_m[1];
    if height_m < 0.0 && Effect::of_role(Role::AirLight).any(is_on) {
        warnings.push(format!(
            "the camera is {} m below the ground, which is at y = 0: the air and the sky that it sees \
             mean nothing",
            brief(-height_m)
        ));
    }
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

/// Whether a direction falls on a pixel.
fn is_in_frame(situation: &Situation, direction: DVec3) -> bool {
    let camera = &situation.camera;
    let inside = |at: f64, n_px: u32| (0.0..=f64::from(n_px)).contains(&at);
    let place = camera.project(direction);
    place.is_some_and(|(x, y)| inside(x, camera.width_px()) && inside(y, camera.height_px()))
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
        warnings.push("the sun is below the horizon: sun.elevation_deg is below 0".to_string());
    } else if scene.photo.is_none() && is_in_frame(situation, scene.sun.direction()) {
        warnings.push(
            "the sun stands in the frame: its disc is not drawn, only what air, drops, water and surfaces send of it"
                .to_string(),
        );
    }
    warnings
}
