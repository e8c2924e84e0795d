//! What one stage hands to the next as EXR: tables with axes, spectral images and provenance.

mod atmosphere_table;
mod attributes;
mod checksum;
mod contents;
mod error;
mod exr_read;
mod exr_write;
mod part;
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
pub use contents::ChannelRange;
pub use contents::PartContents;
pub use contents::contents;
pub use error::Error;
pub use preview::tone_curve;
pub use provenance::Provenance;
pub use provenance::content_hash;
pub use provenance::read_provenance;
pub use scattering_table::ScatteringTable;
pub use spectral_image::Aov;
pub use spectral_image::SpectralImage;
pub use table::Axis;
pub use table::Channel;
pub use table::TableFile;
pub use table::TablePart;
