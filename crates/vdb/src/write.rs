//! Writing: file version 224, active voxels only, uncompressed or deflated.
//!
//! Offsets are patched once a grid is complete. The UUID is made from the content, so that equal
//! content gives equal bytes.

use std::collections::BTreeMap;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;

use flate2::write::ZlibEncoder;

use crate::Compression;
use crate::Error;
use crate::Grid;
use crate::LEAF_DIM;
use crate::LEAF_VOXELS;
use crate::Leaf;
use crate::MetaValue;
use crate::Metadata;
use crate::SparseTree;
use crate::Tile;
use crate::TileLevel;
use crate::Transform;
use crate::Tree;
use crate::Value;
use crate::VdbFile;
use crate::read::MAGIC;
use crate::read_tree::ACTIVE_MASK;
use crate::read_tree::ZIP;
use crate::tree::tree_order;
use crate::value::sealed::Bytes;

/// The version that OpenVDB 6.1 to 12 write and every later one reads.
const FILE_VERSION: u32 = 224;
/// Version of the OpenVDB library whose files these are like.
const LIBRARY_VERSION: [u32; 2] = [10, 0];
/// Items that follow from the grid itself.
const DERIVED: [&str; 7] = [
    "class",
    "name",
    "file_bbox_min",
    "file_bbox_max",
    "file_voxel_count",
    "file_compression",
    "is_saved_as_half_float",
];

pub(crate) fn write(
    file: &VdbFile,
    mut output: impl Write + Seek,
    compression: Compression,
) -> Result<(), Error> {
    let mut header = Vec::new();
    header.extend(MAGIC.to_le_bytes());
    header.extend(FILE_VERSION.to_le_bytes());
    header.extend(LIBRARY_VERSION.iter().flat_map(|part| part.to_le_bytes()));
    header.push(1);
    header.extend(uuid(file).as_bytes());
    push_metadata(&mut header, &file.metadata);
    header.extend((file.grids.len() as u32).to_le_bytes());
    output.write_all(&header)?;
    let mut seen = BTreeMap::<&str, usize>::new();
    for grid in &file.grids {
        let n_before = seen.entry(&grid.name).or_insert(0);
        let unique = match *n_before {
            0 => grid.name.clone(),
            n => format!("{}\u{1e}{n}", grid.name),
        };
        *n_before += 1;
        write_grid(grid, &unique, &mut output, compression)?;
    }
    output.flush()?;
    Ok(())
}

fn write_grid(
    grid: &Grid,
    unique_name: &str,
    output: &mut (impl Write + Seek),
    compression: Compression,
) -> Result<(), Error> {
    match &grid.tree {
        Tree::Float(tree) => write_typed(grid, tree, unique_name, output, compression),
        Tree::Double(tree) => write_typed(grid, tree, unique_name, output, compression),
        Tree::Vec3s(tree) => write_typed(grid, tree, unique_name, output, compression),
        Tree::Int32(tree) => write_typed(grid, tree, unique_name, output, compression),
        Tree::Bool(tree) => write_typed(grid, tree, unique_name, output, compression),
    }
}

fn write_typed<T: Value + Bytes>(
    grid: &Grid,
    tree: &SparseTree<T>,
    unique_name: &str,
    output: &mut (impl Write + Seek),
    compression: Compression,
) -> Result<(), Error> {
    let mut bytes = Vec::new();
    push_string(&mut bytes, unique_name);
    push_string(&mut bytes, &format!("Tree_{}_5_4_3", T::TYPE_NAME));
    push_string(&mut bytes, "");
    output.write_all(&bytes)?;
    let offsets_at = output.stream_position()?;
    output.write_all(&[0; 24])?;

    let grid_at = output.stream_position()?;
    let zip = compression == Compression::Zip;
    bytes.clear();
    bytes.extend((ACTIVE_MASK | if zip { ZIP } else { 0 }).to_le_bytes());
    push_metadata(&mut bytes, &grid_metadata(grid, tree, zip));
    push_transform(&mut bytes, &grid.transform);
    push_topology(&mut bytes, tree, zip)?;
    output.write_all(&bytes)?;

    let blocks_at = output.stream_position()?;
    for leaf in tree.leaves() {
        bytes.clear();
        push_leaf(&mut bytes, leaf, tree.background, zip)?;
        output.write_all(&bytes)?;
    }
    let end_at = output.stream_position()?;
    output.seek(SeekFrom::Start(offsets_at))?;
    for offset in [grid_at, blocks_at, end_at] {
        output.write_all(&offset.to_le_bytes())?;
    }
    output.seek(SeekFrom::Start(end_at))?;
    Ok(())
}

fn grid_metadata<T: Value>(grid: &Grid, tree: &SparseTree<T>, zip: bool) -> Metadata {
    let mut metadata = Metadata::new();
    for (name, value) in grid.metadata.iter() {
        if !DERIVED.contains(&name) && name != "file_mem_bytes" && name != "file_delayed_load" {
            metadata.insert(name, value.clone());
        }
    }
    metadata.insert("class", grid.class.as_str());
    metadata.insert("name", grid.name.as_str());
    metadata.insert("is_saved_as_half_float", false);
    metadata.insert("file_compression", if zip { "zip + active values" } else { "active values" });
    metadata.insert("file_voxel_count", tree.active_voxel_count() as i64);
    let (min, max) = tree.active_bounds().unwrap_or(([0; 3], [0; 3]));
    metadata.insert("file_bbox_min", min);
    metadata.insert("file_bbox_max", max);
    let leaf_bytes = size_of::<Leaf<T>>() + LEAF_VOXELS * size_of::<T>();
    metadata.insert("file_mem_bytes", (tree.leaves().len() * leaf_bytes) as i64);
    metadata
}

fn push_string(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
}

fn push_metadata(bytes: &mut Vec<u8>, metadata: &Metadata) {
    bytes.extend((metadata.len() as u32).to_le_bytes());
    for (name, value) in metadata.iter() {
        let (type_name, value) = meta_bytes(value);
        push_string(bytes, name);
        push_string(bytes, type_name);
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    }
}

fn meta_bytes(value: &MetaValue) -> (&str, Vec<u8>) {
    fn numbers<T: Bytes>(values: &[T]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for &value in values {
            value.encode(&mut bytes);
        }
        bytes
    }
    match value {
        MetaValue::Bool(value) => ("bool", vec![u8::from(*value)]),
        MetaValue::Int32(value) => ("int32", value.to_le_bytes().to_vec()),
        MetaValue::Int64(value) => ("int64", value.to_le_bytes().to_vec()),
        MetaValue::Float(value) => ("float", value.to_le_bytes().to_vec()),
        MetaValue::Double(value) => ("double", value.to_le_bytes().to_vec()),
        MetaValue::String(value) => ("string", value.as_bytes().to_vec()),
        MetaValue::Vec3i(value) => ("vec3i", numbers(value)),
        MetaValue::Vec3s(value) => ("vec3s", numbers(value)),
        MetaValue::Vec3d(value) => ("vec3d", numbers(value)),
        MetaValue::Unknown { type_name, bytes } => (type_name, bytes.clone()),
    }
}

fn push_vec3d(bytes: &mut Vec<u8>, value: glam::DVec3) {
    value.to_array().into_iter().for_each(|axis| axis.encode(bytes));
}

/// The map that OpenVDB itself would choose: uniform scale, with a translation where there is one,
/// else the general affine map.
fn push_transform(bytes: &mut Vec<u8>, transform: &Transform) {
    let translation = transform.translation();
    let Some(size) = transform.uniform_voxel_size() else {
        push_string(bytes, "AffineMap");
        let axes = transform.linear().to_cols_array_2d();
        for (axis, last) in axes.into_iter().chain([translation.to_array()]).zip([0.0, 0.0, 0.0, 1.0]) {
            axis.into_iter().chain([last]).for_each(|value| value.encode(bytes));
        }
        return;
    };
    let moved = translation != glam::DVec3::ZERO;
    push_string(bytes, if moved { "UniformScaleTranslateMap" } else { "UniformScaleMap" });
    if moved {
        push_vec3d(bytes, translation);
    }
    let inverse = 1.0 / size;
    for value in [size, size, inverse, inverse * inverse, 0.5 * inverse] {
        push_vec3d(bytes, glam::DVec3::splat(value));
    }
}

/// A node of 16³ slots.
struct Lower<'a, T> {
    tiles: Vec<&'a Tile<T>>,
    leaves: Vec<&'a Leaf<T>>,
}

/// A node of 32³ slots by the slots of its children.
struct Upper<'a, T> {
    tiles: Vec<&'a Tile<T>>,
    lowers: BTreeMap<u32, Lower<'a, T>>,
}

fn nodes<T: Value>(tree: &SparseTree<T>) -> BTreeMap<[i32; 3], Upper<'_, T>> {
    let mut uppers = BTreeMap::new();
    let upper = || Upper { tiles: Vec::new(), lowers: BTreeMap::new() };
    let lower = || Lower { tiles: Vec::new(), leaves: Vec::new() };
    for leaf in tree.leaves() {
        let (root, slot, _) = tree_order(leaf.origin);
        let node = uppers.entry(root).or_insert_with(upper).lowers.entry(slot).or_insert_with(lower);
        node.leaves.push(leaf);
    }
    for tile in tree.tiles() {
        let (root, slot, _) = tree_order(tile.origin);
        match tile.level {
            TileLevel::Upper => {}
            TileLevel::Lower => uppers.entry(root).or_insert_with(upper).tiles.push(tile),
            TileLevel::Leaf => {
                let node = uppers.entry(root).or_insert_with(upper).lowers.entry(slot);
                node.or_insert_with(lower).tiles.push(tile);
            }
        }
    }
    uppers
}

fn push_topology<T: Value + Bytes>(
    bytes: &mut Vec<u8>,
    tree: &SparseTree<T>,
    zip: bool,
) -> Result<(), Error> {
    let uppers = nodes(tree);
    let root_tiles = || tree.tiles().iter().filter(|tile| tile.level == TileLevel::Upper);
    bytes.extend(1_i32.to_le_bytes());
    tree.background.encode(bytes);
    bytes.extend((root_tiles().count() as u32).to_le_bytes());
    bytes.extend((uppers.len() as u32).to_le_bytes());
    for tile in root_tiles() {
        tile.origin.into_iter().for_each(|axis| axis.encode(bytes));
        tile.value.encode(bytes);
        bytes.push(u8::from(tile.active));
    }
    for (root, upper) in &uppers {
        root.iter().for_each(|axis| (axis << 12).encode(bytes));
        let children = upper.lowers.keys().copied().collect::<Vec<_>>();
        let tiles = upper.tiles.iter().map(|tile| (tree_order(tile.origin).1, *tile));
        push_node(bytes, 32_768, &children, &tiles.collect::<Vec<_>>(), tree.background, zip)?;
        for lower in upper.lowers.values() {
            let slot = |origin| tree_order(origin).2;
            let children: Vec<u32> = lower.leaves.iter().map(|leaf| slot(leaf.origin)).collect();
            let tiles: Vec<_> = lower.tiles.iter().map(|tile| (slot(tile.origin), *tile)).collect();
            push_node(bytes, 4096, &children, &tiles, tree.background, zip)?;
            for leaf in &lower.leaves {
                leaf.mask.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
            }
        }
    }
    Ok(())
}

#[allow(clippy::too_many_arguments, reason = "the six things that a node is made of")]
fn push_node<T: Value + Bytes>(
    bytes: &mut Vec<u8>,
    n_slots: usize,
    children: &[u32],
    tiles: &[(u32, &Tile<T>)],
    background: T,
    zip: bool,
) -> Result<(), Error> {
    let mut child_mask = vec![0_u8; n_slots / 8];
    let mut value_mask = vec![0_u8; n_slots / 8];
    let mut values = vec![background; n_slots];
    let set = |mask: &mut [u8], slot: u32| mask[slot as usize >> 3] |= 1 << (slot & 7);
    for &slot in children {
        set(&mut child_mask, slot);
    }
    for (slot, tile) in tiles {
        values[*slot as usize] = tile.value;
        if tile.active {
            set(&mut value_mask, *slot);
        }
    }
    bytes.extend(&child_mask);
    bytes.extend(&value_mask);
    push_values(bytes, &value_mask, background, &values, zip)
}

fn push_leaf<T: Value + Bytes>(
    bytes: &mut Vec<u8>,
    leaf: &Leaf<T>,
    background: T,
    zip: bool,
) -> Result<(), Error> {
    let mask: Vec<u8> = leaf.mask.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.extend(&mask);
    if T::IS_BOOL {
        leaf.origin.into_iter().for_each(|axis| axis.encode(bytes));
        let mut bits = [0_u8; LEAF_VOXELS / 8];
        for (index, value) in leaf.values.iter().enumerate() {
            let is_set = !value.same_bytes(T::ZERO);
            bits[index >> 3] |= u8::from(is_set) << (index & 7);
        }
        bytes.extend(bits);
        return Ok(());
    }
    push_values(bytes, &mask, background, leaf.values.as_slice(), zip)
}

/// A value block: code 0 where all inactive values are the background, else 2 for one other value,
/// else 6 with everything.
fn push_values<T: Value + Bytes>(
    bytes: &mut Vec<u8>,
    mask: &[u8],
    background: T,
    values: &[T],
    zip: bool,
) -> Result<(), Error> {
    let is_active = |index: usize| mask[index >> 3] >> (index & 7) & 1 == 1;
    let mut inactive = values.iter().enumerate().filter(|(index, _)| !is_active(*index));
    let first = inactive.next().map_or(background, |(_, value)| *value);
    let uniform = inactive.all(|(_, value)| value.same_bytes(first));
    let mut stored = Vec::with_capacity(values.len() * T::SIZE);
    if uniform {
        let is_background = first.same_bytes(background);
        bytes.push(if is_background { 0 } else { 2 });
        if !is_background {
            first.encode(bytes);
        }
        let active = values.iter().enumerate().filter(|(index, _)| is_active(*index));
        active.for_each(|(_, value)| value.encode(&mut stored));
    } else {
        bytes.push(6);
        values.iter().for_each(|value| value.encode(&mut stored));
    }
    if !zip {
        bytes.extend(stored);
        return Ok(());
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(&stored)?;
    let packed = encoder.finish()?;
    if packed.len() < stored.len() {
        bytes.extend((packed.len() as i64).to_le_bytes());
        bytes.extend(packed);
    } else {
        bytes.extend((-(stored.len() as i64)).to_le_bytes());
        bytes.extend(stored);
    }
    Ok(())
}

/// FNV-1a over everything that the file says, twice from different starts, in the form of a UUID.
fn uuid(file: &VdbFile) -> String {
    let mut hash = Fnv::new();
    let mut bytes = Vec::new();
    push_metadata(&mut bytes, &file.metadata);
    for grid in &file.grids {
        push_string(&mut bytes, &grid.name);
        push_string(&mut bytes, &grid.class);
        push_metadata(&mut bytes, &grid.metadata);
        push_transform(&mut bytes, &grid.transform);
        hash.add(&bytes);
        bytes.clear();
        match &grid.tree {
            Tree::Float(tree) => hash.add_tree(tree),
            Tree::Double(tree) => hash.add_tree(tree),
            Tree::Vec3s(tree) => hash.add_tree(tree),
            Tree::Int32(tree) => hash.add_tree(tree),
            Tree::Bool(tree) => hash.add_tree(tree),
        }
    }
    hash.add(&bytes);
    let [a, b] = hash.0;
    let (a1, a2, a3) = (a >> 32, a >> 16 & 0xffff, a & 0xffff);
    format!("{a1:08x}-{a2:04x}-{a3:04x}-{:04x}-{:012x}", b >> 48, b & 0xffff_ffff_ffff)
}

struct Fnv([u64; 2]);

impl Fnv {
    fn new() -> Self {
        Self([0xcbf2_9ce4_8422_2325, 0x9ae1_6a3b_2f90_404f])
    }

    /// Eight bytes at a time: quick enough to be lost beside writing the file.
    fn add(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.add_word(u64::from_le_bytes(word) ^ (chunk.len() as u64) << 60);
        }
    }

    fn add_word(&mut self, word: u64) {
        for state in &mut self.0 {
            *state = (*state ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23);
        }
    }

    fn add_tree<T: Value + Bytes>(&mut self, tree: &SparseTree<T>) {
        let mut bytes = Vec::with_capacity(LEAF_VOXELS * T::SIZE);
        tree.background.encode(&mut bytes);
        for tile in tree.tiles() {
            tile.origin.into_iter().for_each(|axis| axis.encode(&mut bytes));
            tile.value.encode(&mut bytes);
            bytes.push(tile.level.dim().ilog2() as u8 * 2 + u8::from(tile.active));
        }
        self.add(&bytes);
        for leaf in tree.leaves() {
            bytes.clear();
            leaf.origin.into_iter().for_each(|axis| (axis / LEAF_DIM).encode(&mut bytes));
            leaf.mask.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
            leaf.values.iter().for_each(|value| value.encode(&mut bytes));
            self.add(&bytes);
        }
    }
}
