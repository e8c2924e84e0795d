//! What leaving an effect out can change, block by block of the picture.
//!
//! In units of display white, with tau the optical depth of the drops on a ray (Q = 1),
//! q the efficiency of the extinction level, P(theta) the light of a unit of optical depth:
//! * a bow adds at most P tau, with extinction P (1 - exp(-q tau))/q, because
//!   int_0^tau exp(-q t) dt is that;
//! * extinction of drops takes at most P int_0^tau (1 - exp(-q t)) dt = P (tau - (1 - exp(-q tau))/q)
//!   from the bow and (1 - exp(-q tau)) from what shines behind the drops or around them;
//! * their shadow takes at most 1 - exp(-q tau_s) of the bow, tau_s the largest optical depth
//!   towards the sun;
//! * the air takes at most 1 - exp(-tau_air) of each wavelength of the bow, on either path;
//! * the other orders add their own P, and show both sides of the split where a bow is off;
//! * light that drops scatter more than once is as bright as if what half of the drops take of the
//!   sunlight came from all directions, less what scattering keeps going forward:
//!   L = (1 - exp(-tau_s/2)) (1 - exp(-tau)) (1 - g exp(-(1 - g) tau)) E/(4 pi), g the mean cosine of
//!   scattering; by similarity (1 - g) tau decides whether light is even (van de Hulst, Multiple Light
//!   Scattering, Academic Press (1980), section 14.1);
//! * light scattered by the air is bounded by itself (see `air_light`);
//! * sun's disc, spread of sizes and supernumeraries change P by a difference of two curves;
//! * where the theory has no separate orders and others show the same light, an order changes no more
//!   than the error of a table; by size large drops have separate orders, and drops of every size count
//!   as large;
//! * glory and corona are what the exact light has beyond the orders of other theories (see `rings`);
//! * water adds no more than R_s P(theta') c, theta' from the sun in the water, R_s the reflectance of light
//!   polarized along it, for no polarization is mirrored better (waves: at the largest P within their
//!   streak); and what else changes the bow of the sun changes the water's by as much, R_s times;
//! * a lit surface is no brighter than one that faces the sun above the air, and a fifth for the sky; of as much light
//!   of level ground drops take no more than by their largest optical depth between the sun and the ground that is seen,
//!   surfaces all;
//! * water that is seen is no brighter than white in sun and sky, and mirrors no more than all: rays that may meet it add
//!   blocks of the rays that go on from it;
//! * flat drops change P by what moving the bow of every size does (see `flat_drops`).
//!
//! All of it is the light itself: the error of the tables that a picture is made with, which is a level
//! of its own, comes on top.
//!
//! tau is bounded box by box (see `depth`). All are monotone: they grow
//! when light is added and fall when attenuation is. So bounds computed with every light that may be
//! on and only the attenuation that must be on may be added up, in whatever order effects are left
//! out.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use niji_render::shade_under_drops;

use crate::effect::Effect;

use super::air_light::AirLight;
use super::bound::Bound;
use super::bound::BoundKind;
use super::bound::BoundTerms;
use super::directed_curve::DirectedCurve;
use super::light_curves::LightCurves;
use super::light_curves::Shapes;
use super::light_curves::shapings;
use super::luminance::Line;
use super::view::Block;

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
            shapings: shapings(known),
            flat: known(Effect::DropFlattening),
        }
    }
}

/// How sunlight comes to the drops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Straight,
    ByWater,
}

/// A sun that lights the drops: itself or mirrored by water.
pub(super) struct LitBy<'a> {
    pub(super) way: Way,
    /// The blocks of the picture with their scattering angles from it.
    pub(super) blocks: &'a [Block],
    /// Light of the drops by these angles.
    pub(super) light: &'a LightCurves<'a>,
    /// Largest optical depth of the drops towards it at Q = 1.
    pub(super) sun_depth: f64,
    /// Largest share of the sun's light that it has.
    pub(super) share: f64,
    /// How far its light may come from beside it, rad.
    pub(super) reach_rad: f64,
    /// What spreads it, where anything does.
    pub(super) waves: Option<Waves>,
}

/// Waves that mirror the sun.
#[derive(Clone, Copy)]
pub(super) struct Waves {
    /// Standard deviation of their slopes along one axis.
    pub(super) slope: f64,
    /// Of the sun's elevation.
    pub(super) sine: f64,
}

/// Level ground in sun and sky.
#[derive(Clone, Copy)]
pub(super) struct Ground {
    /// Its light over white that faces the sun, at most; 0 where none is seen.
    pub(super) light: f64,
    /// Of the sun's elevation.
    pub(super) sine: f64,
    /// Largest optical depth of the drops towards the sun at Q = 1.
    pub(super) sun_depth: f64,
    /// Whether meshes or terrain may shade it.
    pub(super) has_surfaces: bool,
}

impl Ground {
    /// Whether it is shaded in any of these blocks by effects that are on.
    pub(super) fn is_shaded(&self, blocks: &[Block], on: &BTreeSet<Effect>) -> bool {
        let is_dark = |block: &Block| self.taken(block) > 0.0;
        self.light > 0.0 && self.may_be_shaded(on) && blocks.iter().any(is_dark)
    }

    /// Whether it is shown, and anything is there that may shade it.
    fn may_be_shaded(&self, on: &BTreeSet<Effect>) -> bool {
        on.contains(&Effect::Sky) && (self.has_surfaces || on.contains(&Effect::DropShadow))
    }

    /// Share of its light that drops and surfaces take in a block, at most.
    pub(super) fn taken(&self, block: &Block) -> f64 {
        match block.ground_sun_depth {
            Some(_) if self.has_surfaces => 1.0,
            Some(depth) => shade_under_drops(depth.min(self.sun_depth), self.sine),
            None => 0.0,
        }
    }
}

/// A scene as bounds see it.
pub(super) struct BoundScene<'a> {
    pub(super) sun: LitBy<'a>,
    /// The sun in the water; `None` where there is none.
    pub(super) mirrored: Option<LitBy<'a>>,
    /// Rows and columns of the blocks of the picture.
    pub(super) n_blocks: (usize, usize),
    pub(super) lines: &'a [Line],
    /// Whether rays meet water.
    pub(super) sees_water: bool,
    /// Largest albedo of a surface that is lit.
    pub(super) lit_albedo: f64,
    pub(super) ground: Ground,
    /// Whether the field of the drops goes on below the ground.
    pub(super) reaches_ground: bool,
    pub(super) air: Option<&'a AirLight>,
    /// Extinction efficiency of the level.
    pub(super) efficiency: f64,
    /// Largest error of the scattering table over its peak: all that an order changes that the exact
    /// light holds in any case.
    pub(super) table_error: f64,
    /// Farthest distance at which a ray in view can leave the drops (m).
    pub(super) farthest_m: f64,
}

/// Both bows.
const BOWS: [Effect; 2] = [Effect::PrimaryBow, Effect::SecondaryBow];

/// -expm1(-x): the share that an optical depth takes.
fn taken(depth: f64) -> f64 {
    -(-depth).exp_m1()
}

/// Mean cosine of scattering by large drops without diffraction: 0.87 with it, whose own is 1.
const MEAN_COSINE: f64 = 0.74;

/// Light of sun and sky on a surface over sunlight above the air, at most: air takes from the sun what it gives.
const LIT: f64 = 1.0 + SKYLIT;
/// The sky's part of it.
pub(super) const SKYLIT: f64 = 0.2;

/// Share of further orders that is even over all directions.
fn returned(depth: f64) -> f64 {
    1.0 - MEAN_COSINE * (-(1.0 - MEAN_COSINE) * depth).exp()
}

/// How an effect changes the picture.
enum Change {
    /// A share of the light of the column that is seen.
    Column { light: DirectedCurve, share: f64 },
    /// Light of the column within some degrees of a sun or opposite it: of a sun that waves spread, as many as do.
    Ring { light: DirectedCurve },
    /// What extinction takes from this light and from what shines behind.
    Extinction { light: DirectedCurve },
    /// Light in the share that the drops take from a ray.
    Taken { light: f64 },
    /// The same of light of further orders.
    Further { light: f64 },
    /// Light of the air in front of the far side of the drops.
    Inscatter,
    /// Light of the whole ray beyond.
    Sky,
    /// Light of a surface, or what is taken from this light of the ground.
    Lit { light: f64, ground: f64 },
    /// None.
    Nothing,
}

/// Where a bound is largest.
struct Worst<'a> {
    change: &'a Change,
    /// Of the block.
    index: usize,
    value: f64,
}

impl BoundScene<'_> {
    /// Bound on an effect.
    pub(super) fn bound(&self, effect: Effect, assumed: &Assumed) -> Bound {
        let (kind, _, changes) = self.changes(effect, assumed);
        self.largest(kind, &changes)
    }

    /// The sun by which an effect is explained.
    fn own_sun(&self, effect: Effect) -> &LitBy<'_> {
        match &self.mirrored {
            Some(mirrored) if effect == Effect::ReflectionBow => mirrored,
            Some(_) | None => &self.sun,
        }
    }

    /// How an effect changes the picture, how sure that is, and by how much by block.
    fn changes(&self, effect: Effect, assumed: &Assumed) -> (BoundKind, Change, Vec<f64>) {
        let (kind, change) = self.change(effect, assumed, self.own_sun(effect));
        let by_block = self.of_both_suns(effect, assumed, &change);
        (kind, change, by_block)
    }

    /// Changes by block: of the light of the own sun, and of what water may mirror besides.
    fn of_both_suns(&self, effect: Effect, assumed: &Assumed, change: &Change) -> Vec<f64> {
        let mut changes = self.by_block(change, assumed, self.own_sun(effect));
        if effect == Effect::DropShadow {
            let on_surfaces = self.lit(assumed) * taken(self.sun.sun_depth);
            let ground = self.light_of_ground(assumed);
            for (change, block) in changes.iter_mut().zip(self.sun.blocks) {
                *change += on_surfaces.max(ground * self.ground.taken(block));
            }
        }
        let water = self.mirrored.as_ref().filter(|_| {
            effect != Effect::ReflectionBow && assumed.may_be_on.contains(&Effect::ReflectionBow)
        });
        if let Some(water) = water {
            let (_, change) = self.change(effect, assumed, water);
            if let Change::Column { .. } | Change::Ring { .. } | Change::Extinction { .. } = change
            {
                let more = self.by_block(&change, assumed, water);
                for (sum, more) in changes.iter_mut().zip(more) {
                    *sum += more;
                }
            }
        }
        changes
    }

    /// Bound on an effect with its numbers where it is largest; none where it is 0 everywhere.
    pub(super) fn bound_with_terms(
        &self,
        effect: Effect,
        assumed: &Assumed,
    ) -> (Bound, Option<BoundTerms>) {
        let (kind, change, values) = self.changes(effect, assumed);
        let worst = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b]));
        let worst = worst.filter(|index| values[*index] > 0.0);
        let terms = worst.map(|index| {
            let worst = Worst {
                change: &change,
                index,
                value: values[index],
            };
            self.terms(effect, assumed, &worst)
        });
        (self.largest(kind, &values), terms)
    }

    /// Sum of bounds on effects by row and column of the blocks of the picture.
    pub(super) fn by_place<'b>(
        &self,
        effects: impl Iterator<Item = (Effect, &'b Assumed)>,
    ) -> Vec<Vec<f32>> {
        let (n_rows, n_columns) = self.n_blocks;
        let mut sums = vec![vec![0.0; n_columns]; n_rows];
        for (effect, assumed) in effects {
            let (_, _, changes) = self.changes(effect, assumed);
            let blocks = self.sun.blocks.iter().zip(changes);
            // Rays that go on from water are no part of the picture by themselves.
            for (block, change) in blocks.filter(|(block, _)| block.share > 0.0) {
                let (row, column) = block.place;
                sums[row][column] += change as f32;
            }
        }
        sums
    }

    fn by_block(&self, change: &Change, assumed: &Assumed, sun: &LitBy<'_>) -> Vec<f64> {
        (0..sun.blocks.len())
            .map(|index| self.of_block(change, (index, sun), assumed))
            .collect()
    }

    /// Maximum and RMS over the picture of changes by block.
    fn largest(&self, kind: BoundKind, changes: &[f64]) -> Bound {
        let (mut value, mut square) = (0.0_f64, 0.0);
        for (block, change) in self.sun.blocks.iter().zip(changes) {
            value = value.max(*change);
            square += block.share * change * change;
        }
        // Shares sum to 1 but for roundoff.
        let rms = square.sqrt().min(value);
        Bound { value, rms, kind }
    }

    fn terms(&self, effect: Effect, assumed: &Assumed, worst: &Worst) -> BoundTerms {
        let Worst {
            change,
            index,
            value,
        } = *worst;
        let sun = self.own_sun(effect);
        let (block, depth) = (&sun.blocks[index], self.depth(index));
        let efficiency = self.efficiency;
        let (column, light, share) = match change {
            Change::Column { light, share } => (
                Some(self.column(index, assumed)),
                Some(brightest(light, (index, sun))),
                (share * sun.share < 1.0).then_some(share * sun.share),
            ),
            Change::Ring { light } => (
                Some(self.column(index, assumed)),
                Some(of_spread_sun(light, (index, sun))),
                (sun.share < 1.0).then_some(sun.share),
            ),
            Change::Extinction { light } => (
                Some(taken(efficiency * depth) / efficiency),
                Some(brightest(light, (index, sun))),
                Some(taken(efficiency * depth)),
            ),
            Change::Taken { light } => (None, Some(*light), Some(taken(depth))),
            Change::Further { light } => (None, Some(light * returned(depth)), Some(taken(depth))),
            Change::Inscatter | Change::Sky | Change::Lit { .. } => (None, Some(value), None),
            Change::Nothing => (None, None, None),
        };
        let shaded = [Effect::DropShadow, Effect::MultipleScattering].contains(&effect);
        BoundTerms {
            theta_deg: (
                block.theta_rad.0.to_degrees(),
                block.theta_rad.1.to_degrees(),
            ),
            distance_m: block.drops.map(|chord| (chord.enter_m, chord.leave_m)),
            optical_depth: depth,
            sun_optical_depth: shaded.then_some(sun.sun_depth),
            column,
            light,
            share,
        }
    }

    /// How an effect changes the light of a sun, and how sure that is.
    fn change(&self, effect: Effect, assumed: &Assumed, sun: &LitBy<'_>) -> (BoundKind, Change) {
        let (shapes, sunlight) = (assumed.shapes(), self.sunlight(assumed));
        let bows = |factor: &[f64]| bows(assumed, factor, sun.light);
        if self.is_shown_anyway(effect, assumed) {
            let change = Change::Column {
                light: bows(&sunlight),
                share: self.table_error,
            };
            return (BoundKind::TableDifference, change);
        }
        let whole = |light: DirectedCurve| Change::Column { light, share: 1.0 };
        // Where drops pass their light on to others, that light changes too, and of it there is an
        // estimate only, as of the light of surfaces behind them.
        let is_estimate = assumed.may_be_on.contains(&Effect::MultipleScattering);
        let is_shaded = effect == Effect::DropShadow && self.light_of_ground(assumed) > 0.0;
        let proved = if is_estimate || self.lit(assumed) > 0.0 || self.sees_water || is_shaded {
            BoundKind::Estimated
        } else {
            BoundKind::Proved
        };
        match effect {
            Effect::PrimaryBow | Effect::SecondaryBow => {
                (proved, whole(sun.light.bow(effect, &sunlight, &shapes)))
            }
            Effect::HigherOrders => {
                let shown = BOWS.map(|bow| assumed.is_on.contains(&bow));
                let light = sun.light.higher_light(&sunlight, &shapes, shown);
                (proved, whole(light))
            }
            Effect::Supernumeraries | Effect::SunDisc | Effect::SizeSpread => {
                let light = sun.light.difference(effect, &sunlight, &shapes);
                (BoundKind::TableDifference, whole(light))
            }
            Effect::Glory | Effect::Corona => {
                let light = sun.light.ring(effect, &sunlight, &shapes);
                (BoundKind::Estimated, Change::Ring { light })
            }
            Effect::DropFlattening => {
                let light = sun.light.flattening(&sunlight, &shapes);
                (BoundKind::Estimated, whole(light))
            }
            Effect::DropExtinction => {
                let light = bows(&sunlight);
                (proved, Change::Extinction { light })
            }
            Effect::DropShadow => {
                let change = Change::Column {
                    light: bows(&sunlight),
                    share: taken(self.efficiency * sun.sun_depth),
                };
                (proved, change)
            }
            // What scatters the light of the surroundings is what extinction takes.
            Effect::SkylitDrops if !assumed.may_be_on.contains(&Effect::DropExtinction) => {
                (BoundKind::Estimated, Change::Nothing)
            }
            Effect::SkylitDrops => {
                let light = self.surround(assumed);
                (BoundKind::Estimated, Change::Taken { light })
            }
            Effect::MultipleScattering => {
                let lines = self.lines.iter().zip(&sunlight);
                let sunlight: f64 = lines.map(|(line, factor)| line.weight * factor).sum();
                let light = taken(0.5 * sun.sun_depth) * sunlight / (4.0 * PI);
                (BoundKind::Estimated, Change::Further { light })
            }
            Effect::ReflectionBow if self.mirrored.is_none() => (proved, Change::Nothing),
            Effect::ReflectionBow => (proved, whole(bows(&sunlight))),
            Effect::SunlightThroughAir => {
                let lost = self.air.map(AirLight::sunlight_lost).unwrap_or_default();
                // Light by way of the water has more air to pass.
                let lost = match sun.way {
                    Way::Straight => lost,
                    Way::ByWater => vec![1.0; lost.len()],
                };
                (proved, whole(bows(&lost)))
            }
            Effect::AirExtinction => {
                let lost = self.air.map(|air| air.view_lost(self.farthest_m));
                let lost = lost.unwrap_or_default().into_iter().zip(&sunlight);
                let factor: Vec<f64> = lost.map(|(lost, sunlight)| lost * sunlight).collect();
                (proved, whole(bows(&factor)))
            }
            Effect::AirInscatter => (BoundKind::Proved, Change::Inscatter),
            // The ground, which comes with it, hides drops below it and keeps those that stand on it from fading.
            Effect::Sky if self.reaches_ground && self.air.is_some() => {
                (BoundKind::Estimated, Change::Sky)
            }
            Effect::Sky => (BoundKind::Proved, Change::Sky),
            Effect::LitSurfaces => {
                let (light, ground) = (self.lit(assumed), self.light_of_ground(assumed));
                (BoundKind::Estimated, Change::Lit { light, ground })
            }
            Effect::SeenWater if !self.sees_water => (BoundKind::Proved, Change::Nothing),
            Effect::SeenWater => {
                let light = LIT * self.sunlight_on_white();
                (BoundKind::Estimated, Change::Lit { light, ground: 0.0 })
            }
            Effect::Occluders | Effect::MotionBlur => (BoundKind::Proved, Change::Nothing),
        }
    }

    /// Whether other effects show the same light, because the theory has no orders to divide it into.
    fn is_shown_anyway(&self, effect: Effect, assumed: &Assumed) -> bool {
        let is_shown = if effect == Effect::HigherOrders {
            BOWS.iter().all(|bow| assumed.is_on.contains(bow))
        } else {
            BOWS.contains(&effect) && assumed.is_on.contains(&Effect::HigherOrders)
        };
        is_shown && self.sun.light.is_whole(&assumed.shapes())
    }

    /// Largest change in a block.
    fn of_block(
        &self,
        change: &Change,
        (index, sun): (usize, &LitBy<'_>),
        assumed: &Assumed,
    ) -> f64 {
        match change {
            Change::Column { light, share } => {
                let light = sun.share * brightest(light, (index, sun));
                share * light * self.column(index, assumed)
            }
            Change::Ring { light } => {
                let light = sun.share * of_spread_sun(light, (index, sun));
                light * self.column(index, assumed)
            }
            Change::Extinction { light } => {
                let from_bow = self.extinct(index, sun.share * brightest(light, (index, sun)));
                match sun.way {
                    Way::Straight => self.extinction_change(index, from_bow, assumed),
                    Way::ByWater => from_bow,
                }
            }
            Change::Taken { light } => taken(self.depth(index)) * light,
            Change::Further { light } => {
                let depth = self.depth(index);
                taken(depth) * returned(depth) * light
            }
            Change::Inscatter => self.inscatter(index),
            Change::Sky => self.sky(index),
            Change::Lit { light, ground } => {
                light.max(ground * self.ground.taken(&self.sun.blocks[index]))
            }
            Change::Nothing => 0.0,
        }
    }

    /// Largest optical depth of the drops on any ray of a block, Q = 1.
    pub(super) fn depth(&self, block_index: usize) -> f64 {
        self.sun.blocks[block_index].depth
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

    /// Light of the air in front of the far side of the drops. It is dimmed by the air in any case.
    fn inscatter(&self, block_index: usize) -> f64 {
        self.air.map_or(0.0, |air| air.inscatter(block_index))
    }

    /// Light of air and ground beyond the drops, dimmed by the air in any case.
    fn sky(&self, block_index: usize) -> f64 {
        self.air.map_or(0.0, |air| air.sky(block_index))
    }

    /// Light of a surface in sun and sky, at most.
    fn lit(&self, assumed: &Assumed) -> f64 {
        if assumed.may_be_on.contains(&Effect::LitSurfaces) {
            LIT * self.lit_albedo * self.sunlight_on_white()
        } else {
            0.0
        }
    }

    /// Light of the ground that may be shaded, at most.
    fn light_of_ground(&self, assumed: &Assumed) -> f64 {
        let on = &assumed.may_be_on;
        if on.contains(&Effect::LitSurfaces) && self.ground.may_be_shaded(on) {
            self.ground.light * self.sunlight_on_white()
        } else {
            0.0
        }
    }

    /// Light of white that faces the sun above the air.
    fn sunlight_on_white(&self) -> f64 {
        self.lines.iter().map(|line| line.weight).sum::<f64>() / PI
    }

    fn surround(&self, assumed: &Assumed) -> f64 {
        match self.air {
            Some(air) if assumed.may_be_on.contains(&Effect::Sky) => air.mean_surround(),
            Some(_) | None => 0.0,
        }
    }

    /// What extinction takes from a bow of this light.
    fn extinct(&self, block_index: usize, light: f64) -> f64 {
        let depth = self.depth(block_index);
        let share = taken(self.efficiency * depth);
        (light * (depth - share / self.efficiency)).max(0.0)
    }

    /// What extinction takes from the bows and from the light behind the drops. Skylit drops exist
    /// only with it and add light, so the larger of both changes bounds their difference.
    fn extinction_change(&self, block_index: usize, from_bow: f64, assumed: &Assumed) -> f64 {
        let depth = self.depth(block_index);
        let share = taken(self.efficiency * depth);
        let when = |effect, light: f64| {
            if assumed.may_be_on.contains(&effect) {
                light
            } else {
                0.0
            }
        };
        let behind = when(Effect::Sky, self.sky(block_index))
            + when(Effect::AirInscatter, self.inscatter(block_index))
            + self.lit(assumed);
        let skylit = when(Effect::SkylitDrops, self.surround(assumed)) * taken(depth);
        (from_bow + behind * share).max(skylit)
    }
}

/// Largest value of a curve within a block, as far as light comes from beside a sun.
fn brightest(curve: &DirectedCurve, (block_index, sun): (usize, &LitBy<'_>)) -> f64 {
    let block = &sun.blocks[block_index];
    let (low_rad, high_rad) = block.theta_rad;
    let theta_rad = (low_rad - sun.reach_rad, high_rad + sun.reach_rad);
    curve.max_within(theta_rad, block.rise)
}

/// The same in the mean over the slopes of waves, each axis Gaussian: a facet turns the mirrored sun by twice its tilt
/// along the plane of the sun, and by that times the sine of the sun's elevation across it, so that it has at most the
/// density exp(-tan²(turn/2)/(2 slope²))/(2 pi (2 slope)² sine) a steradian.
fn of_spread_sun(curve: &DirectedCurve, (block_index, sun): (usize, &LitBy<'_>)) -> f64 {
    let most = brightest(curve, (block_index, sun));
    let Some(Waves { slope, sine }) = sun.waves else {
        return most;
    };
    let block = &sun.blocks[block_index];
    let (low_rad, high_rad) = block.theta_rad;
    let density = |theta_rad: f64| {
        let turn_rad = (low_rad - theta_rad).max(theta_rad - high_rad).max(0.0);
        let of_turn = (-0.5 * ((0.5 * turn_rad).tan() / slope).powi(2)).exp();
        of_turn / (2.0 * PI * (2.0 * slope).powi(2) * sine)
    };
    most.min(curve.over_the_sphere(density, block.rise))
}

/// Light of all orders that may be on.
fn bows(assumed: &Assumed, factor: &[f64], light: &LightCurves<'_>) -> DirectedCurve {
    let shapes = assumed.shapes();
    let bows = BOWS
        .into_iter()
        .filter(|bow| assumed.may_be_on.contains(bow))
        .map(|bow| light.bow(bow, factor, &shapes));
    let higher = assumed
        .may_be_on
        .contains(&Effect::HigherOrders)
        .then(|| light.higher_light(factor, &shapes, [true; 2]));
    bows.chain(higher)
        .reduce(|a, b| a.plus(&b))
        .unwrap_or_else(DirectedCurve::empty)
}
