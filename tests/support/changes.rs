//! One change of a file: of its bytes, of its digits, or of a number or a name that its format tells.

use super::places::places;
use super::vdb_files::Random;

/// Numbers where sizes and indices break.
const EDGES: [u64; 9] = [
    0,
    1,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
];

/// Texts where numbers break.
const NUMBERS: [&str; 7] = ["-1", "1e999", "1e-999", "nan", "2.5", "-0", "4294967296"];

/// Names by which formats tell codecs, kinds of pixels and of grids; a file that holds one may hold another.
const NAMES: [&[&str]; 5] = [
    &["scanlineimage", "tiledimage", "deepscanline", "deeptile"],
    &[
        "compression",
        "dataWindow",
        "channels",
        "chunkCount",
        "lineOrder",
        "tiles",
    ],
    &[
        "Tree_float_5_4_3",
        "Tree_float_5_4_3_HalfFloat",
        "Tree_double_5_4_3",
        "Tree_vec3s_5_4_3",
        "Tree_bool_5_4_3",
        "Tree_int32_5_4_3",
    ],
    &[
        "UniformScaleTranslateMap",
        "ScaleTranslateMap",
        "AffineMap",
        "NonlinearFrustumMap",
    ],
    &["SCALAR", "VEC2", "VEC3", "MAT4"],
];

/// Changes a file once.
pub fn change(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    match random.below(10) {
        0..4 => change_place(bytes, random),
        4 => change_name(bytes, random),
        5 => change_digits(bytes, random),
        _ => change_bytes(bytes, random),
    }
}

/// Another number where the format has one: counts, sizes, offsets, codes of compression, flags.
fn change_place(bytes: &mut Vec<u8>, random: &mut Random) {
    let places = places(bytes);
    if places.is_empty() {
        return change_bytes(bytes, random);
    }
    let place = places[random.below(places.len())].clone();
    let old = &bytes[place.clone()];
    let n_bytes = old.len().min(8);
    let mut number = [0; 8];
    number[..n_bytes].copy_from_slice(&old[..n_bytes]);
    let old = u64::from_le_bytes(number);
    let new = match random.below(6) {
        0 => EDGES[random.below(EDGES.len())],
        1 => random.below(20) as u64,
        2 => old.wrapping_add(1),
        3 => old.wrapping_sub(1),
        4 => old ^ (1 << random.below(8 * n_bytes)),
        _ => old.wrapping_mul(1 << random.below(16)),
    };
    let start = place.start;
    bytes[start..start + n_bytes].copy_from_slice(&new.to_le_bytes()[..n_bytes]);
}

/// A name of the format for another, with the bytes around it as they are.
fn change_name(bytes: &mut Vec<u8>, random: &mut Random) {
    let first = random.below(NAMES.len());
    for names in NAMES.iter().cycle().skip(first).take(NAMES.len()) {
        let found = names.iter().find_map(|name| {
            let mut windows = bytes.windows(name.len());
            let at = windows.position(|window| window == name.as_bytes())?;
            Some((at, name.len()))
        });
        if let Some((at, length)) = found {
            let other = names[random.below(names.len())];
            bytes.splice(at..at + length, other.bytes());
            return;
        }
    }
    change_bytes(bytes, random);
}

/// Another number in digits.
fn change_digits(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    let Some(start) = bytes[at..].iter().position(is_digit) else {
        return;
    };
    let start = at + start;
    let n_digits = bytes[start..].iter().take_while(|byte| is_digit(byte));
    let n_digits = n_digits.count();
    let number = match random.below(2 * NUMBERS.len()) {
        index if index < NUMBERS.len() => NUMBERS[index].to_owned(),
        _ => EDGES[random.below(EDGES.len())].to_string(),
    };
    bytes.splice(start..start + n_digits, number.into_bytes());
}

/// A bit, a byte, a binary number; a piece cut out, doubled, filled or cut off.
fn change_bytes(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(32)).min(bytes.len());
    let edge = EDGES[random.below(EDGES.len())];
    match random.below(7) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.next() as u8,
        2 | 3 => {
            let edge = if random.below(2) == 0 {
                edge.to_le_bytes()
            } else {
                edge.to_be_bytes()
            };
            let n_bytes = (1 << random.below(4)).min(bytes.len() - at);
            let first = if edge[0] == 0 { 8 - n_bytes } else { 0 };
            bytes[at..at + n_bytes].copy_from_slice(&edge[first..first + n_bytes]);
        }
        4 => drop(bytes.drain(at..end)),
        5 => {
            let piece = bytes[at..end].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
        _ if random.below(4) == 0 => bytes.truncate(at),
        _ => bytes[at..end].fill(random.next() as u8),
    }
}
