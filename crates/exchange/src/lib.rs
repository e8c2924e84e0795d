//! What one stage hands to the next as EXR: tables with axes, spectral images and provenance.
//!
//! Every file is a plain EXR that other programs open: tables are parts whose width and height are
//! axes ([`TableFile`]; [`ScatteringTable`] and [`AtmosphereTable`] are views of one), images follow
//! the layout of Fichet, Pacanowski and Wilkie ([`SpectralImage`]). Files are written to any writer
//! and read by path. The same content gives the same bytes; NaN and infinity enter no file; a damaged
//! file is an error, never a panic or an abort. A checksum covers pixels, the attributes `niji:…`, white, camera and
//! place in the frame, so that damage never makes other numbers of them than those written; standard attributes that
//! other programs set too, `screenWindowWidth`, `framesPerSecond` and `timeCode`, are not covered.
//!
//! ```
//! use ndarray::array;
//! use niji_exchange::{Attributes, Axis, Channel, Provenance, TableFile, TablePart};
//!
//! let part = TablePart {
//!     name: "profile".to_owned(),
//!     column_axis: Axis::new("height", "m", vec![0.0, 8000.0]),
//!     row_axes: Vec::new(),
//!     channels: vec![Channel { name: "density".to_owned(), values: array![[1.0, 0.37]] }],
//!     attributes: Attributes::new(),
//! };
//! let quantity = "air".to_owned();
//! let file = TableFile { quantity, parts: vec![part], provenance: Provenance::default() };
//! let mut bytes = std::io::Cursor::new(Vec::new());
//! file.write(&mut bytes)?;
//!
//! let path = std::env::temp_dir().join(format!("niji-doc-{}.exr", std::process::id()));
//! std::fs::write(&path, bytes.get_ref())?;
//! let again = TableFile::read(&path)?;
//! std::fs::remove_file(&path)?;
//! assert_eq!(again.part("profile")?.channel("density")?, array![[1.0, 0.37]]);
//! assert_eq!(again.part("profile")?.column_axis.values, [0.0, 8000.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod atmosphere_table;
mod attributes;
mod bow_shift;
mod checksum;
mod contents;
mod error;
mod exr_read;
mod exr_write;
mod falling_drops;
mod frame_time;
mod guarded;
mod image_windows;
mod interpolation_error;
mod layer_rms;
mod layers_file;
mod luminance;
mod moved_bows;
mod part;
mod picture_file;
mod plain;
mod preview;
mod provenance;
mod scattering_table;
mod spectra;
mod spectral_image;
mod strips;
mod table;
mod wavelength_names;

pub use atmosphere_table::AirConstituent;
pub use atmosphere_table::AtmosphereTable;
pub use atmosphere_table::DensityLaw;
pub use atmosphere_table::DiffuseLight;
pub use atmosphere_table::DiffusePlace;
pub use atmosphere_table::DiffuseView;
pub use atmosphere_table::Stencil;
pub use atmosphere_table::cosines_of_multiples;
pub use atmosphere_table::expansion_weights;
pub use atmosphere_table::harmonics;
pub use atmosphere_table::legendre_polynomials;
pub use atmosphere_table::moment_index;
pub use atmosphere_table::n_moments;
pub use attributes::AttributeValue;
pub use attributes::Attributes;
pub use attributes::WINDOW_WIDTH;
pub use bow_shift::BowShift;
pub use bow_shift::FARTHEST_SHIFT_RAD;
pub use bow_shift::SeenShift;
pub use contents::ChannelRange;
pub use contents::PartContents;
pub use contents::contents;
pub use error::Error;
pub use falling_drops::Attitude;
pub use falling_drops::FallingDrops;
pub use frame_time::FrameTime;
pub use guarded::guarded;
pub use image_windows::ImageWindows;
pub use interpolation_error::AxisError;
pub use interpolation_error::InterpolationError;
pub use interpolation_error::N_STRETCHES;
pub use interpolation_error::stretch_of;
pub use layer_rms::LayerRms;
pub use luminance::luminance;
pub use moved_bows::MovedBows;
pub use moved_bows::MovedOrder;
pub use picture_file::BeyondHalf;
pub use picture_file::Held;
pub use picture_file::PictureFile;
pub use picture_file::PictureHead;
pub use picture_file::StripReader;
pub use picture_file::StripWriter;
pub use plain::PlainPart;
pub use plain::read_plain;
pub use plain::write_plain;
pub use preview::Preview;
pub use preview::tone_curve;
pub use preview::write_srgb_png;
pub use provenance::Provenance;
pub use provenance::content_hash;
pub use provenance::read_provenance;
pub use provenance::text_hash;
pub use scattering_table::RowUse;
pub use scattering_table::ScatteringTable;
pub use spectra::Spectra;
pub use spectral_image::Aov;
pub use spectral_image::SpectralImage;
pub use strips::STRIP_BYTES;
pub use table::Axis;
pub use table::Channel;
pub use table::TableFile;
pub use table::TablePart;
