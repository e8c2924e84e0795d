//! Gauss-Legendre quadrature on 0..1, with running integrals at its own nodes.
//!
//! integral over 0..1 of f  =  sum w_j f(x_j)
//! integral over 0..x_i of f  =  sum over j of A_ij f(x_j)
//! A_ij = w_j/2 [1 + t_i + sum over k = 1..n-1 of P_k(t_j) (P_k+1(t_i) - P_k-1(t_i))],  t = 2 x - 1:
//! the polynomial of degree n - 1 through the nodes, integrated. One set of samples so gives both an
//! integral and the optical depth at every sample on the way.
//! [AS64] Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 25.4.29 and 22.7.10.

use niji_radiometry::gauss_legendre;

/// Nodes and weights on 0..1 and the matrix of running integrals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// Row by row: `running[i * n + j]` = A_ij.
    running: Vec<f64>,
}

impl Rule {
    /// The rule of `n_nodes` nodes, at least 1.
    pub(crate) fn new(n_nodes: usize) -> Self {
        let pairs = gauss_legendre(n_nodes.max(1));
        let t: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        let weights: Vec<f64> = pairs.iter().map(|pair| 0.5 * pair.1).collect();
        let legendre: Vec<Vec<f64>> = t.iter().map(|&t| legendre_up_to(t, pairs.len())).collect();
        let mut running = Vec::with_capacity(t.len() * t.len());
        for (i, p_i) in legendre.iter().enumerate() {
            for (j, p_j) in legendre.iter().enumerate() {
                let terms = (1..t.len()).map(|k| p_j[k] * (p_i[k + 1] - p_i[k - 1]));
                running.push(0.5 * weights[j] * (1.0 + t[i] + terms.sum::<f64>()));
            }
        }
        Self {
            nodes: t.iter().map(|t| 0.5 * (1.0 + t)).collect(),
            weights,
            running,
        }
    }

    /// A rule of nodes in rising order on 0..1 and weights from elsewhere; running integrals are those
    /// of the polynomial through the nodes.
    pub(crate) fn through(nodes: Vec<f64>, weights: Vec<f64>) -> Self {
        // Exact up to the degree of that polynomial.
        let exact = Self::new(nodes.len().div_ceil(2));
        let mut running = Vec::with_capacity(nodes.len() * nodes.len());
        for &end in &nodes {
            for j in 0..nodes.len() {
                running.push(exact.integrate(0.0, end, |x| cardinal(&nodes, j, x)));
            }
        }
        Self {
            nodes,
            weights,
            running,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Nodes and weights in rising order.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().copied().zip(self.weights.iter().copied())
    }

    /// Integral of `f` from `from` to `to`.
    pub(crate) fn integrate(&self, from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        let width = to - from;
        self.pairs()
            .map(|(x, weight)| width * weight * f(from + width * x))
            .sum()
    }

    /// Integral over 0..1 of samples at the nodes.
    pub(crate) fn total(&self, samples: &[f64]) -> f64 {
        self.weights
            .iter()
            .zip(samples)
            .map(|(weight, sample)| weight * sample)
            .sum()
    }

    /// Integral from 0 to node `i` of samples at the nodes.
    pub(crate) fn running(&self, i: usize, samples: &[f64]) -> f64 {
        let row = &self.running[i * self.len()..(i + 1) * self.len()];
        row.iter()
            .zip(samples)
            .map(|(weight, sample)| weight * sample)
            .sum()
    }
}

/// Legendre polynomials of degree 0 to n at t, by the recurrence (AS64, 22.7.10).
fn legendre_up_to(t: f64, n: usize) -> Vec<f64> {
    let mut p = vec![1.0, t];
    for k in 1..n {
        let k_f = k as f64;
        p.push(((2.0 * k_f + 1.0) * t * p[k] - k_f * p[k - 1]) / (k_f + 1.0));
    }
    p
}

/// Lagrange's polynomial that is 1 at node `j` and 0 at the others.
fn cardinal(nodes: &[f64], j: usize, x: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|&(i, _)| i != j);
    others
        .map(|(_, node)| (x - node) / (nodes[j] - node))
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_integrals_of_a_polynomial_are_exact() {
        for n_nodes in [1, 2, 5, 16, 40] {
            let rule = Rule::new(n_nodes);
            let degree = n_nodes as i32 - 1;
            let samples: Vec<f64> = rule.pairs().map(|(x, _)| x.powi(degree)).collect();
            for (i, (x, _)) in rule.pairs().enumerate() {
                let exact = x.powi(degree + 1) / f64::from(degree + 1);
                let error = rule.running(i, &samples) - exact;
                assert!(error.abs() < 1e-14, "{n_nodes} nodes: {error}");
            }
        }
    }

    #[test]
    fn an_exponential_is_integrated_to_rounding() {
        let rule = Rule::new(16);
        let found = rule.integrate(0.0, 3.0, |x| (-x).exp());
        assert!((found - (1.0 - (-3.0_f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn no_nodes_are_one_node() {
        assert_eq!(Rule::new(0).len(), 1);
    }
}
