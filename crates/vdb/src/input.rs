//! A byte stream of known length, read in pieces that can never reach past its end.
//!
//! Two bounds hold whatever the bytes say: no piece is larger than what is left of the file, and
//! what the decoder allocates is charged against [`MEMORY_FACTOR`] times the length of the file.

use std::io::Read;

use crate::Error;

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

/// A stream with its position, its length and the memory that may still be used.
pub(crate) struct Input<R> {
    source: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    position: u64,
    length: u64,
    memory_left: u64,
}

impl<R: Read> Input<R> {
    /// A stream of `length` bytes.
    pub(crate) fn new(source: R, length: u64) -> Self {
        let buffer = Vec::new();
        let memory_left = memory_limit(length);
        Self {
            source,
            buffer,
            start: 0,
            end: 0,
            position: 0,
            length,
            memory_left,
        }
    }

    /// Number of bytes before the next one.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Account for memory that is about to be allocated.
    pub(crate) fn charge(&mut self, n_bytes: u64) -> Result<(), Error> {
        let limit = memory_limit(self.length);
        let left = self.memory_left.checked_sub(n_bytes);
        self.memory_left = left.ok_or(Error::TooLarge { limit })?;
        Ok(())
    }

    /// An error at the present position.
    pub(crate) fn damaged(&self, what: impl Into<String>) -> Error {
        Error::Damaged {
            position: self.position,
            what: what.into(),
        }
    }

    /// The next `n` bytes.
    pub(crate) fn bytes(&mut self, n: usize, what: &'static str) -> Result<&[u8], Error> {
        if self.end - self.start < n {
            self.fetch(n, what)?;
        }
        let piece = &self.buffer[self.start..self.start + n];
        self.start += n;
        self.position += n as u64;
        Ok(piece)
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
            .and_then(|at| at.checked_sub(self.position));
        let Some(mut ahead) = ahead else {
            return Err(self.damaged(format!("{what} is to be at byte {target}, before this one")));
        };
        while ahead > 0 {
            let step = ahead.min(CHUNK as u64);
            self.bytes(step as usize, what)?;
            ahead -= step;
        }
        Ok(())
    }

    /// The next `N` bytes by value.
    pub(crate) fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], Error> {
        let mut out = [0; N];
        out.copy_from_slice(self.bytes(N, what)?);
        Ok(out)
    }

    /// A number of 8 bits.
    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, Error> {
        Ok(self.array::<1>(what)?[0])
    }

    /// A number of 32 bits.
    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, Error> {
        self.array(what).map(u32::from_le_bytes)
    }

    /// A signed number of 32 bits.
    pub(crate) fn i32(&mut self, what: &'static str) -> Result<i32, Error> {
        self.array(what).map(i32::from_le_bytes)
    }

    /// A signed number of 64 bits.
    pub(crate) fn i64(&mut self, what: &'static str) -> Result<i64, Error> {
        self.array(what).map(i64::from_le_bytes)
    }

    /// `N` floating-point numbers of 64 bits.
    pub(crate) fn f64s<const N: usize>(&mut self, what: &'static str) -> Result<[f64; N], Error> {
        let mut out = [0.0; N];
        for value in &mut out {
            *value = f64::from_le_bytes(self.array(what)?);
        }
        Ok(out)
    }

    /// Three signed numbers of 32 bits.
    pub(crate) fn coordinates(&mut self, what: &'static str) -> Result<[i32; 3], Error> {
        Ok([self.i32(what)?, self.i32(what)?, self.i32(what)?])
    }

    /// A length of 32 bits and that many bytes of text. Bytes that are not UTF-8 are replaced.
    pub(crate) fn text(&mut self, what: &'static str) -> Result<String, Error> {
        let n_bytes = self.u32(what)?;
        let bytes = self.bytes(n_bytes as usize, what)?;
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// Fill the words of a bit mask.
    pub(crate) fn mask(&mut self, words: &mut [u64], what: &'static str) -> Result<(), Error> {
        let bytes = self.bytes(8 * words.len(), what)?;
        for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(8)) {
            let mut little_endian = [0; 8];
            little_endian.copy_from_slice(bytes);
            *word = u64::from_le_bytes(little_endian);
        }
        Ok(())
    }
}

fn memory_limit(length: u64) -> u64 {
    length
        .saturating_mul(MEMORY_FACTOR)
        .saturating_add(MEMORY_BASE)
}
