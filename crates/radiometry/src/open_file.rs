//! Files that end: a pipe or a device may give bytes forever, or none.

use std::fs;
use std::fs::File;
use std::io;
use std::path::Path;

/// Opens a regular file, and says how long it is.
///
/// # Errors
/// A file that is missing, or a folder, a pipe or a device.
pub fn open_file(path: &Path) -> io::Result<(File, u64)> {
    // Before it is opened: that alone would wait for the other end of a pipe.
    let metadata = fs::metadata(path)?;
    if !metadata.is_file() {
        let message = "found a folder, a pipe or a device, expected a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    Ok((File::open(path)?, metadata.len()))
}
