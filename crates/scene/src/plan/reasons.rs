//! Why an effect is on or off, in words.

use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_facts::Facts;
use crate::effect_switches::Switch;

use super::bound::Bound;

/// What was decided of an effect.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decided {
    pub(super) effect: Effect,
    /// What the scene asks.
    pub(super) asked: Switch,
    pub(super) is_on: bool,
    /// What it contributes at most.
    pub(super) bound: Bound,
}

/// The reason for a decision.
pub(super) fn reason(decided: &Decided, facts: &Facts) -> String {
    let Decided {
        effect,
        asked,
        is_on,
        bound,
    } = *decided;
    if effect.comes_with_theory() {
        return reason_of_theory(decided, facts);
    }
    let fact = effect.fact(facts);
    match asked {
        Switch::Off if effect.row().role == Role::Order && facts.theory.holds_every_order() => {
            format!("the scene leaves it out, but exact light of drops is not without it; {fact}")
        }
        Switch::Auto if is_on && effect == Effect::Occluders => fact,
        Switch::Auto if !is_on && facts.is_for_photograph && effect.is_in_photographs() => {
            format!("the photograph has light of its own for it; {fact}")
        }
        Switch::Auto
            if effect == Effect::MultipleScattering
                && !(is_on || bound.value <= 0.0 || facts.weighs_further_orders) =>
        {
            format!("not without drop extinction, drop shadow and their sun path; {fact}")
        }
        Switch::On | Switch::Off | Switch::Auto => of_switch(decided, &fact),
    }
}

/// The reason that follows from what a scene asks and from the bound, with a fact.
pub(super) fn of_switch(decided: &Decided, fact: &str) -> String {
    let why = match decided.asked {
        Switch::On if !decided.is_on => "the scene asks for what it cannot have",
        Switch::On => "the scene asks for it",
        Switch::Off => "the scene leaves it out",
        Switch::Auto if decided.is_on => "kept",
        Switch::Auto if decided.bound.value <= 0.0 => "adds nothing",
        Switch::Auto => "too small to be seen",
    };
    format!("{why}; {fact}")
}

/// The reason for an effect that a theory has or lacks.
fn reason_of_theory(decided: &Decided, facts: &Facts) -> String {
    let Decided {
        effect,
        asked,
        is_on,
        bound,
    } = *decided;
    let (fact, theory) = (effect.fact(facts), facts.theory.name());
    let is_seen = bound.value > 0.0;
    match asked {
        Switch::Off if is_on => {
            format!("the scene leaves it out, but the theory {theory} is not without it; {fact}")
        }
        Switch::On | Switch::Auto | Switch::Off if is_on => {
            format!("the theory {theory} has it; {fact}")
        }
        Switch::Off => format!("the scene leaves it out; {fact}"),
        Switch::On | Switch::Auto if is_seen => {
            format!("not simulated: the theory {theory} lacks it, mie and debye have it; {fact}")
        }
        Switch::On | Switch::Auto => format!("adds nothing; {fact}"),
    }
}
