//! The same image gives the same bytes.
//!
//! The `exr` crate keeps custom attributes in a hash map and writes them in an order that changes
//! from run to run. This writer holds the header back until it is complete, puts the attributes of
//! each part in alphabetical order, which changes no length and no offset, and passes the rest on.

use std::io;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;

/// Magic number and version field in front of the headers.
const N_PREAMBLE_BYTES: usize = 8;
/// Bit of the version field that says that several headers follow.
const MULTI_PART: u8 = 0x10;

/// A writer that sorts the attributes of an EXR header on their way.
pub(crate) struct CanonicalHeader<W> {
    inner: W,
    /// Bytes held back; `None` once the header has been passed on.
    held: Option<Vec<u8>>,
}

impl<W: Write + Seek> CanonicalHeader<W> {
    pub(crate) fn new(inner: W) -> Self {
        Self { inner, held: Some(Vec::new()) }
    }

    /// Passes on what is still held back.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.pass_on()?;
        self.inner.flush()
    }

    fn pass_on(&mut self) -> io::Result<()> {
        if let Some(mut bytes) = self.held.take() {
            sort_headers(&mut bytes);
            self.inner.write_all(&bytes)?;
        }
        Ok(())
    }
}

impl<W: Write + Seek> Write for CanonicalHeader<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.held {
            Some(held) => {
                held.extend_from_slice(bytes);
                Ok(bytes.len())
            }
            None => self.inner.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.held.is_none() { self.inner.flush() } else { Ok(()) }
    }
}

impl<W: Write + Seek> Seek for CanonicalHeader<W> {
    // The encoder seeks only after the whole header is written: over the offset tables.
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.pass_on()?;
        self.inner.seek(position)
    }
}

/// Sorts the attributes of every complete header; stops at the first thing that is none.
fn sort_headers(bytes: &mut [u8]) {
    let multi_part = bytes.get(5).is_some_and(|flags| flags & MULTI_PART != 0);
    let mut start = N_PREAMBLE_BYTES;
    while let Some(ends) = attribute_ends(bytes, start) {
        let Some(&end) = ends.last() else { return };
        let mut attributes: Vec<Vec<u8>> = Vec::with_capacity(ends.len());
        let mut from = start;
        for &to in &ends {
            attributes.push(bytes[from..to].to_vec());
            from = to;
        }
        // Names end with a zero byte, so comparing bytes compares names first.
        attributes.sort();
        let sorted = attributes.concat();
        bytes[start..end].copy_from_slice(&sorted);
        // Behind the attributes stands the zero byte that ends the header.
        start = end + 1;
        if !multi_part {
            return;
        }
    }
}

/// Where each attribute of the header at `start` ends; `None` if no complete header stands there.
fn attribute_ends(bytes: &[u8], start: usize) -> Option<Vec<usize>> {
    let mut ends = Vec::new();
    let mut at = start;
    loop {
        if *bytes.get(at)? == 0 {
            return (!ends.is_empty()).then_some(ends);
        }
        let name = zero_terminated(bytes, at)?;
        let kind = zero_terminated(bytes, name)?;
        let size = bytes.get(kind..kind + 4)?;
        let n_bytes = u32::from_le_bytes([size[0], size[1], size[2], size[3]]) as usize;
        at = kind.checked_add(4)?.checked_add(n_bytes)?;
        if at > bytes.len() {
            return None;
        }
        ends.push(at);
    }
}

/// The position behind the zero byte that ends the text at `start`.
fn zero_terminated(bytes: &[u8], start: usize) -> Option<usize> {
    let length = bytes.get(start..)?.iter().position(|&byte| byte == 0)?;
    Some(start + length + 1)
}
