//! What a picture keeps of its spectra.
//!
//! Half floats have a relative error of 2^-11 (4.9e-4) down to 6e-5 of a unit, and an absolute one of 3e-8 below;
//! [`Spectra::Left`] keeps X, Y, Z = sum_i w_i L_i [cd/m²], with the weights of [`Colorimetry`]. What is rounded is so
//! value by value, whatever is beside it, so that parts of a picture have the values of the whole.

use ndarray::Array3;
use ndarray::Axis as Dimension;
use ndarray::Zip;
use niji_radiometry::Colorimetry;

use crate::part::as_half;
use crate::spectral_image::Aov;
use crate::spectral_image::SpectralImage;

/// The unit of light in layers.
pub(crate) const LUMINANCE: &str = "cd/m^2";

/// What a picture keeps of its spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Spectra {
    /// All, in f32.
    #[default]
    Full,
    /// All, in half floats; so are the layers of light and of errors.
    Half,
    /// Colors alone, in f32: planes of its radiance are X, Y and Z [cd/m²]. Layers of light and of errors are half
    /// floats.
    Left,
}

impl SpectralImage {
    /// The picture with as much of its spectra; what was left out before does not come back.
    #[must_use]
    pub fn keeping(mut self, spectra: Spectra) -> Self {
        if self.spectra == Spectra::Left {
            return self;
        }
        match spectra {
            Spectra::Full => (),
            Spectra::Half => self.radiance.par_mapv_inplace(as_half),
            Spectra::Left => self.radiance = xyz(&self),
        }
        if spectra != Spectra::Full {
            for aov in self.aovs.iter_mut().filter(|aov| aov.is_light()) {
                for (_, values) in &mut aov.channels {
                    values.par_mapv_inplace(as_half);
                }
            }
        }
        self.spectra = spectra;
        self
    }
}

impl Aov {
    /// Whether it is light, or an error of it: no share and no distance.
    pub(crate) fn is_light(&self) -> bool {
        self.unit == LUMINANCE
    }
}

/// X, Y, Z by row and column.
fn xyz(image: &SpectralImage) -> Array3<f32> {
    let observer = Colorimetry::new(&image.wavelengths);
    let (n_wavelengths, height, width) = image.radiance.dim();
    let mut xyz = Array3::zeros((3, height, width));
    Zip::from(xyz.lanes_mut(Dimension(0)))
        .and(image.radiance.lanes(Dimension(0)))
        .par_for_each(|xyz, spectrum| {
            let mut values = Vec::with_capacity(n_wavelengths);
            values.extend(spectrum.iter().map(|value| f64::from(*value)));
            for (found, value) in xyz.into_iter().zip(observer.xyz(&values)) {
                // f32: what files hold.
                *found = value as f32;
            }
        });
    xyz
}
