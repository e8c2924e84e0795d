//! Estimates for effects that are not computed yet: what a person must expect to miss.
//!
//! None of these decides anything; each comes from a model of a line or two.

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
