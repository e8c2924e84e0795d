//! One effect of a plan explained: what it is, how its bound comes about, what switching it over does.

use std::fmt;
use std::fmt::Write as _;

use serde::Serialize;

use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_rows::Row;
use crate::effect_switches::Switch;
use crate::figures::brief;
use crate::figures::length;
use crate::scene::Scene;

use super::bound::Bound;
use super::bound::BoundKind;
use super::bound::BoundTerms;
use super::decided::EffectDecision;
use super::decided::Plan;
use super::scattering_need::ScatteringNeed;

/// An effect in a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// The effect.
    pub effect: Effect,
    /// What the scene asks.
    pub asked: Switch,
    /// Whether it is simulated.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// What it is.
    pub what: &'static str,
    /// What it contributes at most.
    pub bound: Option<Bound>,
    /// How the bound is computed.
    pub formula: &'static str,
    /// The numbers in it, at the part of the picture where it is largest.
    pub terms: Option<BoundTerms>,
    /// What switching it over would do to stages and tables, a line each; empty where it cannot be
    /// switched.
    pub switching: Vec<String>,
    /// Where it is published.
    pub source: &'static str,
}

impl Plan {
    /// Explains one decision; `switched` is the plan of [`Plan::switched`].
    pub fn explain(&self, effect: Effect, switched: Option<&Plan>) -> Explanation {
        let row = effect.row();
        let decision = self.effects.iter().find(|it| it.effect == effect);
        Explanation {
            effect,
            asked: decision.map_or(Switch::Auto, |it| it.asked),
            on: decision.is_some_and(|it| it.on),
            reason: decision.map(|it| it.reason.clone()).unwrap_or_default(),
            what: row.what,
            bound: decision.map(|it| it.bound),
            formula: row.formula,
            terms: decision.and_then(|it| it.terms),
            switching: switched
                .map(|other| differences(self, other))
                .unwrap_or_default(),
            source: row.source,
        }
    }

    /// The scene of this plan with all its decisions spelt out and one of them the other way; `None`
    /// where it cannot be: surfaces always hide, a theory has its rings or not, a vacuum has no air, dry
    /// ground mirrors nothing, and what another effect needs stays.
    pub fn switched(&self, scene: &Scene, effect: Effect) -> Option<Scene> {
        let is_needed = |it: &EffectDecision| it.on && it.effect.needs().contains(&effect);
        let Row { role, section, .. } = effect.row();
        let is_fixed = [Role::Fixed, Role::OfTheory].contains(role)
            || section.is_some_and(|section| !scene.has(section))
            || self.effects.iter().any(is_needed);
        if is_fixed {
            return None;
        }
        let mut switched = self.settled(scene);
        let asked = if self.is_on(effect) {
            Switch::Off
        } else {
            Switch::On
        };
        switched.effects.set(effect, asked);
        Some(switched)
    }

    /// The scene of this plan with all its decisions spelt out.
    #[must_use]
    pub fn settled(&self, scene: &Scene) -> Scene {
        let mut settled = scene.clone();
        for it in self
            .effects
            .iter()
            .filter(|it| !it.effect.comes_with_theory())
        {
            let asked = if it.on { Switch::On } else { Switch::Off };
            settled.effects.set(it.effect, asked);
        }
        settled
    }
}

/// What differs between the stages of two plans.
fn differences(one: &Plan, other: &Plan) -> Vec<String> {
    let mut lines = Vec::new();
    for stage in &other.stages {
        match one.stages.iter().find(|it| it.stage == stage.stage) {
            None => lines.push(format!(
                "stage {} runs as well: {}",
                stage.stage.name(),
                stage.makes
            )),
            Some(before) if before.makes != stage.makes => {
                lines.push(format!(
                    "stage {} makes: {}",
                    stage.stage.name(),
                    stage.makes
                ));
            }
            Some(_) => (),
        }
    }
    let gone = one.stages.iter().filter(|stage| !other.runs(stage.stage));
    lines.extend(gone.map(|stage| format!("stage {} does not run", stage.stage.name())));
    if let (Some(before), Some(after)) = (&one.scattering, &other.scattering) {
        let rows = |need: &ScatteringNeed| need.n_rows();
        if rows(before) != rows(after) {
            let change = rows(after) as f64 / rows(before) as f64;
            lines.push(format!(
                "the scattering table has {} times the rows",
                brief(change)
            ));
        }
    }
    if lines.is_empty() {
        lines.push("the same stages and tables; the renderer alone does another work".to_string());
    }
    lines
}

impl Explanation {
    /// One line an effect.
    pub fn table(all: &[Self]) -> String {
        let mut table = String::new();
        for it in all {
            let state = if it.on { "on" } else { "off" };
            let bound = it
                .bound
                .map_or_else(|| "?".to_string(), |bound| bound.to_string());
            let _ = writeln!(
                table,
                "{:<21} {state:<4} {bound:<27} {}",
                it.effect, it.what
            );
            let _ = writeln!(table, "{:<54} {}", "", it.formula);
            let _ = writeln!(table, "{:<54} {}", "", it.source);
        }
        table
    }
}

/// How sure a kind of bound is.
fn meaning(kind: BoundKind) -> &'static str {
    match kind {
        BoundKind::Proved => "it follows from the equations that are rendered: never exceeded",
        BoundKind::Estimated => "it follows from a simpler model: may be exceeded",
        BoundKind::TableDifference => {
            "the difference of two coarse tables: may be exceeded a little"
        }
        BoundKind::Measured => "measured on a small picture of the scene",
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = if self.on { "on" } else { "off" };
        writeln!(out, "{}: {state}, {}", self.effect, self.reason)?;
        writeln!(out, "\nwhat it is\n  {}", self.what)?;
        writeln!(out, "\nits bound\n  {}", self.formula)?;
        if let Some(terms) = &self.terms {
            writeln!(out, "  largest where {terms}")?;
        }
        if let Some(bound) = &self.bound {
            writeln!(
                out,
                "  {bound} of display white, rms over the picture {}\n  {}: {}",
                brief(bound.rms),
                bound.kind.name(),
                meaning(bound.kind)
            )?;
        }
        let over = if self.on { "off" } else { "on" };
        writeln!(out, "\nswitching it {over}")?;
        if self.switching.is_empty() {
            writeln!(out, "  not possible here")?;
        }
        for line in &self.switching {
            writeln!(out, "  {line}")?;
        }
        writeln!(out, "\nsource\n  {}", self.source)
    }
}

impl fmt::Display for BoundTerms {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = self.theta_deg;
        write!(out, "theta = {low:.1} to {high:.1} degrees")?;
        if let Some((near_m, far_m)) = self.distance_m {
            write!(out, ", drops {} to {} away", length(near_m), length(far_m))?;
        }
        write!(out, ", tau = {}", brief(self.optical_depth))?;
        for (name, value) in [
            ("tau_s", self.sun_optical_depth),
            ("c", self.column),
            ("light", self.light),
            ("share", self.share),
        ] {
            if let Some(value) = value {
                write!(out, ", {name} = {}", brief(value))?;
            }
        }
        Ok(())
    }
}
