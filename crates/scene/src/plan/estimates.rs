//! Estimates for effects that are not computed yet: what a person must expect to miss.
//!
//! None of these decides anything; each comes from a model of a line or two.

use std::f64::consts::PI;

use crate::effect::Effect;

use super::bounds::Bound;
use super::bounds::BoundKind;
use super::bounds::BoundScene;
use super::reasons::Facts;

/// Scattering angles beyond which glory and corona are not seen, and the largest drops that make
/// rings wide enough to be seen.
const GLORY_DEG: f64 = 175.0;
const CORONA_DEG: f64 = 10.0;
const RINGS_UM: f64 = 30.0;

/// The estimate for an effect that is not available; `None` for others and where none is known.
pub(super) fn bound(effect: Effect, scene: &BoundScene<'_>, facts: &Facts) -> Option<Bound> {
    if effect.is_available() {
        return None;
    }
    let estimate = |change: &dyn Fn(usize) -> f64| Some(scene.over(BoundKind::Estimated, change));
    let spread_light = |sr1: f64| sr1 * scene.lines.iter().map(|line| line.weight).sum::<f64>();
    let share = |index: usize| -(-scene.depth(index)).exp_m1();
    if effect == Effect::MultipleScattering {
        // Light of a second scattering, spread over all directions.
        let second = -(-facts.sun_depth).exp_m1();
        return estimate(&|index| spread_light(second / (4.0 * PI)) * share(index));
    }
    let (low_deg, high_deg) = facts.theta_deg.unwrap_or((90.0, 90.0));
    let in_view = if effect == Effect::Glory {
        high_deg > GLORY_DEG
    } else {
        low_deg < CORONA_DEG
    };
    if in_view && facts.smallest_radius_um < RINGS_UM {
        None
    } else {
        estimate(&|_| 0.0)
    }
}
