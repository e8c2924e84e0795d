//! The file of what a plan decided.

use std::fs;
use std::path::Path;

use niji_picture::Choice;

use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::text_file;

/// Its name in the folder of a run.
pub(crate) const FILE: &str = "choice.toml";

/// Said to whoever opens it.
const HEAD: &str = "# What niji decided for a picture, and what it measured for that. With `--choice` a run and every \
                    stage decides the same\n# without measuring again; `niji plan SCENE -o FILE` makes it anew.\n\n";

/// Reads a choice.
///
/// # Errors
/// A file that is missing or none of ours.
pub(crate) fn read(path: &Path) -> Result<Choice, Failure> {
    let text = text_file::read(path)?;
    toml::from_str(&text).map_err(|error| {
        let cause = error.message();
        let text = format!("{cause}; expected a choice, as `niji plan SCENE -o FILE` writes it");
        Failure::bad_input(path, text)
    })
}

/// Writes a choice.
///
/// # Errors
/// A file that exists and may not be replaced, unless it is the same; one that cannot be written.
pub(crate) fn write(choice: &Choice, path: &Path, existing: Existing) -> Result<(), Failure> {
    let text = toml::to_string(choice).map_err(|error| Failure::Failed(error.to_string()))?;
    let text = HEAD.to_owned() + &text;
    output::check_regular(path)?;
    if fs::read_to_string(path).is_ok_and(|found| found == text) {
        return Ok(());
    }
    output::check_free(path, existing)?;
    output::write_text(path, &text)
}
