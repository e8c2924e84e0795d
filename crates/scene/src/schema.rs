//! JSON Schema (draft 2020-12) of scene files, for editors that complete and check TOML.
//!
//! The schema follows from the very structs that are read: names, documentation, defaults, what may be
//! left out, and ranges, which stand beside the fields. Three things of a scene file are none of JSON's
//! and are put right here: a variant with settings is a table that says its name by a key
//! ([`crate::document`] holds the rule), TOML has no null, and the drops are a shape of another crate
//! or a file, or a list of such. What only holds between keys, such as a highest corner above the
//! lowest, is left to the reader.

mod named;
pub(crate) mod parts;
mod tidy;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

use crate::ice_scene::IceScene;
use crate::scene::Scene;
use crate::sun_section::SunSection;

/// The JSON Schema of a scene of drops, as [`crate::Scene::from_toml`] reads it.
///
/// ```
/// let schema = niji_scene::scene_schema();
/// assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
/// assert!(schema["properties"]["drops"].is_object());
/// assert_eq!(schema["additionalProperties"], false);
/// ```
#[must_use]
pub fn scene_schema() -> Value {
    let mut schema = schema::<Scene<SunSection>>("Niji scene");
    parts::named_populations(&mut schema);
    parts::sun_or_picks(&mut schema);
    schema
}

/// The JSON Schema of a scene of ice, as [`IceScene::from_toml`] reads it.
///
/// ```
/// let schema = niji_scene::ice_scene_schema();
/// assert!(schema["properties"]["ice"].is_object());
/// ```
#[must_use]
pub fn ice_scene_schema() -> Value {
    schema::<IceScene>("Niji scene of ice")
}

fn schema<T: JsonSchema>(title: &str) -> Value {
    let generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    named::name_variants(&mut schema);
    tidy::without_null(&mut schema);
    tidy::plain_text(&mut schema);
    tidy::without_unused(&mut schema);
    schema["title"] = title.into();
    schema
}
