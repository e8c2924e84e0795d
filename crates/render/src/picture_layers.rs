//! What a picture holds of each pixel beside its spectrum: the one list of its layers.
//!
//! A layer more is a line here and what [`crate::pixel::Pixel`] has for it.

use std::ops::Index;
use std::ops::Range;

use ndarray::Array3;
use ndarray::ArrayView2;
use ndarray::Axis;
use ndarray::s;

/// A layer of a picture. Those with X, Y, Z are its light: their sum is that of its spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureLayer {
    /// Light of the drops on the primary side of the split.
    BowPrimary,
    /// Light of the drops on the secondary side of the split.
    BowSecondary,
    /// Light of the air from the eye to the far side of the drops.
    Inscatter,
    /// Light that drops scattered more than once, and what the light diffracted once changes in the bows.
    BowMultiple,
    /// Light of the drops in the sun that water mirrors, both bows.
    BowReflected,
    /// Light of the surroundings that the drops scatter to the eye.
    Skylit,
    /// Sky, air and ground behind the drops, dimmed by them.
    Sky,
    /// Lit surfaces, dimmed by drops and air in front of them.
    LitSurface,
    /// Light that comes by way of water that is seen: drops, air, surfaces and sun in it, and its own.
    Water,
    /// What the drops alone let pass of the light behind them, exp(-tau) without diffraction (Q = 1) whichever
    /// extinction the level takes: by `Full` the light itself is dimmed by its square.
    Transmittance,
    /// Optical depth of the drops towards the sun at Q = 1, mean over the light of the drops; 0 where there
    /// is none.
    TauSun,
    /// Mean distance from the eye of the light of the drops; 0 where there is none.
    Depth,
    /// Distance of the surface that ends the ray through the middle of the pixel, infinite for the sky.
    Surface,
    /// Estimated absolute error of luminance, and what it is made of: error² is the sum of the squares of its
    /// parts. The causes have nothing to do with each other, so that their signs agree as often as not (JCGM
    /// 100:2008, 5.1.2). The plain sum, as if all had one sign, covered hardly more pixels of the shipped
    /// scenes and told up to six tenths more.
    Error,
}

/// Colors.
const XYZ: &[&str] = &["X", "Y", "Z"];
const LUMINANCE_UNIT: &str = "cd/m^2";
/// The error of all causes, and each: the quadrature along the ray, or between rays for a pixel without one; linear interpolation between the angles and
/// between the radii of the scattering table; the optical depth of the drops towards the sun; noise of the light
/// that drops scatter more than once; the quadrature of the air, of its light and of what it lets
/// pass; light that lit surfaces send each other; what the rays of a pixel miss of it.
const ERRORS: &[&str] = &[
    "Y",
    "quadrature",
    "angles",
    "sizes",
    "shadow",
    "orders",
    "air",
    "surfaces",
    "footprint",
];
/// Channels of [`ERRORS`].
pub(crate) const TOTAL: usize = 0;
pub(crate) const QUADRATURE: usize = 1;
pub(crate) const FOOTPRINT: usize = 8;
/// Number of causes.
pub(crate) const N_CAUSES: usize = ERRORS.len() - 1;

/// Layer, its name, unit and channels.
type Row = (
    PictureLayer,
    &'static str,
    &'static str,
    &'static [&'static str],
);

const TABLE: [Row; 14] = [
    (PictureLayer::BowPrimary, "bow_primary", LUMINANCE_UNIT, XYZ),
    (
        PictureLayer::BowSecondary,
        "bow_secondary",
        LUMINANCE_UNIT,
        XYZ,
    ),
    (PictureLayer::Inscatter, "air", LUMINANCE_UNIT, XYZ),
    (
        PictureLayer::BowMultiple,
        "bow_multiple",
        LUMINANCE_UNIT,
        XYZ,
    ),
    (
        PictureLayer::BowReflected,
        "bow_reflected",
        LUMINANCE_UNIT,
        XYZ,
    ),
    (PictureLayer::Skylit, "skylit_drops", LUMINANCE_UNIT, XYZ),
    (PictureLayer::Sky, "sky", LUMINANCE_UNIT, XYZ),
    (
        PictureLayer::LitSurface,
        "lit_surfaces",
        LUMINANCE_UNIT,
        XYZ,
    ),
    (PictureLayer::Water, "water", LUMINANCE_UNIT, XYZ),
    (PictureLayer::Transmittance, "transmittance", "-", &["Y"]),
    (PictureLayer::TauSun, "tau_sun", "-", &["Y"]),
    (PictureLayer::Depth, "depth", "m", &["Z"]),
    (PictureLayer::Surface, "surface", "m", &["Z"]),
    (PictureLayer::Error, "error", LUMINANCE_UNIT, ERRORS),
];

impl PictureLayer {
    /// All of them, in the order of files.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.into_iter().map(|(layer, ..)| layer)
    }

    /// What files call it.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// The unit of its values.
    pub fn unit(self) -> &'static str {
        self.row().2
    }

    /// What files call its channels.
    pub fn channels(self) -> &'static [&'static str] {
        self.row().3
    }

    fn row(self) -> Row {
        // In the order of the enumeration, as a test says.
        TABLE[self as usize]
    }
}

/// A rendered picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Spectral radiance by wavelength, row and column, bin means [W m^-2 sr^-1 nm^-1].
    pub radiance: Array3<f32>,
    /// By channel, row and column.
    pub(crate) layers: Vec<(PictureLayer, Array3<f32>)>,
}

impl Rendered {
    /// A black picture of nothing, by number of wavelengths, height and width. Zeroed memory is not touched until
    /// a row is written.
    pub(crate) fn dark(size: [usize; 3], layers: impl Iterator<Item = PictureLayer>) -> Self {
        let [_, height, width] = size;
        let layer = |layer: PictureLayer| {
            let values = Array3::zeros((layer.channels().len(), height, width));
            (layer, values)
        };
        Self {
            radiance: Array3::zeros(size),
            layers: layers.map(layer).collect(),
        }
    }

    /// A black one with as many columns and wavelengths and the same layers.
    pub(crate) fn dark_of_height(&self, height_px: u32) -> Self {
        let (n_wavelengths, _, width) = self.radiance.dim();
        let size = [n_wavelengths, height_px as usize, width];
        Self::dark(size, self.layers().map(|(layer, _)| layer))
    }

    /// Put rows of one with the same layers in their place, of which this is the first.
    pub(crate) fn put_rows(&mut self, first: usize, rows: &Self) {
        let place = s![.., first..first + rows.radiance.dim().1, ..];
        self.radiance.slice_mut(place).assign(&rows.radiance);
        for ((_, all), (_, rows)) in self.layers.iter_mut().zip(&rows.layers) {
            all.slice_mut(place).assign(rows);
        }
    }

    /// The layers that were wanted, by channel, row and column.
    pub fn layers(&self) -> impl Iterator<Item = (PictureLayer, &Array3<f32>)> {
        self.layers.iter().map(|(layer, values)| (*layer, values))
    }

    /// A layer by channel, row and column; `None` where it was not wanted.
    pub fn layer(&self, wanted: PictureLayer) -> Option<&Array3<f32>> {
        let mut layers = self.layers();
        layers
            .find(|(layer, _)| *layer == wanted)
            .map(|(_, values)| values)
    }

    /// The estimated error from a cause, by its name among the channels of [`PictureLayer::Error`].
    pub fn error_from(&self, cause: &str) -> Option<ArrayView2<'_, f32>> {
        let channel = ERRORS.iter().position(|name| *name == cause)?;
        let errors = self.layer(PictureLayer::Error)?;
        Some(errors.index_axis(Axis(0), channel))
    }

    /// A copy of some rows.
    ///
    /// # Panics
    /// If there are no such rows.
    #[must_use]
    pub fn rows(&self, rows: Range<usize>) -> Self {
        let of_rows = |values: &Array3<f32>| values.slice(s![.., rows.clone(), ..]).to_owned();
        let layers = self.layers();
        Self {
            radiance: of_rows(&self.radiance),
            layers: layers
                .map(|(layer, values)| (layer, of_rows(values)))
                .collect(),
        }
    }
}

impl Index<PictureLayer> for Rendered {
    type Output = Array3<f32>;

    /// A layer that was wanted, by channel, row and column.
    ///
    /// # Panics
    /// Of one that was not.
    fn index(&self, layer: PictureLayer) -> &Array3<f32> {
        let Some(values) = self.layer(layer) else {
            panic!("no layer {} was wanted", layer.name());
        };
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_order_of_the_enumeration() {
        for (index, (layer, ..)) in TABLE.into_iter().enumerate() {
            assert_eq!(layer as usize, index);
        }
        let named = [TOTAL, QUADRATURE, FOOTPRINT].map(|it| ERRORS[it]);
        assert_eq!(named, ["Y", "quadrature", "footprint"]);
    }
}
