//! Value blocks: the values of a node as they stand in a file.
//!
//! A block is a code, then up to two inactive values, a mask that selects between them, and the
//! values themselves. With mask compression only active values are stored, and the code says what
//! the others are:
//!
//! | code | inactive values |
//! |---|---|
//! | 0 | the background |
//! | 1 | minus the background |
//! | 2 | one other value |
//! | 3 | the mask selects between minus the background (0) and the background (1) |
//! | 4 | the mask selects between one other value (0) and the background (1) |
//! | 5 | the mask selects between two other values |
//! | 6 | all are stored |
//!
//! Source: OpenVDB, io/Compression.h.

use flate2::Decompress;
use flate2::FlushDecompress;
use flate2::Status;

use crate::Error;
use crate::Value;
use crate::blosc;
use crate::blosc::Fault;
use crate::source::Source;

/// Bit of a grid's compression word: values are deflated.
pub(crate) const FLAG_ZIP: u32 = 1;

/// Bit of a grid's compression word: inactive values are not stored.
pub(crate) const FLAG_ACTIVE_MASK: u32 = 2;

/// Bit of a grid's compression word: values are in Blosc chunks, whatever the bit for zip says.
pub(crate) const FLAG_BLOSC: u32 = 4;

/// The codes of the table above.
pub(crate) mod code {
    /// Inactive values are the background.
    pub(crate) const BACKGROUND: u8 = 0;
    /// Inactive values are minus the background.
    pub(crate) const MINUS_BACKGROUND: u8 = 1;
    /// Inactive values are one other value.
    pub(crate) const ONE: u8 = 2;
    /// Inactive values are the background or minus the background.
    pub(crate) const BOTH_SIGNS: u8 = 3;
    /// Inactive values are the background or one other value.
    pub(crate) const BACKGROUND_OR_ONE: u8 = 4;
    /// Inactive values are one of two other values.
    pub(crate) const TWO: u8 = 5;
    /// All values are stored.
    pub(crate) const ALL: u8 = 6;
}

/// Part of a file, for messages.
const VALUES: &str = "the values of a node";

/// Zlib and Blosc lengths beyond this multiple of the decoded length, plus a header, are damage.
const LARGEST_EXPANSION: u64 = 2;
const LARGEST_OVERHEAD: u64 = 4096;

/// How the values of a grid are stored, and memory that is kept from block to block.
pub(crate) struct Decoder {
    flags: u32,
    half: bool,
    inflate: Decompress,
    decoded: Vec<u8>,
    shuffled: Vec<u8>,
    selection: Vec<u64>,
}

impl Decoder {
    /// For a grid with that compression word, whose reals are halves or not.
    pub(crate) fn new(flags: u32, half: bool) -> Self {
        Self {
            flags,
            half,
            inflate: Decompress::new(true),
            decoded: Vec::new(),
            shuffled: Vec::new(),
            selection: Vec::new(),
        }
    }

    /// Another one for the same grid, for another thread.
    pub(crate) fn another(&self) -> Self {
        Self::new(self.flags, self.half)
    }

    /// Read a block into `out`, which holds the background in every place; `mask` says which
    /// places are active. Gives whether all others are known to hold the background still.
    pub(crate) fn block<T: Value>(
        &mut self,
        input: &mut impl Source,
        mask: &[u64],
        background: T,
        out: &mut [T],
    ) -> Result<bool, Error> {
        let code = input.u8(VALUES)?;
        if code > code::ALL {
            return Err(input.damaged(format!(
                "a value block with the code {code}, expected 0 to 6"
            )));
        }
        let inactive = self.inactive_values(input, code, mask.len(), background)?;
        let n_stored = self.n_stored(code, mask, out.len());
        if n_stored < out.len() && code != code::BACKGROUND {
            let selection = matches!(code, code::BOTH_SIGNS..=code::TWO);
            fill_inactive(selection.then_some(&self.selection), inactive, out);
        }
        let only_active_changed = n_stored < out.len() && code == code::BACKGROUND;
        let (half, size) = self.stored_form::<T>();
        if half && n_stored == 0 {
            // OpenVDB writes no length in this one case.
            return Ok(only_active_changed);
        }
        let bytes = self.stored_bytes(input, n_stored * size)?;
        let stored = |size: usize| bytes.chunks_exact(size);
        let every = n_stored == out.len();
        match (half, every) {
            (true, true) => fill_all(stored(T::HALF_SIZE).map(T::decode_half), out),
            (true, false) => fill_active(stored(T::HALF_SIZE).map(T::decode_half), mask, out),
            (false, true) => fill_all(stored(T::SIZE).map(T::decode), out),
            (false, false) => fill_active(stored(T::SIZE).map(T::decode), mask, out),
        }
        Ok(only_active_changed)
    }

    /// Length of the block that `bytes` start with; `None` if they do not hold all of it, or if it
    /// cannot be told because the block is not sound.
    pub(crate) fn block_length<T: Value>(&self, bytes: &[u8], mask: &[u64]) -> Option<usize> {
        let code = *bytes.first()?;
        let n_values = match code {
            code::ONE | code::BACKGROUND_OR_ONE => 1,
            code::TWO => 2,
            _ => 0,
        };
        let selection = matches!(code, code::BOTH_SIGNS..=code::TWO);
        let n_selection = if selection { 8 * mask.len() } else { 0 };
        let head = 1 + n_values * T::SIZE + n_selection;
        let n_stored = self.n_stored(code, mask, 64 * mask.len());
        let (half, size) = self.stored_form::<T>();
        let length = if half && n_stored == 0 {
            head
        } else if self.flags & (FLAG_ZIP | FLAG_BLOSC) == 0 {
            head + n_stored * size
        } else {
            let field = bytes.get(head..)?.first_chunk()?;
            let packed = usize::try_from(i64::from_le_bytes(*field).unsigned_abs()).ok()?;
            (head + 8).checked_add(packed)?
        };
        (length <= bytes.len()).then_some(length)
    }

    /// Number of values that are stored of a block.
    fn n_stored(&self, code: u8, mask: &[u64], n_places: usize) -> usize {
        if self.flags & FLAG_ACTIVE_MASK == 0 || code == code::ALL {
            return n_places;
        }
        mask.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether values are stored as halves, and the bytes of each.
    fn stored_form<T: Value>(&self) -> (bool, usize) {
        let half = self.half && T::HALF_SIZE > 0;
        (half, if half { T::HALF_SIZE } else { T::SIZE })
    }

    /// The two values between which the selection mask selects; reads that mask.
    fn inactive_values<T: Value>(
        &mut self,
        input: &mut impl Source,
        code: u8,
        n_words: usize,
        background: T,
    ) -> Result<[T; 2], Error> {
        let mut inactive = [background.negated(), background];
        if matches!(code, code::ONE | code::BACKGROUND_OR_ONE | code::TWO) {
            inactive[0] = T::decode(input.bytes(T::SIZE, VALUES)?);
        }
        if code == code::TWO {
            inactive[1] = T::decode(input.bytes(T::SIZE, VALUES)?);
        }
        if matches!(code, code::BOTH_SIGNS..=code::TWO) {
            self.selection.resize(n_words, 0);
            input.mask(&mut self.selection, VALUES)?;
        }
        Ok(inactive)
    }

    /// The next `n_bytes` of values, decompressed.
    fn stored_bytes<'a>(
        &'a mut self,
        input: &'a mut impl Source,
        n_bytes: usize,
    ) -> Result<&'a [u8], Error> {
        if self.flags & (FLAG_ZIP | FLAG_BLOSC) == 0 {
            return input.bytes(n_bytes, VALUES);
        }
        let length = input.i64(VALUES)?;
        if length <= 0 {
            if length.unsigned_abs() != n_bytes as u64 {
                let what = format!("a stored block of {length} bytes, expected -{n_bytes}");
                return Err(input.damaged(what));
            }
            return input.bytes(n_bytes, VALUES);
        }
        let length = length.unsigned_abs();
        if length > LARGEST_EXPANSION * n_bytes as u64 + LARGEST_OVERHEAD {
            let what =
                format!("a compressed block of {length} bytes for {n_bytes} bytes of values");
            return Err(input.damaged(what));
        }
        let position = input.position();
        let chunk = input.bytes(length as usize, VALUES)?;
        self.decoded.resize(n_bytes, 0);
        let decoded = if self.flags & FLAG_BLOSC != 0 {
            blosc::decode(chunk, &mut self.decoded, &mut self.shuffled)
        } else {
            inflate(&mut self.inflate, chunk, &mut self.decoded)
        };
        match decoded {
            Ok(()) => Ok(&self.decoded),
            Err(Fault::Damaged(what)) => Err(Error::Damaged { position, what }),
            Err(Fault::Unsupported(error)) => Err(error),
        }
    }
}

/// Decode a zlib stream that must fill `out` exactly.
fn inflate(state: &mut Decompress, chunk: &[u8], out: &mut [u8]) -> Result<(), Fault> {
    state.reset(true);
    let status = state.decompress(chunk, out, FlushDecompress::Finish);
    let complete = matches!(status, Ok(Status::StreamEnd)) && state.total_out() == out.len() as u64;
    complete
        .then_some(())
        .ok_or_else(|| "a zlib stream is not sound".into())
}

fn fill_inactive<T: Value>(selection: Option<&Vec<u64>>, inactive: [T; 2], out: &mut [T]) {
    let Some(selection) = selection else {
        out.fill(inactive[0]);
        return;
    };
    for (values, word) in out.chunks_mut(64).zip(selection) {
        for (bit, value) in values.iter_mut().enumerate() {
            *value = inactive[(word >> bit & 1) as usize];
        }
    }
}

fn fill_all<T>(stored: impl Iterator<Item = T>, out: &mut [T]) {
    for (value, stored) in out.iter_mut().zip(stored) {
        *value = stored;
    }
}

/// Put the values into the active places, in their order.
fn fill_active<T>(mut stored: impl Iterator<Item = T>, mask: &[u64], out: &mut [T]) {
    for (values, &word) in out.chunks_mut(64).zip(mask) {
        if word == u64::MAX {
            fill_all(&mut stored, values);
            continue;
        }
        let mut rest = word;
        while rest != 0 {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            if let Some(stored) = stored.next() {
                values[bit] = stored;
            }
        }
    }
}
