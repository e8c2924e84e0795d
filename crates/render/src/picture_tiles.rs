//! The arrays of a picture, and their tiles as threads fill them.
//!
//! Pixels of a tile look through the same drops at nearly the same angles. What one of them reads, cells
//! and rows of the scattering table, the others find in the core's cache; a row of pixels has left it
//! before the next row asks again.

use std::ops::Range;

use glam::Vec4;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::ArrayViewMut;
use ndarray::ArrayViewMut2;
use ndarray::ArrayViewMut3;
use ndarray::Axis;
use ndarray::Dimension;
use ndarray::Slice;
use ndarray::s;
use rayon::prelude::*;

use crate::error_parts::ErrorParts;
use crate::error_parts::N_PARTS;
use crate::error_parts::together;
use crate::footprint_error::Glimpse;
use crate::footprint_error::cross;
use crate::painter::Painter;
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
    /// Light of the drops in the sun that water mirrors, both bows: CIE X, Y, Z [cd/m²]; `None` where
    /// it is not wanted.
    pub bow_reflected: Option<Array3<f32>>,
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

/// Rows and columns of a tile. Five others, of 4 to 16 rows and 8 to 64 columns, were no faster.
const TILE: (usize, usize) = (8, 32);

/// A tile of every array.
pub(crate) struct TileMut<'a> {
    /// Column and row of its first pixel in the region.
    first: (usize, usize),
    pub(crate) radiance: ArrayViewMut3<'a, f32>,
    pub(crate) bow_primary: ArrayViewMut3<'a, f32>,
    pub(crate) bow_secondary: ArrayViewMut3<'a, f32>,
    pub(crate) bow_multiple: Option<ArrayViewMut3<'a, f32>>,
    pub(crate) bow_reflected: Option<ArrayViewMut3<'a, f32>>,
    pub(crate) inscatter: ArrayViewMut3<'a, f32>,
    pub(crate) skylit: Option<ArrayViewMut3<'a, f32>>,
    pub(crate) transmittance: ArrayViewMut2<'a, f32>,
    pub(crate) tau_sun: ArrayViewMut2<'a, f32>,
    pub(crate) depth: ArrayViewMut2<'a, f32>,
    pub(crate) surface: Option<ArrayViewMut2<'a, f32>>,
    pub(crate) error: ArrayViewMut2<'a, f32>,
    /// In the order of [`ErrorParts`].
    pub(crate) error_parts: [ArrayViewMut2<'a, f32>; N_PARTS],
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
            bow_reflected: None,
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

    /// Rows of pixels by tiles, from left to right and top to bottom.
    pub(crate) fn tiles_mut(&mut self, rows: &Range<usize>) -> Vec<TileMut<'_>> {
        let width = self.depth.ncols();
        let tops = rows.clone().step_by(TILE.0);
        let mut firsts = tops.flat_map(|y| (0..width).step_by(TILE.1).map(move |x| (x, y)));
        let mut radiance = tiles(self.radiance.view_mut(), rows);
        let mut bow_primary = tiles(self.bow_primary.view_mut(), rows);
        let mut bow_secondary = tiles(self.bow_secondary.view_mut(), rows);
        let bow_multiple = self.bow_multiple.as_mut();
        let mut bow_multiple = bow_multiple.map(|planes| tiles(planes.view_mut(), rows));
        let bow_reflected = self.bow_reflected.as_mut();
        let mut bow_reflected = bow_reflected.map(|planes| tiles(planes.view_mut(), rows));
        let mut inscatter = tiles(self.inscatter.view_mut(), rows);
        let skylit = self.skylit.as_mut();
        let mut skylit = skylit.map(|planes| tiles(planes.view_mut(), rows));
        let mut transmittance = tiles(self.transmittance.view_mut(), rows);
        let mut tau_sun = tiles(self.tau_sun.view_mut(), rows);
        let mut depth = tiles(self.depth.view_mut(), rows);
        let surface = self.surface.as_mut();
        let mut surface = surface.map(|plane| tiles(plane.view_mut(), rows));
        let mut error = tiles(self.error.view_mut(), rows);
        let mut quadrature = tiles(self.error_parts.quadrature.view_mut(), rows);
        let mut angles = tiles(self.error_parts.angles.view_mut(), rows);
        let mut sizes = tiles(self.error_parts.sizes.view_mut(), rows);
        let mut shadow = tiles(self.error_parts.shadow.view_mut(), rows);
        let mut orders = tiles(self.error_parts.orders.view_mut(), rows);
        let mut air = tiles(self.error_parts.air.view_mut(), rows);
        let mut footprint = tiles(self.error_parts.footprint.view_mut(), rows);
        std::iter::from_fn(|| {
            Some(TileMut {
                first: firsts.next()?,
                radiance: radiance.next()?,
                bow_primary: bow_primary.next()?,
                bow_secondary: bow_secondary.next()?,
                bow_multiple: match &mut bow_multiple {
                    Some(tiles) => Some(tiles.next()?),
                    None => None,
                },
                bow_reflected: match &mut bow_reflected {
                    Some(tiles) => Some(tiles.next()?),
                    None => None,
                },
                inscatter: inscatter.next()?,
                skylit: match &mut skylit {
                    Some(tiles) => Some(tiles.next()?),
                    None => None,
                },
                transmittance: transmittance.next()?,
                tau_sun: tau_sun.next()?,
                depth: depth.next()?,
                surface: match &mut surface {
                    Some(tiles) => Some(tiles.next()?),
                    None => None,
                },
                error: error.next()?,
                error_parts: [
                    quadrature.next()?,
                    angles.next()?,
                    sizes.next()?,
                    shadow.next()?,
                    orders.next()?,
                    air.next()?,
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
        painter: &Painter,
        glimpses: &Array2<Glimpse>,
    ) {
        let mut errors = self.error.slice_mut(s![rows.clone(), ..]);
        let mut parts = self.error_parts.footprint.slice_mut(s![rows.clone(), ..]);
        let pairs = errors.outer_iter_mut().into_par_iter();
        let pairs = pairs.zip(parts.outer_iter_mut().into_par_iter());
        pairs.zip(rows).for_each(|((errors, parts), y)| {
            for (x, (error, part)) in errors.into_iter().zip(parts).enumerate() {
                let missed = painter.missed(&cross(glimpses, x, y), painter.footprint);
                *part = missed as f32;
                *error = together(&[f64::from(*error), missed]) as f32;
            }
        });
    }
}

impl TileMut<'_> {
    /// Column and row in the region of a pixel of the tile.
    pub(crate) fn in_region(&self, (x, y): (usize, usize)) -> (usize, usize) {
        (self.first.0 + x, self.first.1 + y)
    }

    /// Luminance of a pixel by column and row that was put before [cd/m²].
    pub(crate) fn luminance(&self, (x, y): (usize, usize), xyz_weights: &[Vec4]) -> f64 {
        let terms = self.radiance.outer_iter().zip(xyz_weights);
        terms
            .map(|(plane, weight)| f64::from(plane[[y, x]] * weight.y))
            .sum()
    }

    /// Add what the footprint misses of a pixel that was just put.
    pub(crate) fn put_missed(&mut self, (x, y): (usize, usize), missed: f64) {
        let [.., footprint] = &mut self.error_parts;
        footprint[[y, x]] = missed as f32;
        let error = &mut self.error[[y, x]];
        *error = together(&[f64::from(*error), missed]) as f32;
    }

    /// Everything of a pixel but its spectrum.
    pub(crate) fn put(&mut self, (x, y): (usize, usize), pixel: &Pixel) {
        for (planes, xyz) in [
            (&mut self.bow_primary, pixel.bow_primary),
            (&mut self.bow_secondary, pixel.bow_secondary),
            (&mut self.inscatter, pixel.inscatter),
        ] {
            put_xyz(planes, (x, y), xyz);
        }
        if let Some(planes) = &mut self.bow_multiple {
            put_xyz(planes, (x, y), pixel.bow_multiple);
        }
        if let Some(planes) = &mut self.bow_reflected {
            put_xyz(planes, (x, y), pixel.bow_reflected);
        }
        if let Some(planes) = &mut self.skylit {
            put_xyz(planes, (x, y), pixel.skylit);
        }
        self.transmittance[[y, x]] = pixel.transmittance as f32;
        if pixel.light > 0.0 {
            self.tau_sun[[y, x]] = (pixel.light_tau_sun / pixel.light) as f32;
            self.depth[[y, x]] = (pixel.light_m / pixel.light) as f32;
        }
        self.error[[y, x]] = pixel.errors.together() as f32;
        // Zip ends before the footprint's, which rays know nothing of.
        let parts = pixel.errors.parts().map(|part| part as f32);
        for (plane, part) in self.error_parts.iter_mut().zip(parts) {
            plane[[y, x]] = part;
        }
    }
}

fn put_xyz(planes: &mut ArrayViewMut3<f32>, (x, y): (usize, usize), xyz: Vec4) {
    for channel in 0..3 {
        planes[[channel, y, x]] = xyz[channel];
    }
}

/// The tiles of some rows of a view, whose last two axes are rows and columns.
pub(crate) fn tiles<'a, T, D: Dimension>(
    mut view: ArrayViewMut<'a, T, D>,
    rows: &Range<usize>,
) -> impl Iterator<Item = ArrayViewMut<'a, T, D>> + use<'a, T, D> {
    let (down, across) = (Axis(view.ndim() - 2), Axis(view.ndim() - 1));
    view.slice_axis_inplace(down, Slice::from(rows.clone()));
    let bands = cut(view, down, TILE.0).into_iter();
    bands.flat_map(move |band| cut(band, across, TILE.1))
}

/// A view in parts along an axis, the last of them shorter.
fn cut<T, D: Dimension>(
    view: ArrayViewMut<T, D>,
    axis: Axis,
    length: usize,
) -> Vec<ArrayViewMut<T, D>> {
    let mut parts = Vec::new();
    let mut left = view;
    while left.len_of(axis) > 0 {
        let at = length.min(left.len_of(axis));
        let (part, behind) = left.split_at(axis, at);
        parts.push(part);
        left = behind;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_some_rows_lies_in_one_tile_at_its_own_place() {
        let (height, width) = (2 * TILE.0 + 3, 2 * TILE.1 + 5);
        for rows in [0..height, 3..height - 1, 7..8, 5..5] {
            let mut picture = Rendered::dark(2, height, width);
            for mut tile in picture.tiles_mut(&rows) {
                let (tile_height, tile_width) = tile.depth.dim();
                assert!(tile_height <= TILE.0 && tile_width <= TILE.1);
                for y in 0..tile_height {
                    for x in 0..tile_width {
                        let (column, row) = tile.in_region((x, y));
                        let number = (1 + row * width + column) as f32;
                        tile.depth[[y, x]] += number;
                        tile.radiance[[1, y, x]] += number;
                    }
                }
            }
            let expected = Array2::from_shape_fn((height, width), |(row, column)| {
                let number = (1 + row * width + column) as f32;
                if rows.contains(&row) { number } else { 0.0 }
            });
            assert_eq!(picture.depth, expected);
            assert_eq!(picture.radiance.index_axis(Axis(0), 1), expected);
        }
    }
}
