//! How far away the surfaces of a photograph are.

use std::path::Path;
use std::path::PathBuf;

use glam::DVec3;
use ndarray::Array2;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_photo::Anchor;
use niji_photo::ClusterCount;
use niji_photo::DepthAlong;
use niji_photo::DepthKind;
use niji_photo::Layer;
use niji_photo::Layers;
use niji_photo::LayersRequest;
use niji_photo::Photograph;
use niji_photo::depth_from_values;
use niji_photo::depth_of_layers;
use niji_photo::propose_layers;
use niji_photo::read_depth_values;
use niji_photo::read_labels;
use niji_photo::read_layer_distances;
use niji_photo::upsample_depth;
use niji_photo::upsample_labels;
use niji_radiometry::Meters;
use niji_radiometry::Radians;
use niji_scene::Along;
use niji_scene::Camera;

use crate::error::Error;

/// Weight of position beside color in layers that are proposed.
pub const POSITION_WEIGHT: f64 = 0.3;
/// Height of an eye above level ground (m).
pub const EYE_HEIGHT: Meters = Meters(1.6);

/// Where distances come from.
#[derive(Clone, Debug)]
pub enum Distances {
    /// Layers of similar color, their distances proposed.
    Proposed {
        /// How many.
        count: ClusterCount,
        /// Of position beside color: 0 for color alone, as published.
        position_weight: f64,
        /// Of the eye above level ground.
        eye_height: Meters,
    },
    /// Layers in files.
    Layers {
        /// Their distances (TOML).
        distances: PathBuf,
        /// Their labels (PNG), of the size of the photograph or smaller.
        labels: PathBuf,
    },
    /// A map in a file.
    Map(DepthMap),
}

/// A depth map from elsewhere.
#[derive(Clone, Debug)]
pub struct DepthMap {
    /// EXR with a channel Z, or a grey PNG, whose white is 1.
    pub path: PathBuf,
    /// What its values are.
    pub values: MapValues,
    /// What they are measured along.
    pub along: Along,
}

/// What the values of a depth map are; anchors are a column and a row of the photograph with the distance there
/// in metres.
#[derive(Clone, Debug)]
pub enum MapValues {
    /// Distances in this unit (m); 0 and infinity are the sky.
    Metres(f64),
    /// Inverse depth of unknown scale and shift, near = large.
    Inverse(Vec<[f64; 3]>),
    /// Depth of unknown scale and shift, near = small.
    Relative(Vec<[f64; 3]>),
}

/// A photograph and what is known of it.
#[derive(Clone, Debug)]
pub struct PhotoDepthRequest<'a> {
    /// The photograph.
    pub photo: &'a Photograph,
    /// What took it, in the pixels of the photograph.
    pub camera: PinholeRequest,
    /// Where distances come from.
    pub distances: Distances,
}

/// Distances along the view rays.
#[derive(Clone, Debug)]
pub struct PhotoDepth {
    /// By row and column of the photograph (m); infinite for the sky.
    pub depth_m: Array2<f32>,
    /// The layers that were proposed.
    pub layers: Option<Layers>,
}

impl PhotoDepthRequest<'_> {
    /// Finds them.
    ///
    /// # Errors
    /// Files that are missing, damaged or contradict the photograph; counts, weights and heights out of range.
    pub fn depth(&self) -> Result<PhotoDepth, Error> {
        let (depth_m, layers) = match &self.distances {
            &Distances::Proposed {
                count,
                position_weight,
                eye_height,
            } => {
                let request = LayersRequest {
                    count,
                    position_weight,
                    camera: &pinhole(self.camera)?,
                    eye_height,
                };
                let layers = propose_layers(&self.photo.light, &request)?;
                (depth_of_layers(&layers)?, Some(layers))
            }
            Distances::Layers { distances, labels } => (self.of_files(distances, labels)?, None),
            Distances::Map(map) => (self.of_map(map)?, None),
        };
        Ok(PhotoDepth { depth_m, layers })
    }

    fn of_files(&self, toml: &Path, png: &Path) -> Result<Array2<f32>, Error> {
        let distances = read_layer_distances(toml).map_err(|error| Error::file(toml, error))?;
        let of_labels = |error: niji_photo::Error| Error::file(png, error);
        let labels = read_labels(png, distances.len()).map_err(of_labels)?;
        let labels = upsample_labels(&labels, &self.photo.light).map_err(of_labels)?;
        let layers = distances.into_iter().map(|distance_m| Layer {
            color: [0.0; 3],
            share: 0.0,
            distance_m,
        });
        let layers = Layers {
            labels,
            layers: layers.collect(),
        };
        depth_of_layers(&layers).map_err(|error| Error::file(toml, error))
    }

    fn of_map(&self, map: &DepthMap) -> Result<Array2<f32>, Error> {
        let of_map = |error: niji_photo::Error| Error::file(&map.path, error);
        let mut values = read_depth_values(&map.path).map_err(of_map)?;
        let (height, width) = values.dim();
        let camera = pinhole(PinholeRequest {
            width_px: width as u32,
            height_px: height as u32,
            ..self.camera
        })?;
        let anchors = |anchors: &[[f64; 3]]| {
            let at = |value: f64, n: usize, n_photo: usize| {
                ((value + 0.5) * n as f64 / n_photo as f64).max(0.0) as usize
            };
            let anchors = anchors.iter().map(|[x, y, distance_m]| Anchor {
                pixel: [
                    at(*x, width, self.photo.width()),
                    at(*y, height, self.photo.height()),
                ],
                distance_m: *distance_m,
            });
            anchors.collect()
        };
        let kind = match &map.values {
            MapValues::Inverse(known) => DepthKind::Inverse(anchors(known)),
            MapValues::Relative(known) => DepthKind::Relative(anchors(known)),
            MapValues::Metres(found) if !(*found > 0.0 && found.is_finite()) => {
                return Err(Error::Photo(niji_photo::Error::Range {
                    what: "the unit of the map in metres",
                    found: *found,
                    expected: "a length above 0",
                }));
            }
            MapValues::Metres(unit_m) => {
                let unit_m = *unit_m as f32;
                values.mapv_inplace(|value| value * unit_m);
                DepthKind::Metres
            }
        };
        let along = match map.along {
            Along::Ray => DepthAlong::Ray,
            Along::Axis => DepthAlong::Axis,
        };
        let coarse_m = depth_from_values(&values, &kind, along, &camera).map_err(of_map)?;
        upsample_depth(&coarse_m, &self.photo.light).map_err(of_map)
    }
}

/// Reads a photograph.
pub(crate) fn read_photo(path: &Path) -> Result<Photograph, Error> {
    Photograph::read(path).map_err(|error| Error::file(path, error))
}

/// The camera of a scene as the one that took its photograph of a width and height, its eye at the origin.
pub(crate) fn photo_camera(camera: &Camera, [width, height]: [usize; 2]) -> PinholeRequest {
    PinholeRequest {
        position: DVec3::ZERO,
        azimuth: Radians::from_degrees(camera.azimuth_deg),
        elevation: Radians::from_degrees(camera.elevation_deg),
        roll: Radians::from_degrees(camera.roll_deg),
        // A scene with a photograph has a pinhole camera, hence a field of view.
        horizontal_fov: Radians::from_degrees(camera.horizontal_fov_deg.unwrap_or_default()),
        width_px: width as u32,
        height_px: height as u32,
    }
}

pub(crate) fn pinhole(request: PinholeRequest) -> Result<PinholeCamera, Error> {
    PinholeCamera::new(request).map_err(Error::scene)
}
