//! Rays, cameras, boxes and the geometry of a spherical planet.

mod aabb;
mod error;
mod mesh;
mod mesh_bvh;
mod mesh_closed;
mod mesh_files;
mod mesh_triangle;
mod pinhole;
mod planet;
mod ray;

pub use aabb::Aabb;
pub use error::Error;
pub use mesh::TriangleMesh;
pub use mesh_bvh::MeshBvh;
pub use mesh_bvh::MeshHit;
pub use mesh_files::read_mesh;
pub use pinhole::PinholeCamera;
pub use pinhole::PinholeRequest;
pub use planet::EARTH;
pub use planet::Planet;
pub use ray::Ray;
pub use ray::direction_from_azimuth_elevation;
