//! The lines at the end of a run: what it took, what it leaves out, and how accurate the picture is.

use niji_picture::PlannedScene;
use niji_scene::Effect;
use niji_scene::EffectDecision;
use niji_scene::Plan;
use niji_scene::Switch;

use crate::run::budget::Budget;
use crate::stages::Done;
use crate::stages::accuracy::Reached;
use crate::stages::accuracy::of_white;
use crate::stages::seconds_of;

/// What is switched off although it is seen: the scene says so, or cannot do without, so that the verdict does not count
/// it.
const LEFT_OUT: &str = "left out beside the error told here";

/// Shorter times to decide how a picture is made are not told (s).
const INSTANT_S: f64 = 0.05;

/// The times of the plan and of stages after an empty line, the effects that are left out, and the verdict.
pub(super) fn text(
    plan: &Plan,
    (done, reached): (&[Done], Option<&Reached>),
    (decided_s, budget): (f64, Option<&Budget>),
) -> String {
    let mut lines = vec![String::new()];
    if decided_s >= INSTANT_S {
        lines.push(format!("{:>11} {decided_s:>7.2} s", "plan"));
    }
    for stage in done {
        let note = if stage.up_to_date { "  up to date" } else { "" };
        lines.push(format!(
            "{:>11} {:>7.2} s{note}",
            stage.stage, stage.seconds
        ));
    }
    lines.extend(left_out(plan));
    let seconds = decided_s + seconds_of(done);
    lines.extend(reached.map(|reached| match budget {
        Some(budget) => format!("{}; {}", reached.text_of_error(), budget.text(done)),
        None => format!("{}; {seconds:.1} s", reached.text()),
    }));
    lines.join("\n")
}

/// What a camera would show otherwise, where nobody said how bright the picture is shown and it is off by about a stop
/// at least. A photograph has its own exposure.
pub(super) fn exposure(planned: &PlannedScene, done: &[Done]) -> Option<String> {
    let stops = done.iter().find_map(|it| it.usual_stops)?;
    let usual_ev = (2.0 * stops).round() / 2.0;
    if planned.scene.photo.is_some() || usual_ev.abs() < 1.0 {
        return None;
    }
    let looks = if usual_ev > 0.0 { "dark" } else { "bright" };
    Some(format!(
        "{looks}: a camera would show it with about picture.exposure_ev = {usual_ev:.1}"
    ))
}

/// The effects that are off although they may be seen, a line for light that drops scatter more than
/// once and one for all others.
pub(super) fn left_out(plan: &Plan) -> Vec<String> {
    let (orders, others): (Vec<_>, Vec<_>) = plan
        .missed()
        .partition(|it| it.effect == Effect::MultipleScattering);
    let mut lines: Vec<String> = orders.iter().map(|it| further_orders(plan, it)).collect();
    let others = others.iter();
    let others = others.map(|it| format!("{} {}", it.effect, of_white(it.bound.value)));
    let others: Vec<String> = others.collect();
    if !others.is_empty() {
        let others = others.join(", ");
        lines.push(format!("{LEFT_OUT} (at most, of display white): {others}"));
    }
    lines
}

fn further_orders(plan: &Plan, decision: &EffectDecision) -> String {
    let is_refused = |it: &&EffectDecision| {
        it.asked == Switch::Off && decision.effect.needs().contains(&it.effect)
    };
    let off = plan.effects.iter().filter(is_refused).chain([decision]);
    let keys: Vec<String> = off
        .map(|it| format!("effects.{} = \"on\"", it.effect))
        .collect();
    format!(
        "{LEFT_OUT}: light that drops scatter more than once (RMS up to about {} of display white); {} {} it",
        of_white(decision.bound.rms),
        keys.join(", "),
        if keys.len() > 1 { "add" } else { "adds" }
    )
}
