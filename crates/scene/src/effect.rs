//! Everything that can be seen in a picture of a rainbow, as switches of a scene.

use std::collections::BTreeMap;
use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// Something that light does between the sun, drops, air and eye.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Light reflected once inside a drop (p = 2).
    PrimaryBow,
    /// Light reflected twice inside a drop (p = 3).
    SecondaryBow,
    /// External reflection (p = 0), light straight through (p = 1) and three to six internal
    /// reflections (p = 4 to 7): the light between, inside and around the bows.
    HigherOrders,
    /// Interference fringes inside the primary and outside the secondary.
    Supernumeraries,
    /// Rings around the antisolar point, from drops of a few micrometres; the theories `mie` and
    /// `debye` have them.
    Glory,
    /// Rings around the sun, from drops of a few micrometres; the theories `mie` and `debye` have
    /// them.
    Corona,
    /// The sun is a disc of 0.533 degrees, not a point.
    SunDisc,
    /// Drops of one place differ in size.
    SizeSpread,
    /// Large drops are flat, which moves the bow by an angle that changes along it.
    DropFlattening,
    /// Drops on the view path take light away.
    DropExtinction,
    /// Drops on the sun's path take light away.
    DropShadow,
    /// Drops scatter the light of sky and ground into the view.
    SkylitDrops,
    /// Light scattered by two or more drops. It needs a table of all angles and paths through the
    /// drops, so that `auto` leaves it out but for the preset `reference`.
    MultipleScattering,
    /// Water mirrors the sun: drops send the light of a second sun, below the horizon.
    ReflectionBow,
    /// The air dims and reddens sunlight before it reaches the drops.
    SunlightThroughAir,
    /// The air between drops and eye takes light away.
    AirExtinction,
    /// The air from the eye to the far side of the drops scatters sunlight into the view.
    AirInscatter,
    /// Air and ground behind the drops.
    Sky,
    /// Surfaces in front of the drops hide them.
    Occluders,
}

impl Effect {
    /// Every effect, in the order in which plans list them.
    pub const ALL: [Self; 19] = [
        Self::PrimaryBow,
        Self::SecondaryBow,
        Self::HigherOrders,
        Self::Supernumeraries,
        Self::Glory,
        Self::Corona,
        Self::SunDisc,
        Self::SizeSpread,
        Self::DropFlattening,
        Self::DropExtinction,
        Self::DropShadow,
        Self::SkylitDrops,
        Self::MultipleScattering,
        Self::ReflectionBow,
        Self::SunlightThroughAir,
        Self::AirExtinction,
        Self::AirInscatter,
        Self::Sky,
        Self::Occluders,
    ];

    /// The key of the effect in the section `[effects]`.
    pub fn name(self) -> &'static str {
        match self {
            Self::PrimaryBow => "primary_bow",
            Self::SecondaryBow => "secondary_bow",
            Self::HigherOrders => "higher_orders",
            Self::Supernumeraries => "supernumeraries",
            Self::Glory => "glory",
            Self::Corona => "corona",
            Self::SunDisc => "sun_disc",
            Self::SizeSpread => "size_spread",
            Self::DropFlattening => "drop_flattening",
            Self::DropExtinction => "drop_extinction",
            Self::DropShadow => "drop_shadow",
            Self::SkylitDrops => "skylit_drops",
            Self::MultipleScattering => "multiple_scattering",
            Self::ReflectionBow => "reflection_bow",
            Self::SunlightThroughAir => "sunlight_through_air",
            Self::AirExtinction => "air_extinction",
            Self::AirInscatter => "air_inscatter",
            Self::Sky => "sky",
            Self::Occluders => "occluders",
        }
    }

    /// The effect of a key.
    ///
    /// # Errors
    /// For a name that is none, the effects that it may stand for.
    pub fn from_name(name: &str) -> Result<Self, String> {
        if let Some(effect) = Self::ALL.into_iter().find(|effect| effect.name() == name) {
            return Ok(effect);
        }
        let mut names = Self::ALL.map(Self::name);
        let likeness = |known: &str| strsim::normalized_damerau_levenshtein(name, known);
        names.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
        Err(format!(
            "found the effect {name:?}, expected one of {}; the likest first",
            names.join(", ")
        ))
    }

    /// Whether it is a part of the light of one drop that the theory of scattering has or lacks: no
    /// switch can leave it out of the exact light or put it into another theory.
    pub fn comes_with_theory(self) -> bool {
        match self {
            Self::Glory | Self::Corona => true,
            Self::PrimaryBow
            | Self::SecondaryBow
            | Self::HigherOrders
            | Self::Supernumeraries
            | Self::SunDisc
            | Self::SizeSpread
            | Self::DropFlattening
            | Self::DropExtinction
            | Self::DropShadow
            | Self::SkylitDrops
            | Self::MultipleScattering
            | Self::ReflectionBow
            | Self::SunlightThroughAir
            | Self::AirExtinction
            | Self::AirInscatter
            | Self::Sky
            | Self::Occluders => false,
        }
    }

    /// What it cannot do without: light of further orders is all that extinction takes, scattered by
    /// drops in their own shade into all directions.
    pub fn needs(self) -> &'static [Self] {
        match self {
            Self::MultipleScattering => &[
                Self::PrimaryBow,
                Self::SecondaryBow,
                Self::HigherOrders,
                Self::DropExtinction,
                Self::DropShadow,
            ],
            Self::PrimaryBow
            | Self::SecondaryBow
            | Self::HigherOrders
            | Self::Supernumeraries
            | Self::Glory
            | Self::Corona
            | Self::SunDisc
            | Self::SizeSpread
            | Self::DropFlattening
            | Self::DropExtinction
            | Self::DropShadow
            | Self::SkylitDrops
            | Self::ReflectionBow
            | Self::SunlightThroughAir
            | Self::AirExtinction
            | Self::AirInscatter
            | Self::Sky
            | Self::Occluders => &[],
        }
    }

    /// Whether it exists only where there is air.
    pub fn needs_air(self) -> bool {
        match self {
            Self::SunlightThroughAir | Self::AirExtinction | Self::AirInscatter | Self::Sky => true,
            Self::PrimaryBow
            | Self::SecondaryBow
            | Self::HigherOrders
            | Self::Supernumeraries
            | Self::Glory
            | Self::Corona
            | Self::SunDisc
            | Self::SizeSpread
            | Self::DropFlattening
            | Self::DropExtinction
            | Self::DropShadow
            | Self::SkylitDrops
            | Self::MultipleScattering
            | Self::ReflectionBow
            | Self::Occluders => false,
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_read_by_the_name_it_prints() {
        for effect in Effect::ALL {
            let quoted = serde_json::to_string(&effect).unwrap();
            assert_eq!(quoted, format!("\"{effect}\""));
        }
    }

    #[test]
    fn the_list_of_all_effects_is_complete_and_in_order() {
        let mut sorted = Effect::ALL;
        sorted.sort_unstable();
        assert_eq!(sorted, Effect::ALL);
        let last = Effect::Occluders as usize;
        assert_eq!(Effect::ALL.len(), last + 1);
    }
}
