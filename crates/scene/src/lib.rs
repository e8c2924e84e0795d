//! Scene files, effects, the plan with its bounds, and presets.
//!
//! A [`Scene`] is everything that a picture depends on, read from TOML and refused, with its line,
//! if a key is misspelt at any depth. [`plan()`] says which [`Effect`]s it calls for, what leaving the
//! others out can cost, and which stages run with which tables. Opens no file.
//!
//! ```
//! use niji_scene::{Effect, Scene, Stage, plan};
//!
//! let text = include_str!("../../../data/scenes/garden-fountain.toml");
//! let scene = Scene::from_toml(text)?;
//! let plan = plan(&scene, None)?;
//! // Ten metres of air do nothing to the light of a fountain, but its sunlight came through all.
//! assert!(!plan.is_on(Effect::AirExtinction) && plan.is_on(Effect::SunlightThroughAir));
//! assert!(plan.runs(Stage::Atmosphere));
//! println!("{plan}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accuracy;
mod air;
mod albedo;
mod camera_section;
mod canonical_json;
mod check;
mod document;
mod drops;
mod effect;
mod effect_facts;
mod effect_switches;
mod error;
mod figures;
mod files;
mod ice_scene;
mod levels_for_tolerance;
mod moment;
mod occluders;
mod photo;
mod plan;
mod read_scene;
mod scene;
mod scene_check;
mod schema;
mod sections;
mod sequence;
mod sky_level;
mod sun_section;
mod terrain;
mod water_surface;

pub use accuracy::Accuracy;
pub use accuracy::DropSpacing;
pub use accuracy::Levels;
pub use accuracy::Preset;
pub use air::Air;
pub use air::Constituent;
pub use air::Haze;
pub use air::Layer;
pub use air::LayerLaw;
pub use air::RayleighModel;
pub use albedo::Albedo;
pub use camera_section::Camera;
pub use camera_section::Projection;
pub use canonical_json::canonical_json;
pub use drops::DropFile;
pub use drops::DropSource;
pub use drops::Drops;
pub use drops::FromVdb;
pub use drops::Population;
pub use effect::Effect;
pub use effect_switches::EffectSwitches;
pub use effect_switches::Switch;
pub use error::SceneError;
pub use ice_scene::IceAccuracy;
pub use ice_scene::IceScene;
pub use ice_scene::IceSection;
pub use ice_scene::IceShape;
pub use ice_scene::UniformSky;
pub use levels_for_tolerance::BRIGHT_DROPS;
pub use levels_for_tolerance::Goal;
pub use levels_for_tolerance::LEAST_TOLERANCE;
pub use levels_for_tolerance::SHARE_FOR_LEVELS;
pub use levels_for_tolerance::most_error_of_orders;
pub use levels_for_tolerance::tolerance_for_motion;
pub use levels_for_tolerance::tolerance_for_rays;
pub use levels_for_tolerance::tolerance_for_sky;
pub use levels_for_tolerance::tolerance_for_spacing;
pub use moment::Moment;
pub use moment::NoSuchMoment;
pub use moment::SunPosition;
pub use occluders::Along;
pub use occluders::OccluderMesh;
pub use occluders::Occluders;
pub use photo::Photo;
pub use photo::PhotoExposure;
pub use photo::PickedBow;
pub use photo::PickedColor;
pub use plan::Blur;
pub use plan::Bound;
pub use plan::BoundKind;
pub use plan::BoundTerms;
pub use plan::DropPart;
pub use plan::DropSummary;
pub use plan::EffectDecision;
pub use plan::Estimate;
pub use plan::Explanation;
pub use plan::Foretold;
pub use plan::LawsInLight;
pub use plan::Misfit;
pub use plan::Plan;
pub use plan::PlanError;
pub use plan::PlannedFrame;
pub use plan::SHARE_FOR_EFFECTS;
pub use plan::ScatteringNeed;
pub use plan::Stage;
pub use plan::StagePlan;
pub use plan::View;
pub use plan::plan;
pub use plan::plan_looking;
pub use scene::FORMAT;
pub use scene::Scene;
pub use schema::ice_scene_schema;
pub use schema::scene_schema;
pub use sections::Body;
pub use sections::Gamut;
pub use sections::Ground;
pub use sections::Picture;
pub use sections::Primaries;
pub use sections::Spectral;
pub use sections::Sun;
pub use sections::Water;
pub use sequence::LAST_FRAME;
pub use sequence::Sequence;
pub use sequence::Shutter;
pub use sequence::with_frame;
pub use sky_level::SkyLevel;
pub use sun_section::SunSection;
pub use terrain::Terrain;
pub use water_surface::WaterSurface;
