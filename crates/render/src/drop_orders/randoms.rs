//! Numbers in 0..1 for paths: low-discrepancy where a path starts, pseudo-random as it goes on.
//!
//! x_d(k) = sum over set bits j of k of v_dj  (without carry),   u_d = (x_d xor shift_d)/2^32
//!
//! The points of Sobol's sequence fill the cube of six dimensions evenly however many there are; `v`
//! are its direction numbers, and a shift of each replicate makes its points independent of those of others.
//! Further numbers are hashes of replicate, path and position [SLF14]. Every direction takes the same paths, so
//! that what is left of the error varies as smoothly over the picture as the light itself.
//!
//! [SLF14] G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators",
//! OOPSLA 2014, 453-472.

use niji_geometry::SOBOL_DIRECTIONS;

/// Dimensions of the even points.
const N_EVEN: usize = 6;

/// 2^64 over the golden ratio, odd.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// The numbers of one path, in order.
#[derive(Clone, Debug)]
pub(crate) struct Randoms {
    replicate: u64,
    path: u64,
    state: u64,
    n_even: usize,
}

impl Randoms {
    /// The numbers of a path of a replicate.
    pub(crate) fn of(replicate: u64, path: u64) -> Self {
        Self {
            replicate,
            path,
            state: mixed(path.wrapping_mul(STEP) ^ mixed(replicate ^ 0x5851_f42d_4c95_7f2d)),
            n_even: 0,
        }
    }

    /// One of the first numbers, which fill their cube evenly over the paths; beyond six as
    /// [`Randoms::next`].
    pub(crate) fn next_even(&mut self) -> f64 {
        if self.n_even == N_EVEN {
            return self.next();
        }
        let dimension = self.n_even;
        self.n_even += 1;
        let axis = self.replicate * N_EVEN as u64 + dimension as u64;
        let shift = (mixed(axis + 1) >> 32) as u32;
        let mut value = shift;
        let mut bits = self.path & u64::from(u32::MAX);
        while bits != 0 {
            value ^= SOBOL_DIRECTIONS[dimension][bits.trailing_zeros() as usize];
            bits &= bits - 1;
        }
        // The middle of its interval.
        (f64::from(value) + 0.5) / 4_294_967_296.0
    }

    /// The next pseudo-random number.
    pub(crate) fn next(&mut self) -> f64 {
        self.state = self.state.wrapping_add(STEP);
        // The upper 53 bits are a double's.
        (mixed(self.state) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The finalizer of SplitMix64 (SLF14, figure 16).
fn mixed(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_points_hit_every_interval_of_each_dimension_once() {
        for dimension in 0..N_EVEN {
            let mut hit = [false; 256];
            for path in 256..512 {
                let mut randoms = Randoms::of(0, path);
                let numbers: [f64; N_EVEN] = std::array::from_fn(|_| randoms.next_even());
                hit[(256.0 * numbers[dimension]) as usize] = true;
            }
            assert!(hit.iter().all(|hit| *hit), "{dimension}");
        }
    }

    #[test]
    fn pairs_of_dimensions_fill_their_square() {
        for (a, b) in [(0, 1), (2, 3), (3, 4), (0, 5)] {
            let mut hit = [false; 64];
            for path in 0..256 {
                let mut randoms = Randoms::of(0, path);
                let numbers: [f64; N_EVEN] = std::array::from_fn(|_| randoms.next_even());
                hit[8 * (8.0 * numbers[a]) as usize + (8.0 * numbers[b]) as usize] = true;
            }
            assert!(hit.iter().all(|hit| *hit), "{a} {b}");
        }
    }

    #[test]
    fn even_points_integrate_a_product_better_than_random_ones() {
        let error = |even: bool| {
            let n_paths = 4096;
            let sum: f64 = (0..n_paths)
                .map(|path| {
                    let mut randoms = Randoms::of(0, path);
                    (0..N_EVEN)
                        .map(|_| {
                            2.0 * if even {
                                randoms.next_even()
                            } else {
                                randoms.next()
                            }
                        })
                        .product::<f64>()
                })
                .sum();
            (sum / n_paths as f64 - 1.0).abs()
        };
        // Measured 1e-3; the deviation of random points is 3e-2.
        assert!(error(true) < 4e-3, "{}", error(true));
        assert!(error(false) < 0.1);
    }

    #[test]
    fn random_numbers_have_the_moments_of_even_ones_and_do_not_repeat() {
        let mut randoms = Randoms::of(0, 7);
        let numbers: Vec<f64> = (0..100_000).map(|_| randoms.next()).collect();
        let mean = |power: i32| numbers.iter().map(|u| u.powi(power)).sum::<f64>() / 1e5;
        // Deviations of the mean 9e-4.
        assert!((mean(1) - 0.5).abs() < 4e-3 && (mean(2) - 1.0 / 3.0).abs() < 4e-3);
        assert_ne!(Randoms::of(0, 1).next(), Randoms::of(0, 2).next());
        assert_ne!(Randoms::of(0, 1).next(), Randoms::of(1, 1).next());
    }
}
