//! Files of a spectral image, whose rows are written as they come from the top, and read so.
//!
//! A picture need not be in memory to become a file: of its rows come some at a time, and the file has the same bytes
//! whatever number comes at once.

use std::collections::BTreeSet;
use std::io::Seek;
use std::io::Write;
use std::path::Path;

use ndarray::Axis as Dimension;
use niji_geometry::PixelRegion;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;

use crate::attributes;
use crate::attributes::AttributeValue;
use crate::error::Error;
use crate::exr_write::Codec;
use crate::exr_write::PartsWriter;
use crate::layers_file::XYZ;
use crate::layers_file::rgb_channels;
use crate::part::Part;
use crate::part::Samples;
use crate::provenance::Provenance;
use crate::spectra::LUMINANCE;
use crate::spectra::Spectra;
use crate::spectral_image::AOV_UNIT;
use crate::spectral_image::COLOR_PART;
use crate::spectral_image::EMISSIVE_UNITS;
use crate::spectral_image::LAYOUT_VERSION;
use crate::spectral_image::SPECTRAL_PART;
use crate::spectral_image::SPECTRAL_UNIT;
use crate::spectral_image::STOKES_0;
use crate::spectral_image::SpectralImage;
use crate::strips::PartsReader;
use crate::strips::rows_of_strip;
use crate::wavelength_names;
use crate::wavelength_names::long_name;

/// A file that a spectral image becomes.
#[derive(Clone, Copy, Debug)]
pub enum PictureFile {
    /// The image with all its AOVs. Without spectra it has X, Y, Z in their place.
    Spectral,
    /// R, G, B, A, Z, every AOV of X, Y and Z as a layer of R, G and B, and distances. A bow is added light: R, G, B may
    /// be above 0 where A is 0.
    Layers(RgbPrimaries),
}

/// Channels, by the names of their parts and their own, with values that half floats cannot hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BeyondHalf(BTreeSet<(String, String)>);

/// What is known of a file before its first row.
#[derive(Clone, Debug)]
pub struct PictureHead {
    /// Which file.
    pub file: PictureFile,
    /// The pixels of the picture.
    pub pixels: PixelRegion,
    /// Where it comes from.
    pub provenance: Provenance,
    /// Channels that are half floats elsewhere and float in this file.
    pub floats: BeyondHalf,
}

impl PictureHead {
    /// Of a file without channels that have to be float.
    #[must_use]
    pub fn new(file: PictureFile, pixels: PixelRegion, provenance: Provenance) -> Self {
        Self {
            file,
            pixels,
            provenance,
            floats: BeyondHalf::default(),
        }
    }
}

/// A file of a picture while its rows are written.
pub struct StripWriter<W: Write + Seek> {
    head: PictureHead,
    beyond: BeyondHalf,
    /// Until the first row.
    writer: Option<W>,
    /// From then on.
    file: Option<PartsWriter<W>>,
}

impl BeyondHalf {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn add(&mut self, parts: &[Part]) {
        for part in parts {
            let channels = part.beyond_half().map(str::to_owned);
            (self.0).extend(channels.map(|channel| (part.name.clone(), channel)));
        }
    }
}

impl<W: Write + Seek> StripWriter<W> {
    /// Before the first row.
    pub fn new(head: PictureHead, writer: W) -> Self {
        Self {
            head,
            beyond: BeyondHalf::default(),
            writer: Some(writer),
            file: None,
        }
    }

    /// Adds the next rows.
    ///
    /// # Errors
    /// A value that is not finite, an AOV of another size, rows of another picture or more than it has, or a writer
    /// that fails.
    pub fn add(&mut self, rows: &SpectralImage) -> Result<(), Error> {
        rows.check_shape()?;
        let head = &self.head;
        let mut parts = head.file.parts(rows, &head.provenance);
        for part in &mut parts {
            let floats = &head.floats.0;
            let is_float = |it: &String| floats.contains(&(part.name.clone(), it.clone()));
            part.halves.retain(|channel| !is_float(channel));
            if let Some(windows) = &mut part.windows {
                windows.data = head.pixels;
            }
        }
        self.beyond.add(&parts);
        if let Some(writer) = self.writer.take() {
            let size = [head.pixels.height_px, head.pixels.width_px].map(|it| it as usize);
            let heads: Vec<_> = parts.iter().map(|part| (part, size.into())).collect();
            self.file = Some(PartsWriter::new(&heads, Codec::Piz, writer)?);
        }
        let no_rows = self.no_rows();
        let file = self.file.as_mut().ok_or(no_rows)?;
        // Rows that come from files have channels in the order of their names.
        for (part, head) in parts.iter_mut().zip(file.heads()) {
            part.order_as(head);
        }
        file.add(0, &parts)
    }

    /// Of a file that was not begun.
    fn no_rows(&self) -> Error {
        Error::Shape {
            what: "rows of the picture".to_owned(),
            found: 0,
            expected: self.head.pixels.height_px as usize,
        }
    }

    /// Ends the file, and gives channels that its half floats do not hold: if there are any, it has to be written again
    /// with these as floats.
    ///
    /// # Errors
    /// Rows that are missing or a writer that fails.
    pub fn finish(self) -> Result<BeyondHalf, Error> {
        let no_rows = self.no_rows();
        self.file.ok_or(no_rows)?.finish()?;
        Ok(self.beyond)
    }
}

/// How much is read of the file of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Spectra, or colors where these were left out.
    Light,
    /// AOVs, too.
    All,
}

/// The rows of a file of a picture from the top, some at a time: nothing is compared with its checksums, which are of all
/// rows. After an error there are no more.
#[derive(Clone, Debug)]
pub struct StripReader(PartsReader);

impl StripReader {
    /// Before the first row, and what is the same in all.
    ///
    /// # Errors
    /// As [`SpectralImage::read_picture`], as far as headers show it.
    pub fn open(path: &Path, held: Held) -> Result<(Self, SpectralImage), Error> {
        let n_parts = match held {
            Held::Light => 1,
            Held::All => usize::MAX,
        };
        let parts = PartsReader::open(path, n_parts)?;
        let image = SpectralImage {
            windows: parts.windows(),
            ..SpectralImage::of_parts(parts.no_rows()?)?
        };
        Ok((Self(parts), image))
    }
}

impl Iterator for StripReader {
    type Item = Result<SpectralImage, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next(SpectralImage::of_parts)
    }
}

impl SpectralImage {
    /// Its rows from the top, some at a time.
    pub fn strips(&self) -> impl Iterator<Item = Self> {
        let (n_planes, height, width) = self.radiance.dim();
        let n_channels: usize = self.aovs.iter().map(|aov| aov.channels.len()).sum();
        let n_rows = rows_of_strip(size_of::<f32>() * width * (n_planes + n_channels));
        // Of no rows there is one strip.
        let tops = (0..height.max(1)).step_by(n_rows);
        tops.map(move |top| self.rows(top..height.min(top.saturating_add(n_rows))))
    }

    /// Writes one of its files.
    ///
    /// # Errors
    /// A value that is not finite, an AOV of another size, or a writer that fails.
    pub fn write(&self, file: PictureFile, writer: impl Write + Seek) -> Result<(), Error> {
        self.check_shape()?;
        let mut floats = BeyondHalf::default();
        if file.packs(self) {
            for strip in self.strips() {
                floats.add(&file.parts(&strip, &self.provenance));
            }
        }
        let head = PictureHead {
            floats,
            ..PictureHead::new(file, self.windows.data, self.provenance.clone())
        };
        let mut rows = StripWriter::new(head, writer);
        for strip in self.strips() {
            rows.add(&strip)?;
        }
        rows.finish().map(|_| ())
    }

    /// Writes [`PictureFile::Spectral`].
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_spectral(&self, writer: impl Write + Seek) -> Result<(), Error> {
        self.write(PictureFile::Spectral, writer)
    }

    /// Writes [`PictureFile::Layers`].
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_layers(
        &self,
        primaries: RgbPrimaries,
        writer: impl Write + Seek,
    ) -> Result<(), Error> {
        self.write(PictureFile::Layers(primaries), writer)
    }

    /// The parts of the spectral file.
    fn spectral_parts(&self) -> Vec<Part<'_>> {
        let mut parts = vec![self.main_part()];
        for aov in &self.aovs {
            let channels = aov.channels.iter();
            let channels = channels.map(|(name, values)| (name.clone(), values.view().into()));
            let mut part = Part::new(&aov.name, channels.collect());
            if self.spectra != Spectra::Full && aov.is_light() {
                let names = aov.channels.iter().map(|(name, _)| name.clone());
                part.pack_as_half(names.collect());
            }
            let unit = AttributeValue::Text(aov.unit.clone());
            part.attributes.insert(AOV_UNIT.to_owned(), unit);
            part.windows = Some(self.windows);
            part.tells_rms = aov.is_light();
            parts.push(part);
        }
        parts
    }

    /// The spectra with R, G, B beside them, or X, Y, Z.
    fn main_part(&self) -> Part<'_> {
        let planes = self.radiance.axis_iter(Dimension(0));
        let names: Vec<String> = match self.spectra {
            Spectra::Full | Spectra::Half => {
                let centers = self.wavelengths.centers();
                centers
                    .map(|center| format!("{STOKES_0}{}", long_name(center)))
                    .collect()
            }
            Spectra::Left => XYZ.map(str::to_owned).into(),
        };
        let named = names.into_iter().zip(planes);
        let mut channels: Vec<(String, Samples)> =
            named.map(|(name, plane)| (name, plane.into())).collect();
        let (name, texts) = if self.spectra == Spectra::Left {
            (COLOR_PART, vec![(AOV_UNIT, LUMINANCE)])
        } else {
            let rgb = self.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
            channels.extend(rgb_channels("", &rgb));
            let texts = [
                (LAYOUT_VERSION, "1.0"),
                (EMISSIVE_UNITS, "W.m^-2.sr^-1"),
                (SPECTRAL_UNIT, "W.m^-2.sr^-1.nm^-1"),
            ];
            (SPECTRAL_PART, texts.to_vec())
        };
        let mut main = Part::new(name, channels);
        if self.spectra == Spectra::Half {
            let names = main.channels.iter().map(|(name, _)| name.clone());
            main.pack_as_half(names.collect());
        }
        main.attributes = self.attributes.clone();
        self.describe(&mut main);
        main.attributes
            .extend(wavelength_names::describe(&self.wavelengths));
        if self.spectra == Spectra::Left {
            let count = AttributeValue::Number(self.wavelengths.len() as f64);
            main.attributes
                .insert(wavelength_names::COUNT.to_owned(), count);
        }
        for (name, text) in texts {
            main.attributes
                .insert(name.to_owned(), AttributeValue::Text(text.to_owned()));
        }
        main
    }
}

impl PictureFile {
    /// Whether channels of the file are half floats.
    fn packs(self, image: &SpectralImage) -> bool {
        match self {
            Self::Spectral => image.spectra != Spectra::Full,
            Self::Layers(_) => true,
        }
    }

    /// Its parts, of which the first tells where it comes from.
    fn parts<'a>(self, image: &'a SpectralImage, provenance: &Provenance) -> Vec<Part<'a>> {
        let mut parts = match self {
            Self::Spectral => image.spectral_parts(),
            Self::Layers(primaries) => vec![image.layers_part(primaries)],
        };
        attributes::insert_texts(&mut parts[0].attributes, provenance.to_text_items());
        parts
    }
}
