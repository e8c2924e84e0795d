//! The light of glory and corona, for the sizes in view.

use super::BOWS;
use super::LightCurves;
use super::SUN_DISC_DIAMETER_RAD;
use super::Shapes;
use super::Shaping;
use super::Source;
use super::bits;
use super::largest;
use crate::effect::Effect;
use crate::plan::curve::Curve;
use crate::plan::directed_curve::DirectedCurve;
use niji_scatter::GLORY_START_RAD;

impl LightCurves<'_> {
    /// What a theory without a ring misses, largest over `shapes`.
    pub(in crate::plan) fn ring(
        &self,
        effect: Effect,
        factor: &[f64],
        shapes: &Shapes,
    ) -> DirectedCurve {
        let factor = bits(factor);
        largest(shapes, |shaping| {
            DirectedCurve::Round(if effect == Effect::Glory {
                self.glory(shaping, &factor)
            } else {
                self.corona(shaping, &factor)
            })
        })
    }

    /// The rings that belong to the light of an effect in the theory of a shape.
    pub(super) fn rings_of(
        &self,
        effect: Effect,
        shaping: &Shaping,
        factor: &[u64],
    ) -> DirectedCurve {
        let theory = self.theory(shaping);
        let of_primary = effect == Effect::PrimaryBow;
        let of_others = effect == Effect::HigherOrders;
        // Light without orders is divided by its side: that of the secondary reaches to the sun.
        let [has_glory, has_corona] = if theory.holds_every_order() {
            [of_primary || of_others, !of_primary]
        } else {
            [of_primary, of_others].map(|carries| carries && theory.is_exact())
        };
        let glory = has_glory.then(|| self.glory(shaping, factor));
        let corona = has_corona.then(|| self.corona(shaping, factor));
        let rings = glory.into_iter().chain(corona);
        DirectedCurve::Round(rings.fold(Curve::empty(), |sum, ring| sum.plus(&ring)))
    }

    /// What the rings of a shape are beyond those of another; empty in theories without.
    pub(super) fn ring_difference(
        &self,
        (with, without): (&Shaping, &Shaping),
        factor: &[u64],
    ) -> Curve {
        let [is_with, is_without] = [with, without].map(|shaping| self.theory(shaping).is_exact());
        if !is_with {
            return Curve::empty();
        }
        if !is_without {
            return self.glory(with, factor).plus(&self.corona(with, factor));
        }
        let curves = [Source::Glory, Source::Corona].map(|ring| {
            let [with, without] = [with, without]
                .map(|shaping| self.luminance(&(ring, shaping.clone(), None, factor.into())));
            self.apart(&with, &without)
        });
        curves[0].plus(&curves[1])
    }

    /// Difference of the exact light to that of all orders near the antisolar point.
    fn glory(&self, shaping: &Shaping, factor: &[u64]) -> Curve {
        let seen = |source| self.luminance(&(source, shaping.clone(), None, factor.into()));
        let orders = BOWS.iter().chain(&self.higher_orders);
        let orders = orders.map(|order| seen(Source::Order(*order)));
        let Some(orders) = orders.reduce(|a, b| a.plus(&b).into()) else {
            return Curve::empty();
        };
        // Sizes without visible rings have no exact light, and miss nothing.
        let missed = |exact: f64, orders: f64| {
            if exact > 0.0 {
                (exact - orders).abs()
            } else {
                0.0
            }
        };
        let curve = self.largest(&seen(Source::Glory).zip(&orders, missed));
        // The disc blurs where the exact light begins.
        curve.only(|theta_rad| theta_rad >= GLORY_START_RAD + SUN_DISC_DIAMETER_RAD)
    }

    /// Diffracted light near the sun.
    fn corona(&self, shaping: &Shaping, factor: &[u64]) -> Curve {
        self.largest(&self.luminance(&(Source::Corona, shaping.clone(), None, factor.into())))
    }
}
