//! Where the numbers of a file's frame stand, by what its format says: sizes, counts, offsets, codes, flags.
//!
//! The frame of a file that is changed already is followed as far as it goes.

use std::ops::Range;

const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const VDB: [u8; 4] = [0x20, 0x42, 0x44, 0x56];
const PNG: [u8; 4] = [0x89, b'P', b'N', b'G'];
const JPEG: [u8; 2] = [0xff, 0xd8];
const GLB: [u8; 4] = *b"glTF";

/// The longest text whose length before it counts as a number of the frame.
const LONGEST_TEXT: usize = 64;
/// Numbers behind the map of a grid: where its tree begins.
const TREE_NUMBERS: usize = 16;

/// The numbers of a file's frame; none for a format without one.
pub fn places(bytes: &[u8]) -> Vec<Range<usize>> {
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    let places = match () {
        () if starts(&EXR) => exr(bytes),
        () if starts(&VDB) => vdb(bytes),
        () if starts(&PNG) => png(bytes),
        () if starts(&JPEG) => jpeg(bytes),
        () if starts(&GLB) => (0..3).map(|index| 4 * index..4 * index + 4).collect(),
        () => Vec::new(),
    };
    let is_inside = |place: &Range<usize>| place.end <= bytes.len();
    places.into_iter().filter(is_inside).collect()
}

/// Writes the checksums of PNG anew, which hide every other damage; other formats stay as they are.
pub fn mend_checksums(bytes: &mut [u8]) {
    if !bytes.starts_with(&PNG) {
        return;
    }
    for chunk in png_chunks(bytes) {
        let checksum = crc32(&bytes[chunk.start + 4..chunk.end - 4]);
        bytes[chunk.end - 4..chunk.end].copy_from_slice(&checksum.to_be_bytes());
    }
}

/// The number of 4 bytes at a place.
fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let found = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(found.try_into().ok()?) as usize)
}

/// The words of a stretch, and what is left of it byte by byte.
fn words(stretch: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let rest = stretch.start + stretch.len() / 4 * 4;
    let words = (stretch.start..rest).step_by(4).map(|at| at..at + 4);
    words.chain((rest..stretch.end).map(|at| at..at + 1))
}

/// Version and flags, sizes and values of attributes, the table of offsets, the first chunk.
fn exr(bytes: &[u8]) -> Vec<Range<usize>> {
    let mut places: Vec<_> = words(4..8).collect();
    // Flags are bits of the second byte: tiles, long names, deep data, several parts.
    places.extend([5..6, 5..6, 5..6]);
    let text_end = |at: usize| {
        let length = bytes.get(at..)?.iter().position(|byte| *byte == 0)?;
        Some((length, at + length + 1))
    };
    let mut at = 8;
    loop {
        let Some((length, after)) = text_end(at) else {
            return places;
        };
        // A header ends with an empty name; a second one ends all headers of several parts.
        if length == 0 {
            at = after;
            if text_end(at).is_none_or(|(length, _)| length == 0 || length > LONGEST_TEXT) {
                break;
            }
            continue;
        }
        let size_at = text_end(after).map(|(_, after)| after);
        let Some((size_at, size)) = size_at.and_then(|at| Some((at, number(bytes, at)?))) else {
            return places;
        };
        places.push(size_at..size_at + 4);
        let value = size_at + 4;
        places.extend(words(value..value + size.min(LONGEST_TEXT)));
        at = value.saturating_add(size);
    }
    places.extend((0..4).map(|index| at + 8 * index..at + 8 * index + 8));
    places.extend(words(at..at + 64));
    places
}

/// Version, lengths of texts and what stands behind them, the beginning of each tree.
fn vdb(bytes: &[u8]) -> Vec<Range<usize>> {
    let mut places: Vec<_> = words(0..21).collect();
    let end = bytes.len().min(4096);
    let mut at = 21;
    while at + 4 < end {
        let text = number(bytes, at)
            .filter(|length| (1..LONGEST_TEXT).contains(length))
            .and_then(|length| bytes.get(at + 4..at + 4 + length));
        match text {
            Some(text) if text.iter().all(|byte| (0x20..0x7f).contains(byte)) => {
                let after = at + 4 + text.len();
                places.extend([at..at + 4, after..after + 4]);
                if text.starts_with(b"Tree_") {
                    // Behind the parent of an instance: where grid, leaves and end lie, and the compression.
                    places.extend(words(after + 4..after + 32));
                }
                if text.ends_with(b"Map") {
                    let doubles = if text.starts_with(b"Affine") { 16 } else { 18 };
                    let tree = after + 8 * doubles;
                    places.extend(words(tree..tree + 4 * TREE_NUMBERS));
                }
                at = after;
            }
            _ => at += 1,
        }
    }
    places
}

/// The chunks of a PNG, length and checksum included, as far as they fit.
fn png_chunks(bytes: &[u8]) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut at = 8;
    while let Some(length) = number(bytes, at) {
        let end = at
            .saturating_add(12)
            .saturating_add((length as u32).swap_bytes() as usize);
        if end > bytes.len() {
            break;
        }
        chunks.push(at..end);
        at = end;
    }
    chunks
}

/// Length and kind of each chunk, and the first words in it.
fn png(bytes: &[u8]) -> Vec<Range<usize>> {
    let chunks = png_chunks(bytes).into_iter();
    chunks
        .flat_map(|chunk| words(chunk.start..chunk.end.min(chunk.start + 21)))
        .collect()
}

/// Length and first bytes of each segment; the notes of a camera word by word.
fn jpeg(bytes: &[u8]) -> Vec<Range<usize>> {
    let mut places = Vec::new();
    let mut at = 2;
    while let Some(&[0xff, kind, high, low]) = bytes.get(at..at + 4) {
        let length = usize::from(u16::from_be_bytes([high, low]));
        places.extend((at + 1..at + 4 + length.min(20)).map(|at| at..at + 1));
        if kind == 0xe1 {
            places.extend((at + 10..at + 2 + length).step_by(2).map(|at| at..at + 2));
        }
        at += 2 + length;
    }
    places
}

/// CRC-32 of ISO 3309, as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1))
        })
    })
}
