//! The square of Airy's integral averaged over drop sizes, in advance.
//!
//! F(z) = ⟨t^q f²(z t^(2/3))⟩,   P(z) = ∫_−∞^z F dz' = ⟨t^q (z f² + t^(−2/3) f'²/c)⟩,   c = π²/12
//! F'(z) = ⟨2 t^(q+2/3) f f'⟩,   F''(z) = ⟨2 t^(q+4/3) (f'² − c z t^(2/3) f²)⟩,   f and f' at z t^(2/3)
//! `t` radius over effective radius, `q` the power of the radius in front of f² (1/3 absolute, −2/3 as
//! published), ⟨⟩ the mean over the cross-section of the gamma law: weight t^(1/v_e) e^(−t/v_e) d ln t.
//!
//! Airy's theory depends on radius and wavelength through z alone, so one function of z serves every
//! effective radius, wavelength and angle of a table: the size average costs nothing per value and is
//! not sampled in any radius. P gives exact means over steps of the angle, however many fringes they
//! hold. P follows from f'' = −c z f by differentiation.
//!
//! Where the sizes have blurred the fringes to below 1e-5 only their mean is left (DLMF 9.8.20):
//! F = (V²/(2π sqrt(A z))) (⟨t^(q−1/3)⟩ − (5/32) ⟨t^(q−7/3)⟩ (A z)^(−3)),  A = c^(1/3), f = V Ai(−A z)
//! [HT74] J. E. Hansen and L. D. Travis, Space Sci. Rev. 16, 527-610 (1974), eq. 2.56. [DLMF]
//! dlmf.nist.gov.

use std::f64::consts::TAU;

use niji_airy::AiryTable;
use niji_airy::airy_integral_with_derivative;
use niji_airy::fringe_coordinate;
use niji_airy::from_fringe_coordinate;
use niji_airy::quintic_hermite;
use rayon::prelude::*;

/// c = π²/12.
const C: f64 = 0.822_467_033_424_113_2;
/// V²/(2π), half the square of the amplitude of f times sqrt(A z).
const MEAN: f64 = 0.55884639773991457;
/// A = (π²/12)^(1/3).
const ARGUMENT: f64 = 0.936_927_888_800_636_4;
/// (4/3) c^(1/2), the phase of f² over (z t^(2/3))^(3/2).
const PHASE: f64 = 1.209_199_576_156_145_2;

/// Step between nodes in the coordinate of [`fringe_coordinate`]: 0.18 rad of the phase of f².
const STEP: f64 = 0.1;
/// Lowest z for a single size: f² is below 1e-60 there.
const LOWEST_Z: f64 = -24.0;
/// Lowest z for any law, and the value of F that a broad law may have left there.
const LOWEST_OF_ALL_Z: f64 = -150.0;
const LEFT_BELOW: f64 = 1e-10;
/// Amplitude of the fringes, over their mean, from which on only the mean is kept.
const DAMPED: f64 = 1e-5;
/// The expansion of the mean is good to 1e-5 from this z on.
const MEAN_FROM_Z: f64 = 30.0;
/// ln of the density below its peak where the law is cut, towards small and large drops: small drops
/// are all that reaches far into the dark.
const CUTS: (f64, f64) = (40.0, 20.0);
/// Effective variance from which on the sizes are sampled evenly in x, t = ln(1 + e^x): evenly in ln t
/// for small drops and, as the fringes are, in t for large ones.
const BROAD: f64 = 0.02;
/// Sizes for each sqrt(v_e), and for each period of the fringes: the trapezoidal rule converges faster
/// than any power beyond two a period.
const SIZES_PER_WIDTH: f64 = 5.0;
const SIZES_PER_PERIOD: f64 = 2.5;
/// Levels of the size quadrature, each twice as fine as the one before.
const N_LEVELS: usize = 14;
/// Below this effective variance a law is a single size: its fringes blur by less than 1e-6.
const SINGLE_SIZE: f64 = 1e-14;

/// F and P at nodes that are even in phase.
#[derive(Clone, Debug)]
pub(crate) struct MeanSquare {
    /// z and there P, F, F', F''.
    nodes: Vec<(f64, [f64; 4])>,
    low: f64,
    /// ⟨t^(q−1/3)⟩ and (5/32) ⟨t^(q−7/3)⟩ A^(−3).
    tail: [f64; 2],
}

/// What the average is taken of, and over which law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Averaging<'a> {
    /// The power q.
    pub(crate) exponent: f64,
    pub(crate) effective_variance: f64,
    /// No z above it will be asked for.
    pub(crate) highest_z: f64,
    pub(crate) airy_table: Option<&'a AiryTable>,
}

impl MeanSquare {
    pub(crate) fn compute(averaging: Averaging) -> Self {
        let variance = averaging.effective_variance;
        let high = fringe_coordinate(
            averaging
                .highest_z
                .min(damped_from_z(averaging.exponent, variance))
                .max(1.0),
        );
        let low = fringe_coordinate(lowest_z(averaging.exponent, variance));
        let n_nodes = ((high - low) / STEP).ceil() as usize + 2;
        let law = GammaSample::new(averaging.exponent, variance, from_fringe_coordinate(high));
        // A sum over sizes evens out the error of a table, 2e-8; a single size has none to give away.
        let computed =
            (averaging.airy_table.is_none() && variance >= SINGLE_SIZE).then(AiryTable::compute);
        let integral = |z: f64| {
            averaging.airy_table.or(computed.as_ref()).map_or_else(
                || airy_integral_with_derivative(z),
                |table| table.value_with_derivative(z),
            )
        };
        let nodes = (0..n_nodes)
            .into_par_iter()
            .map(|index| {
                let z = from_fringe_coordinate(low + STEP * index as f64);
                (z, law.mean(z, integral))
            })
            .collect();
        let tail = [
            law.moment(-1.0 / 3.0),
            5.0 / 32.0 * law.moment(-7.0 / 3.0) / ARGUMENT.powi(3),
        ];
        Self { nodes, low, tail }
    }

    /// F(z).
    pub(crate) fn value(&self, z: f64) -> f64 {
        let last = self.nodes[self.nodes.len() - 1].0;
        if z >= last {
            let [first, second] = self.tail;
            return MEAN / (ARGUMENT * z).sqrt() * (first - second * z.powi(-3));
        }
        // Not the slope of P: that would magnify the rounding of P.
        self.look_up(z, |[_, value, slope, curvature]| [value, slope, curvature])
    }

    /// P(z).
    pub(crate) fn primitive(&self, z: f64) -> f64 {
        let (last, [p, ..]) = self.nodes[self.nodes.len() - 1];
        if z < last {
            return self.look_up(z, |[value, slope, curvature, _]| [value, slope, curvature]);
        }
        let [first, second] = self.tail;
        let rise = |z: f64| 2.0 * first * z.sqrt() + second * 0.4 * z.powf(-2.5);
        p + MEAN / ARGUMENT.sqrt() * (rise(z) - rise(last))
    }

    /// The mean of F between two places.
    pub(crate) fn mean(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
        let width = to.0 - from.0;
        if width.abs() < 1e-6 {
            return self.value(from.0);
        }
        (to.1 - from.1) / width
    }

    fn look_up(&self, z: f64, quantity: impl Fn([f64; 4]) -> [f64; 3]) -> f64 {
        let position = (fringe_coordinate(z) - self.low) / STEP;
        if position.is_nan() || position < 0.0 {
            return 0.0;
        }
        let index = (position as usize).min(self.nodes.len() - 2);
        let end = |(z, values): (f64, [f64; 4])| (z, quantity(values));
        quintic_hermite(end(self.nodes[index]), end(self.nodes[index + 1]), z).0
    }
}

/// The gamma law as a sum over sizes, at several finenesses.
struct GammaSample {
    levels: Vec<Vec<Size>>,
    /// Largest phase for each unit of z^(3/2) between two sizes of the coarsest level.
    coarsest_phase: f64,
}

/// One size of the sum.
struct Size {
    /// t^(2/3).
    scale: f64,
    /// Weight times t^q; the weights sum to 1.
    weight: f64,
}

impl GammaSample {
    /// Levels that resolve the fringes up to `highest_z`.
    fn new(exponent: f64, variance: f64, highest_z: f64) -> Self {
        if variance < SINGLE_SIZE {
            let size = Size {
                scale: 1.0,
                weight: 1.0,
            };
            return Self {
                levels: vec![vec![size]],
                coarsest_phase: 0.0,
            };
        }
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

    /// P, F, F' and F'' at `z`; ascending sizes, so that the sum has one order.
    fn mean(&self, z: f64, integral: impl Fn(f64) -> (f64, f64)) -> [f64; 4] {
        let needed = self.coarsest_phase * z.max(0.0).powf(1.5) * SIZES_PER_PERIOD / TAU;
        let level = needed.log2().ceil().max(0.0) as usize;
        let mut sum = [0.0; 4];
        for size in &self.levels[level.min(self.levels.len() - 1)] {
            let (f, slope) = integral(z * size.scale);
            sum[0] += size.weight * (z * f * f + slope * slope / (C * size.scale));
            sum[1] += size.weight * f * f;
            sum[2] += size.weight * 2.0 * size.scale * f * slope;
            sum[3] += size.weight
                * 2.0
                * size.scale
                * size.scale
                * (slope * slope - C * z * size.scale * f * f);
        }
        sum
    }

    /// ⟨t^(q + power)⟩.
    fn moment(&self, power: f64) -> f64 {
        let term = |size: &Size| size.weight * size.scale.powf(1.5 * power);
        self.levels[0].iter().map(term).sum()
    }
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

/// Below it nothing is left of the bow: a share t^(1/v_e + q) of the drops, those with
/// t < 1/(2 PHASE |z|^(3/2)), reaches that far into the dark.
fn lowest_z(exponent: f64, variance: f64) -> f64 {
    if variance < SINGLE_SIZE {
        return LOWEST_Z;
    }
    let radius = LEFT_BELOW.powf(1.0 / (1.0 / variance + exponent));
    let z = -(1.0 / (2.0 * PHASE * radius)).powf(2.0 / 3.0);
    z.clamp(LOWEST_OF_ALL_Z, LOWEST_Z)
}

/// The fringes of phase φ t have the amplitude (1 + φ² v_e²)^(−k/2), k = 1/v_e + q − 1/3, over their
/// mean: where it is DAMPED.
fn damped_from_z(exponent: f64, variance: f64) -> f64 {
    if variance < SINGLE_SIZE {
        return f64::INFINITY;
    }
    let power = 1.0 / variance + exponent - 1.0 / 3.0;
    let squared = (-2.0 / power * DAMPED.ln()).exp_m1() / (variance * variance);
    (squared.sqrt() / PHASE).powf(2.0 / 3.0).max(MEAN_FROM_Z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use niji_airy::airy_integral;
    use niji_radiometry::Micrometers;
    use niji_sizes::gamma_area_quadrature;

    fn averaging(exponent: f64, effective_variance: f64) -> Averaging<'static> {
        Averaging {
            exponent,
            effective_variance,
            highest_z: 120.0,
            airy_table: None,
        }
    }

    /// The mean straight from the quadrature of the size laws, with many nodes.
    fn literal(exponent: f64, variance: f64, z: f64) -> f64 {
        let nodes = gamma_area_quadrature(Micrometers(1.0), variance, 6000).unwrap();
        let square = |t: f64| airy_integral(z * t.powf(2.0 / 3.0)).powi(2);
        nodes
            .into_iter()
            .map(|(t, weight)| weight * t.powf(exponent) * square(t))
            .sum()
    }

    #[test]
    fn constants_belong_to_each_other() {
        assert!((C - PI * PI / 12.0).abs() < 1e-15);
        assert!((ARGUMENT - C.cbrt()).abs() < 1e-15);
        assert!((PHASE - 4.0 / 3.0 * C.sqrt()).abs() < 1e-15);
        assert!((MEAN - (2.0 * PI * PI / 3.0).powf(2.0 / 3.0) / TAU).abs() < 1e-15);
    }

    /// Error over the larger of the value and 1e-3; measured worst 6.4e-5 (the published
    /// power at v_e = 1/3).
    const MEAN_TOLERANCE: f64 = 1e-4;

    #[test]
    fn the_mean_is_that_of_the_literal_sum_over_sizes() {
        for variance in [0.0, 1e-8, 1e-4, 2e-3, 0.05, 1.0 / 3.0] {
            for exponent in [1.0 / 3.0, -2.0 / 3.0] {
                let mean = MeanSquare::compute(averaging(exponent, variance));
                for z in [-10.0, -3.0, -0.5, 0.0, 1.087, 2.4955, 7.3, 21.0, 33.0, 61.0] {
                    let expected = literal(exponent, variance, z);
                    let off = (mean.value(z) - expected).abs() / expected.max(1e-3);
                    assert!(
                        off < MEAN_TOLERANCE,
                        "v_e = {variance}, q = {exponent}, z = {z}: {} against {expected}",
                        mean.value(z)
                    );
                }
            }
        }
    }

    #[test]
    fn the_primitive_rises_by_the_integral_of_the_mean() {
        for variance in [0.0, 2e-3, 1.0 / 3.0] {
            let mean = MeanSquare::compute(averaging(1.0 / 3.0, variance));
            for (from, to) in [(-8.0, -1.0), (-1.0, 4.0), (4.0, 29.0), (28.0, 44.0)] {
                let n = 40_000;
                let step = (to - from) / f64::from(n);
                let integral: f64 = (0..n)
                    .map(|i| step * mean.value(from + step * (f64::from(i) + 0.5)))
                    .sum();
                let rise = mean.primitive(to) - mean.primitive(from);
                assert!(
                    (rise / integral - 1.0).abs() < 1e-5,
                    "v_e = {variance}, {from} to {to}: {rise} against {integral}"
                );
            }
        }
    }

    #[test]
    fn nothing_comes_from_far_in_the_dark_and_nothing_is_strange() {
        for variance in [0.0, 1e-12, 0.1, 0.49] {
            let mean = MeanSquare::compute(averaging(1.0 / 3.0, variance));
            assert_eq!(mean.value(-1e4), 0.0);
            assert_eq!(mean.primitive(-1e4), 0.0);
            assert_eq!(mean.value(f64::NAN), 0.0);
            for z in [-30.0, -1.0, 0.0, 100.0, 1e4] {
                assert!(mean.value(z).is_finite() && mean.value(z) > -1e-9);
            }
        }
    }
}
