//! Estimates for effects that are not computed yet: what a person must expect to miss.
//!
//! None of these decides anything; each comes from a model of a line or two.

use std::f64::consts::PI;

use crate::effect::Effect;

use super::bounds::Bound;
use super::bounds::BoundKind;
use super::bounds::BoundScene;
use super::light_curves::variants;
use super::reasons::Facts;

/// (dsigma/dOmega)/(pi <r^2>) of external reflection, p = 0, and of p >= 4 away from their bows
/// (1/sr): a reflectance of 0.05 over 4 pi, and half as much again.
const HIGHER_ORDERS_SR1: f64 = 1.5 * 0.05 / (4.0 * PI);

/// Shift of the top of the primary bow by drops of 1 mm diameter, degrees, for a sun near the
/// horizon: ray tracing through the axis ratios of Beard and Chuang, J. Atmos. Sci. 44, 1509 (1987).
const SHIFT_AT_1_MM_DEG: f64 = 1.8;

/// Width of the primary bow, degrees: a shift by as much leaves nothing in its place.
const BOW_WIDTH_DEG: f64 = 2.0;

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
    if effect == Effect::HigherOrders {
        return estimate(&|index| spread_light(HIGHER_ORDERS_SR1) * share(index));
    }
    if effect == Effect::MultipleScattering {
        // Light of a second scattering, spread over all directions.
        let second = -(-facts.sun_depth).exp_m1();
        return estimate(&|index| spread_light(second / (4.0 * PI)) * share(index));
    }
    if effect == Effect::DropFlattening {
        let diameter_mm = 2e-3 * facts.largest_radius_um;
        let power = if diameter_mm < 1.0 { 3.0 } else { 2.2 };
        let moved = (SHIFT_AT_1_MM_DEG * diameter_mm.powf(power) / BOW_WIDTH_DEG).min(1.0);
        let factor = vec![1.0; scene.lines.len()];
        let bow = scene
            .light
            .bow(Effect::PrimaryBow, &factor, &variants(|_| Some(true)));
        return estimate(&|index| moved * scene.brightest(&bow, index) * share(index));
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
