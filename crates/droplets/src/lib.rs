//! Authoring: shapes of rain, fountains, fog and clouds as drop volumes.
//!
//! A [`Shape`] is a few numbers from a scene file. It knows its totals, bounds and ranges before any
//! voxel exists, most of them in closed form, and lays itself out as a volume. Boxes, rain and fog
//! follow published laws of drop sizes; fountains, waterfalls and sea spray are plausible, not
//! measured, but none of their water is lost or made. [`Turbulence`] stirs what a shape lays out.
//!
//! ```
//! use niji_droplets::{Shape, Uniform};
//! use niji_sizes::{Monodisperse, SizeLaw};
//!
//! let shape = Shape::Uniform(Uniform {
//!     box_min_m: [-100.0, 0.0, -300.0],
//!     box_max_m: [100.0, 100.0, -200.0],
//!     voxel_m: 5.0,
//!     law: SizeLaw::Monodisperse(Monodisperse { radius_um: 100.0 }),
//!     number_density_m3: Some(1000.0),
//! });
//! let volume = shape.volume()?;
//! let found = volume.summary();
//! assert!((found.total_water_g / shape.total_water_g() - 1.0).abs() < 1e-6);
//! # Ok::<(), niji_droplets::Error>(())
//! ```

mod cloud;
mod drag;
mod error;
mod fog_bank;
mod fountain;
mod fountain_flight;
mod fountain_jets;
mod fountain_lattice;
mod gradient;
mod gusts;
mod parcels;
mod rain_cell;
mod rain_shaft;
mod sea_spray;
mod shape;
mod slant;
mod strands;
mod turbulence;
mod uniform;
mod waterfall;
mod waterfall_curtain;
mod waterfall_frame;
mod waterfall_mist;
mod waterfall_splash;

pub use cloud::Cloud;
pub use cloud::CloudForm;
pub use error::Error;
pub use fog_bank::FogBank;
pub use fog_bank::FogProfile;
pub use fountain::Fountain;
pub use gradient::Axis;
pub use gradient::Gradient;
pub use rain_cell::RainCell;
pub use rain_shaft::Footprint;
pub use rain_shaft::RainShaft;
pub use sea_spray::SeaSpray;
pub use shape::Shape;
pub use strands::Strands;
pub use turbulence::Turbulence;
pub use uniform::Uniform;
pub use waterfall::Waterfall;
