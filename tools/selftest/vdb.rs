//! Hard cases of OpenVDB files: truncated, corrupted, of other programs and versions, with offsets
//! that lead back and instances of other grids.

use niji_vdb::Compression;
use niji_vdb::Error;
use niji_vdb::Grid;
use niji_vdb::SparseTree;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::VdbFile;

use crate::selftest::hard_case::HardCase;
use crate::selftest::hard_case::Random;
use crate::selftest::hard_case::violations;

// The files of the library's tests; a panic fails the case.
#[path = "../../crates/vdb/tests/common/mod.rs"]
mod files;

use files::BLOSC;
use files::bytes;
use files::replaced;
use files::small_file;
use files::small_tree;
use files::stream_with_instances;
use files::transform;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "a file that ends too early is an error at every length",
        measure: "lengths without the error",
        allowed: 0.0,
        error: truncated,
    },
    HardCase {
        claim: "up to 20 wrong bytes are an error or another file, never a panic",
        measure: "6000 files without an answer",
        allowed: 0.0,
        error: corrupted,
    },
    HardCase {
        claim: "a zip stream with a wrong checksum is refused",
        measure: "accepted files",
        allowed: 0.0,
        error: wrong_checksum,
    },
    HardCase {
        claim: "other files, and versions beyond 222 to 225, are named",
        measure: "files without the error",
        allowed: 0.0,
        error: other_files,
    },
    HardCase {
        claim: "grids and maps of other kinds are named with their grid",
        measure: "files without the error",
        allowed: 0.0,
        error: unsupported,
    },
    HardCase {
        claim: "offsets that lead back or out of the file are refused",
        measure: "accepted files of 15",
        allowed: 0.0,
        error: wrong_offsets,
    },
    HardCase {
        claim: "9 kB that hold 32768 tiles come back whole",
        measure: "trees that differ",
        allowed: 0.0,
        error: most_memory,
    },
    HardCase {
        claim: "instances share the tree of an earlier grid and of no other",
        measure: "files with the wrong answer",
        allowed: 0.0,
        error: instances,
    },
];

fn zip() -> Vec<u8> {
    bytes(&small_file(), Compression::Zip)
}

fn mask_only() -> Vec<u8> {
    bytes(&small_file(), Compression::None)
}

fn originals() -> [Vec<u8>; 3] {
    [zip(), mask_only(), BLOSC.to_vec()]
}

/// The message of a file that is refused, empty of one that is not.
fn message(bytes: &[u8]) -> String {
    VdbFile::parse(bytes).map_or_else(|error| error.to_string(), |_| String::new())
}

fn truncated() -> f64 {
    let n_violations = originals().map(|whole| {
        violations(
            (0..whole.len()).map(|length| match VdbFile::parse(&whole[..length]) {
                Err(Error::InGrid { reason, .. }) => matches!(*reason, Error::Truncated { .. }),
                Err(error) => matches!(error, Error::Truncated { .. }),
                Ok(_) => false,
            }),
        )
    });
    n_violations.into_iter().sum()
}

fn corrupted() -> f64 {
    let mut random = Random(4);
    for original in originals() {
        for _ in 0..2_000 {
            let mut bytes = original.clone();
            for _ in 0..=random.below(20) {
                let place = random.below(bytes.len());
                bytes[place] = random.below(256) as u8;
            }
            let _ = VdbFile::parse(&bytes);
        }
    }
    0.0
}

fn wrong_checksum() -> f64 {
    let bytes = zip();
    // The last leaf holds one value, stored as it is; before its masks and lengths ends the stream.
    let last_leaf = bytes.len() - (64 + 1 + 8 + 4);
    violations((last_leaf - 4..last_leaf).map(|checksum_byte| {
        let mut damaged = bytes.clone();
        damaged[checksum_byte] ^= 1;
        message(&damaged).contains("a zlib stream is not sound")
    }))
}

fn other_files() -> f64 {
    let is_foreign = matches!(
        VdbFile::parse(b"NOTAVDB! and more"),
        Err(Error::NotVdb { .. })
    );
    let of_version = |version: u8| {
        let mut bytes = mask_only();
        bytes[8] = version;
        VdbFile::parse(&bytes)
    };
    let refused = [0_u8, 221, 226].map(|version| {
        matches!(of_version(version), Err(Error::Version { found, .. }) if found == u32::from(version))
    });
    violations([is_foreign])
        + violations(refused)
        + violations((222..=225).map(|version| of_version(version).is_ok()))
}

fn unsupported() -> f64 {
    let bytes = mask_only();
    let scale = transform().voxel_size().x.to_le_bytes();
    let files = [
        (
            replaced(&bytes, b"Tree_float_5_4_3", b"Tree_ptdta_5_4_3"),
            "grid `density`: grid type `Tree_ptdta_5_4_3` is not",
        ),
        (
            replaced(
                &bytes,
                b"UniformScaleTranslateMap",
                b"NonlinearFrustumMapAbcde",
            ),
            "grid `density`: map `NonlinearFrustumMapAbcde` is not",
        ),
        (
            replaced(&bytes, &scale, &0_f64.to_le_bytes()),
            "grid `density`: the transform",
        ),
    ];
    violations(files.map(|(bytes, start)| message(&bytes).starts_with(start)))
}

fn wrong_offsets() -> f64 {
    let original = mask_only();
    // The descriptor of the first grid ends where its compression word, 2, stands.
    let name = b"Tree_float_5_4_3\0\0\0\0";
    let mut windows = original.windows(name.len());
    let start = windows.position(|window| window == name);
    let offsets = start.expect("the file has a float grid") + name.len();
    let places = [offsets, offsets + 8, offsets + 16].into_iter();
    violations(places.flat_map(|place| {
        [0, -1, i64::MIN, i64::MAX, original.len() as i64 + 1].map(|target| {
            let mut bytes = original.clone();
            bytes[place..place + 8].copy_from_slice(&target.to_le_bytes());
            VdbFile::parse(&bytes).is_err()
        })
    }))
}

fn most_memory() -> f64 {
    // All 32^3 slots of a node are inactive tiles of minus the background: one byte for all.
    let tile = |slot: i32| Tile {
        origin: [slot >> 10, slot >> 5 & 31, slot & 31].map(|axis| 128 * axis),
        level: TileLevel::Lower,
        active: false,
        value: [-1.0; 3],
    };
    let tiles = (0..1 << 15).map(tile).collect();
    let tree = SparseTree::from_parts([1.0_f32; 3], vec![], tiles).expect("distinct tiles");
    let file = VdbFile::new(vec![Grid::new("full", "unknown", transform(), tree)]);
    let bytes = bytes(&file, Compression::None);
    let again = VdbFile::parse(&bytes).expect("the file was just written");
    violations([
        bytes.len() < 9_000,
        again.grids[0].tree == file.grids[0].tree,
    ])
}

fn instances() -> f64 {
    let of_small = |n, parent| stream_with_instances(&mask_only(), n, parent);
    let shared = VdbFile::parse(&of_small(3, "density"))
        .is_ok_and(|file| file.grids.len() == 4 && file.grids[3].tree == small_tree().into());
    let orphan = message(&of_small(1, "other")).contains("an instance of `other`");
    violations([shared, orphan])
}
