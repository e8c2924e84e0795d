//! What a schema of Rust types says and that of a TOML file should not.

use std::collections::BTreeSet;

use serde_json::Value;

/// Takes away null, which stands for a key that is left out.
pub(super) fn without_null(schema: &mut Value) {
    let is_null = |item: &Value| item == "null" || item.get("type").is_some_and(|it| it == "null");
    each_object(schema, &mut |object| {
        if object.get("default").is_some_and(Value::is_null) {
            object.remove("default");
        }
        if let Some(Value::Array(types)) = object.get_mut("type") {
            types.retain(|item| !is_null(item));
            if let [only] = types.as_slice() {
                object["type"] = only.clone();
            }
        }
        let Some(Value::Array(choices)) = object.get_mut("anyOf") else {
            return;
        };
        choices.retain(|item| !is_null(item));
        if let [Value::Object(only)] = choices.as_mut_slice() {
            let only = std::mem::take(only);
            object.remove("anyOf");
            for (key, value) in only {
                object.entry(key).or_insert(value);
            }
        }
    });
}

/// Writes documentation as one line without examples and links, and leaves out what only programs
/// want to know.
pub(super) fn plain_text(schema: &mut Value) {
    each_object(schema, &mut |object| {
        object.remove("writeOnly");
        if object.get("format").is_some_and(Value::is_string) {
            object.remove("format");
        }
        if let Some(Value::String(text)) = object.get_mut("description") {
            let prose = text.split("```").next().unwrap_or_default();
            let line = prose.split_whitespace().collect::<Vec<_>>().join(" ");
            *text = line.replace("[`", "`").replace("`]", "`");
        }
    });
}

/// Takes away definitions that nothing refers to.
pub(super) fn without_unused(schema: &mut Value) {
    loop {
        let mut used = BTreeSet::new();
        each_object(schema, &mut |object| {
            if let Some(Value::String(path)) = object.get("$ref") {
                used.extend(path.rsplit('/').next().map(str::to_owned));
            }
        });
        let Some(Value::Object(definitions)) = schema.get_mut("$defs") else {
            return;
        };
        let n_before = definitions.len();
        definitions.retain(|name, _| used.contains(name));
        if definitions.len() == n_before {
            return;
        }
    }
}

/// Visits every object, outer ones first.
fn each_object(value: &mut Value, visit: &mut impl FnMut(&mut serde_json::Map<String, Value>)) {
    match value {
        Value::Object(object) => {
            visit(object);
            for child in object.values_mut() {
                each_object(child, visit);
            }
        }
        Value::Array(items) => {
            for item in items {
                each_object(item, visit);
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => (),
    }
}
