//! The section `[terrain]`: heights of the land.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::albedo::Albedo;

/// The section `[terrain]`: a map of heights, first row in the north, first column in the west. It hides what is behind
/// it and throws shadows; with an albedo it is lit. The ground at y = 0 hides what lies below that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Terrain {
    /// A PNG, 16 bits of gray for smooth slopes, or an EXR with a channel Z or one channel, relative to the scene.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Distance of neighboring heights, metres.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
    pub spacing_m: f64,
    /// Heights of black and of white, metres; where it is left out, the values of the EXR are metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = -1e7, max = 1e7)))]
    pub height_m: Option<[f64; 2]>,
    /// Where height 0 of the middle of the map lies, metres: x east, y up, z south.
    #[serde(default)]
    #[schemars(inner(range(min = -1e7, max = 1e7)))]
    pub position_m: [f64; 3],
    /// Share of the light that it gives back, 0..1, or red, green and blue, or the name of a ground; black where it is
    /// left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
}
