//! A picture in the time that there is.
//!
//! Tables get half of the time that is left, by the finest tolerance of some for which that is enough; the other half
//! goes into paths and rays ([`niji_render::Deadline`]).

use serde::Deserialize;
use serde::Serialize;

/// Tolerances that a budget chooses from, the coarsest first.
pub const TOLERANCES: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003];

/// What there was time for: with it the same picture is made again without a clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Afforded {
    /// The time that was asked for, seconds.
    pub budget_s: f64,
    /// The tolerance whose tables and effects it has.
    pub tolerance: f64,
    /// How many times larger than that asks for the error of a pixel is before it gets more rays.
    pub coarser_rays: f64,
    /// Paths of light of further orders for each direction, where there is such light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paths_per_node: Option<usize>,
}

impl From<Afforded> for niji_render::Afforded {
    fn from(afforded: Afforded) -> Self {
        Self {
            coarser_rays: afforded.coarser_rays,
            paths_per_node: afforded.paths_per_node,
        }
    }
}
