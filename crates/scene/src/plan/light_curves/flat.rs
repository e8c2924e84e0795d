//! The light of both bows in flat drops, by direction of flattening m.

use crate::effect::Effect;

use super::BOWS;
use super::FlatBows;
use super::LightCurves;
use super::Shapes;
use super::Variant;
use super::bit;
use super::largest;
use crate::plan::bow_light::BowLight;
use crate::plan::curve::Curve;
use crate::plan::directed_curve::DirectedCurve;
use crate::plan::directed_curve::HALF_STEP;
use crate::plan::directed_curve::nodes;
use crate::plan::flat_drops::Classes;
use crate::plan::flat_drops::classes;
use crate::plan::flat_drops::moved;
use crate::plan::flat_drops::shift_rad;

impl LightCurves<'_> {
    /// The bows of a variant in flat drops, for each direction of flattening that is seen.
    pub(super) fn flat(&self, variant: Variant) -> &FlatBows {
        self.flat[variant].get_or_init(|| {
            let classes = self.classes(variant);
            let at = |m: f64| {
                let bows = self.bows(variant).iter().zip(BOWS);
                let bows = bows.map(|(light, (_, of_primary))| {
                    light.map_rows(|size, row| moved(row, &classes[size], of_primary * m))
                });
                (m, bows.collect())
            };
            nodes(self.request.flattening).map(at).collect()
        })
    }

    fn classes(&self, variant: Variant) -> Vec<Classes> {
        let spread = variant & bit(Effect::SizeSpread) != 0;
        let law = |(radius_um, variance): &(f64, f64)| {
            classes((*radius_um, if spread { *variance } else { 0.0 }))
        };
        self.request.sizes.iter().map(law).collect()
    }

    /// How far light moves between a direction of flattening that is looked at and one that is not.
    pub(super) fn between_nodes_rad(&self) -> f64 {
        let shifts = self.request.sizes.iter().map(|size| shift_rad(size.0));
        HALF_STEP * shifts.fold(0.0, f64::max)
    }

    /// A curve made from one of the bows, which may be seen round, flat or both.
    pub(super) fn of_bow(
        &self,
        place: usize,
        (variant, flat): (Variant, Option<bool>),
        curve: impl Fn(&BowLight) -> Curve,
    ) -> DirectedCurve {
        let of = |bows: &[BowLight]| bows.get(place).map_or_else(Curve::empty, &curve);
        let round = || DirectedCurve::Round(of(self.bows(variant)));
        let flattened = || {
            let reach_rad = self.between_nodes_rad() * BOWS[place].1.abs();
            let curves = self.flat(variant).iter();
            let curves = curves.map(|(m, bows)| (*m, of(bows).widened(reach_rad)));
            DirectedCurve::Flat(curves.collect())
        };
        match flat {
            Some(false) => round(),
            Some(true) => flattened(),
            None => flattened().or_larger(&round()),
        }
    }

    /// What flat drops change, largest over `shapes`.
    pub(in crate::plan) fn flattening(&self, factor: &[f64], shapes: &Shapes) -> DirectedCurve {
        largest(shapes, |variant| {
            let change = |place: usize| {
                let change = |flat: &BowLight| {
                    let round = self.bows(variant).get(place);
                    round.map_or_else(Curve::empty, |round| {
                        flat.difference(round, self.request.lines, factor)
                    })
                };
                self.of_bow(place, (variant, Some(true)), change)
            };
            change(0).plus(&change(1))
        })
    }
}
