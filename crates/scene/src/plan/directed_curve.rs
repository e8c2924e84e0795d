//! A quantity by scattering angle and, where flat drops move light, by the rise of the view.

use super::curve::Curve;

/// Nodes of the rise on either side of 0.
const N_HALF_NODES: i32 = 8;

/// Half of the step between them.
pub(super) const HALF_STEP: f64 = 0.5 / N_HALF_NODES as f64;

/// The rise at a node.
pub(super) fn rise_of(node: i32) -> f64 {
    2.0 * HALF_STEP * f64::from(node)
}

/// Whether a node may stand for a rise within a range: each does so for half of a step around it.
fn is_near(node: i32, (low, high): (f64, f64)) -> bool {
    let rise = rise_of(node);
    rise > low - 2.0 * HALF_STEP && rise < high + 2.0 * HALF_STEP
}

/// The nodes that are looked at, for a range of the rise that is seen.
pub(super) fn nodes(range: (f64, f64)) -> impl Iterator<Item = i32> {
    (-N_HALF_NODES..=N_HALF_NODES).filter(move |node| is_near(*node, range))
}

/// Curves over the scattering angle by the rise of the view.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum DirectedCurve {
    /// Every direction is the same.
    Round(Curve),
    /// By node of the rise.
    Flat(Vec<(i32, Curve)>),
}

impl DirectedCurve {
    /// No light.
    pub(super) fn empty() -> Self {
        Self::Round(Curve::empty())
    }

    /// Largest value within a range of angles and one of the rise.
    pub(super) fn max_within(&self, theta_rad: (f64, f64), rise: (f64, f64)) -> f64 {
        match self {
            Self::Round(curve) => curve.max_within(theta_rad),
            Self::Flat(curves) => {
                let near = curves.iter().filter(|(node, _)| is_near(*node, rise));
                near.map(|(_, curve)| curve.max_within(theta_rad))
                    .fold(0.0, f64::max)
            }
        }
    }

    /// Its integral over the sphere times a density, of one range of the rise.
    pub(super) fn over_the_sphere(&self, density: impl Fn(f64) -> f64, rise: (f64, f64)) -> f64 {
        match self {
            Self::Round(curve) => curve.over_the_sphere(density),
            Self::Flat(curves) => {
                let near = curves.iter().filter(|(node, _)| is_near(*node, rise));
                near.map(|(_, curve)| curve.over_the_sphere(&density))
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
                let only = |(node, curve): &(i32, Curve)| (*node, curve.only(&keep));
                Self::Flat(curves.iter().map(only).collect())
            }
        }
    }

    fn zip(&self, other: &Self, combine: impl Fn(&Curve, &Curve) -> Curve) -> Self {
        match (self, other) {
            (Self::Round(a), Self::Round(b)) => Self::Round(combine(a, b)),
            (Self::Flat(curves), Self::Round(b)) => {
                let with = |(node, a): &(i32, Curve)| (*node, combine(a, b));
                Self::Flat(curves.iter().map(with).collect())
            }
            (Self::Round(a), Self::Flat(curves)) => {
                let with = |(node, b): &(i32, Curve)| (*node, combine(a, b));
                Self::Flat(curves.iter().map(with).collect())
            }
            (Self::Flat(a), Self::Flat(b)) => {
                let with =
                    |((node, a), (_, b)): (&(i32, Curve), &(i32, Curve))| (*node, combine(a, b));
                Self::Flat(a.iter().zip(b).map(with).collect())
            }
        }
    }
}
