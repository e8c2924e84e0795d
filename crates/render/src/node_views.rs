//! What places see around them, looked for at nodes between which they lie.
//!
//! x(P) = sum_i w_i x(P_i),   s = 4 p d/sqrt(c)
//! `x` shares of sky and ground that surfaces leave and what these send, as the face sees them; `P` a place, `P_i` nodes around
//! it, `w_i` their weights, `s` width of a cell of nodes, `p` what a pixel is wide, `d` distance from the eye, `c` cosine of the
//! sight to the normal: a cell has about the area of sixteen pixels. Where nodes disagree, or see no sky as one inside of
//! what stands on the surface, the place looks for itself.
//!
//! What a node sees depends on nothing but the surfaces, so it does not matter which ray asks first, and whether it is
//! forgotten and looked for again.

use std::collections::HashMap;
use std::hash::BuildHasher;
use std::hash::BuildHasherDefault;
use std::hash::DefaultHasher;
use std::hash::Hash;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::PoisonError;

use crate::sent_light::Senders;

/// How many pixels a cell is wide.
const PIXELS_OF_CELL: f64 = 4.0;

/// Least cosine at which a surface is seen, for cells.
const LEAST_COSINE: f64 = 1.0 / 16.0;

/// By how much shares of nodes may differ for the places between them.
const MOST_CHANGE: f64 = 0.2;

/// Parts of what is kept, and of how many nodes each may be.
const N_PARTS: usize = 64;
const MOST_IN_PART: usize = 8192;

/// What a face sees around it.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// Share of the sky that surfaces leave.
    pub(crate) free: f64,
    /// Share of what lies below the horizon that surfaces are.
    pub(crate) below: f64,
    /// What they send.
    pub(crate) senders: Senders,
}

impl View {
    /// Nothing but sky and ground.
    pub(crate) const OPEN: Self = Self {
        free: 1.0,
        below: 0.0,
        senders: Senders::NONE,
    };
}

/// How a place is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// What a pixel is wide there (m).
    pub(crate) pixel_m: f64,
    /// Cosine of the sight to its normal.
    pub(crate) cosine: f64,
}

impl Seen {
    /// Width of a cell of nodes there.
    pub(crate) fn cell_m(self) -> f64 {
        PIXELS_OF_CELL * self.pixel_m / self.cosine.max(LEAST_COSINE).sqrt()
    }
}

/// What a place sees between nodes, of which some may not count, by their weights; `None` where they do not know.
pub(crate) fn between(views: &[Option<(Arc<View>, f64)>]) -> Option<View> {
    let views = || views.iter().flatten();
    let spread = |share: fn(&View) -> f64| {
        let shares = || views().map(|(view, _)| share(view));
        shares().fold(0.0, f64::max) - shares().fold(1.0, f64::min)
    };
    let are_dark = views().any(|(view, _)| view.free <= 0.0);
    if are_dark || spread(|it| it.free).max(spread(|it| it.below)) > MOST_CHANGE {
        return None;
    }
    let mut mean = View {
        free: 0.0,
        ..View::OPEN
    };
    for (view, weight) in views() {
        mean.free += weight * view.free;
        mean.below += weight * view.below;
        mean.senders.add_all(&view.senders, *weight as f32);
    }
    Some(mean)
}

/// What nodes see, once they have looked.
#[derive(Debug)]
pub(crate) struct NodeViews<K> {
    parts: Vec<Mutex<HashMap<K, Arc<View>>>>,
}

impl<K: Eq + Hash> NodeViews<K> {
    /// Of none.
    pub(crate) fn new() -> Self {
        Self {
            parts: (0..N_PARTS).map(|_| Mutex::default()).collect(),
        }
    }

    /// What a node sees, which looks unless it is known.
    pub(crate) fn of(&self, node: K, look: impl Fn() -> View) -> Arc<View> {
        let hash = BuildHasherDefault::<DefaultHasher>::default().hash_one(&node);
        let part = &self.parts[hash as usize % N_PARTS];
        let known = || part.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(view) = known().get(&node) {
            return Arc::clone(view);
        }
        // Nobody waits for it: two may look at once, and see the same.
        let view = Arc::new(look());
        let mut known = known();
        if known.len() >= MOST_IN_PART {
            known.clear();
        }
        known.insert(node, Arc::clone(&view));
        view
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_kept_to_a_number_and_those_forgotten_see_the_same() {
        let views = NodeViews::new();
        let look = |node: u32| View {
            free: f64::from(node).sin(),
            ..View::OPEN
        };
        for node in 0..1_000_000 {
            let _ = views.of(node, || look(node));
        }
        let parts = views.parts.iter();
        let n_known: usize = parts.map(|it| it.lock().unwrap().len()).sum();
        assert!(n_known <= N_PARTS * MOST_IN_PART && n_known > N_PARTS);
        for node in 0..1000 {
            assert_eq!(views.of(node, || look(node)).free, look(node).free);
        }
    }

    #[test]
    fn a_mean_is_by_weights_and_only_of_nodes_that_agree() {
        let node = |free: f64, weight: f64| {
            let view = View { free, ..View::OPEN };
            Some((Arc::new(view), weight))
        };
        let mean = between(&[node(0.5, 0.25), None, node(0.6, 0.75)]).unwrap();
        assert!((mean.free - 0.575).abs() < 1e-12);
        assert!(between(&[node(0.5, 0.5), node(0.8, 0.5)]).is_none());
        assert!(between(&[node(0.0, 1.0), None]).is_none());
    }
}
