//! The nodes of a glTF file: a tree of places at which its meshes stand, in the default scene (the first where none is
//! named, all nodes where there is none).

use glam::DMat4;
use glam::DQuat;
use glam::DVec3;
use serde::Deserialize;

use super::Document;
use super::Primitive;
use super::item;

/// Most that the length of a rotation may differ from 1: writers round.
const UNIT_TOLERANCE: f64 = 0.01;

#[derive(Deserialize)]
pub(super) struct Roots {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    #[serde(default)]
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

impl Document {
    /// Shapes of the scene, and where they stand.
    pub(super) fn shapes(&self) -> Result<Vec<(&Primitive, DMat4)>, String> {
        let scene = match self.scene {
            Some(index) => Some(item(&self.scenes, index, "scene")?),
            None => self.scenes.first(),
        };
        let roots = scene.map_or_else(|| self.parentless(), |scene| scene.nodes.clone());
        let mut waiting: Vec<_> = roots.iter().map(|&root| (root, DMat4::IDENTITY)).collect();
        let mut is_met = vec![false; self.nodes.len()];
        let mut shapes = Vec::new();
        while let Some((index, parent)) = waiting.pop() {
            let node = item(&self.nodes, index, "node")?;
            if std::mem::replace(&mut is_met[index], true) {
                return Err(format!(
                    "found node {index} twice in the scene, expected a tree: a node has one parent"
                ));
            }
            let placed = parent * node.matrix()?;
            if let Some(mesh) = node.mesh {
                let mesh = item(&self.meshes, mesh, "mesh")?;
                shapes.extend(mesh.primitives.iter().map(|primitive| (primitive, placed)));
            }
            waiting.extend(node.children.iter().map(|&child| (child, placed)));
        }
        Ok(shapes)
    }

    /// The nodes that are no other's child.
    fn parentless(&self) -> Vec<usize> {
        let mut is_child = vec![false; self.nodes.len()];
        for child in self.nodes.iter().flat_map(|node| &node.children) {
            if let Some(is_child) = is_child.get_mut(*child) {
                *is_child = true;
            }
        }
        (0..self.nodes.len())
            .filter(|index| !is_child[*index])
            .collect()
    }
}

impl Node {
    fn matrix(&self) -> Result<DMat4, String> {
        if let Some(columns) = self.matrix {
            return Ok(DMat4::from_cols_array(&columns));
        }
        let rotation = DQuat::from_array(self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        if (rotation.length() - 1.0).abs() > UNIT_TOLERANCE {
            return Err(format!(
                "found the rotation {rotation}, expected one of length 1"
            ));
        }
        Ok(DMat4::from_scale_rotation_translation(
            self.scale.map_or(DVec3::ONE, DVec3::from),
            rotation.normalize(),
            self.translation.map_or(DVec3::ZERO, DVec3::from),
        ))
    }
}
