//! Values that somebody has for every node, as optical depths towards the sun.

use std::convert::Infallible;

use glam::DVec3;
use rayon::prelude::*;

use super::BRICK_DIM;
use super::Bricks;
use super::Interpolation;
use super::NODES_PER_BRICK;
use crate::brick_layout::node_in_brick;
use crate::coarse_cells::CoarseErrors;

/// A value for every node of every brick, in the bricks' own order.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeValues(Vec<f32>);

impl Bricks {
    /// Evaluate a function at the world position of every node (in parallel by brick). Nodes that
    /// bricks share are asked once for each.
    pub fn at_nodes(&self, value: impl Fn(DVec3) -> f32 + Sync) -> NodeValues {
        let go_on = || Ok::<_, Infallible>(());
        self.at_nodes_while(go_on, value)
            .unwrap_or_else(|never| match never {})
    }

    /// The same, unless `go_on` refuses, which is asked before each brick.
    ///
    /// # Errors
    /// What `go_on` says.
    pub fn at_nodes_while<E: Send>(
        &self,
        go_on: impl Fn() -> Result<(), E> + Sync,
        value: impl Fn(DVec3) -> f32 + Sync,
    ) -> Result<NodeValues, E> {
        let mut values = vec![0.0; self.nodes.len()];
        values
            .par_chunks_mut(NODES_PER_BRICK)
            .zip(&self.places)
            .try_for_each(|(values, place)| {
                go_on()?;
                for (index, slot) in values.iter_mut().enumerate() {
                    let node = *place * BRICK_DIM + node_in_brick(index);
                    *slot = value(self.origin_m + node.as_dvec3() * self.voxel_m);
                }
                Ok(())
            })?;
        Ok(NodeValues(values))
    }

    /// Set the optical depth towards the sun at all nodes; until then it is 0, and no cell is coarse.
    ///
    /// # Panics
    /// If the values are not those of [`Bricks::at_nodes`] of these bricks.
    pub fn set_tau_sun(&mut self, values: &NodeValues) {
        assert_eq!(
            values.0.len(),
            self.nodes.len(),
            "values must belong to these bricks"
        );
        let bricks = self.nodes.par_chunks_mut(NODES_PER_BRICK);
        let depths = values.0.par_chunks(NODES_PER_BRICK);
        let errors = &mut self.coarse_errors;
        let of_moments = self.interpolation == Interpolation::Moments;
        let bricks = bricks.zip(depths).zip(errors);
        bricks.for_each(|((nodes, depths), errors)| {
            for (node, depth) in nodes.iter_mut().zip(depths) {
                node.w = *depth;
            }
            if of_moments {
                *errors = CoarseErrors::of(nodes);
            }
        });
    }
}
