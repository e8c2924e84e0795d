//! The light of glory and corona, for the sizes in view.

use niji_scatter::Theory;

use super::LightCurves;
use super::SUN_DISC_DIAMETER_RAD;
use super::Shapes;
use super::Variant;
use super::bit;
use super::largest;
use super::without_disc;
use crate::effect::Effect;
use crate::plan::bow_light::BowLight;
use crate::plan::curve::Curve;
use crate::plan::directed_curve::DirectedCurve;
use crate::plan::rings::CORONA_RAD;
use crate::plan::rings::GLORY_RAD;
use crate::plan::rings::diffracted;
use crate::plan::rings::exact_glory;

/// Places of the two in a pair of lights.
const GLORY: usize = 0;
const CORONA: usize = 1;

impl LightCurves<'_> {
    /// What a theory without a ring misses, largest over `shapes`.
    pub(in crate::plan) fn ring(
        &self,
        effect: Effect,
        factor: &[f64],
        shapes: &Shapes,
    ) -> DirectedCurve {
        largest(shapes, |variant| {
            DirectedCurve::Round(if effect == Effect::Glory {
                self.glory(variant, factor)
            } else {
                self.corona(variant, factor)
            })
        })
    }

    /// The rings that belong to the light of an effect in the theory of a variant.
    pub(super) fn rings_of(
        &self,
        effect: Effect,
        variant: Variant,
        factor: &[f64],
    ) -> Vec<DirectedCurve> {
        if variant & bit(Effect::Supernumeraries) == 0 {
            return Vec::new();
        }
        let of_primary = effect == Effect::PrimaryBow;
        let of_others = effect == Effect::HigherOrders;
        // The exact light is divided by its side: that of the secondary reaches to the sun.
        let [has_glory, has_corona] = match self.request.theory {
            Theory::Mie | Theory::BySize => [of_primary || of_others, !of_primary],
            Theory::Debye { .. } => [of_primary, of_others],
            Theory::GeometricPublished
            | Theory::Geometric
            | Theory::AiryPublished
            | Theory::Airy
            | Theory::Uniform => [false; 2],
        };
        let glory = has_glory.then(|| self.glory(variant, factor));
        let corona = has_corona.then(|| self.corona(variant, factor));
        let rings = glory.into_iter().chain(corona);
        rings.map(DirectedCurve::Round).collect()
    }

    /// What the rings of a variant are beyond those of another; empty in theories without.
    pub(super) fn ring_difference(&self, with: Variant, without: Variant, factor: &[f64]) -> Curve {
        let has_rings = |variant: Variant| {
            variant & bit(Effect::Supernumeraries) != 0 && self.request.theory.computes_drops()
        };
        if !has_rings(with) {
            return Curve::empty();
        }
        if !has_rings(without) {
            return self.glory(with, factor).plus(&self.corona(with, factor));
        }
        let lines = self.request.lines;
        let pairs = self.rings(with).iter().zip(self.rings(without));
        let curves = pairs.map(|(with, without)| with.difference(without, lines, factor));
        curves.fold(Curve::empty(), |sum, curve| sum.plus(&curve))
    }

    /// Difference of the exact light to that of all orders near the antisolar point.
    fn glory(&self, variant: Variant, factor: &[f64]) -> Curve {
        let lines = self.request.lines;
        let orders = self.bows(variant).iter().chain(self.higher(variant));
        let filled = orders.filter(|light| !light.is_empty()).cloned();
        let Some(orders) = filled.reduce(|a, b| a.plus(&b)) else {
            return Curve::empty();
        };
        let exact = &self.rings(variant)[GLORY];
        let curve = exact.difference(&orders, lines, factor);
        // Sizes without visible rings have no exact light, and miss nothing.
        let seen = exact.luminance(lines, factor);
        let values = curve.values.iter().zip(&seen.values);
        let values = values.map(|(missed, light)| if *light > 0.0 { *missed } else { 0.0 });
        let curve = Curve {
            values: values.collect(),
            ..curve
        };
        curve.only(|theta_rad| theta_rad >= GLORY_RAD)
    }

    /// Diffracted light near the sun.
    fn corona(&self, variant: Variant, factor: &[f64]) -> Curve {
        let light = &self.rings(variant)[CORONA];
        light.luminance(self.request.lines, factor)
    }

    fn rings(&self, variant: Variant) -> &[BowLight; 2] {
        self.rings[variant].get_or_init(|| {
            if let Some(point) = without_disc(variant) {
                let rings = self.rings(point).each_ref();
                return rings.map(|light| light.seen_from_disc(SUN_DISC_DIAMETER_RAD));
            }
            let Some(range) = self.angles_rad() else {
                return [BowLight::empty(), BowLight::empty()];
            };
            let sizes = self.sizes(variant);
            let (lines, water) = (self.request.lines, self.request.water);
            let glory = BowLight::of_rows(range, (&sizes, lines), |size, line, theta_rad| {
                exact_glory(size, line, water, theta_rad)
            });
            let corona = BowLight::of_rows(range, (&sizes, lines), |size, line, theta_rad| {
                let light = |theta: &f64| {
                    if *theta <= CORONA_RAD {
                        diffracted(size.0, line, *theta)
                    } else {
                        0.0
                    }
                };
                theta_rad.iter().map(light).collect()
            });
            [glory, corona]
        })
    }
}
