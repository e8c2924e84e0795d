//! The light of both bows over the scattering angle, for every way in which it may be made.
//!
//! Three effects shape the bows: the sun's disc, the spread of sizes and the supernumeraries. A
//! bound must hold for the table that is made, so light is kept for each of the eight combinations,
//! computed when it is first asked for.

use std::cell::OnceCell;

use niji_airy::AiryTable;
use niji_scatter::Theory;

use crate::effect::Effect;

use super::bow_light::BowLight;
use super::bow_light::Curve;
use super::bow_light::LightRequest;
use super::bow_light::Line;

/// Diameter of the sun's disc, 0.533 degrees.
pub(super) const SUN_DISC_DIAMETER_RAD: f64 = 0.533 * std::f64::consts::PI / 180.0;

/// Orders that make the primary and the secondary bow.
const ORDERS: [u32; 2] = [2, 3];

/// Effects that shape the bows; the place of each is its bit in the number of a variant.
pub(super) const SHAPING: [Effect; 3] =
    [Effect::SunDisc, Effect::SizeSpread, Effect::Supernumeraries];

/// Number of a combination of the shaping effects.
pub(super) type Variant = usize;

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
    /// Where light counts as the primary bow's from, rad.
    pub(super) split_rad: f64,
    pub(super) temperature_c: f64,
}

/// Light of both orders in every variant.
pub(super) struct LightCurves<'a> {
    request: CurvesRequest<'a>,
    airy: OnceCell<AiryTable>,
    lights: [OnceCell<Vec<BowLight>>; 1 << SHAPING.len()],
}

impl<'a> LightCurves<'a> {
    pub(super) fn new(request: CurvesRequest<'a>) -> Self {
        let lights = std::array::from_fn(|_| OnceCell::new());
        Self {
            request,
            airy: OnceCell::new(),
            lights,
        }
    }

    /// Light of both orders in a variant; empty where no drops are in view.
    fn lights(&self, variant: Variant) -> &[BowLight] {
        self.lights[variant].get_or_init(|| self.compute(variant))
    }

    fn compute(&self, variant: Variant) -> Vec<BowLight> {
        let Some((low, high)) = self.request.theta_rad else {
            return Vec::new();
        };
        if variant & bit(Effect::SunDisc) != 0 {
            let point = self.lights(variant & !bit(Effect::SunDisc));
            return point
                .iter()
                .map(|light| light.seen_from_disc(SUN_DISC_DIAMETER_RAD))
                .collect();
        }
        let spread = variant & bit(Effect::SizeSpread) != 0;
        let fringes = variant & bit(Effect::Supernumeraries) != 0;
        let size =
            |(radius, variance): &(f64, f64)| (*radius, if spread { *variance } else { 0.0 });
        let sizes: Vec<(f64, f64)> = self.request.sizes.iter().map(size).collect();
        let reach = SUN_DISC_DIAMETER_RAD;
        let light = |order| {
            BowLight::new(&LightRequest {
                theory: if fringes {
                    self.request.theory
                } else {
                    Theory::Geometric
                },
                order,
                lines: self.request.lines,
                sizes: &sizes,
                theta_rad: (
                    (low - reach).max(0.0),
                    (high + reach).min(std::f64::consts::PI),
                ),
                temperature_c: self.request.temperature_c,
                airy: self.airy.get_or_init(AiryTable::compute),
            })
        };
        ORDERS.into_iter().map(light).collect()
    }

    /// Light that a bow's effect stands for, largest over `variants`: its own order everywhere, and
    /// on its side of the split the other order's too. An order is in the table if its bow is on,
    /// and the renderer leaves out a side whose bow is off.
    pub(super) fn bow(&self, bow: Effect, factor: &[f64], variants: &[Variant]) -> Curve {
        let (own, other) = if bow == Effect::PrimaryBow {
            (0, 1)
        } else {
            (1, 0)
        };
        let is_own_side = |theta_rad: f64| (theta_rad >= self.request.split_rad) == (own == 0);
        let curve = |variant: &Variant| {
            let lights = self.lights(*variant);
            let of = |order: usize| {
                lights
                    .get(order)
                    .map_or_else(Curve::empty, |l| l.luminance(self.request.lines, factor))
            };
            of(own).plus(&of(other).only(is_own_side))
        };
        variants
            .iter()
            .map(curve)
            .reduce(|a, b| a.or_larger(&b))
            .unwrap_or_else(Curve::empty)
    }

    /// What a shaping effect changes, largest over `variants`.
    pub(super) fn difference(&self, effect: Effect, factor: &[f64], variants: &[Variant]) -> Curve {
        let curve = |variant: &Variant| {
            let with = self.lights(variant | bit(effect));
            let without = self.lights(variant & !bit(effect));
            with.iter()
                .zip(without)
                .map(|(with, without)| with.difference(without, self.request.lines, factor))
                .reduce(|a, b| a.plus(&b))
                .unwrap_or_else(Curve::empty)
        };
        variants
            .iter()
            .map(curve)
            .reduce(|a, b| a.or_larger(&b))
            .unwrap_or_else(Curve::empty)
    }
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
