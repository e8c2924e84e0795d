//! The ray integral: sunlight scattered by drops and air along every view ray.
//!
//! L(lambda) = E_sun int pi M2 t(theta, m, lambda; r_e, v_e) T_sun T_view ds
//!             + air in-scattering + what shines through
//!
//! `L` radiance [W m^-2 sr^-1 nm^-1], `E_sun` irradiance [W m^-2 nm^-1], `M2` second moment of the
//! drops' radius [m²/m³], `t` scattering table [1/sr], `m` how the flat shape of large drops moves
//! the bow (T² and B² of the drops' axis), `T` what drops and air let pass.
//!
//! The sun is far, so the scattering angle theta and m are the same all along a ray. Light is
//! therefore *deposited* by drop size while the ray is followed ([`Integration`]), and *shaded* with
//! spectra only at its end: the cost hardly depends on the number of wavelengths.
//!
//! Water mirrors the sun: then drops that know of it ([`LitDrops::beside_water`]) send the light of a second
//! sun, or of a streak of suns, marched along the same rays.
//!
//! Scattering and air are known as tables only; any theory that fills one can be rendered.
//!
//! Start at [`render`]; light the drops first with [`LitDrops::new`].
//!
//! ```
//! use glam::DVec3;
//! use ndarray::Array5;
//! use niji_dropfield::{Bricks, DropMode, Drops, GridBox, Interpolation};
//! use niji_exchange::{RowUse, ScatteringTable};
//! use niji_geometry::{PinholeCamera, PinholeRequest, PixelRegion};
//! use niji_radiometry::{Radians, Water, WavelengthGrid};
//! use niji_render::{
//!     AirPath, DropExtinctionModel, DropOrders, Integration, LitDrops, PixelFootprint,
//!     RenderEffects, RenderLevels, RenderRequest, SkyModel, SunPath, render,
//! };
//!
//! // A curtain of 1 mm drops, 20 m thick and 100 m to the north of the eye.
//! let drops =
//!     Drops { number_density_m3: 100.0, effective_radius_m: 1e-3, effective_variance: 0.0 };
//! let min = DVec3::new(-200.0, -200.0, -120.0);
//! let curtain = GridBox { min, max: DVec3::new(200.0, 200.0, -100.0), voxel_m: 5.0 };
//! let bricks = Bricks::build(&DropMode::from_fn("", &curtain, |_| drops)?, Interpolation::Moments)?;
//! let sun_direction = DVec3::Z;
//! let drops = LitDrops::new(vec![bricks], sun_direction, SunPath::Ignore)?;
//!
//! // Drops that scatter evenly into all directions, 1/(4 pi) of the light on their shadow.
//! let wavelengths = WavelengthGrid::new(550.0, 10.0, 1)?;
//! let table = ScatteringTable {
//!     theory: "isotropic".to_owned(),
//!     orders: "all".to_owned(),
//!     wavelengths,
//!     theta_rad: vec![0.0, std::f64::consts::PI],
//!     effective_radius_um: vec![1000.0],
//!     effective_variance: vec![0.0],
//!     moved: None,
//!     row_use: RowUse::Laws,
//!     relative_error: 5e-3,
//!     values: Array5::from_elem((2, 1, 1, 1, 2), 0.25 * std::f32::consts::FRAC_1_PI),
//!     sun_disc_diameter_rad: 0.0,
//!     split_theta_rad: 2.3,
//!     forward_fraction_left_out: 0.0,
//!     water: Water::pure(15.0),
//!     phase_functions: None,
//!     interpolation_error: None,
//! };
//! let camera = PinholeCamera::new(PinholeRequest {
//!     position: DVec3::ZERO,
//!     azimuth: Radians(0.0),
//!     elevation: Radians(0.0),
//!     roll: Radians(0.0),
//!     horizontal_fov: Radians::from_degrees(1.0),
//!     width_px: 3,
//!     height_px: 3,
//! })?;
//! let picture = render(
//!     &RenderRequest {
//!         camera: &camera.into(),
//!         region: PixelRegion::frame(3, 3),
//!         sun_direction,
//!         wavelengths,
//!         sun_irradiance: &[1.0],
//!         drops: &drops,
//!         table: Some(&table),
//!         air: None,
//!         surfaces: None,
//!         water: None,
//!         effects: RenderEffects::BOWS_ONLY,
//!         levels: RenderLevels {
//!             integration: Integration::CellExact,
//!             drop_extinction_model: DropExtinctionModel::WithoutDiffraction,
//!             drop_orders: DropOrders::SingleScattering,
//!             air_path: AirPath::Table,
//!             sky_model: SkyModel::None,
//!             pixel_footprint: PixelFootprint::Center,
//!         },
//!         tolerance_cd_m2: None,
//!         orders_error_cd_m2: None,
//!         coarser_rays: 1.0,
//!     },
//!     &|_| (),
//! )?;
//!
//! // L = E N pi a^2 t s: 100 drops of 3.14 mm^2 in a cubic metre, 20 m, 1/(4 pi).
//! let expected = 100.0 * 1e-6 * 20.0 / 4.0;
//! assert!((f64::from(picture.radiance[[0, 1, 1]]) / expected - 1.0).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod air;
mod air_diffuse;
mod air_error;
mod air_glow;
mod air_slabs;
mod angle_axis;
mod cell_cubics;
mod deadline;
mod deep_air;
mod deposits;
mod diffracted_light;
mod drop_orders;
mod effects;
mod error;
mod error_parts;
mod exponential;
mod flattening;
mod footprint;
mod footprint_cuts;
mod footprint_error;
mod foretold;
mod frame;
mod front_transmittance;
mod gauss_nodes;
mod ground_view;
mod lane_cubic;
mod levels;
mod lit_drops;
mod map_edge;
mod march;
mod measured_air;
mod merged_cells;
mod mesh_view;
mod mirrored_drops;
mod mirrored_table;
mod moved_angles;
mod moved_radii;
mod moved_rows;
mod node_views;
mod paint;
mod picture;
mod picture_layers;
mod picture_tiles;
mod piece;
mod piece_rule;
mod pixel;
mod polarized_rows;
mod progress;
mod ray_lattice;
mod ray_light;
mod ray_settings;
mod ray_sums;
mod ray_tracer;
mod refinement;
mod reflection;
mod request;
mod scattering_angle;
mod scattering_rows;
mod seen_water;
mod sent_light;
mod shadow_error;
mod size_axes;
mod size_nodes;
mod size_rows;
mod sky_view;
mod spectra;
mod stretch;
mod sun_direction;
mod sun_glint;
mod sun_streak;
mod sun_sweep;
mod surface_light;
mod surfaces;
mod surround;
mod terrain_view;
mod turned;
mod under_drops;
mod water_reflectance;
mod water_surface;
mod wave_facets;

pub use deadline::Afforded;
pub use deadline::Clock;
pub use deadline::Deadline;
pub use deadline::MoreRays;
pub use deadline::Spent;
pub use drop_orders::STANDARD_ERRORS;
pub use effects::RenderEffects;
pub use effects::Toggle;
pub use error::Error;
pub use error::Input;
pub use error::Wavelengths;
pub use foretold::foretold_seconds;
pub use levels::AirPath;
pub use levels::DropExtinctionModel;
pub use levels::DropOrders;
pub use levels::Integration;
pub use levels::PixelFootprint;
pub use levels::RenderLevels;
pub use levels::SkyModel;
pub use levels::SunPath;
pub use lit_drops::LitDrops;
pub use paint::Material;
pub use paint::Paint;
pub use paint::SurfaceColor;
pub use paint::Texture;
pub use picture::render;
pub use picture::render_in_steps;
pub use picture::render_in_strips;
pub use picture_layers::PictureLayer;
pub use picture_layers::Rendered;
pub use progress::Progress;
pub use progress::unwatched;
pub use request::LEAST_STEPS;
pub use request::RenderRequest;
pub use request::ask_for_memory;
pub use surfaces::Solid;
pub use surfaces::SolidShape;
pub use surfaces::Surfaces;
pub use under_drops::shade_under_drops;
pub use water_surface::MirroredLight;
pub use water_surface::WaterSurface;
pub use water_surface::wave_slope;
