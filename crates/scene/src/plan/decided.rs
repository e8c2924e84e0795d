//! What a plan has decided.

use niji_atmosphere::ScatteringOrders;
use niji_render::MirroredLight;
use niji_render::RenderEffects;
use niji_render::SunPath;
use niji_render::Toggle;
use serde::Deserialize;
use serde::Serialize;

use crate::accuracy::Levels;
use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_switches::Switch;
use crate::scene::Scene;
use crate::sections::Sun;
use crate::sky_level::SkyLevel;

use super::bound::Bound;
use super::bound::BoundTerms;
use super::decide;
use super::resources::is_pictured_whole;
use super::scattering_need::ScatteringNeed;
use super::stages::Stage;
use super::stages::StagePlan;

/// One effect, decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectDecision {
    /// The effect.
    pub effect: Effect,
    /// What the scene asks.
    pub asked: Switch,
    /// Whether it is simulated.
    pub on: bool,
    /// Whether the plan left it out by itself: not the scene, nor its theory, nor what it cannot do without.
    pub is_left_out: bool,
    /// Why.
    pub reason: String,
    /// What it contributes at most.
    pub bound: Bound,
    /// The numbers of the bound; `None` where it is 0, and for a sequence.
    pub terms: Option<BoundTerms>,
}

impl EffectDecision {
    /// What of its bound counts against the tolerance.
    pub fn counted(&self) -> f64 {
        decide::counted(self.effect, self.bound)
    }
}

/// What the camera sees of the drops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// Where its sun stands, also where the scene names a moment.
    pub sun: Sun,
    /// Largest RMS error of luminance over the picture, relative to `display_white_cd_m2`.
    pub tolerance: f64,
    /// What a preview shows as white: at exposure 0 a white plane that faces the sun above the air,
    /// E_sun/pi, half as much for every stop of the picture's exposure.
    pub display_white_cd_m2: f64,
    /// What the camera sees of the drops.
    pub view: View,
    /// Every effect.
    pub effects: Vec<EffectDecision>,
    /// Sum of the bounds of the effects that the plan left out by itself.
    pub left_out: f64,
    /// What of it may be where, by row and column of equal parts of the picture, overscan included, over display white: of
    /// effects that are [bounded by place](Effect::is_bounded_by_place). Empty where there is none, and for a sequence.
    #[serde(skip)]
    pub left_out_by_place: Vec<Vec<f32>>,
    /// The level of every stage.
    pub levels: Levels,
    /// How finely light that the air scattered before is solved; `None` where the model of the sky does not ask
    /// for it, or nothing that is on shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sky_level: Option<SkyLevel>,
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

impl Plan {
    /// The same plan for a preview that is so many times brighter: what is told over display white is as much more.
    #[must_use]
    pub fn brighter(mut self, times: f64) -> Self {
        self.display_white_cd_m2 /= times;
        self.left_out *= times;
        for decision in &mut self.effects {
            decision.bound.value *= times;
            decision.bound.rms *= times;
        }
        self
    }

    /// Whether an effect is simulated.
    pub fn is_on(&self, effect: Effect) -> bool {
        self.effects
            .iter()
            .any(|decision| decision.effect == effect && decision.on)
    }

    /// Whether all of a scene's picture is in memory before it is written.
    pub fn is_pictured_whole(&self, scene: &Scene) -> bool {
        is_pictured_whole(scene, self.is_on(Effect::MotionBlur))
    }

    /// The effects that are simulated.
    pub fn effects_on(&self) -> impl Iterator<Item = Effect> {
        let on = self.effects.iter().filter(|decision| decision.on);
        on.map(|decision| decision.effect)
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
        let is_photo = self.runs(Stage::Composite);
        let is_meant = move |effect: Effect| is_photo && effect.is_in_photographs();
        let off = self.effects.iter().filter(|it| !it.on);
        off.filter(move |it| it.counted() > self.tolerance && !is_meant(it.effect))
    }

    /// How finely light that the air scattered before is solved for the table of the air.
    pub fn scattering_orders(&self) -> Option<ScatteringOrders> {
        self.sky_level.map(SkyLevel::orders)
    }

    /// Whether a stage runs.
    pub fn runs(&self, stage: Stage) -> bool {
        self.stages.iter().any(|planned| planned.stage == stage)
    }

    /// The effects as the renderer takes them.
    pub fn render_effects(&self) -> RenderEffects {
        let mut effects = RenderEffects::BOWS_ONLY;
        for (effect, toggle) in Effect::ALL.map(|effect| (effect, effect.row().toggle)) {
            let Some(toggle) = toggle else { continue };
            // Without a table no drop in view sends light.
            let is_lit = effect.row().role != Role::Order || self.scattering.is_some();
            *toggle(&mut effects) = if self.is_on(effect) && is_lit {
                Toggle::On
            } else {
                Toggle::Off
            };
        }
        effects
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
        let mut lights = self.effects.iter().filter(|decision| {
            let role = decision.effect.row().role;
            let is_light = [Role::Order, Role::AirLight].contains(&role)
                || [Effect::LitSurfaces, Effect::SeenWater].contains(&decision.effect);
            decision.on && is_light
        });
        // A bound of 0 is exactly 0.
        lights.all(|decision| decision.bound.value <= 0.0)
    }
}
