//! Where the sky ends first, going down each column: a first guess of the sky.
//!
//! b(x; t) = the first row at which the picture is sharper than t
//! r(t) = sum_x min(|b(x + 1) − b(x)|, m),   `m` also where b lies at the top or the bottom
//! The border is b(x; t) at the least t for which r is at most [`AS_SMOOTH`] times its minimum: noise makes a
//! border ragged, gaps in it make it leap. Sharpness stands for the gradient of the source, so that ramps and
//! soft clouds are no edges, and smoothness for the uniformity of both sides, because clouds are not uniform.
//! [SW13] Y. Shen, Q. Wang, Sky region detection in a single image for autonomous ground robot
//! navigation, Int. J. Advanced Robotic Systems 10, 362 (2013): borders by column, the best threshold.

use ndarray::Array2;

/// Thresholds that are tried.
const N_THRESHOLDS: usize = 60;
/// The lowest and the highest of them, as parts of the pixels that are less sharp.
const QUANTILES: (f64, f64) = (0.2, 0.99);
/// How much rougher than the smoothest a border at fainter edges may be.
const AS_SMOOTH: f64 = 1.6;
/// Largest step between columns that counts, as part of the height.
const MOST_STEP: f64 = 0.05;
/// Rows from the top or the bottom that are no border, as part of the height.
const AT_THE_END: f64 = 0.02;
/// Columns in the width of the picture for one of the reach of a median.
const COLUMNS_PER_REACH: usize = 80;

/// How sharply a picture in Oklab changes about each pixel: the root mean square over three by three pixels of
/// the difference from the mean of theirs. Ramps have none, soft clouds little.
pub(crate) fn sharpness(lab: &Array2<[f32; 3]>) -> Array2<f32> {
    let means = mean_of_nine(lab);
    let squares = Array2::from_shape_fn(lab.dim(), |at| {
        let apart = lab[at].iter().zip(means[at]);
        [apart.map(|(a, b)| (a - b) * (a - b)).sum::<f32>()]
    });
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

/// The first row of each column that is no sky, by how sharp the picture is; below a pixel that is sky, by row and
/// column, where any border lies there.
pub(crate) fn sky_border(sharpness: &Array2<f32>, known: Option<(usize, usize)>) -> Vec<usize> {
    let mut sorted: Vec<f32> = sharpness.iter().copied().collect();
    sorted.sort_by(f32::total_cmp);
    let at = |part: f64| f64::from(sorted[(part * (sorted.len() - 1) as f64) as usize]).max(1e-6);
    let (low, high) = (at(QUANTILES.0), at(QUANTILES.1));
    let borders = (0..N_THRESHOLDS).map(|step| {
        let part = step as f64 / (N_THRESHOLDS - 1) as f64;
        let threshold = (low * (high / low).powf(part)) as f32;
        let rows = sharpness.columns().into_iter().map(|column| {
            let first = column.iter().position(|value| *value > threshold);
            first.unwrap_or(column.len())
        });
        let border: Vec<usize> = rows.collect();
        (roughness(&border, sharpness.nrows()), border)
    });
    let mut borders: Vec<_> = borders.collect();
    if let Some((y, x)) = known {
        let is_below = |it: &(f64, Vec<usize>)| it.1[x] > y;
        if borders.iter().any(is_below) {
            borders.retain(is_below);
        }
    }
    let least = borders.iter().map(|it| it.0).fold(f64::INFINITY, f64::min);
    let first = borders.into_iter().find(|it| it.0 <= AS_SMOOTH * least);
    steadied(&first.map(|it| it.1).unwrap_or_default())
}

fn roughness(border: &[usize], height: usize) -> f64 {
    let most = MOST_STEP * height as f64;
    let ends = [AT_THE_END, 1.0 - AT_THE_END].map(|share| share * height as f64);
    let steps = border.windows(2).map(|pair| {
        let [row, next] = [pair[0] as f64, pair[1] as f64];
        if row < ends[0] || row > ends[1] {
            return most;
        }
        (next - row).abs().min(most)
    });
    steps.sum()
}

/// Where single columns go on below the median of their neighbors, that.
fn steadied(border: &[usize]) -> Vec<usize> {
    let reach = (border.len() / COLUMNS_PER_REACH).max(1);
    let median = |x: usize| {
        let mut near = border[x.saturating_sub(reach)..(x + reach + 1).min(border.len())].to_vec();
        near.sort_unstable();
        near[near.len() / 2].min(border[x])
    };
    (0..border.len()).map(median).collect()
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
        let border = sky_border(&sharpness(&lab), None);
        for (found, row) in border.iter().zip(&line) {
            // Sharpness reaches two pixels out, and the median over the steps of the line.
            assert!((row - 5..=row + 2).contains(found), "{found} {row}");
        }
        let ramp = Array2::from_shape_fn((40, 30), |(y, _)| [0.01 * y as f32, 0.0, 0.0]);
        let sharp = sharpness(&ramp);
        let inside = sharp.slice(ndarray::s![2..38, ..]);
        assert!(inside.iter().all(|value| *value < 1e-6));
    }
}
