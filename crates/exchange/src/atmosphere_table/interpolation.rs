//! Cubic interpolation on an axis with any spacing.
//!
//! f(x) = sum over 4 neighbouring nodes of  f_i * prod over j != i of (x - x_j)/(x_i - x_j)
//! Lagrange's formula; error (spacing)^4 f''''/24 at most. Outside the axis the value at its end is
//! held, so that a table never extrapolates. Axes of fewer than 4 nodes use what they have.

/// The nodes around one place on an axis, with their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    first: usize,
    n_nodes: usize,
    weights: [f64; 4],
}

impl Stencil {
    /// Nodes and weights for `x` on a rising axis.
    ///
    /// # Panics
    /// If the axis is empty.
    pub fn new(axis: &[f64], x: f64) -> Self {
        let n_nodes = axis.len().min(4);
        let above = axis.partition_point(|&node| node <= x);
        let first = above.saturating_sub(2).min(axis.len() - n_nodes);
        let x = x.clamp(axis[0], axis[axis.len() - 1]);
        let weights = match axis[first..first + n_nodes] {
            [a, b, c, d] => cubic_weights([a, b, c, d], x),
            ref nodes => weights_of_few(nodes, x),
        };
        Self {
            first,
            n_nodes,
            weights,
        }
    }

    /// Indices of the nodes in the order of the axis, and their weights.
    pub fn weighted_nodes(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        (self.first..self.first + self.n_nodes).zip(self.weights)
    }

    /// Weighted sum of what `value` gives at the nodes, in the order of the axis.
    pub(super) fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.weighted_nodes()
            .map(|(node, weight)| weight * value(node))
            .sum()
    }
}

/// Lagrange's weights of four nodes.
fn cubic_weights([a, b, c, d]: [f64; 4], x: f64) -> [f64; 4] {
    let (xa, xb, xc, xd) = (x - a, x - b, x - c, x - d);
    [
        xb * xc * xd / ((a - b) * (a - c) * (a - d)),
        xa * xc * xd / ((b - a) * (b - c) * (b - d)),
        xa * xb * xd / ((c - a) * (c - b) * (c - d)),
        xa * xb * xc / ((d - a) * (d - b) * (d - c)),
    ]
}

/// Lagrange's weights of fewer nodes, followed by zeros.
fn weights_of_few(nodes: &[f64], x: f64) -> [f64; 4] {
    let mut weights = [0.0; 4];
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

    fn interpolate(axis: &[f64], x: f64, f: impl Fn(f64) -> f64) -> f64 {
        Stencil::new(axis, x).sum(|node| f(axis[node]))
    }

    #[test]
    fn a_cubic_is_reproduced_on_any_spacing() {
        let axis = [-1.0, 0.0, 0.1, 0.5, 2.0, 7.0];
        let cubic = |x: f64| 3.0 - x + 0.5 * x * x - 0.25 * x * x * x;
        for x in [-1.0, -0.3, 0.05, 0.1, 1.9, 6.5, 7.0] {
            let error = interpolate(&axis, x, cubic) - cubic(x);
            assert!(error.abs() < 1e-12, "{x}: {error}");
        }
    }

    #[test]
    fn outside_the_axis_the_end_is_held() {
        let axis = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert!((interpolate(&axis, -5.0, |x| x) - 0.0).abs() < 1e-15);
        assert!((interpolate(&axis, 9.0, |x| x) - 4.0).abs() < 1e-15);
    }

    #[test]
    fn short_axes_use_what_they_have() {
        assert!((interpolate(&[2.0], 1.0, |x| x) - 2.0).abs() < 1e-15);
        assert!((interpolate(&[2.0, 4.0], 3.0, |x| x) - 3.0).abs() < 1e-15);
    }
}
