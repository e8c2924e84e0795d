//! Gauss-Legendre nodes on a stretch of air, whose density falls exponentially with height.
//!
//! A short stretch takes the rule as it is. On a long one, or one that leads far up, the density varies
//! by orders of magnitude; the substitution
//! s = D (e^(a u) - 1) / (e^a - 1),   a = 3
//! D the stretch's length, crowds the nodes at its dense end. The light of whole skies, hazy and clear,
//! has with 8 such nodes the error, 3e-5 to 3e-4, for which s = D u² takes 12; a of 2 to 6 was tried. A
//! ray that passes a lowest point is dense there and is cut in two.

use std::num::NonZeroUsize;

use niji_geometry::Planet;
use niji_radiometry::gauss_legendre;

/// Beyond this length nodes are crowded at the dense end.
const LONG_M: f64 = 30_000.0;

/// Beyond this change of height too: haze has scale heights of little more.
const HIGH_M: f64 = 1_000.0;

/// `a` of the substitution.
const CROWDING: f64 = 3.0;

/// A rule on 0..1, nodes ascending.
#[derive(Clone, Debug)]
pub(crate) struct GaussRule {
    nodes: Vec<(f64, f64)>,
    /// The same after the substitution: places on 0..1 and weights.
    crowded: Vec<(f64, f64)>,
}

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

/// A stretch of a ray on which the nodes of one rule stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AirStretch {
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
    dense: Dense,
}

/// Where nodes are crowded.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dense {
    Nowhere,
    Everywhere,
    AtStart,
    AtEnd,
}

impl AirStretch {
    /// The stretches of a range of a ray: none if it is empty, two if it holds the lowest point.
    pub(crate) fn of_range(
        planet: Planet,
        ray: AirRay,
        (from_m, to_m): (f64, f64),
    ) -> impl Iterator<Item = Self> {
        let stretch = |from_m: f64, to_m: f64, dense: Dense| {
            (to_m > from_m).then_some(Self {
                from_m,
                to_m,
                dense,
            })
        };
        let lowest_m = -(planet.radius_m + ray.height_m) * ray.cos_zenith;
        let lowest_m = lowest_m.clamp(from_m, to_m.max(from_m));
        let length_m = to_m - from_m;
        let parts = if length_m <= LONG_M && length_m * ray.cos_zenith.abs() <= HIGH_M {
            [stretch(from_m, to_m, Dense::Nowhere), None]
        } else {
            [
                stretch(from_m, lowest_m, Dense::AtEnd),
                stretch(lowest_m, to_m, Dense::AtStart),
            ]
        };
        parts.into_iter().flatten()
    }

    /// A piece of a ray in deep air.
    pub(crate) fn deep(from_m: f64, to_m: f64) -> Self {
        Self {
            from_m,
            to_m,
            dense: Dense::Everywhere,
        }
    }

    /// Its length (m).
    pub(crate) fn length_m(&self) -> f64 {
        self.to_m - self.from_m
    }

    /// Whether nodes are crowded at one of its ends.
    pub(crate) fn is_crowded(&self) -> bool {
        matches!(self.dense, Dense::AtStart | Dense::AtEnd)
    }

    /// Whether it has as many nodes as a long one.
    pub(crate) fn is_dense(&self) -> bool {
        self.dense != Dense::Nowhere
    }

    /// Distance of a place on 0..1 (m).
    pub(crate) fn distance_m(&self, place: f64) -> f64 {
        match self.dense {
            Dense::Nowhere | Dense::Everywhere => self.from_m + self.length_m() * place,
            Dense::AtStart => self.from_m + self.length_m() * crowd(place).0,
            Dense::AtEnd => self.to_m - self.length_m() * crowd(1.0 - place).0,
        }
    }
}

/// The substitution and its derivative.
fn crowd(place: f64) -> (f64, f64) {
    let whole = CROWDING.exp_m1();
    let part = (CROWDING * place).exp_m1();
    (part / whole, CROWDING * (part + 1.0) / whole)
}

impl GaussRule {
    /// The rule with `n` nodes.
    pub(crate) fn new(n: NonZeroUsize) -> Self {
        let rule = gauss_legendre(n.get()).into_iter();
        let nodes: Vec<(f64, f64)> = rule
            .map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight))
            .collect();
        let crowded = nodes.iter().map(|(x, weight)| {
            let (place, slope) = crowd(*x);
            (place, slope * weight)
        });
        Self {
            crowded: crowded.collect(),
            nodes,
        }
    }

    /// Positions and weights on 0..1.
    pub(crate) fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes
    }

    /// Append the nodes of a stretch, ascending.
    pub(crate) fn place(&self, stretch: &AirStretch, out: &mut Vec<RayNode>) {
        let length_m = stretch.length_m();
        let after = |(place, weight): &(f64, f64)| RayNode {
            distance_m: stretch.from_m + length_m * place,
            weight_m: length_m * weight,
        };
        let before = |(place, weight): &(f64, f64)| RayNode {
            distance_m: stretch.to_m - length_m * place,
            weight_m: length_m * weight,
        };
        match stretch.dense {
            Dense::Nowhere | Dense::Everywhere => out.extend(self.nodes.iter().map(after)),
            Dense::AtStart => out.extend(self.crowded.iter().map(after)),
            Dense::AtEnd => out.extend(self.crowded.iter().rev().map(before)),
        }
    }
}

#[cfg(test)]
mod tests {
    use niji_geometry::EARTH;

    use super::*;

    fn nodes(n: usize, ray: AirRay, range_m: (f64, f64)) -> Vec<RayNode> {
        let mut out = Vec::new();
        let rule = GaussRule::new(NonZeroUsize::new(n).unwrap());
        for stretch in AirStretch::of_range(EARTH, ray, range_m) {
            rule.place(&stretch, &mut out);
        }
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
    fn places_of_a_stretch_are_those_of_its_nodes() {
        for (cos_zenith, range_m) in [(0.01, (5.0, 100.0)), (0.3, (0.0, 9e5)), (-0.4, (0.0, 8e3))] {
            let ray = AirRay {
                height_m: 3_000.0,
                cos_zenith,
            };
            let stretch = AirStretch::of_range(EARTH, ray, range_m).next().unwrap();
            let rule = GaussRule::new(NonZeroUsize::new(5).unwrap());
            let places = rule.nodes().iter().map(|(place, _)| *place);
            for (place, node) in places.zip(nodes(5, ray, range_m)) {
                let distance_m = stretch.distance_m(place);
                assert!((distance_m / node.distance_m - 1.0).abs() < 1e-12);
            }
            let ends_m = (stretch.distance_m(0.0), stretch.distance_m(1.0));
            assert!((ends_m.0 - range_m.0).abs() < 1e-9 && (ends_m.1 - range_m.1).abs() < 1e-9);
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
