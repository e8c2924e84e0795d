//! The scene as it is being worked on: its text, what came before, and its file.

use std::collections::BTreeSet;
use std::path::Path;
use std::path::PathBuf;

use niji_photo::Photograph;
use niji_picture::picked_sun;
use niji_picture::turned_picks;
use niji_scene::Goal;
use niji_scene::Scene;
use niji_scene::SceneError;
use serde::Deserialize;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use super::toml_values::with_values;
use crate::failure::Failure;
use crate::output;
use crate::scene_file;
use crate::text_file;

/// Most steps that can be undone.
const MOST_STEPS: usize = 1000;

/// The key of picks in a photograph.
const PICKS: &str = "photo.picks_px";

/// A bow that is dragged by picks in a photograph.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PicksDrag {
    /// Where they were.
    picks_px: Vec<[f64; 2]>,
    /// Places in parts of the frame.
    from: [f64; 2],
    to: [f64; 2],
}

/// Why a change was not made.
#[derive(Debug, PartialEq)]
pub(super) struct Refused {
    /// The key at fault, where one is.
    pub(super) key: Option<String>,
    pub(super) message: String,
}

impl Refused {
    pub(super) fn because(message: impl Into<String>) -> Self {
        Self {
            key: None,
            message: message.into(),
        }
    }
}

impl From<Failure> for Refused {
    fn from(failure: Failure) -> Self {
        Self::because(failure.to_string())
    }
}

impl From<SceneError> for Refused {
    fn from(error: SceneError) -> Self {
        let message = error.to_string();
        let key = match error {
            SceneError::UnknownName { key, .. }
            | SceneError::WrongType { key, .. }
            | SceneError::OutOfRange { key, .. }
            | SceneError::Refused { key, .. } => Some(key),
            SceneError::MissingKey { section, key, .. }
            | SceneError::UnknownKey { section, key, .. } => {
                let section = section
                    .strip_prefix('[')
                    .and_then(|it| it.strip_suffix(']'));
                Some(section.map_or(key.clone(), |section| format!("{section}.{key}")))
            }
            SceneError::Drops { .. } => Some("drops".to_owned()),
            SceneError::Syntax { .. } | SceneError::Json { .. } => None,
        };
        Self { key, message }
    }
}

/// A scene that is being worked on.
pub(super) struct Document {
    path: PathBuf,
    goal: Goal,
    /// What the file held when it was last read or written.
    on_disk: String,
    /// The text, plain.
    text: String,
    scene: Scene,
    before: Vec<String>,
    after: Vec<String>,
    /// The movement of a hand that the last step belongs to.
    gesture: Option<String>,
    /// Files that the scene named when it was opened: it may name no others.
    files: BTreeSet<String>,
}

impl Document {
    /// Opens a scene for a goal.
    ///
    /// # Errors
    /// A scene that is missing or wrong, or of a kind that is not shown.
    pub(super) fn open(path: &Path, goal: Goal) -> Result<Self, Failure> {
        let text = text_file::read(path)?;
        let wrong = |refused: Refused| Failure::bad_input(path, refused.message);
        let scene = read(&plain(&text), (path, None)).map_err(wrong)?;
        Ok(Self {
            path: path.to_owned(),
            goal,
            text: plain(&text),
            on_disk: text,
            files: scene.files().into_iter().map(str::to_owned).collect(),
            scene,
            before: Vec::new(),
            after: Vec::new(),
            gesture: None,
        })
    }

    /// Its text.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Its file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The scene, with what is asked of its picture.
    pub(super) fn scene(&self) -> Scene {
        self.goal.of(self.scene.clone())
    }

    /// Width and height of its photograph, whose pixels its picks are in; none without picks, or of one that cannot be
    /// read.
    pub(super) fn photograph_size(&self) -> Option<[usize; 2]> {
        let photo = (self.scene.photo.as_ref()).filter(|it| !it.picks_px.is_empty())?;
        Photograph::size_in(&scene_file::beside(&self.path).folder.join(&photo.picture)).ok()
    }

    /// Whether a step can be taken back, whether one can be made again, whether the file holds something else.
    pub(super) fn steps(&self) -> [bool; 3] {
        let is_edited = self.text != plain(&self.on_disk);
        [!self.before.is_empty(), !self.after.is_empty(), is_edited]
    }

    /// Sets values by their keys; changes of one gesture are one step.
    ///
    /// # Errors
    /// What is wrong with the scene that this would be.
    pub(super) fn set(
        &mut self,
        values: &Map<String, Value>,
        gesture: Option<&str>,
    ) -> Result<(), Refused> {
        let text = with_values(&self.text, values).map_err(|message| Refused {
            key: values.keys().next().cloned(),
            message,
        })?;
        self.replace(text, gesture)
    }

    /// Drags the bow through the picks in its photograph from one place of the frame to another, in parts of it.
    ///
    /// # Errors
    /// What is wrong with the scene that this would be.
    pub(super) fn drag_picks(
        &mut self,
        drag: &PicksDrag,
        gesture: Option<&str>,
    ) -> Result<(), Refused> {
        let folder = scene_file::beside(&self.path).folder;
        let ends = [drag.from, drag.to];
        let turned = turned_picks((&self.scene, folder), &drag.picks_px, ends)
            .map_err(|error| Refused::because(error.to_string()))?;
        let in_tenths = turned
            .into_iter()
            .map(|it| it.map(|px| (10.0 * px).round() / 10.0));
        let values = [(PICKS.to_owned(), json!(in_tenths.collect::<Vec<_>>()))];
        self.set(&values.into_iter().collect(), gesture)
    }

    /// Takes another text.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn replace(&mut self, text: String, gesture: Option<&str>) -> Result<(), Refused> {
        let scene = self.read(&text)?;
        if text == self.text {
            return Ok(());
        }
        let goes_on = gesture.is_some() && self.gesture.as_deref() == gesture;
        let old = std::mem::replace(&mut self.text, text);
        if !goes_on {
            self.before.push(old);
            let n_over = self.before.len().saturating_sub(MOST_STEPS);
            self.before.drain(..n_over);
        }
        self.after.clear();
        self.scene = scene;
        self.gesture = gesture.map(str::to_owned);
        Ok(())
    }

    /// Reads another text of it.
    fn read(&self, text: &str) -> Result<Scene, Refused> {
        read(text, (&self.path, Some(&self.files)))
    }

    /// Takes the last step back, or makes the last one that was taken back again.
    ///
    /// # Errors
    /// Where there is none.
    pub(super) fn step(&mut self, is_back: bool) -> Result<(), Refused> {
        let steps = if is_back { &self.before } else { &self.after };
        let none = || Refused::because("there is no such step");
        let text = steps.last().cloned().ok_or_else(none)?;
        // A step that cannot be made, as the photograph is gone, stays.
        self.scene = self.read(&text)?;
        let (from, to) = if is_back {
            (&mut self.before, &mut self.after)
        } else {
            (&mut self.after, &mut self.before)
        };
        from.pop();
        to.push(std::mem::replace(&mut self.text, text));
        self.gesture = None;
        Ok(())
    }

    /// Writes the text to its file, unless somebody else wrote there.
    ///
    /// # Errors
    /// A file that is another than it was, or cannot be written.
    pub(super) fn save(&mut self) -> Result<(), Refused> {
        let found = text_file::read(&self.path)?;
        if found != self.on_disk {
            return Err(Refused::because(format!(
                "{} was changed by somebody else: nothing was written; read it again to see that, or copy the text \
                 from here first",
                self.path.display()
            )));
        }
        let spelled = spelled_as(&self.on_disk, &self.text);
        output::write_text(&self.path, &spelled)?;
        self.on_disk = spelled;
        Ok(())
    }

    /// Takes what the file holds now, as a step.
    ///
    /// # Errors
    /// A file that is missing or wrong.
    pub(super) fn read_again(&mut self) -> Result<(), Refused> {
        let text = text_file::read(&self.path)?;
        self.replace(plain(&text), None)?;
        self.on_disk = text;
        Ok(())
    }
}

/// What editors on Windows write before a text, and at the end of a line.
const BYTE_ORDER_MARK: char = '\u{feff}';
const LINE_END: &str = "\r\n";

/// A text without what only editors see.
fn plain(text: &str) -> String {
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    text.replace(LINE_END, "\n")
}

/// A plain text with the mark and the line ends of another one.
fn spelled_as(other: &str, text: &str) -> String {
    let mark = other
        .starts_with(BYTE_ORDER_MARK)
        .then_some(BYTE_ORDER_MARK);
    let is_windows =
        (other.lines().next()).is_some_and(|it| other[it.len()..].starts_with(LINE_END));
    let text = if is_windows {
        text.replace('\n', LINE_END)
    } else {
        text.to_owned()
    };
    mark.into_iter().chain(text.chars()).collect()
}

/// Reads a scene of a kind that is shown, which lies at `path` and names no other files than the `known` ones; opens
/// none of them but a photograph with picks in it, for its size.
fn read(text: &str, (path, known): (&Path, Option<&BTreeSet<String>>)) -> Result<Scene, Refused> {
    // What is wrong with a text that is no TOML is told below.
    let sections: toml::Table = text.parse().unwrap_or_default();
    for (section, command) in [
        ("ice", "`niji ice` makes its picture"),
        ("sequence", "`niji run --frames` makes its pictures"),
    ] {
        if sections.contains_key(section) {
            let message =
                format!("found the section [{section}], which is not shown here: {command}");
            return Err(Refused::because(message));
        }
    }
    let check = |scene: &Scene| {
        let is_stranger = |it: &&str| known.is_some_and(|known| !known.contains(*it));
        let Some(file) = scene.files().into_iter().find(is_stranger) else {
            return Ok(());
        };
        Err(Refused::because(format!(
            "found the file {file:?}, expected one that the scene named when it was opened: write it into {} and \
             open that anew",
            path.display()
        )))
    };
    let scene = Scene::from_toml_with_picks(text, |scene| {
        check(scene)?;
        let key = Some(PICKS.to_owned());
        picked_sun(scene, scene_file::beside(path).folder).map_err(|error| Refused {
            key,
            message: error.to_string(),
        })
    })?;
    check(&scene)?;
    Ok(scene)
}
