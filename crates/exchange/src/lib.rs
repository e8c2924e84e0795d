//! What one stage hands to the next as EXR: tables with axes, spectral images and provenance.

mod atmosphere_table;
mod attributes;
mod canonical_header;
mod container;
mod error;
mod preview;
mod provenance;
mod scattering_table;
mod spectral_image;
mod table;
mod wavelength_names;

pub use atmosphere_table::AirConstituent;
pub use atmosphere_table::AtmosphereTable;
pub use atmosphere_table::DensityLaw;
pub use attributes::AttributeValue;
pub use attributes::Attributes;
pub use error::Error;
pub use preview::tone_curve;
pub use preview::write_png;
pub use provenance::Provenance;
pub use provenance::content_hash;
pub use scattering_table::ScatteringTable;
pub use spectral_image::Aov;
pub use spectral_image::SpectralImage;
pub use table::Axis;
pub use table::Channel;
pub use table::TableFile;
pub use table::TablePart;
