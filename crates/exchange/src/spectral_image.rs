//! Spectral images.
//!
//! Part 0 holds the radiance in the layout of [FPW21] with R, G, B beside it, so that viewers of
//! that layout and ordinary ones both find something; further parts are AOVs. The layout wants the
//! unit `W.m^-2.sr^-1`; the truth, bin means per nanometre, stands in `niji:spectralUnit`.
//!
//! R, G, B are linear Rec.709 relative to a white of `white_luminance_cd_m2`.
//! [FPW21] A. Fichet, R. Pacanowski, A. Wilkie, J. Computer Graphics Techniques 10(3), 1-18 (2021).

use std::io::Seek;
use std::io::Write;
use std::path::Path;

use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis as Dimension;
use ndarray::parallel::prelude::*;
use niji_radiometry::Colorimetry;
use niji_radiometry::GamutPolicy;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::into_gamut;
use niji_radiometry::xyz_to_linear_rec709;

use crate::attributes;
use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::container;
use crate::container::Codec;
use crate::container::Part;
use crate::error::Error;
use crate::preview;
use crate::provenance::Provenance;
use crate::wavelength_names::grid;
use crate::wavelength_names::parse_wavelength;

/// Name of the spectral part.
const SPECTRAL_PART: &str = "spectral";
/// Prefix of the channels of unpolarised emission in the layout.
const STOKES_0: &str = "S0.";
/// The AOV with the distances that become `Z`.
const DEPTH: &str = "depth";
/// The AOV that becomes `A` = 1 − its mean.
const TRANSMITTANCE: &str = "transmittance";
/// A `Z` for pixels without a distance: compositors take it for infinity.
const NO_DEPTH_M: f32 = 1e10;

/// An additional picture beside the radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Aov {
    /// Its name, that of the part.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// Its channels by name.
    pub channels: Vec<(String, Array2<f32>)>,
}

/// A spectral image.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralImage {
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Radiance by wavelength, row and column: bin means in W m^-2 sr^-1 nm^-1.
    pub radiance: Array3<f32>,
    /// Further pictures of the same size.
    pub aovs: Vec<Aov>,
    /// Luminance of R = G = B = 1 in cd/m^2.
    pub white_luminance_cd_m2: f64,
    /// The matrix from world to camera, by rows.
    pub world_to_camera: Option<[f32; 16]>,
    /// Further attributes of part 0.
    pub attributes: Attributes,
    /// Where the image comes from.
    pub provenance: Provenance,
}

impl SpectralImage {
    /// Linear Rec.709 relative to the white, by channel, row and column.
    #[must_use]
    pub fn rgb(&self, policy: GamutPolicy) -> Array3<f32> {
        let (n_wavelengths, height, width) = self.radiance.dim();
        let colorimetry = Colorimetry::new(&self.wavelengths);
        let mut rgb = Array3::zeros((height, width, 3));
        rgb.axis_iter_mut(Dimension(0)).into_par_iter().enumerate().for_each(|(y, mut row)| {
            let mut spectrum = vec![0.0; n_wavelengths];
            for x in 0..width {
                for (index, value) in spectrum.iter_mut().enumerate() {
                    *value = f64::from(self.radiance[[index, y, x]]);
                }
                let xyz = colorimetry.xyz(&spectrum).map(|value| value / self.white_luminance_cd_m2);
                let color = into_gamut(xyz_to_linear_rec709(xyz), policy);
                for (channel, value) in color.into_iter().enumerate() {
                    row[[x, channel]] = value as f32;
                }
            }
        });
        rgb.permuted_axes([2, 0, 1])
    }

    /// Writes the spectral image with all its AOVs.
    ///
    /// # Errors
    /// A value that is not finite, an AOV of another size, or a writer that fails.
    pub fn write_spectral(&self, writer: impl Write + Seek) -> Result<(), Error> {
        let mut channels = rgb_channels(&self.rgb(GamutPolicy::Desaturate));
        for (index, plane) in self.radiance.axis_iter(Dimension(0)).enumerate() {
            let wavelength_nm = self.wavelengths.center(index).0;
            // Six decimals and a decimal comma, as the authors of the layout write them.
            let name = format!("{STOKES_0}{wavelength_nm:.6}nm").replacen('.', "\u{0}", 1);
            let name = name.replace('.', ",").replace('\u{0}', ".");
            channels.push((name, plane.to_owned()));
        }
        let mut main = self.described(Part::new(SPECTRAL_PART, channels));
        main.attributes.extend(self.attributes.clone());
        let text = |text: &str| AttributeValue::Text(text.to_owned());
        for (name, value) in [
            ("spectralLayoutVersion", text("1.0")),
            ("emissiveUnits", text("W.m^-2.sr^-1")),
            ("niji:spectralUnit", text("W.m^-2.sr^-1.nm^-1, means over bins")),
            ("niji:wavelengthStepNm", AttributeValue::Number(self.wavelengths.step_nm())),
        ] {
            main.attributes.insert(name.to_owned(), value);
        }
        let mut parts = vec![main];
        for aov in &self.aovs {
            let mut part = Part::new(&aov.name, aov.channels.clone());
            part.attributes.insert("niji:unit".to_owned(), text(&aov.unit));
            parts.push(part);
        }
        container::write(parts, Codec::Piz, writer)
    }

    /// Reads a spectral image with its AOVs.
    ///
    /// # Errors
    /// A missing, truncated or damaged file, or one without a spectral part.
    pub fn read_spectral(path: &Path) -> Result<Self, Error> {
        let mut parts = container::read_parts(path)?.into_iter();
        let missing = || Error::Missing { kind: "part", name: SPECTRAL_PART.to_owned() };
        let mut main = parts.next().ok_or_else(missing)?;
        let names = main.channels.iter().filter_map(|(name, _)| {
            let wavelength = parse_wavelength(name.strip_prefix(STOKES_0)?)?;
            Some((wavelength.0, name.clone()))
        });
        let mut names: Vec<(f64, String)> = names.collect();
        names.sort_by(|a, b| a.0.total_cmp(&b.0));
        let step_nm = main.number("niji:wavelengthStepNm").unwrap_or(1.0);
        let wavelengths = grid(names.iter().map(|(nm, _)| *nm).collect(), step_nm)?;
        let (height, width) = main.channels[0].1.dim();
        let mut radiance = Array3::zeros((names.len(), height, width));
        for (index, (_, name)) in names.iter().enumerate() {
            radiance.index_axis_mut(Dimension(0), index).assign(&main.take(name)?);
        }
        let provenance = Provenance::from_text_items(attributes::texts(&main.attributes));
        let aovs = parts.map(|part| {
            let unit = part.text("niji:unit").unwrap_or("-").to_owned();
            Aov { name: part.name, unit, channels: part.channels }
        });
        Ok(Self {
            wavelengths,
            radiance,
            aovs: aovs.collect(),
            white_luminance_cd_m2: main.white_luminance_cd_m2.unwrap_or(1.0),
            world_to_camera: main.world_to_camera,
            attributes: main.attributes,
            provenance: provenance.unwrap_or_default(),
        })
    }

    /// Writes a plain image with R, G, B, A and Z, for programs that know no layers. A bow is added
    /// light: R, G, B may be above 0 where A is 0.
    ///
    /// # Errors
    /// A value that is not finite or a writer that fails.
    pub fn write_rgb_exr(&self, writer: impl Write + Seek) -> Result<(), Error> {
        let (_, height, width) = self.radiance.dim();
        let mut channels = rgb_channels(&self.rgb(GamutPolicy::Desaturate));
        let mean = |aov: &Aov| {
            let mut sum = Array2::<f32>::zeros((height, width));
            for (_, values) in &aov.channels {
                sum += values;
            }
            sum / aov.channels.len().max(1) as f32
        };
        let find = |name| self.aovs.iter().find(|aov: &&Aov| aov.name == name);
        let alpha = find(TRANSMITTANCE)
            .map_or_else(|| Array2::zeros((height, width)), |aov| mean(aov).mapv(|t| 1.0 - t));
        let depth = find(DEPTH)
            .map_or_else(|| Array2::from_elem((height, width), NO_DEPTH_M), mean)
            .mapv(|z| if z > 0.0 { z } else { NO_DEPTH_M });
        channels.push(("A".to_owned(), alpha));
        channels.push(("Z".to_owned(), depth));
        let part = self.described(Part::new("rgb", channels));
        container::write(vec![part], Codec::Piz, writer)
    }

    /// Writes a preview for people: 8-bit sRGB, see [`crate::tone_curve`].
    ///
    /// # Errors
    /// A writer that fails.
    pub fn write_png(&self, writer: impl Write, exposure_ev: f64) -> Result<(), Error> {
        preview::write_png(&self.rgb(GamutPolicy::Desaturate), exposure_ev, writer)
    }

    fn described(&self, mut part: Part) -> Part {
        part.white_luminance_cd_m2 = Some(self.white_luminance_cd_m2);
        part.world_to_camera = self.world_to_camera;
        attributes::insert_texts(&mut part.attributes, self.provenance.to_text_items());
        part
    }
}

fn rgb_channels(rgb: &Array3<f32>) -> Vec<(String, Array2<f32>)> {
    let names = ["R", "G", "B"].into_iter().map(str::to_owned);
    names.zip(rgb.axis_iter(Dimension(0)).map(|plane| plane.to_owned())).collect()
}
