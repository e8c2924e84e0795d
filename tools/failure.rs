//! What can go wrong in the program, with the exit code that scripts see.
//!
//! 0 done, 1 failed, 2 usage (also an output that exists), 3 bad input, 4 physically impossible
//! request, 5 accuracy not reached (result written), 6 comparison failed, 130 interrupted.

use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;

use niji_picture::without_path;
use niji_scene::NoSuchMoment;

use crate::shell_word::quoted;
use crate::shell_word::word;

/// A failure of the program: one message, one exit code.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// Something outside the input failed: a full disk, a folder that cannot be written.
    #[error("{0}")]
    Failed(String),
    /// The command line asks for something it may not.
    #[error("{0}")]
    Usage(String),
    /// A file is missing, damaged or holds values that cannot be.
    #[error("{}: {message}", path.display())]
    BadInput {
        /// The file at fault.
        path: PathBuf,
        /// What was found, what was expected, what to do.
        message: String,
    },
    /// The request cannot be met by physics.
    #[error("{0}")]
    Impossible(String),
    /// The result was written, but it is less accurate than was asked for; or it would be, whatever was done.
    #[error("{0}")]
    AccuracyNotReached(String),
    /// A comparison or an assertion on a file did not hold.
    #[error("{0}")]
    ComparisonFailed(String),
}

impl From<NoSuchMoment> for Failure {
    fn from(error: NoSuchMoment) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<niji_picture::Error> for Failure {
    fn from(error: niji_picture::Error) -> Self {
        use niji_picture::Error;
        let text = error.to_string();
        match error {
            Error::File { path, message } => Self::BadInput { path, message },
            Error::NoDrops { ref path, .. } => {
                Self::bad_input(path, text + &how_to_make_drops(&error))
            }
            Error::Drops(_)
            | Error::Dark { .. }
            | Error::NoSun(_)
            | Error::CameraInTerrain { .. } => Self::Impossible(text),
            Error::Render(niji_render::Error::Memory { .. }) => Self::Failed(format!(
                "{text} (`niji render --tiles` or `--region`, or more `--memory`)"
            )),
            Error::Frame(number, error) => Self::from(*error).within(&format!("frame {number}")),
            Error::Photo(niji_photo::Error::Range { .. })
            | Error::Plan(_)
            | Error::NoFrameWithDrops(_)
            | Error::Scattering(_)
            | Error::Air(_)
            | Error::Scene(_)
            | Error::SceneFile(_)
            | Error::TooManyMeshes { .. }
            | Error::Render(_) => Self::Usage(text),
            Error::Stopped
            | Error::Photo(_)
            | Error::PartOfFrame
            | Error::Volume(_)
            | Error::Light(_) => Self::Failed(text),
        }
    }
}

/// The command that makes drops of what a file holds instead of some.
fn how_to_make_drops(error: &niji_picture::Error) -> String {
    let niji_picture::Error::NoDrops {
        path, densities, ..
    } = error
    else {
        return String::new();
    };
    let choice = match &densities[..] {
        [only] => only,
        _ if densities.iter().any(|name| name == "density") => "density",
        _ => "NAME",
    };
    format!(
        "; to make drops of a density grid: niji drops from-vdb {} --grid={} --density-means \
         optical-depth --scale 1 --effective-radius-um 100 -o drops.vdb",
        quoted(path),
        word(choice.as_ref())
    )
}

impl Failure {
    /// A damaged, missing or impossible input file.
    pub(crate) fn bad_input(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::BadInput {
            message: without_path(path, &error.to_string()),
            path: path.to_owned(),
        }
    }

    /// The same failure, said of a part of the work.
    pub(crate) fn within(self, part: &str) -> Self {
        let said = |message: String| format!("{part}: {message}");
        match self {
            Self::Failed(message) => Self::Failed(said(message)),
            Self::Usage(message) => Self::Usage(said(message)),
            Self::BadInput { path, message } => {
                let message = said(message);
                Self::BadInput { path, message }
            }
            Self::Impossible(message) => Self::Impossible(said(message)),
            Self::AccuracyNotReached(message) => Self::AccuracyNotReached(said(message)),
            Self::ComparisonFailed(message) => Self::ComparisonFailed(said(message)),
        }
    }

    /// The code with which the program ends.
    #[must_use]
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Failed(_) => ExitCode::from(1),
            Self::Usage(_) => ExitCode::from(2),
            Self::BadInput { .. } => ExitCode::from(3),
            Self::Impossible(_) => ExitCode::from(4),
            Self::AccuracyNotReached(_) => ExitCode::from(5),
            Self::ComparisonFailed(_) => ExitCode::from(6),
        }
    }
}
