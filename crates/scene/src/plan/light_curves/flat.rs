//! The light of both bows in flat drops, by direction of flattening m, and how many directions a
//! table needs.

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
use crate::plan::flat_drops::bend;
use crate::plan::flat_drops::classes;
use crate::plan::flat_drops::moved;
use crate::plan::flat_drops::shift_rad;

/// Nodes of m at most: 33 double steps.
const MOST_FLATTENINGS: usize = 65;

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

    /// Nodes of m over a range that keep the error of linear interpolation below `relative_error`
    /// of the brightest bow, [`MOST_FLATTENINGS`] at most.
    pub(in crate::plan) fn n_flattenings(
        &self,
        (low, high): (f64, f64),
        relative_error: f64,
        variant: Variant,
    ) -> usize {
        let factor = vec![1.0; self.request.lines.len()];
        let classes = self.classes(variant);
        let bows = self.bows(variant).iter().zip(BOWS);
        let rows: Vec<(Vec<Vec<f64>>, f64)> = bows
            .map(|(light, (_, of_primary))| {
                let rows = light.luminance_by_size(self.request.lines, &factor);
                (rows, of_primary)
            })
            .collect();
        let largest = |row: &[f64]| row.iter().copied().fold(0.0, f64::max);
        let is_enough = |n: usize| {
            let half_step = 0.5 * (high - low) / (n as f64 - 1.0);
            let bends_little = |row: &[f64], classes: &Classes, of_primary: f64| {
                // The first step, the middle one and the last.
                let middles = [low + half_step, 0.5 * (low + high), high - half_step];
                middles.into_iter().all(|m| {
                    let steps = (of_primary * m, of_primary * half_step);
                    largest(&bend(row, classes, steps)) <= relative_error * largest(row)
                })
            };
            rows.iter().all(|(rows, of_primary)| {
                let sizes = rows.iter().zip(&classes);
                sizes
                    .into_iter()
                    .all(|(row, classes)| bends_little(row, classes, *of_primary))
            })
        };
        let mut n = 3;
        while n < MOST_FLATTENINGS && !is_enough(n) {
            n = 2 * n - 1;
        }
        n
    }
}
