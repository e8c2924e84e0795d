//! Sums and products of spectra.

use glam::Vec4;

/// Multiply spectra, wavelength by wavelength.
pub(crate) fn multiply(values: &mut [f32], factors: &[f32]) {
    for (value, factor) in values.iter_mut().zip(factors) {
        *value *= factor;
    }
}

/// Add the product of two spectra.
pub(crate) fn add_product(sums: &mut [f32], a: &[f32], b: &[f32]) {
    for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
        *sum += a * b;
    }
}

/// Sum of a spectrum, in as many parts as fill a vector.
pub(crate) fn sum(values: &[f32]) -> f32 {
    let (vectors, rest) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for vector in vectors {
        for (sum, value) in sums.iter_mut().zip(vector) {
            *sum += value;
        }
    }
    sums.iter().chain(rest).sum()
}

/// Weighted sum of a spectrum in three channels; the fourth lane is idle.
pub(crate) fn weighted_sum(spectrum: &[f32], weights: &[Vec4]) -> Vec4 {
    // Four sums at once: one alone waits for each addition.
    let (fours, rest) = spectrum.as_chunks::<4>();
    let (weights_of_fours, weights_of_rest) = weights.as_chunks::<4>();
    let mut sums = [Vec4::ZERO; 4];
    for (values, weights) in fours.iter().zip(weights_of_fours) {
        for index in 0..4 {
            sums[index] += values[index] * weights[index];
        }
    }
    let last = rest.iter().zip(weights_of_rest);
    let last = last.fold(Vec4::ZERO, |sum, (value, weight)| sum + *value * *weight);
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + last
}
