//! A coarse depth map on a fine photograph, with edges where the colors change.
//!
//! 1/d(p) = sum_q w(q) (1/d_q) / sum_q w(q),   w = exp(−|p' − q|²/(2 s²)) exp(−|c(p) − c_q|²/(2 r²))
//! `p` pixel of the photograph, `p'` the same place in the coarse map, `q` pixels of that map within
//! two of it, `c` colors in Oklab, `c_q` that of the photograph at the middle of q, `s` = 1 pixel,
//! `r` = 0.05. Inverse depth, because the sky is at infinity and light cares for it. Where no
//! neighbour has the color of p all weights are tiny alike and their ratio decides.
//! [KCLU07] J. Kopf et al., Joint bilateral upsampling, ACM Trans. Graphics 26(3), 96 (2007), eq. 3.

use ndarray::Array2;
use ndarray::Zip;

use crate::compositing::check_size;
use crate::error::Error;
use crate::linear_picture::LinearPicture;
use crate::perceptual::oklab;
use crate::resample::same_shape;

/// Reach of the sum, pixels of the coarse map.
const REACH: isize = 2;
/// Standard deviation in place, pixels of the coarse map.
const PLACE_PX: f32 = 1.0;
/// Standard deviation of color, Oklab.
const COLOR: f32 = 0.05;

/// Pixels within reach of a place.
const MOST_NEAR: usize = (2 * REACH as usize + 1).pow(2);

/// A depth map in the resolution of a photograph of the same shape.
///
/// # Errors
/// A map of another shape.
pub fn upsample_depth(coarse_m: &Array2<f32>, photo: &LinearPicture) -> Result<Array2<f32>, Error> {
    if coarse_m.dim() == photo.dim() {
        return Ok(coarse_m.clone());
    }
    let guide = Guide::new("the depth map", coarse_m.dim(), photo)?;
    Ok(guide.upsample(coarse_m, |values, weights| {
        let (mut sum, mut total) = (0.0, 0.0);
        for (value, weight) in values.iter().zip(weights) {
            sum += weight * value.recip();
            total += weight;
        }
        total / sum
    }))
}

/// Labels in the resolution of a photograph of the same shape: that with the largest sum of weights,
/// so that no surface lies between two layers.
///
/// # Errors
/// Labels of another shape.
pub fn upsample_labels(coarse: &Array2<u8>, photo: &LinearPicture) -> Result<Array2<u8>, Error> {
    if coarse.dim() == photo.dim() {
        return Ok(coarse.clone());
    }
    let guide = Guide::new("the labels", coarse.dim(), photo)?;
    Ok(guide.upsample(coarse, |labels, weights| {
        let votes = |label: u8| -> f32 {
            let own = labels.iter().zip(weights).filter(|near| *near.0 == label);
            own.map(|(_, weight)| weight).sum()
        };
        // Of equals the first in the order of rows.
        let mut best = (labels[0], votes(labels[0]));
        for label in labels {
            let found = votes(*label);
            if found > best.1 {
                best = (*label, found);
            }
        }
        best.0
    }))
}

/// A photograph over a coarse map.
struct Guide<'a> {
    photo: &'a LinearPicture,
    /// Colors of the photograph in the middles of the coarse pixels.
    colors: Array2<[f32; 3]>,
    /// Coarse pixels in one of the photograph, down and across.
    scale: [f32; 2],
}

impl<'a> Guide<'a> {
    fn new(
        what: &'static str,
        size: (usize, usize),
        photo: &'a LinearPicture,
    ) -> Result<Self, Error> {
        let fine = photo.dim();
        if !same_shape(size, fine) {
            check_size(what, fine, size)?;
        }
        let scale = [size.0 as f32 / fine.0 as f32, size.1 as f32 / fine.1 as f32];
        let colors = Array2::from_shape_fn(size, |(y, x)| {
            let at = |index: usize, scale: f32, n: usize| {
                (((index as f32 + 0.5) / scale) as usize).min(n - 1)
            };
            oklab(photo[[at(y, scale[0], fine.0), at(x, scale[1], fine.1)]])
        });
        Ok(Self {
            photo,
            colors,
            scale,
        })
    }

    /// A map of the photograph's size; `mix` gets the values near a pixel and their weights.
    fn upsample<T: Copy + Default + PartialEq + Send + Sync>(
        &self,
        coarse: &Array2<T>,
        mix: impl Fn(&[T], &[f32]) -> T + Sync,
    ) -> Array2<T> {
        let mut fine = Array2::from_elem(self.photo.dim(), T::default());
        Zip::indexed(&mut fine)
            .and(self.photo)
            .par_for_each(|(y, x), fine, pixel| {
                let place = [
                    (y as f32 + 0.5) * self.scale[0] - 0.5,
                    (x as f32 + 0.5) * self.scale[1] - 0.5,
                ];
                let (near, n) = self.near(place);
                let mut values = [T::default(); MOST_NEAR];
                for (value, at) in values.iter_mut().zip(&near[..n]) {
                    *value = coarse[*at];
                }
                let values = &values[..n];
                // Far from edges, where most pixels are, there is nothing to weigh.
                *fine = if values.iter().all(|value| *value == values[0]) {
                    values[0]
                } else {
                    mix(values, &self.weights(place, oklab(*pixel), &near[..n])[..n])
                };
            });
        fine
    }

    /// The coarse pixels within reach of a place, by rows, and their number.
    fn near(&self, place: [f32; 2]) -> ([[usize; 2]; MOST_NEAR], usize) {
        let (height, width) = self.colors.dim();
        let middle = place.map(|value| value.round() as isize);
        let window = |middle: isize, n: usize| {
            let low = (middle - REACH).max(0) as usize;
            low..((middle + REACH + 1).max(0) as usize).min(n)
        };
        let (mut near, mut n) = ([[0; 2]; MOST_NEAR], 0);
        for y in window(middle[0], height) {
            for x in window(middle[1], width) {
                near[n] = [y, x];
                n += 1;
            }
        }
        (near, n)
    }

    fn weights(&self, place: [f32; 2], color: [f32; 3], near: &[[usize; 2]]) -> [f32; MOST_NEAR] {
        // The smallest exponent is taken out, so that the largest weight is 1.
        let mut exponents = [f32::INFINITY; MOST_NEAR];
        for (exponent, at) in exponents.iter_mut().zip(near) {
            let (dy, dx) = (place[0] - at[0] as f32, place[1] - at[1] as f32);
            let colors = self.colors[*at].into_iter().zip(color);
            let apart: f32 = colors.map(|(a, b)| (a - b) * (a - b)).sum();
            *exponent =
                (dy * dy + dx * dx) / (2.0 * PLACE_PX * PLACE_PX) + apart / (2.0 * COLOR * COLOR);
        }
        let least = exponents.iter().copied().fold(f32::INFINITY, f32::min);
        exponents.map(|exponent| (least - exponent).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_of_color_stays_sharp_in_depth() {
        // A tree at 10 m before the sky; its edge at column 37 lies inside the coarse column 4,
        // whose middle is the tree.
        let edge = 37;
        let photo = Array2::from_shape_fn((40, 80), |(_, x)| {
            if x < edge {
                [0.02, 0.05, 0.01]
            } else {
                [0.5, 0.6, 0.9]
            }
        });
        let coarse =
            Array2::from_shape_fn((5, 10), |(_, x)| if x < 5 { 10.0 } else { f32::INFINITY });
        let fine = upsample_depth(&coarse, &photo).unwrap();
        for x in 0..80 {
            let depth = fine[[20, x]];
            if x < edge {
                assert!((depth - 10.0).abs() < 0.01, "{x}: {depth}");
            } else {
                assert!(depth > 1e4, "{x}: {depth}");
            }
        }
    }

    #[test]
    fn labels_follow_edges_of_color_and_none_lies_between_two() {
        let edge = |y: usize| 37 + y / 10;
        let photo = Array2::from_shape_fn((40, 80), |(y, x)| {
            if x < edge(y) {
                [0.02, 0.05, 0.01]
            } else {
                [0.5, 0.6, 0.9]
            }
        });
        let coarse = Array2::from_shape_fn((5, 10), |(_, x)| if x < 5 { 0 } else { 2 });
        let fine = upsample_labels(&coarse, &photo).unwrap();
        for ((y, x), label) in fine.indexed_iter() {
            assert_eq!(*label, if x < edge(y) { 0 } else { 2 }, "{y} {x}");
        }
        assert!(upsample_labels(&Array2::zeros((10, 12)), &photo).is_err());
    }

    #[test]
    fn a_plain_depth_stays_plain_on_any_picture() {
        let photo =
            Array2::from_shape_fn((30, 30), |(y, x)| [y as f32 / 30.0, x as f32 / 30.0, 0.5]);
        let fine = upsample_depth(&Array2::from_elem((10, 10), 7.0), &photo).unwrap();
        assert!(fine.iter().all(|depth| (depth - 7.0).abs() < 1e-5));
        assert!(upsample_depth(&Array2::zeros((10, 12)), &photo).is_err());
    }
}
