//! Scenes of strangers: what they name is read in some folders only.

use std::path::Path;
use std::path::PathBuf;

use niji_scene::Scene;

use crate::error::Error;
use crate::picked_sun::picked_sun;

/// The folders in which files may lie that a scene names. Without any it may name every file.
#[derive(Clone, Debug, Default)]
pub struct Sandbox {
    /// Without links and `..`.
    folders: Vec<PathBuf>,
}

impl Sandbox {
    /// Some folders, with all that is in them.
    ///
    /// # Errors
    /// A folder that is missing.
    pub fn new(folders: &[PathBuf]) -> Result<Self, Error> {
        let folders = folders.iter().map(|folder| canonical(folder));
        Ok(Self {
            folders: folders.collect::<Result<_, Error>>()?,
        })
    }

    /// Reads a scene from TOML as [`scene_from_toml`](crate::scene_from_toml), whose files lie in these folders.
    ///
    /// # Errors
    /// As there, and as [`Self::check`], before any of its files is opened.
    pub fn scene_from_toml(&self, text: &str, folder: &Path) -> Result<Scene, Error> {
        let scene = Scene::from_toml_with_picks(text, |scene| {
            self.check(&scene.files(), folder)?;
            picked_sun(scene, folder)
        })?;
        self.check(&scene.files(), folder)?;
        Ok(scene)
    }

    /// Refuses files elsewhere, whatever links and `..` in their names say; names are relative to `folder`.
    ///
    /// # Errors
    /// The first file that is missing, or lies in none of these folders.
    pub fn check(&self, names: &[&str], folder: &Path) -> Result<(), Error> {
        if self.folders.is_empty() {
            return Ok(());
        }
        for name in names {
            let path = folder.join(name);
            // Buffers of a mesh lie in the folder by which it is named, which may be that of a link to it.
            let beside = path.parent().filter(|it| *it != Path::new(""));
            for place in [&path, beside.unwrap_or(Path::new("."))] {
                let place = canonical(place)?;
                if !self.folders.iter().any(|folder| place.starts_with(folder)) {
                    return Err(self.refusal(&path));
                }
            }
        }
        Ok(())
    }

    fn refusal(&self, path: &Path) -> Error {
        let folders = self.folders.iter().map(|it| it.display().to_string());
        let folders = folders.collect::<Vec<_>>().join(" or ");
        let message = format!("found a file outside of the sandbox, expected one in {folders}");
        Error::file(path, message)
    }
}

fn canonical(path: &Path) -> Result<PathBuf, Error> {
    path.canonicalize()
        .map_err(|error| Error::file(path, error))
}
