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
//! Besides, `####` in the name of a file of `[drops]` or `[occluders]` is the frame, with zeros in front
//! up to the number of `#`: drops and depths that another program made for every frame.
//!
//! A frame is a scene of its own: its text is the scene's with other numbers in the same lines, so that
//! everything that can be wrong with a scene is said of a frame in the same words.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;

use toml::Spanned;
use toml::Value;
use toml::de::DeTable;
use toml::de::DeValue;

use crate::error::SceneError;
use crate::error::suggest;

/// Name of the section.
const SECTION: &str = "sequence";
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

/// A number, or a list of numbers or lists.
#[derive(Debug, Clone, PartialEq)]
enum Number {
    /// As it is written, without a point.
    Whole(i64),
    Real(f64),
    Many(Vec<Number>),
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
            tracks.collect("", &parsed[SECTION], &mut changes)?;
        }
        if changes.is_empty() {
            return Ok(None);
        }
        changes.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
        let text = text.to_owned();
        Ok(Some(Self { text, changes }))
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
    if let Some(number) = number(value.get_ref()) {
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

fn number(value: &DeValue) -> Option<Number> {
    match value {
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
            .ok()
            .map(Number::Whole),
        DeValue::Float(number) => number.as_str().parse().ok().map(Number::Real),
        DeValue::Array(items) if !items.is_empty() => {
            let numbers = items.iter().map(|item| number(item.get_ref()));
            numbers.collect::<Option<_>>().map(Number::Many)
        }
        DeValue::Array(_)
        | DeValue::String(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_)
        | DeValue::Table(_) => None,
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
fn with_frame(name: &str, frame: u32) -> String {
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

impl Number {
    fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Integer(number) => Some(Self::Whole(*number)),
            Value::Float(number) if number.is_finite() => Some(Self::Real(*number)),
            Value::Array(items) => {
                let items = items.iter().map(Self::of);
                items.collect::<Option<_>>().map(Self::Many)
            }
            Value::Float(_)
            | Value::String(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Table(_) => None,
        }
    }

    fn is_whole(&self) -> bool {
        match self {
            Self::Whole(_) => true,
            Self::Real(_) => false,
            Self::Many(items) => items.iter().all(Self::is_whole),
        }
    }

    fn into_real(self) -> Self {
        match self {
            // Coordinates and angles: far below 2^53.
            Self::Whole(number) => Self::Real(number as f64),
            Self::Real(number) => Self::Real(number),
            Self::Many(items) => Self::Many(items.into_iter().map(Self::into_real).collect()),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Whole(_) | Self::Real(_), Self::Whole(_) | Self::Real(_)) => true,
            (Self::Many(one), Self::Many(other)) => {
                let mut pairs = one.iter().zip(other);
                one.len() == other.len() && pairs.all(|(one, other)| one.is_like(other))
            }
            (Self::Whole(_) | Self::Real(_), Self::Many(_))
            | (Self::Many(_), Self::Whole(_) | Self::Real(_)) => false,
        }
    }

    /// The value `done` of `all` frames on the way to another.
    fn mix(&self, other: &Self, (done, all): (u32, u32)) -> Self {
        match (self, other) {
            (Self::Whole(a), Self::Whole(b)) => whole_between((*a, *b), (done, all)),
            (Self::Real(a), Self::Real(b)) => {
                let t = f64::from(done) / f64::from(all);
                Self::Real((1.0 - t) * a + t * b)
            }
            (Self::Many(a), Self::Many(b)) => {
                let pairs = a.iter().zip(b);
                Self::Many(pairs.map(|(a, b)| a.mix(b, (done, all))).collect())
            }
            // Of one form, and all whole or none: they were checked.
            (Self::Whole(_), Self::Real(_) | Self::Many(_))
            | (Self::Real(_), Self::Whole(_) | Self::Many(_))
            | (Self::Many(_), Self::Whole(_) | Self::Real(_)) => self.clone(),
        }
    }

    fn to_toml(&self) -> String {
        match self {
            Self::Whole(number) => number.to_string(),
            // The shortest decimals that read back exactly, with a point or an exponent.
            Self::Real(number) => format!("{number:?}"),
            Self::Many(items) => {
                let items: Vec<String> = items.iter().map(Self::to_toml).collect();
                format!("[{}]", items.join(", "))
            }
        }
    }
}

/// Between whole numbers, whole where a whole number lies there: in integers, for a sum of fractions
/// misses 2 by its last digit.
fn whole_between((a, b): (i64, i64), (done, all): (u32, u32)) -> Number {
    let way = (i128::from(b) - i128::from(a)) * i128::from(done);
    let (passed, rest) = (way / i128::from(all), way % i128::from(all));
    match i64::try_from(i128::from(a) + passed) {
        Ok(number) if rest == 0 => Number::Whole(number),
        Ok(_) | Err(_) => Number::Real(a as f64 + way as f64 / f64::from(all)),
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
