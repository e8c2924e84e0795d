//! Scattering tables: a theory, averaged over drop sizes and the sun's disc.

mod adaptive_table;
mod airy_file;
mod angle_grids;
mod axes;
mod bow_light;
mod bow_rows;
mod builder;
mod drop_rows;
mod drop_theory;
mod error;
mod flattening;
mod gamma_sample;
mod interpolation_error;
mod mean_square;
mod request;
mod rings;
mod size_average;
mod sun_disc;
mod theory;
mod theta_axis;

pub use adaptive_table::adaptive_table;
pub use airy_file::airy_from_file;
pub use airy_file::airy_to_file;
pub use axes::radius_axis;
pub use axes::variance_axis;
pub use builder::scattering_table;
pub use error::Error;
pub use request::TableRequest;
pub use theory::Theory;
