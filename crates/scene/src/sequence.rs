//! The section `[sequence]`: what changes from frame to frame.
//!
//! v(f) = (1 - t) v_k + t v_(k+1),   t = (f - f_k)/(f_(k+1) - f_k)
//! `f` the frame, `v_k` the values at the frames `f_k` that are written down; before the first and
//! after the last of them a value stays. A key stands where it stands in the scene, a list of pairs of
//! frame and value:
//!
//! ```toml
//! [sequence]
//! sun.elevation_deg = [[1, 10.0], [240, 20.0]]
//! camera.position_m = [[1, [0.0, 1.6, 0.0]], [240, [0.0, 1.6, -50.0]]]
//! ```
//!
//! Values are numbers and lie between those of the keys, angles too: a turn over north is written from
//! 350 to 370 degrees, for from 350 to 10 leads back over south. A key whose values, the scene's among
//! them, are all written as whole numbers has a whole number wherever one lies there: so `camera.width_px`
//! or a seed can be a key; a frame in which it is none is refused.
//!
//! A table of a list has the key of its name, and where it has none that of its place, counted from 0:
//! `drops.fine.voxel_m`, `drops.1.voxel_m`.
//!
//! `frames_per_second` is no key of a scene: how many frames are shown in a second, 24 where it is left out.
//!
//! Besides, `####` in the name of a file of `[drops]` or `[occluders]` is the frame, with zeros in front
//! up to the number of `#`: drops and depths that another program made for every frame.
//!
//! A frame is a scene of its own: its text is the scene's with other numbers in the same lines, so that
//! everything that can be wrong with a scene is said of a frame in the same words.

mod number;

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::Range;

use toml::Spanned;
use toml::Value;
use toml::de::DeTable;
use toml::de::DeValue;

use crate::canonical_json::canonical_json;
use crate::error::SceneError;
use crate::error::suggest;

use number::Number;

/// Name of the section.
const SECTION: &str = "sequence";
/// Key of the section that is none of the scene, and its range.
const RATE: &str = "frames_per_second";
pub(crate) const RATES: (f64, f64) = (1.0, 1000.0);
/// Rate of films.
pub(crate) const USUAL_RATE: f64 = 24.0;
/// Says how the scene is read, so that no frame can have another.
const VERSION: &str = "format";
/// Sections whose texts may name a file for every frame.
const SECTIONS_WITH_FILES: [&str; 2] = ["drops", "occluders"];
/// Stands for a digit of the frame.
const DIGIT: char = '#';
/// Last frame that can be asked for.
pub const LAST_FRAME: u32 = 9_999_999;

/// A scene that changes from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Frames that are shown in a second.
    pub frames_per_second: f64,
    text: String,
    /// What changes and where it stands in the text, from its end to its beginning.
    changes: Vec<(Range<usize>, Change)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Change {
    /// Values at frames, in ascending order.
    Keys(Vec<(u32, Number)>),
    /// A name with digits to be filled in.
    File(String),
}

/// A number that stands in the scene.
struct Found {
    place: Range<usize>,
    value: Number,
}

impl Sequence {
    /// Reads what changes in a scene; `None` if nothing does.
    ///
    /// # Errors
    /// A key that the scene does not have, one that is no number or list of numbers, or values that
    /// are no list of pairs of frame and value of the same form.
    pub fn from_toml(text: &str) -> Result<Option<Self>, SceneError> {
        let line = |offset: usize| 1 + text[..offset].matches('\n').count();
        let root = DeTable::parse(text).map_err(|error| SceneError::Syntax {
            line: line(error.span().map_or(0, |span| span.start)),
            message: error.message().replace('\n', "; "),
        })?;
        let (mut numbers, mut changes) = (BTreeMap::new(), Vec::new());
        let mut frames_per_second = USUAL_RATE;
        for (section, value) in root.get_ref() {
            let name = section.get_ref();
            if name != SECTION && name != VERSION {
                collect_numbers(value, name, &mut numbers);
            }
            if SECTIONS_WITH_FILES.contains(&name.as_ref()) {
                collect_files(value, &mut changes);
            }
        }
        let section = root
            .get_ref()
            .iter()
            .find(|(key, _)| key.get_ref() == SECTION);
        if let Some((key, _)) = section {
            let line = line(key.span().start);
            let parsed: toml::Table = text.parse().map_err(|error: toml::de::Error| {
                let message = error.message().to_owned();
                SceneError::Syntax { line, message }
            })?;
            let tracks = Tracks { numbers, line };
            let mut section = parsed[SECTION].clone();
            let rate = section.as_table_mut().and_then(|it| it.remove(RATE));
            if let Some(rate) = rate {
                frames_per_second = tracks.rate(&rate)?;
            }
            tracks.collect("", &section, &mut changes)?;
        }
        if changes.is_empty() {
            return Ok(None);
        }
        changes.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
        let text = text.to_owned();
        Ok(Some(Self {
            frames_per_second,
            text,
            changes,
        }))
    }

    /// The frames at which values are written down.
    #[must_use]
    pub fn keys(&self) -> BTreeSet<u32> {
        let frames = self.changes.iter().flat_map(|(_, change)| match change {
            Change::Keys(keys) => keys.iter().map(|(frame, _)| *frame).collect(),
            Change::File(_) => Vec::new(),
        });
        frames.collect()
    }

    /// The names of files with a place for the frame.
    pub fn file_names(&self) -> impl Iterator<Item = &str> {
        self.changes.iter().filter_map(|(_, change)| match change {
            Change::Keys(_) => None,
            Change::File(name) => Some(name.as_str()),
        })
    }

    /// All that is written of it but for comments and spaces, as JSON.
    #[must_use]
    pub fn settings(&self) -> String {
        // It was read before.
        let written: toml::Table = self.text.parse().unwrap_or_default();
        canonical_json(&written)
    }

    /// The scene of a frame.
    #[must_use]
    pub fn scene_text(&self, frame: u32) -> String {
        let mut text = self.text.clone();
        for (place, change) in &self.changes {
            let mut written = match change {
                Change::Keys(keys) => at(keys, frame).to_toml(),
                Change::File(name) => Value::String(with_frame(name, frame)).to_string(),
            };
            // A list over several lines: what follows keeps its line.
            let n_lines = text[place.clone()].matches('\n').count();
            if let Some(end) = written.rfind(']') {
                written.insert_str(end, &"\n".repeat(n_lines));
            }
            text.replace_range(place.clone(), &written);
        }
        text
    }
}

/// The numbers of a scene by their full path.
fn collect_numbers(value: &Spanned<DeValue>, path: &str, found: &mut BTreeMap<String, Found>) {
    for (key, child) in children(value) {
        collect_numbers(child, &format!("{path}.{key}"), found);
    }
    if let Some(number) = Number::written(value.get_ref()) {
        let place = value.span();
        let value = number;
        found.insert(path.to_owned(), Found { place, value });
    }
}

/// What stands in a table, or in a list of tables, by its key.
fn children<'a>(value: &'a Spanned<DeValue<'a>>) -> Vec<(String, &'a Spanned<DeValue<'a>>)> {
    match value.get_ref() {
        DeValue::Table(table) => {
            let entries = table.iter();
            let entries = entries.map(|(key, child)| (key.get_ref().to_string(), child));
            entries.collect()
        }
        DeValue::Array(items) => {
            let items = items.iter().enumerate();
            let tables = items.filter_map(|(place, item)| {
                let table = item.get_ref().as_table()?;
                let name = table.get("name").and_then(|name| name.get_ref().as_str());
                Some((name.map_or(place.to_string(), str::to_owned), item))
            });
            tables.collect()
        }
        DeValue::String(_)
        | DeValue::Integer(_)
        | DeValue::Float(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_) => Vec::new(),
    }
}

/// The texts with a place for the frame.
fn collect_files(value: &Spanned<DeValue>, changes: &mut Vec<(Range<usize>, Change)>) {
    for (_, child) in children(value) {
        collect_files(child, changes);
    }
    if let Some(text) = value.get_ref().as_str().filter(|text| text.contains(DIGIT)) {
        changes.push((value.span(), Change::File(text.to_owned())));
    }
}

/// A name with the frame in place of each run of `#`.
pub fn with_frame(name: &str, frame: u32) -> String {
    let mut written = String::new();
    let mut rest = name;
    while let Some(start) = rest.find(DIGIT) {
        let after = rest[start..].trim_start_matches(DIGIT);
        let n_digits = rest.len() - start - after.len();
        // Writing to a string never fails.
        let _ = write!(written, "{}{frame:0n_digits$}", &rest[..start]);
        rest = after;
    }
    written + rest
}

/// What the section may name, and where it stands.
struct Tracks {
    numbers: BTreeMap<String, Found>,
    line: usize,
}

impl Tracks {
    fn rate(&self, value: &Value) -> Result<f64, SceneError> {
        let rate = value.as_float().or(value.as_integer().map(|it| it as f64));
        rate.filter(|rate| (RATES.0..=RATES.1).contains(rate))
            .ok_or_else(|| SceneError::OutOfRange {
                line: self.line,
                key: format!("{SECTION}.{RATE}"),
                found: value.to_string(),
                expected: format!("{} to {} frames in a second", RATES.0, RATES.1),
            })
    }

    /// Reads the section, which has the tables of the scene.
    fn collect(
        &self,
        path: &str,
        value: &Value,
        changes: &mut Vec<(Range<usize>, Change)>,
    ) -> Result<(), SceneError> {
        let Value::Table(table) = value else {
            let found = self.numbers.get(path).ok_or_else(|| self.unknown(path))?;
            let keys = self.keys(path, value, &found.value)?;
            changes.push((found.place.clone(), Change::Keys(keys)));
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

/// The value at a frame.
fn at(keys: &[(u32, Number)], frame: u32) -> Number {
    let after = keys.partition_point(|(key, _)| *key <= frame);
    if after == 0 {
        return keys[0].1.clone();
    }
    let (before, value) = &keys[after - 1];
    match keys.get(after) {
        Some((next, next_value)) if frame > *before => {
            value.mix(next_value, (frame - before, next - before))
        }
        Some(_) | None => value.clone(),
    }
}

#[cfg(test)]
#[path = "sequence_tests.rs"]
mod tests;
