//! One part of an EXR file as this crate sees it: named f32 channels of one size and attributes.

use std::collections::BTreeSet;

use exr::prelude::f16;
use ndarray::Array2;
use ndarray::ArrayView1;
use ndarray::CowArray;
use ndarray::Ix2;
use niji_radiometry::RgbPrimaries;
use rayon::prelude::*;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::image_windows::ImageWindows;

/// Longest name of a part, channel or attribute that the format holds, in bytes.
const MAX_NAME_BYTES: usize = 255;

/// Samples by row and column, borrowed for writing, owned after reading.
pub(crate) type Samples<'a> = CowArray<'a, f32, Ix2>;

/// Largest half float.
const LARGEST_HALF: f32 = 65504.0;
/// Takes numbers beyond it into its range, up to 2e9; there is no light as bright.
const BEYOND: f32 = 1.0 / 32768.0;

/// One part of a file.
#[derive(Clone, Debug)]
pub(crate) struct Part<'a> {
    pub(crate) name: String,
    pub(crate) channels: Vec<(String, Samples<'a>)>,
    /// Names of channels that are half floats in the file; what half cannot hold is no number there.
    pub(crate) halves: BTreeSet<String>,
    /// Whether its header tells the root mean square of each channel.
    pub(crate) tells_rms: bool,
    pub(crate) attributes: Attributes,
    pub(crate) white_luminance_cd_m2: Option<f32>,
    /// What R, G and B mean in a part with a white; read ones are Rec.709.
    pub(crate) primaries: RgbPrimaries,
    pub(crate) world_to_camera: Option<[f32; 16]>,
    /// `None` for a part that begins at (0, 0) and is shown as a whole.
    pub(crate) windows: Option<ImageWindows>,
}

impl<'a> Part<'a> {
    pub(crate) fn new(name: &str, channels: Vec<(String, Samples<'a>)>) -> Self {
        Self {
            name: name.to_owned(),
            channels,
            halves: BTreeSet::new(),
            tells_rms: false,
            attributes: Attributes::new(),
            white_luminance_cd_m2: None,
            primaries: RgbPrimaries::Rec709,
            world_to_camera: None,
            windows: None,
        }
    }

    /// Rounds channels to the precision of half floats, which they are in the file.
    pub(crate) fn pack_as_half(&mut self, names: Vec<String>) {
        self.channels.par_iter_mut().for_each(|(name, samples)| {
            if names.contains(name) {
                *samples = samples.mapv(as_half).into();
            }
        });
        self.halves.extend(names);
    }

    /// Channels among its half floats with a value that these cannot hold.
    pub(crate) fn beyond_half(&self) -> impl Iterator<Item = &str> {
        let is_beyond = |samples: &Samples| samples.iter().any(|it| it.abs() > LARGEST_HALF);
        let packed = (self.channels.iter()).filter(|(name, _)| self.halves.contains(name));
        packed
            .filter(move |(_, samples)| is_beyond(samples))
            .map(|(name, _)| name.as_str())
    }

    /// The part without its samples.
    pub(crate) fn head(&self) -> Part<'static> {
        let channels = self.channels.iter();
        let channels = channels.map(|(name, _)| (name.clone(), Array2::zeros((0, 0)).into()));
        Part {
            name: self.name.clone(),
            channels: channels.collect(),
            halves: self.halves.clone(),
            tells_rms: self.tells_rms,
            attributes: self.attributes.clone(),
            white_luminance_cd_m2: self.white_luminance_cd_m2,
            primaries: self.primaries,
            world_to_camera: self.world_to_camera,
            windows: self.windows,
        }
    }

    /// Puts its channels in the order of another part that has them all.
    pub(crate) fn order_as(&mut self, other: &Part) {
        let names = || other.channels.iter().map(|(name, _)| name);
        if !names().eq(self.channels.iter().map(|(name, _)| name)) {
            let place = |wanted: &String| names().position(|name| name == wanted);
            self.channels.sort_by_key(|(name, _)| place(name));
        }
    }

    /// Rows and columns; 0 and 0 without channels.
    pub(crate) fn size(&self) -> (usize, usize) {
        self.channels
            .first()
            .map_or((0, 0), |(_, samples)| samples.dim())
    }

    /// Takes a channel out of the part.
    pub(crate) fn take(&mut self, name: &str) -> Result<Array2<f32>, Error> {
        let index = self.channels.iter().position(|channel| channel.0 == name);
        let index = index.ok_or_else(|| Error::missing("channel", name))?;
        Ok(self.channels.swap_remove(index).1.into_owned())
    }

    pub(crate) fn text(&self, name: &str) -> Result<&str, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Text(text)) => Ok(text),
            Some(AttributeValue::Number(_)) | None => Err(self.no_attribute(name, "text")),
        }
    }

    pub(crate) fn number(&self, name: &str) -> Result<f64, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Number(number)) => Ok(*number),
            Some(AttributeValue::Text(_)) | None => Err(self.no_attribute(name, "number")),
        }
    }

    fn no_attribute(&self, name: &str, kind: &'static str) -> Error {
        Error::Attribute {
            part: self.name.clone(),
            name: name.to_owned(),
            kind,
        }
    }

    /// What the format or this crate asks of a part before it is written, but for its values; one of several needs a
    /// name.
    pub(crate) fn check(
        &self,
        (height, width): (usize, usize),
        is_only: bool,
    ) -> Result<(), Error> {
        if !(is_only && self.name.is_empty()) {
            check_name("part", &self.name)?;
        }
        for name in self.attributes.keys() {
            check_name("attribute", name)?;
        }
        self.check_numbers()?;
        if height * width == 0 {
            return Err(Error::Empty {
                part: self.name.clone(),
            });
        }
        for (index, (name, _)) in self.channels.iter().enumerate() {
            check_name("channel", name)?;
            if self.channels[..index]
                .iter()
                .any(|(earlier, _)| earlier == name)
            {
                return Err(Error::Duplicate {
                    kind: "channel",
                    name: name.clone(),
                });
            }
        }
        Ok(())
    }

    /// Refuses other rows than those that may follow on the first ones of a part of this size.
    pub(crate) fn check_rows_of(
        &self,
        head: &Part,
        (first_row, (height, width)): (usize, (usize, usize)),
    ) -> Result<(), Error> {
        let names = self.channels.iter().map(|(name, _)| name);
        if self.name != head.name || !names.eq(head.channels.iter().map(|(name, _)| name)) {
            let message = format!("rows of part {:?} have other channels", head.name);
            return Err(Error::Unwritable(message));
        }
        let n_rows = self.size().0.min(height - first_row);
        let other = (self.channels.iter()).find(|(_, samples)| samples.dim() != (n_rows, width));
        other.map_or(Ok(()), |(name, samples)| {
            Err(Error::Shape {
                what: format!("pixels in channel {name:?} of part {:?}", self.name),
                found: samples.len(),
                expected: n_rows * width,
            })
        })
    }

    /// Refuses NaN and infinity in the header.
    fn check_numbers(&self) -> Result<(), Error> {
        let own = self
            .attributes
            .iter()
            .filter_map(|(name, value)| match value {
                AttributeValue::Number(number) => Some((name.as_str(), *number)),
                AttributeValue::Text(_) => None,
            });
        let white = self.white_luminance_cd_m2.iter();
        let white = white.map(|number| ("whiteLuminance", f64::from(*number)));
        let camera = self.world_to_camera.iter().flatten();
        let camera = camera.map(|number| ("worldToCamera", f64::from(*number)));
        match own.chain(white).chain(camera).find(|it| !it.1.is_finite()) {
            Some((name, value)) => Err(Error::AttributeNotFinite {
                part: self.name.clone(),
                name: name.to_owned(),
                value,
            }),
            None => Ok(()),
        }
    }

    /// Refuses NaN and infinity in a part whose first row is this one.
    pub(crate) fn check_values(&self, first_row: usize) -> Result<(), Error> {
        let not_finite = |(name, samples): &(String, Samples)| {
            if samples.iter().all(|value| value.is_finite()) {
                return None;
            }
            let mut found = samples.indexed_iter();
            let ((y, x), &value) = found.find(|(_, value)| !value.is_finite())?;
            Some(Error::NotFinite {
                part: self.name.clone(),
                channel: name.clone(),
                x,
                y: first_row + y,
                value,
            })
        };
        let found = self.channels.par_iter().map(not_finite);
        let first = found.find_first(Option::is_some).flatten();
        first.map_or(Ok(()), Err)
    }
}

/// Appends samples in so many bytes each.
pub(crate) fn append<const N: usize>(
    bytes: &mut Vec<u8>,
    samples: &ArrayView1<f32>,
    encode: impl Fn(f32) -> [u8; N],
) {
    let start = bytes.len();
    bytes.resize(start + N * samples.len(), 0);
    let (targets, _) = bytes[start..].as_chunks_mut();
    for (target, value) in targets.iter_mut().zip(samples) {
        *target = encode(*value);
    }
}

/// A value with as many digits as a half float holds, also beyond its range.
pub(crate) fn as_half(value: f32) -> f32 {
    if value.abs() <= LARGEST_HALF {
        f16::from_f32(value).to_f32()
    } else {
        // A power of two is exact, and what is not finite stays so for the writer to refuse.
        f16::from_f32(value * BEYOND).to_f32() / BEYOND
    }
}

fn check_name(kind: &'static str, name: &str) -> Result<(), Error> {
    if name.is_empty() || name.len() > MAX_NAME_BYTES || name.contains('\0') {
        return Err(Error::Name {
            kind,
            name: name.to_owned(),
        });
    }
    Ok(())
}
