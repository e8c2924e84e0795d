//! Everything that can be seen in a picture of a rainbow, one row each: what it is, how its bound is made,
//! where it is published, and what it has to do with other effects and with the renderer.
//!
//! Symbols of the formulas: P(theta) light that a unit of optical depth adds, over display white;
//! tau optical depth of the drops on a view ray (Q = 1), tau_s towards the sun; q efficiency of
//! extinction, 1 or 2; c = (1 - exp(-q tau))/q the column that is seen, tau itself where extinction may
//! be off; Q_l, S_l, ... sums over wavelengths l weighted by the eye.

use std::fmt;

use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::Toggle;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::effect_facts::Facts;
use crate::figures::brief;

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

/// What there is to say of an effect.
pub(crate) struct Row {
    effect: Effect,
    name: &'static str,
    /// What it is physically.
    pub(crate) what: &'static str,
    /// Its bound as a formula.
    pub(crate) formula: &'static str,
    /// Where it is published.
    pub(crate) source: &'static str,
    pub(crate) role: Role,
    /// What it cannot do without.
    needs: &'static [Effect],
    pub(crate) section: Option<Section>,
    /// What switches it in the renderer; `None` for what tables hold.
    pub(crate) toggle: Option<fn(&mut RenderEffects) -> &mut Toggle>,
    /// The layer of the picture that its light has to itself.
    pub(crate) layer: Option<PictureLayer>,
    /// What in the scene decides its size.
    fact: fn(&Facts) -> String,
}

/// What a row does not say.
const PLAIN: Row = Row {
    effect: Effect::Occluders,
    name: "",
    what: "",
    formula: "",
    source: "",
    role: Role::OnTheWay,
    needs: &[],
    section: None,
    toggle: None,
    layer: None,
    fact: |_| String::new(),
};

/// Every effect, in the order in which plans list them.
static ROWS: [Row; 22] = [
    Row {
        effect: Effect::PrimaryBow,
        name: "primary_bow",
        what: "light reflected once inside the drops (p = 2): the bow near 138 degrees from the sun and \
               the brightness inside it",
        formula: "max P_2(theta) c; P_2 from the theory of the table",
        source: "Nussenzveig, J. Math. Phys. 10, 82-124 (1969); Airy, Trans. Camb. Phil. Soc. 6, 379-403 \
               (1838)",
        role: Role::Order,
        toggle: Some(|it| &mut it.primary_bow),
        fact: |facts| facts.angles("the bow itself stands near 138 degrees"),
        ..PLAIN
    },
    Row {
        effect: Effect::SecondaryBow,
        name: "secondary_bow",
        what: "light reflected twice inside the drops (p = 3): the bow near 129 degrees from the sun and \
               the brightness outside it",
        formula: "max P_3(theta) c; P_3 from the theory of the table",
        source: "Nussenzveig, J. Math. Phys. 10, 82-124 (1969)",
        role: Role::Order,
        toggle: Some(|it| &mut it.secondary_bow),
        fact: |facts| facts.angles("the bow itself stands near 129 degrees"),
        ..PLAIN
    },
    Row {
        effect: Effect::HigherOrders,
        name: "higher_orders",
        what: "light reflected outside the drops (p = 0), gone straight through (p = 1), and reflected \
               three to six times inside (p = 4 to 7): it fills Alexander's band",
        formula: "max P_other(theta) c; rays of each order",
        source: "van de Hulst, Light Scattering by Small Particles, Wiley (1957), chapter 12",
        role: Role::Order,
        toggle: Some(|it| &mut it.higher_orders),
        fact: |facts| {
            facts.angles(
                "light reflected outside the drops at all angles, light through them below 83, weak bows",
            )
        },
        ..PLAIN
    },
    Row {
        effect: Effect::Supernumeraries,
        name: "supernumeraries",
        what: "interference of the two rays that leave a drop at one angle: fringes inside the primary \
               and outside the secondary, and the finite height of the bow itself",
        formula: "max |P_waves(theta) - P_rays(theta)| c",
        source: "Young, Phil. Trans. R. Soc. 94, 1-16 (1804); Airy, Trans. Camb. Phil. Soc. 6, 379-403 \
               (1838)",
        role: Role::Shape,
        fact: Facts::sizes,
        ..PLAIN
    },
    Row {
        effect: Effect::Glory,
        name: "glory",
        what: "colored rings around the antisolar point, from edge rays and surface waves of small drops; \
               exact theories have it, and theory by size, where drops are small; theories of bows do not",
        formula: "max |P_exact(theta) - P_orders(theta)| c beyond 165 degrees",
        source: "Laven, Appl. Opt. 44, 5675-5683 (2005)",
        role: Role::OfTheory,
        fact: |facts| facts.angles("rings within 15 degrees of 180, of drops below 60 um"),
        ..PLAIN
    },
    Row {
        effect: Effect::Corona,
        name: "corona",
        what: "diffraction around the drops: rings around the sun; exact theories and theory by size \
               have it, theories of bows leave it out",
        formula: "max P_d(theta) c within 15 degrees of the sun, P_d = (pi/0.18) (x^2/4pi)/(1 + (pi/4) u^3), \
               u = x theta, x = 2 pi r/lambda",
        source: "Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983), \
               eq. 4.73",
        role: Role::OfTheory,
        fact: |facts| facts.angles("rings within 15 degrees of 0"),
        ..PLAIN
    },
    Row {
        effect: Effect::SunDisc,
        name: "sun_disc",
        what: "the sun is a disc of 0.533 degrees: bows of rays from all of it overlap",
        formula: "max |P_disc(theta) - P_point(theta)| c",
        source: "Lee, Appl. Opt. 37, 1506-1519 (1998)",
        role: Role::Shape,
        fact: |_| "the sun is 0.533 degrees wide".to_string(),
        ..PLAIN
    },
    Row {
        effect: Effect::SizeSpread,
        name: "size_spread",
        what: "drops of one place differ in size: their fringes blur",
        formula: "max |P_law(theta) - P_one size(theta)| c",
        source: "Hansen and Travis, Space Sci. Rev. 16, 527-610 (1974)",
        role: Role::Shape,
        fact: Facts::sizes,
        ..PLAIN
    },
    Row {
        effect: Effect::DropFlattening,
        name: "drop_flattening",
        what: "air resistance flattens large drops: the bow of each moves by an angle that depends on \
               size and direction",
        formula: "max |P_flat(theta) - P_round(theta)| c over the directions that are seen",
        source: "Moebius, Ann. Phys. 338, 1493-1558 (1910); Beard and Chuang, J. Atmos. Sci. 44, 1509-1524 \
               (1987)",
        role: Role::OfBows,
        fact: |facts| {
            format!(
                "effective diameters up to {} mm; the top of the bow of 1 mm moves by 2 degrees",
                brief(2e-3 * facts.largest_radius_um)
            )
        },
        ..PLAIN
    },
    Row {
        effect: Effect::DropExtinction,
        name: "drop_extinction",
        what: "drops in front take light from those behind them and from what shines through",
        formula: "max of P (tau - c) + L_behind (1 - exp(-q tau)) and, of skylit drops, L_around (1 - \
               exp(-tau))",
        source: "van de Hulst, Light Scattering by Small Particles, Wiley (1957), section 1.4",
        toggle: Some(|it| &mut it.drop_extinction),
        fact: |facts| facts.depth_of("the drops in view"),
        ..PLAIN
    },
    Row {
        effect: Effect::DropShadow,
        name: "drop_shadow",
        what: "drops nearer to the sun shade those behind them",
        formula: "(1 - exp(-q tau_s)) max P(theta) c",
        source: "van de Hulst, Light Scattering by Small Particles, Wiley (1957), section 1.4",
        toggle: Some(|it| &mut it.drop_shadow),
        fact: |facts| {
            format!(
                "optical depth of the drops towards the sun up to {}",
                brief(facts.sun_depth)
            )
        },
        ..PLAIN
    },
    Row {
        effect: Effect::SkylitDrops,
        name: "skylit_drops",
        what: "drops scatter light of sky and ground into the view, as much as they take from it",
        formula: "L_around max (1 - exp(-tau)); L_around the mean of air and ground in all directions",
        source: "Chandrasekhar, Radiative Transfer, Oxford (1950), section 2",
        toggle: Some(|it| &mut it.skylit_drops),
        layer: Some(PictureLayer::Skylit),
        fact: |facts| {
            if facts.has_air {
                facts.depth_of("the drops")
            } else {
                "there is no sky in a vacuum".to_string()
            }
        },
        ..PLAIN
    },
    Row {
        effect: Effect::MultipleScattering,
        name: "multiple_scattering",
        what: "light that two or more drops scattered: it fills shadows and the dark band",
        formula: "(1 - exp(-tau_s/2)) (1 - exp(-tau)) (1 - g exp(-(1 - g) tau)) E/(4 pi), g = 0.74: what half \
               of the drops take, even but for what goes on forward",
        source: "van de Hulst, Multiple Light Scattering, Academic Press (1980), section 14.1",
        // Light of further orders is all that extinction takes, scattered by drops in their own shade into all
        // directions.
        needs: &[
            Effect::PrimaryBow,
            Effect::SecondaryBow,
            Effect::HigherOrders,
            Effect::DropExtinction,
            Effect::DropShadow,
        ],
        layer: Some(PictureLayer::BowMultiple),
        fact: |facts| facts.depth_of("the drops"),
        ..PLAIN
    },
    Row {
        effect: Effect::ReflectionBow,
        name: "reflection_bow",
        what: "water mirrors the sun: a second sun below the horizon makes a second bow, whose center is as \
               high as the sun and which meets the bow of the sun at the horizon",
        formula: "R_s max P(theta') c; theta' from the sun in the water, R_s its reflectance of light polarized \
               along it",
        source: "Born and Wolf, Principles of Optics, Cambridge (1999), section 1.5.2; Cox and Munk, J. Opt. \
               Soc. Am. 44, 838-850 (1954)",
        role: Role::OfBows,
        section: Some(Section::WaterSurface),
        layer: Some(PictureLayer::BowReflected),
        fact: |facts| match facts.mirrored_share {
            Some(share) => format!(
                "water mirrors up to {} % of sunlight with the sun at {} degrees",
                brief(100.0 * share),
                brief(facts.sun_elevation_deg)
            ),
            None => "there is no [water_surface]".to_string(),
        },
        ..PLAIN
    },
    Row {
        effect: Effect::SunlightThroughAir,
        name: "sunlight_through_air",
        what: "the air between the sun and the drops dims and reddens sunlight; how near the drops are \
               does not shorten that way",
        formula: "max P_l(theta) (1 - exp(-tau_air,l)) c, summed over wavelengths l",
        source: "Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999)",
        section: Some(Section::Air),
        toggle: Some(|it| &mut it.sunlight_through_air),
        fact: |facts| {
            format!(
                "with the sun at {} degrees the air takes up to {} % of a wavelength, however near the \
                 drops are",
                brief(facts.sun_elevation_deg),
                brief(100.0 * facts.sunlight_lost)
            )
        },
        ..PLAIN
    },
    Row {
        effect: Effect::AirExtinction,
        name: "air_extinction",
        what: "the air between the drops and the eye takes light of the bow",
        formula: "max P_l(theta) (1 - exp(-beta_l s)) c, summed over wavelengths l; beta_l the largest \
               extinction of the air there, s the farthest drops in view",
        source: "Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999)",
        section: Some(Section::Air),
        toggle: Some(|it| &mut it.air_extinction),
        fact: Facts::distances,
        ..PLAIN
    },
    Row {
        effect: Effect::AirInscatter,
        name: "air_inscatter",
        what: "the air between the eye and the far side of the drops scatters sunlight into the view",
        formula: "max L_air(0..s), solved at the corners and in the middle of every part of the picture",
        source: "Nishita, Sirai, Tadamura and Nakamae, Proc. SIGGRAPH 93, 175-182 (1993)",
        role: Role::AirLight,
        section: Some(Section::Air),
        toggle: Some(|it| &mut it.air_inscatter),
        fact: Facts::distances,
        ..PLAIN
    },
    Row {
        effect: Effect::Sky,
        name: "sky",
        what: "air and ground behind the drops",
        formula: "max L_air(0..end), solved at the corners and in the middle of every part of the picture",
        source: "Nishita, Sirai, Tadamura and Nakamae, Proc. SIGGRAPH 93, 175-182 (1993)",
        role: Role::AirLight,
        section: Some(Section::Air),
        toggle: Some(|it| &mut it.sky),
        layer: Some(PictureLayer::Sky),
        fact: |_| "air and ground behind the drops".to_string(),
        ..PLAIN
    },
    Row {
        effect: Effect::Occluders,
        name: "occluders",
        what: "surfaces in front of the drops hide them; they are never left out",
        formula: "0: nothing is decided",
        source: "Porter and Duff, Computer Graphics 18, 253-259 (1984)",
        role: Role::Fixed,
        fact: |facts| {
            let none = if facts.has_surfaces {
                ""
            } else {
                "; none is given"
            };
            format!("surfaces always hide what is behind them{none}")
        },
        ..PLAIN
    },
    Row {
        effect: Effect::LitSurfaces,
        name: "lit_surfaces",
        what: "surfaces with an albedo send light of sun and sky, and they, terrain and drops shade each other and \
               the ground; what surfaces take of the sky is an estimate, what they send each other is told as error",
        formula: "1.2 A E/pi; A the largest albedo",
        source: "Lambert, Photometria, Augsburg (1760); Ramamoorthi and Hanrahan, J. Opt. Soc. Am. A 18, 2448-2459 \
               (2001)",
        toggle: Some(|it| &mut it.lit_surfaces),
        layer: Some(PictureLayer::LitSurface),
        fact: |facts| match facts.n_lit {
            0 => "no surface has an albedo".to_string(),
            1 => "one surface has an albedo".to_string(),
            n => format!("{n} surfaces have an albedo"),
        },
        ..PLAIN
    },
    Row {
        effect: Effect::SeenWater,
        name: "seen_water",
        what: "water that is seen mirrors drops and bow by their polarization, sky, surfaces and sun; waves blur them, and \
               make glitter of the sun",
        formula: "1.2 E/pi where a ray may meet the water: as bright as white in sun and sky",
        source: "Born and Wolf, Principles of Optics, Cambridge (1999), section 1.5.2; Cox and Munk, J. Opt. Soc. Am. 44, \
                 838-850 (1954)",
        section: Some(Section::WaterSurface),
        layer: Some(PictureLayer::Water),
        fact: |facts| {
            let met = if facts.sees_water {
                "rays meet"
            } else {
                "no ray meets"
            };
            format!("{met} the water")
        },
        ..PLAIN
    },
    Row {
        effect: Effect::MotionBlur,
        name: "motion_blur",
        what: "camera, sun and drops move while the shutter of a frame is open: the frame is the mean over \
               that time",
        formula: "max |mean of L - L|, in small pictures of the frames that are looked at",
        source: "Cook, Porter and Carpenter, Proc. SIGGRAPH 84, 137-145 (1984)",
        section: Some(Section::Shutter),
        fact: |_| {
            "a scene by itself has no shutter, frames of a [sequence] with shutter_deg have one"
                .to_string()
        },
        ..PLAIN
    },
];

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

    /// Whether the theory of scattering has or lacks it, whatever a scene wants.
    pub fn comes_with_theory(self) -> bool {
        self.row().role == Role::OfTheory
    }

    /// Whether it smooths what a table holds, so that leaving it out takes more angles and saves nothing.
    pub(crate) fn smooths_bows(self) -> bool {
        matches!(self, Self::SunDisc | Self::SizeSpread)
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
