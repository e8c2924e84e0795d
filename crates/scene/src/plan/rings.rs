//! Which tables hold glory and corona: the light around the antisolar point and the sun that only exact
//! theories have.

use std::collections::BTreeSet;

use niji_scatter::Theory;

use crate::effect::Effect;
use crate::effect::Role;

/// The rings that a table of a theory holds when these effects are on.
pub(super) fn held(theory: Theory, on: &BTreeSet<Effect>) -> Vec<Effect> {
    // Without fringes a table is made of rays.
    if !theory.is_exact() || !on.contains(&Effect::Supernumeraries) {
        return Vec::new();
    }
    // All orders are there, but no table is made for none of them.
    let whole =
        theory.holds_every_order() && Effect::of_role(Role::Order).any(|it| on.contains(&it));
    let rings = [
        (Effect::Glory, Effect::PrimaryBow),
        (Effect::Corona, Effect::HigherOrders),
    ];
    let held = rings.into_iter();
    held.filter(|(_, carrier)| whole || on.contains(carrier))
        .map(|(ring, _)| ring)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_exact_theories_hold_rings() {
        let all: BTreeSet<Effect> = Effect::ALL.into_iter().collect();
        for theory in [Theory::Mie, Theory::BySize] {
            assert_eq!(held(theory, &all), [Effect::Glory, Effect::Corona]);
        }
        let debye = Theory::Debye { max_order: 7 };
        let mut less = all.clone();
        less.remove(&Effect::HigherOrders);
        assert_eq!(held(debye, &less), [Effect::Glory]);
        less.remove(&Effect::PrimaryBow);
        assert_eq!(held(Theory::Mie, &less), [Effect::Glory, Effect::Corona]);
        less.remove(&Effect::SecondaryBow);
        assert!(held(Theory::Mie, &less).is_empty());
        less = all.clone();
        less.remove(&Effect::Supernumeraries);
        assert!(held(debye, &less).is_empty() && held(Theory::Mie, &less).is_empty());
        assert!(held(Theory::Uniform, &all).is_empty());
    }
}
