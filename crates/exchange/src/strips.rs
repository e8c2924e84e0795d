//! Rows of a picture that are in memory at a time: strips, from the top.

use std::ops::Range;
use std::path::Path;
use std::path::PathBuf;

use crate::error::Error;
use crate::exr_read;
use crate::image_windows::ImageWindows;
use crate::part::Part;

/// Memory of the rows of a picture that are made, written or read at a time, unless they are no more than a few.
pub const STRIP_BYTES: usize = 64 << 20;

/// Rows of a strip are a multiple of this: of a chunk of the codec of pictures.
const CHUNK_ROWS: usize = 32;

/// Rows of so many bytes that are in memory at a time.
pub(crate) fn rows_of_strip(row_bytes: usize) -> usize {
    let n_rows = STRIP_BYTES / row_bytes.max(1);
    n_rows.next_multiple_of(CHUNK_ROWS).max(CHUNK_ROWS)
}

/// The first parts of a file whose rows are read some at a time: they are not compared with its checksums, which are of
/// all rows.
#[derive(Clone, Debug)]
pub(crate) struct PartsReader {
    path: PathBuf,
    n_parts: usize,
    windows: ImageWindows,
    rows: Range<usize>,
    n_at_a_time: usize,
}

impl PartsReader {
    /// Before the first row.
    ///
    /// # Errors
    /// As [`exr_read::read_layout`].
    pub(crate) fn open(path: &Path, n_parts: usize) -> Result<Self, Error> {
        let (windows, row_bytes) = exr_read::read_layout(path, n_parts)?;
        Ok(Self {
            path: path.to_owned(),
            n_parts,
            windows,
            rows: 0..windows.data.height_px as usize,
            n_at_a_time: rows_of_strip(row_bytes),
        })
    }

    /// The pixels that the file holds, and which of them are shown.
    pub(crate) fn windows(&self) -> ImageWindows {
        self.windows
    }

    /// The parts without rows.
    ///
    /// # Errors
    /// As [`exr_read::read_rows`].
    pub(crate) fn no_rows(&self) -> Result<Vec<Part<'static>>, Error> {
        exr_read::read_rows(&self.path, (self.n_parts, 0..0))
    }

    /// The next rows; after an error there are no more.
    ///
    /// # Errors
    /// As [`exr_read::read_rows`]; what `make` of them says.
    pub(crate) fn next<T>(
        &mut self,
        make: impl FnOnce(Vec<Part<'static>>) -> Result<T, Error>,
    ) -> Option<Result<T, Error>> {
        if self.rows.is_empty() {
            return None;
        }
        let top = self.rows.start;
        let bottom = self.rows.end.min(top.saturating_add(self.n_at_a_time));
        let made = exr_read::read_rows(&self.path, (self.n_parts, top..bottom)).and_then(make);
        self.rows.start = if made.is_ok() { bottom } else { self.rows.end };
        Some(made)
    }
}
