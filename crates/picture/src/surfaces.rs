//! What ends view rays: maps of distances and meshes in files.

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
use niji_render::Surfaces;
use niji_scene::Along;
use niji_scene::Camera;
use niji_scene::OccluderMesh;
use niji_scene::Scene;
use niji_scene::canonical_json;
use serde::Serialize;

use crate::error::Error;

/// Names of meshes among the inputs of a picture.
const MESH_ROLES: [&str; 8] = [
    "mesh.1", "mesh.2", "mesh.3", "mesh.4", "mesh.5", "mesh.6", "mesh.7", "mesh.8",
];

/// Surfaces that hide what is behind them.
#[derive(Clone, Debug, Default)]
pub struct SurfaceFiles {
    /// Their distances.
    pub depth: Option<DepthFile>,
    /// Meshes among them, and where they stand.
    pub meshes: Vec<(PathBuf, OccluderMesh)>,
}

/// A depth map, and what it is measured along.
#[derive(Clone, Debug)]
pub struct DepthFile {
    /// The file.
    pub path: PathBuf,
    /// The view ray, or the optical axis.
    pub along: Along,
}

impl SurfaceFiles {
    /// The surfaces that a scene names whose files lie in `folder`.
    #[must_use]
    pub fn of_scene(scene: &Scene, folder: &Path) -> Self {
        let Some(occluders) = &scene.occluders else {
            return Self::default();
        };
        let depth = occluders.depth.as_ref().map(|path| DepthFile {
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
    pub fn with_depth(self, path: PathBuf) -> Self {
        let along = Along::Ray;
        Self {
            depth: Some(DepthFile { path, along }),
            ..self
        }
    }

    /// The same with other meshes, in metres, y up, where their corners say.
    ///
    /// # Errors
    /// More meshes than a picture may have.
    pub fn with_meshes(self, paths: &[PathBuf]) -> Result<Self, Error> {
        if paths.len() > MESH_ROLES.len() {
            return Err(Error::TooManyMeshes {
                found: paths.len(),
                most: MESH_ROLES.len(),
            });
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
    pub fn inputs(&self) -> Vec<(&'static str, &Path)> {
        let depth = self.depth.iter().map(|depth| ("depth", &*depth.path));
        let meshes = self.meshes.iter().map(|(path, _)| &**path);
        depth.chain(MESH_ROLES.into_iter().zip(meshes)).collect()
    }

    /// The settings of a picture before them; files are known by their content, not by their names.
    pub fn settings<T: Serialize>(&self, settings: &T) -> String {
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
    pub fn read(&self, camera: Camera) -> Result<Option<Surfaces>, Error> {
        let depth = self.depth.as_ref();
        self.beside(depth.map(|depth| read_depth(depth, camera)).transpose()?)
    }

    /// Reads its meshes beside surfaces whose distances are there; `None` if there is neither.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn beside(&self, depth: Option<Surfaces>) -> Result<Option<Surfaces>, Error> {
        Ok(match (depth, read_meshes(&self.meshes)?) {
            (Some(depth), Some(mesh)) => Some(depth.with_mesh(mesh)),
            (None, Some(mesh)) => Some(Surfaces::of_mesh(mesh)),
            (depth, None) => depth,
        })
    }
}

/// Reads a map as distances along the rays of a camera.
fn read_depth(depth: &DepthFile, camera: Camera) -> Result<Surfaces, Error> {
    let bad = |error: &dyn std::fmt::Display| Error::file(&depth.path, error);
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
    Surfaces::new(distance_m).map_err(|error| bad(&error))
}

/// Reads meshes and puts all of them into one tree.
fn read_meshes(meshes: &[(PathBuf, OccluderMesh)]) -> Result<Option<MeshBvh>, Error> {
    let (mut corners, mut triangles) = (Vec::<DVec3>::new(), Vec::new());
    let Some((first_file, _)) = meshes.first() else {
        return Ok(None);
    };
    for (path, placed) in meshes {
        let bad = |error: &dyn std::fmt::Display| Error::file(path, error);
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
    let all = all.map_err(|error| Error::file(first_file, error))?;
    Ok(Some(MeshBvh::new(all)))
}
