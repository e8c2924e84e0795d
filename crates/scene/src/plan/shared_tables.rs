//! What frames that differ a little need alike, so that they share one table.
//!
//! The ranges that a frame needs are rounded outward: angles to the forward half, the backward half or
//! all of them (outside of the bows a table is coarse, so that they cost little), radii to powers of 2,
//! variances to twentieths, flattenings to nodes at multiples of a power of 2. A frame's table then
//! follows from the frame alone, whichever other frames are made with it.

use std::f64::consts::PI;

use crate::plan::drop_summary::DropSummary;
use crate::plan::stages::ScatteringNeed;

/// Step of scattering angles, degrees.
const ANGLE_STEP_DEG: f64 = 90.0;
/// Step of effective variances.
const VARIANCE_STEP: f64 = 0.05;
/// A number that is as near to a step counts as one: f32 files round.
const ROUNDOFF: f64 = 1e-5;

impl DropSummary {
    /// The same drops with sizes rounded outward.
    #[must_use]
    pub fn with_rounded_sizes(self) -> Self {
        let (smallest, largest) = self.effective_radius_um;
        let (narrowest, broadest) = self.effective_variance;
        let power = |exponent: f64| exponent.exp2();
        let variance = rounded_out((narrowest, broadest), VARIANCE_STEP);
        Self {
            effective_radius_um: if smallest > 0.0 {
                let exponents = rounded_out((smallest.log2(), largest.log2()), 1.0);
                (power(exponents.0), power(exponents.1))
            } else {
                (smallest, largest)
            },
            effective_variance: (variance.0.max(0.0), variance.1),
            ..self
        }
    }
}

impl ScatteringNeed {
    /// The same table for directions rounded outward.
    #[must_use]
    pub fn with_rounded_directions(self) -> Self {
        let (low, high) = self.theta_range_rad;
        let (low, high) = rounded_out((low, high), ANGLE_STEP_DEG.to_radians());
        Self {
            theta_range_rad: (low.max(0.0), high.min(PI)),
            flattening: rounded_nodes(&self.flattening),
            ..self
        }
    }
}

/// The range between multiples of a step that holds a range.
fn rounded_out((low, high): (f64, f64), step: f64) -> (f64, f64) {
    let (low, high) = (low / step + ROUNDOFF, high / step - ROUNDOFF);
    (step * low.floor(), step * high.ceil().max(low.floor()))
}

/// Even nodes at multiples of a power of 2, no farther apart than these even nodes, from at most the
/// first to at least the last of them and within -1 to 1.
fn rounded_nodes(nodes: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
        return Vec::new();
    };
    if nodes.len() < 2 {
        return nodes.to_vec();
    }
    let spacing = (last - first) / (nodes.len() as f64 - 1.0);
    let step = spacing.log2().floor().exp2();
    let (low, high) = ((first / step).floor() as i64, (last / step).ceil() as i64);
    let nodes = (low..=high).map(|index| index as f64 * step);
    nodes.filter(|node| node.abs() <= 1.0).collect()
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

    #[test]
    fn nodes_of_neighboring_frames_are_the_same() {
        let even = |low: f64, high: f64, n: usize| -> Vec<f64> {
            let step = (high - low) / (n as f64 - 1.0);
            (0..n).map(|index| low + step * index as f64).collect()
        };
        let nodes = rounded_nodes(&even(0.11, 0.62, 12));
        assert_eq!(nodes, rounded_nodes(&even(0.115, 0.624, 12)));
        assert!(nodes[0] <= 0.11 && nodes[nodes.len() - 1] >= 0.62);
        assert!(nodes[1] - nodes[0] <= 0.51 / 11.0);
        assert_eq!(rounded_nodes(&[0.0]), [0.0]);
        let whole = rounded_nodes(&even(-0.99, 0.999, 7));
        assert!((whole[0] + 1.0).abs() < 1e-12 && (whole[whole.len() - 1] - 1.0).abs() < 1e-12);
    }
}
