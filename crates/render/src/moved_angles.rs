//! The angles of an order over which its moved light is integrated.
//!
//! ⟨t⟩ = (I(θ + w/2) − I(θ − w/2))/w,   I = ∫ t dθ  linear between these angles
//! `w` width of the stretch of angles over which the mean is taken, no narrower than the step
//! there. At 0 and 180 degrees the light is continued by its mirror.

use std::f64::consts::PI;

use niji_exchange::FARTHEST_SHIFT_RAD;

/// Entries of the guide to the angles for each of them.
const GUIDE_DENSITY: usize = 16;

/// Ascending angles with a guide to them.
#[derive(Debug)]
pub(crate) struct MovedAngles {
    pub(crate) theta_rad: Vec<f64>,
    /// One over the step from each angle to the next.
    per_step: Vec<f64>,
    pub(crate) widest_step_rad: f64,
    guide: Vec<u32>,
    guide_per_rad: f64,
}

/// Where a mean is taken: the difference of two sums of two integrals each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AngleMean {
    /// The lower of the two angles, at the beginning and at the end.
    pub(crate) ends: [usize; 2],
    /// Weights of the integrals there and at the next angle.
    pub(crate) shares: [[f32; 2]; 2],
}

impl MovedAngles {
    /// The angles of a table, continued by mirrored ones beyond 0 and 180 degrees where it reaches there.
    pub(crate) fn mirrored(theta_rad: &[f64]) -> Self {
        let (first, last) = (theta_rad[0], theta_rad[theta_rad.len() - 1]);
        let end = 1e-6;
        let inner = &theta_rad[1..theta_rad.len().max(2) - 1];
        let mut all = Vec::with_capacity(3 * theta_rad.len());
        if first < end {
            let mirrored = inner
                .iter()
                .take_while(|theta| **theta < FARTHEST_SHIFT_RAD);
            all.extend(mirrored.map(|theta| 2.0 * first - theta));
            all.reverse();
        }
        all.extend(theta_rad);
        if last > PI - end {
            let mirrored = inner
                .iter()
                .rev()
                .take_while(|theta| last - **theta < FARTHEST_SHIFT_RAD);
            all.extend(mirrored.map(|theta| 2.0 * last - theta));
        }
        let n_guides = GUIDE_DENSITY * all.len();
        let (first, last) = (all[0], all[all.len() - 1]);
        let step = (last - first) / n_guides as f64;
        let lower = |entry: usize| {
            // One step back, so that rounding does not put the guide above its place.
            let theta = first + (entry as f64 - 1.0) * step;
            let above = all.partition_point(|node| *node <= theta);
            above.saturating_sub(1).min(all.len().saturating_sub(2)) as u32
        };
        let steps = all.windows(2).map(|pair| pair[1] - pair[0]);
        Self {
            guide: (0..=n_guides).map(lower).collect(),
            guide_per_rad: if step > 0.0 { 1.0 / step } else { 0.0 },
            per_step: steps.clone().map(f64::recip).collect(),
            widest_step_rad: steps.fold(0.0, f64::max),
            theta_rad: all,
        }
    }

    /// The last angle but one that is not above an angle.
    fn lower(&self, theta_rad: f64) -> usize {
        let entry = ((theta_rad - self.theta_rad[0]) * self.guide_per_rad) as usize;
        let mut lower = self.guide[entry.min(self.guide.len() - 1)] as usize;
        while lower + 2 < self.theta_rad.len() && self.theta_rad[lower + 1] <= theta_rad {
            lower += 1;
        }
        lower
    }

    /// The mean over a stretch around an angle, no narrower than a step; `None` beyond the angles.
    #[inline]
    pub(crate) fn mean(&self, theta_rad: f64, width_rad: f64) -> Option<AngleMean> {
        let theta = &self.theta_rad;
        let (first, last) = (theta[0], *theta.last()?);
        if theta.len() < 2 || theta_rad < first || theta_rad > last {
            return None;
        }
        let width_rad = if width_rad < self.widest_step_rad {
            let middle = self.lower(theta_rad);
            width_rad.max(theta[middle + 1] - theta[middle])
        } else {
            width_rad
        };
        let half = 0.5 * width_rad;
        let ends_rad = [(theta_rad - half).max(first), (theta_rad + half).min(last)];
        let per_rad = 1.0 / (ends_rad[1] - ends_rad[0]);
        let ends = ends_rad.map(|end| self.lower(end));
        let shares = [0, 1].map(|end| {
            let lower = ends[end];
            let upper = per_rad * (ends_rad[end] - theta[lower]) * self.per_step[lower];
            [(per_rad - upper) as f32, upper as f32]
        });
        Some(AngleMean { ends, shares })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0 to 180 degrees.
    fn all_angles() -> Vec<f64> {
        (0..3601)
            .map(|step| PI / 3600.0 * f64::from(step))
            .collect()
    }

    /// Steps from 0.01 to 0.05.
    fn uneven() -> Vec<f64> {
        let step = |index: u32| 0.01 + 0.01 * f64::from(index * 7 % 5);
        let mut theta = 1.0;
        let next = |index| {
            theta += step(index);
            theta
        };
        (0..40).map(next).collect()
    }

    #[test]
    fn the_mean_is_that_of_a_linear_integral() {
        let nodes = uneven();
        let angles = MovedAngles::mirrored(&nodes);
        let integrals: Vec<f64> = nodes.iter().map(|theta| (3.0 * theta).sin()).collect();
        let integral = |theta: f64| {
            let lower = nodes
                .partition_point(|node| *node <= theta)
                .clamp(1, nodes.len() - 1)
                - 1;
            let slope =
                (integrals[lower + 1] - integrals[lower]) / (nodes[lower + 1] - nodes[lower]);
            integrals[lower] + slope * (theta - nodes[lower])
        };
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        // f32 shares of 1 over the width; measured 1.8e-6.
        let tolerance = 5e-6;
        let mut worst = 0.0_f64;
        for width_rad in [0.05, 0.06, 0.3, 5.0] {
            for index in 0..=1000 {
                let theta = first + (last - first) * f64::from(index) / 1000.0;
                let AngleMean { ends, shares } = angles.mean(theta, width_rad).unwrap();
                let [low, high] = [0, 1].map(|end| {
                    let [a, b] = shares[end].map(f64::from);
                    a * integrals[ends[end]] + b * integrals[ends[end] + 1]
                });
                let begin = (theta - 0.5 * width_rad).max(first);
                let end = (theta + 0.5 * width_rad).min(last);
                let expected = (integral(end) - integral(begin)) / (end - begin);
                worst = worst.max((high - low - expected).abs());
            }
        }
        assert!(worst < tolerance, "{worst}");
        assert!(angles.mean(first - 1e-9, 0.1).is_none());
        assert!(angles.mean(last + 1e-9, 0.1).is_none());
    }

    #[test]
    fn no_mean_is_narrower_than_the_step() {
        let nodes = uneven();
        let angles = MovedAngles::mirrored(&nodes);
        for pair in nodes.windows(2) {
            for part in [0.0, 0.3, 0.9] {
                let (step, theta) = (pair[1] - pair[0], pair[0] + part * (pair[1] - pair[0]));
                let of_step = angles.mean(theta, step);
                for width_rad in [0.0, 1e-9, 0.9 * step] {
                    assert_eq!(angles.mean(theta, width_rad), of_step);
                }
                assert_ne!(angles.mean(theta, 1.1 * step), of_step);
            }
        }
    }

    #[test]
    fn a_guide_finds_every_angle() {
        for nodes in [
            uneven(),
            all_angles(),
            vec![0.3, 0.4],
            vec![0.0, 1e-3, 3.0, 3.1],
        ] {
            let angles = MovedAngles::mirrored(&nodes);
            let theta = &angles.theta_rad;
            assert!(theta.windows(2).all(|pair| pair[0] < pair[1]));
            let last = theta.len() - 2;
            for lower in 0..=last {
                assert_eq!(angles.lower(theta[lower]), lower);
                assert_eq!(angles.lower(0.5 * (theta[lower] + theta[lower + 1])), lower);
            }
            assert_eq!(angles.lower(theta[0] - 1.0), 0);
            assert_eq!(angles.lower(theta[last + 1] + 1.0), last);
        }
    }
}
