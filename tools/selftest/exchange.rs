//! Hard cases of tables and images in files: truncated, corrupted, with huge headers; and what may
//! not enter a file.

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
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_exchange::read_provenance;
use niji_radiometry::WavelengthGrid;

use crate::selftest::hard_case::HardCase;
use crate::selftest::hard_case::Random;
use crate::selftest::hard_case::violations;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "tables and images that end too early are errors at every length",
        measure: "files of 400 without the error",
        allowed: 0.0,
        error: truncated,
    },
    HardCase {
        claim: "a changed byte anywhere never changes a table unnoticed",
        measure: "files of 2000 read with other values",
        allowed: 0.0,
        error: changed_tables,
    },
    HardCase {
        claim: "a changed byte anywhere never changes an image unnoticed",
        measure: "files of 2000 read with other values",
        allowed: 0.0,
        error: changed_images,
    },
    HardCase {
        claim: "damaged headers are errors or harmless",
        measure: "files of 4000 read with other values",
        allowed: 0.0,
        error: damaged_headers,
    },
    HardCase {
        claim: "windows of 500 million pixels are refused before memory is asked for",
        measure: "files of 6 without the error",
        allowed: 0.0,
        error: huge_windows,
    },
    HardCase {
        claim: "a flipped bit in a pixel is named with its part",
        measure: "files without the error",
        allowed: 0.0,
        error: flipped_bit,
    },
    HardCase {
        claim: "a block that comes twice is refused",
        measure: "files without the error",
        allowed: 0.0,
        error: repeated_block,
    },
    HardCase {
        claim: "NaN and infinities never enter a file",
        measure: "files that hold one",
        allowed: 0.0,
        error: not_a_number,
    },
];

const N_CORRUPTIONS: usize = 2000;
const N_HEADER_CORRUPTIONS: usize = 1000;
const N_TRUNCATIONS: usize = 200;

fn wave(y: usize, x: usize) -> f32 {
    (0.1 * y as f32).sin() + (0.07 * x as f32).cos() + 2.0
}

fn provenance() -> Provenance {
    Provenance {
        tool: "niji selftest".to_owned(),
        version: "0".to_owned(),
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
    TableFile {
        quantity: "test".to_owned(),
        parts: vec![part("one"), part("two")],
        provenance: provenance(),
    }
}

fn image() -> SpectralImage {
    let (height, width) = (40, 30);
    SpectralImage {
        wavelengths: WavelengthGrid::new(400.0, 50.0, 7).expect("wavelengths of light"),
        radiance: Array3::from_shape_fn((7, height, width), |(l, y, x)| wave(y + l, x)),
        spectra: Spectra::Full,
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
    table().write(&mut cursor).expect("a table of numbers");
    cursor.into_inner()
}

fn image_bytes() -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    let written = image().write_spectral(&mut cursor);
    written.expect("an image of numbers");
    cursor.into_inner()
}

/// `Ok(true)` where the content is the one that was written.
type Read = fn(&Path) -> Result<bool, Error>;

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

/// Reads files of given bytes one after the other, by one thread: more cost more than they save on
/// small files.
fn through_files<T: Send>(
    contents: impl Iterator<Item = Vec<u8>> + Send,
    read: impl Fn(&Path) -> T + Sync,
) -> Vec<T> {
    let folder = tempfile::tempdir().expect("a folder for damaged files");
    let path = folder.path().join("damaged.exr");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let read_bytes = |bytes: Vec<u8>| {
        fs::write(&path, bytes).expect("a file of some bytes");
        read(&path)
    };
    pool.expect("one thread")
        .install(|| contents.map(read_bytes).collect())
}

/// How many of `n` corrupted files are read without an error and with other content.
fn unnoticed(n: usize, original: &[u8], read: Read, corrupt: fn(&mut Random, &mut [u8])) -> f64 {
    let mut random = Random(20_240_607);
    let corrupted = (0..n).map(|_| {
        let mut bytes = original.to_vec();
        corrupt(&mut random, &mut bytes);
        bytes
    });
    violations(through_files(corrupted, |path| {
        !matches!(read(path), Ok(false))
    }))
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
    let is_negative = random.below(4) == 0;
    let number = if is_negative {
        number.wrapping_neg()
    } else {
        number
    };
    bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
}

fn truncated() -> f64 {
    let files: [(Vec<u8>, Read); 2] = [(table_bytes(), read_table), (image_bytes(), read_image)];
    let n_violations = files.map(|(whole, read)| {
        let lengths = (0..N_TRUNCATIONS).map(|index| whole.len() * index / N_TRUNCATIONS);
        let is_told =
            |path: &Path| matches!(read(path), Err(Error::Damaged(_) | Error::TooLarge { .. }));
        let told = through_files(lengths.map(|length| whole[..length].to_vec()), is_told);
        let is_whole = through_files(std::iter::once(whole.clone()), |path| {
            matches!(read(path), Ok(true))
        });
        violations(told) + violations(is_whole)
    });
    n_violations.into_iter().sum()
}

fn changed_tables() -> f64 {
    unnoticed(N_CORRUPTIONS, &table_bytes(), read_table, any_byte)
}

fn changed_images() -> f64 {
    unnoticed(N_CORRUPTIONS, &image_bytes(), read_image, any_byte)
}

fn damaged_headers() -> f64 {
    let corruptions: [fn(&mut Random, &mut [u8]); 2] = [header_byte, header_number];
    let n_unnoticed = corruptions.map(|corrupt| {
        unnoticed(N_HEADER_CORRUPTIONS, &table_bytes(), read_table, corrupt)
            + unnoticed(N_HEADER_CORRUPTIONS, &image_bytes(), read_image, corrupt)
    });
    n_unnoticed.into_iter().sum()
}

/// Position behind the name and kind of an attribute and the length of its value.
fn value_of(bytes: &[u8], name_and_kind: &[u8]) -> usize {
    let length = name_and_kind.len();
    let mut windows = bytes.windows(length);
    let start = windows.position(|window| window == name_and_kind);
    start.expect("every part has the attribute") + length + 4
}

fn huge_windows() -> f64 {
    // Rows in a chunk: the count of chunks would give the height away.
    let files = [(table_bytes(), 1), (image_bytes(), 32)];
    let damaged = files.into_iter().flat_map(|(original, n_rows)| {
        let at = value_of(&original, b"dataWindow\0box2i\0");
        let chunks = value_of(&original, b"chunkCount\0int\0");
        let ends = [(500_000_000, 7), (39, 500_000_000), (1_000_000, 1_000_000)];
        ends.map(|(max_x, max_y): (i32, i32)| {
            let mut bytes = original.clone();
            let n_chunks = max_y / n_rows + 1;
            bytes[at + 8..at + 12].copy_from_slice(&max_x.to_le_bytes());
            bytes[at + 12..at + 16].copy_from_slice(&max_y.to_le_bytes());
            bytes[chunks..chunks + 4].copy_from_slice(&n_chunks.to_le_bytes());
            bytes
        })
    });
    violations(through_files(damaged, |path| {
        matches!(TableFile::read(path), Err(Error::TooLarge { .. }))
    }))
}

fn flipped_bit() -> f64 {
    let mut bytes = table_bytes();
    let last = bytes.len() - 1;
    bytes[last - 2] ^= 1;
    violations(through_files(
        std::iter::once(bytes),
        |path| matches!(TableFile::read(path), Err(Error::Checksum { part }) if part == "two"),
    ))
}

fn repeated_block() -> f64 {
    let mut bytes = table_bytes();
    // Chunks of the table: part, row, length, two channels of 40 samples.
    let n_chunk_bytes = 12 + 2 * 40 * 4;
    let last = bytes.len() - n_chunk_bytes;
    bytes.copy_within(last - n_chunk_bytes..last, last);
    violations(through_files(
        std::iter::once(bytes),
        |path| matches!(TableFile::read(path), Err(Error::Damaged(text)) if text.contains("twice")),
    ))
}

fn not_a_number() -> f64 {
    violations(
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
            .into_iter()
            .flat_map(|bad| {
                let (mut table, mut image) = (table(), image());
                table.parts[1].channels[0].values[[3, 5]] = bad;
                image.radiance[[2, 7, 9]] = bad;
                [
                    table.write(Cursor::new(Vec::new())).is_err(),
                    image.write_spectral(Cursor::new(Vec::new())).is_err(),
                ]
            }),
    )
}
