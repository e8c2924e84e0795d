//! Scattering tables: a theory, averaged over drop sizes and the sun's disc.

mod airy_file;
mod axes;
mod bow_light;
mod bow_rows;
mod builder;
mod drop_theory;
mod error;
mod exact_rows;
mod mean_square;
mod request;
mod rings;
mod size_average;
mod sun_disc;
mod theory;
mod theta_axis;

pub use airy_file::airy_from_file;
pub use airy_file::airy_to_file;
pub use axes::radius_axis;
pub use axes::variance_axis;
pub use builder::scattering_table;
pub use error::Error;
pub use request::TableRequest;
pub use theory::Theory;
