//! The light of all orders over the scattering angle, for every way in which it may be made.
//!
//! Three effects shape the bows: the sun's disc, the spread of sizes and the supernumeraries. A
//! bound must hold for the table that is made, so light is kept for each of the eight combinations,
//! computed when it is first asked for. Flat drops move it by an angle that depends on the direction:
//! where they may be on, light is kept for several directions.

mod flat;
mod ring_light;

use std::cell::OnceCell;

use niji_airy::AiryTable;
use niji_radiometry::Water;
use niji_scatter::Theory;

use crate::effect::Effect;

use super::bow_light::BowLight;
use super::bow_light::LightRequest;
use super::bow_light::Line;
use super::curve::Curve;
use super::directed_curve::DirectedCurve;
use super::flat_drops::OF_SECONDARY;
use super::flat_drops::largest_shift_rad;
use super::higher_orders::orders_seen;

/// Diameter of the sun's disc, 0.533 degrees.
pub(super) const SUN_DISC_DIAMETER_RAD: f64 = 0.533 * std::f64::consts::PI / 180.0;

/// Orders that make the primary and the secondary bow, and how far flat drops move each over the
/// shift of the primary.
const BOWS: [(u32, f64); 2] = [(2, 1.0), (3, OF_SECONDARY)];

/// The first of the other orders that has a bow; flat drops move no light of those below.
const FIRST_HIGHER_BOW: u32 = 4;

/// Effects that shape the bows; the place of each is its bit in the number of a variant.
pub(super) const SHAPING: [Effect; 3] =
    [Effect::SunDisc, Effect::SizeSpread, Effect::Supernumeraries];

/// Number of a combination of the shaping effects.
pub(super) type Variant = usize;

/// The ways in which light may be shaped.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shapes {
    /// Combinations of the shaping effects.
    pub(super) variants: Vec<Variant>,
    /// Whether drops are flat; `None` where they may be.
    pub(super) flat: Option<bool>,
}

/// Bit of a shaping effect.
fn bit(effect: Effect) -> Variant {
    SHAPING
        .iter()
        .position(|shaping| *shaping == effect)
        .map_or(0, |place| 1 << place)
}

/// Combinations that agree with what is known: `None` where an effect may be on or off.
pub(super) fn variants(known: impl Fn(Effect) -> Option<bool>) -> Vec<Variant> {
    let agrees = |variant: Variant| {
        SHAPING
            .into_iter()
            .all(|effect| known(effect).is_none_or(|on| on == (variant & bit(effect) != 0)))
    };
    (0..1 << SHAPING.len())
        .filter(|variant| agrees(*variant))
        .collect()
}

/// What the curves are made from.
pub(super) struct CurvesRequest<'a> {
    pub(super) theory: Theory,
    pub(super) lines: &'a [Line],
    /// (effective radius (um), effective variance) of the drops that occur.
    pub(super) sizes: Vec<(f64, f64)>,
    /// Scattering angles in view of the drops; `None` where no drops are.
    pub(super) theta_rad: Option<(f64, f64)>,
    /// Smallest and largest m of rays that may meet drops, by which flat drops move the bow.
    pub(super) flattening: (f64, f64),
    /// Where light counts as the primary bow's from, rad.
    pub(super) split_rad: f64,
    pub(super) water: Water,
}

/// Both bows in flat drops, by m.
type FlatBows = Vec<(f64, Vec<BowLight>)>;

/// Light of every order in every variant.
pub(super) struct LightCurves<'a> {
    request: CurvesRequest<'a>,
    /// Orders besides those of the bows that are worth their time.
    higher_orders: Vec<u32>,
    airy: OnceCell<AiryTable>,
    bows: [OnceCell<Vec<BowLight>>; 1 << SHAPING.len()],
    higher: [OnceCell<Vec<BowLight>>; 1 << SHAPING.len()],
    flat: [OnceCell<FlatBows>; 1 << SHAPING.len()],
    /// Exact light near the antisolar point, and diffracted light near the sun.
    rings: [OnceCell<[BowLight; 2]>; 1 << SHAPING.len()],
}

impl<'a> LightCurves<'a> {
    pub(super) fn new(request: CurvesRequest<'a>) -> Self {
        let higher_orders = request
            .theta_rad
            .map(|range| orders_seen(range, request.water))
            .unwrap_or_default();
        Self {
            request,
            higher_orders,
            airy: OnceCell::new(),
            bows: std::array::from_fn(|_| OnceCell::new()),
            higher: std::array::from_fn(|_| OnceCell::new()),
            flat: std::array::from_fn(|_| OnceCell::new()),
            rings: std::array::from_fn(|_| OnceCell::new()),
        }
    }

    /// The orders besides those of the bows that a table holds; every order is in exact theories.
    pub(super) fn higher_orders(&self) -> &[u32] {
        &self.higher_orders
    }

    /// Light of both bows in a variant; empty where no drops are in view.
    fn bows(&self, variant: Variant) -> &[BowLight] {
        self.bows[variant].get_or_init(|| {
            if let Some(point) = without_disc(variant) {
                return seen_from_disc(self.bows(point));
            }
            let light = |(order, _)| self.light(order, variant);
            BOWS.into_iter().filter_map(light).collect()
        })
    }

    /// Light of the other orders in a variant: of those that flat drops do not move, of those that
    /// they do.
    fn higher(&self, variant: Variant) -> &[BowLight] {
        self.higher[variant].get_or_init(|| {
            if let Some(point) = without_disc(variant) {
                return seen_from_disc(self.higher(point));
            }
            let sum = |of_bows: bool| {
                let orders = self.higher_orders.iter();
                let orders = orders.filter(|order| (**order >= FIRST_HIGHER_BOW) == of_bows);
                let lights = orders.filter_map(|order| self.light(*order, variant));
                lights.reduce(|a, b| a.plus(&b))
            };
            // An empty light keeps the place of what still and what moves.
            [false, true]
                .map(|of_bows| sum(of_bows).unwrap_or_else(BowLight::empty))
                .into()
        })
    }

    /// Light of one order for a point sun; `None` where no drops are in view.
    fn light(&self, order: u32, variant: Variant) -> Option<BowLight> {
        Some(BowLight::new(&LightRequest {
            theory: if variant & bit(Effect::Supernumeraries) != 0 {
                self.request.theory
            } else {
                Theory::Geometric
            },
            order,
            lines: self.request.lines,
            sizes: &self.sizes(variant),
            theta_rad: self.angles_rad()?,
            water: self.request.water,
            airy: self.airy.get_or_init(AiryTable::compute),
        }))
    }

    /// Sizes of a variant.
    fn sizes(&self, variant: Variant) -> Vec<(f64, f64)> {
        let spread = variant & bit(Effect::SizeSpread) != 0;
        let sizes = self.request.sizes.iter();
        sizes
            .map(|(radius, variance)| (*radius, if spread { *variance } else { 0.0 }))
            .collect()
    }

    /// Angles in view, and those that the disc and flat drops bring into view.
    fn angles_rad(&self) -> Option<(f64, f64)> {
        let (low, high) = self.request.theta_rad?;
        let (down_rad, up_rad) = self.shifts_rad();
        let reach = SUN_DISC_DIAMETER_RAD;
        Some((
            (low - reach - up_rad).max(0.0),
            (high + reach - down_rad).min(std::f64::consts::PI),
        ))
    }

    /// Smallest and largest shift of the primary bow by flat drops, none among them.
    fn shifts_rad(&self) -> (f64, f64) {
        let largest_rad = largest_shift_rad(&self.request.sizes);
        let (low, high) = self.request.flattening;
        (low.min(0.0) * largest_rad, high.max(0.0) * largest_rad)
    }

    fn luminance(
        &self,
        place: usize,
        shape: (Variant, Option<bool>),
        factor: &[f64],
    ) -> DirectedCurve {
        let luminance = |bow: &BowLight| bow.luminance(self.request.lines, factor);
        self.of_bow(place, shape, luminance)
    }

    /// Light that a bow's effect stands for, largest over `shapes`: its own order everywhere, and on
    /// its side of the split all that the table holds besides. An order is in the table if its bow
    /// is on, and the renderer leaves out a side whose bow is off.
    pub(super) fn bow(&self, bow: Effect, factor: &[f64], shapes: &Shapes) -> DirectedCurve {
        let own = usize::from(bow != Effect::PrimaryBow);
        let is_own_side = |theta_rad: f64| (theta_rad >= self.request.split_rad) == (own == 0);
        largest(shapes, |variant| {
            let shape = (variant, shapes.flat);
            let other = self.luminance(1 - own, shape, factor).only(is_own_side);
            let bows = self.luminance(own, shape, factor).plus(&other);
            let rings = self.rings_of(bow, variant, factor);
            let bows = rings.into_iter().fold(bows, |sum, ring| sum.plus(&ring));
            if self.holds_every_order(variant) {
                let higher = self.higher_curve(variant, factor, shapes.flat);
                bows.plus(&higher.only(is_own_side))
            } else {
                bows
            }
        })
    }

    /// Light of the other orders, and, on the side of a bow that is not `shown` by itself, of that
    /// of the other bow, largest over `shapes`.
    pub(super) fn higher_light(
        &self,
        factor: &[f64],
        shapes: &Shapes,
        shown: [bool; 2],
    ) -> DirectedCurve {
        let is_hidden = |theta_rad: f64| !shown[usize::from(theta_rad < self.request.split_rad)];
        largest(shapes, |variant| {
            let shape = (variant, shapes.flat);
            let higher = self.higher_curve(variant, factor, shapes.flat);
            let rings = self.rings_of(Effect::HigherOrders, variant, factor);
            let higher = rings.into_iter().fold(higher, |sum, ring| sum.plus(&ring));
            let higher = if self.holds_every_order(variant) {
                higher.only(is_hidden)
            } else {
                higher
            };
            if shown == [true; 2] {
                return higher;
            }
            let bows = [0, 1].map(|place| self.luminance(place, shape, factor));
            higher.plus(&bows[0].plus(&bows[1]).only(is_hidden))
        })
    }

    /// The other orders; their bows are moved either way, none farther than the primary.
    fn higher_curve(&self, variant: Variant, factor: &[f64], flat: Option<bool>) -> DirectedCurve {
        let (low, high) = self.request.flattening;
        let reach_rad = low.abs().max(high.abs()) * largest_shift_rad(&self.request.sizes);
        let curves = self
            .higher(variant)
            .iter()
            .zip([false, flat != Some(false)]);
        let curves = curves.map(|(light, moves)| {
            let curve = light.luminance(self.request.lines, factor);
            if moves {
                curve.widened(reach_rad)
            } else {
                curve
            }
        });
        let sum = curves.reduce(|a, b| a.plus(&b));
        DirectedCurve::Round(sum.unwrap_or_else(Curve::empty))
    }

    /// Whether no way of shaping the light has separate orders to leave out.
    pub(super) fn is_whole(&self, shapes: &Shapes) -> bool {
        let mut variants = shapes.variants.iter();
        variants.all(|variant| self.holds_every_order(*variant))
    }

    /// Whether the theory of a variant has no separate orders to leave out.
    fn holds_every_order(&self, variant: Variant) -> bool {
        let fringes = variant & bit(Effect::Supernumeraries) != 0;
        fringes
            && match self.request.theory {
                Theory::Mie | Theory::BySize => true,
                Theory::GeometricPublished
                | Theory::Geometric
                | Theory::AiryPublished
                | Theory::Airy
                | Theory::Uniform
                | Theory::Debye { .. } => false,
            }
    }

    /// What a shaping effect changes, largest over `shapes`.
    pub(super) fn difference(
        &self,
        effect: Effect,
        factor: &[f64],
        shapes: &Shapes,
    ) -> DirectedCurve {
        let between = |with: &[BowLight], without: &[BowLight]| {
            let curves = with
                .iter()
                .zip(without)
                .map(|(with, without)| with.difference(without, self.request.lines, factor));
            curves
                .reduce(|a, b| a.plus(&b))
                .unwrap_or_else(Curve::empty)
        };
        largest(shapes, |variant| {
            let (with, without) = (variant | bit(effect), variant & !bit(effect));
            let round = || {
                let bows = between(self.bows(with), self.bows(without));
                DirectedCurve::Round(bows.plus(&self.ring_difference(with, without, factor)))
            };
            let flattened = || {
                let curves = self.flat(with).iter().zip(self.flat(without));
                let curves = curves.map(|((m, with), (_, without))| {
                    let curve = between(with, without);
                    (*m, curve.widened(self.between_nodes_rad()))
                });
                DirectedCurve::Flat(curves.collect())
            };
            match shapes.flat {
                Some(false) => round(),
                Some(true) => flattened(),
                None => flattened().or_larger(&round()),
            }
        })
    }
}

/// The largest of curves over the combinations of shaping effects.
fn largest(shapes: &Shapes, curve: impl Fn(Variant) -> DirectedCurve) -> DirectedCurve {
    let curves = shapes.variants.iter().map(|variant| curve(*variant));
    curves
        .reduce(|a, b| a.or_larger(&b))
        .unwrap_or_else(DirectedCurve::empty)
}

/// The combination without the sun's disc, if it is in one.
fn without_disc(variant: Variant) -> Option<Variant> {
    let disc = bit(Effect::SunDisc);
    (variant & disc != 0).then_some(variant & !disc)
}

fn seen_from_disc(lights: &[BowLight]) -> Vec<BowLight> {
    let lights = lights.iter();
    lights
        .map(|light| light.seen_from_disc(SUN_DISC_DIAMETER_RAD))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_agree_with_what_is_known() {
        assert_eq!(variants(|_| None).len(), 8);
        assert_eq!(variants(|_| Some(true)), [7]);
        assert_eq!(variants(|_| Some(false)), [0]);
        let disc_only = variants(|effect| (effect != Effect::SunDisc).then_some(false));
        assert_eq!(disc_only, [0, 1]);
    }
}
