//! A function that is linear between nodes and constant outside them.
//!
//! y(x) = y_i (1 - t) + y_{i+1} t,  t = (x - x_i)/(x_{i+1} - x_i)
//! Means over an interval are exact: the trapezoid rule on every piece.

/// Nodes with increasing abscissas, at least one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PiecewiseLinear {
    nodes: Vec<(f64, f64)>,
}

impl PiecewiseLinear {
    /// The function through `nodes`, which the caller has checked: one at least, increasing.
    pub(crate) fn new(nodes: Vec<(f64, f64)>) -> Self {
        debug_assert!(!nodes.is_empty(), "a function needs a node");
        debug_assert!(
            nodes.windows(2).all(|pair| pair[0].0 < pair[1].0),
            "nodes must increase"
        );
        Self { nodes }
    }

    /// The nodes, in increasing order.
    pub(crate) fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes
    }

    /// The value at `x`; outside the nodes that of the nearest end, NaN for NaN.
    pub(crate) fn at(&self, x: f64) -> f64 {
        if x.is_nan() {
            return f64::NAN;
        }
        let upper = self.nodes.partition_point(|node| node.0 <= x);
        if upper == 0 {
            return self.nodes[0].1;
        }
        let (x0, y0) = self.nodes[upper - 1];
        let Some(&(x1, y1)) = self.nodes.get(upper) else {
            return y0;
        };
        let t = (x - x0) / (x1 - x0);
        y0 * (1.0 - t) + y1 * t
    }

    /// The mean over `lo..hi`, exact for this function; the value itself where they coincide.
    pub(crate) fn mean(&self, lo: f64, hi: f64) -> f64 {
        let (lo, hi) = if lo <= hi { (lo, hi) } else { (hi, lo) };
        let width = hi - lo;
        if width.is_nan() || width <= 0.0 {
            return self.at(lo);
        }
        let first = self.nodes.partition_point(|node| node.0 <= lo);
        let last = self.nodes.partition_point(|node| node.0 < hi);
        let mut integral = 0.0;
        let mut left = (lo, self.at(lo));
        for &node in self.nodes[first..last].iter().chain([&(hi, self.at(hi))]) {
            integral += 0.5 * (node.0 - left.0) * (node.1 + left.1);
            left = node;
        }
        integral / width
    }
}
