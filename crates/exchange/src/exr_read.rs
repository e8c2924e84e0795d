//! Reads EXR files that may be damaged.
//!
//! A header can promise anything. So what it promises is compared with the length of the file before
//! memory is asked for, memory is asked for in a way that may fail, and it is touched only as blocks
//! arrive that really unpack to what the header says. Every block must come exactly once.

use std::io::BufReader;
use std::io::Read;
use std::io::Seek;
use std::ops::Range;
use std::path::Path;

use exr::block::BlockIndex;
use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::block::chunk::CompressedBlock;
use exr::block::chunk::TileCoordinates;
use exr::block::lines::LineIndex;
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue as ExrValue;
use exr::meta::attribute::IntegerBounds;
use exr::meta::attribute::SampleType;
use exr::meta::attribute::Text;
use exr::meta::header::Header;
use exr::prelude::f16;
use ndarray::Array2;
use niji_geometry::PixelRegion;
use niji_radiometry::Bytes;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::memory_limit;
use niji_radiometry::open_file;
use rayon::prelude::*;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::attributes::WINDOW_WIDTH;
use crate::checksum;
use crate::error::Error;
use crate::frame_time;
use crate::guarded::guarded;
use crate::image_windows::ImageWindows;
use crate::part::Part;

/// Best that a codec can do: deflate packs at most 1032 bytes into one, the others less.
const MAX_EXPANSION: u128 = 1032;
/// Bytes that a chunk takes besides its pixels: its offset, row and length; 4 more name the part if
/// there are several.
const CHUNK_BYTES: u128 = 16;
/// Pixels that are unpacked at a time.
const BATCH_BYTES: usize = 32 << 20;

/// Reads all parts of a file.
///
/// # Errors
/// A missing, truncated or damaged file, a header that promises more than the file can hold, a part
/// that does not fit its checksum, or a value that is not finite.
pub(crate) fn read_parts(path: &Path) -> Result<Vec<Part<'static>>, Error> {
    let (file, file_bytes) = open_file(path)?;
    guarded(Error::Damaged, || {
        read_from(BufReader::with_capacity(1 << 18, file), file_bytes)
    })
}

/// Reads names and attributes of all parts, and of pixels no more than tells that none were cut off.
///
/// # Errors
/// As for [`read_parts`], as far as headers and the end of each part show it.
pub(crate) fn read_headers(path: &Path) -> Result<Vec<(String, Attributes)>, Error> {
    let (file, file_bytes) = open_file(path)?;
    guarded(Error::Damaged, || headers(BufReader::new(file), file_bytes))
}

fn headers(
    mut source: impl Read + Seek,
    file_bytes: u64,
) -> Result<Vec<(String, Attributes)>, Error> {
    let meta_data = exr::block::read(&mut source, false)?.into_meta_data();
    // The reader looks at most one byte ahead.
    let header_bytes = source.stream_position()?.saturating_sub(1);
    check_sizes(&meta_data, header_bytes, file_bytes)?;
    source.rewind()?;
    check_ends(source)?;
    let headers = meta_data.headers.iter();
    Ok(headers.map(|it| (name(it), attributes(it))).collect())
}

/// Which pixels the first part of a file holds, and which are shown; the bytes of a row of its first parts in memory.
///
/// # Errors
/// As for [`read_headers`].
pub(crate) fn read_layout(path: &Path, n_parts: usize) -> Result<(ImageWindows, usize), Error> {
    let (file, file_bytes) = open_file(path)?;
    guarded(Error::Damaged, || {
        let reader = exr::block::read(BufReader::new(file), false)?;
        check_sizes(reader.meta_data(), 0, file_bytes)?;
        let headers = &reader.meta_data().headers;
        let first = headers.first().ok_or_else(|| Error::missing("part", "0"))?;
        let row_bytes = |header: &Header| {
            size_of::<f32>() * header.channels.list.len() * header.layer_size.width()
        };
        let row_bytes = headers.iter().take(n_parts).map(row_bytes).sum();
        Ok((windows(first)?, row_bytes))
    })
}

/// Reads all parts from a source of so many bytes.
fn read_from(source: impl Read + Seek, file_bytes: u64) -> Result<Vec<Part<'static>>, Error> {
    let reader = exr::block::read(source, false)?;
    check_sizes(reader.meta_data(), 0, file_bytes)?;
    let meta_data = reader.meta_data().clone();
    let headers = &meta_data.headers;
    check_memory(headers, 0..usize::MAX)?;
    let whole = |header: &Header| Page::new(header, 0..header.layer_size.height());
    let pages = headers.iter().map(whole);
    let mut pages = pages.collect::<Result<Vec<_>, _>>()?;
    fill(&mut pages, reader.all_chunks(false)?, &meta_data)?;
    let parts = headers.iter().zip(pages).map(|(header, page)| {
        let part = page.finish(header)?;
        checksum::verify(&part)?;
        part.check_values(0)?;
        Ok(part)
    });
    parts.collect()
}

/// Rows of the first parts of a file whose parts have these rows; they are not compared with the checksums, which are of
/// all rows.
///
/// # Errors
/// As for [`read_parts`], as far as these rows show it.
pub(crate) fn read_rows(
    path: &Path,
    (n_parts, rows): (usize, Range<usize>),
) -> Result<Vec<Part<'static>>, Error> {
    let (file, file_bytes) = open_file(path)?;
    guarded(Error::Damaged, || {
        let source = BufReader::with_capacity(1 << 18, file);
        let reader = exr::block::read(source, false)?;
        check_sizes(reader.meta_data(), 0, file_bytes)?;
        let meta_data = reader.meta_data().clone();
        let headers = &meta_data.headers[..n_parts.min(meta_data.headers.len())];
        check_memory(headers, rows.clone())?;
        let pages = headers.iter().map(|header| {
            let height = header.layer_size.height();
            Page::new(header, rows.start.min(height)..rows.end.min(height))
        });
        let mut pages = pages.collect::<Result<Vec<_>, _>>()?;
        let is_wanted = |_: &MetaData, _: TileCoordinates, block: BlockIndex| {
            let top = block.pixel_position.y();
            let bottom = top + block.pixel_size.height();
            block.layer < n_parts && top < rows.end && rows.start < bottom
        };
        fill(
            &mut pages,
            reader.filter_chunks(false, is_wanted)?,
            &meta_data,
        )?;
        let parts = headers.iter().zip(pages).map(|(header, page)| {
            let part = page.finish(header)?;
            part.check_values(rows.start)?;
            Ok(part)
        });
        parts.collect()
    })
}

/// Puts chunks into their pages.
fn fill(
    pages: &mut [Page],
    mut chunks: impl Iterator<Item = Result<Chunk, exr::error::Error>>,
    meta_data: &MetaData,
) -> Result<(), Error> {
    let headers = &meta_data.headers;
    let n_per_batch = batch_length(headers);
    loop {
        let batch = chunks
            .by_ref()
            .take(n_per_batch)
            .collect::<Result<Vec<Chunk>, _>>()?;
        if batch.is_empty() {
            return Ok(());
        }
        let blocks: Vec<UncompressedBlock> = batch
            .into_par_iter()
            .map(|chunk| unpack(chunk, meta_data))
            .collect::<Result<_, _>>()?;
        for block in blocks {
            let layer = block.index.layer;
            pages[layer].insert(&headers[layer], &block)?;
        }
    }
}

/// Compares the promises of all headers with the length of the file.
fn check_sizes(meta_data: &MetaData, header_bytes: u64, file_bytes: u64) -> Result<(), Error> {
    let chunk_bytes = CHUNK_BYTES
        + if meta_data.requirements.is_multilayer() {
            4
        } else {
            0
        };
    let mut needed_bytes = u128::from(header_bytes);
    for header in &meta_data.headers {
        if header.blocks != BlockDescription::ScanLines {
            return Err(Error::Layout {
                found: "tiles",
                expected: "scan lines",
            });
        }
        if header.layer_size.area() == 0 {
            return Err(Error::Damaged("found a part without pixels".to_owned()));
        }
        needed_bytes += chunk_bytes * header.chunk_count as u128;
        needed_bytes += pixel_bytes(header).div_ceil(max_expansion(header));
    }
    if needed_bytes > u128::from(file_bytes) {
        return Err(Error::TooLarge {
            needed_bytes,
            file_bytes,
        });
    }
    Ok(())
}

/// Refuses more pixels of some rows than fit into memory.
fn check_memory(headers: &[Header], rows: Range<usize>) -> Result<(), Error> {
    let n_samples = |header: &Header| {
        let Vec2(width, height) = header.layer_size;
        let n_rows = rows.end.min(height).saturating_sub(rows.start);
        let n_channels = header.channels.list.len() as u128;
        n_channels * n_rows as u128 * width as u128
    };
    let needed = Bytes(4 * headers.iter().map(n_samples).sum::<u128>());
    let limit = memory_limit();
    if needed > limit {
        return Err(Error::Memory { needed, limit });
    }
    Ok(())
}

/// Reads the last block of each part, as it is packed: in a file that was cut short one is not there.
fn check_ends(source: impl Read + Seek) -> Result<(), Error> {
    let reader = exr::block::read(source, false)?;
    let is_last = |meta_data: &MetaData, _: TileCoordinates, block: BlockIndex| {
        let height = meta_data.headers[block.layer].layer_size.height();
        block.pixel_position.y() + block.pixel_size.height() == height
    };
    for block in reader.filter_chunks(false, is_last)? {
        block?;
    }
    Ok(())
}

fn pixel_bytes(header: &Header) -> u128 {
    let pixel_bytes = header.channels.bytes_per_pixel as u128;
    let (width, height) = (
        header.layer_size.width() as u128,
        header.layer_size.height() as u128,
    );
    pixel_bytes.saturating_mul(width).saturating_mul(height)
}

fn max_expansion(header: &Header) -> u128 {
    if header.compression == Compression::Uncompressed {
        1
    } else {
        MAX_EXPANSION
    }
}

fn batch_length(headers: &[Header]) -> usize {
    let longest = headers.iter().map(Header::max_block_byte_size).max();
    (BATCH_BYTES / longest.unwrap_or(BATCH_BYTES).max(1)).clamp(1, 4096)
}

/// Decompresses a chunk, unless it is too short for what it should become.
fn unpack(chunk: Chunk, meta_data: &MetaData) -> Result<UncompressedBlock, Error> {
    // Chunk::read has checked the index of the part.
    let header = &meta_data.headers[chunk.layer_index];
    let CompressedBlock::ScanLine(block) = &chunk.compressed_block else {
        return Err(Error::Layout {
            found: "tiles or deep data",
            expected: "scan lines",
        });
    };
    let location = header.get_block_data_indices(&chunk.compressed_block)?;
    let height = header
        .get_absolute_block_pixel_coordinates(location)?
        .size
        .height();
    let expected_bytes =
        (header.channels.bytes_per_pixel * header.layer_size.width() * height) as u128;
    let packed_bytes = block.compressed_pixels_le.len() as u128;
    let is_raw = packed_bytes == expected_bytes;
    let is_possible = header.compression != Compression::Uncompressed
        && packed_bytes < expected_bytes
        && expected_bytes <= MAX_EXPANSION * packed_bytes;
    if !is_raw && !is_possible {
        let message = format!("found {packed_bytes} bytes for {expected_bytes} bytes of pixels");
        return Err(Error::Damaged(message));
    }
    Ok(UncompressedBlock::decompress_chunk(
        chunk, meta_data, false,
    )?)
}

/// The pixels of some rows of a part while its blocks arrive.
struct Page {
    rows: Range<usize>,
    channels: Vec<Vec<f32>>,
    /// Whether the block of this index has come.
    seen: Vec<bool>,
}

impl Page {
    /// Reserves memory without touching it.
    fn new(header: &Header, rows: Range<usize>) -> Result<Self, Error> {
        let n_samples = rows.len() * header.layer_size.width();
        let n_channels = header.channels.list.len();
        let needed = Bytes(4 * n_samples as u128 * n_channels as u128);
        let mut channels = Vec::new();
        for _ in 0..n_channels {
            let mut samples = Vec::new();
            samples
                .try_reserve_exact(n_samples)
                .map_err(|_| Error::Memory {
                    needed,
                    limit: memory_limit(),
                })?;
            channels.push(samples);
        }
        Ok(Self {
            rows,
            channels,
            seen: vec![false; header.chunk_count],
        })
    }

    fn insert(&mut self, header: &Header, block: &UncompressedBlock) -> Result<(), Error> {
        let index = block.index.pixel_position.y() / header.compression.scan_lines_per_block();
        match self.seen.get_mut(index) {
            Some(seen) if !*seen => *seen = true,
            Some(_) | None => return Err(Error::Damaged(format!("found block {index} twice"))),
        }
        let width = header.layer_size.width();
        for (bytes, line) in LineIndex::lines_in_block(block.index, &header.channels) {
            if !self.rows.contains(&line.position.y()) {
                continue;
            }
            let samples = &mut self.channels[line.channel];
            let start = (line.position.y() - self.rows.start) * width;
            if samples.len() < start + width {
                samples.resize(start + width, 0.0);
            }
            let sample_type = header.channels.list[line.channel].sample_type;
            decode(
                sample_type,
                &block.data[bytes],
                &mut samples[start..start + width],
            );
        }
        Ok(())
    }

    fn finish(self, header: &Header) -> Result<Part<'static>, Error> {
        let size = (self.rows.len(), header.layer_size.width());
        let own = &header.own_attributes;
        let name = name(header);
        let mut channels = Vec::with_capacity(self.channels.len());
        for (description, samples) in header.channels.list.iter().zip(self.channels) {
            let channel = text(&description.name);
            let found = samples.len();
            let what = || format!("pixels in channel {channel:?} of part {name:?}");
            let shape = |_| Error::Shape {
                what: what(),
                found,
                expected: size.0 * size.1,
            };
            let samples = Array2::from_shape_vec(size, samples).map_err(shape)?;
            channels.push((channel, samples.into()));
        }
        let windows = windows(header)?;
        Ok(Part {
            name,
            channels,
            halves: {
                let channels = header.channels.list.iter();
                let halves = channels.filter(|it| it.sample_type == SampleType::F16);
                halves.map(|it| text(&it.name)).collect()
            },
            tells_rms: false,
            attributes: attributes(header),
            white_luminance_cd_m2: own.white_luminance,
            primaries: RgbPrimaries::Rec709,
            world_to_camera: own.world_to_camera,
            windows: Some(ImageWindows {
                data: PixelRegion {
                    y_px: windows.data.y_px.saturating_add(self.rows.start as i32),
                    height_px: self.rows.len() as u32,
                    ..windows.data
                },
                ..windows
            }),
        })
    }
}

/// The name of a part, empty where it has none.
fn name(header: &Header) -> String {
    let name = header.own_attributes.layer_name.as_ref();
    name.map(text).unwrap_or_default()
}

fn windows(header: &Header) -> Result<ImageWindows, Error> {
    Ok(ImageWindows {
        data: region(header.data_window())?,
        display: region(header.shared_attributes.display_window)?,
    })
}

/// A window of the format.
fn region(bounds: IntegerBounds) -> Result<PixelRegion, Error> {
    let too_large = |_| Error::Damaged("found a window of more than 2^32 pixels".to_owned());
    Ok(PixelRegion {
        x_px: bounds.position.x(),
        y_px: bounds.position.y(),
        width_px: u32::try_from(bounds.size.width()).map_err(too_large)?,
        height_px: u32::try_from(bounds.size.height()).map_err(too_large)?,
    })
}

/// Samples from bytes in the order of this machine, as `exr` hands them out.
fn decode(sample_type: SampleType, bytes: &[u8], target: &mut [f32]) {
    match sample_type {
        SampleType::F32 => {
            for (target, bytes) in target.iter_mut().zip(bytes.as_chunks::<4>().0) {
                *target = f32::from_ne_bytes(*bytes);
            }
        }
        SampleType::F16 => {
            for (target, bytes) in target.iter_mut().zip(bytes.as_chunks::<2>().0) {
                *target = f16::from_ne_bytes(*bytes).to_f32();
            }
        }
        SampleType::U32 => {
            for (target, bytes) in target.iter_mut().zip(bytes.as_chunks::<4>().0) {
                // Integers above 2^24 lose digits; no file of ours holds any.
                *target = u32::from_ne_bytes(*bytes) as f32;
            }
        }
    }
}

/// The texts and numbers of a header, when its frame is shown and how wide it looks; other kinds belong to other programs.
fn attributes(header: &Header) -> Attributes {
    let mut attributes = Attributes::new();
    if let Some((rate, of)) = header
        .own_attributes
        .frames_per_second
        .filter(|it| it.1 > 0)
    {
        let rate = AttributeValue::Number(f64::from(rate) / f64::from(of));
        attributes.insert(frame_time::FRAMES_PER_SECOND.to_owned(), rate);
    }
    if let Some(code) = &header.shared_attributes.time_code {
        let code = AttributeValue::Text(frame_time::time_code_text(code));
        attributes.insert(frame_time::TIME_CODE.to_owned(), code);
    }
    let width = header.own_attributes.screen_window_width;
    if width.to_bits() != 1.0_f32.to_bits() {
        let width = AttributeValue::Number(f64::from(width));
        attributes.insert(WINDOW_WIDTH.to_owned(), width);
    }
    for (name, value) in &header.own_attributes.other {
        let value = match value {
            ExrValue::Text(value) => AttributeValue::Text(text(value)),
            ExrValue::F64(number) => AttributeValue::Number(*number),
            ExrValue::F32(number) => AttributeValue::Number(f64::from(*number)),
            _ => continue,
        };
        attributes.insert(text(name), value);
    }
    attributes
}

/// UTF-8, or Latin-1 where it is none.
fn text(text: &Text) -> String {
    std::str::from_utf8(text.as_slice()).map_or_else(|_| text.to_string(), str::to_owned)
}
