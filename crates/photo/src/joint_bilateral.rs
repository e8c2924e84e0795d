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
use crate::perceptual::oklab;
use crate::photograph::LinearPicture;
use crate::resample::same_shape;

/// Reach of the sum, pixels of the coarse map.
const REACH: isize = 2;
/// Standard deviation in place, pixels of the coarse map.
const PLACE_PX: f32 = 1.0;
/// Standard deviation of color, Oklab.
const COLOR: f32 = 0.05;

/// A depth map in the resolution of a photograph of the same shape.
///
/// # Errors
/// A map of another shape.
pub fn upsample_depth(coarse_m: &Array2<f32>, photo: &LinearPicture) -> Result<Array2<f32>, Error> {
    let (size, fine) = (coarse_m.dim(), photo.dim());
    if size == fine {
        return Ok(coarse_m.clone());
    }
    if !same_shape(size, fine) {
        check_size("the depth map", fine, size)?;
    }
    let scale = [size.0 as f32 / fine.0 as f32, size.1 as f32 / fine.1 as f32];
    let colors = Array2::from_shape_fn(size, |(y, x)| {
        let at = |index: usize, scale: f32, n: usize| {
            (((index as f32 + 0.5) / scale) as usize).min(n - 1)
        };
        oklab(photo[[at(y, scale[0], fine.0), at(x, scale[1], fine.1)]])
    });
    let inverse = coarse_m.mapv(f32::recip);
    let mut depth = Array2::zeros(fine);
    Zip::indexed(&mut depth)
        .and(photo)
        .par_for_each(|(y, x), depth, pixel| {
            let place = [
                (y as f32 + 0.5) * scale[0] - 0.5,
                (x as f32 + 0.5) * scale[1] - 0.5,
            ];
            *depth = filtered(place, oklab(*pixel), &colors, &inverse).recip();
        });
    Ok(depth)
}

fn filtered(
    place: [f32; 2],
    color: [f32; 3],
    colors: &Array2<[f32; 3]>,
    inverse: &Array2<f32>,
) -> f32 {
    let (height, width) = inverse.dim();
    let middle = place.map(|value| value.round() as isize);
    let window = |middle: isize, n: usize| {
        let low = (middle - REACH).max(0);
        low..=(middle + REACH).min(n as isize - 1)
    };
    let exponent = |y: isize, x: isize| {
        let (dy, dx) = (place[0] - y as f32, place[1] - x as f32);
        let near = colors[[y as usize, x as usize]];
        let apart: f32 = near.iter().zip(color).map(|(a, b)| (a - b) * (a - b)).sum();
        (dy * dy + dx * dx) / (2.0 * PLACE_PX * PLACE_PX) + apart / (2.0 * COLOR * COLOR)
    };
    // The smallest exponent is taken out, so that the largest weight is 1.
    let mut exponents = [f32::INFINITY; 25];
    let mut values = [0.0; 25];
    let mut n = 0;
    for y in window(middle[0], height) {
        for x in window(middle[1], width) {
            exponents[n] = exponent(y, x);
            values[n] = inverse[[y as usize, x as usize]];
            n += 1;
        }
    }
    let least = exponents.iter().copied().fold(f32::INFINITY, f32::min);
    let (mut sum, mut total) = (0.0, 0.0);
    for index in 0..n {
        let weight = (least - exponents[index]).exp();
        sum += weight * values[index];
        total += weight;
    }
    sum / total
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
    fn a_plain_depth_stays_plain_on_any_picture() {
        let photo =
            Array2::from_shape_fn((30, 30), |(y, x)| [y as f32 / 30.0, x as f32 / 30.0, 0.5]);
        let fine = upsample_depth(&Array2::from_elem((10, 10), 7.0), &photo).unwrap();
        assert!(fine.iter().all(|depth| (depth - 7.0).abs() < 1e-5));
        assert!(upsample_depth(&Array2::zeros((10, 12)), &photo).is_err());
    }
}
