//! The light of all orders over the scattering angle, for every way in which it may be made.
//!
//! Three effects shape the bows: the sun's disc, the spread of sizes and the supernumeraries. A
//! bound must hold for the table that is made, so light is known for each of their combinations,
//! computed when it is first asked for. Flat drops move it by an angle that depends on the direction:
//! where they may be on, light is known for several directions.

mod ring_light;

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::ops::Range;
use std::rc::Rc;

use ndarray::s;
use niji_radiometry::Water;
use niji_scatter::DiscAverage;
use niji_scatter::DropLight;
use niji_scatter::Light;
use niji_scatter::LightRequest;
use niji_scatter::Rings;
use niji_scatter::Theory;

use crate::effect::Effect;
use crate::effect::Role;

use super::cache::Cache;
use super::curve::Curve;
use super::curve::STEP_RAD;
use super::directed_curve::DirectedCurve;
use super::directed_curve::nodes;
use super::flat_drops::BOWS;
use super::flat_drops::FlatDrops;
use super::flat_drops::Kernel;
use super::flat_drops::moved;
use super::higher_orders::orders_seen;
use super::luminance::Line;
use super::luminance::Luminance;
use super::theory_by_size::table_theory;

/// Diameter of the sun's disc, 0.533 degrees.
pub(super) const SUN_DISC_DIAMETER_RAD: f64 = 0.533 * PI / 180.0;

/// Of radii that a volume holds as f32.
const ROUNDOFF: f64 = 1e-5;

/// The first of the other orders that has a bow; flat drops move no light of those below.
const FIRST_HIGHER_BOW: u32 = 4;

/// Those of the shaping effects that are on.
pub(super) type Shaping = BTreeSet<Effect>;

/// The ways in which light may be shaped.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shapes {
    /// Combinations of the shaping effects.
    pub(super) shapings: Vec<Shaping>,
    /// Whether drops are flat; `None` where they may be.
    pub(super) flat: Option<bool>,
}

/// Combinations that agree with what is known: `None` where an effect may be on or off.
pub(super) fn shapings(known: impl Fn(Effect) -> Option<bool>) -> Vec<Shaping> {
    let mut all = vec![Shaping::new()];
    for effect in Effect::of_role(Role::Shape) {
        let with = all.iter().map(|shaping| with(shaping, effect)).collect();
        match known(effect) {
            Some(true) => all = with,
            Some(false) => (),
            None => all.extend::<Vec<Shaping>>(with),
        }
    }
    all
}

fn with(shaping: &Shaping, effect: Effect) -> Shaping {
    shaping.iter().copied().chain([effect]).collect()
}

fn without(shaping: &Shaping, effect: Effect) -> Shaping {
    let others = shaping.iter().copied();
    others.filter(|other| *other != effect).collect()
}

/// What the curves are made from.
pub(super) struct CurvesRequest<'a> {
    pub(super) theory: Theory,
    pub(super) lines: &'a [Line],
    /// (effective radius (um), effective variance) of the drops that occur.
    pub(super) sizes: Vec<(f64, f64)>,
    /// Smaller drops have too little light for their glory to be seen (um).
    pub(super) smallest_um: f64,
    /// Scattering angles in view of the drops; `None` where no drops are.
    pub(super) theta_rad: Option<(f64, f64)>,
    /// How flat drops move bows.
    pub(super) flat: FlatDrops,
    /// Smallest and largest rise of rays that may meet drops.
    pub(super) rise: (f64, f64),
    /// Where light counts as the primary bow's from, rad.
    pub(super) split_rad: f64,
    pub(super) water: Water,
}

/// Some of the light of the drops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Order(u32),
    /// Exact light near the antisolar point.
    Glory,
    /// Diffracted light near the sun.
    Corona,
}

/// A luminance: of which light, how it is shaped, at which node of the rise if drops are flat, and with
/// which factor for each line (bits of it).
type Seen = (Source, Shaping, Option<i32>, Vec<u64>);

/// Light of every order in every shape.
pub(super) struct LightCurves<'a> {
    request: CurvesRequest<'a>,
    /// Orders besides those of the bows that are worth their time.
    higher_orders: Vec<u32>,
    /// Around the angles in view, and those that the disc and flat drops bring into view; none without drops.
    rings: Rings,
    /// Nodes of the rise that are seen.
    nodes: Vec<i32>,
    disc: OnceCell<DiscAverage>,
    /// By name of the theory.
    drops: Cache<&'static str, DropLight>,
    lights: Cache<(Source, &'static str), Light>,
    luminances: Cache<Seen, Luminance>,
    /// How light moves, law by law: of which bow, at which node, from which of the laws on.
    kernels: Cache<(usize, i32, usize), Vec<Kernel>>,
}

impl<'a> LightCurves<'a> {
    pub(super) fn new(request: CurvesRequest<'a>) -> Self {
        let nodes: Vec<i32> = nodes(request.rise).collect();
        let (down_rad, up_rad) = request.flat.range_rad(&request.sizes, &nodes);
        let reach = SUN_DISC_DIAMETER_RAD;
        let seen = request.theta_rad.map(|(low, high)| {
            let first = (low - reach - up_rad).max(0.0);
            Rings::around((first, (high + reach - down_rad).min(PI)), STEP_RAD)
        });
        let none = Rings {
            first_rad: 0.0,
            step_rad: STEP_RAD,
            n: 0,
        };
        let orders = |range| orders_seen(range, request.water);
        Self {
            higher_orders: request.theta_rad.map(orders).unwrap_or_default(),
            rings: seen.unwrap_or(none),
            nodes,
            request,
            disc: OnceCell::new(),
            drops: Cache::new(),
            lights: Cache::new(),
            luminances: Cache::new(),
            kernels: Cache::new(),
        }
    }

    /// The orders besides those of the bows that a table holds; every order is in exact theories.
    pub(super) fn higher_orders(&self) -> &[u32] {
        &self.higher_orders
    }

    /// The drops in a theory: of all laws, and then without their spread.
    fn drops(&self, shaping: &Shaping) -> Rc<DropLight> {
        let theory = self.theory(shaping);
        self.drops.of(&theory.name(), || {
            let sizes = &self.request.sizes;
            let single = sizes.iter().map(|(radius_um, _)| (*radius_um, 0.0));
            DropLight::new(LightRequest {
                theory,
                laws: sizes.iter().copied().chain(single).collect(),
                bands: self.request.lines.iter().map(|line| line.band).collect(),
                rings: self.rings,
                water: self.request.water,
            })
        })
    }

    /// Places of a shape's laws among those of the drops.
    fn places(&self, shaping: &Shaping) -> Range<usize> {
        let n = self.request.sizes.len();
        if shaping.contains(&Effect::SizeSpread) {
            0..n
        } else {
            n..2 * n
        }
    }

    /// The theory of a shape: without fringes all light is rays.
    fn theory(&self, shaping: &Shaping) -> Theory {
        table_theory(self.request.theory, shaping)
    }

    fn luminance(&self, seen: &Seen) -> Rc<Luminance> {
        let (source, shaping, node, factor) = seen;
        let round = |shaping: &Shaping| {
            let round = (*source, shaping.clone(), None, factor.clone());
            self.luminance(&round)
        };
        self.luminances.of(seen, || {
            if let (Some(node), Source::Order(order)) = (node, source) {
                return self.moved(*order, *node, (shaping, &round(shaping)));
            }
            if shaping.contains(&Effect::SunDisc) {
                let disc = || self.rings.seen_from_disc(SUN_DISC_DIAMETER_RAD);
                let disc = self.disc.get_or_init(disc);
                return round(&without(shaping, Effect::SunDisc)).seen_from_disc(disc);
            }
            let theory = self.theory(shaping);
            let light = self.lights.of(&(*source, theory.name()), || {
                let drops = self.drops(shaping);
                match source {
                    Source::Order(order) => drops.of_order(*order),
                    Source::Glory => drops.glory(),
                    Source::Corona => drops.corona(),
                }
            });
            let lines = self.request.lines.iter().zip(factor);
            let weight = |(line, factor): (&Line, &u64)| line.weight * f64::from_bits(*factor);
            let weights: Vec<f64> = lines.map(weight).collect();
            let mut luminance =
                Luminance::new(&light.slice(s![self.places(shaping), .., ..]), &weights);
            if *source == Source::Glory {
                for ((radius_um, _), row) in self.request.sizes.iter().zip(&mut luminance.rows) {
                    if *radius_um < (1.0 - ROUNDOFF) * self.request.smallest_um {
                        row.fill(0.0);
                    }
                }
            }
            luminance
        })
    }

    /// The light of a bow where flat drops move it.
    fn moved(&self, order: u32, node: i32, (shaping, round): (&Shaping, &Luminance)) -> Luminance {
        let bow = usize::from(order != BOWS[0]);
        let spread = f64::from(u8::from(shaping.contains(&Effect::SizeSpread)));
        let kernels = self
            .kernels
            .of(&(bow, node, self.places(shaping).start), || {
                let laws = self.request.sizes.iter();
                let kernel = |(radius_um, variance): &(f64, f64)| {
                    self.request
                        .flat
                        .kernel(bow, node, (*radius_um, spread * variance))
                };
                laws.map(kernel).collect()
            });
        let rows = kernels.iter().zip(&round.rows);
        Luminance {
            rows: rows.map(|(kernel, row)| moved(row, kernel)).collect(),
        }
    }

    fn largest(&self, luminance: &Luminance) -> Curve {
        luminance.largest(self.rings.first_rad + 0.5 * STEP_RAD)
    }

    /// Largest difference of two luminances.
    fn apart(&self, one: &Luminance, other: &Luminance) -> Curve {
        self.largest(&one.zip(other, |a, b| (a - b).abs()))
    }

    /// A curve of one bow by node of the rise, `None` for round drops.
    fn directed(
        &self,
        bow: usize,
        flat: Option<bool>,
        curve: impl Fn(Option<i32>) -> Curve,
    ) -> DirectedCurve {
        let round = || DirectedCurve::Round(curve(None));
        let flattened = || {
            let at = |node: &i32| {
                let (flat, sizes) = (&self.request.flat, &self.request.sizes);
                let reach_rad = flat.between_nodes_rad(bow, *node, sizes);
                (*node, curve(Some(*node)).widened(reach_rad))
            };
            DirectedCurve::Flat(self.nodes.iter().map(at).collect())
        };
        match flat {
            Some(false) => round(),
            Some(true) => flattened(),
            None => flattened().or_larger(&round()),
        }
    }

    fn of_bow(
        &self,
        bow: usize,
        (shaping, flat): (&Shaping, Option<bool>),
        factor: &[u64],
    ) -> DirectedCurve {
        let order = Source::Order(BOWS[bow]);
        self.directed(bow, flat, |node| {
            self.largest(&self.luminance(&(order, shaping.clone(), node, factor.into())))
        })
    }

    /// Light that a bow's effect stands for, largest over `shapes`: its own order everywhere, and on
    /// its side of the split all that the table holds besides. An order is in the table if its bow
    /// is on, and the renderer leaves out a side whose bow is off.
    pub(super) fn bow(&self, bow: Effect, factor: &[f64], shapes: &Shapes) -> DirectedCurve {
        let factor = bits(factor);
        let own = usize::from(bow != Effect::PrimaryBow);
        let is_own_side = |theta_rad: f64| (theta_rad >= self.request.split_rad) == (own == 0);
        largest(shapes, |shaping| {
            let shape = (shaping, shapes.flat);
            let other = self.of_bow(1 - own, shape, &factor).only(is_own_side);
            let bows = self.of_bow(own, shape, &factor).plus(&other);
            let bows = bows.plus(&self.rings_of(bow, shaping, &factor));
            if self.theory(shaping).holds_every_order() {
                let higher = self.higher_curve(shape, &factor);
                bows.plus(&higher.only(is_own_side))
            } else {
                bows
            }
        })
    }

    /// Light of the other orders, and, on the side of a bow that is not `shown` by itself, that of both
    /// bows, largest over `shapes`. What a table holds whatever is asked for is new on such a side only.
    pub(super) fn higher_light(
        &self,
        factor: &[f64],
        shapes: &Shapes,
        shown: [bool; 2],
    ) -> DirectedCurve {
        let factor = bits(factor);
        let is_hidden = |theta_rad: f64| !shown[usize::from(theta_rad < self.request.split_rad)];
        largest(shapes, |shaping| {
            let (shape, theory) = ((shaping, shapes.flat), self.theory(shaping));
            let added = |light: DirectedCurve, is_held: bool| {
                if is_held {
                    light.only(is_hidden)
                } else {
                    light
                }
            };
            let orders = self.higher_curve(shape, &factor);
            let orders = added(orders, theory.ignores_orders());
            let rings = self.rings_of(Effect::HigherOrders, shaping, &factor);
            let higher = orders.plus(&added(rings, theory.holds_every_order()));
            if shown == [true; 2] {
                return higher;
            }
            let bows = [0, 1].map(|bow| self.of_bow(bow, shape, &factor));
            higher.plus(&bows[0].plus(&bows[1]).only(is_hidden))
        })
    }

    /// The other orders; their bows are moved either way, none farther than the two.
    fn higher_curve(
        &self,
        (shaping, flat): (&Shaping, Option<bool>),
        factor: &[u64],
    ) -> DirectedCurve {
        let sum = |orders: &mut dyn Iterator<Item = u32>| {
            let lights = orders
                .map(|order| {
                    self.luminance(&(Source::Order(order), shaping.clone(), None, factor.into()))
                })
                .reduce(|a, b| Rc::new(a.plus(&b)));
            lights.map_or_else(Curve::empty, |light| self.largest(&light))
        };
        let orders = || self.higher_orders.iter().copied();
        let still = sum(&mut orders().filter(|order| *order < FIRST_HIGHER_BOW));
        let moving = sum(&mut orders().filter(|order| *order >= FIRST_HIGHER_BOW));
        let (down_rad, up_rad) = if flat == Some(false) {
            (0.0, 0.0)
        } else {
            self.request
                .flat
                .range_rad(&self.request.sizes, &self.nodes)
        };
        let moving = moving.widened(up_rad.max(-down_rad));
        DirectedCurve::Round(still.plus(&moving))
    }

    /// Whether no way of shaping the light has separate orders to leave out.
    pub(super) fn is_whole(&self, shapes: &Shapes) -> bool {
        let mut shapings = shapes.shapings.iter();
        shapings.all(|shaping| self.theory(shaping).ignores_orders())
    }

    /// What a shaping effect changes, largest over `shapes`.
    pub(super) fn difference(
        &self,
        effect: Effect,
        factor: &[f64],
        shapes: &Shapes,
    ) -> DirectedCurve {
        let factor = bits(factor);
        largest(shapes, |shaping| {
            let both = [with(shaping, effect), without(shaping, effect)];
            let change = |bow: usize| {
                self.directed(bow, shapes.flat, |node| {
                    let order = Source::Order(BOWS[bow]);
                    let [with, without] = both.each_ref().map(|shaping| {
                        self.luminance(&(order, shaping.clone(), node, factor.clone()))
                    });
                    self.apart(&with, &without)
                })
            };
            let [with, without] = &both;
            let rings = self.ring_difference((with, without), &factor);
            change(0)
                .plus(&change(1))
                .plus(&DirectedCurve::Round(rings))
        })
    }

    /// What flat drops change, largest over `shapes`.
    pub(super) fn flattening(&self, factor: &[f64], shapes: &Shapes) -> DirectedCurve {
        let factor = bits(factor);
        largest(shapes, |shaping| {
            let change = |bow: usize| {
                let order = Source::Order(BOWS[bow]);
                let seen = |node| self.luminance(&(order, shaping.clone(), node, factor.clone()));
                self.directed(bow, Some(true), |node| self.apart(&seen(node), &seen(None)))
            };
            change(0).plus(&change(1))
        })
    }
}

/// The largest of curves over the combinations of shaping effects.
fn largest(shapes: &Shapes, curve: impl Fn(&Shaping) -> DirectedCurve) -> DirectedCurve {
    let curves = shapes.shapings.iter().map(curve);
    curves
        .reduce(|a, b| a.or_larger(&b))
        .unwrap_or_else(DirectedCurve::empty)
}

/// Numbers as a key.
fn bits(factor: &[f64]) -> Vec<u64> {
    factor.iter().map(|factor| factor.to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapings_agree_with_what_is_known() {
        let all = shapings(|_| None);
        assert_eq!(all.len(), 8);
        assert!(all.iter().collect::<BTreeSet<_>>().len() == 8);
        assert_eq!(
            shapings(|_| Some(true)),
            [Effect::of_role(Role::Shape).collect()]
        );
        assert_eq!(shapings(|_| Some(false)), [Shaping::new()]);
        let disc_only = shapings(|effect| (effect != Effect::SunDisc).then_some(false));
        assert_eq!(
            disc_only,
            [Shaping::new(), Shaping::from([Effect::SunDisc])]
        );
    }

    #[test]
    fn an_effect_is_added_once_and_taken_away() {
        let all: Shaping = Effect::of_role(Role::Shape).collect();
        assert_eq!(with(&all, Effect::SunDisc), all);
        let less = without(&all, Effect::SunDisc);
        assert!(!less.contains(&Effect::SunDisc) && with(&less, Effect::SunDisc) == all);
    }
}
