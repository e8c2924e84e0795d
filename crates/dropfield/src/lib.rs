//! Drop volumes: modes, area moments, their VDB layout, bricks and sampling.
//!
//! A [`DropVolume`] is a sum of modes; a [`DropMode`] holds [`Drops`] at the nodes of a sparse
//! lattice, goes to a VDB file and comes from one. For rays it becomes [`Bricks`], whose
//! [`Segments`] are the cells along a ray and whose samples are [`AreaMoments`].
//!
//! ```
//! use glam::DVec3;
//! use niji_dropfield::{Bricks, DropMode, Drops, GridBox, Interpolation};
//!
//! // 1000 drops of 0.1 mm per cubic metre, 10 m thick.
//! let drops =
//!     Drops { number_density_m3: 1000.0, effective_radius_m: 1e-4, effective_variance: 0.0 };
//! let grid = GridBox { min: DVec3::ZERO, max: DVec3::splat(10.0), voxel_m: 0.5 };
//! let mode = DropMode::from_fn("", &grid, |_| drops)?;
//! let bricks = Bricks::build(&mode, Interpolation::Moments)?;
//!
//! let ray = bricks.segments(DVec3::new(-5.0, 5.0, 5.0), DVec3::X, (0.0, 100.0));
//! let optical_depth: f64 = ray
//!     .map(|cell| {
//!         let length_m = cell.t_exit - cell.t_enter;
//!         length_m * cell.sample(0.5).moments().extinction_m1_q1()
//!     })
//!     .sum();
//! assert!((optical_depth - 10.0 * 3.1416e-5).abs() < 1e-8);
//! # Ok::<(), niji_dropfield::Error>(())
//! ```

mod area_moments;
mod brick_layout;
mod bricks;
mod coarse_cells;
mod drops;
mod error;
mod from_density;
mod grid_box;
mod law_shares;
mod local_radius;
mod mode;
mod radius_formula;
mod read_vdb;
mod resample;
mod segments;
mod size_range;
mod summary;
#[cfg(test)]
mod test_volumes;
mod volume;
mod warning;

pub use area_moments::AreaMoments;
pub use area_moments::MAX_EFFECTIVE_VARIANCE;
pub use bricks::Bricks;
pub use bricks::Interpolation;
pub use bricks::NodeValues;
pub use bricks::Sample;
pub use drops::Drops;
pub use error::Error;
pub use from_density::DensityImport;
pub use from_density::DensityMeans;
pub use from_density::EffectiveRadius;
pub use grid_box::GridBox;
pub use law_shares::LawShare;
pub use mode::DropLeaf;
pub use mode::DropMode;
pub use mode::LARGEST_NUMBER_M3;
pub use mode::LEAF_DIM;
pub use mode::LEAF_NODES;
pub use segments::Segment;
pub use segments::Segments;
pub use size_range::SizeRange;
pub use size_range::mixture_variance;
pub use summary::VolumeSummary;
pub use volume::DropVolume;
pub use volume::mode_name_fault;
pub use warning::Warning;
