//! The gamma law as a sum over sizes that resolves the fringes of the bow, at several finenesses.
//!
//! ⟨g⟩ = Σ w g(t),   w = t^(1/v_e) e^(−t/v_e) d ln t   normalised
//! `t` radius over effective radius. A fringe has the phase φ t with φ = (4/3) c^(1/2) z^(3/2), so that
//! the number of sizes that a sum needs grows with z: each level is twice as fine as the one before. The
//! trapezoidal rule in the variable chosen converges faster than any power beyond two sizes a period.
//! [HT74] J. E. Hansen and L. D. Travis, Space Sci. Rev. 16, 527-610 (1974), eq. 2.56.

use std::f64::consts::TAU;

/// c = π²/12.
pub(crate) const C: f64 = 0.822_467_033_424_113_2;
/// (4/3) c^(1/2), the phase of f² over (z t^(2/3))^(3/2).
pub(crate) const PHASE: f64 = 1.209_199_576_156_145_2;
/// Below this effective variance a law is a single size: its fringes blur by less than 1e-6.
pub(crate) const SINGLE_SIZE: f64 = 1e-14;

/// ln of the density below its peak where the law is cut, towards small and large drops: small drops
/// are all that reaches far into the dark.
const CUTS: (f64, f64) = (40.0, 20.0);
/// Effective variance from which on the sizes are sampled evenly in x, t = ln(1 + e^x): evenly in ln t
/// for small drops and, as the fringes are, in t for large ones.
const BROAD: f64 = 0.02;
/// Sizes for each sqrt(v_e), and for each period of the fringes.
const SIZES_PER_WIDTH: f64 = 5.0;
const SIZES_PER_PERIOD: f64 = 2.5;
/// Levels of the size quadrature.
const N_LEVELS: usize = 14;

/// The gamma law as a sum over sizes, at several finenesses.
#[derive(Clone, Debug)]
pub(crate) struct GammaSample {
    levels: Vec<Vec<Size>>,
    /// Largest phase for each unit of z^(3/2) between two sizes of the coarsest level.
    coarsest_phase: f64,
}

/// One size of the sum.
#[derive(Clone, Copy, Debug)]
struct Size {
    /// t^(2/3).
    scale: f64,
    /// Weight times t^q; the weights sum to 1.
    weight: f64,
}

impl GammaSample {
    /// Levels that resolve the fringes up to the highest z.
    pub(crate) fn new(exponent: f64, variance: f64, highest_z: f64) -> Self {
        let (small, large) = (cut(variance, -CUTS.0), cut(variance, CUTS.1));
        let is_broad = variance > BROAD;
        // Range of x, and the largest dt/dx in it.
        let (low, high, steepest) = if is_broad {
            (small, large.exp(), 1.0)
        } else {
            (small, large, large.exp())
        };
        let n = ((high - low) * SIZES_PER_WIDTH / variance.sqrt()).ceil() as usize;
        let coarsest_phase = PHASE * steepest * (high - low) / n as f64;
        let needed = coarsest_phase * highest_z.powf(1.5) * SIZES_PER_PERIOD / TAU;
        let n_levels = (needed.log2().ceil().max(0.0) as usize + 1).min(N_LEVELS);
        let levels = (0..n_levels)
            .map(|level| {
                let n = n << level;
                let step = (high - low) / n as f64;
                let place = |index| low + step * index as f64;
                // ln t and ln of the weight of each step.
                let sizes: Vec<(f64, f64)> = (0..=n)
                    .map(|index| {
                        if is_broad {
                            broad_size(place(index), variance)
                        } else {
                            narrow_size(place(index), variance)
                        }
                    })
                    .collect();
                let total: f64 = sizes.iter().map(|(_, ln_weight)| ln_weight.exp()).sum();
                let size = |&(ln_t, ln_weight): &(f64, f64)| Size {
                    scale: (2.0 / 3.0 * ln_t).exp(),
                    weight: (ln_weight + exponent * ln_t).exp() / total,
                };
                sizes.iter().map(size).collect()
            })
            .collect();
        Self {
            levels,
            coarsest_phase,
        }
    }

    /// P, F, F', F'' and Q, G, G', G'' of [`crate::mean_square`] at `z`; ascending sizes, so that the
    /// sums have one order.
    pub(crate) fn mean(&self, z: f64, integral: impl Fn(f64) -> (f64, f64)) -> [[f64; 4]; 2] {
        let needed = self.coarsest_phase * z.max(0.0).powf(1.5) * SIZES_PER_PERIOD / TAU;
        let level = needed.log2().ceil().max(0.0) as usize;
        let mut sums = [[0.0; 4]; 2];
        for size in &self.levels[level.min(self.levels.len() - 1)] {
            let of_size = of_size(z, size.scale, &integral);
            for (sum, term) in sums.iter_mut().flatten().zip(of_size.as_flattened()) {
                *sum += size.weight * term;
            }
        }
        sums
    }

    /// ⟨t^(q + power)⟩.
    pub(crate) fn moment(&self, power: f64) -> f64 {
        let term = |size: &Size| size.weight * size.scale.powf(1.5 * power);
        self.levels[0].iter().map(term).sum()
    }
}

/// What [`GammaSample::mean`] gives for a law of one size.
pub(crate) fn single_size(z: f64, integral: impl Fn(f64) -> (f64, f64)) -> [[f64; 4]; 2] {
    of_size(z, 1.0, &integral)
}

/// The terms of a size, its t^(2/3) being `scale`.
#[inline]
fn of_size(z: f64, scale: f64, integral: &impl Fn(f64) -> (f64, f64)) -> [[f64; 4]; 2] {
    let u = z * scale;
    let (f, slope) = integral(u);
    let (ff, fs, ss) = (f * f, f * slope, slope * slope);
    [
        [
            z * ff + ss / (C * scale),
            ff,
            2.0 * scale * fs,
            2.0 * scale * scale * (ss - C * u * ff),
        ],
        [
            (u * ss + C * u * u * ff + 2.0 * fs) / (3.0 * scale * scale),
            ss / scale,
            -2.0 * C * u * fs,
            -2.0 * C * scale * (fs + u * ss - C * u * u * ff),
        ],
    ]
}

/// ln t and ln weight of a step of x = ln t, exact for the narrowest laws:
/// t^(1/v_e) e^(−t/v_e) over its peak.
fn narrow_size(x: f64, variance: f64) -> (f64, f64) {
    (x, (x - x.exp_m1()) / variance)
}

/// The same for a step of x with t = ln(1 + e^x), dt/dx = 1/(1 + e^−x).
fn broad_size(x: f64, variance: f64) -> (f64, f64) {
    let t = if x > 0.0 {
        x + (-x).exp().ln_1p()
    } else {
        x.exp().ln_1p()
    };
    let ln_t = t.ln();
    let ln_weight = (ln_t - (t - 1.0)) / variance - ln_t - (-x).exp().ln_1p();
    (ln_t, ln_weight)
}

/// ln t where the density has fallen by e^−|fall|, below the peak for a negative `fall` and above it
/// for a positive one: the solution of expm1(u) − u = |fall| v_e, by Newton's rule from outside.
fn cut(variance: f64, fall: f64) -> f64 {
    let depth = fall.abs() * variance;
    let mut u = if fall < 0.0 {
        -depth - (2.0 * depth).sqrt()
    } else {
        (2.0 * depth).sqrt().min((1.0 + 2.0 * depth).ln() + 1.0)
    };
    for _ in 0..30 {
        u -= (u.exp_m1() - u - depth) / u.exp_m1();
    }
    u
}
