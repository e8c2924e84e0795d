//! JSON with one spelling for each value, for provenance.

use serde::Serialize;
use serde_json::Value;

/// JSON of `value` with sorted keys and without white space.
///
/// Equal values give equal bytes, in whatever order their maps were filled. Numbers are the shortest
/// decimals that read back exactly. A value that JSON cannot express becomes `null`.
pub fn canonical_json<T: Serialize>(value: &T) -> String {
    let mut text = String::new();
    write_sorted(
        &serde_json::to_value(value).unwrap_or(Value::Null),
        &mut text,
    );
    text
}

/// Sorts by itself: whether `serde_json`'s maps are sorted depends on the features of other crates.
fn write_sorted(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|(key, _)| key.as_str());
            out.push('{');
            for (index, (key, value)) in entries.into_iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                out.push_str(&Value::String(key.clone()).to_string());
                out.push(':');
                write_sorted(value, out);
            }
            out.push('}');
        }
        Value::Array(items) => {
            out.push('[');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                write_sorted(item, out);
            }
            out.push(']');
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
            out.push_str(&value.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn keys_are_sorted_and_nothing_is_spaced() {
        let text = r#"{ "b": [1, 2.5, {"y": null, "x": "\""}], "a": 1e-3 }"#;
        let value: Value = serde_json::from_str(text).unwrap();
        assert_eq!(
            canonical_json(&value),
            r#"{"a":0.001,"b":[1,2.5,{"x":"\"","y":null}]}"#
        );
    }

    #[test]
    fn decimals_read_back_exactly() {
        for number in [0.1 + 0.2, 1e300, 5e-324, 1.0 / 3.0] {
            let map = BTreeMap::from([("x", number)]);
            let back: BTreeMap<String, f64> = serde_json::from_str(&canonical_json(&map)).unwrap();
            assert_eq!(back["x"].to_bits(), f64::to_bits(number));
        }
    }
}
