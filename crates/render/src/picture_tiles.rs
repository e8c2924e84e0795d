//! The arrays of a picture, and their tiles as threads fill them.
//!
//! Pixels of a tile look through the same drops at nearly the same angles. What one of them reads, cells
//! and rows of the scattering table, the others find in the core's cache; a row of pixels has left it
//! before the next row asks again.

use std::ops::Range;

use glam::Vec4;
use ndarray::Array2;
use ndarray::ArrayView1;
use ndarray::ArrayViewMut;
use ndarray::ArrayViewMut3;
use ndarray::Axis;
use ndarray::Dimension;
use ndarray::Slice;
use ndarray::s;
use rayon::prelude::*;

use crate::error_parts::together;
use crate::picture_layers::FOOTPRINT;
use crate::picture_layers::PictureLayer;
use crate::picture_layers::PictureLayer::Error;
use crate::picture_layers::PictureLayer::Surface;
use crate::picture_layers::QUADRATURE;
use crate::picture_layers::Rendered;
use crate::picture_layers::TOTAL;
use crate::pixel::Pixel;

/// Rows and columns of a tile. Five others, of 4 to 16 rows and 8 to 64 columns, were no faster.
const TILE: (usize, usize) = (8, 32);

/// A tile of every array.
pub(crate) struct TileMut<'a> {
    /// Column and row of its first pixel in the region.
    first: (usize, usize),
    /// By wavelength, row and column.
    pub(crate) radiance: ArrayViewMut3<'a, f32>,
    /// By channel, row and column.
    layers: Vec<(PictureLayer, ArrayViewMut3<'a, f32>)>,
}

/// What rays could better of a pixel, from its errors by cause [cd/m²].
pub(crate) fn of_rays(causes: &ArrayView1<f32>) -> f64 {
    together(&[QUADRATURE, FOOTPRINT].map(|cause| f64::from(causes[cause])))
}

impl Rendered {
    /// What rays could better of the pixels of some rows [cd/m²].
    pub(crate) fn errors_of_rays(&self, rows: &Range<usize>) -> Vec<f64> {
        let errors = self.layers.iter().filter(|(layer, _)| *layer == Error);
        let of_rows = errors.flat_map(|(_, values)| {
            let of_rows = values.slice(s![.., rows.clone(), ..]);
            of_rows.map_axis(Axis(0), |causes| of_rays(&causes))
        });
        of_rows.collect()
    }

    /// Luminance of rows of pixels [cd/m²].
    pub(crate) fn luminance_of(&self, rows: &Range<usize>, xyz_weights: &[Vec4]) -> Array2<f64> {
        let radiance = self.radiance.slice(s![.., rows.clone(), ..]);
        let mut luminance = Array2::zeros((rows.len(), self.radiance.dim().2));
        for (plane, weight) in radiance.outer_iter().zip(xyz_weights) {
            luminance.zip_mut_with(&plane, |sum, value| *sum += f64::from(value * weight.y));
        }
        luminance
    }

    /// Rows of pixels by tiles, from left to right and top to bottom.
    pub(crate) fn tiles_mut(&mut self, rows: &Range<usize>) -> Vec<TileMut<'_>> {
        let width = self.radiance.dim().2;
        let tops = rows.clone().step_by(TILE.0);
        let firsts = tops.flat_map(|y| (0..width).step_by(TILE.1).map(move |x| (x, y)));
        let radiance = tiles(self.radiance.view_mut(), rows);
        let pixels = firsts.zip(radiance).map(|(first, radiance)| TileMut {
            first,
            radiance,
            layers: Vec::new(),
        });
        let mut pixels: Vec<TileMut> = pixels.collect();
        for (layer, values) in &mut self.layers {
            let tiles = tiles(values.view_mut(), rows);
            for (tile, values) in pixels.iter_mut().zip(tiles) {
                tile.layers.push((*layer, values));
            }
        }
        pixels
    }

    /// Add what pixels of some rows miss, by column and row, to their error.
    pub(crate) fn add_missed(
        &mut self,
        rows: Range<usize>,
        missed: &(dyn Fn(usize, usize) -> f64 + Sync),
    ) {
        let Some((_, errors)) = self.layers.iter_mut().find(|(layer, _)| *layer == Error) else {
            return;
        };
        let mut errors = errors.slice_mut(s![.., rows.clone(), ..]);
        let errors = errors.axis_iter_mut(Axis(1)).into_par_iter();
        errors.zip(rows).for_each(|(mut errors, y)| {
            for (x, mut causes) in errors.axis_iter_mut(Axis(1)).enumerate() {
                let missed = missed(x, y);
                causes[FOOTPRINT] = missed as f32;
                causes[TOTAL] = together(&[f64::from(causes[TOTAL]), missed]) as f32;
            }
        });
    }
}

impl<'a> TileMut<'a> {
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

    /// Errors by cause, row and column, the sum of all first.
    pub(crate) fn errors(&mut self) -> &mut ArrayViewMut3<'a, f32> {
        let errors = self.layers.iter_mut().find(|(layer, _)| *layer == Error);
        &mut errors.expect("every picture has its error").1
    }

    /// Set what the footprint misses of a pixel, beside its other errors.
    pub(crate) fn put_missed(&mut self, (x, y): (usize, usize), missed: f64) {
        let mut causes = self.errors().slice_mut(s![.., y, x]);
        causes[FOOTPRINT] = missed as f32;
        let parts = causes.slice(s![TOTAL + 1..]).mapv(f64::from);
        causes[TOTAL] = together(&parts.to_vec()) as f32;
    }

    /// Where the ray through the middle of a pixel ends, where that is wanted (m).
    pub(crate) fn put_surface(&mut self, (x, y): (usize, usize), surface_m: impl Fn() -> f64) {
        for (layer, values) in &mut self.layers {
            if *layer == Surface {
                // f32: what the map held.
                values[[0, y, x]] = surface_m() as f32;
            }
        }
    }

    /// Everything of a pixel but its spectrum and its surface.
    pub(crate) fn put(&mut self, (x, y): (usize, usize), pixel: &Pixel) {
        for (layer, values) in &mut self.layers {
            let channels = pixel.channels(*layer);
            for (channel, value) in channels.iter().enumerate() {
                values[[channel, y, x]] = *value;
            }
        }
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
    use ndarray::Array2;

    use super::*;

    #[test]
    fn every_pixel_of_some_rows_lies_in_one_tile_at_its_own_place() {
        let (height, width) = (2 * TILE.0 + 3, 2 * TILE.1 + 5);
        for rows in [0..height, 3..height - 1, 7..8, 5..5] {
            let layers = PictureLayer::all();
            let mut picture = Rendered::dark([2, height, width], layers);
            for mut tile in picture.tiles_mut(&rows) {
                let (_, tile_height, tile_width) = tile.radiance.dim();
                assert!(tile_height <= TILE.0 && tile_width <= TILE.1);
                for y in 0..tile_height {
                    for x in 0..tile_width {
                        let (column, row) = tile.in_region((x, y));
                        let number = (1 + row * width + column) as f32;
                        tile.errors()[[TOTAL, y, x]] += number;
                        tile.radiance[[1, y, x]] += number;
                    }
                }
            }
            let expected = Array2::from_shape_fn((height, width), |(row, column)| {
                let number = (1 + row * width + column) as f32;
                if rows.contains(&row) { number } else { 0.0 }
            });
            assert_eq!(picture[Error].index_axis(Axis(0), TOTAL), expected);
            assert_eq!(picture.radiance.index_axis(Axis(0), 1), expected);
        }
    }
}
