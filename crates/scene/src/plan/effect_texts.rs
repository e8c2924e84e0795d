//! What every effect is, how its bound is made, and where it is published.
//!
//! Symbols of the formulas: P(theta) light that a unit of optical depth adds, in gray cards in the sun;
//! tau optical depth of the drops on a view ray (Q = 1), tau_s towards the sun; q efficiency of
//! extinction, 1 or 2; c = (1 - exp(-q tau))/q the column that is seen, tau itself where extinction may
//! be off; Q_l, S_l, ... sums over wavelengths l weighted by the eye.

use crate::effect::Effect;

/// What, formula and source of every effect, in the order of [`Effect::ALL`].
const TEXTS: [(Effect, [&str; 3]); Effect::ALL.len()] = [
    (
        Effect::PrimaryBow,
        [
            "light reflected once inside the drops (p = 2): the bow near 138 degrees from the sun and \
             the brightness inside it",
            "max P_2(theta) c; P_2 from the theory of the table",
            "Nussenzveig, J. Math. Phys. 10, 82-124 (1969); Airy, Trans. Camb. Phil. Soc. 6, 379-403 \
             (1838)",
        ],
    ),
    (
        Effect::SecondaryBow,
        [
            "light reflected twice inside the drops (p = 3): the bow near 129 degrees from the sun and \
             the brightness outside it",
            "max P_3(theta) c; P_3 from the theory of the table",
            "Nussenzveig, J. Math. Phys. 10, 82-124 (1969)",
        ],
    ),
    (
        Effect::HigherOrders,
        [
            "light reflected outside the drops (p = 0), gone straight through (p = 1), and reflected \
             three to six times inside (p = 4 to 7): it fills Alexander's band",
            "max P_other(theta) c; rays of each order",
            "van de Hulst, Light Scattering by Small Particles, Wiley (1957), chapter 12",
        ],
    ),
    (
        Effect::Supernumeraries,
        [
            "interference of the two rays that leave a drop at one angle: fringes inside the primary \
             and outside the secondary, and the finite height of the bow itself",
            "max |P_waves(theta) - P_rays(theta)| c",
            "Young, Phil. Trans. R. Soc. 94, 1-16 (1804); Airy, Trans. Camb. Phil. Soc. 6, 379-403 \
             (1838)",
        ],
    ),
    (
        Effect::Glory,
        [
            "colored rings around the antisolar point, from edge rays and surface waves of small drops; \
             exact theories have it, theories of bows do not",
            "max |P_exact(theta) - P_orders(theta)| c beyond 165 degrees",
            "Laven, Appl. Opt. 44, 5675-5683 (2005)",
        ],
    ),
    (
        Effect::Corona,
        [
            "diffraction around the drops: rings around the sun; exact theories have it, theories of \
             bows leave it out",
            "max P_d(theta) c within 15 degrees of the sun, P_d = (pi/0.18) (x^2/4pi)/(1 + (pi/4) u^3), \
             u = x theta, x = 2 pi r/lambda",
            "Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983), \
             eq. 4.73",
        ],
    ),
    (
        Effect::SunDisc,
        [
            "the sun is a disc of 0.533 degrees: bows of rays from all of it overlap",
            "max |P_disc(theta) - P_point(theta)| c",
            "Lee, Appl. Opt. 37, 1506-1519 (1998)",
        ],
    ),
    (
        Effect::SizeSpread,
        [
            "drops of one place differ in size: their fringes blur",
            "max |P_law(theta) - P_one size(theta)| c",
            "Hansen and Travis, Space Sci. Rev. 16, 527-610 (1974)",
        ],
    ),
    (
        Effect::DropFlattening,
        [
            "air resistance flattens large drops: the bow of each moves by an angle that depends on \
             size and direction",
            "max |P_flat(theta) - P_round(theta)| c over the directions that are seen",
            "Moebius, Ann. Phys. 338, 1493-1558 (1910); Beard and Chuang, J. Atmos. Sci. 44, 1509-1524 \
             (1987)",
        ],
    ),
    (
        Effect::DropExtinction,
        [
            "drops in front take light from those behind them and from what shines through",
            "max of P (tau - c) + L_behind (1 - exp(-q tau)) and, of skylit drops, L_around (1 - \
             exp(-tau))",
            "van de Hulst, Light Scattering by Small Particles, Wiley (1957), section 1.4",
        ],
    ),
    (
        Effect::DropShadow,
        [
            "drops nearer to the sun shade those behind them",
            "(1 - exp(-q tau_s)) max P(theta) c",
            "van de Hulst, Light Scattering by Small Particles, Wiley (1957), section 1.4",
        ],
    ),
    (
        Effect::SkylitDrops,
        [
            "drops scatter light of sky and ground into the view, as much as they take from it",
            "L_around max (1 - exp(-tau)); L_around the mean of air and ground in all directions",
            "Chandrasekhar, Radiative Transfer, Oxford (1950), section 2",
        ],
    ),
    (
        Effect::MultipleScattering,
        [
            "light that two or more drops scattered: it fills shadows and the dark band",
            "(1 - exp(-tau_s/2)) (1 - exp(-tau)) (1 - g exp(-(1 - g) tau)) E/(4 pi), g = 0.74: what half \
             of the drops take, even but for what goes on forward",
            "van de Hulst, Multiple Light Scattering, Academic Press (1980), section 14.1",
        ],
    ),
    (
        Effect::ReflectionBow,
        [
            "water mirrors the sun: a second sun below the horizon makes a second bow, whose center is as \
             high as the sun and which meets the bow of the sun at the horizon",
            "R_s max P(theta') c; theta' from the sun in the water, R_s its reflectance of light polarized \
             along it",
            "Born and Wolf, Principles of Optics, Cambridge (1999), section 1.5.2; Cox and Munk, J. Opt. \
             Soc. Am. 44, 838-850 (1954)",
        ],
    ),
    (
        Effect::SunlightThroughAir,
        [
            "the air between the sun and the drops dims and reddens sunlight; how near the drops are \
             does not shorten that way",
            "max P_l(theta) (1 - exp(-tau_air,l)) c, summed over wavelengths l",
            "Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999)",
        ],
    ),
    (
        Effect::AirExtinction,
        [
            "the air between the drops and the eye takes light of the bow",
            "max P_l(theta) (1 - exp(-beta_l s)) c, summed over wavelengths l; beta_l the largest \
             extinction of the air there, s the farthest drops in view",
            "Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999)",
        ],
    ),
    (
        Effect::AirInscatter,
        [
            "the air between the eye and the far side of the drops scatters sunlight into the view",
            "max L_air(0..s), solved at the corners and in the middle of every part of the picture",
            "Nishita, Sirai, Tadamura and Nakamae, Proc. SIGGRAPH 93, 175-182 (1993)",
        ],
    ),
    (
        Effect::Sky,
        [
            "air and ground behind the drops",
            "max L_air(0..end), solved at the corners and in the middle of every part of the picture",
            "Nishita, Sirai, Tadamura and Nakamae, Proc. SIGGRAPH 93, 175-182 (1993)",
        ],
    ),
    (
        Effect::Occluders,
        [
            "surfaces in front of the drops hide them; they are never left out",
            "0: nothing is decided",
            "Porter and Duff, Computer Graphics 18, 253-259 (1984)",
        ],
    ),
];

/// What stands in a text on an effect.
pub(super) struct EffectText {
    /// What it is physically.
    pub(super) what: &'static str,
    /// Its bound as a formula.
    pub(super) formula: &'static str,
    /// Where it is published.
    pub(super) source: &'static str,
}

/// The text on an effect.
pub(super) fn text(effect: Effect) -> EffectText {
    let [what, formula, source] = TEXTS[effect as usize].1;
    EffectText {
        what,
        formula,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_a_text_a_formula_and_a_dated_source() {
        assert_eq!(TEXTS.map(|(effect, _)| effect), Effect::ALL);
        for effect in Effect::ALL {
            let text = text(effect);
            assert!(text.what.len() > 20 && !text.formula.is_empty(), "{effect}");
            let year = text
                .source
                .split(['(', ')'])
                .filter_map(|part| part.parse::<u32>().ok());
            assert!(
                year.into_iter().any(|year| (1800..2030).contains(&year)),
                "{effect}"
            );
        }
    }
}
