//! What several tests share: files to write, their bytes, and a random number generator.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(dead_code, reason = "each test uses its part")]

use std::io::Cursor;

use glam::DVec3;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

/// A file that OpenVDB wrote with Blosc; `data/README.md` says what it holds.
pub(crate) const BLOSC: &[u8] = include_bytes!("../data/blosc.vdb");

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): a sequence that is the same everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

pub(crate) fn bytes(file: &VdbFile, compression: Compression) -> Vec<u8> {
    let mut output = Cursor::new(Vec::new());
    file.write(&mut output, compression).unwrap();
    output.into_inner()
}

pub(crate) fn transform() -> Transform {
    Transform::uniform_scale_translate(0.1, DVec3::new(-20.5, 0.05, 1e4))
}

/// Three leaves under one node, smooth so that they shrink: full, half full, one voxel.
pub(crate) fn small_tree() -> FloatTree {
    let leaf = |(place, origin): (usize, [i32; 3])| {
        let mut leaf = Leaf::new(origin, 0.0);
        let step = [1, 2, LEAF_VOXELS][place];
        for index in (0..LEAF_VOXELS).step_by(step) {
            leaf.set(leaf.voxel(index), 1.0 + (index / 8) as f32);
        }
        leaf
    };
    let origins = [[8, 16, 24], [16, 16, 24], [8, 72, 24]];
    let leaves = origins.into_iter().enumerate().map(leaf).collect();
    FloatTree::from_leaves(0.0, leaves).unwrap()
}

pub(crate) fn small_file() -> VdbFile {
    let mut file = VdbFile::new(vec![Grid::new(
        "density",
        FOG_VOLUME,
        transform(),
        small_tree(),
    )]);
    file.metadata.insert("comment", "a small file");
    file.grids[0].metadata.insert("unit", "1/m");
    file
}

/// Replace the first place where `from` stands.
pub(crate) fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let place = bytes
        .windows(from.len())
        .position(|window| window == from)
        .unwrap();
    [&bytes[..place], to, &bytes[place + from.len()..]].concat()
}

/// A file without offsets, with copies behind its one grid that share the tree of `parent`.
pub(crate) fn stream_with_instances(original: &[u8], n_instances: u32, parent: &str) -> Vec<u8> {
    let place = |of: &[u8]| {
        original
            .windows(of.len())
            .position(|window| window == of)
            .unwrap()
    };
    let type_name = b"Tree_float_5_4_3\0\0\0\0";
    let type_place = place(type_name);
    let map_name = b"UniformScaleTranslateMap";
    let map_end = place(map_name) + map_name.len() + 18 * 8;
    let head = &original[type_place + type_name.len() + 24..map_end];
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let mut file = original.to_vec();
    // The flag for offsets stands before the UUID, the number of grids before the first name.
    file[20] = 0;
    let count_place = type_place - 4 - "density".len() - 4 - 4;
    file[count_place..count_place + 4].copy_from_slice(&(n_instances + 1).to_le_bytes());
    for _ in 0..n_instances {
        file.extend([text("copy"), text("Tree_float_5_4_3"), text(parent)].concat());
        file.extend([0; 24]);
        file.extend_from_slice(head);
    }
    file
}
