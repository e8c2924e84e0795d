//! What ends view rays: maps of distances, meshes and terrain in files.

use std::path::Path;
use std::path::PathBuf;

use glam::DVec3;
use niji_geometry::HeightField;
use niji_geometry::HeightMap;
use niji_geometry::MeshBvh;
use niji_geometry::MeshDetail;
use niji_geometry::Ray;
use niji_geometry::read_mesh;
use niji_photo::DepthAlong;
use niji_photo::DepthKind;
use niji_photo::depth_from_values;
use niji_photo::read_depth_of_frame;
use niji_photo::read_depth_values;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::SurfaceColor;
use niji_render::Surfaces;
use niji_scene::Along;
use niji_scene::Camera;
use niji_scene::MeshAlbedo;
use niji_scene::OccluderMesh;
use niji_scene::OfFile;
use niji_scene::Scene;
use niji_scene::Terrain;
use niji_scene::canonical_json;
use serde::Serialize;

use crate::error::Error;
use crate::mesh_paint::read_painted;

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
    /// Heights of the land, and where it lies.
    pub terrain: Option<(PathBuf, Terrain)>,
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
        let terrain = scene.terrain.as_ref();
        let terrain = terrain.map(|it| (folder.join(&it.file), it.clone()));
        let Some(occluders) = &scene.occluders else {
            return Self {
                terrain,
                ..Self::default()
            };
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
            terrain,
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
        let terrain = self.terrain.iter().map(|(path, _)| ("terrain", &**path));
        let meshes = MESH_ROLES.into_iter().zip(meshes);
        depth.chain(meshes).chain(terrain).collect()
    }

    /// The settings of a picture before them; files are known by their content, not by their names.
    pub fn settings<T: Serialize>(&self, settings: &T) -> String {
        let along = self.depth.as_ref().map(|depth| depth.along);
        let nameless = |mesh: &OccluderMesh| OccluderMesh {
            file: String::new(),
            ..mesh.clone()
        };
        let meshes: Vec<_> = self.meshes.iter().map(|(_, mesh)| nameless(mesh)).collect();
        if let Some((_, terrain)) = &self.terrain {
            let terrain = Terrain {
                file: String::new(),
                ..terrain.clone()
            };
            return canonical_json(&(settings, along, meshes, terrain));
        }
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
        let depth = depth.map(|depth| read_depth(depth, camera)).transpose()?;
        self.beside(depth, camera)
    }

    /// Reads its meshes and terrain beside surfaces whose distances are there; `None` if there are none of all.
    ///
    /// # Errors
    /// A file that is missing or damaged; a camera below the terrain.
    pub fn beside(
        &self,
        depth: Option<Surfaces>,
        camera: Camera,
    ) -> Result<Option<Surfaces>, Error> {
        let is_any = depth.is_some() || !self.meshes.is_empty() || self.terrain.is_some();
        let mut surfaces = depth.unwrap_or_default();
        for (path, mesh) in &self.meshes {
            surfaces = surfaces.with(read_solid(path, mesh)?);
        }
        if let Some((path, terrain)) = &self.terrain {
            surfaces = surfaces.with(read_terrain((path, terrain), camera)?);
        }
        Ok(is_any.then_some(surfaces))
    }
}

/// Reads a map as distances along the rays of a camera.
fn read_depth(depth: &DepthFile, camera: Camera) -> Result<Surfaces, Error> {
    let bad = |error: &dyn std::fmt::Display| Error::file(&depth.path, error);
    let mut distance_m = read_depth_of_frame(&depth.path).map_err(|error| bad(&error))?;
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

/// Reads a mesh and puts it in its place.
fn read_solid(path: &Path, placed: &OccluderMesh) -> Result<Solid, Error> {
    let bad = |error: &dyn std::fmt::Display| {
        Error::file(path, format!("{error} (file of [[occluders.meshes]])"))
    };
    let read = |detail| read_mesh(path, detail).map_err(|error| bad(&error));
    let (mesh, albedo) = match placed.albedo {
        None => (read(MeshDetail::Shape)?, None),
        Some(MeshAlbedo::Plain(albedo)) => {
            let color = SurfaceColor::Plain(albedo.reflectance());
            (read(MeshDetail::Normals)?, Some(color))
        }
        Some(MeshAlbedo::OfFile(OfFile::Materials)) => {
            let (mesh, paint) = read_painted(path)?;
            (mesh, Some(SurfaceColor::Painted(paint)))
        }
    };
    let mesh = mesh.placed(&placed.to_world());
    Ok(Solid {
        shape: SolidShape::Mesh(MeshBvh::new(mesh.map_err(|error| bad(&error))?)),
        albedo,
    })
}

/// Reads heights, above which a camera has to stand.
fn read_terrain((path, terrain): (&Path, &Terrain), camera: Camera) -> Result<Solid, Error> {
    let bad = |error: &dyn std::fmt::Display| Error::file(path, format!("{error} (terrain.file)"));
    let mut heights = read_depth_values(path).map_err(|error| bad(&error))?;
    if let Some([low_m, high_m]) = terrain.height_m {
        let metres = |value: f32| low_m + f64::from(value) * (high_m - low_m);
        // f32: as the field has them.
        heights.mapv_inplace(|value| metres(value) as f32);
    }
    let (n_z, n_x) = heights.dim();
    let size_m = terrain.spacing_m * DVec3::new(n_x as f64 - 1.0, 0.0, n_z as f64 - 1.0);
    let (height_m, _) = heights.into_raw_vec_and_offset();
    let field = HeightField::new(HeightMap {
        size: (n_x, n_z),
        height_m,
        spacing_m: terrain.spacing_m,
        corner: DVec3::from(terrain.position_m) - 0.5 * size_m,
    });
    let field = field.map_err(|error| bad(&error))?;
    let upwards = Ray {
        origin: DVec3::from(camera.position_m),
        direction: DVec3::Y,
    };
    if let Some(above) = field.nearest(&upwards, 0.0) {
        return Err(Error::CameraInTerrain {
            found_m: upwards.origin.y,
            ground_m: upwards.origin.y + above.distance_m,
        });
    }
    Ok(Solid {
        shape: SolidShape::Heights(field),
        albedo: terrain.albedo.map(|it| it.reflectance().into()),
    })
}
