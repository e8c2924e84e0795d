//! What can go wrong in the program, with the exit code that scripts see.
//!
//! 0 done, 1 failed, 2 usage (also an output that exists), 3 bad input, 4 physically impossible
//! request, 5 accuracy not reached (result written), 6 comparison failed, 130 interrupted.

use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;

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
    /// The result was written, but it is less accurate than was asked for.
    #[error("{0}")]
    AccuracyNotReached(String),
    /// A comparison or an assertion on a file did not hold.
    #[error("{0}")]
    ComparisonFailed(String),
}

impl Failure {
    /// A damaged, missing or impossible input file.
    pub(crate) fn bad_input(path: &Path, error: impl std::fmt::Display) -> Self {
        let message = error.to_string();
        // Libraries name the path themselves where they open the file: say it once.
        let prefix = format!("{}: ", path.display());
        let message = message.strip_prefix(&prefix).unwrap_or(&message).to_owned();
        Self::BadInput {
            path: path.to_owned(),
            message,
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
