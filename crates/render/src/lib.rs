//! The ray integral: sunlight scattered by drops and air along every view ray.
//!
//! L(lambda) = E_sun int pi M2 t(theta, m, lambda; r_e, v_e) T_sun T_view ds
//!             + air in-scattering + what shines through
//!
//! `L` radiance [W m^-2 sr^-1 nm^-1], `E_sun` irradiance [W m^-2 nm^-1], `M2` second moment of the
//! drops' radius [m²/m³], `t` scattering table [1/sr], `m` how the flat shape of large drops moves
//! the bow ([`flattening_along`]), `T` what drops and air let pass.
//!
//! The sun is far, so the scattering angle theta and m are the same all along a ray. Light is
//! therefore *deposited* by drop size while the ray is followed ([`Integration`]), and *shaded* with
//! spectra only at its end: the cost hardly depends on the number of wavelengths.
//!
//! Scattering and air are known as tables only; any theory that fills one can be rendered.
//!
//! Start at [`render`]; light the drops first with [`LitDrops::new`].

mod air;
mod air_diffuse;
mod air_glow;
mod air_slabs;
mod deposits;
mod drop_orders;
mod effects;
mod error;
mod error_parts;
mod exponential;
mod flattening;
mod footprint;
mod footprint_error;
mod frame;
mod gauss_nodes;
mod lane_cubic;
mod levels;
mod lit_drops;
mod march;
mod painter;
mod picture;
mod picture_rows;
mod piece;
mod piece_rule;
mod pixel;
mod ray_light;
mod refinement;
mod rendered_rows;
mod request;
mod scattering_angle;
mod scattering_rows;
mod shadow_error;
mod size_axes;
mod sun_sweep;
mod surfaces;
mod surround;

pub use effects::RenderEffects;
pub use effects::Toggle;
pub use error::Error;
pub use error::Wavelengths;
pub use error_parts::ErrorParts;
pub use flattening::flattening_along;
pub use levels::AirPath;
pub use levels::DropExtinctionModel;
pub use levels::DropOrders;
pub use levels::Integration;
pub use levels::PixelFootprint;
pub use levels::RenderLevels;
pub use levels::SkyModel;
pub use levels::SunPath;
pub use lit_drops::LitDrops;
pub use picture::render;
pub use picture::render_in_steps;
pub use picture_rows::Rendered;
pub use request::RenderRequest;
pub use surfaces::Surfaces;
