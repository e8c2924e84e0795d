//! Rays, cameras, boxes, meshes, fields of heights and the geometry of a spherical planet.
//!
//! World space is right-handed and in metres: x east, y up, z south; azimuths run clockwise from
//! north. [`Camera`] is any of the cameras; all of them give a [`Ray`] for a point of the picture.
//!
//! ```
//! use glam::DVec3;
//! use niji_geometry::{Aabb, EARTH, PinholeCamera, PinholeRequest};
//! use niji_radiometry::Radians;
//!
//! let camera = PinholeCamera::new(PinholeRequest {
//!     position: DVec3::new(0.0, 2.0, 0.0),
//!     azimuth: Radians::from_degrees(90.0),
//!     elevation: Radians(0.0),
//!     roll: Radians(0.0),
//!     horizontal_fov: Radians::from_degrees(60.0),
//!     width_px: 640,
//!     height_px: 480,
//! })?;
//! // The middle of the picture looks east, into a box of rain 100 m away.
//! let ray = camera.ray(320.0, 240.0);
//! assert!(ray.direction.distance(DVec3::X) < 1e-12);
//! let rain = Aabb { min: DVec3::new(100.0, 0.0, -50.0), max: DVec3::new(300.0, 80.0, 50.0) };
//! let (enters_m, leaves_m) = rain.intersect(&ray).expect("it is in front of the camera");
//! assert!((enters_m - 100.0).abs() < 1e-9 && (leaves_m - 300.0).abs() < 1e-9);
//!
//! // A level ray from 2 m up meets no ground; half a degree below it does, 230 m away.
//! assert_eq!(EARTH.distance_to_ground(2.0, 0.0), None);
//! let down = -0.5_f64.to_radians().sin();
//! let distance_m = EARTH.distance_to_ground(2.0, down).expect("it leads downwards");
//! assert!((distance_m - 2.0 / -down).abs() < 1.0);
//! # Ok::<(), niji_geometry::Error>(())
//! ```

mod aabb;
mod camera;
mod camera_pose;
mod covered_slopes;
mod error;
mod fisheye;
mod four_boxes;
mod height_field;
mod lens;
mod level_look;
mod mesh;
mod mesh_bvh;
mod mesh_closed;
mod mesh_files;
mod mesh_gltf;
mod mesh_materials;
mod mesh_mtl;
mod mesh_normals;
mod mesh_obj;
mod mesh_triangle;
mod panorama;
mod pinhole;
mod pixel_region;
mod planet;
mod polygon;
mod ray;
mod sobol;
mod triangle_nodes;

pub use aabb::Aabb;
pub use camera::Camera;
pub use camera_pose::CameraPose;
pub use camera_pose::Up;
pub use covered_slopes::CoveredSlopes;
pub use error::Error;
pub use fisheye::FisheyeCamera;
pub use fisheye::FisheyeMapping;
pub use fisheye::FisheyeRequest;
pub use height_field::HeightField;
pub use height_field::HeightHit;
pub use height_field::HeightMap;
pub use lens::FocalLength;
pub use lens::Lens;
pub use mesh::TriangleAttributes;
pub use mesh::TriangleMesh;
pub use mesh_bvh::MeshBvh;
pub use mesh_bvh::MeshHit;
pub use mesh_files::MeshDetail;
pub use mesh_files::files_beside_mesh;
pub use mesh_files::read_mesh;
pub use mesh_files::read_painted_mesh;
pub use mesh_materials::MeshMaterial;
pub use mesh_materials::MeshTexture;
pub use mesh_materials::PaintedMesh;
pub use mesh_materials::TextureContent;
pub use mesh_materials::TextureWrap;
pub use panorama::PanoramaCamera;
pub use pinhole::PinholeCamera;
pub use pinhole::PinholeRequest;
pub use pixel_region::PixelRegion;
pub use planet::EARTH;
pub use planet::Planet;
pub use ray::Ray;
pub use ray::direction_from_azimuth_elevation;
pub use sobol::N_SOBOL_DIMENSIONS;
pub use sobol::SOBOL_DIRECTIONS;
pub use triangle_nodes::TriangleNode;
pub use triangle_nodes::TrianglePlace;
