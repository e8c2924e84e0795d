//! Writing a file of version 224 (225 if it has grids of halves): header, then grid after grid, as `read.rs` describes them.
//!
//! The UUID is a hash of the content (RFC 9562, version 8), not a random number, so that the same
//! content gives the same bytes.

use std::collections::HashMap;
use std::collections::HashSet;
use std::io::Seek;
use std::io::Write;

use crate::Compression;
use crate::Error;
use crate::Grid;
use crate::Metadata;
use crate::SparseTree;
use crate::Tree;
use crate::Value;
use crate::VdbFile;
use crate::decode::FLAG_ACTIVE_MASK;
use crate::decode::FLAG_ZIP;
use crate::encode::Encoder;
use crate::items;
use crate::maps;
use crate::output::Output;
use crate::output::push_text;
use crate::read::MAGIC;
use crate::read::NAME_SEPARATOR;
use crate::read::UUID_LENGTH;
use crate::write_tree;

/// The version that OpenVDB 5 to 12 write, and that of the library that the header then names.
const VERSION: [u32; 3] = [224, 10, 0];

/// The version that has grids of halves, and the first library that wrote it.
const VERSION_WITH_HALVES: [u32; 3] = [225, 13, 0];

/// Items that follow from the grid or from the way it is stored.
pub(crate) const DERIVED_ITEMS: [&str; 9] = [
    "class",
    "name",
    "file_bbox_max",
    "file_bbox_min",
    "file_compression",
    "file_delayed_load",
    "file_mem_bytes",
    "file_voxel_count",
    "is_saved_as_half_float",
];

/// Write a file.
pub(crate) fn file<W: Write + Seek>(
    file: &VdbFile,
    sink: W,
    compression: Compression,
) -> Result<(), Error> {
    let mut output = Output::new(sink)?;
    let has_halves = |grid: &Grid| matches!(grid.tree, Tree::Half(_));
    let version = if file.grids.iter().any(has_halves) {
        VERSION_WITH_HALVES
    } else {
        VERSION
    };
    output.append(|bytes| {
        bytes.extend_from_slice(&MAGIC.to_le_bytes());
        for part in version {
            bytes.extend_from_slice(&part.to_le_bytes());
        }
        // Grid offsets are present.
        bytes.push(1);
    })?;
    let uuid_position = output.position();
    output.append(|bytes| {
        bytes.extend_from_slice(&[0; UUID_LENGTH]);
        items::push(bytes, &file.metadata);
        bytes.extend_from_slice(&(file.grids.len() as u32).to_le_bytes());
    })?;
    let mut encoder = Encoder::new(compression);
    for (grid, unique_name) in file.grids.iter().zip(unique_names(&file.grids)) {
        let mut writer = GridWriter {
            output: &mut output,
            encoder: &mut encoder,
            compression,
        };
        match &grid.tree {
            Tree::Float(tree) => writer.grid(grid, &unique_name, tree)?,
            Tree::Double(tree) => writer.grid(grid, &unique_name, tree)?,
            Tree::Half(tree) => writer.grid(grid, &unique_name, tree)?,
            Tree::Vec3s(tree) => writer.grid(grid, &unique_name, tree)?,
            Tree::Int32(tree) => writer.grid(grid, &unique_name, tree)?,
            Tree::Bool(tree) => writer.grid(grid, &unique_name, tree)?,
        }
    }
    output.finish(uuid_position, uuid)
}

/// Names with a number behind those that occur more than once or are empty, as OpenVDB has them.
fn unique_names(grids: &[Grid]) -> Vec<String> {
    let mut n_grids = HashMap::new();
    for grid in grids {
        *n_grids.entry(grid.name.as_str()).or_insert(0) += 1;
    }
    let mut taken = HashSet::new();
    let mut unique_name = |grid: &Grid| {
        let name = &grid.name;
        let plain = (!name.is_empty() && n_grids[name.as_str()] == 1).then(|| name.clone());
        let numbered = (0..).map(|number| format!("{name}{NAME_SEPARATOR}{number}"));
        let free = plain
            .into_iter()
            .chain(numbered)
            .find(|name| !taken.contains(name));
        let free = free.expect("there are more numbers than grids");
        taken.insert(free.clone());
        free
    };
    grids.iter().map(&mut unique_name).collect()
}

/// The first 16 bytes of a hash, with the bits that mark a UUID of version 8.
pub(crate) fn uuid(hash: &[u8; 32]) -> String {
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&hash[..16]);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex = bytes.map(|byte| format!("{byte:02x}")).concat();
    [
        &hex[..8],
        &hex[8..12],
        &hex[12..16],
        &hex[16..20],
        &hex[20..],
    ]
    .join("-")
}

/// Writes one grid.
struct GridWriter<'a, W> {
    output: &'a mut Output<W>,
    encoder: &'a mut Encoder,
    compression: Compression,
}

impl<W: Write + Seek> GridWriter<'_, W> {
    fn grid<T: Value>(
        &mut self,
        grid: &Grid,
        unique_name: &str,
        tree: &SparseTree<T>,
    ) -> Result<(), Error> {
        self.output.append(|bytes| {
            push_text(bytes, unique_name);
            push_text(bytes, &format!("Tree_{}_5_4_3", T::TYPE_NAME));
            // No grid whose tree this one shares.
            push_text(bytes, "");
        })?;
        let offsets_position = self.output.position();
        self.output
            .append(|bytes| bytes.extend_from_slice(&[0; 24]))?;
        let grid_position = self.output.position();
        let (flags, compression) = match self.compression {
            Compression::None => (FLAG_ACTIVE_MASK, "active values"),
            Compression::Zip => (FLAG_ACTIVE_MASK | FLAG_ZIP, "zip + active values"),
        };
        let metadata = grid_metadata(grid, tree, compression);
        self.output.append(|bytes| {
            bytes.extend_from_slice(&flags.to_le_bytes());
            items::push(bytes, &metadata);
            maps::push(bytes, &grid.transform);
        })?;
        write_tree::topology(self.output, self.encoder, tree)?;
        let leaves_position = self.output.position();
        write_tree::leaves(self.output, self.encoder, tree)?;
        let positions = [grid_position, leaves_position, self.output.position()];
        let offsets = positions.map(u64::to_le_bytes).concat();
        self.output.patch(offsets_position, offsets);
        Ok(())
    }
}

/// The items of a grid, with those that OpenVDB derives.
fn grid_metadata<T: Value>(grid: &Grid, tree: &SparseTree<T>, compression: &str) -> Metadata {
    let mut metadata = grid.metadata.clone();
    for name in DERIVED_ITEMS {
        metadata.remove(name);
    }
    // OpenVDB's box around nothing: its lowest corner lies above its highest.
    let bounds = tree
        .active_bounds()
        .unwrap_or(([i32::MAX; 3], [i32::MIN; 3]));
    metadata.insert("class", grid.class.as_str());
    metadata.insert("name", grid.name.as_str());
    metadata.insert("file_bbox_min", bounds.0);
    metadata.insert("file_bbox_max", bounds.1);
    metadata.insert("file_compression", compression);
    metadata.insert("file_mem_bytes", tree.memory() as i64);
    metadata.insert("file_voxel_count", tree.active_voxel_count() as i64);
    metadata.insert("is_saved_as_half_float", false);
    metadata
}
