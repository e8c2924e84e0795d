//! Air: one file for each constituent, one for each method of solution.
//!
//! An [`AirModel`] says what the air is made of; [`AirModel::tabulate`] turns it into the table that
//! renderers read. Constituents: `rayleigh_nishita`, `rayleigh_bodhaine`, `ozone`, `aerosol`,
//! `band_gas` (water vapor, oxygen).
//! Methods: `optical_length` (midpoints, Gauss-Legendre, Chapman, table), `in_scattering`,
//! `sky`, `sky_dome`, `sun_beam`; `sky_method` lists those for a sky with their errors.
//!
//! ```
//! use niji_atmosphere::{AirModel, NishitaAir, USUAL_TOP_M, sun_transmittance};
//! use niji_geometry::EARTH;
//! use niji_radiometry::{Radians, Reflectance, WavelengthGrid};
//!
//! let wavelengths = WavelengthGrid::new(450.0, 200.0, 2)?;
//! let model = AirModel {
//!     planet: EARTH,
//!     top_height_m: USUAL_TOP_M,
//!     wavelengths,
//!     sun_scale: 1.0,
//!     ground: Reflectance::Even(0.2),
//!     constituents: vec![NishitaAir::PUBLISHED.constituent(&wavelengths)?],
//! };
//! let air = model.tabulate()?;
//! let noon = sun_transmittance(&air, 0.0, 1.0, Radians(0.0));
//! let evening = sun_transmittance(&air, 0.0, 0.05, Radians(0.0));
//! assert!(evening[0] / noon[0] < evening[1] / noon[1], "the low sun is red");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aerosol;
mod air_model;
mod angle_table;
mod band_gas;
mod chapman;
mod constituent;
mod cornette_shanks;
mod density_profile;
mod diffuse_dome;
mod error;
mod eval;
mod exponential;
mod gas_absorption;
mod gathered;
mod gauss_kronrod;
mod gauss_legendre;
mod ground_sun;
mod henyey_greenstein;
mod in_scattering;
mod king_factor;
mod leg;
mod multiple_scattering;
mod optical_length;
mod ozone;
mod phase_function;
mod rayleigh_bodhaine;
mod rayleigh_nishita;
mod rayleigh_phase;
mod reach_table;
mod refined_axis;
mod sky;
mod sky_dome;
mod sky_method;
mod sky_view;
mod sun_beam;
mod sun_disc;
mod view_ray;

pub use crate::aerosol::Aerosol;
pub use crate::aerosol::AerosolKind;
pub use crate::aerosol::AerosolLobe;
pub use crate::air_model::AirModel;
pub use crate::air_model::USUAL_TOP_M;
pub use crate::band_gas::BandGas;
pub use crate::chapman::chapman_erfcx;
pub use crate::constituent::Constituent;
pub use crate::cornette_shanks::cornette_shanks;
pub use crate::density_profile::DensityProfile;
pub use crate::diffuse_dome::DiffuseDome;
pub use crate::error::Error;
pub use crate::eval::AirSample;
pub use crate::eval::evaluate_rays;
pub use crate::henyey_greenstein::henyey_greenstein;
pub use crate::in_scattering::AirLight;
pub use crate::in_scattering::InScattering;
pub use crate::in_scattering::SingleScattering;
pub use crate::king_factor::KingFactor;
pub use crate::king_factor::king_factor;
pub use crate::multiple_scattering::DiffuseSky;
pub use crate::multiple_scattering::ScatteringOrders;
pub use crate::multiple_scattering::Suns;
pub use crate::multiple_scattering::diffuse_light;
pub use crate::multiple_scattering::diffuse_light_while;
pub use crate::multiple_scattering::with_diffuse_light;
pub use crate::multiple_scattering::with_diffuse_light_of;
pub use crate::optical_length::OpticalLength;
pub use crate::optical_length::optical_length_m;
pub use crate::ozone::OzoneLayer;
pub use crate::phase_function::PhaseFunction;
pub use crate::rayleigh_bodhaine::BodhaineAir;
pub use crate::rayleigh_bodhaine::STANDARD_PRESSURE_PA;
pub use crate::rayleigh_bodhaine::rayleigh_bodhaine_m1;
pub use crate::rayleigh_nishita::NishitaAir;
pub use crate::rayleigh_phase::rayleigh_phase;
pub use crate::sky_dome::SkyDome;
pub use crate::sky_method::PreparedSky;
pub use crate::sky_method::ReferenceSky;
pub use crate::sky_method::SkyMethod;
pub use crate::sky_method::SkyMethodCost;
pub use crate::sky_method::spread_directions;
pub use crate::sky_view::SkyDirection;
pub use crate::sky_view::SkyObserver;
pub use crate::sun_beam::sun_irradiance_at;
pub use crate::sun_beam::sun_transmittance;
pub use crate::sun_disc::SUN_RADIUS;
pub use crate::view_ray::ViewRay;
