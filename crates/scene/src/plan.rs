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
mod depth;
mod directed_curve;
mod display;
mod drop_file;
mod drop_parts;
mod drop_summary;
mod effect_texts;
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
mod shared_tables;
mod stages;
mod theory_by_size;
mod view;
mod warnings;

pub use bound::Bound;
pub use bound::BoundKind;
pub use bound::BoundTerms;
pub(crate) use decide::SHARE_FOR_EFFECTS;
pub use drop_parts::DropPart;
pub use drop_summary::DropSummary;
pub use explain::Explanation;
pub use given_table::Misfit;
pub use laws_in_light::LawsInLight;
pub use stages::Estimate;
pub use stages::ScatteringNeed;
pub use stages::Stage;
pub use stages::StagePlan;

use std::collections::BTreeSet;

use niji_atmosphere::ScatteringOrders;
use niji_render::DropOrders;
use niji_render::MirroredLight;
use niji_render::RenderEffects;
use niji_render::SunPath;
use niji_render::Toggle;
use serde::Serialize;
use thiserror::Error;

use crate::accuracy::Levels;
use crate::effect::Effect;
use crate::effect::Switch;
use crate::scene::Scene;
use crate::sections::Sun;

use bounds::Assumed;
use facts::Situation;

/// Why there is no plan.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The drops are in a file whose figures were not given, or which has no drops.
    #[error("the drop volume {file} holds no drops, or was not read")]
    NoDrops {
        /// The file, or the shape.
        file: String,
    },
    /// Drops that cannot be laid out.
    #[error("[drops]")]
    Drops(#[from] niji_droplets::Error),
    /// The camera of a scene that was not read from a file.
    #[error("camera")]
    Camera(#[from] niji_geometry::Error),
    /// The spectrum of a scene that was not read from a file.
    #[error("spectrum")]
    Spectrum(#[from] niji_radiometry::Error),
    /// The air of a scene that was not read from a file.
    #[error("air")]
    Air(#[from] niji_atmosphere::Error),
    /// Axes of the scattering table.
    #[error("scattering table")]
    Scatter(#[from] niji_scatter::Error),
    /// Sizes of the scattering table.
    #[error("scattering table")]
    Sizes(#[from] niji_sizes::Error),
}

/// One effect, decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectDecision {
    /// The effect.
    pub effect: Effect,
    /// What the scene asks.
    pub asked: Switch,
    /// Whether it is simulated.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// What it contributes at most.
    pub bound: Bound,
    /// The numbers of the bound; `None` where it is 0.
    pub terms: Option<BoundTerms>,
}

/// What the camera sees of the drops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct View {
    /// Smallest and largest scattering angle of rays that may meet drops, degrees.
    pub theta_deg: Option<(f64, f64)>,
    /// Nearest and farthest drops in view, m.
    pub distance_m: Option<(f64, f64)>,
    /// Largest optical depth of the drops on a ray, without diffraction.
    pub max_optical_depth: f64,
    /// Largest optical depth of the drops towards the sun, without diffraction.
    pub max_sun_optical_depth: f64,
}

/// A plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// Where its sun stands, also where the scene names a moment.
    pub sun: Sun,
    /// Largest RMS error of luminance over the picture, relative to `reference_luminance_cd_m2`.
    pub tolerance: f64,
    /// What a gray card (albedo 0.18) that faces the sun above the air looks like at exposure 0:
    /// 0.18 E_sun/pi, half as much for every stop of the picture's exposure.
    pub reference_luminance_cd_m2: f64,
    /// What the camera sees of the drops.
    pub view: View,
    /// Every effect.
    pub effects: Vec<EffectDecision>,
    /// Sum of the bounds of the effects that the plan left out by itself.
    pub left_out: f64,
    /// The level of every stage.
    pub levels: Levels,
    /// The scattering table that is needed; `None` where no bow is in view.
    pub scattering: Option<ScatteringNeed>,
    /// Why the stage would refuse to make that table.
    #[serde(skip)]
    pub table_refused: Option<niji_scatter::Error>,
    /// The stages to run, in order.
    pub stages: Vec<StagePlan>,
    /// Edge of a voxel of the drops (m).
    pub voxel_m: f64,
    /// What a person should know before running.
    pub warnings: Vec<String>,
}

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
        let reason = reasons::reason(effect, (asked, is_on), &bound, &facts);
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
    let scattering = stages::scattering_need(scene, (&situation, &curves), &on)?;
    let with_angles = |need| (need, resources::n_angles(need, &situation));
    let table_need = scattering.as_ref().map(with_angles);
    let table_refused = table_need.and_then(|need| resources::refusal(need, &situation));
    let levels = levels_used(situation.levels, &on, scattering.as_ref());
    let stages = stages::stages(scene, &situation, (&on, table_need, table.as_ref()));
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

impl Plan {
    /// Whether an effect is simulated.
    pub fn is_on(&self, effect: Effect) -> bool {
        self.effects
            .iter()
            .any(|decision| decision.effect == effect && decision.on)
    }

    /// What an effect contributes at most.
    pub fn bound(&self, effect: Effect) -> Option<Bound> {
        let decision = self
            .effects
            .iter()
            .find(|decision| decision.effect == effect);
        decision.map(|decision| decision.bound)
    }

    /// The effects that are off although they may be seen, because they may change the picture by more
    /// than the tolerance; sky and air of a photograph are in it.
    pub fn missed(&self) -> impl Iterator<Item = &EffectDecision> {
        let of_photo = [Effect::Sky, Effect::AirInscatter];
        let is_photo = self.runs(Stage::Composite);
        let is_meant = move |effect| is_photo && of_photo.contains(&effect);
        let off = self.effects.iter().filter(|it| !it.on);
        off.filter(move |it| it.bound.value > self.tolerance && !is_meant(it.effect))
    }

    /// How finely light that the air scattered before is solved for the table of the air; `None` where
    /// the level of the sky does not ask for it, or nothing that is on shows it.
    pub fn scattering_orders(&self, scene: &Scene) -> Option<ScatteringOrders> {
        stages::scattering_orders(scene, |effect| self.is_on(effect))
    }

    /// Whether a stage runs.
    pub fn runs(&self, stage: Stage) -> bool {
        self.stages.iter().any(|planned| planned.stage == stage)
    }

    /// The effects as the renderer takes them.
    pub fn render_effects(&self) -> RenderEffects {
        let toggle = |effect| {
            if self.is_on(effect) {
                Toggle::On
            } else {
                Toggle::Off
            }
        };
        // Without a table no drop in view sends light.
        let of_table = |effect| match &self.scattering {
            Some(_) => toggle(effect),
            None => Toggle::Off,
        };
        RenderEffects {
            primary_bow: of_table(Effect::PrimaryBow),
            secondary_bow: of_table(Effect::SecondaryBow),
            higher_orders: of_table(Effect::HigherOrders),
            drop_extinction: toggle(Effect::DropExtinction),
            drop_shadow: toggle(Effect::DropShadow),
            skylit_drops: toggle(Effect::SkylitDrops),
            sunlight_through_air: toggle(Effect::SunlightThroughAir),
            air_extinction: toggle(Effect::AirExtinction),
            air_inscatter: toggle(Effect::AirInscatter),
            sky: toggle(Effect::Sky),
        }
    }

    /// How the drops are lit: not at all if their shadow is off.
    pub fn sun_path(&self) -> SunPath {
        if self.is_on(Effect::DropShadow) {
            self.levels.sun_path
        } else {
            SunPath::Ignore
        }
    }

    /// What of the light that the scene's water mirrors lights the drops; `None` if it does not.
    pub fn mirrored_light(&self) -> Option<MirroredLight> {
        let is_lit = self.is_on(Effect::ReflectionBow) && self.scattering.is_some();
        is_lit.then_some(self.levels.mirrored_light)
    }

    /// Whether no enabled effect sends any light: a request that cannot be met.
    pub fn is_dark(&self) -> bool {
        let lights = [
            Effect::PrimaryBow,
            Effect::SecondaryBow,
            Effect::HigherOrders,
            Effect::AirInscatter,
            Effect::Sky,
        ];
        let sends = |effect: &Effect| {
            // An unknown size may be light; a bound of 0 is exactly 0.
            self.is_on(*effect) && self.bound(*effect).is_none_or(|bound| bound.value > 0.0)
        };
        !lights.iter().any(sends)
    }
}
