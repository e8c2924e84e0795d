//! What ends view rays: maps of distances and meshes, as the render stage takes them.

use std::path::Path;
use std::path::PathBuf;

use glam::DVec3;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleMesh;
use niji_geometry::read_mesh;
use niji_photo::DepthAlong;
use niji_photo::DepthKind;
use niji_photo::depth_from_values;
use niji_photo::read_depth_map;
use niji_scene::Along;
use niji_scene::Camera;
use niji_scene::OccluderMesh;
use niji_scene::Scene;
use niji_scene::canonical_json;
use serde::Serialize;

use crate::failure::Failure;

/// Names of meshes among the inputs of a picture.
const MESH_ROLES: [&str; 8] = [
    "mesh.1", "mesh.2", "mesh.3", "mesh.4", "mesh.5", "mesh.6", "mesh.7", "mesh.8",
];

/// Surfaces that hide what is behind them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces {
    /// Their distances.
    pub depth: Option<Depth>,
    /// Meshes among them, and where they stand.
    pub meshes: Vec<(PathBuf, OccluderMesh)>,
}

/// A depth map, and what it is measured along.
#[derive(Clone, Debug)]
pub(crate) struct Depth {
    /// The file.
    pub path: PathBuf,
    /// The view ray, or the optical axis.
    pub along: Along,
}

impl Surfaces {
    /// The surfaces that a scene names, relative to its file.
    #[must_use]
    pub(crate) fn of_scene(scene: &Scene, scene_file: &Path) -> Self {
        let folder = scene_file.parent().unwrap_or(Path::new(""));
        let Some(occluders) = &scene.occluders else {
            return Self::default();
        };
        let depth = occluders.depth.as_ref().map(|path| Depth {
            path: folder.join(path),
            along: occluders.along,
        });
        let meshes = occluders.meshes.iter();
        let meshes = meshes.map(|mesh| (folder.join(&mesh.file), mesh.clone()));
        Self {
            depth,
            meshes: meshes.collect(),
        }
    }

    /// The same with a map along the view rays.
    #[must_use]
    pub(crate) fn with_depth(self, path: PathBuf) -> Self {
        let along = Along::Ray;
        Self {
            depth: Some(Depth { path, along }),
            ..self
        }
    }

    /// The same with other meshes, in metres, y up, where their corners say.
    ///
    /// # Errors
    /// More meshes than a picture may have.
    pub(crate) fn with_meshes(self, paths: &[PathBuf]) -> Result<Self, Failure> {
        if paths.len() > MESH_ROLES.len() {
            let (found, most) = (paths.len(), MESH_ROLES.len());
            let message = format!("found {found} meshes, expected {most} at most: join some");
            return Err(Failure::Usage(message));
        }
        let meshes = paths.iter().map(|path| {
            let mesh = OccluderMesh::of_file(path.display().to_string());
            (path.clone(), mesh)
        });
        Ok(Self {
            meshes: meshes.collect(),
            ..self
        })
    }

    /// Their files by role.
    pub(crate) fn inputs(&self) -> Vec<(&'static str, &Path)> {
        let depth = self.depth.iter().map(|depth| ("depth", &*depth.path));
        let meshes = self.meshes.iter().map(|(path, _)| &**path);
        depth.chain(MESH_ROLES.into_iter().zip(meshes)).collect()
    }

    /// The settings of a picture before them; files are known by their content, not by their names.
    pub(crate) fn settings<T: Serialize>(&self, settings: &T) -> String {
        let along = self.depth.as_ref().map(|depth| depth.along);
        let nameless = |mesh: &OccluderMesh| OccluderMesh {
            file: String::new(),
            ..mesh.clone()
        };
        let meshes: Vec<_> = self.meshes.iter().map(|(_, mesh)| nameless(mesh)).collect();
        if !meshes.is_empty() {
            return canonical_json(&(settings, along, meshes));
        }
        match along {
            // As it was before there were surfaces, so that files made then still fit.
            None | Some(Along::Ray) => canonical_json(settings),
            Some(Along::Axis) => canonical_json(&(settings, Along::Axis)),
        }
    }

    /// Reads them for a camera; `None` if there are none.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub(crate) fn read(&self, camera: Camera) -> Result<Option<niji_render::Surfaces>, Failure> {
        let depth = self.depth.as_ref();
        let depth = depth.map(|depth| read_depth(depth, camera)).transpose()?;
        let mesh = read_meshes(&self.meshes)?;
        Ok(match (depth, mesh) {
            (Some(depth), Some(mesh)) => Some(depth.with_mesh(mesh)),
            (None, Some(mesh)) => Some(niji_render::Surfaces::of_mesh(mesh)),
            (depth, None) => depth,
        })
    }
}

/// Reads a map as distances along the rays of a camera.
fn read_depth(depth: &Depth, camera: Camera) -> Result<niji_render::Surfaces, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(&depth.path, error);
    let mut distance_m = read_depth_map(&depth.path).map_err(|error| bad(&error))?;
    if depth.along == Along::Axis {
        let (height, width) = distance_m.dim();
        // The same view in the pixels of the map.
        let of_map = Camera {
            width_px: width as u32,
            height_px: height as u32,
            ..camera
        };
        let pinhole = of_map.pinhole().map_err(|error| bad(&error))?;
        distance_m = depth_from_values(&distance_m, &DepthKind::Metres, DepthAlong::Axis, &pinhole)
            .map_err(|error| bad(&error))?;
    }
    niji_render::Surfaces::new(distance_m).map_err(|error| bad(&error))
}

/// Reads meshes and puts all of them into one tree.
fn read_meshes(meshes: &[(PathBuf, OccluderMesh)]) -> Result<Option<MeshBvh>, Failure> {
    let (mut corners, mut triangles) = (Vec::<DVec3>::new(), Vec::new());
    let Some((first_file, _)) = meshes.first() else {
        return Ok(None);
    };
    for (path, placed) in meshes {
        let bad = |error: &dyn std::fmt::Display| Failure::bad_input(path, error);
        let mesh = read_mesh(path).map_err(|error| bad(&error))?;
        let to_world = placed.to_world();
        let moved = mesh.moved(|corner| to_world.transform_point3(corner));
        let moved = moved.map_err(|error| bad(&error))?;
        let first = corners.len() as u32;
        corners.extend_from_slice(moved.vertices());
        let own = moved.triangles().iter();
        triangles.extend(own.map(|triangle| triangle.map(|index| first + index)));
    }
    let all = TriangleMesh::new(&corners, &triangles);
    let all = all.map_err(|error| Failure::bad_input(first_file, error))?;
    Ok(Some(MeshBvh::new(all)))
}
