//! Reading a tree: first the topology of all nodes, then the values of all leaves.
//!
//! A value block is a code, up to two inactive values, a selection mask where the code says so, and
//! the active values (all values without mask compression or with code 6). Codes: 0 inactive voxels
//! hold the background, 1 its negative, 2 one other value; 3 to 5 a mask selects between negative and
//! background, one value and background, two values; 6 everything is stored.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::Error;
use crate::LEAF_VOXELS;
use crate::Leaf;
use crate::SparseTree;
use crate::Tile;
use crate::TileLevel;
use crate::Value;
use crate::blosc;
use crate::cursor::Cursor;
use crate::value::sealed::Bytes;

/// Compression flag: deflate.
pub(crate) const ZIP: u32 = 1;
/// Compression flag: only active values are stored.
pub(crate) const ACTIVE_MASK: u32 = 2;
/// Compression flag: Blosc.
pub(crate) const BLOSC: u32 = 4;

/// How the values of a grid are stored.
#[derive(Clone, Copy)]
pub(crate) struct TreeReader {
    pub(crate) compression: u32,
    pub(crate) is_half: bool,
}

/// A node above the leaves: number of slots, level of its tiles, log2 of the slots on an axis.
struct NodeKind {
    n_slots: usize,
    log2: u32,
    tiles: TileLevel,
}

const UPPER: NodeKind = NodeKind { n_slots: 32_768, log2: 5, tiles: TileLevel::Lower };
const LOWER: NodeKind = NodeKind { n_slots: 4096, log2: 4, tiles: TileLevel::Leaf };

fn bit(mask: &[u8], index: usize) -> bool {
    mask[index >> 3] >> (index & 7) & 1 == 1
}

/// The parts of a tree as they are gathered.
struct Parts<T> {
    background: T,
    leaves: Vec<Leaf<T>>,
    tiles: Vec<Tile<T>>,
}

impl TreeReader {
    pub(crate) fn read<T: Value + Bytes>(self, cursor: &mut Cursor) -> Result<SparseTree<T>, Error> {
        cursor.i32("the number of buffers")?;
        let background = T::decode(cursor.take(T::SIZE, "the background")?);
        let n_tiles = cursor.u32("the number of root tiles")?;
        let n_children = cursor.u32("the number of root children")?;
        let mut parts = Parts { background, leaves: Vec::new(), tiles: Vec::new() };
        for _ in 0..n_tiles {
            let origin = origin(cursor, TileLevel::Upper)?;
            let value = T::decode(cursor.take(T::SIZE, "a root tile")?);
            let active = cursor.u8("a root tile")? != 0;
            parts.tiles.push(Tile { origin, level: TileLevel::Upper, active, value });
        }
        for _ in 0..n_children {
            let origin = origin(cursor, TileLevel::Upper)?;
            self.node(cursor, &UPPER, origin, &mut parts)?;
        }
        for leaf in &mut parts.leaves {
            self.leaf_values(cursor, leaf, background)?;
        }
        SparseTree::from_parts(background, parts.leaves, parts.tiles)
    }

    fn node<T: Value + Bytes>(
        self,
        cursor: &mut Cursor,
        kind: &NodeKind,
        origin: [i32; 3],
        parts: &mut Parts<T>,
    ) -> Result<(), Error> {
        let child_mask = cursor.take(kind.n_slots / 8, "a child mask")?;
        let value_mask = cursor.take(kind.n_slots / 8, "a value mask")?;
        let mut values = vec![parts.background; kind.n_slots];
        self.values(cursor, value_mask, parts.background, &mut values)?;
        let dim = kind.tiles.dim();
        let place = |slot: usize| {
            let at = |shift: u32| (slot as i32 >> shift & ((1 << kind.log2) - 1)) * dim;
            [
                origin[0].wrapping_add(at(2 * kind.log2)),
                origin[1].wrapping_add(at(kind.log2)),
                origin[2].wrapping_add(at(0)),
            ]
        };
        for (slot, &value) in values.iter().enumerate() {
            if bit(child_mask, slot) {
                continue;
            }
            let active = bit(value_mask, slot);
            if active || !value.same_bytes(parts.background) {
                parts.tiles.push(Tile { origin: place(slot), level: kind.tiles, active, value });
            }
        }
        for slot in (0..kind.n_slots).filter(|&slot| bit(child_mask, slot)) {
            match kind.tiles {
                TileLevel::Lower | TileLevel::Upper => self.node(cursor, &LOWER, place(slot), parts)?,
                TileLevel::Leaf => {
                    let mut leaf = Leaf::new(place(slot), parts.background);
                    leaf.mask = leaf_mask(cursor)?;
                    parts.leaves.push(leaf);
                }
            }
        }
        Ok(())
    }

    fn leaf_values<T: Value + Bytes>(
        self,
        cursor: &mut Cursor,
        leaf: &mut Leaf<T>,
        background: T,
    ) -> Result<(), Error> {
        let mask = cursor.take(LEAF_VOXELS / 8, "the mask of a leaf")?;
        for (word, bytes) in leaf.mask.iter().zip(mask.chunks_exact(8)) {
            if word.to_le_bytes() != bytes {
                return Err(cursor.damaged("a leaf whose two masks differ"));
            }
        }
        if T::IS_BOOL {
            cursor.take(12, "the origin of a leaf")?;
            let bits = cursor.take(LEAF_VOXELS / 8, "the values of a leaf")?;
            for (index, value) in leaf.values.iter_mut().enumerate() {
                *value = T::decode(&[u8::from(bit(bits, index))]);
            }
            return Ok(());
        }
        self.values(cursor, mask, background, leaf.values.as_mut_slice())
    }

    /// A value block into `out`, whose length is the number of slots.
    fn values<T: Value + Bytes>(
        self,
        cursor: &mut Cursor,
        value_mask: &[u8],
        background: T,
        out: &mut [T],
    ) -> Result<(), Error> {
        let code = cursor.u8("the code of a value block")?;
        if code > 6 {
            return Err(cursor.damaged(format!("a value block of code {code}, expected 0 to 6")));
        }
        let mut first = if code == 0 { background } else { background.negated() };
        let mut second = background;
        if matches!(code, 2 | 4 | 5) {
            first = T::decode(cursor.take(T::SIZE, "an inactive value")?);
        }
        if code == 5 {
            second = T::decode(cursor.take(T::SIZE, "an inactive value")?);
        }
        let selection = if matches!(code, 3..=5) {
            Some(cursor.take(out.len() / 8, "a selection mask")?)
        } else {
            None
        };
        let only_active = self.compression & ACTIVE_MASK != 0 && code != 6;
        let n_active = value_mask.iter().map(|byte| byte.count_ones() as usize).sum();
        let n_stored = if only_active { n_active } else { out.len() };
        let (stored, size) = self.stored::<T>(cursor, n_stored)?;
        let decode = |bytes: &[u8]| if self.is_half_of::<T>() { T::decode_half(bytes) } else { T::decode(bytes) };
        let mut stored = stored.chunks_exact(size).map(decode);
        for (index, value) in out.iter_mut().enumerate() {
            if !only_active || bit(value_mask, index) {
                if let Some(found) = stored.next() {
                    *value = found;
                }
            } else {
                let picks_second = selection.is_some_and(|mask| bit(mask, index));
                *value = if picks_second { second } else { first };
            }
        }
        Ok(())
    }

    fn is_half_of<T: Bytes>(self) -> bool {
        self.is_half && T::HALF_SIZE > 0
    }

    /// The bytes of `n` stored values, and the size of each.
    fn stored<'a, T: Bytes>(
        self,
        cursor: &mut Cursor<'a>,
        n: usize,
    ) -> Result<(std::borrow::Cow<'a, [u8]>, usize), Error> {
        let size = if self.is_half_of::<T>() { T::HALF_SIZE } else { T::SIZE };
        let n_bytes = n * size;
        // The writer of half values writes nothing at all for none, not even a length.
        if self.is_half_of::<T>() && n == 0 {
            return Ok((std::borrow::Cow::Borrowed(&[]), size));
        }
        if self.compression & (ZIP | BLOSC) == 0 {
            return Ok((cursor.take(n_bytes, "values")?.into(), size));
        }
        let length = cursor.i64("the length of compressed values")?;
        if length <= 0 {
            let stored = usize::try_from(length.unsigned_abs()).unwrap_or(usize::MAX);
            if stored != n_bytes {
                return Err(cursor.damaged(format!("{stored} stored bytes, expected {n_bytes}")));
            }
            return Ok((cursor.take(n_bytes, "values")?.into(), size));
        }
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let packed = cursor.take(length, "compressed values")?;
        let bytes = if self.compression & BLOSC != 0 {
            blosc::decode(packed, n_bytes).map_err(|what| cursor.damaged(what))?
        } else {
            inflate(packed, n_bytes).map_err(|what| cursor.damaged(what))?
        };
        Ok((bytes.into(), size))
    }
}

fn origin(cursor: &mut Cursor, level: TileLevel) -> Result<[i32; 3], Error> {
    let what = "the origin of a node";
    let origin = [cursor.i32(what)?, cursor.i32(what)?, cursor.i32(what)?];
    if origin.iter().any(|axis| axis.rem_euclid(level.dim()) != 0) {
        return Err(Error::Misaligned { origin, dim: level.dim() });
    }
    Ok(origin)
}

fn leaf_mask(cursor: &mut Cursor) -> Result<[u64; 8], Error> {
    let mut mask = [0; 8];
    for word in &mut mask {
        *word = cursor.u64("the mask of a leaf")?;
    }
    Ok(mask)
}

fn inflate(packed: &[u8], n_bytes: usize) -> Result<Vec<u8>, String> {
    let mut bytes = vec![0; n_bytes];
    let mut decoder = ZlibDecoder::new(packed);
    decoder.read_exact(&mut bytes).map_err(|error| format!("deflated values: {error}"))?;
    // Reading on to the end checks the sum over the bytes.
    match decoder.read(&mut [0]) {
        Ok(0) => Ok(bytes),
        Ok(_) => Err(format!("deflated values of more than the expected {n_bytes} bytes")),
        Err(error) => Err(format!("deflated values: {error}")),
    }
}
