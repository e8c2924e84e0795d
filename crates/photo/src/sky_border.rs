//! Where the sky may end first, going down each column.
//!
//! b(x; t) = the first row at which the picture is sharper than t
//! Sharpness stands for the gradient of the source, so that ramps and soft clouds are no edges.
//! [SW13] Y. Shen, Q. Wang, Sky region detection in a single image for autonomous ground robot
//! navigation, Int. J. Advanced Robotic Systems 10, 362 (2013): borders by column. Which threshold serves is told by
//! what the colors make of it, no longer by the border.

use ndarray::Array2;

use crate::perceptual::square_apart;
use crate::sky_mask::quantile;

/// Thresholds, between the lowest (0) and the highest (1) by their ratio.
const THRESHOLDS: [f64; 3] = [0.25, 0.51, 0.77];
/// The lowest and the highest, as parts of the pixels that are less sharp.
const QUANTILES: (f64, f64) = (0.2, 0.99);

/// How sharply a picture in Oklab changes about each pixel: the root mean square over three by three pixels of
/// the difference from the mean of theirs. Ramps have none, soft clouds little.
pub(crate) fn sharpness(lab: &Array2<[f32; 3]>) -> Array2<f32> {
    let means = mean_of_nine(lab);
    let squares = Array2::from_shape_fn(lab.dim(), |at| [square_apart(lab[at], means[at])]);
    mean_of_nine(&squares).mapv(|[square]| square.sqrt())
}

/// Means of three by three pixels, fewer at the edges.
pub(crate) fn mean_of_nine<const N: usize>(picture: &Array2<[f32; N]>) -> Array2<[f32; N]> {
    let (height, width) = picture.dim();
    Array2::from_shape_fn((height, width), |(y, x)| {
        let mut sum = [0.0; N];
        let mut n = 0.0;
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                n += 1.0;
                for (sum, value) in sum.iter_mut().zip(picture[[row, column]]) {
                    *sum += value;
                }
            }
        }
        sum.map(|sum: f32| sum / n)
    })
}

/// The first row of each column that is no sky, by how sharp the picture is, for each threshold.
pub(crate) fn sky_borders(sharpness: &Array2<f32>) -> Vec<Vec<usize>> {
    let all = || sharpness.iter().copied().collect();
    let [low, high] =
        [QUANTILES.0, QUANTILES.1].map(|part| f64::from(quantile(all(), part)).max(1e-6));
    let border = |part: f64| {
        let threshold = (low * (high / low).powf(part)) as f32;
        let rows = sharpness.columns().into_iter().map(|column| {
            let first = column.iter().position(|value| *value > threshold);
            first.unwrap_or(column.len())
        });
        rows.collect()
    };
    THRESHOLDS.into_iter().map(border).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of light above a rough hill, with the noise of a sensor.
    fn hill() -> (Array2<[f32; 3]>, Vec<usize>) {
        let line: Vec<usize> = (0..160).map(|x| 50 + x / 8 + (x * x) % 3).collect();
        let lab = Array2::from_shape_fn((120, 160), |(y, x)| {
            let grain = 0.01 * ((x * x * 7 + y * 13 + x * y) % 97) as f32 / 97.0;
            if y < line[x] {
                [0.6 + 0.003 * y as f32 + grain, 0.0, -0.05]
            } else {
                [0.4 + 10.0 * grain, -0.05, 0.05]
            }
        });
        (lab, line)
    }

    #[test]
    fn the_border_follows_the_hill_and_no_ramp() {
        let (lab, line) = hill();
        let borders = sky_borders(&sharpness(&lab));
        for (found, row) in borders[1].iter().zip(&line) {
            // Sharpness reaches two pixels out, and so do the steps of the line.
            assert!((row - 5..=row + 2).contains(found), "{found} {row}");
        }
        let ramp = Array2::from_shape_fn((40, 30), |(y, _)| [0.01 * y as f32, 0.0, 0.0]);
        let sharp = sharpness(&ramp);
        let inside = sharp.slice(ndarray::s![2..38, ..]);
        assert!(inside.iter().all(|value| *value < 1e-6));
    }
}
