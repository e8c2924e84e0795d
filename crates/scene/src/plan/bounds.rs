//! What leaving an effect out can change, block by block of the picture.
//!
//! In units of a gray card in the sun, with tau the optical depth of the drops on a ray (Q = 1),
//! q the efficiency of the extinction level, P(theta) the light of a unit of optical depth:
//! * a bow adds at most P tau, with extinction P (1 - exp(-q tau))/q, because
//!   int_0^tau exp(-q t) dt is that;
//! * extinction of drops takes at most P int_0^tau (1 - exp(-q t)) dt = P (tau - (1 - exp(-q tau))/q)
//!   from the bow and (1 - exp(-q tau)) from what shines behind the drops or around them;
//! * their shadow takes at most 1 - exp(-q tau_s) of the bow, tau_s the largest optical depth
//!   towards the sun;
//! * the air takes at most 1 - exp(-tau_air) of each wavelength of the bow, on either path;
//! * the other orders add their own P, and show both sides of the split where a bow is off;
//! * light that drops scatter more than once is as bright as if the sunlight that they take, 1 -
//!   exp(-tau_s), came back evenly from all directions: L = (1 - exp(-tau_s)) (1 - exp(-tau)) E/(4 pi);
//! * light scattered by the air is bounded by itself (see `air_light`);
//! * sun's disc, spread of sizes and supernumeraries change P by a difference of two curves;
//! * flat drops change P by what moving the bow of every size does (see `flat_drops`).
//!
//! tau <= sigma_max times the longest way of a block through the box. All are monotone: they grow
//! when light is added and fall when attenuation is. So bounds computed with every light that may be
//! on and only the attenuation that must be on may be added up, in whatever order effects are left
//! out.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use crate::effect::Effect;

use super::air_light::AirLight;
use super::bow_light::Line;
use super::directed_curve::DirectedCurve;
use super::light_curves::LightCurves;
use super::light_curves::Shapes;
use super::light_curves::variants;
use super::view::Block;

/// A bound on the contribution of an effect.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bound {
    /// Largest change of luminance of any pixel, relative to a gray card (albedo 0.18) that faces
    /// the sun above the air.
    pub value: f64,
    /// RMS of that change over the picture; never above `value`.
    pub rms: f64,
    /// How sure it is.
    pub kind: BoundKind,
}

/// How sure a bound is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoundKind {
    /// It follows from the equations that are rendered; the change is never larger.
    Proved,
    /// It follows from a simpler model of what is left out.
    Estimated,
    /// It is the difference of two coarse tables.
    TableDifference,
}

impl BoundKind {
    /// The kind in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Estimated => "estimated",
            Self::TableDifference => "table difference",
        }
    }
}

/// Which effects count while a bound is computed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assumed {
    /// Effects whose light may be there.
    pub(super) may_be_on: BTreeSet<Effect>,
    /// Effects whose attenuation is there for sure.
    pub(super) is_on: BTreeSet<Effect>,
}

impl Assumed {
    /// The ways in which light may be shaped.
    fn shapes(&self) -> Shapes {
        let known = |effect: Effect| match (
            self.may_be_on.contains(&effect),
            self.is_on.contains(&effect),
        ) {
            (true, true) => Some(true),
            (true, false) => None,
            (false, _) => Some(false),
        };
        Shapes {
            variants: variants(known),
            flat: known(Effect::DropFlattening),
        }
    }
}

/// A scene as bounds see it.
pub(super) struct BoundScene<'a> {
    pub(super) blocks: &'a [Block],
    pub(super) lines: &'a [Line],
    pub(super) light: &'a LightCurves<'a>,
    pub(super) air: Option<&'a AirLight>,
    /// Largest optical depth of the drops towards the sun at Q = 1.
    pub(super) sun_depth: f64,
    /// Extinction efficiency of the level.
    pub(super) efficiency: f64,
    /// Farthest distance at which a ray in view can leave the drops (m).
    pub(super) farthest_m: f64,
}

/// Both bows.
const BOWS: [Effect; 2] = [Effect::PrimaryBow, Effect::SecondaryBow];

/// -expm1(-x): the share that an optical depth takes.
fn taken(depth: f64) -> f64 {
    -(-depth).exp_m1()
}

impl BoundScene<'_> {
    /// Bound on an effect; `None` where nothing is known.
    pub(super) fn bound(&self, effect: Effect, assumed: &Assumed) -> Option<Bound> {
        let proved = |change: &dyn Fn(usize) -> f64| Some(self.over(BoundKind::Proved, change));
        match effect {
            Effect::PrimaryBow | Effect::SecondaryBow => {
                let curve = self
                    .light
                    .bow(effect, &self.sunlight(assumed), &assumed.shapes());
                proved(&|index| self.brightest(&curve, index) * self.column(index, assumed))
            }
            Effect::Supernumeraries | Effect::SunDisc | Effect::SizeSpread => {
                let (factor, shapes) = (self.sunlight(assumed), assumed.shapes());
                let curve = self.light.difference(effect, &factor, &shapes);
                let change = |index| self.brightest(&curve, index) * self.column(index, assumed);
                Some(self.over(BoundKind::TableDifference, &change))
            }
            Effect::HigherOrders => {
                let factor = self.sunlight(assumed);
                let shown = BOWS.map(|bow| assumed.is_on.contains(&bow));
                let curve = self.light.higher_light(&factor, &assumed.shapes(), shown);
                proved(&|index| self.brightest(&curve, index) * self.column(index, assumed))
            }
            Effect::DropFlattening => {
                let curve = self
                    .light
                    .flattening(&self.sunlight(assumed), &assumed.shapes());
                let change = |index| self.brightest(&curve, index) * self.column(index, assumed);
                Some(self.over(BoundKind::Estimated, &change))
            }
            Effect::DropExtinction => {
                let curve = self.bows(assumed, &self.sunlight(assumed));
                proved(&|index| self.extinction_change(index, &curve, assumed))
            }
            Effect::DropShadow => {
                let curve = self.bows(assumed, &self.sunlight(assumed));
                let shadow = taken(self.efficiency * self.sun_depth);
                proved(&|index| {
                    shadow * self.brightest(&curve, index) * self.column(index, assumed)
                })
            }
            Effect::SkylitDrops => {
                let surround = self.surround(assumed);
                let change = |index| taken(self.depth(index)) * surround;
                Some(self.over(BoundKind::Estimated, &change))
            }
            Effect::SunlightThroughAir => {
                let lost = self.air.map(AirLight::sunlight_lost).unwrap_or_default();
                let curve = self.bows(assumed, &lost);
                proved(&|index| self.brightest(&curve, index) * self.column(index, assumed))
            }
            Effect::AirExtinction => {
                let lost = self
                    .air
                    .map(|air| air.view_lost(self.farthest_m))
                    .unwrap_or_default();
                let sunlight = self.sunlight(assumed);
                let factor: Vec<f64> = lost.iter().zip(&sunlight).map(|(a, b)| a * b).collect();
                let curve = self.bows(assumed, &factor);
                proved(&|index| self.brightest(&curve, index) * self.column(index, assumed))
            }
            Effect::AirInscatter => proved(&|index| self.inscatter(index)),
            Effect::Sky => proved(&|index| self.sky(index)),
            Effect::Occluders => proved(&|_| 0.0),
            Effect::MultipleScattering => {
                let factor = self.sunlight(assumed);
                let lines = self.lines.iter().zip(&factor);
                let sunlight: f64 = lines.map(|(line, factor)| line.weight * factor).sum();
                let source = taken(self.sun_depth) * sunlight / (4.0 * PI);
                let change = |index| source * taken(self.depth(index));
                Some(self.over(BoundKind::Estimated, &change))
            }
            Effect::Glory | Effect::Corona => None,
        }
    }

    /// Maximum and RMS over the picture of a change by block.
    pub(super) fn over(&self, kind: BoundKind, change: &dyn Fn(usize) -> f64) -> Bound {
        let (mut value, mut square) = (0.0_f64, 0.0);
        for (index, block) in self.blocks.iter().enumerate() {
            let change = change(index);
            value = value.max(change);
            square += block.share * change * change;
        }
        // Shares sum to 1 but for roundoff.
        let rms = square.sqrt().min(value);
        Bound { value, rms, kind }
    }

    /// Largest optical depth of the drops on any ray of a block, Q = 1.
    pub(super) fn depth(&self, block_index: usize) -> f64 {
        self.blocks[block_index].depth
    }

    /// Largest value of a curve within a block.
    fn brightest(&self, curve: &DirectedCurve, block_index: usize) -> f64 {
        let block = &self.blocks[block_index];
        curve.max_within(block.theta_rad, block.flattening)
    }

    /// Effective column of the drops that scatters into the view.
    fn column(&self, block_index: usize, assumed: &Assumed) -> f64 {
        let depth = self.depth(block_index);
        if assumed.is_on.contains(&Effect::DropExtinction) {
            taken(self.efficiency * depth) / self.efficiency
        } else {
            depth
        }
    }

    /// Largest share of sunlight at the drops, by line.
    fn sunlight(&self, assumed: &Assumed) -> Vec<f64> {
        match self.air {
            Some(air) if assumed.is_on.contains(&Effect::SunlightThroughAir) => air.sunlight(),
            Some(_) | None => vec![1.0; self.lines.len()],
        }
    }

    /// Light of all orders that may be on.
    fn bows(&self, assumed: &Assumed, factor: &[f64]) -> DirectedCurve {
        let shapes = assumed.shapes();
        let bows = BOWS
            .into_iter()
            .filter(|bow| assumed.may_be_on.contains(bow))
            .map(|bow| self.light.bow(bow, factor, &shapes));
        let higher = assumed
            .may_be_on
            .contains(&Effect::HigherOrders)
            .then(|| self.light.higher_light(factor, &shapes, [true; 2]));
        bows.chain(higher)
            .reduce(|a, b| a.plus(&b))
            .unwrap_or_else(DirectedCurve::empty)
    }

    /// Light of the air in front of the far side of the drops. It is dimmed by the air in any case.
    fn inscatter(&self, block_index: usize) -> f64 {
        self.air.map_or(0.0, |air| air.inscatter(block_index))
    }

    /// Light of air and ground beyond the drops, dimmed by the air in any case.
    fn sky(&self, block_index: usize) -> f64 {
        self.air.map_or(0.0, |air| air.sky(block_index))
    }

    fn surround(&self, assumed: &Assumed) -> f64 {
        match self.air {
            Some(air) if assumed.may_be_on.contains(&Effect::Sky) => air.mean_surround(),
            Some(_) | None => 0.0,
        }
    }

    /// What extinction takes from the bows and from the light behind the drops. Skylit drops exist
    /// only with it and add light, so the larger of both changes bounds their difference.
    fn extinction_change(
        &self,
        block_index: usize,
        curve: &DirectedCurve,
        assumed: &Assumed,
    ) -> f64 {
        let depth = self.depth(block_index);
        let share = taken(self.efficiency * depth);
        let from_bow = self.brightest(curve, block_index) * (depth - share / self.efficiency);
        let when = |effect, light: f64| {
            if assumed.may_be_on.contains(&effect) {
                light
            } else {
                0.0
            }
        };
        let behind = when(Effect::Sky, self.sky(block_index))
            + when(Effect::AirInscatter, self.inscatter(block_index));
        let skylit = when(Effect::SkylitDrops, self.surround(assumed)) * taken(depth);
        (from_bow.max(0.0) + behind * share).max(skylit)
    }
}
