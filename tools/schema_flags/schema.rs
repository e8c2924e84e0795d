//! A JSON schema read as fields.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Map;
use serde_json::Value;

use super::field::Field;
use super::field::Flags;
use super::field::Kind;
use super::field::Variant;

/// The schema of a type, with every type inside written out in its place.
pub(super) fn of<T: JsonSchema>() -> Value {
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().into()
}

/// The fields of a struct in the order of its definition, their flags behind a prefix; none for
/// anything else.
pub(super) fn fields(schema: &Value, prefix: &str) -> Vec<Field> {
    let required: Vec<&str> = list(schema, "required")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    // A list of structs has no flag: it stands in files.
    let has_flag =
        |(_, schema): &(&String, &Value)| schema.get("items").and_then(properties).is_none();
    let field = |(key, schema): (&String, &Value)| {
        let flag = format!("{prefix}{}", key.replace('_', "-"));
        Field {
            key: key.clone(),
            help: documentation(schema),
            is_required: required.contains(&key.as_str()),
            default: schema
                .get("default")
                .filter(|value| !value.is_null())
                .cloned(),
            kind: kind(without_null(schema), &flag),
            flag,
        }
    };
    properties(schema)
        .into_iter()
        .flatten()
        .filter(has_flag)
        .map(field)
        .collect()
}

/// The variants of an enum of structs.
pub(super) fn variants(schema: &Value) -> Vec<Variant> {
    let variant = |item: &Value| {
        let (name, content) = properties(item)?.iter().next()?;
        Some(Variant {
            name: name.clone(),
            about: documentation(item),
            flags: Flags {
                fields: fields(content, ""),
            },
        })
    };
    list(schema, "oneOf").iter().filter_map(variant).collect()
}

fn kind(schema: &Value, flag: &str) -> Kind {
    let items = list(schema, "oneOf");
    if let Some(first) = items.first() {
        return match properties(first).and_then(|content| content.values().next()) {
            None => Kind::Name(names(schema)),
            Some(content) if properties(content).is_some() => Kind::Choice(variants(schema)),
            Some(_) => Kind::OneOf(items.iter().flat_map(numbers).collect()),
        };
    }
    if properties(schema).is_some() {
        return Kind::Group(fields(schema, &format!("{flag}-")));
    }
    let is = |name: &str| match schema.get("type") {
        Some(Value::Array(names)) => names.iter().any(|found| found == name),
        found => found.is_some_and(|found| found == name),
    };
    if let Some(items) = schema
        .get("items")
        .filter(|items| items.get("oneOf").is_some())
    {
        return Kind::Names(names(items));
    }
    let length = schema.get("maxItems").and_then(Value::as_u64);
    match length {
        Some(n) => Kind::Numbers(n as usize),
        // A number or words: who reads them knows which.
        None if is("number") && is("string") => Kind::Text,
        None if is("number") => Kind::Number,
        None if is("integer") => Kind::WholeNumber,
        None => Kind::Text,
    }
}

/// The names of an enum without content.
pub(super) fn names(schema: &Value) -> Vec<(String, String)> {
    list(schema, "oneOf").iter().filter_map(name).collect()
}

fn name(item: &Value) -> Option<(String, String)> {
    let name = item.get("const")?.as_str()?;
    Some((name.to_owned(), documentation(item)))
}

/// The fields of a variant whose content is a plain number; its documentation is theirs.
fn numbers(item: &Value) -> Vec<Field> {
    let mut fields = fields(item, "");
    for field in &mut fields {
        field.help = documentation(item);
    }
    fields
}

/// What may be left out is written as "this or null".
fn without_null(schema: &Value) -> &Value {
    let is_null = |item: &&Value| item.get("type").is_none_or(|name| name != "null");
    list(schema, "anyOf").iter().find(is_null).unwrap_or(schema)
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema.get("properties")?.as_object()
}

fn list<'a>(schema: &'a Value, key: &str) -> &'a [Value] {
    schema
        .get(key)
        .and_then(Value::as_array)
        .map_or(&[], Vec::as_slice)
}

/// The documentation as a line without the final full stop, as help texts are.
fn documentation(schema: &Value) -> String {
    let text = schema
        .get("description")
        .and_then(Value::as_str)
        .unwrap_or_default();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.trim_end_matches('.').to_owned()
}
