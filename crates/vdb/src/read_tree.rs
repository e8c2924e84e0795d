//! Reading a tree: first the topology of all nodes with the tiles, then the values of all leaves.
//!
//! The root holds tiles of 4096³ voxels and nodes of 32³ slots; a slot is a tile of 128³ voxels or a
//! node of 16³ slots; a slot of these is a tile of 8³ voxels or a leaf. A node is a mask of its
//! children, a mask of its active tiles, and a value block with a place for every slot.
//! Sources: OpenVDB, tree/RootNode.h, tree/InternalNode.h, tree/LeafNode.h, tree/LeafNodeBool.h.

use std::io::Read;

use crate::Error;
use crate::LEAF_VOXELS;
use crate::Leaf;
use crate::SparseTree;
use crate::Tile;
use crate::TileLevel;
use crate::Value;
use crate::decode::Decoder;
use crate::input::Input;
use crate::tree::NODE_SLOTS;
use crate::tree::ROOT_NODE_SLOTS;

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
    pub(crate) fn read<T: Value, R: Read>(
        mut self,
        input: &mut Input<R>,
    ) -> Result<SparseTree<T>, Error> {
        let parts = self.topology(input)?;
        if let Some(position) = self.leaves_position {
            input.skip_to(position, "the leaves of a grid")?;
        }
        let mut leaves = Vec::with_capacity(parts.leaves.len());
        for place in &parts.leaves {
            leaves.push(self.leaf(input, place, parts.background)?);
        }
        SparseTree::from_parts(parts.background, leaves, parts.tiles)
    }

    fn topology<T: Value, R: Read>(&mut self, input: &mut Input<R>) -> Result<Parts<T>, Error> {
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
    fn node<T: Value, R: Read>(
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

    fn leaf<T: Value, R: Read>(
        &mut self,
        input: &mut Input<R>,
        place: &LeafPlace,
        background: T,
    ) -> Result<Leaf<T>, Error> {
        const WHAT: &str = "a leaf";
        let mut mask = [0; 8];
        input.mask(&mut mask, WHAT)?;
        if mask != place.mask {
            return Err(input.damaged(format!("the two masks of leaf {:?} differ", place.origin)));
        }
        let mut leaf = Leaf::new(place.origin, background);
        leaf.mask = mask;
        if T::IS_BOOL {
            // Leaves of bool grids repeat their origin and hold their values as bits.
            input.coordinates(WHAT)?;
            let mut bits = [0; 8];
            input.mask(&mut bits, WHAT)?;
            for index in 0..LEAF_VOXELS {
                leaf.values[index] = T::decode(&[(bits[index >> 6] >> (index & 63) & 1) as u8]);
            }
        } else {
            self.decoder
                .block(input, &mask, background, leaf.values.as_mut_slice())?;
        }
        Ok(leaf)
    }
}

impl<T: Value> Parts<T> {
    /// Keep a tile, unless it says what is true without it.
    fn push_tile(&mut self, tile: Tile<T>) {
        if tile.active || !tile.value.same_bytes(self.background) {
            self.tiles.push(tile);
        }
    }

    fn push_tiles<R: Read>(
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

    fn push_leaves<R: Read>(
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
