//! Bytes in their order, and the numbers, texts and masks that they hold, little-endian.

use crate::Error;

/// A file, or a piece of one that lies in memory.
pub(crate) trait Source {
    /// Number of bytes of the file before the next one.
    fn position(&self) -> u64;

    /// The next `n` bytes; `what` they are a part of, for messages.
    fn bytes(&mut self, n: usize, what: &'static str) -> Result<&[u8], Error>;

    /// An error at the present position.
    fn damaged(&self, what: impl Into<String>) -> Error {
        Error::Damaged {
            position: self.position(),
            what: what.into(),
        }
    }

    /// The next `N` bytes by value.
    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], Error> {
        let mut out = [0; N];
        out.copy_from_slice(self.bytes(N, what)?);
        Ok(out)
    }

    /// A number of 8 bits.
    fn u8(&mut self, what: &'static str) -> Result<u8, Error> {
        Ok(self.array::<1>(what)?[0])
    }

    /// A number of 32 bits.
    fn u32(&mut self, what: &'static str) -> Result<u32, Error> {
        self.array(what).map(u32::from_le_bytes)
    }

    /// A signed number of 32 bits.
    fn i32(&mut self, what: &'static str) -> Result<i32, Error> {
        self.array(what).map(i32::from_le_bytes)
    }

    /// A signed number of 64 bits.
    fn i64(&mut self, what: &'static str) -> Result<i64, Error> {
        self.array(what).map(i64::from_le_bytes)
    }

    /// `N` floating-point numbers of 64 bits.
    fn f64s<const N: usize>(&mut self, what: &'static str) -> Result<[f64; N], Error> {
        let mut out = [0.0; N];
        for value in &mut out {
            *value = f64::from_le_bytes(self.array(what)?);
        }
        Ok(out)
    }

    /// Three signed numbers of 32 bits.
    fn coordinates(&mut self, what: &'static str) -> Result<[i32; 3], Error> {
        Ok([self.i32(what)?, self.i32(what)?, self.i32(what)?])
    }

    /// A length of 32 bits and that many bytes of text. Bytes that are not UTF-8 are replaced.
    fn text(&mut self, what: &'static str) -> Result<String, Error> {
        let n_bytes = self.u32(what)?;
        let bytes = self.bytes(n_bytes as usize, what)?;
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// Fill the words of a bit mask.
    fn mask(&mut self, words: &mut [u64], what: &'static str) -> Result<(), Error> {
        let bytes = self.bytes(8 * words.len(), what)?;
        for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(8)) {
            let mut little_endian = [0; 8];
            little_endian.copy_from_slice(bytes);
            *word = u64::from_le_bytes(little_endian);
        }
        Ok(())
    }
}

/// A piece of a file that lies in memory.
pub(crate) struct Piece<'a> {
    /// The bytes that are left.
    pub(crate) bytes: &'a [u8],
    /// Where in the file they start.
    pub(crate) position: u64,
}

impl Source for Piece<'_> {
    fn position(&self) -> u64 {
        self.position
    }

    fn bytes(&mut self, n: usize, what: &'static str) -> Result<&[u8], Error> {
        let Some((piece, rest)) = self.bytes.split_at_checked(n) else {
            let length = self.position + self.bytes.len() as u64;
            let needed = (n - self.bytes.len()) as u64;
            return Err(Error::Truncated {
                what,
                length,
                needed,
            });
        };
        self.bytes = rest;
        self.position += n as u64;
        Ok(piece)
    }
}
