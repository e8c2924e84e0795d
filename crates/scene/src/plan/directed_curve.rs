//! A quantity by scattering angle and, where flat drops move light, by direction of flattening m.

use super::curve::Curve;

/// Directions of flattening that are looked at on either side of 0.
const N_HALF_NODES: i32 = 8;

/// Half of the step between them.
pub(super) const HALF_STEP: f64 = 0.5 / N_HALF_NODES as f64;

/// The directions of flattening that are looked at, for a range of m that is seen.
pub(super) fn nodes((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    (-N_HALF_NODES..=N_HALF_NODES)
        .map(|index| 2.0 * HALF_STEP * f64::from(index))
        .filter(move |m| *m > low - 2.0 * HALF_STEP && *m < high + 2.0 * HALF_STEP)
}

/// Curves over the scattering angle for directions of flattening.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum DirectedCurve {
    /// Every direction is the same.
    Round(Curve),
    /// By m, at even steps.
    Flat(Vec<(f64, Curve)>),
}

impl DirectedCurve {
    /// No light.
    pub(super) fn empty() -> Self {
        Self::Round(Curve::empty())
    }

    /// Largest value within a range of angles and one of directions.
    pub(super) fn max_within(&self, theta_rad: (f64, f64), (low, high): (f64, f64)) -> f64 {
        match self {
            Self::Round(curve) => curve.max_within(theta_rad),
            Self::Flat(curves) => {
                // Each node stands for half of a step around it.
                let is_near = |m: f64| m > low - 2.0 * HALF_STEP && m < high + 2.0 * HALF_STEP;
                let near = curves.iter().filter(|(m, _)| is_near(*m));
                near.map(|(_, curve)| curve.max_within(theta_rad))
                    .fold(0.0, f64::max)
            }
        }
    }

    /// Pointwise sum.
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.zip(other, Curve::plus)
    }

    /// Pointwise larger of both.
    pub(super) fn or_larger(&self, other: &Self) -> Self {
        self.zip(other, Curve::or_larger)
    }

    /// The curves with zeros where `keep` does not hold.
    pub(super) fn only(&self, keep: impl Fn(f64) -> bool) -> Self {
        match self {
            Self::Round(curve) => Self::Round(curve.only(keep)),
            Self::Flat(curves) => {
                let only = |(m, curve): &(f64, Curve)| (*m, curve.only(&keep));
                Self::Flat(curves.iter().map(only).collect())
            }
        }
    }

    fn zip(&self, other: &Self, combine: impl Fn(&Curve, &Curve) -> Curve) -> Self {
        match (self, other) {
            (Self::Round(a), Self::Round(b)) => Self::Round(combine(a, b)),
            (Self::Flat(curves), Self::Round(b)) => {
                let with = |(m, a): &(f64, Curve)| (*m, combine(a, b));
                Self::Flat(curves.iter().map(with).collect())
            }
            (Self::Round(a), Self::Flat(curves)) => {
                let with = |(m, b): &(f64, Curve)| (*m, combine(a, b));
                Self::Flat(curves.iter().map(with).collect())
            }
            (Self::Flat(a), Self::Flat(b)) => {
                let with = |((m, a), (_, b)): (&(f64, Curve), &(f64, Curve))| (*m, combine(a, b));
                Self::Flat(a.iter().zip(b).map(with).collect())
            }
        }
    }
}
