//! How the cross-section of a volume is shared out over laws of size.
//!
//! Nodes whose effective radii lie within a factor of 2^(1/4), and whose effective variances lie within a
//! factor of 2^(1/2), are one entry, which keeps the ends of what it holds.

use std::collections::BTreeMap;

use crate::AreaMoments;
use crate::DropMode;

/// Entries for a factor of 2 in radius and in variance.
const RADII_PER_OCTAVE: f64 = 4.0;
const VARIANCES_PER_OCTAVE: f64 = 2.0;
/// Below it sizes are one: f32 moments of one size vary by 1e-6.
const ONE_SIZE: f64 = 1e-5;

/// Drops of about the same law of size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawShare {
    /// Smallest and largest effective radius (um).
    pub effective_radius_um: (f64, f64),
    /// Smallest and largest effective variance.
    pub effective_variance: (f64, f64),
    /// Their part of all cross-sections.
    pub share: f64,
}

impl DropMode {
    /// The laws of its nodes with their shares of the cross-section, which sum to 1; none without drops.
    pub fn law_shares(&self) -> Vec<LawShare> {
        let mut laws: BTreeMap<(i32, i32), LawShare> = BTreeMap::new();
        for (_, drops) in self.nodes() {
            let radius_um = 1e6 * f64::from(drops.effective_radius_m);
            let variance = f64::from(drops.effective_variance);
            let of_radius = (RADII_PER_OCTAVE * radius_um.log2()).floor() as i32;
            let of_variance = (VARIANCES_PER_OCTAVE * variance.max(ONE_SIZE).log2()).floor() as i32;
            let here = LawShare {
                effective_radius_um: (radius_um, radius_um),
                effective_variance: (variance, variance),
                share: AreaMoments::from_drops(&drops).extinction_m1_q1(),
            };
            let law = laws.entry((of_radius, of_variance));
            law.and_modify(|law| *law = law.with(here)).or_insert(here);
        }
        let total: f64 = laws.values().map(|law| law.share).sum();
        let shared = |law: LawShare| LawShare {
            share: law.share / total,
            ..law
        };
        laws.into_values().map(shared).collect()
    }
}

impl LawShare {
    fn with(self, other: Self) -> Self {
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        Self {
            effective_radius_um: wider(self.effective_radius_um, other.effective_radius_um),
            effective_variance: wider(self.effective_variance, other.effective_variance),
            share: self.share + other.share,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Drops;
    use crate::GridBox;

    fn box_of(drops: impl Fn(DVec3) -> Drops + Sync) -> DropMode {
        let grid = GridBox {
            min: DVec3::ZERO,
            max: DVec3::new(8.0, 4.0, 4.0),
            voxel_m: 1.0,
        };
        DropMode::from_fn("", &grid, drops).unwrap()
    }

    #[test]
    fn a_share_is_that_of_the_cross_section() {
        // Equal numbers of drops, one half twice as large: four times the area.
        let mode = box_of(|place| Drops {
            number_density_m3: 100.0,
            effective_radius_m: if place.x < 4.0 { 1e-4 } else { 2e-4 },
            effective_variance: 0.0,
        });
        let laws = mode.law_shares();
        assert_eq!(laws.len(), 2);
        assert!((laws[0].share - 0.2).abs() < 1e-6 && (laws[1].share - 0.8).abs() < 1e-6);
    }

    #[test]
    fn every_law_lies_between_the_ends_of_its_entry() {
        let mode = box_of(|place| Drops {
            number_density_m3: 100.0,
            effective_radius_m: (1e-4 * (1.0 + 0.3 * place.x)) as f32,
            effective_variance: (0.01 * place.y) as f32,
        });
        let laws = mode.law_shares();
        assert!((laws.iter().map(|law| law.share).sum::<f64>() - 1.0).abs() < 1e-12);
        for (_, drops) in mode.nodes() {
            let radius_um = 1e6 * f64::from(drops.effective_radius_m);
            let variance = f64::from(drops.effective_variance);
            let holds = |(low, high): (f64, f64), value: f64| low <= value && value <= high;
            assert!(laws.iter().any(|law| {
                holds(law.effective_radius_um, radius_um) && holds(law.effective_variance, variance)
            }));
        }
        let is_narrow = |law: &&LawShare| {
            let (low_um, high_um) = law.effective_radius_um;
            high_um / low_um > 1.2
        };
        assert_eq!(laws.iter().filter(is_narrow).count(), 0);
    }
}
