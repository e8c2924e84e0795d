//! Drop-size laws and their moments.
//!
//! A law says how the radii of the drops of a cubic metre are distributed. What light needs of it
//! is [`SizeMoments`]: how many drops, their mean square radius, effective radius and effective
//! variance. [`GammaSizes`] is the law with which the other stages close these moments again.
//!
//! ```
//! use niji_sizes::{MarshallPalmer, SizeLaw};
//!
//! let law = SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0));
//! law.validate()?;
//! let rain = law.moments().bulk_properties(law.natural_number_density_m3().unwrap_or(1.0));
//! assert!((rain.lwc_g_m3 - 0.344).abs() < 5e-4);
//! # Ok::<(), niji_sizes::Error>(())
//! ```

mod amount;
mod bulk;
mod cloud_preset;
mod error;
mod gamma;
mod gamma_quadrature;
mod hansen_travis;
mod law;
mod law_nodes;
mod law_weights;
mod lognormal;
mod marshall_palmer;
mod marshall_palmer_dbz;
mod modified_gamma;
mod monodisperse;
mod normal;
mod rosin_rammler;
mod truncated_moments;
mod truncated_normal;
mod ulbrich;
mod uniform;

pub use amount::Amount;
pub use bulk::BulkProperties;
pub use bulk::SizeMoments;
pub use bulk::WATER_DENSITY_G_M3;
pub use bulk::liquid_water_g_m3;
pub use cloud_preset::Cloud;
pub use cloud_preset::CloudPreset;
pub use error::Error;
pub use gamma::GammaSizes;
pub use gamma_quadrature::gamma_area_quadrature;
pub use hansen_travis::HansenTravis;
pub use law::SizeLaw;
pub use law_nodes::bin_step;
pub use law_nodes::bins;
pub use law_nodes::narrowest_variance;
pub use law_nodes::radius_axis;
pub use law_nodes::variance_axis;
pub use law_weights::law_support;
pub use law_weights::law_weights;
pub use lognormal::Lognormal;
pub use marshall_palmer::MOST_RAIN_MM_H;
pub use marshall_palmer::MarshallPalmer;
pub use marshall_palmer_dbz::MarshallPalmerDbz;
pub use modified_gamma::ModifiedGamma;
pub use monodisperse::Monodisperse;
pub use normal::Normal;
pub use rosin_rammler::RosinRammler;
pub use truncated_normal::TruncatedNormal;
pub use ulbrich::Ulbrich;
pub use uniform::Uniform;
