//! Authoring: shapes of rain, fountains and fog as drop volumes.
//!
//! A [`Shape`] is a few numbers from a scene file. It knows its totals, bounds and ranges in closed
//! form, before any voxel exists, and lays itself out as a volume.
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

mod error;
mod fog_bank;
mod gradient;
mod rain_shaft;
mod shape;
mod uniform;

pub use error::Error;
pub use fog_bank::FogBank;
pub use fog_bank::FogProfile;
pub use gradient::Axis;
pub use gradient::Gradient;
pub use rain_shaft::Footprint;
pub use rain_shaft::RainShaft;
pub use shape::Shape;
pub use uniform::Uniform;
