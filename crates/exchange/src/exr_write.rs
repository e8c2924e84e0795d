//! Writes parts as an EXR file whose bytes depend on nothing but the parts.
//!
//! Layout: magic number and version, for each part its attributes by name, the offsets of all
//! chunks, the chunks. Rows are written as they come: those of parts that come together from top to bottom, at each
//! height part by part, in whichever pieces they come. What the header tells of all rows (checksums, root mean
//! squares) has a place of its size in it, and is put there last. Chunks are compressed in parallel and written
//! in order, so that the number of threads changes nothing. The frame is written here because the
//! writer of the `exr` crate takes the attributes of a header in the order of a hash map, which
//! differs from run to run; attributes, chunks and codecs themselves are its own.
//! [EXR] OpenEXR file layout, openexr.com/en/latest/OpenEXRFileLayout.html.

use std::io::BufWriter;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;
use std::ops::Range;

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
use crate::checksum::ChannelHashes;
use crate::error::Error;
use crate::frame_time;
use crate::layer_rms;
use crate::part::Part;
use crate::part::append;

/// Pixels that are compressed at a time, or a chunk for each thread: enough work for many of them, little memory.
const BATCH_BYTES: usize = 64 << 20;

/// Codec of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    /// For tables, which are made once and read by every run: deflate takes 5 % off a scattering
    /// table.
    None,
    /// For noisy pictures: a quarter smaller than deflate and three times as fast to write.
    Piz,
}

/// Writes parts in their order, from the current position of the writer.
///
/// # Errors
/// A value or number of a header that is not finite, a name the format cannot hold, no pixels, channels of several
/// sizes, two parts of one name, or a writer that fails.
pub(crate) fn write(parts: &[Part], codec: Codec, writer: impl Write + Seek) -> Result<(), Error> {
    let heads = parts.iter().map(|part| (part, part.size()));
    let mut rows = PartsWriter::new(&heads.collect::<Vec<_>>(), codec, writer)?;
    for (index, part) in parts.iter().enumerate() {
        rows.add(index, std::slice::from_ref(part))?;
    }
    rows.finish()
}

/// A part while its rows are written.
struct Sheet {
    /// Without its samples.
    head: Part<'static>,
    /// Rows and columns in all.
    size: (usize, usize),
    /// Channel indices of the part in the order of their names, which the format wants.
    order: Vec<usize>,
    n_rows: usize,
    hashes: ChannelHashes,
    /// Sums of the squares of each channel.
    squares: Vec<f64>,
    /// Lines of a chunk that has not come to its end.
    begun: Vec<u8>,
    /// Where its chunks begin.
    offsets: Vec<u64>,
}

/// Parts of a file while their rows are written.
pub(crate) struct PartsWriter<W: Write + Seek> {
    sheets: Vec<Sheet>,
    codec: Codec,
    headers: Vec<Header>,
    writer: BufWriter<W>,
    start: u64,
    at: u64,
}

/// A chunk that rows complete.
struct ChunkPlace {
    sheet: usize,
    /// Its part among those that come together.
    part: usize,
    block: BlockIndex,
}

impl<W: Write + Seek> PartsWriter<W> {
    /// Begins a file of parts with so many rows and columns; of the parts that stand for them rows do not count.
    ///
    /// # Errors
    /// As [`write`].
    pub(crate) fn new(
        parts: &[(&Part, (usize, usize))],
        codec: Codec,
        writer: W,
    ) -> Result<Self, Error> {
        for (index, (part, size)) in parts.iter().enumerate() {
            part.check(*size, parts.len() == 1)?;
            if parts[..index].iter().any(|(it, _)| it.name == part.name) {
                return Err(Error::Duplicate {
                    kind: "part",
                    name: part.name.clone(),
                });
            }
        }
        let sheets = parts.iter().map(|(part, size)| Sheet::new(part, *size));
        let mut sheets: Vec<Sheet> = sheets.collect();
        let headers = headers(&mut sheets, codec);
        let n_chunks: usize = headers.iter().map(|header| header.chunk_count).sum();
        let mut bytes = header_bytes(&headers)?;
        bytes.resize(bytes.len() + n_chunks * size_of::<u64>(), 0);
        let mut writer = BufWriter::with_capacity(1 << 20, writer);
        let start = writer.stream_position()?;
        writer.write_all(&bytes)?;
        Ok(Self {
            sheets,
            codec,
            headers,
            writer,
            start,
            at: bytes.len() as u64,
        })
    }

    /// The parts without their samples.
    pub(crate) fn heads(&self) -> impl Iterator<Item = &Part<'static>> {
        self.sheets.iter().map(|sheet| &sheet.head)
    }

    /// Adds rows of parts that come together, the first of which is this one.
    ///
    /// # Errors
    /// Rows of another size, a value that is not finite, or a writer that fails.
    pub(crate) fn add(&mut self, first: usize, parts: &[Part]) -> Result<(), Error> {
        for (sheet, part) in self.sheets[first..].iter_mut().zip(parts) {
            part.check_rows_of(&sheet.head, (sheet.n_rows, sheet.size))?;
            part.check_values(sheet.n_rows)?;
            sheet.hashes.add(&part.channels);
            if sheet.head.tells_rms {
                let channels = part.channels.par_iter().map(|(_, samples)| samples);
                let sums = sheet.squares.par_iter_mut().zip(channels);
                sums.for_each(|(sum, samples)| *sum = layer_rms::add_squares(*sum, samples));
            }
        }
        let places = self.completed(first, parts);
        for batch in self.batches(&places) {
            let packed = batch.par_iter().with_max_len(1).map(|place| {
                let sheet = &self.sheets[place.sheet];
                let data = sheet.lines(&self.headers[place.sheet], &parts[place.part], place.block);
                let index = place.block;
                UncompressedBlock { index, data }.compress_to_chunk(&self.headers)
            });
            let chunks: Result<Vec<Chunk>, exr::error::Error> = packed.collect();
            for chunk in chunks.map_err(|error| Error::Unwritable(error.to_string()))? {
                self.write(&chunk)?;
            }
        }
        for (index, part) in parts.iter().enumerate() {
            let index = first + index;
            self.sheets[index].keep_rest(&self.headers[index], part);
        }
        Ok(())
    }

    /// Chunks that are compressed at a time.
    fn batches<'a>(&self, places: &'a [ChunkPlace]) -> Vec<&'a [ChunkPlace]> {
        let n_threads = rayon::current_num_threads();
        let n_bytes = |place: &ChunkPlace| {
            let bytes_per_pixel = self.headers[place.sheet].channels.bytes_per_pixel;
            place.block.pixel_size.area() * bytes_per_pixel
        };
        let (mut batches, mut first, mut sum) = (Vec::new(), 0, 0);
        for (index, place) in places.iter().enumerate() {
            sum += n_bytes(place);
            let is_last = index + 1 == places.len();
            if is_last || (sum >= BATCH_BYTES && index + 1 - first >= n_threads) {
                batches.push(&places[first..=index]);
                (first, sum) = (index + 1, 0);
            }
        }
        batches
    }

    /// The chunks that rows complete, from top to bottom.
    fn completed(&self, first: usize, parts: &[Part]) -> Vec<ChunkPlace> {
        let mut places = Vec::new();
        for (part, rows) in parts.iter().enumerate() {
            let (sheet, header) = (&self.sheets[first + part], &self.headers[first + part]);
            let n_lines = header.compression.scan_lines_per_block();
            let end = sheet.n_rows + rows.size().0;
            let completed = if end == sheet.size.0 {
                end.div_ceil(n_lines)
            } else {
                end / n_lines
            };
            places.extend((sheet.n_rows / n_lines..completed).map(|index| ChunkPlace {
                sheet: first + part,
                part,
                block: BlockIndex {
                    layer: first + part,
                    pixel_position: Vec2(0, index * n_lines),
                    pixel_size: Vec2(sheet.size.1, n_lines.min(sheet.size.0 - index * n_lines)),
                    level: Vec2(0, 0),
                },
            }));
        }
        places.sort_by_key(|place| (place.block.pixel_position.y(), place.part));
        places
    }

    fn write(&mut self, chunk: &Chunk) -> Result<(), Error> {
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
        self.writer.write_all(&front)?;
        self.writer.write_all(&block.compressed_pixels_le)?;
        self.sheets[chunk.layer_index].offsets.push(self.at);
        self.at += (front.len() + block.compressed_pixels_le.len()) as u64;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Rows that are missing or a writer that fails.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        for sheet in &self.sheets {
            if sheet.n_rows != sheet.size.0 {
                return Err(Error::Shape {
                    what: format!("rows of part {:?}", sheet.head.name),
                    found: sheet.n_rows,
                    expected: sheet.size.0,
                });
            }
        }
        let headers = headers(&mut self.sheets, self.codec);
        self.writer.seek(SeekFrom::Start(self.start))?;
        self.writer.write_all(&header_bytes(&headers)?)?;
        for offset in self.sheets.iter().flat_map(|sheet| &sheet.offsets) {
            self.writer.write_all(&offset.to_le_bytes())?;
        }
        Ok(self.writer.flush()?)
    }
}

/// The headers of parts, with what their rows that have come make of them.
fn headers(sheets: &mut [Sheet], codec: Codec) -> Vec<Header> {
    let shared = shared_attributes(sheets);
    let headers = sheets.iter_mut().map(|sheet| sheet.header(codec, &shared));
    headers.collect()
}

impl Sheet {
    fn new(part: &Part, size: (usize, usize)) -> Self {
        let mut order: Vec<usize> = (0..part.channels.len()).collect();
        order.sort_by(|&a, &b| part.channels[a].0.cmp(&part.channels[b].0));
        Self {
            head: part.head(),
            size,
            n_rows: 0,
            hashes: ChannelHashes::new(order.len()),
            squares: vec![0.0; order.len()],
            order,
            begun: Vec::new(),
            offsets: Vec::new(),
        }
    }

    fn header(&mut self, codec: Codec, shared: &ImageAttributes) -> Header {
        if self.head.tells_rms {
            for ((name, _), sum) in self.head.channels.iter().zip(&self.squares) {
                let rms = layer_rms::of_squares(*sum, self.size.0 * self.size.1);
                let value = AttributeValue::Number(rms);
                (self.head.attributes).insert(layer_rms::attribute(name), value);
            }
        }
        let channel = |&index: &usize| {
            let name = &self.head.channels[index].0;
            let sample = if self.head.halves.contains(name) {
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
        let (height, width) = self.size;
        let channels = self.order.iter().map(channel).collect();
        Header::new(text(&self.head.name), Vec2(width, height), channels)
            .with_encoding(
                compression,
                BlockDescription::ScanLines,
                LineOrder::Increasing,
            )
            .with_attributes(self.attributes())
            .with_shared_attributes(shared.clone())
    }

    fn attributes(&self) -> LayerAttributes {
        let mut attributes = LayerAttributes::named(text(&self.head.name));
        attributes
            .layer_name
            .take_if(|name| name.as_slice().is_empty());
        attributes.white_luminance = self.head.white_luminance_cd_m2;
        attributes.world_to_camera = self.head.world_to_camera;
        if let Some(windows) = self.head.windows {
            attributes.layer_position = bounds(windows.data).position;
        }
        let checksum = AttributeValue::Text(self.hashes.checksum(&self.head, self.size));
        let own = self
            .head
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

    /// The lines of a chunk that these rows complete.
    fn lines(&self, header: &Header, rows: &Part, block: BlockIndex) -> Vec<u8> {
        let top = block.pixel_position.y();
        let bottom = top + block.pixel_size.height();
        let mut bytes = Vec::with_capacity(header.max_block_byte_size());
        if top < self.n_rows {
            bytes.extend_from_slice(&self.begun);
        }
        let rows_of_block = top.max(self.n_rows) - self.n_rows..bottom - self.n_rows;
        self.append_lines(&mut bytes, rows, rows_of_block);
        bytes
    }

    /// Takes rows as written, and keeps the lines of the chunk that they begin.
    fn keep_rest(&mut self, header: &Header, rows: &Part) {
        let end = self.n_rows + rows.size().0;
        let n_lines = header.compression.scan_lines_per_block();
        let top = if end == self.size.0 {
            end
        } else {
            end - end % n_lines
        };
        let mut begun = std::mem::take(&mut self.begun);
        if top > self.n_rows {
            begun.clear();
        }
        self.append_lines(
            &mut begun,
            rows,
            top.max(self.n_rows) - self.n_rows..rows.size().0,
        );
        self.begun = begun;
        self.n_rows = end;
    }

    /// Appends rows line by line, in each line channel by channel.
    fn append_lines(&self, bytes: &mut Vec<u8>, part: &Part, rows: Range<usize>) {
        for row in rows {
            for &channel in &self.order {
                let (name, samples) = &part.channels[channel];
                let values = samples.row(row);
                if self.head.halves.contains(name) {
                    append(bytes, &values, |it| f16::from_f32(it).to_ne_bytes());
                } else {
                    append(bytes, &values, f32::to_ne_bytes);
                }
            }
        }
    }
}

/// What all headers of a file share: the display window of the first part that has one, or one around
/// all parts, what R, G, B mean if a part has a white, and the time code of a part that has one.
fn shared_attributes(sheets: &[Sheet]) -> ImageAttributes {
    let sizes = sheets.iter().map(|sheet| sheet.size);
    let (height, width) = sizes.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let around = IntegerBounds::from_dimensions((width, height));
    let parts = sheets.iter().map(|sheet| &sheet.head);
    let windows = parts.clone().find_map(|part| part.windows);
    let display = windows.map_or(around, |windows| bounds(windows.display));
    let mut shared = ImageAttributes::new(display);
    let mut with_white = parts
        .clone()
        .filter(|part| part.white_luminance_cd_m2.is_some());
    let mut codes = parts.filter_map(|part| part.text(frame_time::TIME_CODE).ok());
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
