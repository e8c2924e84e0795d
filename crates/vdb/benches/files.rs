//! Reading and writing of files in memory.
//!
//! `cargo bench -p niji-vdb`. Printed beside the times: the length of each file against its voxels,
//! and whether it comes back. The comparison with OpenVDB, through files on disc, is
//! `tests/peers/vdb_speed.py`.

use std::io::Cursor;
use std::sync::LazyLock;

use divan::Bencher;
use divan::counter::BytesCount;
use glam::DVec3;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

const COMPRESSIONS: [Compression; 2] = [Compression::None, Compression::Zip];

/// Leaves along an edge of the volume.
const N_LEAVES: i32 = 20;

/// 8000 leaves, 16 MB of smooth values with noise in their last bits.
static FILE: LazyLock<VdbFile> = LazyLock::new(|| {
    let leaf = |n: i32| {
        let place = [
            n / (N_LEAVES * N_LEAVES),
            n / N_LEAVES % N_LEAVES,
            n % N_LEAVES,
        ];
        let mut leaf = Leaf::new(place.map(|axis| 8 * axis), 0.0);
        for index in 0..LEAF_VOXELS {
            let [x, y, z] = leaf.voxel(index).map(|axis| axis as f32);
            let noise = (12.9898 * x + 78.233 * y + 37.719 * z).sin();
            leaf.set(leaf.voxel(index), 1.0 + 0.01 * x + 1e-4 * noise);
        }
        leaf
    };
    let leaves = (0..N_LEAVES.pow(3)).map(leaf).collect();
    let tree = FloatTree::from_leaves(0.0, leaves).expect("leaves apart");
    let transform = Transform::uniform_scale_translate(0.1, DVec3::ZERO);
    VdbFile::new(vec![Grid::new("density", FOG_VOLUME, transform, tree)])
});

/// The file in either compression.
static WRITTEN: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| COMPRESSIONS.map(written));

fn main() {
    for (compression, bytes) in COMPRESSIONS.iter().zip(WRITTEN.iter()) {
        let length = bytes.len() as f64 / n_voxel_bytes() as f64;
        let same =
            VdbFile::parse(bytes).is_ok_and(|again| again.grids[0].tree == FILE.grids[0].tree);
        println!("{compression:?}: {length:.3} bytes a byte of voxels, comes back: {same}");
    }
    divan::main();
}

fn n_voxel_bytes() -> usize {
    N_LEAVES.pow(3) as usize * LEAF_VOXELS * size_of::<f32>()
}

fn written(compression: Compression) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    FILE.write(&mut bytes, compression)
        .expect("memory takes everything");
    bytes.into_inner()
}

#[divan::bench(args = COMPRESSIONS)]
fn read(bencher: Bencher, compression: Compression) {
    let bytes = &WRITTEN[usize::from(compression == Compression::Zip)];
    bencher
        .counter(BytesCount::new(n_voxel_bytes()))
        .bench_local(|| VdbFile::parse(bytes));
}

#[divan::bench(args = COMPRESSIONS)]
fn read_header(bencher: Bencher, compression: Compression) {
    let bytes = &WRITTEN[usize::from(compression == Compression::Zip)];
    bencher.bench_local(|| VdbHeader::parse(bytes));
}

#[divan::bench(args = COMPRESSIONS)]
fn write(bencher: Bencher, compression: Compression) {
    bencher
        .counter(BytesCount::new(n_voxel_bytes()))
        .bench_local(|| written(compression));
}
