//! Values of a scene's text set by their keys; comments, order and spelling of all else stay.

use serde_json::Value;
use toml_edit::Array;
use toml_edit::DocumentMut;
use toml_edit::Formatted;
use toml_edit::InlineTable;
use toml_edit::Item;
use toml_edit::Table;

/// The text with values set, by paths as `sun.elevation_deg` or `drops.0.voxel_m`; null takes a key out.
///
/// # Errors
/// A text that is no TOML; a path that leads through a value, or a value that TOML lacks.
pub(super) fn with_values<'a>(
    text: &str,
    values: impl IntoIterator<Item = (&'a String, &'a Value)>,
) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    for (path, value) in values {
        let keys: Vec<&str> = path.split('.').collect();
        if keys.iter().any(|key| key.is_empty()) {
            return Err(format!(
                "found the key {path:?}, expected names with points between"
            ));
        }
        set(document.as_item_mut(), &keys, value)
            .map_err(|reason| format!("`{path}` cannot be set: {reason}"))?;
    }
    Ok(document.to_string())
}

/// All values, as JSON.
pub(super) fn values(text: &str) -> Value {
    toml::from_str(text).unwrap_or_default()
}

fn set(item: &mut Item, keys: &[&str], value: &Value) -> Result<(), String> {
    let [key, rest @ ..] = keys else {
        return Err("found no key".to_owned());
    };
    if let Item::ArrayOfTables(tables) = item {
        let table = key.parse().ok().and_then(|index| tables.get_mut(index));
        let table = table.ok_or_else(|| format!("found no table {key}"))?;
        return set_in(table, rest, value);
    }
    if let Some(array) = item.as_array_mut() {
        let index: Option<usize> = key.parse().ok();
        let place = index.and_then(|index| array.get_mut(index));
        let place = place.ok_or_else(|| format!("found no place {key}"))?;
        if !rest.is_empty() {
            let mut inner = Item::Value(place.clone());
            set(&mut inner, rest, value)?;
            *place = inner.into_value().map_err(|_| "found a table".to_owned())?;
            return Ok(());
        }
        *place = instead_of(Some(place), value)?;
        return Ok(());
    }
    let kind = item.type_name();
    let table = item.as_table_like_mut();
    set_in(
        table.ok_or_else(|| format!("found {kind} before `{key}`"))?,
        keys,
        value,
    )
}

fn set_in(
    table: &mut dyn toml_edit::TableLike,
    keys: &[&str],
    value: &Value,
) -> Result<(), String> {
    match keys {
        [] => Err("found a table".to_owned()),
        [key] if value.is_null() => {
            table.remove(key);
            Ok(())
        }
        [key] => {
            let before = table.get(key).and_then(Item::as_value);
            let value = Item::Value(instead_of(before, value)?);
            // The old key keeps the comments before it.
            match table.get_mut(key) {
                Some(place) => *place = value,
                None => drop(table.insert(key, value)),
            }
            Ok(())
        }
        [section, rest @ ..] => {
            if table.get(section).is_none() {
                if value.is_null() {
                    return Ok(());
                }
                let is_inline = table.get_values().len() == table.len() && !table.is_empty();
                // A section of the file is a table of its own, one inside of a section stands in its line.
                let new = if is_inline || rest.len() > 1 {
                    Item::Value(InlineTable::new().into())
                } else {
                    Item::Table(Table::new())
                };
                table.insert(section, new);
            }
            let inner = table.get_mut(section);
            inner.map_or(Ok(()), |inner| set(inner, rest, value))
        }
    }
}

/// A value of TOML, spaced and commented as the one before it; a number stays one with or without a point.
fn instead_of(
    before: Option<&toml_edit::Value>,
    value: &Value,
) -> Result<toml_edit::Value, String> {
    let mut new = match value {
        Value::Bool(flag) => (*flag).into(),
        Value::String(text) => text.as_str().into(),
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(whole), _) if !before.is_some_and(toml_edit::Value::is_float) => whole.into(),
            (_, Some(number)) => toml_edit::Value::Float(Formatted::new(number)),
            _ => return Err(format!("found the number {number}")),
        },
        Value::Array(items) => {
            let before = before.and_then(toml_edit::Value::as_array);
            let mut array = before.cloned().unwrap_or_default();
            array.clear();
            for (index, item) in items.iter().enumerate() {
                let before = before.and_then(|it| it.get(index));
                array.push_formatted(instead_of(before, item)?);
                if before.is_none() && index > 0 {
                    spaced(&mut array, index);
                }
            }
            array.into()
        }
        Value::Object(fields) => {
            let mut table = InlineTable::new();
            for (key, value) in fields {
                table.insert(key, instead_of(None, value)?);
            }
            table.into()
        }
        Value::Null => return Err("found nothing".to_owned()),
    };
    if let Some(before) = before {
        *new.decor_mut() = before.decor().clone();
    }
    Ok(new)
}

fn spaced(array: &mut Array, index: usize) {
    if let Some(item) = array.get_mut(index) {
        item.decor_mut().set_prefix(" ");
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const TEXT: &str = "# A scene.\n[sun] # ours\nelevation_deg = 20.0   # high\nazimuth_deg = 180\n\n\
                        # Where we stand.\n[camera]\nposition_m = [0.0,  2.0, 0.0] # eye\n\n[drops]\n\
                        law = { marshall-palmer = { rain_rate_mm_h = 5.0 } } # rain\n";

    fn changed(path: &str, value: &Value) -> Result<String, String> {
        with_values(TEXT, [(&path.to_owned(), value)])
    }

    #[test]
    fn a_value_changes_and_nothing_else() {
        for (path, value, from, to) in [
            ("sun.elevation_deg", json!(21), "20.0   #", "21.0   #"),
            ("sun.azimuth_deg", json!(181.5), "= 180\n", "= 181.5\n"),
            (
                "camera.position_m",
                json!([1, 2.5, 0]),
                "[0.0,  2.0, 0.0] #",
                "[1.0,  2.5, 0.0] #",
            ),
            ("camera.position_m.1", json!(3), "  2.0,", "  3.0,"),
            (
                "drops.law.marshall-palmer.rain_rate_mm_h",
                json!(7.5),
                "= 5.0 }",
                "= 7.5 }",
            ),
            ("sun.azimuth_deg", Value::Null, "azimuth_deg = 180\n", ""),
        ] {
            assert_eq!(
                changed(path, &value).unwrap(),
                TEXT.replace(from, to),
                "{path}"
            );
        }
    }

    #[test]
    fn a_section_that_is_not_there_comes_at_the_end() {
        let text = changed("picture.exposure_ev", &json!(1.5)).unwrap();
        assert_eq!(text, format!("{TEXT}\n[picture]\nexposure_ev = 1.5\n"));
        // What is read is what was meant.
        assert_eq!(values(&text)["picture"]["exposure_ev"], 1.5);
        let text = changed("drops.turbulence", &json!({"strength": 0.5})).unwrap();
        assert_eq!(values(&text)["drops"]["turbulence"]["strength"], 0.5);
    }

    #[test]
    fn paths_that_lead_nowhere_are_refused() {
        for (path, value) in [
            ("sun.elevation_deg.x", json!(1)),
            ("camera.position_m.7", json!(1)),
            ("camera.position_m.x", json!(1)),
            ("sun..x", json!(1)),
            ("", json!(1)),
        ] {
            assert!(changed(path, &value).is_err(), "{path}");
        }
    }
}
