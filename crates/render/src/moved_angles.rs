//! The angles of an order over which its moved light is integrated.
//!
//! ⟨t⟩ = b⁻ⁿ Σ_k (−1)^(n − k) (n over k) I_n(θ + (k − n/2) b),   b = w/√n,   k = 0..n
//! `I_n` the n-fold integral of t over θ, linear between these angles, `w` width of the even stretch of angles with the
//! variance w²/12 of the mean, `b` width of the n even stretches over which the mean is taken one after the other, no
//! narrower than the step there. Of one stretch it is the mean over it, (I(θ + w/2) − I(θ − w/2))/w; of two it is that
//! over a tent, which is nowhere more than 7.8 % of a Gaussian's peak off the Gaussian of its variance. At 0 and 180
//! degrees the light is continued by its mirror; a mean ends where the angles do.
//! C. de Boor, A Practical Guide to Splines (1978), chapter IX: differences of truncated powers.

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

/// Where a mean is taken: a sum over places of two integrals each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AngleMean<const PLACES: usize> {
    /// The lower of the two angles, ascending.
    pub(crate) places: [usize; PLACES],
    /// Weights of the integrals there and at the next angle.
    pub(crate) shares: [[f32; 2]; PLACES],
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

    /// The mean around an angle, as wide as an even stretch but no narrower than a step; `None` beyond the angles.
    #[inline]
    pub(crate) fn mean<const PLACES: usize>(
        &self,
        theta_rad: f64,
        width_rad: f64,
    ) -> Option<AngleMean<PLACES>> {
        let theta = &self.theta_rad;
        let (first, last) = (theta[0], *theta.last()?);
        if theta.len() < 2 || theta_rad < first || theta_rad > last {
            return None;
        }
        let n = const { PLACES - 1 } as f64;
        let width_rad = width_rad / n.sqrt();
        let width_rad = if width_rad < self.widest_step_rad {
            let middle = self.lower(theta_rad);
            width_rad.max(theta[middle + 1] - theta[middle])
        } else {
            width_rad
        };
        let half = 0.5 * n * width_rad;
        let (from, to) = ((theta_rad - half).max(first), (theta_rad + half).min(last));
        let width_rad = (to - from) / n;
        let places_rad = std::array::from_fn(|place| from + place as f64 * width_rad);
        let places = places_rad.map(|place| self.lower(place));
        let scale = (1.0 / width_rad).powi(PLACES as i32 - 1);
        let shares = std::array::from_fn(|place| {
            let (lower, share) = (
                places[place],
                scale * const { differences::<PLACES>() }[place],
            );
            let upper = share * (places_rad[place] - theta[lower]) * self.per_step[lower];
            [(share - upper) as f32, upper as f32]
        });
        Some(AngleMean { places, shares })
    }

    /// How far from its angle a mean reaches at most, as wide as an even stretch.
    #[inline]
    pub(crate) fn farthest_rad<const PLACES: usize>(&self, width_rad: f64) -> f64 {
        let n = const { PLACES - 1 } as f64;
        0.5 * n * (width_rad / n.sqrt()).max(self.widest_step_rad)
    }
}

/// Factors of values at even places in their difference of the highest order.
const fn differences<const PLACES: usize>() -> [f64; PLACES] {
    let mut factors = [0.0; PLACES];
    factors[0] = 1.0;
    let mut order = 1;
    while order < PLACES {
        let mut place = order;
        while place > 0 {
            factors[place] = factors[place - 1] - factors[place];
            place -= 1;
        }
        factors[0] = -factors[0];
        order += 1;
    }
    factors
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

    /// A mean of integrals.
    fn sum<const PLACES: usize>(mean: &AngleMean<PLACES>, integrals: &[f64]) -> f64 {
        let terms = mean.places.iter().zip(mean.shares);
        let terms = terms.map(|(place, [a, b])| {
            f64::from(a) * integrals[*place] + f64::from(b) * integrals[place + 1]
        });
        terms.sum()
    }

    #[test]
    fn differences_are_those_of_powers() {
        assert_eq!(differences::<2>(), [-1.0, 1.0]);
        assert_eq!(differences::<3>(), [1.0, -2.0, 1.0]);
        assert_eq!(differences::<5>(), [1.0, -4.0, 6.0, -4.0, 1.0]);
    }

    #[test]
    fn a_tent_has_the_moments_of_its_width() {
        // From 1 to 3: none is mirrored.
        let nodes: Vec<f64> = (0..2001).map(|step| 1.0 + 1e-3 * f64::from(step)).collect();
        let angles = MovedAngles::mirrored(&nodes);
        // Means of 1, of the way off and of its square, by their twofold integrals.
        let moments = |theta: f64, width_rad: f64| {
            let mean = angles.mean::<3>(theta, width_rad).unwrap();
            [(0.5, 2), (1.0 / 6.0, 3), (1.0 / 12.0, 4)].map(|(factor, power)| {
                let integral = |node: &f64| factor * (node - theta).powi(power);
                let integrals: Vec<f64> = nodes.iter().map(integral).collect();
                sum(&mean, &integrals)
            })
        };
        for (theta, width_rad) in [(2.0, 0.05), (1.987_6, 0.2), (2.234_5, 0.8)] {
            let [all, first, second] = moments(theta, width_rad);
            // Straight lines between angles: parts of the square of a step over that of the tent.
            let tolerance = (1e-3 / width_rad).powi(2) + 1e-6;
            assert!((all - 1.0).abs() < tolerance, "{width_rad}: {all}");
            assert!(first.abs() < tolerance * width_rad, "{width_rad}: {first}");
            let off = 12.0 * second / (width_rad * width_rad) - 1.0;
            assert!(off.abs() < 6.0 * tolerance, "{width_rad}: {off}");
        }
        // Where angles end a tent does: one half as wide.
        let [all, first, _] = moments(3.0, 0.2);
        assert!((all - 1.0).abs() < 1e-3, "{all}");
        assert!((first + 0.1 / 2.0_f64.sqrt()).abs() < 1e-3, "{first}");
    }

    #[test]
    fn a_tent_is_nearly_a_gaussian() {
        // In standard deviations, of which a tent reaches sqrt(6).
        let reach = 6.0_f64.sqrt();
        let peak = 1.0 / std::f64::consts::TAU.sqrt();
        let off = |x: f64| {
            let tent = (1.0 - x / reach).max(0.0) / reach;
            (tent - peak * (-0.5 * x * x).exp()).abs() / peak
        };
        let worst = (0..5000)
            .map(|step| off(1e-3 * f64::from(step)))
            .fold(0.0, f64::max);
        assert!((0.077..0.078).contains(&worst), "{worst}");
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
                let found = sum(&angles.mean::<2>(theta, width_rad).unwrap(), &integrals);
                let begin = (theta - 0.5 * width_rad).max(first);
                let end = (theta + 0.5 * width_rad).min(last);
                let expected = (integral(end) - integral(begin)) / (end - begin);
                worst = worst.max((found - expected).abs());
            }
        }
        assert!(worst < tolerance, "{worst}");
        assert!(angles.mean::<2>(first - 1e-9, 0.1).is_none());
        assert!(angles.mean::<3>(last + 1e-9, 0.1).is_none());
    }

    #[test]
    fn no_mean_is_narrower_than_the_step() {
        let nodes = uneven();
        let angles = MovedAngles::mirrored(&nodes);
        for pair in nodes.windows(2) {
            for part in [0.0, 0.3, 0.9] {
                let (step, theta) = (pair[1] - pair[0], pair[0] + part * (pair[1] - pair[0]));
                let of_step = angles.mean::<2>(theta, step);
                let of_two = angles.mean::<3>(theta, 0.0);
                for width_rad in [0.0, 1e-9, 0.9 * step] {
                    assert_eq!(angles.mean(theta, width_rad), of_step);
                    assert_eq!(angles.mean(theta, 1.4 * width_rad), of_two);
                }
                assert_ne!(angles.mean(theta, 1.1 * step), of_step);
                assert_ne!(angles.mean(theta, 1.6 * step), of_two);
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
