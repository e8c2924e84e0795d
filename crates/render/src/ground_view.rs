//! What level ground sees around it, looked for at nodes of a grid.
//!
//! Cells are squares along the axes of the world, as wide as cells of nodes are (`node_views`) to the nearest power of two (m).

use glam::DVec2;
use glam::DVec3;

use crate::node_views::NodeViews;
use crate::node_views::Seen;
use crate::node_views::View;
use crate::node_views::between;

/// Nodes lie at fewer steps from the origin than this, so that floating point knows them.
const MOST_STEPS: f64 = (1_u64 << 40) as f64;

/// A node by the power of two of its cells, and steps from the origin.
type Key = (i32, [i64; 2]);

/// Ground whose nodes look around.
#[derive(Debug)]
pub(crate) struct GroundView {
    known: NodeViews<Key>,
}

impl GroundView {
    /// Ground of which nobody has asked yet.
    pub(crate) fn new() -> Self {
        let known = NodeViews::new();
        Self { known }
    }

    /// What a point of the ground sees, where `look` tells it of a node by east and south; `None` where nodes do not know.
    pub(crate) fn at(
        &self,
        point: DVec3,
        seen: Seen,
        look: impl Fn(DVec2) -> View,
    ) -> Option<View> {
        let power = seen.cell_m().log2().round();
        let cell_m = power.exp2();
        let place = DVec2::new(point.x, point.z) / cell_m;
        let is_known = place.abs().max_element() < MOST_STEPS;
        if !is_known {
            return None;
        }
        let first = place.floor();
        let DVec2 { x: right, y: down } = place - first;
        let node = |steps: DVec2, weight: f64| {
            let steps = first + steps;
            let key = (power as i32, steps.to_array().map(|step| step as i64));
            (weight > 0.0).then(|| (self.known.of(key, || look(cell_m * steps)), weight))
        };
        between(&[
            node(DVec2::ZERO, (1.0 - right) * (1.0 - down)),
            node(DVec2::X, right * (1.0 - down)),
            node(DVec2::Y, (1.0 - right) * down),
            node(DVec2::ONE, right * down),
        ])
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    const PIXEL: Seen = Seen {
        pixel_m: 0.1,
        cosine: 1.0,
    };

    #[test]
    fn shares_that_change_evenly_are_those_of_the_place() {
        let view = GroundView::new();
        let even = |place: DVec2| View {
            free: 0.5 + 0.01 * place.x - 0.005 * place.y,
            ..View::OPEN
        };
        for (x, z) in [(0.0, 0.0), (-3.21, 7.9), (12.0, -0.001), (4.0, 5.5)] {
            let found = view.at(DVec3::new(x, -1.0, z), PIXEL, even).unwrap();
            let expected = even(DVec2::new(x, z)).free;
            assert!((found.free - expected).abs() < 1e-12, "{x} {z}");
        }
        assert!(view.at(DVec3::splat(1e30), PIXEL, even).is_none());
    }

    #[test]
    fn neighbors_share_nodes_and_each_looks_once() {
        let view = GroundView::new();
        let n_looks = Cell::new(0);
        // Cells are half a metre wide.
        for x in [0.1, 0.2, 0.3, 0.6] {
            let point = DVec3::new(x, 0.0, 0.1);
            let _ = view.at(point, PIXEL, |_| {
                n_looks.set(n_looks.get() + 1);
                View::OPEN
            });
        }
        assert_eq!(n_looks.get(), 6);
    }
}
