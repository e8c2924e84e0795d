//! Everything that can be seen in a picture of a rainbow; what there is to say of each stands in its row
//! (`effect_rows.rs`).

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::effect_facts::Facts;
use crate::effect_rows::ROWS;
use crate::effect_rows::Row;

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
    /// Rings around the antisolar point, from drops of a few micrometres; the theories `by-size`, `mie`
    /// and `debye` have them.
    Glory,
    /// Rings around the sun, from drops of a few micrometres; the theories `by-size`, `mie` and `debye`
    /// have them.
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
    /// Surfaces with an albedo send light of sun and sky, and the ground has the shadow of drops and surfaces.
    LitSurfaces,
    /// Water that is seen mirrors drops and bow, sky, surfaces and sun.
    SeenWater,
    /// A frame of a sequence is the mean over the time its shutter is open; it takes a picture for each of some instants.
    MotionBlur,
}

/// What an effect is to the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Light of some orders of the drops: without any of them there is no table.
    Order,
    /// It shapes the light of the bows.
    Shape,
    /// It acts on the bows, and is nothing without them.
    OfBows,
    /// A part of the light of one drop that the theory of scattering has or lacks: no switch can leave
    /// it out of the exact light or put it into another theory.
    OfTheory,
    /// It adds to light on its way or takes from it.
    OnTheWay,
    /// Light of the air, which a photograph has already.
    AirLight,
    /// It is there whatever a scene wants.
    Fixed,
}

/// A section of the scene without which an effect does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Section {
    Air,
    WaterSurface,
    /// That of frames: a scene by itself has none.
    Shutter,
}

impl Section {
    /// It in a sentence.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Air => "an [air] section",
            Self::WaterSurface => "a [water_surface] section",
            Self::Shutter => "a shutter_deg in [sequence]",
        }
    }
}

impl Effect {
    /// Every effect, in the order in which plans list them.
    pub const ALL: [Self; ROWS.len()] = {
        let mut all = [Self::PrimaryBow; ROWS.len()];
        let mut index = 0;
        while index < all.len() {
            all[index] = ROWS[index].effect;
            index += 1;
        }
        all
    };

    /// All that is said of it.
    pub(crate) fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// The effects of a role.
    pub(crate) fn of_role(role: Role) -> impl Iterator<Item = Self> {
        Self::ALL
            .into_iter()
            .filter(move |effect| effect.row().role == role)
    }

    /// The key of the effect in the section `[effects]`.
    pub fn name(self) -> &'static str {
        self.row().name
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

    /// Whether a photograph holds this light already, or that which its own takes the place of.
    #[must_use]
    pub fn is_in_photographs(self) -> bool {
        self.row().role == Role::AirLight || self == Self::SkylitDrops
    }

    /// Whether bounds alone say what it would add where: small pictures do of light of further orders, and of a shutter.
    #[must_use]
    pub fn is_bounded_by_place(self) -> bool {
        ![Self::MultipleScattering, Self::MotionBlur].contains(&self)
    }

    /// Whether the theory of scattering has or lacks it, whatever a scene wants.
    pub fn comes_with_theory(self) -> bool {
        self.row().role == Role::OfTheory
    }

    /// Whether leaving it out saves nothing: what smooths a table, which takes more angles without, and shadows on the
    /// ground, of which bounds say too much to be worth the other levels' part of the error.
    pub(crate) fn is_free(self) -> bool {
        matches!(self, Self::SunDisc | Self::SizeSpread | Self::LitSurfaces)
    }

    /// What it cannot do without.
    pub fn needs(self) -> &'static [Self] {
        self.row().needs
    }

    /// Whether it exists only where there is air.
    pub fn needs_air(self) -> bool {
        self.row().section == Some(Section::Air)
    }

    /// What in the scene decides its size.
    pub(crate) fn fact(self, facts: &Facts) -> String {
        if self.needs_air() && !facts.has_air {
            return "the scene lies in a vacuum".to_string();
        }
        (self.row().fact)(facts)
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use niji_render::RenderEffects;
    use niji_render::Toggle;

    use super::*;

    #[test]
    fn every_effect_has_its_row_and_is_read_by_the_name_it_prints() {
        let mut sorted = Effect::ALL;
        sorted.sort_unstable();
        assert_eq!(sorted, Effect::ALL);
        assert_eq!(Effect::ALL.len(), Effect::MotionBlur as usize + 1);
        for effect in Effect::ALL {
            let quoted = serde_json::to_string(&effect).unwrap();
            assert_eq!(quoted, format!("\"{effect}\""));
        }
    }

    #[test]
    fn every_effect_has_a_text_a_formula_and_a_dated_source() {
        for effect in Effect::ALL {
            let row = effect.row();
            assert!(row.what.len() > 20 && !row.formula.is_empty(), "{effect}");
            let parts = row.source.split(['(', ')']);
            let mut years = parts.filter_map(|part| part.parse::<u32>().ok());
            assert!(years.any(|year| (1800..2030).contains(&year)), "{effect}");
        }
    }

    #[test]
    fn every_switch_of_the_renderer_belongs_to_an_effect() {
        let mut effects = RenderEffects::BOWS_ONLY;
        for toggle in Effect::ALL.into_iter().filter_map(|it| it.row().toggle) {
            *toggle(&mut effects) = Toggle::On;
        }
        assert_eq!(effects, RenderEffects::ALL);
    }
}
