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

use std::io::Read;

use flate2::Decompress;
use flate2::FlushDecompress;
use flate2::Status;

use crate::Error;
use crate::Value;
use crate::blosc;
use crate::blosc::Fault;
use crate::input::Input;

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

    /// Read a block into `out`, which holds the background in every place; `mask` says which
    /// places are active. Gives whether all others are known to hold the background still.
    pub(crate) fn block<T: Value, R: Read>(
        &mut self,
        input: &mut Input<R>,
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
        let mask_compressed = self.flags & FLAG_ACTIVE_MASK != 0 && code != code::ALL;
        let n_active = mask
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum::<usize>();
        let n_stored = if mask_compressed { n_active } else { out.len() };
        if n_stored < out.len() && code != code::BACKGROUND {
            let selection = matches!(code, code::BOTH_SIGNS..=code::TWO);
            fill_inactive(selection.then_some(&self.selection), inactive, out);
        }
        let only_active_changed = n_stored < out.len() && code == code::BACKGROUND;
        let half = self.half && T::HALF_SIZE > 0;
        if half && n_stored == 0 {
            // OpenVDB writes no length in this one case.
            return Ok(only_active_changed);
        }
        let size = if half { T::HALF_SIZE } else { T::SIZE };
        let bytes = self.stored_bytes(input, n_stored * size)?;
        let every = n_stored == out.len();
        match (half, every) {
            (true, true) => decode_all(bytes, T::HALF_SIZE, T::decode_half, out),
            (true, false) => decode_active(bytes, T::HALF_SIZE, T::decode_half, (mask, out)),
            (false, true) => decode_all(bytes, T::SIZE, T::decode, out),
            (false, false) => decode_active(bytes, T::SIZE, T::decode, (mask, out)),
        }
        Ok(only_active_changed)
    }

    /// The two values between which the selection mask selects; reads that mask.
    fn inactive_values<T: Value, R: Read>(
        &mut self,
        input: &mut Input<R>,
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
    fn stored_bytes<'a, R: Read>(
        &'a mut self,
        input: &'a mut Input<R>,
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

fn decode_all<T>(bytes: &[u8], size: usize, decode: impl Fn(&[u8]) -> T, out: &mut [T]) {
    for (value, bytes) in out.iter_mut().zip(bytes.chunks_exact(size)) {
        *value = decode(bytes);
    }
}

/// Put the values into the active places, in their order.
fn decode_active<T>(
    bytes: &[u8],
    size: usize,
    decode: impl Fn(&[u8]) -> T,
    (mask, out): (&[u64], &mut [T]),
) {
    let mut stored = bytes.chunks_exact(size);
    for (values, &word) in out.chunks_mut(64).zip(mask) {
        if word == u64::MAX {
            for (value, bytes) in values.iter_mut().zip(&mut stored) {
                *value = decode(bytes);
            }
            continue;
        }
        let mut rest = word;
        while rest != 0 {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            if let Some(bytes) = stored.next() {
                values[bit] = decode(bytes);
            }
        }
    }
}
