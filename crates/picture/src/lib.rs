//! A scene becomes a picture in memory.
//!
//! ```
//! use std::path::Path;
//! use niji_picture::{PlanRequest, PlannedScene, scene_from_toml, unwatched};
//!
//! let text = include_str!("../../../data/scenes/paper-c-figure-3.toml");
//! let folder = Path::new("data/scenes");
//! let scene = scene_from_toml(text, folder)?;
//! # let scene = { let mut scene = scene; scene.camera.width_px = 24; scene.camera.height_px = 16; scene };
//! let planned = PlannedScene::new(scene, PlanRequest { folder, ..PlanRequest::default() })?;
//! println!("{}", planned.plan);
//! let image = planned.picture(&unwatched)?;
//! let mut png = Vec::new();
//! image.write_png(&mut png, planned.scene.picture.exposure_ev)?;
//! # assert!(png.len() > 100);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`PlannedScene`] makes its parts one by one, each a value: drops, Airy's integral, scattering table,
//! air, surfaces. [`PictureParts`] and [`PictureSettings`] together are [`PictureWork`], which renders any
//! region. `niji run` writes and reads each as a file in between, and comes to the same bytes. Whoever waits
//! hears of it by a [`Watch`], and may stop it.
//!
//! No file is written here, and nothing but files that a scene names is read.

pub mod air;
mod background;
mod bow_edge;
mod budget;
mod choice;
mod composite;
mod drop_volume;
mod error;
mod foreseen_errors;
mod image;
mod image_camera;
mod kept_parts;
mod look;
mod mean_of_instants;
mod mesh_paint;
mod open_shutter;
mod photo_depth;
mod photographed_light;
mod picked_sun;
mod picture;
mod pilot;
mod planned_scene;
mod sandbox;
pub mod scattering;
mod scene_checks;
mod seen_drops;
mod sequence_choice;
mod sky_marks;
mod stage_seconds;
mod sun_volume;
mod surfaces;
mod watch;

pub use background::Background;
pub use background::DEPTH_MAP;
pub use bow_edge::BowEdge;
pub use bow_edge::EDGE_ERROR;
pub use budget::Afforded;
pub use budget::TOLERANCES;
pub use choice::Choice;
pub use composite::CardExposure;
pub use composite::Composite;
pub use composite::CompositeRequest;
pub use composite::SetBow;
pub use drop_volume::VolumePart;
pub use drop_volume::VolumeSource;
pub use drop_volume::read_drops;
pub use drop_volume::read_vdb;
pub use error::Error;
pub use error::with_causes;
pub use error::without_path;
pub use foreseen_errors::DROP_SPACING;
pub use foreseen_errors::ForeseenErrors;
pub use foreseen_errors::LEFT_OUT;
pub use foreseen_errors::SKY;
pub use image::white_luminance_cd_m2;
pub use kept_parts::KeptParts;
pub use kept_parts::Photographed;
pub use look::Look;
pub use look::Looks;
pub use look::have_same_light;
pub use mean_of_instants::MOTION;
pub use niji_scene::Scene;
pub use open_shutter::OpenShutter;
pub use photo_depth::DepthMap;
pub use photo_depth::Distances;
pub use photo_depth::EYE_HEIGHT;
pub use photo_depth::MapValues;
pub use photo_depth::POSITION_WEIGHT;
pub use photo_depth::PhotoDepth;
pub use photo_depth::PhotoDepthRequest;
pub use picked_sun::PICK_ERROR_PX;
pub use picked_sun::PickedSuns;
pub use picked_sun::PicksRequest;
pub use picked_sun::picked_sun;
pub use picked_sun::scene_from_toml;
pub use picked_sun::turned_picks;
pub use picture::PictureParts;
pub use picture::PictureSettings;
pub use picture::PictureWork;
pub use picture::rows_of_step;
pub use planned_scene::PlanRequest;
pub use planned_scene::PlannedScene;
pub use sandbox::Sandbox;
pub use scene_checks::check_files;
pub use seen_drops::SeenDrops;
pub use sequence_choice::SequenceChoice;
pub use sequence_choice::SequenceRequest;
pub use sky_marks::BowTop;
pub use sky_marks::Lines;
pub use sky_marks::SkyMarks;
pub use sky_marks::bow_angle;
pub use stage_seconds::WRITTEN_BYTES_PER_S;
pub use stage_seconds::stage_seconds;
pub use stage_seconds::table_seconds;
pub use surfaces::DepthFile;
pub use surfaces::SurfaceFiles;
pub use watch::Watch;
pub use watch::unwatched;
