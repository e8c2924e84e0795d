//! Reading a tree: first the topology of all nodes with the tiles, then the values of all leaves.
//!
//! The root holds tiles of 4096³ voxels and nodes of 32³ slots; a slot is a tile of 128³ voxels or a
//! node of 16³ slots; a slot of these is a tile of 8³ voxels or a leaf. A node is a mask of its
//! children, a mask of its active tiles, and a value block with a place for every slot.
//!
//! Where a leaf ends is told by its first few bytes, so leaves are cut out of the file one after
//! the other and decoded in parallel. A leaf that cannot be cut out is decoded alone, from the
//! stream, which finds out what is wrong with it.
//! Sources: OpenVDB, tree/RootNode.h, tree/InternalNode.h, tree/LeafNode.h, tree/LeafNodeBool.h.

use std::io::Read;
use std::io::Seek;
use std::ops::Range;

use rayon::prelude::*;

use crate::Error;
use crate::LEAF_VOXELS;
use crate::Leaf;
use crate::SparseTree;
use crate::Tile;
use crate::TileLevel;
use crate::Value;
use crate::decode::Decoder;
use crate::input::Input;
use crate::source::Piece;
use crate::source::Source;
use crate::tree::NODE_SLOTS;
use crate::tree::ROOT_NODE_SLOTS;

/// Bytes of leaves that are decoded together: a few hundred leaves, and within the caches.
const BATCH_BYTES: usize = 1 << 20;

/// Leaves that one thread decodes before it asks for more.
const LEAVES_PER_TASK: usize = 32;

/// Bytes of the mask of a leaf.
const MASK_BYTES: usize = 64;

/// Bytes of a leaf of bools: mask, origin, values.
const BOOL_LEAF_BYTES: usize = MASK_BYTES + 12 + 64;

/// Reads one tree.
pub(crate) struct TreeReader {
    /// How its values are stored.
    pub(crate) decoder: Decoder,
    /// Where its leaves start, if the file says so.
    pub(crate) leaves_position: Option<i64>,
}

/// What has been read of a tree.
struct Parts<T> {
    background: T,
    tiles: Vec<Tile<T>>,
    leaves: Vec<LeafPlace>,
}

/// A leaf before its values are known.
struct LeafPlace {
    origin: [i32; 3],
    mask: [u64; 8],
}

/// The masks and values of a node, kept from node to node for their memory.
struct Slots<T> {
    children: Vec<u64>,
    active: Vec<u64>,
    values: Vec<T>,
    /// Whether only active tiles can differ from the background.
    plain: bool,
}

impl<T: Value> Slots<T> {
    fn new(n_slots: usize) -> Self {
        let words = vec![0; n_slots / 64];
        let values = vec![T::ZERO; n_slots];
        Self {
            children: words.clone(),
            active: words,
            values,
            plain: false,
        }
    }
}

impl TreeReader {
    /// Read the tree.
    pub(crate) fn read<T: Value, R: Read + Seek>(
        mut self,
        input: &mut Input<R>,
    ) -> Result<SparseTree<T>, Error> {
        let parts = self.topology(input)?;
        if let Some(position) = self.leaves_position {
            input.skip_to(position, "the leaves of a grid")?;
        }
        let leaves = self.leaves(input, &parts.leaves, parts.background)?;
        SparseTree::from_parts(parts.background, leaves, parts.tiles)
    }

    fn leaves<T: Value, R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
        mut places: &[LeafPlace],
        background: T,
    ) -> Result<Vec<Leaf<T>>, Error> {
        let mut leaves = Vec::with_capacity(places.len());
        while let Some(first) = places.first() {
            let position = input.position();
            let window = input.window(BATCH_BYTES)?;
            let cut = self.cut_leaves::<T>(window, places);
            let Some(n_bytes) = cut.last().map(|piece| piece.end) else {
                let mut leaf = Leaf::new(first.origin, background);
                first.read(&mut self.decoder, input, background, &mut leaf)?;
                leaves.push(leaf);
                places = &places[1..];
                continue;
            };
            let (batch, rest) = places.split_at(cut.len());
            let n_before = leaves.len();
            let empty = |place: &LeafPlace| Leaf::new(place.origin, background);
            leaves.par_extend(batch.par_iter().map(empty));
            let tasks = leaves[n_before..]
                .par_chunks_mut(LEAVES_PER_TASK)
                .zip(cut.par_chunks(LEAVES_PER_TASK))
                .zip(batch.par_chunks(LEAVES_PER_TASK));
            let decoded = tasks.map(|((leaves, pieces), places)| {
                let mut decoder = self.decoder.another();
                for ((leaf, piece), place) in leaves.iter_mut().zip(pieces).zip(places) {
                    let mut source = Piece {
                        bytes: &window[piece.clone()],
                        position: position + piece.start as u64,
                    };
                    place.read(&mut decoder, &mut source, background, leaf)?;
                }
                Ok(())
            });
            // Looked at in their order, so that of several errors the first is told.
            for task in decoded.collect::<Vec<Result<(), Error>>>() {
                task?;
            }
            input.consume(n_bytes);
            places = rest;
        }
        Ok(leaves)
    }

    /// Where the leaves are that lie in `bytes` from their start on, as far as they are whole.
    fn cut_leaves<T: Value>(&self, bytes: &[u8], places: &[LeafPlace]) -> Vec<Range<usize>> {
        let mut start = 0;
        let length = |bytes: &[u8], place: &LeafPlace| {
            if T::IS_BOOL {
                return (bytes.len() >= BOOL_LEAF_BYTES).then_some(BOOL_LEAF_BYTES);
            }
            let block = bytes.get(MASK_BYTES..)?;
            let length = self.decoder.block_length::<T>(block, &place.mask)?;
            Some(MASK_BYTES + length)
        };
        let cut = places.iter().map_while(|place| {
            let end = start + length(&bytes[start..], place)?;
            let piece = start..end;
            start = end;
            Some(piece)
        });
        cut.collect()
    }

    fn topology<T: Value, R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
    ) -> Result<Parts<T>, Error> {
        const WHAT: &str = "the root of a tree";
        let n_buffers = input.u32(WHAT)?;
        if n_buffers != 1 {
            return Err(input.damaged(format!("a tree with {n_buffers} buffers, expected 1")));
        }
        let background = T::decode(input.bytes(T::SIZE, WHAT)?);
        let mut parts = Parts {
            background,
            tiles: Vec::new(),
            leaves: Vec::new(),
        };
        let n_tiles = input.u32(WHAT)?;
        let n_children = input.u32(WHAT)?;
        for _ in 0..n_tiles {
            let origin = input.coordinates(WHAT)?;
            let value = T::decode(input.bytes(T::SIZE, WHAT)?);
            let active = input.u8(WHAT)? != 0;
            input.charge(2 * size_of::<Tile<T>>() as u64)?;
            parts.push_tile(Tile {
                origin,
                level: TileLevel::Upper,
                active,
                value,
            });
        }
        let mut upper = Slots::new(ROOT_NODE_SLOTS);
        let mut lower = Slots::new(NODE_SLOTS);
        for _ in 0..n_children {
            let origin = TileLevel::Upper.check(input.coordinates(WHAT)?)?;
            self.node(input, &mut upper, background)?;
            parts.push_tiles(input, &upper, origin, TileLevel::Lower)?;
            for slot in set_bits(&upper.children) {
                let origin = TileLevel::Lower.slot_origin(origin, slot);
                self.node(input, &mut lower, background)?;
                parts.push_tiles(input, &lower, origin, TileLevel::Leaf)?;
                parts.push_leaves(input, &lower, origin)?;
            }
        }
        Ok(parts)
    }

    /// Read the masks and values of a node.
    fn node<T: Value, R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
        slots: &mut Slots<T>,
        background: T,
    ) -> Result<(), Error> {
        input.mask(&mut slots.children, "a node")?;
        input.mask(&mut slots.active, "a node")?;
        slots.values.fill(background);
        let Slots {
            active,
            values,
            plain,
            ..
        } = slots;
        *plain = self.decoder.block(input, active, background, values)?;
        Ok(())
    }
}

impl LeafPlace {
    /// Read the values of the leaf, which holds the background.
    fn read<T: Value>(
        &self,
        decoder: &mut Decoder,
        source: &mut impl Source,
        background: T,
        leaf: &mut Leaf<T>,
    ) -> Result<(), Error> {
        const WHAT: &str = "a leaf";
        source.mask(&mut leaf.mask, WHAT)?;
        if leaf.mask != self.mask {
            return Err(source.damaged(format!("the two masks of leaf {:?} differ", self.origin)));
        }
        if T::IS_BOOL {
            // Leaves of bool grids repeat their origin and hold their values as bits.
            source.coordinates(WHAT)?;
            let mut bits = [0; 8];
            source.mask(&mut bits, WHAT)?;
            for index in 0..LEAF_VOXELS {
                leaf.values[index] = T::decode(&[(bits[index >> 6] >> (index & 63) & 1) as u8]);
            }
        } else {
            decoder.block(source, &leaf.mask, background, &mut leaf.values)?;
        }
        Ok(())
    }
}

impl<T: Value> Parts<T> {
    /// Keep a tile, unless it says what is true without it.
    fn push_tile(&mut self, tile: Tile<T>) {
        if tile.active || !tile.value.same_bytes(self.background) {
            self.tiles.push(tile);
        }
    }

    fn push_tiles<R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
        slots: &Slots<T>,
        origin: [i32; 3],
        level: TileLevel,
    ) -> Result<(), Error> {
        let before = self.tiles.len();
        let words = slots.children.iter().zip(&slots.active).enumerate();
        for (index, (&children, &active)) in words {
            let mut places = if slots.plain {
                active & !children
            } else {
                !children
            };
            while places != 0 {
                let bit = places.trailing_zeros() as usize;
                places &= places - 1;
                let slot = 64 * index + bit;
                let origin = level.slot_origin(origin, slot);
                let active = active >> bit & 1 == 1;
                self.push_tile(Tile {
                    origin,
                    level,
                    active,
                    value: slots.values[slot],
                });
            }
        }
        // Twice, as the vector may have grown by doubling.
        input.charge(2 * ((self.tiles.len() - before) * size_of::<Tile<T>>()) as u64)
    }

    fn push_leaves<R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
        slots: &Slots<T>,
        origin: [i32; 3],
    ) -> Result<(), Error> {
        for slot in set_bits(&slots.children) {
            let origin = TileLevel::Leaf.slot_origin(origin, slot);
            let mut mask = [0; 8];
            input.mask(&mut mask, "the mask of a leaf")?;
            input.charge(Leaf::<T>::MEMORY + 2 * size_of::<LeafPlace>() as u64)?;
            self.leaves.push(LeafPlace { origin, mask });
        }
        Ok(())
    }
}

/// Places of the bits that are set, in rising order.
fn set_bits(mask: &[u64]) -> impl Iterator<Item = usize> {
    mask.iter().enumerate().flat_map(|(index, &word)| {
        let rest = std::iter::successors(Some(word), |&word| Some(word & word.wrapping_sub(1)));
        let words = rest.take_while(|&word| word != 0);
        words.map(move |word| 64 * index + word.trailing_zeros() as usize)
    })
}
