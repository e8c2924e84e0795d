//! Blosc 1 chunks, as OpenVDB writes them: LZ4 behind a byte shuffle.
//!
//! A chunk is a header of 16 bytes (format version, codec version, flags, element size; then, each
//! in 32 bits, the decoded length, the block length and the chunk length), the offset of each
//! block, and the blocks. A block is one stream, or one for each byte of an element; a stream has
//! its length in front, and a stream as long as what it decodes to is stored as it is.
//! Source: <https://github.com/Blosc/c-blosc>, README_CHUNK_FORMAT.rst.

use crate::Error;

const HEADER_BYTES: usize = 16;

/// Format versions of Blosc 1; Blosc 2 starts at 3.
const NEWEST_FORMAT: u8 = 2;

const FLAG_BYTE_SHUFFLE: u8 = 0x01;
const FLAG_STORED: u8 = 0x02;
const FLAG_BIT_SHUFFLE: u8 = 0x04;
const FLAG_NOT_SPLIT: u8 = 0x10;

const CODEC_LZ4: u8 = 1;
const CODEC_NAMES: [&str; 8] = ["blosclz", "lz4", "snappy", "zlib", "zstd", "5", "6", "7"];

/// Blocks are split by the bytes of an element only up to this element size.
const LARGEST_SPLIT: usize = 16;

/// Blocks are split only if each stream has at least this many bytes.
const LEAST_STREAM: usize = 128;

/// What the header says.
struct Header {
    flags: u8,
    element: usize,
    block: usize,
}

/// Decode a chunk that must fill `out` exactly; `scratch` is kept between calls for its memory.
///
/// The error is a sentence for [`Error::Damaged`], or another error.
pub(crate) fn decode(chunk: &[u8], out: &mut [u8], scratch: &mut Vec<u8>) -> Result<(), Fault> {
    let header = header(chunk, out.len())?;
    if out.is_empty() {
        return Ok(());
    }
    if header.flags & FLAG_STORED != 0 {
        let stored = chunk.get(HEADER_BYTES..HEADER_BYTES + out.len());
        out.copy_from_slice(stored.ok_or("a blosc chunk ends inside its stored bytes")?);
        return Ok(());
    }
    check_codec(header.flags)?;
    let shuffled = header.flags & FLAG_BYTE_SHUFFLE != 0 && header.element > 1;
    for (index, block) in out.chunks_mut(header.block).enumerate() {
        let start = number(chunk, HEADER_BYTES + 4 * index)?;
        let streams = chunk
            .get(start..)
            .ok_or("a blosc block starts behind the end of its chunk")?;
        if shuffled {
            scratch.resize(block.len(), 0);
            decode_block(streams, scratch, &header)?;
            unshuffle(scratch, block, header.element);
        } else {
            decode_block(streams, block, &header)?;
        }
    }
    Ok(())
}

/// Why a chunk cannot be decoded.
pub(crate) enum Fault {
    /// The bytes contradict themselves.
    Damaged(String),
    /// Sound, but not read here.
    Unsupported(Error),
}

impl From<&str> for Fault {
    fn from(what: &str) -> Self {
        Self::Damaged(what.to_owned())
    }
}

fn header(chunk: &[u8], n_bytes: usize) -> Result<Header, Fault> {
    let [format, _, flags, element] = *chunk
        .first_chunk()
        .ok_or("a blosc chunk of under 16 bytes")?;
    if format > NEWEST_FORMAT {
        return Err(unsupported(
            "blosc format",
            format!("version {format}"),
            "version 1 or 2",
        ));
    }
    let decoded = number(chunk, 4)?;
    let block = number(chunk, 8)?;
    if decoded != n_bytes {
        let what = format!("a blosc chunk of {decoded} bytes, expected {n_bytes}");
        return Err(Fault::Damaged(what));
    }
    if number(chunk, 12)? != chunk.len() {
        return Err("a blosc chunk whose own length is not that of the file's entry".into());
    }
    if n_bytes > 0 && (block == 0 || element == 0) {
        return Err("a blosc chunk with blocks or elements of 0 bytes".into());
    }
    Ok(Header {
        flags,
        element: usize::from(element),
        block,
    })
}

fn check_codec(flags: u8) -> Result<(), Fault> {
    let codec = flags >> 5;
    if codec != CODEC_LZ4 {
        let name = CODEC_NAMES[usize::from(codec)].to_owned();
        return Err(unsupported("blosc codec", name, "lz4"));
    }
    if flags & FLAG_BIT_SHUFFLE != 0 {
        return Err(unsupported(
            "blosc filter",
            "bit shuffle".to_owned(),
            "byte shuffle or none",
        ));
    }
    Ok(())
}

fn unsupported(what: &'static str, found: String, expected: &'static str) -> Fault {
    Fault::Unsupported(Error::Unsupported {
        what,
        found,
        expected,
    })
}

/// A number of 32 bits that is a length or an offset.
fn number(bytes: &[u8], at: usize) -> Result<usize, Fault> {
    let field = bytes.get(at..).and_then(<[u8]>::first_chunk);
    let field = field.ok_or("a blosc chunk ends inside its lengths")?;
    Ok(u32::from_le_bytes(*field) as usize)
}

fn decode_block(mut streams: &[u8], out: &mut [u8], header: &Header) -> Result<(), Fault> {
    let full = out.len() == header.block;
    let split = header.flags & FLAG_NOT_SPLIT == 0
        && full
        && header.element <= LARGEST_SPLIT
        && header.block / header.element >= LEAST_STREAM;
    let n_streams = if split { header.element } else { 1 };
    let n_bytes = out.len() / n_streams;
    if n_bytes * n_streams != out.len() {
        return Err("a blosc block that its streams do not divide".into());
    }
    for part in out.chunks_exact_mut(n_bytes) {
        let length = number(streams, 0)?;
        let stream = streams.get(4..).and_then(|rest| rest.get(..length));
        let stream = stream.ok_or("a blosc stream reaches past its chunk")?;
        decode_stream(stream, part)?;
        streams = &streams[4 + length..];
    }
    Ok(())
}

fn decode_stream(stream: &[u8], out: &mut [u8]) -> Result<(), Fault> {
    if stream.len() == out.len() {
        out.copy_from_slice(stream);
        return Ok(());
    }
    match lz4_flex::block::decompress_into(stream, out) {
        Ok(n_bytes) if n_bytes == out.len() => Ok(()),
        Ok(_) | Err(_) => Err("an lz4 stream in a blosc chunk is not sound".into()),
    }
}

/// Bring the bytes of each element together again; a rest shorter than an element is not shuffled.
fn unshuffle(shuffled: &[u8], out: &mut [u8], element: usize) {
    let n_elements = out.len() / element;
    let (planes, rest) = shuffled.split_at(n_elements * element);
    let (elements, out_rest) = out.split_at_mut(planes.len());
    out_rest.copy_from_slice(rest);
    if element == 4 {
        unshuffle_words(planes, elements);
        return;
    }
    for (index, bytes) in elements.chunks_exact_mut(element).enumerate() {
        for (byte, plane) in bytes.iter_mut().zip(planes.chunks_exact(n_elements)) {
            *byte = plane[index];
        }
    }
}

/// The case of OpenVDB, which always names four bytes; written so that it vectorises.
fn unshuffle_words(planes: &[u8], words: &mut [u8]) {
    let n_words = words.len() / 4;
    let (low, high) = planes.split_at(2 * n_words);
    let (first, second) = low.split_at(n_words);
    let (third, fourth) = high.split_at(n_words);
    let low = first.iter().zip(second);
    let high = third.iter().zip(fourth);
    for (word, ((a, b), (c, d))) in words.chunks_exact_mut(4).zip(low.zip(high)) {
        word.copy_from_slice(&[*a, *b, *c, *d]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(flags: u8, element: u8, block: u32, decoded: u32, body: &[u8]) -> Vec<u8> {
        let mut bytes = vec![2, 1, flags, element];
        let length = (HEADER_BYTES + body.len()) as u32;
        for number in [decoded, block, length] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(body);
        bytes
    }

    fn lz4_body(n_blocks: usize, streams: &[&[u8]]) -> Vec<u8> {
        // All blocks of these tests follow each other and hold one stream each.
        let mut starts = Vec::new();
        let mut body = Vec::new();
        for stream in streams {
            let start = (HEADER_BYTES + 4 * n_blocks + body.len()) as u32;
            starts.extend(start.to_le_bytes());
            body.extend((stream.len() as u32).to_le_bytes());
            body.extend(*stream);
        }
        starts.extend(body);
        starts
    }

    fn decoded(chunk: &[u8], n_bytes: usize) -> Result<Vec<u8>, String> {
        let mut out = vec![0; n_bytes];
        match decode(chunk, &mut out, &mut Vec::new()) {
            Ok(()) => Ok(out),
            Err(Fault::Damaged(what)) => Err(what),
            Err(Fault::Unsupported(error)) => Err(error.to_string()),
        }
    }

    #[test]
    fn several_blocks_with_a_shorter_last_one_are_joined() {
        let plain: Vec<u8> = (0..70).map(|byte| byte / 5).collect();
        let streams = plain
            .chunks(32)
            .map(lz4_flex::block::compress)
            .collect::<Vec<_>>();
        let streams = streams.iter().map(Vec::as_slice).collect::<Vec<_>>();
        let bytes = chunk(0x30, 1, 32, 70, &lz4_body(3, &streams));
        assert_eq!(decoded(&bytes, 70), Ok(plain));
    }

    #[test]
    fn shuffled_elements_come_back_in_order_with_their_rest() {
        // Two elements of three bytes and one byte over: planes 1 4, 2 5, 3 6, rest 7.
        let bytes = chunk(0x31, 3, 7, 7, &lz4_body(1, &[&[1, 4, 2, 5, 3, 6, 7]]));
        assert_eq!(decoded(&bytes, 7), Ok(vec![1, 2, 3, 4, 5, 6, 7]));
    }

    #[test]
    fn an_empty_chunk_decodes_to_nothing() {
        assert_eq!(decoded(&chunk(0x33, 4, 0, 0, &[]), 0), Ok(vec![]));
    }

    #[test]
    fn other_codecs_are_named() {
        let error = decoded(&chunk(0x81, 4, 8, 8, &[0; 12]), 8).unwrap_err();
        assert_eq!(error, "blosc codec `zstd` is not supported, expected lz4");
        let error = decoded(&chunk(0x24, 4, 8, 8, &[0; 12]), 8).unwrap_err();
        assert_eq!(
            error,
            "blosc filter `bit shuffle` is not supported, expected byte shuffle or none"
        );
    }

    #[test]
    fn lengths_that_contradict_each_other_are_damage() {
        assert!(decoded(&chunk(0x33, 4, 8, 8, &[0; 8]), 12).is_err());
        assert!(decoded(&chunk(0x33, 4, 8, 8, &[0; 7]), 8).is_err());
        assert!(decoded(&chunk(0x31, 0, 8, 8, &[0; 12]), 8).is_err());
        assert!(decoded(&chunk(0x31, 4, 8, 8, &[255; 12]), 8).is_err());
    }
}
