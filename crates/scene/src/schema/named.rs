//! Variants with settings as scene files write them.
//!
//! A derived schema has `{ "march": { "step_m": 1.0 } }`; the reader wants `{ level = "march",
//! step_m = 1.0 }`, or another key, or none. Which it is, is asked of the reader.

use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use crate::document::Naming;
use crate::document::naming;
use crate::drops::FILE;

/// Where a schema keeps those of its types.
const DEFINITIONS: &str = "$defs";

/// Rewrites every type that is one of several variants.
pub(super) fn name_variants(schema: &mut Value) {
    let Some(Value::Object(definitions)) = schema.get(DEFINITIONS).cloned() else {
        return;
    };
    for (name, definition) in &definitions {
        let Some(variants) = definition.get("oneOf").and_then(Value::as_array) else {
            continue;
        };
        let has_settings = variants.iter().any(|variant| content(variant).is_some());
        let only_tables = variants.iter().all(|variant| content(variant).is_some());
        let named = match naming(name) {
            Naming::Key(_) | Naming::OnlyKey if !has_settings => continue,
            Naming::OnlyKey => one_of(variants.iter().map(documented_at_key)),
            Naming::Key(key) => {
                let tables = variants
                    .iter()
                    .flat_map(|variant| by_key(key, variant, &definitions));
                if only_tables {
                    chosen_by(key, &tables.collect::<Vec<_>>())
                } else {
                    one_of(tables)
                }
            }
        };
        let mut rewritten = definition.as_object().cloned().unwrap_or_default();
        rewritten.remove("oneOf");
        rewritten.extend(named);
        schema[DEFINITIONS][name] = rewritten.into();
    }
}

fn one_of(variants: impl Iterator<Item = Value>) -> Map<String, Value> {
    Map::from_iter([("oneOf".to_owned(), variants.collect())])
}

/// One of several tables by the name at a key. With `oneOf` an editor could only say that none of
/// all the tables fits; so the name decides which table must fit. All keys stand beside, for editors
/// that complete them without asking the name.
fn chosen_by(key: &str, tables: &[Value]) -> Map<String, Value> {
    let name = |table: &Value| table["properties"].get(key).cloned();
    let mut keys = Map::from_iter([(
        key.to_owned(),
        json!({ "oneOf": tables.iter().filter_map(name).collect::<Vec<_>>() }),
    )]);
    let mut branches = Vec::new();
    for table in tables {
        let condition = match name(table) {
            Some(name) => json!({ "properties": { key: name }, "required": [key] }),
            None => json!({ "properties": { key: false }, "required": table["required"] }),
        };
        branches.push(json!({ "if": condition, "then": table }));
        for (field, schema) in table["properties"].as_object().into_iter().flatten() {
            let described = json!({ "description": schema["description"] });
            keys.entry(field).or_insert(described);
        }
    }
    let ways = tables.iter().map(|table| match name(table) {
        Some(_) => json!({ "required": [key] }),
        None => json!({ "required": table["required"] }),
    });
    let mut ways: Vec<Value> = ways.collect();
    ways.dedup();
    let whole = json!({
        "type": "object",
        "properties": keys,
        "anyOf": ways,
        "allOf": branches,
    });
    whole.as_object().cloned().unwrap_or_default()
}

/// Name and settings of a variant that has some.
fn content(variant: &Value) -> Option<(&String, &Value)> {
    let only_key = variant.get("properties")?.as_object()?.iter().next()?;
    (variant["required"] == json!([only_key.0])).then_some(only_key)
}

/// A variant whose only key says what it is, as editors show it.
fn documented_at_key(variant: &Value) -> Value {
    let mut variant = variant.clone();
    if let Some((name, _)) = content(&variant.clone()) {
        variant["properties"][name]["description"] = variant["description"].clone();
    }
    variant
}

/// A variant as the reader takes it: a bare name also as a table.
fn by_key(key: &str, variant: &Value, definitions: &Map<String, Value>) -> Vec<Value> {
    let description = variant.get("description").cloned().unwrap_or_default();
    let Some((name, settings)) = content(variant) else {
        let name = variant.get("const").cloned().unwrap_or_default();
        let table = table(
            &description,
            [(key.to_owned(), constant(&name, &description))],
        );
        return vec![variant.clone(), table];
    };
    let settings = resolved(settings, definitions);
    let mut named = if name == FILE {
        table(&description, [])
    } else {
        let name = constant(&Value::from(name.as_str()), &description);
        table(&description, [(key.to_owned(), name)])
    };
    for (part, value) in settings.as_object().into_iter().flatten() {
        match (part.as_str(), value) {
            ("properties", Value::Object(fields)) => {
                for (field, schema) in fields {
                    named["properties"][field] = schema.clone();
                }
            }
            ("required", Value::Array(fields)) => {
                if let Some(required) = named["required"].as_array_mut() {
                    required.extend(fields.iter().cloned());
                }
            }
            ("type" | "additionalProperties" | "description", _) => (),
            _ => named[part] = value.clone(),
        }
    }
    vec![named]
}

/// A table with these keys, all of them required, and no others.
fn table<const N: usize>(description: &Value, keys: [(String, Value); N]) -> Value {
    let required: Vec<_> = keys.iter().map(|(key, _)| key.clone()).collect();
    json!({
        "description": description,
        "type": "object",
        "properties": Map::from_iter(keys),
        "required": required,
        "additionalProperties": false,
    })
}

fn constant(name: &Value, description: &Value) -> Value {
    json!({ "type": "string", "const": name, "description": description })
}

/// The schema that a reference stands for.
fn resolved<'a>(schema: &'a Value, definitions: &'a Map<String, Value>) -> &'a Value {
    let name = schema.get("$ref").and_then(Value::as_str);
    let name = name.and_then(|path| path.rsplit('/').next());
    name.and_then(|name| definitions.get(name))
        .unwrap_or(schema)
}
