//! Descartes geometry, the rainbow integral f(z) and its table, Airy's and the uniform theory of the
//! rainbow, and geometric optics.

mod airy;
mod airy_integral;
mod airy_table;
mod bow_direction;
mod fresnel;
mod geometric;
mod geometric_published;
mod rainbow_ray;
mod ray_path;
mod uniform;

pub use airy::AIRY_SMALLEST_RADIUS;
pub use airy::AiryBow;
pub use airy::AiryForm;
pub use airy_integral::airy_integral;
pub use airy_integral::airy_integral_derivative;
pub use airy_integral::airy_integral_with_derivative;
pub use airy_integral::airy_squares;
pub use airy_table::AiryTable;
pub use airy_table::TableError;
pub use airy_table::fringe_coordinate;
pub use airy_table::from_fringe_coordinate;
pub use airy_table::quintic_hermite;
pub use bow_direction::BowDirection;
pub use geometric::GeometricOrder;
pub use geometric_published::PublishedGeometricBow;
pub use geometric_published::published_wavelength;
pub use rainbow_ray::RainbowRay;
pub use rainbow_ray::rainbow_ray;
pub use uniform::UniformBow;
