//! What a scene calls for: which effects are simulated and why, what leaving the others out can
//! cost, which stages run with which tables, and what that takes.
//!
//! A pure function of the scene and of what others have read of its drops. Bounds are derived
//! in `bounds`, the choice of what is left out in `decide`.

mod air_light;
mod bound;
mod bounds;
mod cache;
mod curve;
mod decide;
mod decided;
mod depth;
mod directed_curve;
mod display;
mod drop_file;
mod drop_parts;
mod drop_summary;
mod error;
mod explain;
mod facts;
mod flat_drops;
mod given_table;
mod higher_orders;
mod laws_in_light;
mod light_curves;
mod luminance;
mod reasons;
mod resources;
mod rings;
mod scattering_need;
mod shared_tables;
mod stages;
mod theory_by_size;
mod view;
mod warnings;

pub use bound::Bound;
pub use bound::BoundKind;
pub use bound::BoundTerms;
pub(crate) use decide::SHARE_FOR_EFFECTS;
pub use decided::EffectDecision;
pub use decided::Plan;
pub use decided::View;
pub use drop_parts::DropPart;
pub use drop_summary::DropSummary;
pub use error::PlanError;
pub use explain::Explanation;
pub use given_table::Misfit;
pub use laws_in_light::LawsInLight;
pub use scattering_need::ScatteringNeed;
pub use stages::Estimate;
pub use stages::Stage;
pub use stages::StagePlan;

use std::collections::BTreeSet;

use niji_render::DropOrders;

use crate::accuracy::Levels;
use crate::effect::Effect;
use crate::effect_switches::Switch;
use crate::scene::Scene;

use bounds::Assumed;
use facts::Situation;
use reasons::Decided;
use stages::Chosen;

/// Plans a scene. Pure: equal arguments give equal plans.
///
/// `drops` are figures of the drops: of the file that the scene names; those of a shape, which the plan
/// finds by itself where they are not known yet.
///
/// # Errors
/// If figures of a drop file are missing or the volume is empty, drops cannot be laid out, or parts of a scene that was not
/// read from a file are out of range.
pub fn plan(scene: &Scene, drops: Option<DropSummary>) -> Result<Plan, PlanError> {
    let situation = Situation::new(scene, drops)?;
    let table = situation.air_table(scene)?;
    let air = situation.air_light(table.as_ref());
    let curves = situation.curves(scene);
    let mirrored_curves = situation.mirrored_curves(scene);
    let curves_of_suns = (&curves, mirrored_curves.as_ref());
    let bound_scene = situation.bound_scene(curves_of_suns, air.as_ref());
    let bound = |effect: Effect, assumed: &Assumed| bound_scene.bound(effect, assumed);
    let switches = decide::settled(&scene.effects, &scene.accuracy);
    let mut on = decide::decide(&switches, scene.accuracy.tolerance, &bound).on;
    let seen = |effect: &Effect| bound(*effect, &decide::forced(&on, *effect)).value > 0.0;
    let rings = rings::held(situation.levels.theory, &on).into_iter();
    let rings: Vec<Effect> = rings.filter(seen).collect();
    on.extend(rings);

    let facts = situation.facts(scene, (air.as_ref(), &on));
    let decision = |effect: Effect| {
        let (asked, is_on) = (scene.effects.of(effect), on.contains(&effect));
        let assumed = decide::forced(&on, effect);
        let (bound, terms) = bound_scene.bound_with_terms(effect, &assumed);
        let decided = Decided {
            effect,
            asked,
            is_on,
            bound,
        };
        let reason = reasons::reason(&decided, &facts);
        EffectDecision {
            effect,
            asked,
            on: is_on,
            reason,
            bound,
            terms,
        }
    };
    let effects: Vec<EffectDecision> = Effect::ALL.into_iter().map(decision).collect();
    let left_out = effects
        .iter()
        .filter(|decision| !decision.on && switches.of(decision.effect) == Switch::Auto)
        .filter(|decision| !decision.effect.comes_with_theory())
        .map(|decision| decision.bound.value)
        .sum();
    let scattering = scattering_need::scattering_need(scene, (&situation, &curves), &on)?;
    let angles = |need| resources::angles(need, &situation);
    let angles = scattering.as_ref().map(angles);
    let table_need = scattering.as_ref().zip(angles.as_ref());
    let table_refused = table_need.and_then(|need| resources::refusal(need, &situation));
    let levels = levels_used(situation.levels, &on, scattering.as_ref());
    let stages = stages::stages(
        scene,
        &situation,
        &Chosen {
            on: &on,
            scattering: table_need,
            air: table.as_ref(),
        },
    );
    Ok(Plan {
        scene: scene.name.clone(),
        sun: scene.sun,
        tolerance: scene.accuracy.tolerance,
        reference_luminance_cd_m2: situation.reference_luminance_cd_m2,
        view: situation.view,
        warnings: warnings::warnings(scene, &situation, &on),
        effects,
        left_out,
        levels,
        scattering,
        table_refused,
        stages,
        voxel_m: situation.drops.voxel_m,
    })
}

/// The levels, without those of what is left out.
fn levels_used(levels: Levels, on: &BTreeSet<Effect>, need: Option<&ScatteringNeed>) -> Levels {
    if on.contains(&Effect::MultipleScattering) && need.is_some() {
        return levels;
    }
    Levels {
        drop_orders: DropOrders::SingleScattering,
        ..levels
    }
}
