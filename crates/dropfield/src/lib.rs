//! Drop volumes: modes, area moments, their VDB layout, bricks and sampling.

mod area_moments;
mod bricks;
mod drops;
mod error;
mod grid_box;
mod mode;
mod read_vdb;
mod segments;
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
pub use grid_box::DEFAULT_NODE_LIMIT;
pub use grid_box::GridBox;
pub use mode::DropLeaf;
pub use mode::DropMode;
pub use mode::LEAF_DIM;
pub use mode::LEAF_NODES;
pub use segments::Segment;
pub use segments::Segments;
pub use summary::VolumeSummary;
pub use volume::DropVolume;
pub use warning::Warning;
