//! The arrays of a picture, and their rows as threads fill them.

use std::ops::Range;

use glam::Vec4;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::ArrayViewMut1;
use ndarray::ArrayViewMut2;
use ndarray::Axis;
use ndarray::s;
use rayon::prelude::*;

use crate::error_parts::ErrorParts;
use crate::footprint_error::Glimpse;
use crate::footprint_error::cross;
use crate::footprint_error::footprint_error;
use crate::levels::PixelFootprint;
use crate::pixel::Pixel;

/// A rendered picture, all arrays by row and column of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Spectral radiance by wavelength, row and column, bin means [W m^-2 sr^-1 nm^-1].
    pub radiance: Array3<f32>,
    /// Light of the drops on the primary side of the split: CIE X, Y, Z [cd/m²].
    pub bow_primary: Array3<f32>,
    /// Light of the drops on the secondary side of the split: CIE X, Y, Z [cd/m²].
    pub bow_secondary: Array3<f32>,
    /// Light that drops scattered more than once, and what the light diffracted once changes in the
    /// bows: CIE X, Y, Z [cd/m²]; `None` where it is not wanted.
    pub bow_multiple: Option<Array3<f32>>,
    /// Light of the air from the eye to the far side of the drops: CIE X, Y, Z [cd/m²].
    pub inscatter: Array3<f32>,
    /// Light of the surroundings that the drops scatter to the eye: CIE X, Y, Z [cd/m²]; `None`
    /// where that effect is off.
    pub skylit: Option<Array3<f32>>,
    /// What the drops let pass of the light behind them, without diffraction (Q = 1).
    pub transmittance: Array2<f32>,
    /// Optical depth of the drops towards the sun at Q = 1, mean over the light of the drops; 0
    /// where there is none.
    pub tau_sun: Array2<f32>,
    /// Mean distance from the eye of the light of the drops (m); 0 where there is none.
    pub depth: Array2<f32>,
    /// Distance of the surface that ends the ray through the middle of the pixel (m), infinite for
    /// the sky; `None` where no surfaces are given.
    pub surface: Option<Array2<f32>>,
    /// Estimated absolute error of luminance [cd/m²].
    pub error: Array2<f32>,
    /// What the error is made of.
    pub error_parts: ErrorParts,
}

/// One row of every array.
pub(crate) struct RowMut<'a> {
    pub(crate) radiance: ArrayViewMut2<'a, f32>,
    pub(crate) bow_primary: ArrayViewMut2<'a, f32>,
    pub(crate) bow_secondary: ArrayViewMut2<'a, f32>,
    pub(crate) bow_multiple: Option<ArrayViewMut2<'a, f32>>,
    pub(crate) inscatter: ArrayViewMut2<'a, f32>,
    pub(crate) skylit: Option<ArrayViewMut2<'a, f32>>,
    pub(crate) transmittance: ArrayViewMut1<'a, f32>,
    pub(crate) tau_sun: ArrayViewMut1<'a, f32>,
    pub(crate) depth: ArrayViewMut1<'a, f32>,
    pub(crate) surface: Option<ArrayViewMut1<'a, f32>>,
    pub(crate) error: ArrayViewMut1<'a, f32>,
    /// In the order of [`ErrorParts`].
    pub(crate) error_parts: [ArrayViewMut1<'a, f32>; 5],
}

impl Rendered {
    /// A black picture of nothing. Zeroed memory is not touched until a row is written.
    pub(crate) fn dark(n_wavelengths: usize, height: usize, width: usize) -> Self {
        let xyz = || Array3::zeros((3, height, width));
        let plane = || Array2::zeros((height, width));
        Self {
            radiance: Array3::zeros((n_wavelengths, height, width)),
            bow_primary: xyz(),
            bow_secondary: xyz(),
            bow_multiple: None,
            inscatter: xyz(),
            skylit: None,
            transmittance: plane(),
            tau_sun: plane(),
            depth: plane(),
            surface: None,
            error: plane(),
            error_parts: ErrorParts::none((height, width)),
        }
    }

    pub(crate) fn rows_mut(&mut self) -> Vec<RowMut<'_>> {
        let mut radiance = self.radiance.axis_iter_mut(Axis(1));
        let mut bow_primary = self.bow_primary.axis_iter_mut(Axis(1));
        let mut bow_secondary = self.bow_secondary.axis_iter_mut(Axis(1));
        let mut bow_multiple = self
            .bow_multiple
            .as_mut()
            .map(|planes| planes.axis_iter_mut(Axis(1)));
        let mut inscatter = self.inscatter.axis_iter_mut(Axis(1));
        let mut skylit = self
            .skylit
            .as_mut()
            .map(|planes| planes.axis_iter_mut(Axis(1)));
        let mut transmittance = self.transmittance.outer_iter_mut();
        let mut tau_sun = self.tau_sun.outer_iter_mut();
        let mut depth = self.depth.outer_iter_mut();
        let mut surface = self.surface.as_mut().map(|plane| plane.outer_iter_mut());
        let mut error = self.error.outer_iter_mut();
        let mut quadrature = self.error_parts.quadrature.outer_iter_mut();
        let mut sizes = self.error_parts.sizes.outer_iter_mut();
        let mut shadow = self.error_parts.shadow.outer_iter_mut();
        let mut orders = self.error_parts.orders.outer_iter_mut();
        let mut footprint = self.error_parts.footprint.outer_iter_mut();
        std::iter::from_fn(|| {
            Some(RowMut {
                radiance: radiance.next()?,
                bow_primary: bow_primary.next()?,
                bow_secondary: bow_secondary.next()?,
                bow_multiple: match &mut bow_multiple {
                    Some(rows) => Some(rows.next()?),
                    None => None,
                },
                inscatter: inscatter.next()?,
                skylit: match &mut skylit {
                    Some(rows) => Some(rows.next()?),
                    None => None,
                },
                transmittance: transmittance.next()?,
                tau_sun: tau_sun.next()?,
                depth: depth.next()?,
                surface: match &mut surface {
                    Some(rows) => Some(rows.next()?),
                    None => None,
                },
                error: error.next()?,
                error_parts: [
                    quadrature.next()?,
                    sizes.next()?,
                    shadow.next()?,
                    orders.next()?,
                    footprint.next()?,
                ],
            })
        })
        .collect()
    }

    /// Add what pixels miss to the error of rows; `glimpses` reach [`REACH_PX`] beyond the picture.
    pub(crate) fn add_footprint_error(
        &mut self,
        rows: Range<usize>,
        footprint: PixelFootprint,
        glimpses: &Array2<Glimpse>,
    ) {
        let mut errors = self.error.slice_mut(s![rows.clone(), ..]);
        let mut parts = self.error_parts.footprint.slice_mut(s![rows.clone(), ..]);
        let pairs = errors.outer_iter_mut().into_par_iter();
        let pairs = pairs.zip(parts.outer_iter_mut().into_par_iter());
        pairs.zip(rows).for_each(|((errors, parts), y)| {
            for (x, (error, part)) in errors.into_iter().zip(parts).enumerate() {
                let missed = footprint_error(&cross(glimpses, x, y), footprint) as f32;
                *part = missed;
                *error += missed;
            }
        });
    }
}

impl RowMut<'_> {
    /// Luminance of a pixel that was put before [cd/m²].
    pub(crate) fn luminance(&self, x: usize, xyz_weights: &[Vec4]) -> f64 {
        let terms = self.radiance.outer_iter().zip(xyz_weights);
        terms
            .map(|(plane, weight)| f64::from(plane[x] * weight.y))
            .sum()
    }

    /// Add what the footprint misses of a pixel that was just put.
    pub(crate) fn put_missed(&mut self, x: usize, missed: f32) {
        let [.., footprint] = &mut self.error_parts;
        footprint[x] = missed;
        self.error[x] += missed;
    }

    /// Everything of a pixel but its spectrum.
    pub(crate) fn put(&mut self, x: usize, pixel: &Pixel) {
        for (plane, xyz) in [
            (&mut self.bow_primary, pixel.bow_primary),
            (&mut self.bow_secondary, pixel.bow_secondary),
            (&mut self.inscatter, pixel.inscatter),
        ] {
            put_xyz(plane, x, xyz);
        }
        if let Some(plane) = &mut self.bow_multiple {
            put_xyz(plane, x, pixel.bow_multiple);
        }
        if let Some(plane) = &mut self.skylit {
            put_xyz(plane, x, pixel.skylit);
        }
        self.transmittance[x] = pixel.transmittance as f32;
        if pixel.light > 0.0 {
            self.tau_sun[x] = (pixel.light_tau_sun / pixel.light) as f32;
            self.depth[x] = (pixel.light_m / pixel.light) as f32;
        }
        self.error[x] = pixel.errors.sum() as f32;
        // Zip ends before the footprint's, which rays know nothing of.
        let parts = pixel.errors.parts().map(|part| part as f32);
        for (plane, part) in self.error_parts.iter_mut().zip(parts) {
            plane[x] = part;
        }
    }
}

fn put_xyz(plane: &mut ArrayViewMut2<f32>, x: usize, xyz: Vec4) {
    for channel in 0..3 {
        plane[[channel, x]] = xyz[channel];
    }
}
