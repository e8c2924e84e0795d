//! One of the two rays of a bow by d, its deviation beyond the rainbow ray, at even steps of ln d.
//!
//! i(sqrt(d)) is analytic, and with it the optical path and what the strength is made of; so six nodes around
//! a place give what Newton's rule would, to 1e-9, at a tenth of its cost.

/// Nodes, and those of them that a value is interpolated from.
const N_NODES: usize = 160;
const N_AROUND: usize = 6;

/// What a ray has: its optical path, sin i cos i, and ε_j sqrt(σ/(dD/di)) of both polarisations.
pub(crate) type RayValues = [f64; 4];

/// A ray at nodes of ln d.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RayBranch {
    from_rad: f64,
    step: f64,
    nodes: Vec<RayValues>,
}

impl RayBranch {
    /// Nodes over a range of d above 0.
    pub(crate) fn new((from_rad, to_rad): (f64, f64), values: impl Fn(f64) -> RayValues) -> Self {
        let step = (to_rad / from_rad).ln() / (N_NODES - 1) as f64;
        let node = |index: usize| values(from_rad * (step * index as f64).exp());
        Self {
            from_rad,
            step,
            nodes: (0..N_NODES).map(node).collect(),
        }
    }

    /// The values at a d of its range.
    pub(crate) fn at(&self, beyond_rad: f64) -> RayValues {
        let place = (beyond_rad / self.from_rad).ln() / self.step;
        let first = (place.floor() - 2.0).clamp(0.0, (N_NODES - N_AROUND) as f64);
        let weights = lagrange(place - first);
        let mut values = [0.0; 4];
        for (node, weight) in self.nodes[first as usize..].iter().zip(weights) {
            for (value, at_node) in values.iter_mut().zip(node) {
                *value += weight * at_node;
            }
        }
        values
    }
}

/// Weights of nodes at 0, 1 … 5 for a value at `place`.
fn lagrange(place: f64) -> [f64; N_AROUND] {
    const SCALES: [f64; N_AROUND] = [
        -1.0 / 120.0,
        1.0 / 24.0,
        -1.0 / 12.0,
        1.0 / 12.0,
        -1.0 / 24.0,
        1.0 / 120.0,
    ];
    let away: [f64; N_AROUND] = std::array::from_fn(|node| place - node as f64);
    let mut weights = SCALES;
    let (mut before, mut after) = (1.0, 1.0);
    for node in 0..N_AROUND {
        weights[node] *= before;
        before *= away[node];
        let other = N_AROUND - 1 - node;
        weights[other] *= after;
        after *= away[other];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quintic_is_found_again_at_and_between_nodes_and_at_both_ends() {
        let quintic = |d: f64| {
            let x = d.ln();
            [1.0, x, x.powi(5) - x.powi(2), 2.0 * x.powi(4)]
        };
        let branch = RayBranch::new((0.5, 2.5), quintic);
        for step in 0..=1000 {
            let x = 0.5 + 2.0 * f64::from(step) / 1000.0;
            for (found, expected) in branch.at(x).into_iter().zip(quintic(x)) {
                assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0));
            }
        }
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        let branch = RayBranch::new((0.1, 1.0), |x| [x; 4]);
        assert!(branch.at(f64::NAN)[0].is_nan());
    }
}
