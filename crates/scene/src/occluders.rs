//! The section `[occluders]`: surfaces that hide what is behind them.

use glam::DAffine3;
use glam::DMat3;
use glam::DVec3;
use niji_geometry::Up;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::albedo::MeshAlbedo;

/// Most meshes that hide what is behind them.
pub(crate) const MAX_MESHES: usize = 8;

/// The section `[occluders]`: a map of distances, meshes, or both; the nearer hides the farther.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Occluders {
    /// Path of an EXR with a channel Z in metres, relative to the scene file; 0, infinity and 1e10
    /// are the sky.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub depth: Option<String>,
    /// What Z is measured along: the view ray where it is left out.
    #[serde(default)]
    pub along: Along,
    /// Meshes that stand in the scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 8))]
    pub meshes: Vec<OccluderMesh>,
}

/// A mesh that hides what is behind it, lit where it has an albedo: `[[occluders.meshes]]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OccluderMesh {
    /// OBJ, glTF or STL, relative to the scene.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Which way is up in the file: y where it is left out.
    #[serde(default)]
    pub up: Up,
    /// Metres that a unit of the file is long: 1 where it is left out.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
    pub scale: f64,
    /// Turn about the vertical, clockwise seen from above, degrees.
    #[serde(default)]
    #[schemars(range(min = -3600.0, max = 3600.0))]
    pub turn_deg: f64,
    /// Where the origin of the file lies, metres: x east, y up, z south.
    #[serde(default)]
    #[schemars(inner(range(min = -1e7, max = 1e7)))]
    pub position_m: [f64; 3],
    /// Share of the light that it gives back, 0..1, or red, green and blue, or the name of a ground, or "materials" for
    /// those of its file; black where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub albedo: Option<MeshAlbedo>,
}

impl OccluderMesh {
    /// A file as it is: metres, y up, in the world's own coordinates.
    pub fn of_file(file: String) -> Self {
        Self {
            file,
            up: Up::Y,
            scale: 1.0,
            turn_deg: 0.0,
            position_m: [0.0; 3],
            albedo: None,
        }
    }

    /// The matrix that takes the corners of the file to the world: up, scale, turn, then position.
    pub fn to_world(&self) -> DAffine3 {
        let turn = DMat3::from_rotation_y(-self.turn_deg.to_radians());
        let matrix = turn * (self.scale * self.up.to_y_up());
        DAffine3::from_mat3_translation(matrix, DVec3::from(self.position_m))
    }
}

fn one() -> f64 {
    1.0
}

/// What a depth is measured along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// The view ray.
    #[default]
    Ray,
    /// The optical axis, as most renderers write it.
    Axis,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_raised_scaled_turned_and_moved_in_this_order() {
        let mesh = OccluderMesh {
            up: Up::Z,
            scale: 2.0,
            turn_deg: 90.0,
            position_m: [10.0, 20.0, 30.0],
            ..OccluderMesh::of_file("ship.stl".to_string())
        };
        let place = |corner| mesh.to_world().transform_point3(corner);
        // Up there is up here; north there is y, and a quarter turn clockwise makes it east.
        for (there, here) in [
            (DVec3::ZERO, DVec3::new(10.0, 20.0, 30.0)),
            (DVec3::Z, DVec3::new(10.0, 22.0, 30.0)),
            (DVec3::Y, DVec3::new(12.0, 20.0, 30.0)),
            (DVec3::X, DVec3::new(10.0, 20.0, 32.0)),
        ] {
            assert!(place(there).distance(here) < 1e-14, "{there}");
        }
        let plain = OccluderMesh::of_file(String::new());
        assert_eq!(plain.to_world(), DAffine3::IDENTITY);
    }
}
