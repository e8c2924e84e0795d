//! A byte stream of known length, read in pieces that can never reach past its end.
//!
//! Two bounds hold whatever the bytes say: no piece is larger than what is left of the file, and
//! what the decoder allocates is charged against [`MEMORY_FACTOR`] times the length of the file.

use std::fs;
use std::fs::File;
use std::io;
use std::io::Read;
use std::io::Seek;
use std::io::SeekFrom;
use std::path::Path;

use crate::Error;
use crate::source::Source;

/// Decoded bytes for each byte of a file, at most.
///
/// The largest ratio that a sound file reaches is 2 x 112: an internal node of a vec3s grid whose
/// 32³ slots are inactive tiles of minus the background takes 8193 bytes, and 28 bytes a tile in
/// memory, doubled because vectors grow by doubling. A leaf without active voxels takes 129 bytes
/// and becomes 2.2 kB (float) to 6.3 kB (vec3s), a ratio of 17 to 49.
const MEMORY_FACTOR: u64 = 256;

/// Room for the fixed buffers of the decoder, in bytes.
const MEMORY_BASE: u64 = 1 << 20;

/// Bytes that are fetched at a time.
const CHUNK: usize = 1 << 18;

/// Open a file; gives its length too.
pub(crate) fn open(path: &Path) -> Result<(File, u64), Error> {
    let open = || {
        // Before it is opened: that alone would wait for the other end of a pipe.
        let metadata = fs::metadata(path)?;
        if !metadata.is_file() {
            let message = "found a folder, a pipe or a device, expected a file";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        Ok((File::open(path)?, metadata.len()))
    };
    open().map_err(|reason| Error::Open {
        path: path.to_owned(),
        reason,
    })
}

/// A stream with its position, its length and the memory that may still be used.
pub(crate) struct Input<R> {
    source: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    position: u64,
    length: u64,
    memory_limit: u64,
    memory_left: u64,
}

impl<R: Read + Seek> Input<R> {
    /// A stream of `length` bytes.
    pub(crate) fn new(source: R, length: u64) -> Self {
        let buffer = Vec::new();
        let memory_limit = memory_limit(length);
        Self {
            source,
            buffer,
            start: 0,
            end: 0,
            position: 0,
            length,
            memory_limit,
            memory_left: memory_limit,
        }
    }

    /// Use no more memory than this.
    pub(crate) fn limit_memory(&mut self, most_bytes: u64) {
        self.memory_limit = self.memory_limit.min(most_bytes);
        self.memory_left = self.memory_left.min(most_bytes);
    }

    /// Account for memory that is about to be allocated.
    pub(crate) fn charge(&mut self, n_bytes: u64) -> Result<(), Error> {
        let limit = self.memory_limit;
        let left = self.memory_left.checked_sub(n_bytes);
        self.memory_left = left.ok_or(Error::TooLarge { limit })?;
        Ok(())
    }

    /// The next bytes, at least `n` of them or all that are left; they are not yet consumed.
    pub(crate) fn window(&mut self, n: usize) -> Result<&[u8], Error> {
        let left = self.length - self.position;
        let n = n.min(usize::try_from(left).unwrap_or(usize::MAX));
        if self.end - self.start < n {
            self.fetch(n, "the file")?;
        }
        Ok(&self.buffer[self.start..self.end])
    }

    /// Go on by bytes that [`Input::window`] has shown.
    pub(crate) fn consume(&mut self, n: usize) {
        assert!(
            n <= self.end - self.start,
            "only bytes that were shown are consumed"
        );
        self.start += n;
        self.position += n as u64;
    }

    /// Fill the buffer until it holds `n` unread bytes.
    fn fetch(&mut self, n: usize, what: &'static str) -> Result<(), Error> {
        let left = self.length - self.position;
        if n as u64 > left {
            return Err(self.truncated(n as u64 - left, what));
        }
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        let room = n.max(CHUNK).min(left as usize);
        if self.buffer.len() < room {
            self.buffer.resize(room, 0);
        }
        while self.end < n {
            match self.source.read(&mut self.buffer[self.end..]) {
                Ok(0) => return Err(self.truncated((n - self.end) as u64, what)),
                Ok(n_read) => self.end += n_read,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    fn truncated(&self, needed: u64, what: &'static str) -> Error {
        Error::Truncated {
            what,
            length: self.length,
            needed,
        }
    }

    /// Go forward to a position that the file names.
    pub(crate) fn skip_to(&mut self, target: i64, what: &'static str) -> Result<(), Error> {
        let ahead = u64::try_from(target)
            .ok()
            .filter(|&target| target >= self.position);
        let Some(target) = ahead else {
            return Err(self.damaged(format!("{what} is to be at byte {target}, before this one")));
        };
        if target > self.length {
            return Err(self.truncated(target - self.length, what));
        }
        self.seek(target)
    }

    /// Go to a position inside the file where reading has stood before.
    pub(crate) fn seek(&mut self, target: u64) -> Result<(), Error> {
        let buffered = target
            .checked_sub(self.position)
            .filter(|&ahead| ahead <= (self.end - self.start) as u64);
        if let Some(ahead) = buffered {
            self.start += ahead as usize;
        } else {
            self.source.seek(SeekFrom::Start(target))?;
            (self.start, self.end) = (0, 0);
        }
        self.position = target;
        Ok(())
    }
}

impl<R: Read + Seek> Source for Input<R> {
    fn position(&self) -> u64 {
        self.position
    }

    fn bytes(&mut self, n: usize, what: &'static str) -> Result<&[u8], Error> {
        if self.end - self.start < n {
            self.fetch(n, what)?;
        }
        let piece = &self.buffer[self.start..self.start + n];
        self.start += n;
        self.position += n as u64;
        Ok(piece)
    }
}

fn memory_limit(length: u64) -> u64 {
    length
        .saturating_mul(MEMORY_FACTOR)
        .saturating_add(MEMORY_BASE)
}
