//! Which effects are simulated.
//!
//! What a scene says `on` or `off` stays so. Of the rest, the smallest bounds are left out first, as
//! long as the sum of all that are left out stays within half of the tolerance. The bounds of this
//! sum hold in whatever order effects are left out (see `bounds`), with the bows shaped by every
//! effect that may shape them. Where one of those is left out itself, the bows change a little, so
//! the sum is checked again with the final bounds, and the largest comes back until it fits.
//!
//! What costs nothing is on wherever it is seen at all: a table without that which makes bows smoother needs more angles.
//!
//! Light that drops scatter more than once is smooth, and its bound an estimate: the RMS of it counts. An effect
//! that is on brings those that it cannot do without.

use std::collections::BTreeSet;

use niji_render::SunPath;

use crate::accuracy::Accuracy;
use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_switches::EffectSwitches;
use crate::effect_switches::Switch;

use super::bound::Bound;
use super::bounds::Assumed;

/// Share of the tolerance that is for effects left out; the rest is for levels.
pub const SHARE_FOR_EFFECTS: f64 = 0.5;

/// The effects that are on.
pub(super) struct Decision {
    pub(super) on: BTreeSet<Effect>,
}

/// The switches of a scene, with light of further orders left out where it is not weighed, and wherever the scene
/// leaves out what it needs; without what its photograph holds, and without the shutter, of which sequences decide.
pub(super) fn settled(
    switches: &EffectSwitches,
    accuracy: &Accuracy,
    is_for_photograph: bool,
) -> EffectSwitches {
    let mut settled = switches.clone();
    for effect in Effect::ALL {
        let is_open = is_for_photograph && switches.of(effect) == Switch::Auto;
        if is_open && effect.is_in_photographs() {
            settled.set(effect, Switch::Off);
        }
    }
    let effect = Effect::MultipleScattering;
    if switches.of(effect) == Switch::Auto && !weighs_further_orders(switches, accuracy) {
        settled.set(effect, Switch::Off);
    }
    settled.set(Effect::MotionBlur, Switch::Off);
    settled
}

/// Whether light of further orders is on where it is seen.
pub(super) fn weighs_further_orders(switches: &EffectSwitches, accuracy: &Accuracy) -> bool {
    let effect = Effect::MultipleScattering;
    let mut needs = effect.needs().iter();
    switches.of(effect) == Switch::Auto
        && accuracy.sun_path != Some(SunPath::Ignore)
        && needs.all(|needed| switches.of(*needed) != Switch::Off)
}

/// Decides every effect; `bound` says what an effect may contribute.
pub(super) fn decide(
    switches: &EffectSwitches,
    tolerance: f64,
    bound: &dyn Fn(Effect, &Assumed) -> Bound,
) -> Decision {
    // The theory decides on the others.
    let is_switch = |effect: &Effect| !effect.comes_with_theory();
    let asked = |switch: Switch| {
        let effects = Effect::ALL.into_iter().filter(is_switch);
        effects.filter(move |effect| switches.of(*effect) == switch)
    };
    let mut on: BTreeSet<Effect> = asked(Switch::On).collect();
    on.extend(Effect::of_role(Role::Fixed));
    let open: Vec<Effect> = asked(Switch::Auto)
        .filter(|effect| !on.contains(effect))
        .collect();
    let shaping = open.iter().filter(|it| it.row().role == Role::Shape);
    let assumed = Assumed {
        may_be_on: on.iter().chain(&open).copied().collect(),
        is_on: on.iter().chain(shaping).copied().collect(),
    };
    let mut sized: Vec<(f64, Effect)> = open
        .into_iter()
        .map(|effect| (counted(effect, bound(effect, &assumed)), effect))
        .collect();
    let is_free = |(value, effect): &(f64, Effect)| effect.is_free() && *value > 0.0;
    on.extend(sized.extract_if(.., |it| is_free(it)).map(|(_, it)| it));
    sized.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let budget = SHARE_FOR_EFFECTS * tolerance;
    let mut sum = 0.0;
    let mut left_out = Vec::new();
    for (value, effect) in sized {
        sum += value;
        if sum > budget {
            on.insert(effect);
        } else {
            left_out.push(effect);
        }
    }
    drop_dependents(switches, &mut on);
    keep_to(budget, (&mut on, left_out), bound);
    let needed: Vec<Effect> = on
        .iter()
        .flat_map(|effect| effect.needs())
        .copied()
        .collect();
    on.extend(needed);
    Decision { on }
}

/// What of a bound counts against the tolerance.
pub(super) fn counted(effect: Effect, bound: Bound) -> f64 {
    match effect {
        Effect::MultipleScattering => bound.rms,
        _ => bound.value,
    }
}

/// What forcing `effect` on would add, with everything else as it is.
pub(super) fn forced(on: &BTreeSet<Effect>, effect: Effect) -> Assumed {
    let (mut may_be_on, mut is_on) = (on.clone(), on.clone());
    may_be_on.insert(effect);
    is_on.remove(&effect);
    Assumed { may_be_on, is_on }
}

/// Brings the largest effect back until the sum of the final bounds fits.
fn keep_to(
    budget: f64,
    (on, mut left_out): (&mut BTreeSet<Effect>, Vec<Effect>),
    bound: &dyn Fn(Effect, &Assumed) -> Bound,
) {
    loop {
        let value = |effect: Effect| counted(effect, bound(effect, &forced(on, effect)));
        let sized: Vec<f64> = left_out.iter().map(|effect| value(*effect)).collect();
        if sized.iter().sum::<f64>() <= budget {
            return;
        }
        let largest = (0..sized.len()).max_by(|a, b| sized[*a].total_cmp(&sized[*b]));
        let Some(largest) = largest else { return };
        on.insert(left_out.swap_remove(largest));
    }
}

/// Effects that have nothing to act on, once what they need was left out.
fn drop_dependents(switches: &EffectSwitches, on: &mut BTreeSet<Effect>) {
    if on.contains(&Effect::PrimaryBow) || on.contains(&Effect::SecondaryBow) {
        return;
    }
    on.retain(|effect| {
        let is_of_bows = [Role::Shape, Role::OfBows].contains(&effect.row().role);
        !is_of_bows || switches.of(*effect) != Switch::Auto
    });
}

#[cfg(test)]
mod tests {
    use super::super::bound::BoundKind;
    use super::*;

    fn decide_with(bounds: &[(Effect, f64)], switches: &EffectSwitches) -> BTreeSet<Effect> {
        let bound = |effect: Effect, _: &Assumed| {
            let default = f64::from(u8::from(effect != Effect::MultipleScattering));
            let value = bounds
                .iter()
                .find(|(of, _)| *of == effect)
                .map_or(default, |(_, value)| *value);
            Bound {
                value,
                rms: value,
                kind: BoundKind::Proved,
            }
        };
        decide(
            &settled(switches, &Accuracy::default(), false),
            0.01,
            &bound,
        )
        .on
    }

    #[test]
    fn the_sum_of_what_is_left_out_stays_within_half_of_the_tolerance() {
        let bounds = [
            (Effect::SunlightThroughAir, 0.002),
            (Effect::DropShadow, 0.0025),
            (Effect::DropExtinction, 0.003),
            (Effect::SecondaryBow, 0.0),
        ];
        let on = decide_with(&bounds, &EffectSwitches::default());
        // 0 + 0.002 + 0.0025 fit into 0.005; the next would not.
        for effect in [
            Effect::SunlightThroughAir,
            Effect::DropShadow,
            Effect::SecondaryBow,
        ] {
            assert!(!on.contains(&effect), "{effect}");
        }
        assert!(on.contains(&Effect::DropExtinction) && on.contains(&Effect::PrimaryBow));
    }

    #[test]
    fn what_makes_bows_smoother_is_never_left_out_to_save_time() {
        let bounds = [(Effect::SunDisc, 1e-4), (Effect::SizeSpread, 0.0)];
        let on = decide_with(&bounds, &EffectSwitches::default());
        assert!(on.contains(&Effect::SunDisc), "it is free");
        assert!(!on.contains(&Effect::SizeSpread), "it adds nothing");
        let no_bows = [(Effect::PrimaryBow, 0.0), (Effect::SecondaryBow, 0.0)];
        let on = decide_with(&no_bows, &EffectSwitches::default());
        assert!(!on.contains(&Effect::SunDisc));
    }

    #[test]
    fn what_is_not_asked_about_stays_as_it_was_said() {
        let mut switches = EffectSwitches::default();
        switches.set(Effect::SunDisc, Switch::On);
        switches.set(Effect::PrimaryBow, Switch::Off);
        let on = decide_with(
            &[(Effect::SunDisc, 0.0), (Effect::PrimaryBow, 9.0)],
            &switches,
        );
        assert!(on.contains(&Effect::SunDisc) && !on.contains(&Effect::PrimaryBow));
        assert!(on.contains(&Effect::Occluders), "surfaces always hide");
    }

    #[test]
    fn what_comes_with_the_theory_is_not_switched() {
        let on = decide_with(&[], &EffectSwitches::default());
        assert!(
            Effect::ALL
                .iter()
                .filter(|effect| ![Effect::MultipleScattering, Effect::MotionBlur].contains(effect))
                .all(|effect| effect.comes_with_theory() != on.contains(effect))
        );
    }

    #[test]
    fn light_of_further_orders_is_asked_about_where_its_needs_are_and_brings_them() {
        let multiple = Effect::MultipleScattering;
        let settled_of = |switches: &EffectSwitches, accuracy: &Accuracy| {
            settled(switches, accuracy, false).of(multiple)
        };
        let (free, standard) = (EffectSwitches::default(), Accuracy::default());
        assert_eq!(settled_of(&free, &standard), Switch::Auto);
        let mut without_shadow = free.clone();
        without_shadow.set(Effect::DropShadow, Switch::Off);
        assert_eq!(settled_of(&without_shadow, &standard), Switch::Off);
        let ignoring = Accuracy {
            sun_path: Some(SunPath::Ignore),
            ..standard
        };
        assert_eq!(settled_of(&free, &ignoring), Switch::Off);
        let mut switches = EffectSwitches::default();
        switches.set(multiple, Switch::On);
        let needs = multiple.needs().iter();
        let bounds: Vec<(Effect, f64)> = needs.map(|needed| (*needed, 0.0)).collect();
        let on = decide_with(&bounds, &switches);
        assert!(multiple.needs().iter().all(|needed| on.contains(needed)));
    }

    #[test]
    fn without_bows_nothing_shapes_them() {
        let bounds = [(Effect::PrimaryBow, 0.0), (Effect::SecondaryBow, 0.0)];
        let on = decide_with(&bounds, &EffectSwitches::default());
        assert!(!on.contains(&Effect::SunDisc) && !on.contains(&Effect::Supernumeraries));
    }
}
