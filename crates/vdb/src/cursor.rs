//! A position in the bytes of a file; every step is checked against their end.

use crate::Error;

/// Reads little-endian numbers and slices from a byte slice.
#[derive(Clone, Copy)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    pub(crate) fn position(&self) -> u64 {
        self.position as u64
    }

    /// Go to a stored offset.
    pub(crate) fn seek(&mut self, position: i64, what: &'static str) -> Result<(), Error> {
        let target = usize::try_from(position).ok().filter(|&target| target <= self.bytes.len());
        let message = || format!("{what} stands at {position}, outside of the file");
        self.position = target.ok_or_else(|| self.damaged(message()))?;
        Ok(())
    }

    pub(crate) fn damaged(&self, what: impl Into<String>) -> Error {
        Error::Damaged { position: self.position(), what: what.into() }
    }

    /// The next `n` bytes.
    pub(crate) fn take(&mut self, n: usize, what: &'static str) -> Result<&'a [u8], Error> {
        let rest = &self.bytes[self.position..];
        if n > rest.len() {
            let (length, needed) = (self.bytes.len() as u64, (n - rest.len()) as u64);
            return Err(Error::Truncated { what, length, needed });
        }
        self.position += n;
        Ok(&rest[..n])
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, what)?);
        Ok(array)
    }

    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, Error> {
        Ok(self.array::<1>(what)?[0])
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, Error> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn i32(&mut self, what: &'static str) -> Result<i32, Error> {
        Ok(i32::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn i64(&mut self, what: &'static str) -> Result<i64, Error> {
        Ok(i64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn u64(&mut self, what: &'static str) -> Result<u64, Error> {
        Ok(u64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn f64(&mut self, what: &'static str) -> Result<f64, Error> {
        Ok(f64::from_le_bytes(self.array(what)?))
    }

    /// A length and that many bytes of UTF-8.
    pub(crate) fn string(&mut self, what: &'static str) -> Result<String, Error> {
        let n = self.u32(what)? as usize;
        Ok(String::from_utf8_lossy(self.take(n, what)?).into_owned())
    }
}
