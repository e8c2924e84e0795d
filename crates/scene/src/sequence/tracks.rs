//! The section as it is written: tracks of keys, and settings that are no keys of a scene.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::Value;

use super::Change;
use super::Found;
use super::LAST_FRAME;
use super::SECTION;
use super::number::Number;
use super::shutter::Within;
use crate::error::SceneError;
use crate::error::suggest;

/// A setting: its name, its range and what is counted.
pub(super) type Setting = (&'static str, (f64, f64), &'static str);

/// What the section may name, and where it stands.
pub(super) struct Tracks {
    pub(super) numbers: BTreeMap<String, Found>,
    pub(super) line: usize,
}

impl Tracks {
    /// Takes a setting out of the section that is no key of a scene.
    pub(super) fn setting(
        &self,
        section: &mut Value,
        (key, range, unit): Setting,
    ) -> Result<Option<f64>, SceneError> {
        let Some(value) = section.as_table_mut().and_then(|it| it.remove(key)) else {
            return Ok(None);
        };
        let number = value.as_float().or(value.as_integer().map(|it| it as f64));
        let number = number.filter(|number| (range.0..=range.1).contains(number));
        number.map(Some).ok_or_else(|| SceneError::OutOfRange {
            line: self.line,
            key: format!("{SECTION}.{key}"),
            found: value.to_string(),
            expected: format!("{} to {} {unit}", range.0, range.1),
        })
    }

    /// Reads the section, which has the tables of the scene.
    pub(super) fn collect(
        &self,
        path: &str,
        value: &Value,
        changes: &mut Vec<(Range<usize>, Change)>,
    ) -> Result<(), SceneError> {
        let Value::Table(table) = value else {
            let found = self.numbers.get(path).ok_or_else(|| self.unknown(path))?;
            let keys = self.keys(path, value, &found.value)?;
            let change = Change::Keys(keys, Within::of(path));
            changes.push((found.place.clone(), change));
            return Ok(());
        };
        for (key, child) in table {
            let path = if path.is_empty() {
                key.clone()
            } else {
                format!("{path}.{key}")
            };
            self.collect(&path, child, changes)?;
        }
        Ok(())
    }

    fn keys(
        &self,
        path: &str,
        value: &Value,
        like: &Number,
    ) -> Result<Vec<(u32, Number)>, SceneError> {
        let wrong = |found: String| SceneError::WrongType {
            line: self.line,
            key: format!("{SECTION}.{path}"),
            found,
            expected: format!(
                "pairs of a frame and a value like that of the scene, say [[1, {0}], [240, {0}]]",
                like.to_toml()
            ),
        };
        let pairs = value.as_array().filter(|pairs| !pairs.is_empty());
        let pairs = pairs.ok_or_else(|| wrong(value.to_string()))?;
        let mut keys: Vec<(u32, Number)> = Vec::new();
        for pair in pairs {
            let (frame, value) = match pair.as_array().map(Vec::as_slice) {
                Some([frame, value]) => (frame.as_integer(), Number::of(value)),
                _ => (None, None),
            };
            let frame = frame.and_then(|frame| u32::try_from(frame).ok());
            let frame = frame.filter(|frame| *frame <= LAST_FRAME);
            let (Some(frame), Some(value)) = (frame, value.filter(|value| value.is_like(like)))
            else {
                return Err(wrong(pair.to_string()));
            };
            if keys.last().is_some_and(|(last, _)| *last >= frame) {
                return Err(SceneError::OutOfRange {
                    line: self.line,
                    key: format!("{SECTION}.{path}"),
                    found: format!("frame {frame} after a frame that is not before it"),
                    expected: "frames in ascending order".to_owned(),
                });
            }
            keys.push((frame, value));
        }
        if !like.is_whole() || keys.iter().any(|(_, value)| !value.is_whole()) {
            keys = keys
                .into_iter()
                .map(|(frame, value)| (frame, value.into_real()))
                .collect();
        }
        Ok(keys)
    }

    fn unknown(&self, path: &str) -> SceneError {
        let allowed: Vec<String> = self.numbers.keys().cloned().collect();
        SceneError::UnknownKey {
            line: self.line,
            section: format!("[{SECTION}]"),
            key: path.to_owned(),
            suggestion: suggest(path, &allowed),
            allowed,
        }
    }
}
