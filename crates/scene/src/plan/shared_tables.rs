//! What frames that differ a little need alike, so that they share one table.
//!
//! The ranges that a frame needs are rounded outward: angles to the forward half, the backward half or
//! all of them (outside of the bows a table is coarse, so that they cost little), radii to powers of 2,
//! variances to twentieths and below the first to hundredths, flattenings to nodes at multiples of a power of 2. A frame's table then
//! follows from the sequence, whichever of its frames are made.

use std::f64::consts::PI;

use niji_dropfield::LawShare;

use crate::plan::drop_summary::DropSummary;
use crate::plan::scattering_need::ScatteringNeed;

/// Step of scattering angles, degrees.
const ANGLE_STEP_DEG: f64 = 90.0;
/// Margin of angles before that, degrees.
const BETWEEN_DEG: f64 = 1.0;
/// Step of effective variances.
const VARIANCE_STEP: f64 = 0.05;
const NARROW_STEP: f64 = 0.01;
/// Largest effective variance that is rounded to.
const LARGEST_ROUNDED: f64 = 0.499;
/// A number that is as near to a step counts as one: f32 files round.
const ROUNDOFF: f64 = 1e-5;

impl DropSummary {
    /// The same drops with sizes rounded outward.
    #[must_use]
    pub fn with_rounded_sizes(self) -> Self {
        Self {
            effective_radius_um: rounded_radii(self.effective_radius_um),
            effective_variance: rounded_variances(self.effective_variance),
            laws: self.laws.each(|law| LawShare {
                effective_radius_um: rounded_radii(law.effective_radius_um),
                effective_variance: rounded_variances(law.effective_variance),
                ..law
            }),
            ..self
        }
    }
}

/// Radii rounded outward to powers of 2.
fn rounded_radii((smallest, largest): (f64, f64)) -> (f64, f64) {
    if smallest <= 0.0 {
        return (smallest, largest);
    }
    let (low, high) = rounded_out((smallest.log2(), largest.log2()), 1.0);
    (low.exp2(), high.exp2())
}

/// Variances rounded outward to twentieths, narrow ones to hundredths.
fn rounded_variances((narrowest, broadest): (f64, f64)) -> (f64, f64) {
    let (low, high) = rounded_out((narrowest, broadest), VARIANCE_STEP);
    let low = if low <= 0.0 {
        rounded_out((narrowest, narrowest), NARROW_STEP).0
    } else {
        low
    };
    // No law has a half.
    (low.max(0.0), high.min(broadest.max(LARGEST_ROUNDED)))
}

impl ScatteringNeed {
    /// The same table for directions rounded outward.
    #[must_use]
    pub fn with_rounded_directions(self) -> Self {
        let (low, high) = self.theta_range_rad;
        // Frames between those that were looked at may see a little more.
        let margin = BETWEEN_DEG.to_radians();
        let range = (low - margin, high + margin);
        let (low, high) = rounded_out(range, ANGLE_STEP_DEG.to_radians());
        Self {
            theta_range_rad: (low.max(0.0), high.min(PI)),
            ..self
        }
    }
}

/// The range between multiples of a step that holds a range.
fn rounded_out((low, high): (f64, f64), step: f64) -> (f64, f64) {
    let (low, high) = (low / step + ROUNDOFF, high / step - ROUNDOFF);
    (step * low.floor(), step * high.ceil().max(low.floor()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_grow_to_the_next_step_and_steps_stay() {
        let (low, high) = rounded_out((131.2, 148.7), 10.0);
        assert!((low - 130.0).abs() < 1e-9 && (high - 150.0).abs() < 1e-9);
        let (low, high) = rounded_out((130.0, 150.0), 10.0);
        assert!((low - 130.0).abs() < 1e-9 && (high - 150.0).abs() < 1e-9);
        // A single drop size between steps, and one that is a step.
        assert_eq!(rounded_out((6.5, 6.5), 1.0), (6.0, 7.0));
        assert_eq!(rounded_out((6.0, 6.0), 1.0), (6.0, 6.0));
    }
}
