//! What a scene wants of the effects.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::effect::Effect;

/// What a scene wants of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Switch {
    /// It is simulated.
    On,
    /// It is left out.
    Off,
    /// It is left out if the picture is the same within the tolerance.
    #[default]
    Auto,
}

/// The section `[effects]`: a switch for every effect, `auto` for those that are not listed.
///
/// ```
/// use niji_scene::{Effect, EffectSwitches, Switch};
///
/// let mut switches = EffectSwitches::default();
/// switches.set(Effect::DropShadow, Switch::Off);
/// assert_eq!(switches.of(Effect::DropShadow), Switch::Off);
/// assert_eq!(switches.of(Effect::SunDisc), Switch::Auto);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<Effect, Switch>", into = "BTreeMap<Effect, Switch>")]
pub struct EffectSwitches {
    by_effect: BTreeMap<Effect, Switch>,
}

impl EffectSwitches {
    /// The switch of an effect.
    pub fn of(&self, effect: Effect) -> Switch {
        self.by_effect.get(&effect).copied().unwrap_or_default()
    }

    /// Sets the switch of an effect.
    pub fn set(&mut self, effect: Effect, switch: Switch) {
        self.by_effect.insert(effect, switch);
    }
}

impl Default for EffectSwitches {
    fn default() -> Self {
        Self::from(BTreeMap::new())
    }
}

impl From<BTreeMap<Effect, Switch>> for EffectSwitches {
    /// Fills in `auto`, so that equal switches are equal however they were written.
    fn from(listed: BTreeMap<Effect, Switch>) -> Self {
        let switch = |effect| listed.get(&effect).copied().unwrap_or_default();
        Self {
            by_effect: Effect::ALL
                .into_iter()
                .map(|effect| (effect, switch(effect)))
                .collect(),
        }
    }
}

impl From<EffectSwitches> for BTreeMap<Effect, Switch> {
    fn from(switches: EffectSwitches) -> Self {
        switches.by_effect
    }
}
