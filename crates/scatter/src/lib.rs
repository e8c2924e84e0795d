//! Scattering tables: a theory, averaged over drop sizes and the sun's disc.
//!
//! A [`TableRequest`] names the [`Theory`], the orders and the axes; [`scattering_table`] fills the
//! table at just these sizes, [`adaptive_table`] adds sizes until interpolation between them keeps to
//! the tolerance. The result is a `ScatteringTable` of `niji-exchange`, which the renderer reads.
//!
//! ```
//! use niji_radiometry::Water;
//! use niji_radiometry::WavelengthGrid;
//! use niji_scatter::{SizeRows, TableRequest, Theory, scattering_table, unwatched};
//!
//! let request = TableRequest {
//!     theory: Theory::Airy,
//!     orders: vec![2],
//!     theta_range_rad: (2.3, 2.5),
//!     tolerance: 1e-2,
//!     wavelengths: WavelengthGrid::new(450.0, 200.0, 2)?,
//!     effective_radius_um: vec![500.0],
//!     effective_variance: vec![0.0],
//!     rows: SizeRows::Laws,
//!     motion: None,
//!     sun_disc_diameter_rad: 0.0093,
//!     water: Water::pure(15.0),
//!     airy_table: None,
//! };
//! let table = scattering_table(&request, &unwatched)?;
//!
//! // Natural light is the mean of both polarizations; which angle is brightest?
//! let bow_angle_deg = |wavelength| {
//!     let light = |i| table.values[[0, 0, 0, wavelength, i]] + table.values[[1, 0, 0, wavelength, i]];
//!     let angles = 0..table.theta_rad.len();
//!     let brightest = angles.max_by(|&i, &j| f32::total_cmp(&light(i), &light(j)));
//!     180.0 - table.theta_rad[brightest.expect("a table has angles")].to_degrees()
//! };
//! let (blue, red) = (bow_angle_deg(0), bow_angle_deg(1));
//! assert!((red - 41.9).abs() < 0.2 && (red - blue - 1.0).abs() < 0.2, "{red} {blue}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adaptive_table;
mod airy_file;
mod angle_grids;
mod axis_ratio;
mod bow_light;
mod bow_rows;
mod bow_shift;
mod builder;
mod by_size;
mod corona;
mod dark_band;
mod diffraction;
mod drop_motion;
mod drop_rows;
mod drop_theory;
mod error;
mod gamma_sample;
mod glory;
mod interpolation_error;
mod jet;
mod mean_square;
mod measured_angles;
mod moebius_shift;
mod moved_orders;
mod needed_angles;
mod order_light;
mod phase_functions;
mod progress;
mod request;
mod rings;
mod size_average;
mod spheroid_ray;
#[cfg(test)]
mod spheroid_trace;
mod sun_disc;
mod table_rows;
mod terminal_speed;
mod theory;
mod theta_axis;

pub use adaptive_table::adaptive_table;
pub use airy_file::airy_from_file;
pub use airy_file::airy_to_file;
pub use axis_ratio::axis_ratio;
pub use axis_ratio::eccentricity;
pub use bow_shift::bow_shift;
pub use builder::scattering_table;
pub use by_size::SizeLaw;
pub use by_size::theory_for_laws;
pub use dark_band::dark_band_rad;
pub use drop_motion::DropMotion;
pub use error::Error;
pub use glory::GLORY_LARGEST_UM;
pub use glory::GLORY_START_RAD;
pub use order_light::Band;
pub use order_light::DropLight;
pub use order_light::Light;
pub use order_light::LightRequest;
pub use phase_functions::N_PHASE_ANGLES;
pub use phase_functions::phase_functions;
pub use progress::Progress;
pub use progress::unwatched;
pub use request::SizeRows;
pub use request::TableRequest;
pub use rings::DiscAverage;
pub use rings::Rings;
pub use theory::Theory;
pub use theta_axis::NumberOfAngles;
pub use theta_axis::number_of_angles;
