//! Writing a tree: its nodes are rebuilt from the sorted leaves and tiles, and told in that order.

use std::collections::BTreeSet;
use std::io::Seek;
use std::io::Write;

use rayon::prelude::*;

use crate::Error;
use crate::LEAF_VOXELS;
use crate::Leaf;
use crate::SparseTree;
use crate::Tile;
use crate::TileLevel;
use crate::Value;
use crate::encode::Encoder;
use crate::encode::Slots;
use crate::output::Output;
use crate::output::push_mask;
use crate::tree::NODE_SLOTS;
use crate::tree::ROOT_NODE_SLOTS;
use crate::tree::TreeOrder;
use crate::tree::tree_order;

/// Leaves that are encoded before they are written.
const LEAVES_PER_BATCH: usize = 2048;

/// Leaves that one thread encodes before it asks for more.
const LEAVES_PER_TASK: usize = 64;

/// The leaves and tiles inside a node, each sorted.
#[derive(Clone, Copy)]
struct Inside<'a, T> {
    leaves: &'a [Leaf<T>],
    tiles: &'a [Tile<T>],
}

/// A node that is being put together.
struct Node<T> {
    children: Vec<u64>,
    active: Vec<u64>,
    values: Vec<T>,
}

/// Write the nodes: all masks, and the values of tiles.
pub(crate) fn topology<T: Value, W: Write + Seek>(
    output: &mut Output<W>,
    encoder: &mut Encoder,
    tree: &SparseTree<T>,
) -> Result<(), Error> {
    let (roots, nodes): (Vec<&Tile<T>>, Vec<&Tile<T>>) = tree
        .tiles()
        .iter()
        .partition(|tile| tile.level == TileLevel::Upper);
    let origins = tree.leaves().iter().map(|leaf| leaf.origin);
    let origins = origins.chain(nodes.iter().map(|tile| tile.origin));
    let uppers = origins
        .map(|origin| tree_order(origin).0)
        .collect::<BTreeSet<_>>();
    output.append(|bytes| {
        bytes.extend_from_slice(&1_u32.to_le_bytes());
        tree.background.encode(bytes);
        bytes.extend_from_slice(&(roots.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&(uppers.len() as u32).to_le_bytes());
    })?;
    for tile in roots {
        output.append(|bytes| {
            push_origin(bytes, tile.origin);
            tile.value.encode(bytes);
            bytes.push(u8::from(tile.active));
        })?;
    }
    let all = Inside {
        leaves: tree.leaves(),
        tiles: tree.tiles(),
    };
    for upper in uppers {
        output.append(|bytes| push_origin(bytes, upper.map(|axis| axis << 12)))?;
        let inside = all.range(|order| order.0.cmp(&upper));
        upper_node(output, encoder, inside, tree.background)?;
    }
    Ok(())
}

/// Write the values of all leaves: a batch is encoded in parallel while the one before it is
/// written.
pub(crate) fn leaves<T: Value, W: Write + Seek>(
    output: &mut Output<W>,
    encoder: &Encoder,
    tree: &SparseTree<T>,
) -> Result<(), Error> {
    let mut batches = tree.leaves().chunks(LEAVES_PER_BATCH);
    let mut encoded = Vec::new();
    let mut next = Vec::new();
    let encode = |batch: Option<&[Leaf<T>]>, parts: &mut Vec<Vec<u8>>| {
        let leaves = batch.unwrap_or_default();
        parts.resize_with(leaves.len().div_ceil(LEAVES_PER_TASK), Vec::new);
        let tasks = leaves.par_chunks(LEAVES_PER_TASK).zip(parts);
        tasks.for_each(|(leaves, bytes)| {
            let mut encoder = encoder.another();
            bytes.clear();
            for leaf in leaves {
                push_leaf(bytes, &mut encoder, leaf, tree.background);
            }
        });
    };
    encode(batches.next(), &mut encoded);
    while !encoded.is_empty() {
        let batch = batches.next();
        output.append_all(&encoded, || encode(batch, &mut next))?;
        std::mem::swap(&mut encoded, &mut next);
    }
    Ok(())
}

fn push_leaf<T: Value>(bytes: &mut Vec<u8>, encoder: &mut Encoder, leaf: &Leaf<T>, background: T) {
    push_mask(bytes, &leaf.mask);
    if T::IS_BOOL {
        push_origin(bytes, leaf.origin);
        push_mask(bytes, &value_bits(leaf));
    } else {
        let slots = Slots {
            children: &[0; 8],
            active: &leaf.mask,
            values: leaf.values.as_slice(),
        };
        encoder.block(bytes, slots, background);
    }
}

fn upper_node<T: Value, W: Write + Seek>(
    output: &mut Output<W>,
    encoder: &mut Encoder,
    inside: Inside<T>,
    background: T,
) -> Result<(), Error> {
    let mut node = Node::new(ROOT_NODE_SLOTS, background);
    for leaf in inside.leaves {
        node.set_child(tree_order(leaf.origin).1);
    }
    for tile in inside.tiles {
        let slot = tree_order(tile.origin).1;
        match tile.level {
            TileLevel::Lower => node.set_tile(slot, tile),
            TileLevel::Leaf => node.set_child(slot),
            TileLevel::Upper => {}
        }
    }
    output.append(|bytes| node.push(bytes, encoder, background))?;
    for slot in 0..ROOT_NODE_SLOTS as u32 {
        if node.has_child(slot) {
            let inside = inside.range(|order| order.1.cmp(&slot));
            output.append(|bytes| push_lower_node(bytes, encoder, inside, background))?;
        }
    }
    Ok(())
}

fn push_lower_node<T: Value>(
    bytes: &mut Vec<u8>,
    encoder: &mut Encoder,
    inside: Inside<T>,
    background: T,
) {
    let mut node = Node::new(NODE_SLOTS, background);
    for leaf in inside.leaves {
        node.set_child(tree_order(leaf.origin).2);
    }
    for tile in inside.tiles {
        node.set_tile(tree_order(tile.origin).2, tile);
    }
    node.push(bytes, encoder, background);
    for leaf in inside.leaves {
        push_mask(bytes, &leaf.mask);
    }
}

impl<T: Value> Inside<'_, T> {
    /// Those whose place in the tree compares equal.
    fn range(self, compare: impl Fn(TreeOrder) -> std::cmp::Ordering) -> Self {
        let leaves = equal_range(self.leaves, |leaf| compare(tree_order(leaf.origin)));
        let tiles = equal_range(self.tiles, |tile| compare(tree_order(tile.origin)));
        Self { leaves, tiles }
    }
}

fn equal_range<E>(sorted: &[E], compare: impl Fn(&E) -> std::cmp::Ordering) -> &[E] {
    let start = sorted.partition_point(|entry| compare(entry).is_lt());
    let end = sorted.partition_point(|entry| compare(entry).is_le());
    &sorted[start..end]
}

impl<T: Value> Node<T> {
    fn new(n_slots: usize, background: T) -> Self {
        let words = vec![0; n_slots / 64];
        Self {
            children: words.clone(),
            active: words,
            values: vec![background; n_slots],
        }
    }

    fn set_child(&mut self, slot: u32) {
        self.children[slot as usize >> 6] |= 1 << (slot & 63);
    }

    fn has_child(&self, slot: u32) -> bool {
        self.children[slot as usize >> 6] >> (slot & 63) & 1 == 1
    }

    fn set_tile(&mut self, slot: u32, tile: &Tile<T>) {
        self.values[slot as usize] = tile.value;
        self.active[slot as usize >> 6] |= u64::from(tile.active) << (slot & 63);
    }

    fn push(&self, bytes: &mut Vec<u8>, encoder: &mut Encoder, background: T) {
        push_mask(bytes, &self.children);
        push_mask(bytes, &self.active);
        let (children, active, values) = (&self.children, &self.active, &self.values);
        encoder.block(
            bytes,
            Slots {
                children,
                active,
                values,
            },
            background,
        );
    }
}

fn value_bits<T: Value>(leaf: &Leaf<T>) -> [u64; 8] {
    let mut bits = [0; 8];
    for index in 0..LEAF_VOXELS {
        let is_set = !leaf.values[index].same_bytes(T::ZERO);
        bits[index >> 6] |= u64::from(is_set) << (index & 63);
    }
    bits
}

fn push_origin(bytes: &mut Vec<u8>, origin: [i32; 3]) {
    for axis in origin {
        bytes.extend_from_slice(&axis.to_le_bytes());
    }
}
