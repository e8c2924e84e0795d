//! Rays, cameras, boxes and the geometry of a spherical planet.

mod aabb;
mod error;
mod pinhole;
mod planet;
mod ray;

pub use aabb::Aabb;
pub use error::Error;
pub use pinhole::PinholeCamera;
pub use pinhole::PinholeRequest;
pub use planet::EARTH;
pub use planet::Planet;
pub use ray::Ray;
pub use ray::direction_from_azimuth_elevation;
