//! Interpolation through the N nodes around a place, on an axis with any spacing.
//!
//! f(x) = sum over i of  f_i * prod over j != i of (x - x_j)/(x_i - x_j)
//! On even spacing h the error is below  c h^N max|f^(N)|,  c = 0.023 for 4, 0.0049 for 6 nodes.
//! Nodes at the ends of an axis stand to one side of the place; beyond the ends the value there is
//! held.

/// The nodes around one place, with their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil<const N: usize> {
    first: usize,
    n_nodes: usize,
    weights: [f64; N],
}

impl<const N: usize> Stencil<N> {
    /// Nodes and weights for `x` on a rising axis; axes of fewer than N nodes use what they have.
    ///
    /// # Panics
    /// If the axis is empty.
    pub fn new(axis: &[f64], x: f64) -> Self {
        let n_nodes = axis.len().min(N);
        let above = axis.partition_point(|&node| node <= x);
        let first = above.saturating_sub(N / 2).min(axis.len() - n_nodes);
        let x = x.clamp(axis[0], axis[axis.len() - 1]);
        let nodes = &axis[first..first + n_nodes];
        let weights = match nodes.first_chunk() {
            Some(nodes) => weights(nodes, x),
            None => weights_of_few(nodes, x),
        };
        Self {
            first,
            n_nodes,
            weights,
        }
    }

    /// Indices of the nodes in the order of the axis, and their weights.
    pub fn weighted_nodes(&self) -> impl Iterator<Item = (usize, f64)> + use<N> {
        (self.first..self.first + self.n_nodes).zip(self.weights)
    }

    /// Weighted sum of what `value` gives at the nodes, in the order of the axis.
    pub(super) fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.weighted_nodes()
            .map(|(node, weight)| weight * value(node))
            .sum()
    }
}

/// Lagrange's weights of N nodes.
fn weights<const N: usize>(nodes: &[f64; N], x: f64) -> [f64; N] {
    std::array::from_fn(|i| {
        let (mut above, mut below) = (1.0, 1.0);
        for j in 0..N {
            if j != i {
                above *= x - nodes[j];
                below *= nodes[i] - nodes[j];
            }
        }
        above / below
    })
}

/// Lagrange's weights of fewer nodes, followed by zeros.
fn weights_of_few<const N: usize>(nodes: &[f64], x: f64) -> [f64; N] {
    let mut weights = [0.0; N];
    for (i, weight) in weights.iter_mut().enumerate().take(nodes.len()) {
        let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
        *weight = others
            .map(|(_, node)| (x - node) / (nodes[i] - node))
            .product();
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interpolate<const N: usize>(axis: &[f64], x: f64, f: impl Fn(f64) -> f64) -> f64 {
        Stencil::<N>::new(axis, x).sum(|node| f(axis[node]))
    }

    #[test]
    fn a_polynomial_of_degree_one_less_than_the_nodes_is_reproduced() {
        let axis = [-1.0, 0.0, 0.1, 0.5, 2.0, 3.0, 4.5];
        for x in [-1.0, -0.3, 0.05, 0.1, 1.9, 4.0, 4.5] {
            let cubic = |x: f64| 3.0 - x + 0.5 * x * x - 0.25 * x * x * x;
            assert!((interpolate::<4>(&axis, x, cubic) - cubic(x)).abs() < 1e-12);
            let quintic = |x: f64| cubic(x) * (1.0 - 0.1 * x * x);
            assert!((interpolate::<6>(&axis, x, quintic) - quintic(x)).abs() < 1e-11);
        }
    }

    #[test]
    fn six_nodes_follow_an_exponential_to_their_own_order() {
        let axis: Vec<f64> = (0..20).map(|i| 0.5 * f64::from(i)).collect();
        let error = |n: f64, exact: f64| (n / exact - 1.0).abs();
        let exact = 4.75_f64.exp();
        // (0.5)^4 3/128 = 1.5e-3 and (0.5)^6 5/1024 = 7.6e-5.
        assert!((1e-3..2e-3).contains(&error(interpolate::<4>(&axis, 4.75, f64::exp), exact)));
        assert!((5e-5..1e-4).contains(&error(interpolate::<6>(&axis, 4.75, f64::exp), exact)));
    }

    #[test]
    fn outside_the_axis_the_end_is_held_and_short_axes_use_what_they_have() {
        let axis = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert!((interpolate::<4>(&axis, -5.0, |x| x) - 0.0).abs() < 1e-15);
        assert!((interpolate::<6>(&axis, 9.0, |x| x) - 4.0).abs() < 1e-15);
        assert!((interpolate::<6>(&[2.0], 1.0, |x| x) - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_cubic_is_reproduced_on_any_spacing() {
        let axis = [-1.0, 0.0, 0.1, 0.5, 2.0, 7.0];
        let cubic = |x: f64| 3.0 - x + 0.5 * x * x - 0.25 * x * x * x;
        for x in [-1.0, -0.3, 0.05, 0.1, 1.9, 6.5, 7.0] {
            let error = interpolate::<4>(&axis, x, cubic) - cubic(x);
            assert!(error.abs() < 1e-12, "{x}: {error}");
        }
    }

    #[test]
    fn outside_the_axis_the_end_is_held() {
        let axis = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert!((interpolate::<4>(&axis, -5.0, |x| x) - 0.0).abs() < 1e-15);
        assert!((interpolate::<4>(&axis, 9.0, |x| x) - 4.0).abs() < 1e-15);
    }

    #[test]
    fn short_axes_use_what_they_have() {
        assert!((interpolate::<4>(&[2.0], 1.0, |x| x) - 2.0).abs() < 1e-15);
        assert!((interpolate::<4>(&[2.0, 4.0], 3.0, |x| x) - 3.0).abs() < 1e-15);
    }
}
