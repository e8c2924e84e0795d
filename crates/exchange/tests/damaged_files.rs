//! Damaged files end in an error: never in a panic, an abort, or silently other values.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use ndarray::Array2;
use ndarray::Array3;
use niji_exchange::Aov;
use niji_exchange::Attributes;
use niji_exchange::Axis;
use niji_exchange::Channel;
use niji_exchange::Error;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_exchange::read_provenance;
use niji_radiometry::WavelengthGrid;

const N_CORRUPTIONS: usize = 2000;
const N_HEADER_CORRUPTIONS: usize = 1000;
const N_TRUNCATIONS: usize = 200;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

fn wave(y: usize, x: usize) -> f32 {
    (0.1 * y as f32).sin() + (0.07 * x as f32).cos() + 2.0
}

fn provenance() -> Provenance {
    let (tool, version) = ("niji test".to_owned(), "0".to_owned());
    Provenance {
        tool,
        version,
        settings: "{}".to_owned(),
        inputs: BTreeMap::new(),
    }
}

fn table() -> TableFile {
    let channel = |name: &str| Channel {
        name: name.to_owned(),
        values: Array2::from_shape_fn((8, 40), |(y, x)| wave(y, x)),
    };
    let part = |name: &str| TablePart {
        name: name.to_owned(),
        column_axis: Axis::new("z", "-", (0..40).map(f64::from).collect()),
        row_axes: vec![Axis::new("h", "m", (0..8).map(f64::from).collect())],
        channels: vec![channel("a"), channel("b")],
        attributes: Attributes::new(),
    };
    let parts = vec![part("one"), part("two")];
    TableFile {
        quantity: "test".to_owned(),
        parts,
        provenance: provenance(),
    }
}

fn image() -> SpectralImage {
    let (height, width) = (40, 30);
    SpectralImage {
        wavelengths: WavelengthGrid::new(400.0, 50.0, 7).unwrap(),
        radiance: Array3::from_shape_fn((7, height, width), |(l, y, x)| wave(y + l, x)),
        windows: ImageWindows::whole(width, height),
        aovs: vec![Aov {
            name: "depth".to_owned(),
            unit: "m".to_owned(),
            channels: vec![("Z".to_owned(), Array2::ones((height, width)))],
        }],
        white_luminance_cd_m2: 1e4,
        world_to_camera: None,
        attributes: Attributes::new(),
        provenance: provenance(),
    }
}

fn table_bytes() -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    table().write(&mut cursor).unwrap();
    cursor.into_inner()
}

fn image_bytes() -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    image().write_spectral(&mut cursor).unwrap();
    cursor.into_inner()
}

/// `Ok(true)` where the content is the one that was written.
fn read_table(path: &Path) -> Result<bool, Error> {
    read_provenance(path)?;
    let mut found = TableFile::read(path)?;
    for part in &mut found.parts {
        // Where the damage hit the name of the checksum, or of an attribute that holds no content.
        part.attributes.clear();
    }
    Ok(found == table())
}

fn read_image(path: &Path) -> Result<bool, Error> {
    read_provenance(path)?;
    let found = SpectralImage::read_spectral(path)?;
    Ok(found.radiance == image().radiance && found.wavelengths == image().wavelengths)
}

/// How many of `n` corrupted files were read without an error and with other content.
fn unnoticed(
    n: usize,
    original: &[u8],
    read: impl Fn(&Path) -> Result<bool, Error> + Sync,
    corrupt: impl Fn(&mut Random, &mut [u8]) + Sync,
) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.exr");
    let mut random = Random(20_240_607);
    // Threads cost more than they save on small files.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    pool.install(|| {
        let is_unnoticed = |_: &usize| {
            let mut bytes = original.to_vec();
            corrupt(&mut random, &mut bytes);
            fs::write(&path, &bytes).unwrap();
            matches!(read(&path), Ok(false))
        };
        (0..n).filter(is_unnoticed).count()
    })
}

fn any_byte(random: &mut Random, bytes: &mut [u8]) {
    let at = random.below(bytes.len());
    bytes[at] ^= 1 + random.below(255) as u8;
}

fn header_byte(random: &mut Random, bytes: &mut [u8]) {
    let at = random.below(1500.min(bytes.len()));
    bytes[at] = random.below(256) as u8;
}

/// Four bytes at once: sizes and counts of any magnitude and sign.
fn header_number(random: &mut Random, bytes: &mut [u8]) {
    let at = random.below(1500.min(bytes.len() - 4));
    let number = (random.below(1 << 32) as u32) >> random.below(32);
    let number = if random.below(4) == 0 {
        number.wrapping_neg()
    } else {
        number
    };
    bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
}

fn truncations(original: &[u8], read: impl Fn(&Path) -> Result<bool, Error>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.exr");
    for index in 0..N_TRUNCATIONS {
        fs::write(&path, &original[..original.len() * index / N_TRUNCATIONS]).unwrap();
        let error = read(&path).expect_err("a truncated file is no file");
        let expected = matches!(error, Error::Damaged(_) | Error::TooLarge { .. });
        assert!(expected, "{error}");
    }
    fs::write(&path, original).unwrap();
    assert!(read(&path).unwrap());
}

/// Position behind the name and kind of an attribute and the length of its value.
fn value_of(bytes: &[u8], name_and_kind: &[u8]) -> usize {
    let length = name_and_kind.len();
    bytes
        .windows(length)
        .position(|window| window == name_and_kind)
        .unwrap()
        + length
        + 4
}

#[test]
fn truncated_files_are_errors_at_every_length() {
    truncations(&table_bytes(), read_table);
    truncations(&image_bytes(), read_image);
}

#[test]
fn a_changed_byte_anywhere_never_changes_a_table_unnoticed() {
    assert_eq!(
        unnoticed(N_CORRUPTIONS, &table_bytes(), read_table, any_byte),
        0
    );
}

#[test]
fn a_changed_byte_anywhere_never_changes_an_image_unnoticed() {
    assert_eq!(
        unnoticed(N_CORRUPTIONS, &image_bytes(), read_image, any_byte),
        0
    );
}

#[test]
fn damaged_headers_are_errors_or_harmless() {
    for corrupt in [header_byte, header_number] {
        assert_eq!(
            unnoticed(N_HEADER_CORRUPTIONS, &table_bytes(), read_table, corrupt),
            0
        );
        assert_eq!(
            unnoticed(N_HEADER_CORRUPTIONS, &image_bytes(), read_image, corrupt),
            0
        );
    }
}

#[test]
fn huge_windows_are_refused_before_memory_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.exr");
    for original in [table_bytes(), image_bytes()] {
        let at = value_of(&original, b"dataWindow\0box2i\0");
        for (max_x, max_y) in [(500_000_000, 7), (39, 500_000_000), (1_000_000, 1_000_000)] {
            let mut bytes = original.clone();
            bytes[at + 8..at + 12].copy_from_slice(&i32::to_le_bytes(max_x));
            bytes[at + 12..at + 16].copy_from_slice(&i32::to_le_bytes(max_y));
            // The count of chunks would give the height away.
            let chunks = value_of(&original, b"chunkCount\0int\0");
            let is_table = original.len() == table_bytes().len();
            let n_chunks = if is_table { max_y + 1 } else { max_y / 32 + 1 };
            bytes[chunks..chunks + 4].copy_from_slice(&n_chunks.to_le_bytes());
            fs::write(&path, &bytes).unwrap();
            let error = TableFile::read(&path).unwrap_err();
            assert!(matches!(error, Error::TooLarge { .. }), "{error}");
        }
    }
}

#[test]
fn a_flipped_bit_in_a_pixel_is_named_with_its_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flipped.exr");
    let mut bytes = table_bytes();
    let last = bytes.len() - 1;
    bytes[last - 2] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let error = TableFile::read(&path).unwrap_err();
    assert!(
        matches!(&error, Error::Checksum { part } if part == "two"),
        "{error}"
    );
}

#[test]
fn a_block_that_comes_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("twice.exr");
    let mut bytes = table_bytes();
    // Chunks of the table: part, row, length, two channels of 40 samples.
    let n_chunk_bytes = 12 + 2 * 40 * 4;
    let last = bytes.len() - n_chunk_bytes;
    bytes.copy_within(last - n_chunk_bytes..last, last);
    fs::write(&path, &bytes).unwrap();
    let error = TableFile::read(&path).unwrap_err();
    assert!(
        matches!(&error, Error::Damaged(text) if text.contains("twice")),
        "{error}"
    );
}
