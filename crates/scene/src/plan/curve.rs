//! A quantity over the scattering angle, at even steps.

use std::collections::VecDeque;

/// Factor on every maximum, for the coarseness of curves.
const MARGIN: f64 = 1.15;

/// Step of the angles, 0.05 degrees.
pub(super) const STEP_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// A quantity by scattering angle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub(super) first_rad: f64,
    pub(super) values: Vec<f64>,
}

impl Curve {
    /// No light at any angle.
    pub(super) fn empty() -> Self {
        Self {
            first_rad: 0.0,
            values: Vec::new(),
        }
    }

    /// Largest value within a range of angles, the neighbors of its ends included, times
    /// [`MARGIN`]; 0 beyond the curve.
    pub(super) fn max_within(&self, (low_rad, high_rad): (f64, f64)) -> f64 {
        let place = |theta_rad: f64| (theta_rad - self.first_rad) / STEP_RAD;
        if self.values.is_empty() || place(high_rad) < 0.0 {
            return 0.0;
        }
        let first = place(low_rad).floor().max(0.0) as usize;
        let last = (place(high_rad).ceil() as usize).min(self.values.len() - 1);
        let range = self.values.get(first..=last).unwrap_or_default();
        MARGIN * range.iter().fold(0.0, |max: f64, value| max.max(*value))
    }

    /// Its integral over the sphere times a density by angle, times [`MARGIN`].
    pub(super) fn over_the_sphere(&self, density: impl Fn(f64) -> f64) -> f64 {
        let angles = (0..self.values.len()).map(|index| self.first_rad + STEP_RAD * index as f64);
        // The ring of an angle, a cap at 0.
        let light = angles.zip(&self.values).map(|(theta_rad, value)| {
            let ring = theta_rad.sin().max(0.25 * STEP_RAD) * STEP_RAD * std::f64::consts::TAU;
            value * density(theta_rad) * ring
        });
        MARGIN * light.sum::<f64>()
    }

    /// Pointwise sum of curves over the same angles.
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.pointwise(other, |a, b| a + b)
    }

    /// Pointwise larger of two curves over the same angles.
    pub(super) fn or_larger(&self, other: &Self) -> Self {
        self.pointwise(other, f64::max)
    }

    fn pointwise(&self, other: &Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        if self.values.is_empty() {
            return other.clone();
        }
        if other.values.is_empty() {
            return self.clone();
        }
        let pairs = self.values.iter().zip(&other.values);
        Self {
            first_rad: self.first_rad,
            values: pairs.map(|(a, b)| combine(*a, *b)).collect(),
        }
    }

    /// The largest value within `reach_rad` on either side of each angle.
    pub(super) fn widened(&self, reach_rad: f64) -> Self {
        let n_side = (reach_rad / STEP_RAD).ceil() as usize;
        if n_side == 0 {
            return self.clone();
        }
        let n = self.values.len();
        // Places of falling values, the largest first.
        let mut falling: VecDeque<usize> = VecDeque::new();
        let mut values = Vec::with_capacity(n);
        for last in 0..n + n_side {
            if last < n {
                while falling
                    .back()
                    .is_some_and(|at| self.values[*at] <= self.values[last])
                {
                    falling.pop_back();
                }
                falling.push_back(last);
            }
            if last >= n_side {
                while falling.front().is_some_and(|at| at + 2 * n_side < last) {
                    falling.pop_front();
                }
                values.push(falling.front().map_or(0.0, |at| self.values[*at]));
            }
        }
        Self {
            first_rad: self.first_rad,
            values,
        }
    }

    /// The curve with zeros where `keep` does not hold.
    pub(super) fn only(&self, keep: impl Fn(f64) -> bool) -> Self {
        let angle = |index: usize| self.first_rad + STEP_RAD * index as f64;
        let values = self.values.iter().enumerate();
        let values = values
            .map(|(i, value)| if keep(angle(i)) { *value } else { 0.0 })
            .collect();
        Self {
            first_rad: self.first_rad,
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_light_over_the_sphere_is_that_of_4_pi() {
        let n = (std::f64::consts::PI / STEP_RAD).round() as usize + 1;
        let even = Curve {
            first_rad: 0.0,
            values: vec![0.5; n],
        };
        let whole = even.over_the_sphere(|_| 1.0) / MARGIN;
        assert!(
            (whole / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-5,
            "{whole}"
        );
        let cap = even.over_the_sphere(|theta| f64::from(u8::from(theta < 0.1))) / MARGIN;
        let expected = std::f64::consts::PI * (1.0 - 0.1_f64.cos());
        assert!((cap / expected - 1.0).abs() < 0.02, "{cap} {expected}");
        assert_eq!(Curve::empty().over_the_sphere(|_| 1.0), 0.0);
    }

    #[test]
    fn a_widened_curve_is_the_largest_value_around() {
        let values: Vec<f64> = (0..200_u32).map(|i| f64::from(i * 7919 % 101)).collect();
        let curve = Curve {
            first_rad: 1.0,
            values: values.clone(),
        };
        assert_eq!(curve.widened(0.0), curve);
        for n in [1, 4, 250] {
            let wide = curve.widened((n as f64 - 0.5) * STEP_RAD);
            for (index, found) in wide.values.iter().enumerate() {
                let near = index.saturating_sub(n)..(index + n + 1).min(values.len());
                let expected = values[near].iter().copied().fold(0.0, f64::max);
                assert_eq!(*found, expected, "{n} {index}");
            }
        }
        assert_eq!(Curve::empty().widened(0.1), Curve::empty());
    }
}
