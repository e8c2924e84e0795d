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
//! `frames_per_second` is no key of a scene: how many frames are shown in a second, 24 where it is left out. Nor is
//! `shutter_deg` (see [`Shutter`]): how long the shutter is open, centred on the frame.
//!
//! Besides, `####` in the name of a file of `[drops]`, `[occluders]` or `[terrain]` is the frame, with zeros in front
//! up to the number of `#`: drops and depths that another program made for every frame.
//!
//! A frame is a scene of its own: its text is the scene's with other numbers in the same lines, so that
//! everything that can be wrong with a scene is said of a frame in the same words.

mod number;
mod shutter;
mod tracks;

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

use number::Number;
use shutter::Within;
use tracks::Setting;
use tracks::Tracks;

pub use shutter::Shutter;

/// Name of the section.
const SECTION: &str = "sequence";
/// Keys of the section that are none of the scene.
pub(crate) const RATES: (f64, f64) = (1.0, 1000.0);
const RATE: Setting = ("frames_per_second", RATES, "frames in a second");
pub(crate) const ANGLES_DEG: (f64, f64) = (0.0, 360.0);
const ANGLE: Setting = (
    "shutter_deg",
    ANGLES_DEG,
    "degrees, all of a frame being 360",
);
/// Rate of films.
pub(crate) const USUAL_RATE: f64 = 24.0;
/// Says how the scene is read, so that no frame can have another.
const VERSION: &str = "format";
/// Sections whose texts may name a file for every frame.
const SECTIONS_WITH_FILES: [&str; 3] = ["drops", "occluders", "terrain"];
/// Stands for a digit of the frame.
const DIGIT: char = '#';
/// Last frame that can be asked for.
pub const LAST_FRAME: u32 = 9_999_999;

/// A scene that changes from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Frames that are shown in a second.
    pub frames_per_second: f64,
    /// How long of each frame the shutter is open.
    pub shutter: Shutter,
    text: String,
    /// What changes and where it stands in the text, from its end to its beginning.
    changes: Vec<(Range<usize>, Change)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Change {
    /// Values at frames, in ascending order, and what they do between two frames.
    Keys(Vec<(u32, Number)>, Within),
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
        let (mut frames_per_second, mut shutter) = (USUAL_RATE, Shutter::default());
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
            if let Some(rate) = tracks.setting(&mut section, RATE)? {
                frames_per_second = rate;
            }
            if let Some(angle_deg) = tracks.setting(&mut section, ANGLE)? {
                shutter = Shutter::of_angle(angle_deg);
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
            shutter,
            text,
            changes,
        }))
    }

    /// The frames at which values are written down.
    #[must_use]
    pub fn keys(&self) -> BTreeSet<u32> {
        let frames = self.changes.iter().flat_map(|(_, change)| match change {
            Change::Keys(keys, _) => keys.iter().map(|(frame, _)| *frame).collect(),
            Change::File(_) => Vec::new(),
        });
        frames.collect()
    }

    /// The names of files with a place for the frame.
    pub fn file_names(&self) -> impl Iterator<Item = &str> {
        self.changes.iter().filter_map(|(_, change)| match change {
            Change::Keys(..) => None,
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
        self.scene_text_beside(frame, 0.0)
    }

    /// The scene so many frames after one, or before: of it is what stands still within a frame.
    #[must_use]
    pub fn scene_text_beside(&self, frame: u32, after: f64) -> String {
        let mut text = self.text.clone();
        for (place, change) in &self.changes {
            let mut written = match change {
                Change::Keys(keys, Within::Still) => at(keys, frame, 0.0).to_toml(),
                Change::Keys(keys, Within::Moves) => at(keys, frame, after).to_toml(),
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

/// The value so many frames after one, less than one either way.
fn at(keys: &[(u32, Number)], frame: u32, after: f64) -> Number {
    // In whole frames as far as it goes: they are exact.
    let is_over = |key: u32| key < frame || key == frame && after >= 0.0;
    let n_over = keys.partition_point(|(key, _)| is_over(*key));
    if n_over == 0 {
        return keys[0].1.clone();
    }
    let (before, value) = &keys[n_over - 1];
    match keys.get(n_over) {
        Some((next, next_value)) if after != 0.0 => {
            let way = f64::from(frame) - f64::from(*before) + after;
            value.mix_real(next_value, way / f64::from(next - before))
        }
        Some((next, next_value)) if frame > *before => {
            value.mix(next_value, (frame - before, next - before))
        }
        Some(_) | None => value.clone(),
    }
}

#[cfg(test)]
#[path = "sequence_tests.rs"]
mod tests;
