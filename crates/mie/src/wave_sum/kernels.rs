//! The inner loop of the sums over waves, for the vectors that the processor has.
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

use super::Row;

/// f64 lanes of the longest vectors; the number of pairs is padded to a multiple.
pub(super) const MAX_LANES: usize = 8;

/// Vectors in a block where there are 32 registers: enough to hide the latency of two FMAs.
const BLOCK_OF_32_REGISTERS: usize = 3;
/// Vectors in a block where there are 16 registers.
const BLOCK_OF_16_REGISTERS: usize = 2;

/// Adds all waves at each `w`, with the best instructions at hand.
pub(super) fn add_waves(rows: &[Row], w: &[f64], parts: &mut [Vec<f64>; 8]) {
    let arch = Arch::new();
    if matches!(arch, Arch::Scalar) {
        add_waves_without_fma(rows, w, parts);
    } else {
        arch.dispatch(VectorSum { rows, w, parts });
    }
}

/// The sums with explicit vectors.
struct VectorSum<'a> {
    rows: &'a [Row],
    w: &'a [f64],
    parts: &'a mut [Vec<f64>; 8],
}

impl WithSimd for VectorSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (w, _) = S::as_simd_f64s(self.w);
        let mut parts = self
            .parts
            .each_mut()
            .map(|part| S::as_mut_simd_f64s(part).0);
        let mut first = 0;
        if S::REGISTER_COUNT >= 32 {
            while w.len() - first >= BLOCK_OF_32_REGISTERS {
                block::<S, BLOCK_OF_32_REGISTERS>(simd, self.rows, (w, first), &mut parts);
                first += BLOCK_OF_32_REGISTERS;
            }
        }
        while w.len() - first >= BLOCK_OF_16_REGISTERS {
            block::<S, BLOCK_OF_16_REGISTERS>(simd, self.rows, (w, first), &mut parts);
            first += BLOCK_OF_16_REGISTERS;
        }
        while w.len() > first {
            block::<S, 1>(simd, self.rows, (w, first), &mut parts);
            first += 1;
        }
    }
}

/// `B` vectors of pairs through all waves.
#[inline(always)]
fn block<S: Simd, const B: usize>(
    simd: S,
    rows: &[Row],
    (all_w, first): (&[S::f64s], usize),
    parts: &mut [&mut [S::f64s]; 8],
) {
    let one = simd.splat_f64s(1.0);
    let zero = simd.splat_f64s(0.0);
    let mut w = [zero; B];
    w.copy_from_slice(&all_w[first..first + B]);
    let mut state = State {
        w,
        q: [one; B],
        d: [one; B],
    };
    let mut u = [[zero; B]; 4];
    let mut v = [[zero; B]; 4];
    let (pairs, _) = rows.as_chunks::<2>();
    for [odd, even] in pairs {
        state.add(simd, odd, &mut u);
        state.add(simd, even, &mut v);
    }
    for part in 0..4 {
        parts[part][first..first + B].copy_from_slice(&u[part]);
        parts[part + 4][first..first + B].copy_from_slice(&v[part]);
    }
}

/// q_n and d_n of a block, and where it is.
struct State<S: Simd, const B: usize> {
    w: [S::f64s; B],
    q: [S::f64s; B],
    d: [S::f64s; B],
}

impl<S: Simd, const B: usize> State<S, B> {
    /// Adds wave n and steps to n + 1.
    #[inline(always)]
    fn add(&mut self, simd: S, row: &Row, sums: &mut [[S::f64s; B]; 4]) {
        for (sums, factor) in sums.iter_mut().zip(&row[2..]) {
            let factor = simd.splat_f64s(*factor);
            for (sum, q) in sums.iter_mut().zip(self.q) {
                *sum = simd.mul_add_f64s(factor, q, *sum);
            }
        }
        let minus_e = simd.splat_f64s(row[0]);
        let minus_alpha = simd.splat_f64s(row[1]);
        for i in 0..B {
            let factor = simd.mul_add_f64s(minus_alpha, self.w[i], minus_e);
            self.d[i] = simd.mul_add_f64s(factor, self.q[i], self.d[i]);
            self.q[i] = simd.add_f64s(self.q[i], self.d[i]);
        }
    }
}

/// The sums with plain products, in loops that the compiler turns into short vectors.
fn add_waves_without_fma(rows: &[Row], w: &[f64], parts: &mut [Vec<f64>; 8]) {
    const B: usize = MAX_LANES;
    let (blocks, _) = w.as_chunks::<B>();
    for (block_index, w) in blocks.iter().enumerate() {
        let (mut q, mut d) = ([1.0; B], [1.0; B]);
        let mut sums = [[[0.0; B]; 4]; 2];
        let (pairs, _) = rows.as_chunks::<2>();
        for pair in pairs {
            for (row, sums) in pair.iter().zip(&mut sums) {
                for i in 0..B {
                    for part in 0..4 {
                        sums[part][i] += row[part + 2] * q[i];
                    }
                    d[i] += (row[1] * w[i] + row[0]) * q[i];
                    q[i] += d[i];
                }
            }
        }
        let first = block_index * B;
        for part in 0..4 {
            parts[part][first..first + B].copy_from_slice(&sums[0][part]);
            parts[part + 4][first..first + B].copy_from_slice(&sums[1][part]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a converging sum and arguments from pole to equator.
    fn example() -> (Vec<Row>, Vec<f64>) {
        let row = |n: usize| {
            let m = n as f64;
            let e = super::super::asymptotic_e(n.max(3));
            [
                -e,
                e - 2.0,
                m.sin(),
                (1.3 * m).cos(),
                (0.7 * m).sin(),
                1.0 / m,
            ]
        };
        let w = (0..104).map(|i| f64::from(i) / 103.0);
        ((1..=200).map(row).collect(), w.collect())
    }

    fn sums(add: impl FnOnce(&[Row], &[f64], &mut [Vec<f64>; 8])) -> [Vec<f64>; 8] {
        let (rows, w) = example();
        let mut parts = std::array::from_fn(|_| vec![0.0; w.len()]);
        add(&rows, &w, &mut parts);
        parts
    }

    #[test]
    fn plain_products_agree_with_the_fused_ones() {
        let (fused, plain) = (sums(add_waves), sums(add_waves_without_fma));
        for (fused, plain) in fused.iter().flatten().zip(plain.iter().flatten()) {
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
            sums(|rows, w, parts| Simd::vectorize(pulp::Scalar, VectorSum { rows, w, parts }));
        if let Some(v3) = pulp::x86::V3::try_new() {
            assert_eq!(
                sums(|rows, w, parts| Simd::vectorize(v3, VectorSum { rows, w, parts })),
                scalar
            );
        }
        if let Some(v4) = pulp::x86::V4::try_new() {
            assert_eq!(
                sums(|rows, w, parts| Simd::vectorize(v4, VectorSum { rows, w, parts })),
                scalar
            );
        }
    }
}
