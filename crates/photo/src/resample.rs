//! Pictures of another resolution.
//!
//! v(x) = sum of the four nearest pixels times (1 − |dx|)(1 − |dy|), pixel centers at +0.5; beyond
//! the outer centers the outer pixels go on. Exact for linear ramps inside.

use ndarray::Array2;
use ndarray::parallel::prelude::*;

use crate::error::Error;

/// The four neighbours of a point and their weights.
#[derive(Clone, Copy)]
pub(crate) struct Neighbors<T> {
    pub(crate) values: [T; 4],
    pub(crate) weights: [f32; 4],
}

/// A picture of another size, each pixel mixed from its four neighbours.
pub(crate) fn resample<T: Copy + Send + Sync>(
    source: &Array2<T>,
    (height, width): (usize, usize),
    mix: impl Fn(Neighbors<T>) -> T + Sync,
) -> Result<Array2<T>, Error> {
    let (source_height, source_width) = source.dim();
    let columns = taps(source_width, width);
    let rows = taps(source_height, height);
    let pixels: Vec<T> = rows
        .par_iter()
        .flat_map_iter(|row| {
            let mix = &mix;
            columns.iter().map(move |column| {
                let at = |y: usize, x: usize| source[[row.index[y], column.index[x]]];
                let weight = |y: usize, x: usize| row.weight[y] * column.weight[x];
                mix(Neighbors {
                    values: [at(0, 0), at(0, 1), at(1, 0), at(1, 1)],
                    weights: [weight(0, 0), weight(0, 1), weight(1, 0), weight(1, 1)],
                })
            })
        })
        .collect();
    Array2::from_shape_vec((height, width), pixels)
        .map_err(|error| Error::Damaged(error.to_string()))
}

struct Tap {
    index: [usize; 2],
    weight: [f32; 2],
}

fn taps(n_source: usize, n: usize) -> Vec<Tap> {
    let scale = n_source as f64 / n as f64;
    let last = n_source.saturating_sub(1);
    (0..n)
        .map(|index| {
            let center = ((index as f64 + 0.5) * scale - 0.5).clamp(0.0, last as f64);
            let low = (center.floor() as usize).min(last);
            // f32: weights of values that are f32 themselves.
            let fraction = (center - low as f64) as f32;
            Tap {
                index: [low, (low + 1).min(last)],
                weight: [1.0 - fraction, fraction],
            }
        })
        .collect()
}

/// Mixes numbers.
pub(crate) fn mix_numbers(near: Neighbors<f32>) -> f32 {
    let terms = near.values.iter().zip(near.weights);
    terms.map(|(value, weight)| weight * value).sum()
}

/// Mixes colors.
pub(crate) fn mix_colors(near: Neighbors<[f32; 3]>) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (value, weight) in near.values.iter().zip(near.weights) {
        for (sum, channel) in sum.iter_mut().zip(value) {
            *sum += weight * channel;
        }
    }
    sum
}

/// Takes the nearest of the four.
pub(crate) fn nearest<T: Copy>(near: Neighbors<T>) -> T {
    let mut best = 0;
    for index in 1..4 {
        if near.weights[index] > near.weights[best] {
            best = index;
        }
    }
    near.values[best]
}

/// Have two sizes the same shape, up to the rounding of a pixel?
pub(crate) fn same_shape((h1, w1): (usize, usize), (h2, w2): (usize, usize)) -> bool {
    let (ratio, other) = (w1 as f64 / h1 as f64, w2 as f64 / h2 as f64);
    let pixel = 1.0 / h1.min(h2).min(w1).min(w2) as f64;
    (ratio / other - 1.0).abs() <= pixel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_a_ramp_and_its_size_itself() {
        let ramp =
            Array2::from_shape_fn((5, 7), |(y, x)| (x as f32 + 0.5) + 10.0 * (y as f32 + 0.5));
        let large = resample(&ramp, (15, 21), mix_numbers).unwrap();
        for ((y, x), value) in large.indexed_iter() {
            if (1..14).contains(&y) && (1..20).contains(&x) {
                let expected = (x as f32 + 0.5) / 3.0 + 10.0 * (y as f32 + 0.5) / 3.0;
                assert!((value - expected).abs() < 1e-4, "{y} {x}");
            }
        }
        assert_eq!(resample(&ramp, (5, 7), mix_numbers).unwrap(), ramp);
        assert_eq!(resample(&ramp, (5, 7), nearest).unwrap(), ramp);
    }

    #[test]
    fn shapes_agree_up_to_a_pixel() {
        assert!(same_shape((427, 640), (4000, 5995)));
        assert!(same_shape((4000, 6000), (1000, 1500)));
        assert!(!same_shape((4000, 6000), (1000, 1600)));
    }
}
