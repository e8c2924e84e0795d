//! What a sequence calls for: one plan for all of its frames, so that nothing jumps between two of them.
//!
//! Some frames are planned, each by itself. An effect that any of them shows is on, with the largest of its bounds;
//! levels and scattering table are those of a scene that has the drops of all of them and sees the angles of all
//! frames.

use std::collections::BTreeSet;

use super::Decisions;
use super::Known;
use super::LitAir;
use super::decide::counted;
use super::decided::EffectDecision;
use super::decided::Plan;
use super::drop_summary::DropSummary;
use super::error::PlanError;
use super::facts::Situation;
use super::facts::display_white_cd_m2;
use super::scattering_need::ScatteringNeed;
use crate::scene::Scene;

/// A frame that was planned by itself.
#[derive(Debug)]
pub struct PlannedFrame {
    /// Its number.
    pub number: u32,
    /// Its scene.
    pub scene: Scene,
    /// Figures of its drops.
    pub drops: DropSummary,
    /// What it calls for.
    pub plan: Plan,
}

impl Plan {
    /// The plan of a sequence, from a frame and others that were planned, and the most light in any of them of which
    /// errors of the table are parts; `between` are more of its frames, so that the scattering table holds their angles.
    ///
    /// # Errors
    /// As [`plan`](super::plan()).
    pub fn of_sequence<'a>(
        (first, others): (&PlannedFrame, &[PlannedFrame]),
        bright_drops: Option<f64>,
        mut between: impl Iterator<Item = &'a Scene>,
    ) -> Result<Self, PlanError> {
        let frames = || std::iter::once(first).chain(others);
        let drops = DropSummary::of_any(&first.drops, others.iter().map(|it| &it.drops));
        let mut situation = Situation::new(&first.scene, Some(drops.clone()))?;
        let mut see = |scene: &Scene| {
            situation.see(&Situation::new(scene, Some(drops.clone()))?);
            Ok::<_, PlanError>(())
        };
        frames().try_for_each(|it| see(&it.scene))?;
        between.try_for_each(see)?;
        situation.levels = situation.levels_by(&first.scene, bright_drops);
        let plans: Vec<&Self> = frames().map(|it| &it.plan).collect();
        let on: BTreeSet<_> = plans.iter().flat_map(|it| it.effects_on()).collect();
        let effects = (0..first.plan.effects.len()).map(|effect| of_any(effect, &plans));
        let decisions = Decisions {
            on,
            effects: effects.collect(),
            // It moves from frame to frame.
            left_out_by_place: Vec::new(),
        };
        let air = LitAir {
            table: situation.air_table(&first.scene)?,
            // All was decided.
            light: None,
        };
        let plan = Known::of(&first.scene, &situation, Some(&air), |known: &Known| {
            known.plan(decisions)
        })?;
        Ok(Self {
            scattering: plan.scattering.map(ScatteringNeed::with_rounded_directions),
            warnings: warnings(frames()),
            ..plan
        })
    }

    /// The same for a frame.
    #[must_use]
    pub fn of_frame(&self, scene: &Scene) -> Self {
        Self {
            scene: scene.name.clone(),
            sun: scene.sun,
            tolerance: scene.accuracy.tolerance(),
            display_white_cd_m2: display_white_cd_m2(scene),
            warnings: Vec::new(),
            ..self.clone()
        }
    }
}

/// An effect as it is in the plan in which it is seen most, on where it is on in any.
fn of_any(effect: usize, plans: &[&Plan]) -> EffectDecision {
    let decisions = || plans.iter().map(|it| &it.effects[effect]);
    let size = |it: &EffectDecision| (it.on, counted(it.effect, it.bound));
    let most = decisions().fold(&plans[0].effects[effect], |most, it| {
        if size(it) > size(most) { it } else { most }
    });
    let largest = decisions().fold(most.bound, |largest, it| {
        let is_larger = counted(it.effect, it.bound) > counted(it.effect, largest);
        if is_larger { it.bound } else { largest }
    });
    EffectDecision {
        bound: largest,
        is_left_out: !most.on && decisions().any(|it| it.is_left_out),
        terms: None,
        ..most.clone()
    }
}

/// What is to be known of frames, each thing once.
fn warnings<'a>(frames: impl Iterator<Item = &'a PlannedFrame>) -> Vec<String> {
    let (mut told, mut warnings) = (BTreeSet::new(), Vec::new());
    for frame in frames {
        for warning in &frame.plan.warnings {
            if told.insert(warning) {
                warnings.push(format!("frame {}: {warning}", frame.number));
            }
        }
    }
    warnings
}
