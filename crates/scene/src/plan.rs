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
mod doubtful;
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
mod sequence_plan;
mod shared_tables;
mod shutter;
mod stages;
mod theory_by_size;
mod view;
mod warnings;

pub use bound::Bound;
pub use bound::BoundKind;
pub use bound::BoundTerms;
pub use decide::SHARE_FOR_EFFECTS;
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
pub use sequence_plan::PlannedFrame;
pub use shutter::Blur;
pub use stages::Estimate;
pub use stages::Stage;
pub use stages::StagePlan;

use std::collections::BTreeMap;
use std::collections::BTreeSet;

use niji_exchange::AtmosphereTable;
use niji_render::DropOrders;

use crate::accuracy::Levels;
use crate::check::Check;
use crate::effect::Effect;
use crate::effect_switches::Switch;
use crate::scene::Scene;
use crate::scene_check;

use air_light::AirLight;
use bounds::Assumed;
use bounds::BoundScene;
use facts::Situation;
use light_curves::LightCurves;
use reasons::Decided;
use stages::Chosen;

/// Plans a scene. Pure: equal arguments give equal plans.
///
/// `drops` are figures of the drops: of the file that the scene names; those of a shape, which the plan
/// finds by itself where they are not known yet.
///
/// # Errors
/// If figures of a drop file are missing or the volume is empty, drops cannot be laid out, or the scene is none
/// ([`Scene::check`], but for switches of effects that do not go together, as [`Plan::switched`] has them).
pub fn plan(scene: &Scene, drops: Option<DropSummary>) -> Result<Plan, PlanError> {
    plan_looking(scene, drops, |_| Ok(DropsSeen::default()))
}

/// As [`plan`]; `look` is asked, with what bounds foretell, what somebody measured of the drops.
///
/// # Errors
/// As [`plan`], and what `look` reports.
pub fn plan_looking<E: From<PlanError>>(
    scene: &Scene,
    drops: Option<DropSummary>,
    look: impl FnOnce(&Foretold) -> Result<DropsSeen, E>,
) -> Result<Plan, E> {
    let mut situation = checked(scene, drops)?;
    let air = LitAir::new(scene, &situation)?;
    let (seen, plan) = Known::of(scene, &situation, Some(&air), |known| {
        let decisions = known.decisions(None);
        let seen = look(&Foretold {
            on: &decisions.on,
            further_orders: decisions
                .bound(Effect::MultipleScattering)
                .filter(|_| decide::weighs_further_orders(&scene.effects, &scene.accuracy)),
            levels: situation.levels,
            display_white_cd_m2: situation.display_white_cd_m2,
        })?;
        if situation.levels_by(scene, seen.bright_drops) != situation.levels {
            return Ok::<_, E>((seen, None));
        }
        let further_orders = seen.further_orders;
        let decisions = further_orders.map_or(decisions, |it| known.decisions(Some(it)));
        Ok((seen, Some(known.plan(decisions)?)))
    })?;
    if let Some(plan) = plan {
        return Ok(plan);
    }
    situation.levels = situation.levels_by(scene, seen.bright_drops);
    let plan = Known::of(scene, &situation, Some(&air), |known| {
        known.plan(known.decisions(seen.further_orders))
    });
    Ok(plan?)
}

/// As [`plan`] for a scene every effect of which is switched on or off, in a fraction of the time: nothing is bounded,
/// and no sizes are told.
///
/// # Errors
/// As [`plan`].
pub fn plan_of_switches(scene: &Scene, drops: Option<DropSummary>) -> Result<Plan, PlanError> {
    let situation = checked(scene, drops)?;
    Known::of(scene, &situation, None, |known| {
        known.plan(known.decisions(None))
    })
}

/// A scene that is one, measured.
fn checked(scene: &Scene, drops: Option<DropSummary>) -> Result<Situation, PlanError> {
    let lines = BTreeMap::new();
    scene_check::values(scene, &Check { lines: &lines })?;
    Situation::new(scene, drops)
}

/// What small pictures show of the drops of a scene, where somebody made them.
#[derive(Clone, Copy, Debug, Default)]
pub struct DropsSeen {
    /// What light of further orders changes, where bounds leave that open.
    pub further_orders: Option<Bound>,
    /// Luminance of which errors of the scattering table are parts, RMS over the picture over display white.
    pub bright_drops: Option<f64>,
}

/// What bounds foretell, before anything is measured.
#[derive(Debug)]
pub struct Foretold<'a> {
    /// The effects that are on.
    pub on: &'a BTreeSet<Effect>,
    /// What light of further orders adds at most, where it is on if it is seen.
    pub further_orders: Option<Bound>,
    /// The level of every stage.
    pub levels: Levels,
    /// What a preview shows as white.
    pub display_white_cd_m2: f64,
}

/// Which effects are simulated.
struct Decisions {
    on: BTreeSet<Effect>,
    effects: Vec<EffectDecision>,
    /// See [`Plan::left_out_by_place`].
    left_out_by_place: Vec<Vec<f32>>,
}

impl Decisions {
    fn bound(&self, effect: Effect) -> Option<Bound> {
        let decision = self.effects.iter().find(|it| it.effect == effect);
        decision.map(|it| it.bound)
    }
}

/// The air of a scene with what it adds and takes; none in a vacuum.
struct LitAir {
    table: Option<AtmosphereTable>,
    light: Option<AirLight>,
}

impl LitAir {
    fn new(scene: &Scene, situation: &Situation) -> Result<Self, PlanError> {
        let table = situation.air_table(scene)?;
        let light = situation.air_light(table.as_ref());
        Ok(Self { table, light })
    }
}

/// A bound where nothing is bounded.
const UNBOUNDED: Bound = Bound {
    value: f64::INFINITY,
    rms: f64::INFINITY,
    kind: BoundKind::Estimated,
};

/// What decisions are made from.
struct Known<'a> {
    scene: &'a Scene,
    situation: &'a Situation,
    /// `None` where nothing is bounded.
    air: Option<&'a LitAir>,
    curves: &'a LightCurves<'a>,
    bounds: Option<BoundScene<'a>>,
}

impl Known<'_> {
    /// What `then` makes of all that is known of a scene in its air; without that nothing is bounded.
    fn of<T>(
        scene: &Scene,
        situation: &Situation,
        air: Option<&LitAir>,
        then: impl FnOnce(&Known) -> T,
    ) -> T {
        let curves = situation.curves(scene);
        let mirrored_curves = situation.mirrored_curves(scene);
        let of_suns = (&curves, mirrored_curves.as_ref());
        then(&Known {
            scene,
            situation,
            air,
            curves: &curves,
            bounds: air.map(|air| situation.bound_scene(of_suns, air.light.as_ref())),
        })
    }

    /// Decides, where `further_orders` is what light of these changes.
    fn decisions(&self, further_orders: Option<Bound>) -> Decisions {
        let Self {
            scene,
            situation,
            air,
            ref bounds,
            ..
        } = *self;
        let measured =
            |effect: Effect| further_orders.filter(|_| effect == Effect::MultipleScattering);
        let bound = |effect: Effect, assumed: &Assumed| {
            let foretold = || bounds.as_ref().map(|it| it.bound(effect, assumed));
            measured(effect).or_else(foretold).unwrap_or(UNBOUNDED)
        };
        // Those of the scene, without what it cannot have.
        let switches = decide::settled(&scene.effects, &scene.accuracy, scene.photo.is_some());
        let mut on = decide::decide(&switches, scene.accuracy.tolerance(), &bound).on;
        let seen = |effect: &Effect| bound(*effect, &decide::forced(&on, *effect)).value > 0.0;
        let rings = rings::held(situation.levels.theory, &on).into_iter();
        let rings: Vec<Effect> = rings.filter(seen).collect();
        on.extend(rings);

        let light = air.and_then(|air| air.light.as_ref());
        let facts = situation.facts(scene, (light, &on));
        let decision = |effect: Effect| {
            let (asked, is_on) = (scene.effects.of(effect), on.contains(&effect));
            let assumed = decide::forced(&on, effect);
            let foretold = bounds.as_ref();
            let foretold = foretold.map(|it| it.bound_with_terms(effect, &assumed));
            let (foretold, terms) = foretold.unwrap_or((UNBOUNDED, None));
            let bound = measured(effect).unwrap_or(foretold);
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
                is_left_out: !is_on
                    && switches.of(effect) == Switch::Auto
                    && !effect.comes_with_theory(),
                reason,
                bound,
                terms,
            }
        };
        let effects: Vec<EffectDecision> = Effect::ALL.into_iter().map(decision).collect();
        let left_out = effects.iter().filter(|it| it.is_left_out);
        let left_out: Vec<(Effect, Assumed)> = left_out
            .filter(|it| it.effect.is_bounded_by_place() && it.bound.value > 0.0)
            .map(|it| (it.effect, decide::forced(&on, it.effect)))
            .collect();
        let of_left_out = || left_out.iter().map(|(effect, assumed)| (*effect, assumed));
        let bounds = bounds.as_ref().filter(|_| !left_out.is_empty());
        Decisions {
            left_out_by_place: bounds.map_or_else(Vec::new, |it| it.by_place(of_left_out())),
            on,
            effects,
        }
    }

    /// The plan of what was decided.
    fn plan(&self, decisions: Decisions) -> Result<Plan, PlanError> {
        let Self {
            scene,
            situation,
            air,
            curves,
            ..
        } = *self;
        let Decisions {
            on,
            effects,
            left_out_by_place,
        } = decisions;
        let left_out = effects.iter().filter(|decision| decision.is_left_out);
        let left_out = left_out.map(EffectDecision::counted).sum();
        let scattering = scattering_need::scattering_need(scene, (situation, curves), &on)?;
        let angles = |need| air.map(|_| resources::angles(need, situation));
        let angles = scattering
            .as_ref()
            .map(|need| angles(need).unwrap_or_default());
        let table_need = scattering.as_ref().zip(angles.as_ref());
        let table_refused = table_need.and_then(|need| resources::refusal(need, situation));
        let levels = levels_used(situation.levels, &on, scattering.as_ref());
        let stages = stages::stages(
            scene,
            situation,
            &Chosen {
                on: &on,
                scattering: table_need,
                air: air.and_then(|air| air.table.as_ref()),
            },
        );
        Ok(Plan {
            scene: scene.name.clone(),
            sun: scene.sun,
            tolerance: scene.accuracy.tolerance(),
            display_white_cd_m2: situation.display_white_cd_m2,
            view: situation.view,
            warnings: warnings::warnings(scene, situation, &on),
            effects,
            left_out,
            left_out_by_place,
            levels,
            sky_level: stages::sky_level(scene, &on),
            scattering,
            table_refused,
            stages,
            voxel_m: situation.drops.voxel_m,
        })
    }
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
