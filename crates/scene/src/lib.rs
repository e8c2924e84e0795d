//! Scene files, effects, the plan with its bounds, and presets.

mod accuracy;
mod canonical_json;
mod check;
mod document;
mod drops;
mod effect;
mod error;
mod level_names;
mod scene;
mod sections;

pub use accuracy::Accuracy;
pub use accuracy::Levels;
pub use accuracy::Preset;
pub use canonical_json::canonical_json;
pub use drops::DropFile;
pub use drops::Drops;
pub use effect::Effect;
pub use effect::EffectSwitches;
pub use effect::Switch;
pub use error::SceneError;
pub use scene::FORMAT;
pub use scene::Scene;
pub use sections::Air;
pub use sections::Camera;
pub use sections::Constituent;
pub use sections::Gamut;
pub use sections::Ground;
pub use sections::Picture;
pub use sections::RayleighModel;
pub use sections::Spectrum;
pub use sections::Sun;
pub use sections::Water;
