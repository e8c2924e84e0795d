//! What drops let pass of light that is sent from between them.
//!
//! int_0^1 g(u) T(u) du ~ sum_i w_i g(x_i) T_i,   T_i = (1/w_i) int_0^1 l_i(u) T(u) du
//!
//! `g` light that the air sends towards the eye, smooth enough for the few nodes `x_i` of a Gauss rule
//! with weights `w_i` and polynomials of Lagrange `l_i`; `T = exp(-tau)` transmittance of the drops in
//! front, which may fall from 1 to 0 between two nodes. The depth `tau` is known at the ends of parts of
//! 0..1, the shorter the nearer they are to the eye, whose light counts most; in a part it is taken as
//! linear, and so is `l_i`, with its own mean:
//! int l T du = D [mean(l) mean(T) + (l_end - l_start) M],   M = int_0^1 (x - 1/2) T dx
//! `D` length of the part, `x` place in it. The same with pairs of parts as parts tells the error.

use crate::gauss_nodes::GaussRule;

/// Below this change of depth T is linear: its mean is 1e-9 off.
const SAME_DEPTH: f64 = 1e-4;

/// Transmittance as a node of the air has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeTransmittance {
    /// `T_i`.
    pub(crate) transmittance: f64,
    /// What it exceeds that of half as many parts by.
    pub(crate) change: f64,
}

impl NodeTransmittance {
    /// Behind drops of a transmittance, or without any (1).
    pub(crate) fn by(transmittance: f64) -> Self {
        Self {
            transmittance,
            change: 0.0,
        }
    }
}

/// What a part lets pass: the mean of T and its moment `M`.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    mean: f64,
    moment: f64,
}

impl Part {
    /// Between two places by depth and transmittance.
    fn between((from_depth, from): (f64, f64), (to_depth, to): (f64, f64)) -> Self {
        let change = to_depth - from_depth;
        if change < SAME_DEPTH {
            return Self {
                mean: 0.5 * (from + to),
                moment: (to - from) / 12.0,
            };
        }
        let mean = (from - to) / change;
        Self {
            mean,
            moment: (mean - to) / change - 0.5 * mean,
        }
    }
}

/// How a part counts at a node: (1/w_i) int l_i du, and (1/w_i) D (l_end - l_start).
#[derive(Clone, Copy, Debug)]
struct Share {
    of_mean: f64,
    of_moment: f64,
}

/// Room to work in.
#[derive(Clone, Debug, Default)]
pub(crate) struct FrontRoom {
    /// Depth and transmittance at the ends of parts.
    ends: Vec<(f64, f64)>,
    parts: Vec<Part>,
    pairs: Vec<Part>,
}

/// How the transmittances of parts, and of pairs of them, count at the nodes of a rule.
#[derive(Clone, Debug)]
pub(crate) struct FrontTransmittance {
    n_parts: usize,
    /// By node, then part.
    of_parts: Vec<Share>,
    of_pairs: Vec<Share>,
}

impl FrontTransmittance {
    /// For the nodes of a rule and an even number of parts.
    pub(crate) fn new(rule: &GaussRule, n_parts: usize) -> Self {
        let n_nodes = rule.nodes().len();
        let by_node = |n_parts: usize| {
            let nodes = rule.nodes().iter();
            nodes
                .flat_map(|(place, _)| shares(*place, n_nodes, n_parts))
                .collect()
        };
        Self {
            n_parts,
            of_parts: by_node(n_parts),
            of_pairs: by_node(n_parts / 2),
        }
    }

    /// Places on 0..1 where the depth is wanted: the ends of the parts.
    pub(crate) fn places(&self) -> impl Iterator<Item = f64> {
        let n_parts = self.n_parts;
        (0..=n_parts).map(move |index| end_of_part(index, n_parts))
    }

    /// Append what the nodes have, from the depths at [`FrontTransmittance::places`].
    pub(crate) fn over(
        &self,
        depths: impl Iterator<Item = f64>,
        room: &mut FrontRoom,
        out: &mut Vec<NodeTransmittance>,
    ) {
        let FrontRoom { ends, parts, pairs } = room;
        ends.clear();
        ends.extend(depths.map(|depth| (depth, (-depth).exp())));
        parts.clear();
        parts.extend(ends.windows(2).map(|ends| Part::between(ends[0], ends[1])));
        pairs.clear();
        let of_pairs = ends.windows(3).step_by(2);
        pairs.extend(of_pairs.map(|ends| Part::between(ends[0], ends[2])));
        let nodes = self.of_parts.chunks(parts.len());
        out.extend(
            nodes
                .zip(self.of_pairs.chunks(pairs.len()))
                .map(|(of_parts, of_pairs)| {
                    let transmittance = sum(of_parts, parts);
                    NodeTransmittance {
                        transmittance,
                        change: transmittance - sum(of_pairs, pairs),
                    }
                }),
        );
    }
}

/// Where a part of 0..1 starts.
fn end_of_part(index: usize, n_parts: usize) -> f64 {
    let place = index as f64 / n_parts as f64;
    place * place
}

fn sum(shares: &[Share], parts: &[Part]) -> f64 {
    let terms = shares.iter().zip(parts);
    terms
        .map(|(share, part)| share.of_mean * part.mean + share.of_moment * part.moment)
        .sum()
}

/// Shares of parts at a node of a rule of `n_nodes`. With Legendre polynomials on -1..1
/// l_i(x) = w_i sum_k (2k + 1) P_k(x_i) P_k(x),   (2k + 1) int P_k dx = P_(k+1) - P_(k-1).
fn shares(place: f64, n_nodes: usize, n_parts: usize) -> impl Iterator<Item = Share> {
    let at_node = legendre(place, n_nodes);
    (0..n_parts).map(move |part| {
        let [start, end] = [part, part + 1].map(|index| end_of_part(index, n_parts));
        let (at_start, at_end) = (legendre(start, n_nodes), legendre(end, n_nodes));
        let integral = |k: usize| {
            let before = |values: &[f64]| if k == 0 { 0.0 } else { values[k - 1] };
            (at_end[k + 1] - before(&at_end)) - (at_start[k + 1] - before(&at_start))
        };
        let change = |k: usize| (2.0 * k as f64 + 1.0) * (at_end[k] - at_start[k]);
        let sum = |of_degree: &dyn Fn(usize) -> f64| -> f64 {
            (0..n_nodes).map(|k| at_node[k] * of_degree(k)).sum()
        };
        Share {
            // Half: 0..1 is half as long as -1..1.
            of_mean: 0.5 * sum(&integral),
            of_moment: (end - start) * sum(&change),
        }
    })
}

/// Legendre polynomials of degree 0 to n at a place of 0..1, which stands for -1..1.
fn legendre(place: f64, n: usize) -> Vec<f64> {
    let x = 2.0 * place - 1.0;
    let mut values = vec![1.0, x];
    for k in 1..n {
        let k_f64 = k as f64;
        values.push(((2.0 * k_f64 + 1.0) * x * values[k] - k_f64 * values[k - 1]) / (k_f64 + 1.0));
    }
    values
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use super::*;

    /// int g T du by a rule of n nodes, and what it changed by, for a depth along the way.
    fn integral(n: usize, g: impl Fn(f64) -> f64, depth: impl Fn(f64) -> f64) -> (f64, f64) {
        let rule = GaussRule::new(NonZeroUsize::new(n).unwrap());
        let front = FrontTransmittance::new(&rule, 16);
        let mut transmittances = Vec::new();
        front.over(
            front.places().map(depth),
            &mut FrontRoom::default(),
            &mut transmittances,
        );
        assert_eq!(transmittances.len(), n);
        let terms = rule.nodes().iter().zip(&transmittances);
        terms.fold((0.0, 0.0), |sum, ((x, weight), in_front)| {
            let light = weight * g(*x);
            (
                sum.0 + light * in_front.transmittance,
                sum.1 + light * in_front.change,
            )
        })
    }

    #[test]
    fn without_drops_the_rule_is_gauss() {
        for n in [1, 2, 3, 10, 24] {
            let (found, change) = integral(n, |u| u, |_| 0.0);
            assert!((found - 0.5).abs() < 1e-12 && change.abs() < 1e-12, "{n}");
        }
    }

    #[test]
    fn even_drops_of_any_thickness_have_the_closed_form() {
        for depth in [1e-9_f64, 1e-3, 0.5, 4.0, 60.0, 1e4] {
            let expected = -(-depth).exp_m1() / depth;
            for n in [1, 3, 7] {
                let (found, _) = integral(n, |_| 1.0, |u| depth * u);
                assert!(
                    (found / expected - 1.0).abs() < 1e-8,
                    "{n} {depth}: {found}"
                );
            }
            // int u exp(-D u) du.
            let expected = (1.0 - (1.0 + depth) * (-depth).exp()) / (depth * depth);
            if depth > 1e-4 {
                let (found, _) = integral(2, |u| u, |u| depth * u);
                assert!((found / expected - 1.0).abs() < 1e-8, "{depth}: {found}");
            }
        }
    }

    #[test]
    fn a_curtain_between_two_nodes_is_met_and_its_error_told() {
        // All drops in 0.3 to 0.3 + width; before it all light passes, behind it exp(-3).
        for (width, most) in [(0.2, 5e-3), (0.05, 2e-2), (1e-3, 1.0 / 32.0)] {
            let depth = |u: f64| 3.0 * ((u - 0.3) / width).clamp(0.0, 1.0);
            let steps = 1_000_000;
            let expected = (0..steps)
                .map(|step| (-depth((f64::from(step) + 0.5) / f64::from(steps))).exp())
                .sum::<f64>()
                / f64::from(steps);
            for n in [1, 3] {
                let (found, change) = integral(n, |_| 1.0, depth);
                let error = (found - expected).abs();
                assert!(
                    error < 2.0 * change.abs() && error < most,
                    "{width}: {error} {change}"
                );
            }
        }
    }
}
