//! Units, wavelength grids, spectra, CIE color, solar irradiance and refractive indices.
//!
//! The bottom of the workspace: every stage speaks in these units and on these wavelength grids.
//! Its tables are embedded; nothing is read from disk but how much memory the system has. How much of that a file
//! may take, and that it is a file at all, every reader asks here.
//!
//! ```
//! use niji_radiometry::{Colorimetry, WavelengthGrid, solar_irradiance, xy_chromaticity};
//!
//! let grid = WavelengthGrid::visible();
//! let sun = solar_irradiance(&grid);
//! let [x, y] = xy_chromaticity(Colorimetry::new(&grid).xyz(&sun)).expect("the sun is not dark");
//! assert!((x - 0.325).abs() < 0.005 && (y - 0.334).abs() < 0.005);
//! ```

mod byte_count;
mod ciddor;
mod color_space;
mod colorimetry;
mod error;
mod gauss_legendre;
mod ground_reflectance;
mod iapws_r9_97;
mod memory_limit;
mod moonlight;
mod open_file;
mod piecewise_linear;
mod quan_fry;
mod reflectance;
mod rgb_primaries;
mod size_parameter;
mod solar_irradiance;
mod tabulated_spectrum;
mod units;
mod warren_brandt;
mod water;
mod wavelength_grid;

pub use crate::byte_count::Bytes;
pub use crate::ciddor::air_refractive_index;
pub use crate::color_space::GamutPolicy;
pub use crate::color_space::into_gamut;
pub use crate::color_space::kept_saturation;
pub use crate::color_space::linear_rec709_to_xyz;
pub use crate::color_space::srgb_decode;
pub use crate::color_space::srgb_encode;
pub use crate::color_space::xy_chromaticity;
pub use crate::color_space::xyz_to_linear_rec709;
pub use crate::colorimetry::Colorimetry;
pub use crate::colorimetry::OBSERVER_RANGE_NM;
pub use crate::error::Error;
pub use crate::gauss_legendre::gauss_legendre;
pub use crate::ground_reflectance::GroundCover;
pub use crate::iapws_r9_97::water_refractive_index;
pub use crate::memory_limit::memory_limit;
pub use crate::memory_limit::set_memory_limit;
pub use crate::moonlight::moon_over_sun;
pub use crate::open_file::open_file;
pub use crate::quan_fry::sea_water_refractive_index;
pub use crate::reflectance::Reflectance;
pub use crate::rgb_primaries::RgbPrimaries;
pub use crate::size_parameter::size_parameter;
pub use crate::solar_irradiance::solar_irradiance;
pub use crate::tabulated_spectrum::TabulatedSpectrum;
pub use crate::units::Meters;
pub use crate::units::Micrometers;
pub use crate::units::Nanometers;
pub use crate::units::Radians;
pub use crate::warren_brandt::ice_refractive_index;
pub use crate::water::Water;
pub use crate::wavelength_grid::WavelengthGrid;
