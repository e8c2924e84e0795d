//! Pearson's test, for the tests of sampled directions against their densities.
//!
//! chi² = sum (n_i - N p_i)²/(N p_i), of mean k - 1 and variance 2(k - 1) over k bins; with probabilities
//! that are estimates themselves, the variance of N p_i is added below.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use glam::DVec3;

use crate::sampler::Stream;

/// Counts by bin.
pub(crate) struct Chi2 {
    counts: Vec<f64>,
}

/// By how many standard deviations chi² may exceed its mean: p = 3e-5 for many bins.
const LIMIT: f64 = 4.0;
/// Expected counts below this are put together, as the test wants them.
const LEAST_EXPECTED: f64 = 10.0;

impl Chi2 {
    /// No counts yet.
    pub(crate) fn new(n_bins: usize) -> Self {
        let counts = vec![0.0; n_bins];
        Self { counts }
    }

    /// Counts one.
    pub(crate) fn count(&mut self, bin: usize) {
        self.counts[bin] += 1.0;
    }

    /// Fails if the counts do not come from `probabilities`; what they lack to 1 is not counted.
    pub(crate) fn assert_fits(&self, probabilities: &[f64]) {
        let n_all: f64 = self.counts.iter().sum();
        self.assert_fits_of(probabilities, n_all / probabilities.iter().sum::<f64>());
    }

    /// The same for probabilities that are estimates, given with their variances.
    pub(crate) fn assert_fits_estimates(&self, estimates: &[[f64; 2]]) {
        let n_all: f64 = self.counts.iter().sum();
        let (mut chi2, mut freedom) = (0.0, 0.0);
        for (&found, [share, variance]) in self.counts.iter().zip(estimates) {
            let expected = n_all * share;
            if expected >= LEAST_EXPECTED {
                chi2 += (found - expected).powi(2) / (expected + n_all * n_all * variance);
                freedom += 1.0;
            }
        }
        assert_probable(chi2, freedom);
    }

    /// The same for `n_all` draws, some of which fell into no bin.
    pub(crate) fn assert_fits_of(&self, probabilities: &[f64], n_all: f64) {
        let (mut chi2, mut n_bins) = (0.0, 0.0);
        let (mut rare, mut rare_expected) = (0.0, 0.0);
        let mut add = |found: f64, expected: f64| {
            chi2 += (found - expected).powi(2) / expected;
            n_bins += 1.0;
        };
        for (&found, probability) in self.counts.iter().zip(probabilities) {
            let expected = n_all * probability;
            if expected < LEAST_EXPECTED {
                rare += found;
                rare_expected += expected;
            } else {
                add(found, expected);
            }
        }
        if rare_expected >= LEAST_EXPECTED {
            add(rare, rare_expected);
        } else {
            assert!(
                rare <= 5.0 * LEAST_EXPECTED,
                "{rare} draws where hardly any are expected"
            );
        }
        assert_probable(chi2, n_bins - 1.0);
    }
}

fn assert_probable(chi2: f64, freedom: f64) {
    let deviations = (chi2 - freedom) / (2.0 * freedom).sqrt();
    assert!(
        deviations < LIMIT,
        "chi² = {chi2} for {freedom} degrees of freedom"
    );
}

/// Rings of the sphere alike in height, and sectors of each.
const N_RINGS: usize = 16;
/// Steps of a quadrature over a ring or a sector.
const N_FINE: usize = 40;

/// The bin of a direction among 16 x 16 of the same solid angle.
pub(crate) fn sphere_bin(direction: DVec3) -> usize {
    let n = N_RINGS as f64;
    let ring = ((0.5 + 0.5 * direction.z) * n).min(n - 1.0) as usize;
    let turn = direction.y.atan2(direction.x) / TAU + 0.5;
    ring * N_RINGS + (turn * n).min(n - 1.0) as usize
}

/// Integrals of a density [1/sr] over these bins.
pub(crate) fn sphere_shares(density: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let estimates = sphere_estimates(|direction, _| density(direction));
    estimates.into_iter().map(|[share, _]| share).collect()
}

/// The same for a density of which two random estimates are known at every direction, numbered from 0,
/// with the variances of the integrals.
pub(crate) fn sphere_estimates(density: impl Fn(DVec3, u64) -> f64) -> Vec<[f64; 2]> {
    let n = N_RINGS * N_FINE;
    let solid_angle_sr = 4.0 * PI / (n * n) as f64;
    let mut estimates = vec![[0.0; 2]; N_RINGS * N_RINGS];
    for ring in 0..n {
        let z = 2.0 * (ring as f64 + 0.5) / n as f64 - 1.0;
        let level = (1.0 - z * z).sqrt();
        for sector in 0..n {
            let (sin, cos) = (TAU * ((sector as f64 + 0.5) / n as f64 - 0.5)).sin_cos();
            let direction = DVec3::new(level * cos, level * sin, z);
            let number = 2 * (ring * n + sector) as u64;
            let pair =
                [number, number + 1].map(|number| solid_angle_sr * density(direction, number));
            let [share, variance] = &mut estimates[ring / N_FINE * N_RINGS + sector / N_FINE];
            *share += 0.5 * (pair[0] + pair[1]);
            *variance += 0.25 * (pair[0] - pair[1]).powi(2);
        }
    }
    estimates
}

/// Numbers in 0..1 without a pattern.
pub(crate) fn pseudo_random<const N: usize>(index: u64) -> [f64; N] {
    let mut stream = Stream::new(index * N as u64);
    std::array::from_fn(|_| stream.next())
}
