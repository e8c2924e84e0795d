//! Spectral images.
//!
//! Part 0 holds the radiance in the layout of [FPW21] with R, G, B beside it, so that viewers of
//! that layout and ordinary ones both find something; further parts are AOVs. The layout wants the
//! unit `W.m^-2.sr^-1`; the truth, bin means per nanometre, stands in `niji:spectralUnit`.
//!
//! The data window is the region that was rendered and the display window the frame of the camera, so
//! that tiles and overscan stand where they belong.
//!
//! R, G, B are linear Rec.709 relative to a white of `white_luminance_cd_m2`, so that
//!   xyz [cd/m^2] = white * M rgb;  colors outside the gamut are mixed with grey (never clipped).
//! [FPW21] A. Fichet, R. Pacanowski, A. Wilkie, J. Computer Graphics Techniques 10(3), 1-18 (2021).

use std::ops::Range;
use std::path::Path;

use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis as Dimension;
use ndarray::Zip;
use ndarray::parallel::prelude::*;
use ndarray::s;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::into_gamut;
use niji_radiometry::xyz_to_linear_rec709;

use crate::attributes;
use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::checksum;
use crate::error::Error;
use crate::exr_read;
use crate::image_windows::ImageWindows;
use crate::layers_file::XYZ;
use crate::part::Part;
use crate::provenance::Provenance;
use crate::spectra::Spectra;
use crate::wavelength_names;
use crate::wavelength_names::parse_wavelength;

/// Name of the spectral part.
pub(crate) const SPECTRAL_PART: &str = "spectral";
/// Name of the part that stands for it where spectra were left out.
pub(crate) const COLOR_PART: &str = "color";
/// Prefix of the channels of unpolarised emission in the layout.
pub(crate) const STOKES_0: &str = "S0.";
/// Name of the attribute with the version of the layout.
pub(crate) const LAYOUT_VERSION: &str = "spectralLayoutVersion";
/// Name of the attribute with the unit that the layout wants.
pub(crate) const EMISSIVE_UNITS: &str = "emissiveUnits";
/// Name of the attribute with the true unit.
pub(crate) const SPECTRAL_UNIT: &str = "niji:spectralUnit";
/// Name of the attribute with the white in f64; the standard one is f32.
const WHITE: &str = "niji:whiteLuminanceCdM2";
/// Name of the attribute with the unit of an AOV.
pub(crate) const AOV_UNIT: &str = "niji:unit";

/// An additional picture beside the radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Aov {
    /// Its name, that of the part.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// Its channels by name; in the order of their names after reading.
    pub channels: Vec<(String, Array2<f32>)>,
}

/// A spectral image.
///
/// ```
/// use ndarray::Array3;
/// use niji_exchange::{Attributes, ImageWindows, Provenance, Spectra, SpectralImage};
/// use niji_radiometry::{Colorimetry, GamutPolicy, RgbPrimaries, WavelengthGrid};
///
/// // The same radiance at every wavelength, as bright as white.
/// let wavelengths = WavelengthGrid::visible();
/// let flat = vec![1.0; wavelengths.len()];
/// let image = SpectralImage {
///     wavelengths,
///     radiance: Array3::ones((wavelengths.len(), 1, 1)),
///     spectra: Spectra::Full,
///     windows: ImageWindows::whole(1, 1),
///     aovs: Vec::new(),
///     white_luminance_cd_m2: Colorimetry::new(&wavelengths).xyz(&flat)[1],
///     world_to_camera: None,
///     attributes: Attributes::new(),
///     provenance: Provenance::default(),
/// };
/// let rgb = image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
/// let luminance = 0.2126 * rgb[[0, 0, 0]] + 0.7152 * rgb[[1, 0, 0]] + 0.0722 * rgb[[2, 0, 0]];
/// assert!((luminance - 1.0).abs() < 1e-4);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralImage {
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Radiance by wavelength, row and column: bin means in W m^-2 sr^-1 nm^-1. Where spectra were left out: X, Y, Z
    /// [cd/m²] by row and column.
    pub radiance: Array3<f32>,
    /// What is kept of the spectra.
    pub spectra: Spectra,
    /// Where its pixels lie, and which are the frame.
    pub windows: ImageWindows,
    /// Further pictures of the same size.
    pub aovs: Vec<Aov>,
    /// Luminance of R = G = B = 1 in cd/m^2.
    pub white_luminance_cd_m2: f64,
    /// The matrix from world to camera in the convention of OpenEXR: by rows, for row vectors
    /// (p_camera = p_world M), so that the translation stands in the last row.
    pub world_to_camera: Option<[f32; 16]>,
    /// Further attributes of part 0.
    pub attributes: Attributes,
    /// Where the image comes from.
    pub provenance: Provenance,
}

impl SpectralImage {
    /// Linear RGB relative to the white, by channel, row and column.
    #[must_use]
    pub fn rgb(&self, primaries: RgbPrimaries, policy: GamutPolicy) -> Array3<f32> {
        in_gamut(&self.unbound_rgb(primaries), primaries, policy)
    }

    /// Linear RGB whose channels may be negative.
    pub(crate) fn unbound_rgb(&self, primaries: RgbPrimaries) -> Array3<f64> {
        let (n_wavelengths, height, width) = self.radiance.dim();
        let colorimetry = Colorimetry::new(&self.wavelengths);
        let mut rgb = Array3::zeros((height, width, 3));
        rgb.axis_iter_mut(Dimension(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(y, mut row)| {
                let mut spectrum = vec![0.0; n_wavelengths];
                for x in 0..width {
                    for (index, value) in spectrum.iter_mut().enumerate() {
                        *value = f64::from(self.radiance[[index, y, x]]);
                    }
                    let xyz = match (self.spectra, spectrum.as_slice()) {
                        (Spectra::Left, &[x, y, z]) => [x, y, z],
                        (_, spectrum) => colorimetry.xyz(spectrum),
                    };
                    let xyz = xyz.map(|value| value / self.white_luminance_cd_m2);
                    let color = primaries.of_linear_rec709(xyz_to_linear_rec709(xyz));
                    for (channel, value) in color.into_iter().enumerate() {
                        row[[x, channel]] = value;
                    }
                }
            });
        rgb.permuted_axes([2, 0, 1])
    }

    /// Reads a spectral image with its AOVs; one by another program too, if its wavelengths are
    /// equidistant.
    ///
    /// # Errors
    /// A missing, truncated or damaged file, one without a spectral part, [`Error::NoSpectra`], or values that are not
    /// finite.
    pub fn read_spectral(path: &Path) -> Result<Self, Error> {
        let image = Self::read_picture(path)?;
        if image.spectra == Spectra::Left {
            return Err(Error::NoSpectra);
        }
        Ok(image)
    }

    /// The same for whom colors are enough: of an image whose spectra were left out, too.
    ///
    /// # Errors
    /// As [`Self::read_spectral`], but for [`Error::NoSpectra`].
    pub fn read_picture(path: &Path) -> Result<Self, Error> {
        Self::of_parts(exr_read::read_parts(path)?)
    }

    /// The image in the parts of a file.
    pub(crate) fn of_parts(parts: Vec<Part<'static>>) -> Result<Self, Error> {
        let mut parts = parts.into_iter();
        let missing = || Error::missing("part", SPECTRAL_PART);
        let mut main = parts.next().ok_or_else(missing)?;
        let spectra = match (main.name.as_str(), main.halves.is_empty()) {
            (COLOR_PART, _) => Spectra::Left,
            (_, true) => Spectra::Full,
            (_, false) => Spectra::Half,
        };
        let (wavelengths, radiance) = if spectra == Spectra::Left {
            colors(&mut main)?
        } else {
            radiance(&mut main)?
        };
        let (_, height, width) = radiance.dim();
        let provenance = Provenance::from_text_items(attributes::texts(&main.attributes));
        let white = main.white_luminance_cd_m2.map_or(1.0, f64::from);
        let image = Self {
            wavelengths,
            radiance,
            spectra,
            windows: main
                .windows
                .unwrap_or_else(|| ImageWindows::whole(width, height)),
            aovs: parts.map(aov).collect(),
            white_luminance_cd_m2: main.number(WHITE).unwrap_or(white),
            world_to_camera: main.world_to_camera,
            attributes: {
                main.attributes.retain(|name, _| !describes(name));
                main.attributes
            },
            provenance: provenance.unwrap_or_default(),
        };
        image.check_shape()?;
        Ok(image)
    }

    /// A copy of some of its rows.
    ///
    /// # Panics
    /// If there are no such rows.
    #[must_use]
    pub fn rows(&self, rows: Range<usize>) -> Self {
        let of_plane = |values: &Array2<f32>| values.slice(s![rows.clone(), ..]).to_owned();
        let of_aov = |aov: &Aov| Aov {
            name: aov.name.clone(),
            unit: aov.unit.clone(),
            channels: {
                let channels = aov.channels.iter();
                channels
                    .map(|(name, values)| (name.clone(), of_plane(values)))
                    .collect()
            },
        };
        let data = self.windows.data;
        Self {
            wavelengths: self.wavelengths,
            radiance: self.radiance.slice(s![.., rows.clone(), ..]).to_owned(),
            spectra: self.spectra,
            windows: ImageWindows {
                data: PixelRegion {
                    y_px: data.y_px.saturating_add(rows.start as i32),
                    height_px: rows.len() as u32,
                    ..data
                },
                display: self.windows.display,
            },
            aovs: self.aovs.iter().map(of_aov).collect(),
            white_luminance_cd_m2: self.white_luminance_cd_m2,
            world_to_camera: self.world_to_camera,
            attributes: self.attributes.clone(),
            provenance: self.provenance.clone(),
        }
    }

    pub(crate) fn describe(&self, part: &mut Part) {
        // f32: what the standard attribute holds; the exact number stands beside it.
        part.white_luminance_cd_m2 = Some(self.white_luminance_cd_m2 as f32);
        part.world_to_camera = self.world_to_camera;
        part.windows = Some(self.windows);
        let white = AttributeValue::Number(self.white_luminance_cd_m2);
        part.attributes.insert(WHITE.to_owned(), white);
    }

    pub(crate) fn check_shape(&self) -> Result<(), Error> {
        let (n_planes, height, width) = self.radiance.dim();
        let expected = match self.spectra {
            Spectra::Full | Spectra::Half => self.wavelengths.len(),
            Spectra::Left => XYZ.len(),
        };
        if n_planes != expected {
            let what = "planes of radiance".to_owned();
            return Err(Error::Shape {
                what,
                found: n_planes,
                expected,
            });
        }
        let window = self.windows.data;
        for (what, found, expected) in [
            ("rows in its data window", window.height_px, height),
            ("columns in its data window", window.width_px, width),
        ] {
            if found as usize != expected {
                return Err(Error::Shape {
                    what: what.to_owned(),
                    found: found as usize,
                    expected,
                });
            }
        }
        for aov in &self.aovs {
            for (name, values) in &aov.channels {
                if values.dim() != (height, width) {
                    let what = format!("pixels in channel {name:?} of part {:?}", aov.name);
                    let (found, expected) = (values.len(), height * width);
                    return Err(Error::Shape {
                        what,
                        found,
                        expected,
                    });
                }
            }
        }
        Ok(())
    }
}

/// A picture by channel, row and column as [`into_gamut`] has it, in f32 as files hold it.
pub(crate) fn in_gamut(
    rgb: &Array3<f64>,
    primaries: RgbPrimaries,
    policy: GamutPolicy,
) -> Array3<f32> {
    let mut bound = Array3::zeros(rgb.dim());
    Zip::from(bound.lanes_mut(Dimension(0)))
        .and(rgb.lanes(Dimension(0)))
        .par_for_each(|bound, pixel| {
            let color = into_gamut([pixel[0], pixel[1], pixel[2]], primaries, policy);
            for (bound, value) in bound.into_iter().zip(color) {
                *bound = value as f32;
            }
        });
    bound
}

/// Takes the spectral channels out of part 0.
fn radiance(main: &mut Part) -> Result<(WavelengthGrid, Array3<f32>), Error> {
    let names = main.channels.iter().filter_map(|(name, _)| {
        let wavelength = parse_wavelength(name.strip_prefix(STOKES_0)?)?;
        Some((wavelength.0, name.clone()))
    });
    let mut names: Vec<(f64, String)> = names.collect();
    if names.is_empty() {
        let name = format!("{STOKES_0}WAVELENGTHnm");
        return Err(Error::missing("channel", &name));
    }
    // By number: as text, 1000 comes before 380.
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wavelengths_nm = names.iter().map(|(nm, _)| *nm).collect();
    let wavelengths = wavelength_names::described_grid(wavelengths_nm, &main.attributes)?;
    let (height, width) = main.size();
    let mut radiance = Array3::zeros((names.len(), height, width));
    for (index, (_, name)) in names.iter().enumerate() {
        radiance
            .index_axis_mut(Dimension(0), index)
            .assign(&main.take(name)?);
    }
    Ok((wavelengths, radiance))
}

/// Takes X, Y and Z out of part 0, and the wavelengths that they are of.
fn colors(main: &mut Part) -> Result<(WavelengthGrid, Array3<f32>), Error> {
    let (height, width) = main.size();
    let mut xyz = Array3::zeros((XYZ.len(), height, width));
    for (mut plane, name) in xyz.outer_iter_mut().zip(XYZ) {
        plane.assign(&main.take(name)?);
    }
    Ok((wavelength_names::grid_of(main)?, xyz))
}

fn aov(part: Part) -> Aov {
    let unit = part.text(AOV_UNIT).unwrap_or("-").to_owned();
    let channels = part.channels.into_iter();
    let channels = channels.map(|(name, values)| (name, values.into_owned()));
    Aov {
        name: part.name,
        unit,
        channels: channels.collect(),
    }
}

/// Whether an attribute is one that every spectral image has.
fn describes(name: &str) -> bool {
    let own = [
        LAYOUT_VERSION,
        EMISSIVE_UNITS,
        SPECTRAL_UNIT,
        AOV_UNIT,
        WHITE,
        checksum::NAME,
    ];
    own.contains(&name)
        || [
            wavelength_names::FIRST,
            wavelength_names::STEP,
            wavelength_names::COUNT,
        ]
        .contains(&name)
        || Provenance::owns(name)
}
