//! The file of what a plan decided.

use std::fs;
use std::path::Path;

use niji_exchange::text_hash;
use niji_picture::Choice;
use niji_picture::SequenceChoice;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::text_file;

/// Its name in the folder of a run.
pub(crate) const FILE: &str = "choice.toml";

/// Said to whoever opens it.
const HEAD: &str = "# What niji decided for a picture or a sequence, and what it measured for that. With `--choice` a run and every \
                    stage decides the same\n# without measuring again; `niji plan SCENE -o FILE` makes it anew.\n";

/// Before the hash of what follows: what a hand or a disk changed is not what was decided.
const HASH: &str = "# SHA-256 of what follows: ";

/// Reads a choice, of a picture or of a sequence.
///
/// # Errors
/// A file that is missing or none of ours.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let text = text_file::read(path)?;
    let choice = toml::from_str(&text).map_err(|error| {
        let cause = error.message();
        let text = if toml::from_str::<SequenceChoice>(&text).is_ok() {
            "found what was decided for a sequence, expected it for one picture: `niji run SCENE --frames LIST \
             --choice FILE` makes frames by it"
                .to_owned()
        } else if toml::from_str::<Choice>(&text).is_ok() {
            "found what was decided for one picture, expected it for a sequence: `niji plan SCENE --frames LIST -o \
             FILE` writes that"
                .to_owned()
        } else {
            format!("{cause}; expected a choice, as `niji plan SCENE -o FILE` writes it")
        };
        Failure::bad_input(path, text)
    })?;
    if is_as_written(&text) {
        return Ok(choice);
    }
    let message = "found a choice that was changed after niji wrote it, expected it untouched: change the scene, and \
                   make it anew with `niji plan SCENE -o FILE --force`";
    Err(Failure::bad_input(path, message))
}

/// Is the text of a choice what its hash was made from?
fn is_as_written(text: &str) -> bool {
    let sealed = text
        .split_once(HASH)
        .and_then(|(_, sealed)| sealed.split_once("\n\n"));
    sealed.is_some_and(|(hash, body)| hash == text_hash(body))
}

/// The choice of a run before, where it is of the kind that is asked for.
///
/// # Errors
/// A file of that name that is no choice and may not be replaced.
pub(crate) fn kept<T: DeserializeOwned>(
    path: &Path,
    existing: Existing,
) -> Result<Option<T>, Failure> {
    output::check_regular(path)?;
    let kept = read(path).ok();
    let is_other = || fs::read_to_string(path).is_ok_and(|text| text.starts_with(HEAD));
    if kept.is_none() && !is_other() {
        // Of another request it is out of date, like a file of a stage that is made anew; this is none.
        output::check_free(path, existing)?;
    }
    Ok(kept)
}

/// Writes a choice.
///
/// # Errors
/// A file that exists and may not be replaced, unless it is the same; one that cannot be written.
pub(crate) fn write(
    choice: &impl Serialize,
    path: &Path,
    existing: Existing,
) -> Result<(), Failure> {
    let text = toml::to_string(choice).map_err(|error| Failure::Failed(error.to_string()))?;
    let text = format!("{HEAD}{HASH}{}\n\n{text}", text_hash(&text));
    output::check_regular(path)?;
    if fs::read_to_string(path).is_ok_and(|found| found == text) {
        return Ok(());
    }
    output::check_free(path, existing)?;
    output::write_text(path, &text)
}
