//! Schemas of the parts whose reading is written by hand.

use std::borrow::Cow;

use niji_droplets::Shape;
use schemars::JsonSchema;
use schemars::Schema;
use schemars::SchemaGenerator;
use schemars::json_schema;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use crate::drops::DropFile;
use crate::drops::DropSource;
use crate::drops::Drops;
use crate::drops::FILE;
use crate::drops::FROM_VDB;
use crate::drops::FromVdb;
use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_switches::EffectSwitches;
use crate::effect_switches::Switch;
use crate::sequence::ANGLES_DEG;
use crate::sequence::LAST_FRAME;
use crate::sequence::RATES;
use crate::sequence::USUAL_RATE;

/// The variants of the shapes beside our own, each as `{ name: settings }`.
impl JsonSchema for DropSource {
    fn schema_name() -> Cow<'static, str> {
        "DropSource".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut drops = Shape::json_schema(generator);
        let own = [
            (
                FROM_VDB,
                generator.subschema_for::<FromVdb>(),
                "A density grid that another program made.",
            ),
            (
                FILE,
                generator.subschema_for::<DropFile>(),
                "A drop volume that exists already.",
            ),
        ];
        let own = own.into_iter().map(|(name, content, description)| {
            json!({
                "description": description,
                "properties": { name: content },
                "required": [name],
            })
        });
        if let Some(Value::Array(variants)) = drops.get_mut("oneOf") {
            variants.extend(own);
        }
        let description =
            "Where the drops are and how large they are: a shape with its keys, or a file.";
        drops.insert("description".to_owned(), description.into());
        drops
    }
}

/// One table, or a list of them.
impl JsonSchema for Drops {
    fn schema_name() -> Cow<'static, str> {
        "Drops".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<DropSource>();
        json_schema!({
            "description": "The drops: one table, or a list of tables whose drops are there together.",
            "type": ["object", "array"],
            "if": { "type": "object" },
            "then": one,
            "items": one,
            "minItems": 1,
        })
    }
}

/// Lets each population of drops have a name beside the keys of what it is.
pub(super) fn named_populations(scene: &mut Value) {
    let drops = &mut scene["$defs"]["DropSource"];
    let name = json!({
        "description": "What the grids of these drops begin with in the drop volume: nothing where they \
                        are the only ones, else what they are and their place.",
        "type": "string",
        "minLength": 1,
    });
    for branch in drops["allOf"].as_array_mut().into_iter().flatten() {
        branch["then"]["properties"]["name"] = name.clone();
    }
    drops["properties"]["name"] = name;
}

/// A key for every effect.
impl JsonSchema for EffectSwitches {
    fn schema_name() -> Cow<'static, str> {
        "EffectSwitches".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let effects = named_variants(Effect::json_schema(generator));
        let switches = named_variants(Switch::json_schema(generator));
        let key = |effect: Effect| {
            let name = effect.name();
            let is_fixed = effect.row().role == Role::Fixed;
            let is_meant = |switch: &Value| !is_fixed || *switch != "off";
            let switches = switches.iter().filter(|it| is_meant(&it["const"]));
            let documented = effects.iter().find(|variant| variant["const"] == name);
            let schema = json!({
                "description": documented.map(|variant| &variant["description"]),
                "oneOf": switches.collect::<Vec<_>>(),
                "default": Switch::default(),
            });
            (name.to_owned(), schema)
        };
        json_schema!({
            "description": "What is to be simulated.",
            "type": "object",
            "properties": Effect::ALL.into_iter().map(key).collect::<Map<_, _>>(),
            "additionalProperties": false,
        })
    }
}

/// The variants of a type that is one of some names.
fn named_variants(schema: Schema) -> Vec<Value> {
    match schema.to_value().get_mut("oneOf").map(Value::take) {
        Some(Value::Array(variants)) => variants,
        _ => Vec::new(),
    }
}

/// Lets the sun be left out where points of the bow in a photograph tell it.
pub(super) fn sun_or_picks(scene: &mut Value) {
    if let Some(Value::Array(required)) = scene.get_mut("required") {
        required.retain(|key| key != "sun");
    }
    scene["anyOf"] = json!([
        { "required": ["sun"] },
        { "properties": { "photo": { "required": ["picks_px"] } }, "required": ["photo"] },
    ]);
}

/// The section `[sequence]`: tables as in the scene, whose values are lists of frame and value.
pub(crate) struct Tracks;

impl JsonSchema for Tracks {
    fn schema_name() -> Cow<'static, str> {
        "Tracks".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let inner = generator.subschema_for::<Tracks>();
        json_schema!({
            "type": "object",
            "properties": { "frames_per_second": {
                "description": "Frames that are shown in a second.",
                "type": "number",
                "minimum": RATES.0,
                "maximum": RATES.1,
                "default": USUAL_RATE,
            }, "shutter_deg": {
                "description": "How long the shutter is open, of a frame's 360 degrees: 180 is usual in films. It stands open half before and half after the frame; at 0 nothing is blurred. Within a frame counts (names that end in _px, seed), voxel_m, files with #### and the sections spectrum, accuracy and picture stay those of the frame.",
                "type": "number",
                "minimum": ANGLES_DEG.0,
                "maximum": ANGLES_DEG.1,
                "default": 0.0,
            } },
            "additionalProperties": { "anyOf": [inner, {
                "description": "Pairs of a frame and a value like that of the scene, frames in ascending order; between them values are interpolated as numbers, so that a turn over north is from 350 to 370 degrees.",
                "type": "array",
                "minItems": 1,
                "items": {
                    "type": "array",
                    "prefixItems": [
                        { "type": "integer", "minimum": 0, "maximum": LAST_FRAME },
                        { "type": ["number", "array"] },
                    ],
                    "minItems": 2,
                    "maxItems": 2,
                },
            }] },
        })
    }
}
