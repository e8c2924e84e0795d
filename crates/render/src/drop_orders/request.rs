//! What light of further orders is made from.

use glam::DVec3;
use niji_exchange::ScatteringTable;

use crate::air::Air;
use crate::deadline::Deadline;
use crate::lit_drops::LitDrops;
use crate::progress::Progress;

use super::view_grid::SeenDirections;

/// What the light is found from.
pub(crate) struct OrdersRequest<'a> {
    /// The drops with their shadows.
    pub(crate) drops: &'a LitDrops,
    /// Their phase functions.
    pub(crate) table: &'a ScatteringTable,
    /// Towards the sun.
    pub(crate) sun_direction: DVec3,
    /// Where view rays start.
    pub(crate) eye: DVec3,
    /// Where they go.
    pub(crate) seen: &'a SeenDirections,
    /// Air that dims sunlight; `None` if it does not.
    pub(crate) sunlight_air: Option<&'a Air<'a>>,
    /// Air that dims the view; `None` if it does not.
    pub(crate) view_air: Option<&'a Air<'a>>,
    /// Weights that turn a spectrum for unit irradiance into luminance in the sun [cd/m²].
    pub(crate) luminance_weights: &'a [f64],
    /// Directions along both sides of the coarse lattice.
    pub(crate) nodes_across: usize,
    /// Paths of a direction of it and stratum, where no error is allowed.
    pub(crate) paths_per_node: usize,
    /// What they may err by, RMS over the directions [cd/m²]: not more are followed, nor sixteen times as many.
    pub(crate) allowed_cd_m2: Option<f64>,
    /// When they are enough whatever their noise is.
    pub(crate) deadline: Deadline<'a>,
    /// Whoever waits for it.
    pub(crate) progress: Progress<'a>,
}
