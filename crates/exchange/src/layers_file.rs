//! The picture for compositors: one part of scene-linear RGB and its layers, sample by sample in half precision.
//!
//! c = sum_k c_k,   c_k = Y_k + s (M xyz_k/white - Y_k)
//! `c` the color of the picture in R, G, B, 1 a white card in the sun; `xyz_k` the light of a layer [cd/m²], `M` to
//! linear RGB, `Y_k` its luminance, `s` how much of its saturation the picture keeps where a channel would be negative
//! ([`kept_saturation`]; 1 elsewhere). So layers are lights that add up to the picture, and a layer alone may have a
//! negative channel. `A` is what the drops cover, 1 - transmittance, and R, G, B are premultiplied: c + (1 - A) b goes
//! over a background b. `Z` and `surface.Z` are distances in metres, of the drops' light and of the surface.
//!
//! A layer `NAME` has channels `NAME.R`, `NAME.G`, `NAME.B`, the way compositors name them. Colors and A are half floats,
//! relative error 2^-11; a channel that half cannot hold, above 65504, and distances are float.

use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis as Dimension;
use ndarray::Zip;
use ndarray::parallel::prelude::*;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::kept_saturation;
use niji_radiometry::xyz_to_linear_rec709;

use crate::attributes::WINDOW_WIDTH;
use crate::frame_time::FRAMES_PER_SECOND;
use crate::frame_time::TIME_CODE;
use crate::part::Part;
use crate::part::Samples;
use crate::spectral_image::Aov;
use crate::spectral_image::SpectralImage;
use crate::spectral_image::in_gamut;

/// The AOV with the distances that become `Z`.
const DEPTH: &str = "depth";
/// The AOV that becomes `A` = 1 − its mean.
const TRANSMITTANCE: &str = "transmittance";
/// A `Z` for pixels without a distance: compositors take it for infinity.
const NO_DEPTH_M: f32 = 1e10;
/// Name of the part.
pub(crate) const PART: &str = "layers";
pub(crate) const RGB: [&str; 3] = ["R", "G", "B"];
pub(crate) const XYZ: [&str; 3] = ["X", "Y", "Z"];
const Z: &str = "Z";

impl SpectralImage {
    /// The part of the file.
    pub(crate) fn layers_part(&self, primaries: RgbPrimaries) -> Part<'_> {
        let (_, height, width) = self.radiance.dim();
        let find = |name| self.aovs.iter().find(|aov: &&Aov| aov.name == name);
        let alpha = find(TRANSMITTANCE).map_or_else(
            || Array2::zeros((height, width)),
            |aov| aov.mean().mapv(|t| 1.0 - t),
        );
        let depth = find(DEPTH)
            .map_or_else(|| Array2::from_elem((height, width), NO_DEPTH_M), Aov::mean)
            .mapv(|z| if z > 0.0 { z } else { NO_DEPTH_M });
        let unbound = self.unbound_rgb(primaries);
        let kept = kept_of(&unbound, primaries);
        let rgb = in_gamut(&unbound, primaries, GamutPolicy::Desaturate);
        let mut channels = rgb_channels("", &rgb);
        channels.push(("A".to_owned(), alpha.into()));
        for aov in &self.aovs {
            if let Some(xyz) = aov.xyz() {
                let light = self.layer(xyz, primaries, &kept);
                channels.extend(rgb_channels(&format!("{}.", aov.name), &light));
            }
        }
        let halves = channels.iter().map(|(name, _)| name.clone());
        let halves: Vec<String> = halves.collect();
        channels.push((Z.to_owned(), depth.into()));
        let distances = self.aovs.iter().filter(|aov| aov.name != DEPTH);
        for (aov, values) in distances.filter_map(|aov| Some((aov, aov.distances()?))) {
            channels.push((format!("{}.{Z}", aov.name), values.view().into()));
        }
        let mut part = Part::new(PART, channels);
        part.pack_as_half(halves);
        part.primaries = primaries;
        let is_standard = |name: &str| [FRAMES_PER_SECOND, TIME_CODE, WINDOW_WIDTH].contains(&name);
        let standard = (self.attributes.iter()).filter(|(name, _)| is_standard(name));
        (part.attributes).extend(standard.map(|(name, value)| (name.clone(), value.clone())));
        self.describe(&mut part);
        part
    }

    /// The light of a layer, with what the picture keeps of saturation.
    fn layer(
        &self,
        xyz: [&Array2<f32>; 3],
        primaries: RgbPrimaries,
        kept: &Array2<f64>,
    ) -> Array3<f32> {
        let (height, width) = kept.dim();
        let mut light = Array3::zeros((height, width, 3));
        let rows = light.axis_iter_mut(Dimension(0)).into_par_iter();
        rows.enumerate().for_each(|(y, mut row)| {
            for (x, mut pixel) in row.axis_iter_mut(Dimension(0)).enumerate() {
                let relative =
                    xyz.map(|plane| f64::from(plane[[y, x]]) / self.white_luminance_cd_m2);
                let rgb = primaries.of_linear_rec709(xyz_to_linear_rec709(relative));
                let grey = primaries.luminance(rgb);
                for (channel, value) in pixel.iter_mut().zip(rgb) {
                    // f32: what is rounded to half anyway.
                    *channel = (grey + kept[[y, x]] * (value - grey)) as f32;
                }
            }
        });
        light.permuted_axes([2, 0, 1])
    }
}

impl Aov {
    /// Its light, if it is one in X, Y, Z.
    fn xyz(&self) -> Option<[&Array2<f32>; 3]> {
        let find = |name| {
            let mut channels = self.channels.iter();
            channels.find(|it| it.0 == name).map(|it| &it.1)
        };
        let [Some(x), Some(y), Some(z)] = XYZ.map(find) else {
            return None;
        };
        Some([x, y, z])
    }

    /// Its distances, if it has nothing else.
    fn distances(&self) -> Option<&Array2<f32>> {
        match self.channels.as_slice() {
            [(name, values)] if name == Z => Some(values),
            _ => None,
        }
    }

    /// Mean of the channels.
    fn mean(&self) -> Array2<f32> {
        let size = self
            .channels
            .first()
            .map_or((0, 0), |(_, values)| values.dim());
        let mut sum = Array2::<f32>::zeros(size);
        for (_, values) in &self.channels {
            sum += values;
        }
        sum / self.channels.len().max(1) as f32
    }
}

/// What each pixel keeps of its saturation, of a picture by channel, row and column.
fn kept_of(rgb: &Array3<f64>, primaries: RgbPrimaries) -> Array2<f64> {
    let plane = |channel| rgb.index_axis(Dimension(0), channel);
    Zip::from(plane(0))
        .and(plane(1))
        .and(plane(2))
        .map_collect(|r, g, b| kept_saturation([*r, *g, *b], primaries))
}

/// Channels of a layer with this in front of their names.
pub(crate) fn rgb_channels(layer: &str, rgb: &Array3<f32>) -> Vec<(String, Samples<'static>)> {
    let planes = rgb
        .axis_iter(Dimension(0))
        .map(|plane| plane.to_owned().into());
    let names = RGB.map(|channel| format!("{layer}{channel}"));
    names.into_iter().zip(planes).collect()
}
