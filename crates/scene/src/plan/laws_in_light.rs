//! The laws of drops and how much of the light is theirs, which says how finely a table has to hold sizes.
//!
//! A table serves laws down to a least width: narrower ones show their supernumeraries as that one has them,
//! which changes their light by less than half of a bow's peak. Those that have no more of the cross-section
//! than twice the tolerance may therefore be narrower: at the edge of a fountain drops are sorted to one size,
//! and are next to none.
//!
//! Each mode of a volume is judged by itself, because another may hide it where it is not.

use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::LawShare;
use niji_radiometry::Micrometers;
use niji_sizes::law_support;

use super::error::PlanError;

/// Share of a mode's cross-section in laws that need not be held, in tolerances.
const UNSEEN_SHARE: f64 = 2.0;
/// Share of a mode's cross-section that the single sizes of a table leave out on either side.
const LEFT_OUT: f64 = 5e-5;

/// The laws of drops with their shares of the cross-section of each mode.
#[derive(Debug, Clone, PartialEq)]
pub struct LawsInLight {
    modes: Vec<Vec<LawShare>>,
}

impl LawsInLight {
    /// Those of a volume's nodes.
    pub(super) fn of_volume(volume: &DropVolume) -> Self {
        Self {
            modes: volume.modes.iter().map(DropMode::law_shares).collect(),
        }
    }

    /// Any law between these, each as bright as all.
    pub(super) fn between(effective_radius_um: (f64, f64), effective_variance: (f64, f64)) -> Self {
        let all = LawShare {
            effective_radius_um,
            effective_variance,
            share: 1.0,
        };
        Self {
            modes: vec![vec![all]],
        }
    }

    /// With those of other drops in the same air.
    pub(super) fn beside(mut self, others: Self) -> Self {
        self.modes.extend(others.modes);
        self
    }

    /// With every law changed.
    pub(super) fn each(mut self, change: impl Fn(LawShare) -> LawShare) -> Self {
        for law in self.modes.iter_mut().flatten() {
            *law = change(*law);
        }
        self
    }

    /// The laws of each mode.
    pub(super) fn modes(&self) -> &[Vec<LawShare>] {
        &self.modes
    }

    /// Effective variance of the narrowest law that a table of a tolerance has to hold.
    pub(super) fn narrowest_variance(&self, tolerance: f64) -> f64 {
        self.first_held(tolerance, |law| law.effective_variance.0)
    }

    /// Smallest effective radius that has as much light (um).
    pub(super) fn smallest_radius_um(&self, tolerance: f64) -> f64 {
        self.first_held(tolerance, |law| law.effective_radius_um.0)
    }

    /// The smallest value, of the modes, below which laws have too little light to count; 0 without drops.
    fn first_held(&self, tolerance: f64, value: impl Fn(&LawShare) -> f64) -> f64 {
        let of_mode = |laws: &Vec<LawShare>| {
            let mut laws: Vec<(f64, f64)> =
                laws.iter().map(|law| (value(law), law.share)).collect();
            laws.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut less = 0.0;
            let held = laws.into_iter().find(|(_, share)| {
                less += share;
                less > UNSEEN_SHARE * tolerance
            });
            held.map(|(value, _)| value)
        };
        let modes = self.modes.iter().filter_map(of_mode);
        modes.reduce(f64::min).unwrap_or(0.0)
    }

    /// Radii that hold all but a share of 5e-5 on either side, and every effective radius.
    ///
    /// # Errors
    /// A law that does not exist.
    pub(super) fn support_um(&self) -> Result<(f64, f64), PlanError> {
        let mut support = (f64::INFINITY, 0.0_f64);
        for law in self.modes.iter().flatten() {
            let left_out = (LEFT_OUT / law.share).min(0.5);
            let end = |radius_um: f64| {
                law_support(Micrometers(radius_um), law.effective_variance.1, left_out)
            };
            let (low_um, high_um) = law.effective_radius_um;
            support.0 = support.0.min(end(low_um)?.0);
            support.1 = support.1.max(end(high_um)?.1);
        }
        Ok(support)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(radius_um: f64, variance: f64, share: f64) -> LawShare {
        LawShare {
            effective_radius_um: (radius_um, radius_um),
            effective_variance: (variance, variance),
            share,
        }
    }

    fn modes(modes: &[&[LawShare]]) -> LawsInLight {
        LawsInLight {
            modes: modes.iter().map(|laws| laws.to_vec()).collect(),
        }
    }

    #[test]
    fn narrow_laws_count_from_twice_the_tolerance_on() {
        let spray = |share| modes(&[&[law(900.0, 0.0, share), law(500.0, 0.1, 1.0 - share)]]);
        assert_eq!(spray(0.009).narrowest_variance(5e-3), 0.1);
        assert_eq!(spray(0.011).narrowest_variance(5e-3), 0.0);
        assert_eq!(spray(0.009).narrowest_variance(5e-4), 0.0);
    }

    #[test]
    fn a_mode_counts_however_little_of_all_light_is_its_own() {
        let rain = [law(500.0, 0.3, 1.0)];
        let mist = [law(30.0, 0.02, 1.0)];
        assert_eq!(modes(&[&rain, &mist]).narrowest_variance(5e-3), 0.02);
    }

    #[test]
    fn radii_hold_every_law_the_less_of_it_the_less_it_is() {
        let support = |share| modes(&[&[law(50.0, 0.3, share), law(500.0, 0.1, 1.0 - share)]]);
        let (all, little, none) = (support(1.0), support(1e-3), support(1e-9));
        let ends = [all, little, none].map(|laws| laws.support_um().unwrap());
        assert!(ends[0].0 < 0.2 * 50.0);
        assert!(ends.is_sorted_by(|a, b| a.0 < b.0));
        assert!(
            ends.iter()
                .all(|(low_um, high_um)| *low_um <= 50.0 && *high_um >= 500.0)
        );
    }
}
