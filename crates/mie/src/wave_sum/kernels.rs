//! The inner loop of the sums over waves, for the vectors that the processor has.
//!
//! A block of angles goes through the waves in strips: first q_n of the whole strip, which is the
//! same for every series, then one series after the other, odd waves into U and even ones into V.
//! So the recurrence is paid once for all orders of a Debye series, and few enough sums are live at
//! a time for 16 registers.
//!
//! One lane holds one pair of angles, so no sum crosses lanes and every processor with fused
//! multiply-add gives the same bits, whatever its vector length and the number of angles. Without
//! fused multiply-add the compiler vectorizes plain products; those differ in the last digits.

#![allow(
    clippy::inline_always,
    reason = "only what is inlined gets the processor's instructions"
)]

use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

use super::Factors;
use super::Parts;
use super::Step;

/// f64 lanes of the longest vectors; the number of pairs is padded to a multiple.
pub(super) const MAX_LANES: usize = 8;

/// Waves of a strip, an even number: the q_n of a block stay in the first-level cache.
const N_STRIP: usize = 64;

/// Lanes of a vector where the compiler vectorizes.
const PLAIN_LANES: usize = 4;

/// What is added in one pass: steps of consecutive n from an odd one, an even number of them, and
/// as many factors of each series.
#[derive(Clone, Copy)]
pub(super) struct Waves<'a> {
    pub(super) steps: &'a [Step],
    pub(super) series: &'a [Vec<Factors>],
}

/// How far the sums of all pairs are; all vectors have one length, a multiple of `MAX_LANES`.
pub(super) struct Progress {
    pub(super) w: Vec<f64>,
    /// q_n and d_n of the next wave.
    pub(super) q: Vec<f64>,
    pub(super) d: Vec<f64>,
    /// Of each series.
    pub(super) sums: Vec<Parts>,
}

/// Adds waves with the instructions of `arch`.
pub(super) fn add_waves(arch: Arch, waves: Waves, progress: &mut Progress) {
    let sum = WaveSum { waves, progress };
    if matches!(arch, Arch::Scalar) {
        // Each vector is two short ones.
        sum.add::<_, 2, 1>(PlainProducts);
    } else {
        arch.dispatch(sum);
    }
}

/// Arithmetic on vectors of f64.
trait Lanes: Copy {
    type Vector: Copy;

    fn splat(self, value: f64) -> Self::Vector;
    /// a b + c.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn vectors(values: &[f64]) -> &[Self::Vector];
    fn vectors_mut(values: &mut [f64]) -> &mut [Self::Vector];
}

/// Fused products in the vectors of a processor.
#[derive(Clone, Copy)]
struct Fused<S>(S);

impl<S: Simd> Lanes for Fused<S> {
    type Vector = S::f64s;

    #[inline(always)]
    fn splat(self, value: f64) -> S::f64s {
        self.0.splat_f64s(value)
    }

    #[inline(always)]
    fn mul_add(self, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
        self.0.mul_add_f64s(a, b, c)
    }

    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }

    #[inline(always)]
    fn vectors(values: &[f64]) -> &[S::f64s] {
        S::as_simd_f64s(values).0
    }

    #[inline(always)]
    fn vectors_mut(values: &mut [f64]) -> &mut [S::f64s] {
        S::as_mut_simd_f64s(values).0
    }
}

/// Products that are rounded before they are added, in loops that the compiler turns into vectors.
#[derive(Clone, Copy)]
struct PlainProducts;

impl Lanes for PlainProducts {
    type Vector = [f64; PLAIN_LANES];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        [value; PLAIN_LANES]
    }

    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|i| a[i] + b[i])
    }

    #[inline(always)]
    fn vectors(values: &[f64]) -> &[Self::Vector] {
        values.as_chunks().0
    }

    #[inline(always)]
    fn vectors_mut(values: &mut [f64]) -> &mut [Self::Vector] {
        values.as_chunks_mut().0
    }
}

/// The waves of one pass and where they go.
struct WaveSum<'a> {
    waves: Waves<'a>,
    progress: &'a mut Progress,
}

impl WithSimd for WaveSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Four vectors hide the latency of the recurrence; 4 or 2 of them with 4 sums each hide
        // that of a fused multiply-add and fit into the registers.
        if S::REGISTER_COUNT >= 32 {
            self.add::<_, 4, 4>(Fused(simd));
        } else {
            self.add::<_, 4, 2>(Fused(simd));
        }
    }
}

impl WaveSum<'_> {
    /// Blocks of `B` vectors through the recurrence, `H` of them at a time through the sums.
    #[inline(always)]
    fn add<L: Lanes, const B: usize, const H: usize>(self, lanes: L) {
        let Progress { w, q, d, sums } = self.progress;
        let mut all = Vectors::<L> {
            w: L::vectors(w),
            q: L::vectors_mut(q),
            d: L::vectors_mut(d),
            sums: sums
                .iter_mut()
                .map(|parts| parts.each_mut().map(|part| L::vectors_mut(part)))
                .collect(),
        };
        let n_vectors = all.w.len();
        let n_in_blocks = n_vectors / B * B;
        for first in (0..n_in_blocks).step_by(B) {
            all.add_to_block::<B, H>(lanes, self.waves, first);
        }
        for first in n_in_blocks..n_vectors {
            all.add_to_block::<1, 1>(lanes, self.waves, first);
        }
    }
}

/// [`Progress`] as vectors.
struct Vectors<'a, L: Lanes> {
    w: &'a [L::Vector],
    q: &'a mut [L::Vector],
    d: &'a mut [L::Vector],
    sums: Vec<[&'a mut [L::Vector]; 8]>,
}

impl<L: Lanes> Vectors<'_, L> {
    #[inline(always)]
    fn add_to_block<const B: usize, const H: usize>(
        &mut self,
        lanes: L,
        waves: Waves,
        first: usize,
    ) {
        let block =
            |all: &[L::Vector]| -> [L::Vector; B] { std::array::from_fn(|i| all[first + i]) };
        let mut block = Block::<L, B> {
            w: block(self.w),
            q: block(self.q),
            d: block(self.d),
        };
        let mut strip = [block.q; N_STRIP];
        for (strip_index, steps) in waves.steps.chunks(N_STRIP).enumerate() {
            let strip = &mut strip[..steps.len()];
            block.fill_strip(lanes, steps, strip);
            for (factors, sums) in waves.series.iter().zip(&mut self.sums) {
                let factors = &factors[strip_index * N_STRIP..][..steps.len()];
                let strip = SeriesStrip {
                    lanes,
                    factors,
                    q: strip,
                };
                let (u, v) = sums.split_at_mut(4);
                for h in (0..B).step_by(H) {
                    strip.add::<H, 0>(h, u, first + h);
                    strip.add::<H, 1>(h, v, first + h);
                }
            }
        }
        self.q[first..first + B].copy_from_slice(&block.q);
        self.d[first..first + B].copy_from_slice(&block.d);
    }
}

/// The recurrence of `B` vectors of pairs: their arguments, and q_n and d_n of the next wave.
struct Block<L: Lanes, const B: usize> {
    w: [L::Vector; B],
    q: [L::Vector; B],
    d: [L::Vector; B],
}

impl<L: Lanes, const B: usize> Block<L, B> {
    /// Keeps q_n before each step, and leaves q and d behind the last.
    #[inline(always)]
    fn fill_strip(&mut self, lanes: L, steps: &[Step], strip: &mut [[L::Vector; B]]) {
        let Self { w, q, d } = self;
        for ([minus_e, minus_alpha], strip) in steps.iter().zip(strip) {
            *strip = *q;
            let minus_e = lanes.splat(*minus_e);
            let minus_alpha = lanes.splat(*minus_alpha);
            for i in 0..B {
                let factor = lanes.mul_add(minus_alpha, w[i], minus_e);
                d[i] = lanes.mul_add(factor, q[i], d[i]);
                q[i] = lanes.add(q[i], d[i]);
            }
        }
    }
}

/// The waves of a strip in one series: its factors, and the q_n of a block.
#[derive(Clone, Copy)]
struct SeriesStrip<'a, L: Lanes, const B: usize> {
    lanes: L,
    factors: &'a [Factors],
    q: &'a [[L::Vector; B]],
}

impl<L: Lanes, const B: usize> SeriesStrip<'_, L, B> {
    /// Adds the waves of one parity, 0 for odd n and 1 for even, to `H` vectors of sums from `first`
    /// on, which belong to those of the block from `first_in_block` on.
    #[inline(always)]
    fn add<const H: usize, const PARITY: usize>(
        self,
        first_in_block: usize,
        parts: &mut [&mut [L::Vector]],
        first: usize,
    ) {
        let lanes = self.lanes;
        let mut sums = [[lanes.splat(0.0); H]; 4];
        for (sums, part) in sums.iter_mut().zip(parts.iter()) {
            sums.copy_from_slice(&part[first..first + H]);
        }
        let (factors, _) = self.factors.as_chunks::<2>();
        let (strip, _) = self.q.as_chunks::<2>();
        for (factors, q) in factors.iter().zip(strip) {
            let q: [L::Vector; H] = std::array::from_fn(|i| q[PARITY][first_in_block + i]);
            for (sums, factor) in sums.iter_mut().zip(factors[PARITY]) {
                let factor = lanes.splat(factor);
                for (sum, q) in sums.iter_mut().zip(q) {
                    *sum = lanes.mul_add(factor, q, *sum);
                }
            }
        }
        for (sums, part) in sums.iter().zip(parts.iter_mut()) {
            part[first..first + H].copy_from_slice(sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two converging series and arguments from pole to equator.
    fn example() -> (Vec<Step>, Vec<Vec<Factors>>, Vec<f64>) {
        let step = |n: usize| {
            let e = super::super::asymptotic_e(n.max(3));
            [-e, e - 2.0]
        };
        let factors = |phase: f64| {
            let factors = |n: usize| {
                let m = n as f64;
                [(m + phase).sin(), (1.3 * m).cos(), (0.7 * m).sin(), 1.0 / m]
            };
            (1..=200).map(factors).collect()
        };
        let w = (0..104).map(|i| f64::from(i) / 103.0);
        let series = vec![factors(0.0), factors(0.5)];
        ((1..=200).map(step).collect(), series, w.collect())
    }

    fn sums(add: impl Fn(Waves, &mut Progress)) -> Vec<Parts> {
        let (steps, series, w) = example();
        let ones = vec![1.0; w.len()];
        let zeros = std::array::from_fn(|_| vec![0.0; w.len()]);
        let mut progress = Progress {
            w,
            q: ones.clone(),
            d: ones,
            sums: vec![zeros; 2],
        };
        let waves = Waves {
            steps: &steps,
            series: &series,
        };
        add(waves, &mut progress);
        progress.sums
    }

    #[test]
    fn plain_products_agree_with_the_fused_ones() {
        let fused = sums(|waves, progress| add_waves(Arch::new(), waves, progress));
        let plain = sums(|waves, progress| add_waves(Arch::Scalar, waves, progress));
        let values = |sums: Vec<Parts>| sums.into_iter().flatten().flatten();
        for (fused, plain) in values(fused).zip(values(plain)) {
            // Worst found 7.9e-15.
            assert!(
                (fused - plain).abs() <= 1e-13 * (1.0 + plain.abs()),
                "{fused} {plain}"
            );
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn short_and_long_vectors_give_the_same_bits_as_one_lane() {
        let scalar =
            sums(|waves, progress| Simd::vectorize(pulp::Scalar, WaveSum { waves, progress }));
        if let Some(v3) = pulp::x86::V3::try_new() {
            assert_eq!(
                sums(|waves, progress| Simd::vectorize(v3, WaveSum { waves, progress })),
                scalar
            );
        }
        if let Some(v4) = pulp::x86::V4::try_new() {
            assert_eq!(
                sums(|waves, progress| Simd::vectorize(v4, WaveSum { waves, progress })),
                scalar
            );
        }
    }
}
