//! Writes parts as an EXR file whose bytes depend on nothing but the parts.
//!
//! Layout: magic number and version, for each part its attributes by name, the offsets of all
//! chunks, the chunks from top to bottom, part by part. Chunks are compressed in parallel and written
//! in order, so that the number of threads changes nothing. The frame is written here because the
//! writer of the `exr` crate takes the attributes of a header in the order of a hash map, which
//! differs from run to run; attributes, chunks and codecs themselves are its own.
//! [EXR] OpenEXR file layout, openexr.com/en/latest/OpenEXRFileLayout.html.

use std::io::BufWriter;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;

use exr::block::BlockIndex;
use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::attribute;
use exr::meta::attribute::AttributeValue as ExrValue;
use exr::meta::attribute::ChannelDescription;
use exr::meta::attribute::Chromaticities;
use exr::meta::attribute::IntegerBounds;
use exr::meta::attribute::LineOrder;
use exr::meta::attribute::SampleType;
use exr::meta::attribute::Text;
use exr::meta::header::Header;
use exr::meta::header::ImageAttributes;
use exr::meta::header::LayerAttributes;
use exr::prelude::f16;
use niji_geometry::PixelRegion;
use niji_radiometry::RgbPrimaries;
use rayon::prelude::*;

use crate::attributes::AttributeValue;
use crate::attributes::WINDOW_WIDTH;
use crate::checksum;
use crate::error::Error;
use crate::frame_time;
use crate::part::Part;

/// Pixels that are compressed at a time: enough work for many threads, little memory.
const BATCH_BYTES: usize = 32 << 20;

/// Codec of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    /// For tables, which are made once and read by every run: deflate takes 5 % off a scattering
    /// table.
    None,
    /// For noisy pictures: a quarter smaller than deflate and three times as fast to write.
    Piz,
}

/// A part with what its header needs.
struct Sheet<'a, 'p> {
    part: &'a Part<'p>,
    /// Channel indices of the part in the order of their names, which the format wants.
    order: Vec<usize>,
}

/// Writes parts in their order, from the current position of the writer.
///
/// # Errors
/// A value or number of a header that is not finite, a name the format cannot hold, no pixels, channels of several
/// sizes, two parts of one name, or a writer that fails.
pub(crate) fn write(parts: &[Part], codec: Codec, writer: impl Write + Seek) -> Result<(), Error> {
    for (index, part) in parts.iter().enumerate() {
        part.check(parts.len() == 1)?;
        if parts[..index]
            .iter()
            .any(|earlier| earlier.name == part.name)
        {
            return Err(Error::Duplicate {
                kind: "part",
                name: part.name.clone(),
            });
        }
    }
    let sheets: Vec<Sheet> = parts.iter().map(Sheet::new).collect();
    let shared = shared_attributes(parts);
    let headers = sheets.iter().map(|sheet| sheet.header(codec, &shared));
    let headers: Vec<Header> = headers.collect();
    let mut bytes = header_bytes(&headers)?;
    let n_chunks: usize = headers.iter().map(|header| header.chunk_count).sum();
    let table_start = bytes.len();
    bytes.resize(table_start + n_chunks * size_of::<u64>(), 0);

    let mut writer = BufWriter::with_capacity(1 << 20, writer);
    let start = writer.stream_position()?;
    writer.write_all(&bytes)?;
    let chunks = ChunkWriter {
        headers,
        at: bytes.len() as u64,
        offsets: Vec::new(),
    };
    let offsets = chunks.write_all(&sheets, &mut writer)?;
    writer.seek(SeekFrom::Start(start + table_start as u64))?;
    for offset in offsets {
        writer.write_all(&offset.to_le_bytes())?;
    }
    Ok(writer.flush()?)
}

impl<'a, 'p> Sheet<'a, 'p> {
    fn new(part: &'a Part<'p>) -> Self {
        let mut order: Vec<usize> = (0..part.channels.len()).collect();
        order.sort_by(|&a, &b| part.channels[a].0.cmp(&part.channels[b].0));
        Self { part, order }
    }

    fn header(&self, codec: Codec, shared: &ImageAttributes) -> Header {
        let channel = |&index: &usize| {
            let name = &self.part.channels[index].0;
            let sample = if self.part.halves.contains(name) {
                SampleType::F16
            } else {
                SampleType::F32
            };
            // Not perceptually quantized: matters to lossy codecs only.
            ChannelDescription::new(text(name), sample, true)
        };
        let compression = match codec {
            Codec::None => Compression::Uncompressed,
            Codec::Piz => Compression::PIZ,
        };
        let (part_height, part_width) = self.part.size();
        let size = Vec2(part_width, part_height);
        Header::new(
            text(&self.part.name),
            size,
            self.order.iter().map(channel).collect(),
        )
        .with_encoding(
            compression,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_attributes(self.attributes())
        .with_shared_attributes(shared.clone())
    }

    fn attributes(&self) -> LayerAttributes {
        let mut attributes = LayerAttributes::named(text(&self.part.name));
        attributes
            .layer_name
            .take_if(|name| name.as_slice().is_empty());
        attributes.white_luminance = self.part.white_luminance_cd_m2;
        attributes.world_to_camera = self.part.world_to_camera;
        if let Some(windows) = self.part.windows {
            attributes.layer_position = bounds(windows.data).position;
        }
        let checksum = AttributeValue::Text(checksum::of(self.part));
        let own = self
            .part
            .attributes
            .iter()
            .filter(|(name, _)| *name != checksum::NAME);
        for (name, value) in own.chain([(&checksum::NAME.to_owned(), &checksum)]) {
            let value = match (name.as_str(), value) {
                // All parts have it alike.
                (frame_time::TIME_CODE, _) => continue,
                (frame_time::FRAMES_PER_SECOND, AttributeValue::Number(rate)) => {
                    attributes.frames_per_second = Some(frame_time::fraction(*rate));
                    continue;
                }
                (WINDOW_WIDTH, AttributeValue::Number(width)) => {
                    attributes.screen_window_width = *width as f32;
                    continue;
                }
                (_, AttributeValue::Text(value)) => ExrValue::Text(text(value)),
                (_, AttributeValue::Number(number)) => ExrValue::F64(*number),
            };
            attributes.other.insert(text(name), value);
        }
        attributes
    }

    /// Samples of one block: line by line, in each line channel by channel.
    fn block(&self, header: &Header, index: BlockIndex) -> UncompressedBlock {
        UncompressedBlock::from_lines(&header.channels, index, |line| {
            let channel = line.location.channel;
            let samples = &self.part.channels[self.order[channel]].1;
            let row = samples.row(line.location.position.y());
            if header.channels.list[channel].sample_type == SampleType::F16 {
                let (targets, _) = line.value.as_chunks_mut();
                for (target, value) in targets.iter_mut().zip(row) {
                    *target = f16::from_f32(*value).to_ne_bytes();
                }
            } else {
                let (targets, _) = line.value.as_chunks_mut();
                for (target, value) in targets.iter_mut().zip(row) {
                    *target = value.to_ne_bytes();
                }
            }
        })
    }
}

/// What all headers of a file share: the display window of the first part that has one, or one around
/// all parts, what R, G, B mean if a part has a white, and the time code of a part that has one.
fn shared_attributes(parts: &[Part]) -> ImageAttributes {
    let sizes = parts.iter().map(Part::size);
    let (height, width) = sizes.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let around = IntegerBounds::from_dimensions((width, height));
    let windows = parts.iter().find_map(|part| part.windows);
    let display = windows.map_or(around, |windows| bounds(windows.display));
    let mut shared = ImageAttributes::new(display);
    let mut with_white = parts
        .iter()
        .filter(|part| part.white_luminance_cd_m2.is_some());
    let mut codes = parts
        .iter()
        .filter_map(|part| part.text(frame_time::TIME_CODE).ok());
    shared.time_code = codes.find_map(frame_time::time_code);
    shared.chromaticities = with_white.next().map(|part| chromaticities(part.primaries));
    shared
}

/// A region as the format has it.
fn bounds(region: PixelRegion) -> IntegerBounds {
    IntegerBounds {
        position: Vec2(region.x_px, region.y_px),
        size: Vec2(region.width_px as usize, region.height_px as usize),
    }
}

/// What red, green, blue and white are, as the format has it.
fn chromaticities(primaries: RgbPrimaries) -> Chromaticities {
    // f32: what the format holds.
    let [red, green, blue, white] = primaries
        .chromaticities()
        .map(|[x, y]| Vec2(x as f32, y as f32));
    Chromaticities {
        red,
        green,
        blue,
        white,
    }
}

/// UTF-8, as OpenEXR has it; the `From` of `exr` panics beyond Latin-1.
fn text(text: &str) -> Text {
    Text::from_bytes_unchecked(text.as_bytes().into())
}

/// Everything in front of the offsets.
fn header_bytes(headers: &[Header]) -> Result<Vec<u8>, Error> {
    let unwritable = |error: exr::error::Error| Error::Unwritable(error.to_string());
    let requirements = MetaData::validate(headers, true).map_err(unwritable)?;
    let mut bytes = Vec::new();
    exr::meta::magic_number::write(&mut bytes).map_err(unwritable)?;
    requirements.write(&mut bytes).map_err(unwritable)?;
    for header in headers {
        let mut attributes: Vec<_> = header.all_named_attributes().collect();
        attributes.sort_by(|a, b| a.0.cmp(b.0));
        for (name, value) in attributes {
            attribute::write(name, &value, &mut bytes).map_err(unwritable)?;
        }
        bytes.push(0);
    }
    if requirements.is_multilayer() {
        bytes.push(0);
    }
    Ok(bytes)
}

/// Writes chunks one behind the other and remembers where each begins.
struct ChunkWriter {
    headers: Vec<Header>,
    at: u64,
    offsets: Vec<u64>,
}

impl ChunkWriter {
    fn write_all(mut self, sheets: &[Sheet], writer: &mut impl Write) -> Result<Vec<u64>, Error> {
        for (layer, sheet) in sheets.iter().enumerate() {
            let n_per_batch = (BATCH_BYTES / self.headers[layer].max_block_byte_size()).max(1);
            let blocks = blocks(layer, &self.headers[layer]);
            for batch in blocks.chunks(n_per_batch) {
                let headers = &self.headers;
                let chunks: Result<Vec<Chunk>, exr::error::Error> = batch
                    .par_iter()
                    .map(|&index| {
                        sheet
                            .block(&headers[layer], index)
                            .compress_to_chunk(headers)
                    })
                    .collect();
                let chunks = chunks.map_err(|error| Error::Unwritable(error.to_string()))?;
                for chunk in &chunks {
                    self.write(chunk, writer)?;
                }
            }
        }
        Ok(self.offsets)
    }

    fn write(&mut self, chunk: &Chunk, writer: &mut impl Write) -> Result<(), Error> {
        let CompressedBlock::ScanLine(block) = &chunk.compressed_block else {
            return Err(Error::Unwritable(
                "found a tile, expected scan lines".to_owned(),
            ));
        };
        let mut front = Vec::with_capacity(12);
        if self.headers.len() > 1 {
            front.extend_from_slice(&(chunk.layer_index as i32).to_le_bytes());
        }
        front.extend_from_slice(&block.y_coordinate.to_le_bytes());
        let n_bytes = i32::try_from(block.compressed_pixels_le.len());
        let too_long = |_| Error::Unwritable("a block is longer than 2 GiB".to_owned());
        front.extend_from_slice(&n_bytes.map_err(too_long)?.to_le_bytes());
        writer.write_all(&front)?;
        writer.write_all(&block.compressed_pixels_le)?;
        self.offsets.push(self.at);
        self.at += (front.len() + block.compressed_pixels_le.len()) as u64;
        Ok(())
    }
}

/// The blocks of a part from top to bottom.
fn blocks(layer: usize, header: &Header) -> Vec<BlockIndex> {
    let Vec2(width, height) = header.layer_size;
    let n_lines = header.compression.scan_lines_per_block();
    (0..header.chunk_count)
        .map(|index| BlockIndex {
            layer,
            pixel_position: Vec2(0, index * n_lines),
            pixel_size: Vec2(width, n_lines.min(height - index * n_lines)),
            level: Vec2(0, 0),
        })
        .collect()
}
