//! Pearson's test, for the tests of sampled directions against their densities.
//!
//! chi² = sum (n_i - N p_i)²/(N p_i), of mean k - 1 and variance 2(k - 1) over k bins.

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
        let freedom: f64 = n_bins - 1.0;
        let deviations = (chi2 - freedom) / (2.0 * freedom).sqrt();
        assert!(
            deviations < LIMIT,
            "chi² = {chi2} for {freedom} degrees of freedom"
        );
    }
}

/// Numbers in 0..1 without a pattern: SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014).
pub(crate) fn pseudo_random<const N: usize>(index: u64) -> [f64; N] {
    std::array::from_fn(|dimension| {
        let mut z = (index * N as u64 + dimension as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 9_007_199_254_740_992.0
    })
}
