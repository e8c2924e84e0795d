//! Value blocks, written with mask compression: see the table of codes in `decode.rs`.

use flate2::Compress;
use flate2::FlushCompress;
use flate2::Status;

use crate::Compression;
use crate::Value;
use crate::decode::code;
use crate::output::push_mask;

/// Writes value blocks; keeps memory from block to block.
pub(crate) struct Encoder {
    compression: Compression,
    deflate: Option<Compress>,
    plain: Vec<u8>,
    packed: Vec<u8>,
}

/// The slots of a node, or the voxels of a leaf.
#[derive(Clone, Copy)]
pub(crate) struct Slots<'a, T> {
    /// Places that hold a child and therefore no value.
    pub(crate) children: &'a [u64],
    /// Places that are active.
    pub(crate) active: &'a [u64],
    /// A value for every place.
    pub(crate) values: &'a [T],
}

/// How the inactive values of a block are told.
struct Inactive<T> {
    code: u8,
    /// What the two sides of the selection mask stand for.
    values: [T; 2],
}

impl Encoder {
    /// For a file with that compression.
    pub(crate) fn new(compression: Compression) -> Self {
        let deflate = match compression {
            Compression::None => None,
            Compression::Zip => Some(Compress::new(flate2::Compression::default(), true)),
        };
        Self {
            compression,
            deflate,
            plain: Vec::new(),
            packed: Vec::new(),
        }
    }

    /// Another one for the same file, for another thread.
    pub(crate) fn another(&self) -> Self {
        Self::new(self.compression)
    }

    /// Append a block.
    pub(crate) fn block<T: Value>(&mut self, out: &mut Vec<u8>, slots: Slots<T>, background: T) {
        let inactive = inactive_values(slots, background);
        out.push(inactive.code);
        match inactive.code {
            code::ONE | code::BACKGROUND_OR_ONE => inactive.values[0].encode(out),
            code::TWO => inactive
                .values
                .into_iter()
                .for_each(|value| value.encode(out)),
            _ => {}
        }
        if matches!(inactive.code, code::BOTH_SIGNS..=code::TWO) {
            push_mask(out, &selection(slots, inactive.values[1]));
        }
        let all = inactive.code == code::ALL;
        let Some(deflate) = &mut self.deflate else {
            push_stored(out, slots, all);
            return;
        };
        self.plain.clear();
        push_stored(&mut self.plain, slots, all);
        push_deflated(out, deflate, &self.plain, &mut self.packed);
    }
}

/// Append the values that are stored: all of them, or the active ones.
fn push_stored<T: Value>(out: &mut Vec<u8>, slots: Slots<T>, all: bool) {
    out.reserve(slots.values.len() * T::SIZE);
    for (values, &active) in slots.values.chunks(64).zip(slots.active) {
        let mut rest = if all { u64::MAX } else { active };
        if rest == u64::MAX {
            T::encode_all(values, out);
            continue;
        }
        while rest != 0 {
            values[rest.trailing_zeros() as usize].encode(out);
            rest &= rest - 1;
        }
    }
}

/// Append bytes with their length in front, deflated if that makes them shorter.
fn push_deflated(out: &mut Vec<u8>, deflate: &mut Compress, plain: &[u8], packed: &mut Vec<u8>) {
    packed.resize(plain.len(), 0);
    deflate.reset();
    let status = deflate.compress(plain, packed, FlushCompress::Finish);
    let n_packed = deflate.total_out() as usize;
    if matches!(status, Ok(Status::StreamEnd)) && n_packed < plain.len() {
        out.extend_from_slice(&(n_packed as i64).to_le_bytes());
        out.extend_from_slice(&packed[..n_packed]);
    } else {
        // A length that is not above zero says that what follows is not deflated.
        out.extend_from_slice(&(-(plain.len() as i64)).to_le_bytes());
        out.extend_from_slice(plain);
    }
}

/// Values of places that are neither active nor children.
fn inactive_places<T: Value>(slots: Slots<'_, T>) -> impl Iterator<Item = T> {
    let masks = slots.active.iter().zip(slots.children);
    slots
        .values
        .chunks(64)
        .zip(masks)
        .flat_map(|(values, (active, children))| {
            let mut left = !(active | children);
            std::iter::from_fn(move || {
                let place = left.trailing_zeros() as usize;
                left &= left.wrapping_sub(1);
                values.get(place).copied()
            })
        })
}

fn inactive_values<T: Value>(slots: Slots<T>, background: T) -> Inactive<T> {
    let mut found = [None; 2];
    for value in inactive_places(slots) {
        match found {
            [None, _] => found[0] = Some(value),
            [Some(first), _] if value.same_bytes(first) => {}
            [_, None] => found[1] = Some(value),
            [_, Some(second)] if value.same_bytes(second) => {}
            [Some(_), Some(_)] => {
                return Inactive {
                    code: code::ALL,
                    values: [background; 2],
                };
            }
        }
    }
    let is_background = |value: T| value.same_bytes(background);
    let is_minus = |value: T| value.same_bytes(background.negated());
    let (code, values) = match found {
        [None, _] => (code::BACKGROUND, [background; 2]),
        [Some(one), None] if is_background(one) => (code::BACKGROUND, [background; 2]),
        [Some(one), None] if is_minus(one) => (code::MINUS_BACKGROUND, [one; 2]),
        [Some(one), None] => (code::ONE, [one; 2]),
        [Some(first), Some(second)] => {
            let values = if is_background(first) {
                [second, first]
            } else {
                [first, second]
            };
            match values.map(is_background) {
                [_, false] => (code::TWO, values),
                [_, true] if is_minus(values[0]) => (code::BOTH_SIGNS, values),
                [_, true] => (code::BACKGROUND_OR_ONE, values),
            }
        }
    };
    Inactive { code, values }
}

/// Bits of the inactive places that hold `second`.
fn selection<T: Value>(slots: Slots<T>, second: T) -> Vec<u64> {
    let word = |(values, active): (&[T], &u64)| {
        let places = values.iter().enumerate();
        let bits = places.map(|(place, value)| u64::from(value.same_bytes(second)) << place);
        bits.fold(0, |word, bit| word | bit) & !active
    };
    slots
        .values
        .chunks(64)
        .zip(slots.active)
        .map(word)
        .collect()
}
