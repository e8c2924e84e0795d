//! Damaged files give an error or a file, never a panic, and never much memory.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use std::io::Cursor;

use common::BLOSC;
use common::Random;
use common::bytes;
use common::replaced;
use common::small_file;
use common::stream_with_instances;
use common::transform;
use niji_vdb::Compression;
use niji_vdb::Error;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;
use niji_vdb::edit_metadata;

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
        // A copy of every file would take most of the time.
        if n % 20 == 0 {
            let copied = edit_metadata(Cursor::new(&bytes), &[], Cursor::new(Vec::new()));
            assert_eq!(copied.is_ok(), headers_are_read);
        }
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
fn several_wrong_bytes_are_an_error_or_another_file() {
    let mut random = Random(4);
    for original in [zip(), mask_only(), BLOSC.to_vec()] {
        for _ in 0..2_000 {
            let mut bytes = original.clone();
            for _ in 0..=random.below(20) {
                let place = random.below(bytes.len());
                bytes[place] = random.next() as u8;
            }
            let _ = VdbFile::parse(&bytes);
        }
    }
    assert_memory_is_bounded();
}

#[test]
fn a_file_that_ends_too_early_is_an_error_at_every_length() {
    for bytes in [zip(), mask_only(), BLOSC.to_vec()] {
        for length in 0..bytes.len() {
            let error = VdbFile::parse(&bytes[..length]).unwrap_err();
            let error = match error {
                Error::InGrid { reason, .. } => *reason,
                other => other,
            };
            assert!(
                matches!(error, Error::Truncated { .. }),
                "at {length}: {error}"
            );
        }
    }
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
fn a_zip_stream_with_a_wrong_checksum_is_refused() {
    let bytes = zip();
    // The last leaf holds one value, stored as it is; before its masks and lengths ends the stream.
    let last_leaf = bytes.len() - (64 + 1 + 8 + 4);
    for checksum_byte in last_leaf - 4..last_leaf {
        let mut damaged = bytes.clone();
        damaged[checksum_byte] ^= 1;
        let error = VdbFile::parse(&damaged).unwrap_err();
        assert!(
            error.to_string().contains("a zlib stream is not sound"),
            "{error}"
        );
    }
}

#[test]
fn other_files_are_named_for_what_they_are() {
    let error = VdbFile::parse(b"NOTAVDB! and more").unwrap_err();
    assert!(matches!(error, Error::NotVdb { .. }), "{error}");
    for version in [0_u8, 221, 226] {
        let mut bytes = mask_only();
        bytes[8] = version;
        let error = VdbFile::parse(&bytes).unwrap_err();
        assert!(matches!(error, Error::Version { found, .. } if found == u32::from(version)));
    }
    for version in 222..=225 {
        let mut bytes = mask_only();
        bytes[8] = version;
        assert!(VdbFile::parse(&bytes).is_ok());
    }
}

#[test]
fn what_is_not_supported_is_named_with_its_grid() {
    let bytes = mask_only();
    let points = replaced(&bytes, b"Tree_float_5_4_3", b"Tree_ptdta_5_4_3");
    let error = VdbFile::parse(&points).unwrap_err().to_string();
    assert!(
        error.starts_with("grid `density`: grid type `Tree_ptdta_5_4_3` is not"),
        "{error}"
    );
    let frustum = replaced(
        &bytes,
        b"UniformScaleTranslateMap",
        b"NonlinearFrustumMapAbcde",
    );
    let error = VdbFile::parse(&frustum).unwrap_err().to_string();
    assert!(
        error.starts_with("grid `density`: map `NonlinearFrustumMapAbcde` is not"),
        "{error}"
    );
    let scale = transform().voxel_size().x.to_le_bytes();
    let flat = replaced(&bytes, &scale, &0_f64.to_le_bytes());
    let error = VdbFile::parse(&flat).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("grid `density`: the transform"),
        "{error}"
    );
}

#[test]
fn offsets_that_lead_back_are_refused() {
    let original = mask_only();
    let mut bytes = original.clone();
    // The descriptor of the first grid ends where its compression word, 2, stands.
    let name = b"Tree_float_5_4_3\0\0\0\0";
    let offsets = bytes
        .windows(name.len())
        .position(|window| window == name)
        .unwrap()
        + name.len();
    for place in [offsets, offsets + 8, offsets + 16] {
        for target in [0_i64, -1, i64::MIN, i64::MAX, original.len() as i64 + 1] {
            bytes[place..place + 8].copy_from_slice(&target.to_le_bytes());
            assert!(VdbFile::parse(&bytes).is_err(), "offset {target}");
        }
        bytes[place..place + 8].copy_from_slice(&original[place..place + 8]);
    }
}

#[test]
fn the_file_with_most_memory_for_its_length_is_read() {
    // All 32³ slots of a node are inactive tiles of minus the background: one byte for all.
    let background = [1.0_f32; 3];
    let tile = |slot: i32| Tile {
        origin: [slot >> 10, slot >> 5 & 31, slot & 31].map(|axis| 128 * axis),
        level: TileLevel::Lower,
        active: false,
        value: [-1.0; 3],
    };
    let tiles = (0..1 << 15).map(tile).collect();
    let tree = niji_vdb::SparseTree::from_parts(background, vec![], tiles).unwrap();
    let file = VdbFile::new(vec![Grid::new("full", "unknown", transform(), tree)]);
    let bytes = bytes(&file, Compression::None);
    assert!(bytes.len() < 9_000);
    assert_eq!(
        VdbFile::parse(&bytes).unwrap().grids[0].tree,
        file.grids[0].tree
    );
}

#[test]
fn instances_share_the_tree_of_an_earlier_grid() {
    let file = VdbFile::parse(&stream_with_instances(&mask_only(), 3, "density")).unwrap();
    assert_eq!(file.grids.len(), 4);
    assert_eq!(file.grids[3].tree, common::small_tree().into());
    let error = VdbFile::parse(&stream_with_instances(&mask_only(), 1, "other")).unwrap_err();
    assert!(
        error.to_string().contains("an instance of `other`"),
        "{error}"
    );
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
