//! Descartes geometry, the rainbow integral f(z) and its table, Airy's and the uniform theory of the
//! rainbow, and geometric optics.
//!
//! A bow of order p is light that was reflected p - 1 times inside the drop: 2 the primary, 3 the
//! secondary. All theories say how much light a sphere throws into a direction
//! ([`BowDirection::normalized_cross_section`], 1/sr over its shadow), from [`GeometricOrder`] (rays)
//! over [`AiryBow`] (interference near the bow) to [`UniformBow`] (both).
//!
//! ```
//! use niji_airy::{AiryBow, airy_integral, airy_squares, rainbow_ray};
//! use niji_radiometry::{Micrometers, Nanometers, Radians};
//!
//! // Descartes in 1637: 42 degrees from the antisolar point, and 51 after two reflections.
//! let bow_angle_deg = |p| Some(180.0 - rainbow_ray(4.0 / 3.0, p)?.theta_rad().to_degrees());
//! assert!((bow_angle_deg(2).expect("n < 2") - 42.03).abs() < 0.01);
//! assert!((bow_angle_deg(3).expect("n < 3") - 50.98).abs() < 0.01);
//!
//! // Airy in 1838: f(z) has its first zero, the first dark fringe, at z = 2.4955.
//! assert!(airy_integral(2.4955).abs() < 1e-4);
//!
//! // Drops of 0.1 mm are brightest a degree inside Descartes' bow.
//! let bow = AiryBow::new(4.0 / 3.0, 2).expect("n < 2");
//! let light = |theta_deg: f64| {
//!     let direction = bow.direction(Radians::from_degrees(theta_deg));
//!     let (radius, wavelength) = (Micrometers(100.0), Nanometers(550.0));
//!     let [s, p] = direction.normalized_cross_section(radius, wavelength, airy_squares);
//!     0.5 * (s + p)
//! };
//! assert!(light(139.1) > 2.0 * light(137.97));
//! ```

mod airy;
mod airy_integral;
mod airy_table;
mod bow_direction;
mod fresnel;
mod geometric;
mod geometric_published;
mod rainbow_ray;
mod ray_branch;
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
pub use airy_table::HermiteNode;
pub use airy_table::TableError;
pub use airy_table::fringe_coordinate;
pub use airy_table::from_fringe_coordinate;
pub use airy_table::quintic;
pub use airy_table::quintic_coefficients;
pub use airy_table::quintic_hermite;
pub use bow_direction::BowDirection;
pub use geometric::GeometricOrder;
pub use geometric_published::PublishedGeometricBow;
pub use rainbow_ray::RainbowRay;
pub use rainbow_ray::rainbow_ray;
pub use uniform::UniformBow;
