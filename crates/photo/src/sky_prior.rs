//! How like a sky a pixel is before its picture's own colors are known.
//!
//! log p(sky)/p(ground) = w0 + w1 b + w2 a² + w3 (L − L̃) + w4 y/h + w5 ln(s + s0)
//! `L`, `a`, `b` Oklab, `L̃` the median of the picture, `y` the row of `h`, `s` the [`sharpness`](crate::sky_border),
//! `s0` [`LEAST_SHARP`]: a sky is bluer, neither green nor red, brighter than the rest, high and smooth. Which of these
//! a sky lacks may be one or two: a sunset is orange, a shower darker than the land. So this only leans, and the
//! picture's own colors decide.
//!
//! The weights are a logistic regression (ridge of 1 on standardized values) on 1500 pixels of each of 116 photographs
//! of Debian and PyPI packages, 46 of them with a sky outlined by hand, and of the plates 1 to 10 and eight rooms and
//! thickets (seeds 101 to 108), at most 160 pixels across; a picture without a sky counts half. Left out in turn by
//! sixths, 91 % of the pixels of pictures with a sky and 93 % of those without are right.

use ndarray::Array2;

use crate::sky_mask::quantile;

/// w0 to w5.
const WEIGHTS: [f32; 6] = [-4.39, -32.0, -312.0, 7.13, -3.16, -0.921];
/// What is added to the sharpness, Oklab.
pub(crate) const LEAST_SHARP: f32 = 0.003;
/// Largest log ratio that counts.
const MOST: f32 = 4.0;

/// The logarithm of how much likelier a pixel is sky than ground, of a picture in Oklab and its sharpness.
pub(crate) fn sky_prior(lab: &Array2<[f32; 3]>, sharpness: &Array2<f32>) -> Array2<f32> {
    let median = quantile(lab.iter().map(|lab| lab[0]).collect(), 0.5);
    let height = lab.nrows() as f32;
    Array2::from_shape_fn(lab.dim(), |(y, x)| {
        let [l, a, b] = lab[[y, x]];
        let smooth = (sharpness[[y, x]] + LEAST_SHARP).ln();
        let signs = [1.0, b, a * a, l - median, y as f32 / height, smooth];
        let terms = signs.iter().zip(WEIGHTS);
        let sum: f32 = terms.map(|(sign, weight)| sign * weight).sum();
        sum.clamp(-MOST, MOST)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(lab: [f32; 3], row: usize, sharp: f32) -> f32 {
        let mut picture = Array2::from_elem((20, 9), [0.5, 0.0, 0.0]);
        picture[[row, 4]] = lab;
        sky_prior(&picture, &Array2::from_elem((20, 9), sharp))[[row, 4]]
    }

    #[test]
    fn a_sky_is_bluer_brighter_higher_and_smoother_and_neither_green_nor_red() {
        let usual = one([0.6, 0.0, -0.02], 8, 0.02);
        assert!(one([0.6, 0.0, -0.08], 8, 0.02) > usual);
        assert!(one([0.8, 0.0, -0.02], 8, 0.02) > usual);
        assert!(one([0.6, 0.0, -0.02], 2, 0.02) > usual);
        assert!(one([0.6, 0.0, -0.02], 8, 0.005) > usual);
        for a in [-0.1, 0.1] {
            assert!(one([0.6, a, -0.02], 8, 0.02) < usual);
        }
    }

    #[test]
    fn blue_above_is_sky_and_grass_below_is_none() {
        assert!(one([0.75, -0.02, -0.09], 1, 0.002) > 1.0);
        assert!(one([0.5, -0.1, 0.1], 18, 0.05) < -1.0);
    }
}
