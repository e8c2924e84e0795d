//! Scattering tables: a theory, averaged over drop sizes and the sun's disc.

mod airy_file;
mod axes;
mod builder;
mod drop_theory;
mod error;
mod size_average;
mod sun_disc;
mod theory;

pub use airy_file::airy_from_file;
pub use airy_file::airy_to_file;
pub use axes::radius_axis;
pub use axes::variance_axis;
pub use builder::TableRequest;
pub use builder::scattering_table;
pub use error::Error;
pub use theory::Theory;
