//! Damaged files give an error or a file, never a panic, and never much memory.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use common::BLOSC;
use common::Random;
use common::bytes;
use common::small_file;
use common::stream_with_instances;
use common::transform;
use niji_vdb::Compression;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

const N_CORRUPTIONS: usize = 20_000;
const N_HEADER_CORRUPTIONS: usize = 2_000;

/// The header, the first descriptor, the metadata and the map of each of the files.
const HEADER_BYTES: usize = 800;

/// Peak memory of this whole process in bytes, all tests together. Most is needed by the 0.55 MB file
/// of a thousand instances, for which the reader allows itself 256 bytes a byte, 141 MiB; the other
/// files have 20 kB and so 6 MiB each. Measured: 177 MiB in all. A single allocation from an
/// unchecked count of 32 bits would be gigabytes.
const PEAK_MEMORY: u64 = 256 << 20;

fn zip() -> Vec<u8> {
    bytes(&small_file(), Compression::Zip)
}

fn mask_only() -> Vec<u8> {
    bytes(&small_file(), Compression::None)
}

#[cfg(target_os = "linux")]
fn assert_memory_is_bounded() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap();
    let kilobytes = peak.trim().trim_end_matches(" kB").parse::<u64>().unwrap();
    assert!(kilobytes << 10 < PEAK_MEMORY, "a peak of {kilobytes} kB");
}

#[cfg(not(target_os = "linux"))]
fn assert_memory_is_bounded() {}

/// Change single bytes; says how often the file could still be read.
fn corrupt(bytes: &[u8], seed: u64) -> usize {
    let mut random = Random(seed);
    let mut bytes = bytes.to_vec();
    let mut n_read = 0;
    for n in 0..N_CORRUPTIONS + N_HEADER_CORRUPTIONS {
        let reach = if n < N_CORRUPTIONS {
            bytes.len()
        } else {
            HEADER_BYTES.min(bytes.len())
        };
        let place = random.below(reach);
        let was = bytes[place];
        bytes[place] ^= 1 + random.below(255) as u8;
        let is_read = VdbFile::parse(&bytes).is_ok();
        let headers_are_read = VdbHeader::parse(&bytes).is_ok();
        assert!(headers_are_read || !is_read, "a grid without a header");
        n_read += usize::from(is_read);
        bytes[place] = was;
    }
    assert_memory_is_bounded();
    n_read
}

#[test]
fn single_wrong_bytes_in_a_zip_file_are_an_error_or_another_file() {
    let n_read = corrupt(&zip(), 1);
    assert!(n_read > 0 && n_read < N_CORRUPTIONS, "{n_read}");
}

#[test]
fn single_wrong_bytes_in_a_blosc_file_are_an_error_or_another_file() {
    let n_read = corrupt(BLOSC, 2);
    assert!(n_read > 0 && n_read < N_CORRUPTIONS, "{n_read}");
}

#[test]
fn single_wrong_bytes_in_a_mask_only_file_are_an_error_or_another_file() {
    let n_read = corrupt(&mask_only(), 3);
    assert!(n_read > 0 && n_read < N_CORRUPTIONS, "{n_read}");
}

#[test]
fn huge_counts_and_lengths_are_refused_without_being_allocated() {
    let original = mask_only();
    // Every 32 bits of the header in turn become the largest counts, signed and unsigned.
    for place in 0..HEADER_BYTES {
        for huge in [u32::MAX, i32::MAX as u32, 1 << 30] {
            let mut bytes = original.clone();
            bytes[place..place + 4].copy_from_slice(&huge.to_le_bytes());
            let _ = VdbFile::parse(&bytes);
        }
    }
    assert_memory_is_bounded();
}

#[test]
fn instances_cannot_multiply_a_tree_without_end() {
    let leaf = |n: i32| {
        let mut leaf = Leaf::new([8 * (n & 15), 8 * (n >> 4 & 15), 8 * (n >> 8)], 0.0);
        leaf.set(leaf.voxel(0), 1.0);
        leaf
    };
    let tree = FloatTree::from_leaves(0.0, (0..1000).map(leaf).collect()).unwrap();
    let file = VdbFile::new(vec![Grid::new("density", "unknown", transform(), tree)]);
    let original = bytes(&file, Compression::None);
    assert!(VdbFile::parse(&stream_with_instances(&original, 3, "density")).is_ok());
    let error = VdbFile::parse(&stream_with_instances(&original, 1000, "density")).unwrap_err();
    assert!(
        error.to_string().contains("decoding needs more than"),
        "{error}"
    );
    assert_memory_is_bounded();
}
