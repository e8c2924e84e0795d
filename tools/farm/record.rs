//! `DIR/farm/job.json`: which pictures were asked for in a folder, for whoever counts them.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use serde::Deserialize;
use serde::Serialize;

use super::bundle::Places;
use super::job::Request;
use crate::failure::Failure;
use crate::frame_list::FrameList;
use crate::output;
use crate::output::Existing;
use crate::text_file;

/// The folder of job files within that of the pictures.
pub(super) fn folder(out: &Path) -> PathBuf {
    out.join("farm")
}

fn file(out: &Path) -> PathBuf {
    folder(out).join("job.json")
}

/// Was a job written for a folder?
pub(super) fn is_there(out: &Path) -> bool {
    file(out).exists()
}

/// The pictures of a folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Record {
    /// The scene file.
    pub(super) scene: PathBuf,
    /// Frames of every job that was written for the folder; of a single picture `None`.
    pub(super) frames: Option<FrameList>,
    /// Tiles of each picture.
    pub(super) n_tiles: Option<u32>,
}

impl Record {
    /// What a job asks for.
    pub(super) fn of(places: &Places, request: &Request) -> Self {
        Self {
            scene: places.scene.clone(),
            frames: request.frames.cloned(),
            n_tiles: request.n_tiles,
        }
    }

    /// With the frames that were asked for before, of the same scene in as many tiles.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a folder of another job, unless that may be replaced.
    pub(super) fn joined(self, out: &Path, existing: Existing) -> Result<Self, Failure> {
        let path = file(out);
        output::check_regular(&path)?;
        if !is_there(out) {
            return Ok(self);
        }
        let kind = |it: &Self| (it.scene.clone(), it.n_tiles, it.frames.is_some());
        let before = match Self::read(out) {
            Ok(before) if kind(&before) == kind(&self) => before,
            _ if existing == Existing::Replace => return Ok(self),
            Err(unreadable) => return Err(unreadable),
            Ok(_) => {
                return Err(Failure::Usage(format!(
                    "{} is of another job, expected one of {} in as many tiles: choose another folder with -o, or \
                     begin anew with --force",
                    path.display(),
                    self.scene.display()
                )));
            }
        };
        let frames = self.frames.as_ref().zip(before.frames);
        let frames = frames.map(|(now, before)| FrameList::of(now.iter().chain(before.iter())));
        Ok(Self { frames, ..self })
    }

    /// Reads that of a folder.
    ///
    /// # Errors
    /// A file that is missing or none of ours.
    pub(super) fn read(out: &Path) -> Result<Self, Failure> {
        let path = file(out);
        let text = text_file::read(&path)?;
        serde_json::from_str(&text).map_err(|error| {
            let text = format!("{error}; expected a job, as `niji farm SCENE -o DIR` writes it");
            Failure::bad_input(&path, text)
        })
    }

    /// Writes it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(&self, out: &Path) -> Result<(), Failure> {
        let path = file(out);
        fs::create_dir_all(folder(out))
            .map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))?;
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(|error| Failure::Failed(error.to_string()))?;
        output::write_text(&path, &(text + "\n"))
    }
}
