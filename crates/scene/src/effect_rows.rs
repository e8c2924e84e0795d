//! What there is to say of every effect, a row each: what it is, how its bound is made, where it is published, and what it
//! has to do with other effects and with the renderer.
//!
//! Symbols of the formulas: P(theta) light that a unit of optical depth adds, over display white;
//! tau optical depth of the drops on a view ray (Q = 1), tau_s towards the sun; q efficiency of
//! extinction, 1 or 2; c = (1 - exp(-q tau))/q the column that is seen, tau itself where extinction may
//! be off; Q_l, S_l, ... sums over wavelengths l weighted by the eye.

use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::Toggle;

use crate::effect::Effect;
use crate::effect::Role;
use crate::effect::Section;
use crate::effect_facts::Facts;
use crate::figures::brief;

/// What there is to say of an effect.
pub(crate) struct Row {
    pub(crate) effect: Effect,
    pub(crate) name: &'static str,
    /// What it is physically.
    pub(crate) what: &'static str,
    /// Its bound as a formula.
    pub(crate) formula: &'static str,
    /// Where it is published.
    pub(crate) source: &'static str,
    pub(crate) role: Role,
    /// What it cannot do without.
    pub(crate) needs: &'static [Effect],
    pub(crate) section: Option<Section>,
    /// What switches it in the renderer; `None` for what tables hold.
    pub(crate) toggle: Option<fn(&mut RenderEffects) -> &mut Toggle>,
    /// The layer of the picture that its light has to itself.
    pub(crate) layer: Option<PictureLayer>,
    /// What in the scene decides its size.
    pub(crate) fact: fn(&Facts) -> String,
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
pub(crate) static ROWS: [Row; 22] = [
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
               the ground; what surfaces take of the sky is an estimate, what they send each other one with an error that \
               is told",
        formula: "1.2 A E/pi, A the largest albedo; for the ground, under a sun at elevation e, (sin e + 0.2) A E/pi times \
                  the share that drops take",
        source: "Lambert, Photometria, Augsburg (1760); Ramamoorthi and Hanrahan, J. Opt. Soc. Am. A 18, 2448-2459 \
               (2001)",
        toggle: Some(|it| &mut it.lit_surfaces),
        layer: Some(PictureLayer::LitSurface),
        fact: |facts| match facts.n_lit {
            0 if facts.is_ground_shaded => "ground in view may have a shadow".to_string(),
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
