//! The byte stream of a file that is being written, with a hash of its content.

use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;

use sha2::Digest;
use sha2::Sha256;

use crate::Error;

/// Bytes that are handed on at a time.
const CHUNK: usize = 1 << 18;

/// A stream that counts and hashes; places that are known only later are patched at the end.
pub(crate) struct Output<W> {
    sink: W,
    start: u64,
    n_written: u64,
    waiting: Vec<u8>,
    hash: Sha256,
    patches: Vec<(u64, Vec<u8>)>,
}

impl<W: Write + Seek> Output<W> {
    /// A file that begins where the sink stands.
    pub(crate) fn new(mut sink: W) -> Result<Self, Error> {
        let start = sink.stream_position()?;
        let (waiting, patches) = (Vec::new(), Vec::new());
        Ok(Self {
            sink,
            start,
            n_written: 0,
            waiting,
            hash: Sha256::new(),
            patches,
        })
    }

    /// Bytes written so far.
    pub(crate) fn position(&self) -> u64 {
        self.n_written + self.waiting.len() as u64
    }

    /// Write what `fill` appends.
    pub(crate) fn append(&mut self, fill: impl FnOnce(&mut Vec<u8>)) -> Result<(), Error> {
        fill(&mut self.waiting);
        if self.waiting.len() >= CHUNK {
            self.hand_on()?;
        }
        Ok(())
    }

    /// Write these parts, one behind the other, and hash them; do something else meanwhile.
    pub(crate) fn append_all(
        &mut self,
        parts: &[Vec<u8>],
        meanwhile: impl FnOnce() + Send,
    ) -> Result<(), Error> {
        self.hand_on()?;
        let Self { sink, hash, .. } = self;
        rayon::in_place_scope(|scope| {
            scope.spawn(|_| meanwhile());
            scope.spawn(|_| parts.iter().for_each(|part| hash.update(part)));
            parts.iter().try_for_each(|part| sink.write_all(part))
        })?;
        self.n_written += parts.iter().map(|part| part.len() as u64).sum::<u64>();
        Ok(())
    }

    fn hand_on(&mut self) -> Result<(), Error> {
        self.hash.update(&self.waiting);
        self.sink.write_all(&self.waiting)?;
        self.n_written += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }

    /// Replace bytes at a position once all is written.
    pub(crate) fn patch(&mut self, position: u64, bytes: Vec<u8>) {
        self.patches.push((position, bytes));
    }

    /// Write what is waiting, put the text that `id` makes of the hash at `id_position`, then the
    /// other patches. The hash covers the bytes before any patch.
    pub(crate) fn finish(
        mut self,
        id_position: u64,
        id: impl FnOnce(&[u8; 32]) -> String,
    ) -> Result<(), Error> {
        self.hand_on()?;
        let hash = self.hash.finalize();
        self.patches
            .push((id_position, id(&hash.into()).into_bytes()));
        for (position, bytes) in &self.patches {
            self.sink.seek(SeekFrom::Start(self.start + position))?;
            self.sink.write_all(bytes)?;
        }
        self.sink
            .seek(SeekFrom::Start(self.start + self.n_written))?;
        self.sink.flush()?;
        Ok(())
    }
}

/// Append a length of 32 bits and a text.
pub(crate) fn push_text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
}

/// Append the words of a bit mask.
pub(crate) fn push_mask(bytes: &mut Vec<u8>, mask: &[u64]) {
    for word in mask {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
}
