//! Why an effect is on or off, in words.

use niji_scatter::Theory;

use crate::effect::Effect;
use crate::effect::Switch;

use super::bound::Bound;
use super::rings::ORDERS;

/// What reasons speak of.
pub(super) struct Facts {
    pub(super) has_air: bool,
    /// Are surfaces given that hide drops?
    pub(super) has_surfaces: bool,
    pub(super) sun_elevation_deg: f64,
    /// Scattering angles of rays that may meet drops, degrees.
    pub(super) theta_deg: Option<(f64, f64)>,
    /// Nearest and farthest drops in view, m.
    pub(super) distance_m: Option<(f64, f64)>,
    /// Largest optical depth of the drops in view and towards the sun, Q = 1.
    pub(super) depth: f64,
    pub(super) sun_depth: f64,
    /// Largest share of the sun's light that the air takes at any wavelength.
    pub(super) sunlight_lost: f64,
    pub(super) effective_variance: f64,
    pub(super) largest_radius_um: f64,
    pub(super) smallest_radius_um: f64,
    /// The theory of the table that is made.
    pub(super) theory: Theory,
    /// Largest share of the sun's light that water mirrors; `None` without water.
    pub(super) mirrored_share: Option<f64>,
}

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
    let fact = fact(effect, facts);
    match asked {
        Switch::On => format!("the scene asks for it; {fact}"),
        Switch::Off if ORDERS.contains(&effect) && facts.theory.holds_every_order() => {
            format!("the scene leaves it out, but exact light of drops is not without it; {fact}")
        }
        Switch::Off => format!("the scene leaves it out; {fact}"),
        Switch::Auto if is_on && effect == Effect::Occluders => fact,
        Switch::Auto if is_on => format!("kept; {fact}"),
        Switch::Auto if effect == Effect::MultipleScattering && !is_on => {
            format!("left out unless the scene or the preset reference asks for it; {fact}")
        }
        Switch::Auto if bound.value <= 0.0 => format!("adds nothing; {fact}"),
        Switch::Auto => format!("too small to be seen; {fact}"),
    }
}

/// The reason for an effect that a theory has or lacks.
fn reason_of_theory(decided: &Decided, facts: &Facts) -> String {
    let Decided {
        effect,
        asked,
        is_on,
        bound,
    } = *decided;
    let (fact, theory) = (fact(effect, facts), facts.theory.name());
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

/// What in the scene decides the size of an effect.
fn fact(effect: Effect, facts: &Facts) -> String {
    if effect.needs_air() && !facts.has_air {
        return "the scene lies in a vacuum".to_string();
    }
    match effect {
        Effect::PrimaryBow => view_of(facts, "the bow itself stands near 138 degrees"),
        Effect::SecondaryBow => view_of(facts, "the bow itself stands near 129 degrees"),
        Effect::HigherOrders => view_of(
            facts,
            "light reflected outside the drops at all angles, light through them below 83, weak bows",
        ),
        Effect::Supernumeraries | Effect::SizeSpread => format!(
            "effective radius {} to {} um, effective variance up to {}",
            brief(facts.smallest_radius_um),
            brief(facts.largest_radius_um),
            brief(facts.effective_variance)
        ),
        Effect::Glory => view_of(
            facts,
            "rings within 15 degrees of 180, of drops below 60 um",
        ),
        Effect::Corona => view_of(facts, "rings within 15 degrees of 0"),
        Effect::SunDisc => "the sun is 0.533 degrees wide".to_string(),
        Effect::DropFlattening => format!(
            "effective diameters up to {} mm; the top of the bow of 1 mm moves by 2 degrees",
            brief(2e-3 * facts.largest_radius_um)
        ),
        Effect::DropExtinction => {
            format!(
                "optical depth of the drops in view up to {}",
                brief(facts.depth)
            )
        }
        Effect::DropShadow => {
            format!(
                "optical depth of the drops towards the sun up to {}",
                brief(facts.sun_depth)
            )
        }
        Effect::SkylitDrops if !facts.has_air => "there is no sky in a vacuum".to_string(),
        Effect::SkylitDrops | Effect::MultipleScattering => {
            format!("optical depth of the drops up to {}", brief(facts.depth))
        }
        Effect::ReflectionBow => match facts.mirrored_share {
            Some(share) => format!(
                "water mirrors up to {} % of sunlight with the sun at {} degrees",
                brief(100.0 * share),
                brief(facts.sun_elevation_deg)
            ),
            None => "there is no [water_surface]".to_string(),
        },
        Effect::SunlightThroughAir => format!(
            "with the sun at {} degrees the air takes up to {} % of a wavelength, however near the \
             drops are",
            brief(facts.sun_elevation_deg),
            brief(100.0 * facts.sunlight_lost)
        ),
        Effect::AirExtinction | Effect::AirInscatter => match facts.distance_m {
            Some((near_m, far_m)) => {
                format!(
                    "the drops in view lie {} to {} away",
                    length(near_m),
                    length(far_m)
                )
            }
            None => "no drops are in view".to_string(),
        },
        Effect::Sky => "air and ground behind the drops".to_string(),
        Effect::Occluders if facts.has_surfaces => {
            "surfaces always hide what is behind them".to_string()
        }
        Effect::Occluders => "surfaces always hide what is behind them; none is given".to_string(),
    }
}

fn view_of(facts: &Facts, where_it_stands: &str) -> String {
    match facts.theta_deg {
        Some((low, high)) => format!(
            "rays through the drops scatter by {low:.0} to {high:.0} degrees; {where_it_stands}"
        ),
        None => "no drops are in view".to_string(),
    }
}

/// A length in metres or kilometres.
pub(super) fn length(length_m: f64) -> String {
    if length_m >= 1000.0 {
        format!("{} km", brief(length_m / 1000.0))
    } else {
        format!("{} m", brief(length_m))
    }
}

/// About two significant digits.
pub(super) fn brief(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        // A stored zero: nothing was computed.
        "0".to_string()
    } else if size >= 100.0 {
        format!("{value:.0}")
    } else if size >= 10.0 {
        format!("{value:.1}").trim_end_matches(".0").to_string()
    } else if size >= 0.01 {
        let text = format!("{value:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{value:.1e}")
    }
}
