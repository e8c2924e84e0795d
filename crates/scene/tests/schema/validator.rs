//! A JSON Schema validator for the keywords that the schemas of scenes use; any other stops the test.
//!
//! Of draft 2020-12, with references into `$defs` only. The conformance tests ask the validator of
//! somebody else about the same scenes.

use serde_json::Map;
use serde_json::Value;

/// Keywords that say nothing about what is right.
const NOTES: [&str; 8] = [
    "$schema",
    "$defs",
    "$comment",
    "title",
    "description",
    "default",
    "format",
    "then",
];

/// The first thing that is wrong, as `path: keyword`; `None` if the value is as the schema says.
pub(crate) fn first_fault(root: &Value, value: &Value) -> Option<String> {
    Validator { root }.fault(root, value, "")
}

struct Validator<'a> {
    root: &'a Value,
}

impl Validator<'_> {
    fn fault(&self, schema: &Value, value: &Value, path: &str) -> Option<String> {
        let keywords = match schema {
            Value::Bool(true) => return None,
            Value::Bool(false) => return Some(format!("{path}: nothing may stand here")),
            Value::Object(keywords) => keywords,
            other => panic!("{other} is no schema"),
        };
        let wrong = |keyword: &str| Some(format!("{path}: {keyword}"));
        keywords.iter().find_map(|(keyword, asked)| {
            if NOTES.contains(&keyword.as_str()) || keyword == "else" {
                return None;
            }
            match self.by_keyword((keyword, asked), keywords, value, path) {
                Outcome::Right => None,
                Outcome::Wrong => wrong(keyword),
                Outcome::Inside(fault) => Some(fault),
            }
        })
    }

    fn by_keyword(
        &self,
        (keyword, asked): (&str, &Value),
        keywords: &Map<String, Value>,
        value: &Value,
        path: &str,
    ) -> Outcome {
        let fits = |schema: &Value| self.fault(schema, value, path).is_none();
        let count_fits = |list: &Value| {
            list.as_array()
                .unwrap()
                .iter()
                .filter(|it| fits(it))
                .count()
        };
        let number = value.as_f64();
        let bound = asked.as_f64().unwrap_or(f64::NAN);
        let length = value.as_array().map(Vec::len);
        let size = asked.as_u64().unwrap_or(0) as usize;
        let right = match keyword {
            "$ref" => {
                let name = asked.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                return self.inside(&self.root["$defs"][name], value, path);
            }
            "type" => is_of_type(asked, value),
            "const" => value == asked || (number.is_some() && number == asked.as_f64()),
            "enum" => asked.as_array().unwrap().contains(value),
            "minimum" => number.is_none_or(|it| it >= bound),
            "maximum" => number.is_none_or(|it| it <= bound),
            "exclusiveMinimum" => number.is_none_or(|it| it > bound),
            "exclusiveMaximum" => number.is_none_or(|it| it < bound),
            "minItems" => length.is_none_or(|it| it >= size),
            "maxItems" => length.is_none_or(|it| it <= size),
            "minLength" => value.as_str().is_none_or(|it| it.chars().count() >= size),
            "uniqueItems" => value.as_array().is_none_or(|it| are_different(it)),
            "required" => is_complete(asked, value),
            "anyOf" => count_fits(asked) > 0,
            "allOf" => {
                let all = asked.as_array().unwrap().iter();
                return first(all.map(|schema| self.fault(schema, value, path)));
            }
            "oneOf" => count_fits(asked) == 1,
            "if" => {
                let branch = if fits(asked) { "then" } else { "else" };
                let branch = keywords.get(branch).unwrap_or(&Value::Bool(true));
                return self.inside(branch, value, path);
            }
            "prefixItems" => {
                let pairs = asked.as_array().unwrap().iter();
                let items = value.as_array().into_iter().flatten();
                return first(
                    pairs
                        .zip(items)
                        .map(|(schema, it)| self.fault(schema, it, path)),
                );
            }
            "items" => {
                let items = value.as_array().into_iter().flatten();
                return first(items.map(|it| self.fault(asked, it, path)));
            }
            "properties" => {
                let fields = asked.as_object().unwrap().iter();
                let given = fields.filter_map(|(key, schema)| Some((key, schema, value.get(key)?)));
                return first(
                    given.map(|(key, schema, it)| self.fault(schema, it, &at(path, key))),
                );
            }
            "additionalProperties" => {
                let known = keywords.get("properties").and_then(Value::as_object);
                let others = value.as_object().into_iter().flatten();
                let others =
                    others.filter(|(key, _)| known.is_none_or(|it| !it.contains_key(*key)));
                return first(others.map(|(key, it)| self.fault(asked, it, &at(path, key))));
            }
            other => panic!("the keyword {other} is not known here"),
        };
        if right {
            Outcome::Right
        } else {
            Outcome::Wrong
        }
    }

    fn inside(&self, schema: &Value, value: &Value, path: &str) -> Outcome {
        first(std::iter::once(self.fault(schema, value, path)))
    }
}

enum Outcome {
    Right,
    Wrong,
    /// What is wrong further inside.
    Inside(String),
}

fn first(mut faults: impl Iterator<Item = Option<String>>) -> Outcome {
    faults
        .find_map(|fault| fault)
        .map_or(Outcome::Right, Outcome::Inside)
}

fn at(path: &str, key: &str) -> String {
    format!("{path}/{key}")
}

fn is_complete(required: &Value, value: &Value) -> bool {
    let Value::Object(table) = value else {
        return true;
    };
    let mut keys = required.as_array().unwrap().iter();
    keys.all(|key| table.contains_key(key.as_str().unwrap()))
}

fn are_different(items: &[Value]) -> bool {
    let repeats = |(index, item)| items[..index].contains(item);
    !items.iter().enumerate().any(repeats)
}

fn is_of_type(types: &Value, value: &Value) -> bool {
    if let Value::Array(types) = types {
        return types.iter().any(|name| is_of_type(name, value));
    }
    match types.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|it| it.fract() == 0.0),
        other => panic!("the type {other} is not known here"),
    }
}
