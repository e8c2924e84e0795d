//! What an engine's writer is given besides the steps, and what it gives.

use std::ffi::OsStr;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

use crate::failure::Failure;
use crate::output;
use crate::output::Existing;

/// Where scene and pictures lie, for every machine alike: absolute, so that no task depends on where it starts.
#[derive(Clone, Debug)]
pub(super) struct Places {
    /// The scene file.
    pub(super) scene: PathBuf,
    /// The folder of the pictures.
    pub(super) out: PathBuf,
}

/// A file for an engine.
#[derive(Clone, Debug)]
pub(super) struct BundleFile {
    /// Its name in the folder of the bundle.
    pub(super) name: String,
    /// What it holds.
    pub(super) text: String,
}

/// A job as an engine reads it.
#[derive(Clone, Debug)]
pub(super) struct Bundle {
    /// Its files.
    pub(super) files: Vec<BundleFile>,
    /// The command that hands it to the engine, in the folder of the bundle.
    pub(super) submitted_by: &'static [&'static str],
}

/// An absolute path as text. Links stay as they are: other machines may have them too.
///
/// # Errors
/// A path that is no text, which not every engine can say.
pub(super) fn absolute(path: &Path) -> Result<String, Failure> {
    let refused = |what: &str| Failure::Usage(format!("{}: {what}", path.display()));
    let full = std::path::absolute(path).map_err(|error| refused(&error.to_string()))?;
    let text = full.to_str().filter(|it| !it.contains(char::is_control));
    let text = text.map(str::to_owned);
    text.ok_or_else(|| refused("expected a path of letters alone, which job files can hold"))
}

impl Places {
    /// Absolute paths of a scene and a folder.
    ///
    /// # Errors
    /// As [`absolute`].
    pub(super) fn new(scene: &Path, out: &Path) -> Result<Self, Failure> {
        Ok(Self {
            scene: absolute(scene)?.into(),
            out: absolute(out)?.into(),
        })
    }
}

impl Bundle {
    /// Writes the files to a folder.
    ///
    /// # Errors
    /// As [`output::write_text`]; a file that exists and may not be replaced.
    pub(super) fn write(&self, folder: &Path, existing: Existing) -> Result<(), Failure> {
        let paths = self
            .files
            .iter()
            .map(|file| (folder.join(&file.name), &file.text));
        let paths: Vec<_> = paths.collect();
        for (path, _) in &paths {
            output::check_free(path, existing)?;
        }
        paths
            .iter()
            .try_for_each(|(path, text)| output::write_text(path, text))
    }

    /// Hands the job to its engine, whose program speaks for itself.
    ///
    /// # Errors
    /// A program that is not there or fails.
    pub(super) fn submit(&self, folder: &Path) -> Result<(), Failure> {
        let [program, arguments @ ..] = self.submitted_by else {
            return Ok(());
        };
        let outcome = Command::new(program)
            .args(arguments.iter().map(OsStr::new))
            .current_dir(folder)
            .status();
        let failed = |what: String| {
            let command = self.submitted_by.join(" ");
            Err(Failure::Failed(format!(
                "`{command}` in {}: {what}",
                folder.display()
            )))
        };
        match outcome {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => failed(format!("ended with {status}")),
            Err(error) => failed(error.to_string()),
        }
    }
}
