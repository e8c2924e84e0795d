//! The scene as it is being worked on: its text, what came before, and its file.

use std::collections::BTreeSet;
use std::path::Path;
use std::path::PathBuf;

use niji_scene::Goal;
use niji_scene::Scene;
use niji_scene::SceneError;
use serde_json::Map;
use serde_json::Value;

use super::toml_values::with_values;
use crate::failure::Failure;
use crate::output;
use crate::text_file;

/// Most steps that can be undone.
const MOST_STEPS: usize = 1000;

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
        let scene = read(&plain(&text)).map_err(wrong)?;
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

    /// Takes another text.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn replace(&mut self, text: String, gesture: Option<&str>) -> Result<(), Refused> {
        let scene = read(&text)?;
        let stranger = scene
            .files()
            .into_iter()
            .find(|it| !self.files.contains(*it));
        if let Some(file) = stranger {
            let message = format!(
                "found the file {file:?}, expected one that the scene named when it was opened: write it into {} and \
                 open that anew",
                self.path.display()
            );
            return Err(Refused::because(message));
        }
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

    /// Takes the last step back, or makes the last one that was taken back again.
    ///
    /// # Errors
    /// Where there is none.
    pub(super) fn step(&mut self, is_back: bool) -> Result<(), Refused> {
        let (from, to) = if is_back {
            (&mut self.before, &mut self.after)
        } else {
            (&mut self.after, &mut self.before)
        };
        let text = from
            .pop()
            .ok_or_else(|| Refused::because("there is no such step"))?;
        self.scene = read(&text)?;
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

/// Reads a scene of a kind that is shown; opens none of its files.
fn read(text: &str) -> Result<Scene, Refused> {
    // What is wrong with a text that is no TOML is told below.
    let sections: toml::Table = text.parse().unwrap_or_default();
    for (section, command) in [
        ("ice", "`niji ice` makes its picture"),
        ("photo", "`niji run` makes its picture"),
        ("sequence", "`niji run --frames` makes its pictures"),
    ] {
        if sections.contains_key(section) {
            let message =
                format!("found the section [{section}], which is not shown here: {command}");
            return Err(Refused::because(message));
        }
    }
    Ok(Scene::from_toml(text)?)
}
