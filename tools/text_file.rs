//! Texts that people write: scenes, choices, lists of values.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use niji_radiometry::Bytes;

use crate::failure::Failure;

/// Most bytes of a text: a scene of a thousand frames has a hundredth of it.
const MOST_BYTES: u64 = 16 << 20;

/// Reads a text.
///
/// # Errors
/// [`Failure::BadInput`] if it is missing, no UTF-8, or longer than any that somebody writes.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    let failed = |error: std::io::Error| Failure::bad_input(path, error);
    let mut text = String::new();
    // One more than may be: a device gives bytes forever.
    let mut file = File::open(path).map_err(failed)?.take(MOST_BYTES + 1);
    file.read_to_string(&mut text).map_err(|error| {
        if file.limit() == 0 {
            too_long(path)
        } else {
            failed(error)
        }
    })?;
    if text.len() as u64 > MOST_BYTES {
        return Err(too_long(path));
    }
    Ok(text)
}

fn too_long(path: &Path) -> Failure {
    let most = Bytes(MOST_BYTES.into());
    let message = format!("found more than {most}, expected a text of at most that");
    Failure::bad_input(path, message)
}
