//! Light through ice: blue because it is big.
//!
//! Pure ice absorbs red a thousand times as much as blue, but little of either: a cube of 0.1 m is
//! white, one of 50 m blue. [`render_ice`] follows random paths from the eye through a [`Body`] to sun
//! and sky; [`one_crossing`] is the transmittance of a single way through it.
//!
//! ```
//! use glam::DVec3;
//! use niji_geometry::Aabb;
//! use niji_ice::{Body, ice_absorption_per_m, one_crossing};
//! use niji_radiometry::Nanometers;
//!
//! let absorption = [450.0, 650.0].map(|nm| ice_absorption_per_m(Nanometers(nm)));
//! let ratio = |edge_m: f64| {
//!     let max = DVec3::splat(edge_m);
//!     let cube = Body::of_box(Aabb { min: DVec3::ZERO, max }).expect("a cube has a volume");
//!     let passed = one_crossing(&cube, &absorption, 4096, 1);
//!     passed[0].transmittance / passed[1].transmittance
//! };
//! assert!(ratio(0.1) < 1.02 && ratio(50.0) > 5.0);
//! ```

mod absorption;
mod body;
mod bubbles;
#[cfg(test)]
mod chi_square;
mod crossing;
mod diffuse_surface;
mod directions;
mod error;
mod facets;
mod ground;
mod ice;
mod iceberg;
mod levels;
mod light;
mod mean_chord;
mod noise;
mod picture;
mod radiance_sum;
mod rough_dielectric;
mod sampler;
mod slopes;
mod snow;
mod surface;
mod transmittance_table;
mod walk;

pub use crate::absorption::ice_absorption_per_m;
pub use crate::absorption::ice_absorption_spectrum;
pub use crate::body::Body;
pub use crate::bubbles::Bubbles;
pub use crate::crossing::OneCrossing;
pub use crate::crossing::one_crossing;
pub use crate::error::Error;
pub use crate::ground::Ground;
pub use crate::ice::Ice;
pub use crate::iceberg::Iceberg;
pub use crate::levels::IceTransport;
pub use crate::levels::PathWavelengths;
pub use crate::light::Light;
pub use crate::light::Sky;
pub use crate::light::SkyMap;
pub use crate::picture::IcePicture;
pub use crate::picture::IceRequest;
pub use crate::picture::render_ice;
pub use crate::snow::Snow;
pub use crate::surface::IceSurface;
