//! Gauss-Legendre nodes on a stretch of air, whose density falls exponentially with height.
//!
//! A short stretch takes the rule as it is. On a long one the density varies by orders of magnitude;
//! the substitution s = D u², D the stretch's length, crowds the nodes at its dense end. A ray that
//! passes a lowest point is dense there and is cut in two.

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;
use niji_geometry::Planet;

/// Beyond this length nodes are crowded at the dense end.
const LONG_M: f64 = 30_000.0;

/// A rule on 0..1, nodes ascending.
#[derive(Clone, Debug)]
pub(crate) struct GaussRule(Vec<(f64, f64)>);

/// A node on a ray: distance from the eye and the length that it stands for, both in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayNode {
    pub(crate) distance_m: f64,
    pub(crate) weight_m: f64,
}

/// A ray as the air sees it: height of the eye and cosine of the zenith angle there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AirRay {
    pub(crate) height_m: f64,
    pub(crate) cos_zenith: f64,
}

impl GaussRule {
    /// The rule with `n` nodes.
    pub(crate) fn new(n: NonZeroUsize) -> Self {
        let rule = GaussLegendre::new(n);
        let mut nodes: Vec<(f64, f64)> = rule
            .iter()
            .map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight))
            .collect();
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(nodes)
    }

    /// Positions and weights on 0..1.
    pub(crate) fn nodes(&self) -> &[(f64, f64)] {
        &self.0
    }

    /// Append nodes between two distances of a ray, ascending.
    pub(crate) fn place(
        &self,
        planet: Planet,
        ray: AirRay,
        (from_m, to_m): (f64, f64),
        out: &mut Vec<RayNode>,
    ) {
        let lowest_m = -(planet.radius_m + ray.height_m) * ray.cos_zenith;
        if to_m - from_m <= LONG_M {
            self.place_evenly((from_m, to_m), out);
        } else if lowest_m <= from_m {
            self.place_upwards((from_m, to_m), out);
        } else if lowest_m >= to_m {
            self.place_downwards((from_m, to_m), out);
        } else {
            self.place_downwards((from_m, lowest_m), out);
            self.place_upwards((lowest_m, to_m), out);
        }
    }

    fn place_evenly(&self, (from_m, to_m): (f64, f64), out: &mut Vec<RayNode>) {
        let length_m = to_m - from_m;
        out.extend(self.0.iter().map(|(x, weight)| RayNode {
            distance_m: from_m + length_m * x,
            weight_m: length_m * weight,
        }));
    }

    /// Dense at the start: s = from + D u², ds = 2 D u du.
    fn place_upwards(&self, (from_m, to_m): (f64, f64), out: &mut Vec<RayNode>) {
        let length_m = to_m - from_m;
        out.extend(self.0.iter().map(|(u, weight)| RayNode {
            distance_m: from_m + length_m * u * u,
            weight_m: 2.0 * length_m * u * weight,
        }));
    }

    /// Dense at the end: s = to - D u².
    fn place_downwards(&self, (from_m, to_m): (f64, f64), out: &mut Vec<RayNode>) {
        let length_m = to_m - from_m;
        out.extend(self.0.iter().rev().map(|(u, weight)| RayNode {
            distance_m: to_m - length_m * u * u,
            weight_m: 2.0 * length_m * u * weight,
        }));
    }
}

#[cfg(test)]
mod tests {
    use niji_geometry::EARTH;

    use super::*;

    fn nodes(n: usize, ray: AirRay, range_m: (f64, f64)) -> Vec<RayNode> {
        let mut out = Vec::new();
        GaussRule::new(NonZeroUsize::new(n).unwrap()).place(EARTH, ray, range_m, &mut out);
        out
    }

    #[test]
    fn weights_add_up_to_the_length_and_nodes_ascend() {
        for (cos_zenith, range_m) in [
            (0.5, (0.0, 100.0)),
            (0.1, (50.0, 9e5)),
            (-0.05, (0.0, 3e5)),
            (-0.02, (0.0, 9e5)),
        ] {
            let ray = AirRay {
                height_m: 3_000.0,
                cos_zenith,
            };
            let nodes = nodes(8, ray, range_m);
            let length: f64 = nodes.iter().map(|node| node.weight_m).sum();
            assert!((length / (range_m.1 - range_m.0) - 1.0).abs() < 1e-12);
            assert!(nodes.is_sorted_by(|a, b| a.distance_m < b.distance_m));
        }
    }

    #[test]
    fn sixteen_nodes_hold_the_column_of_an_exponential_air() {
        // Straight up through a scale height of 8 km: H (1 - exp(-100/8)). Measured 4e-12.
        let ray = AirRay {
            height_m: 0.0,
            cos_zenith: 1.0,
        };
        let column: f64 = nodes(16, ray, (0.0, 1e5))
            .iter()
            .map(|node| node.weight_m * (-node.distance_m / 8e3).exp())
            .sum();
        assert!((column / (8e3 * (1.0 - (-12.5_f64).exp())) - 1.0).abs() < 1e-9);
    }
}
