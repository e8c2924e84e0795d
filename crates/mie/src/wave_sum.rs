//! S1 and S2 of mirrored pairs of angles: the sums that take all the time.
//!
//! tau_n = (n^2 pi_{n+1} - (n+1)^2 pi_{n-1})/(2n+1) removes tau_n:
//!   S1 = sum gamma_n pi_n,  S2 = sum delta_n pi_n,  n = 1 to N+1
//!   gamma_n = (2n+1)/(n(n+1)) a_n + (n-1)/n b_{n-1} - (n+2)/(n+1) b_{n+1}
//! and delta_n with a and b exchanged. pi_n has the parity of n-1 in mu = cos(theta'), so a wave
//! feeds either U (odd n) or V (even n), and S(theta') = U + V, S(180 deg - theta') = U - V.
//! With pi_n = s_n q_n, s_n s_{n+1} = 2(n+1)/pi, the recurrence is symmetric,
//!   q_{n+1} = alpha_n mu q_n - q_{n-1},  alpha_n = (2n+1)/n s_n/s_{n+1} = 2 - e_n
//! and in differences, after Reinsch, with w = 1 - mu = 2 sin^2(theta'/2):
//!   d_{n+1} = d_n - (e_n + alpha_n w) q_n,  q_{n+1} = q_n + d_{n+1}
//! That is 7 vector operations for a wave and a pair, against 24 of the textbook loop; 3 of them
//! are the recurrence, which all orders of a Debye series share. It keeps its digits at the poles,
//! where mu cannot represent the angle.
//! Symmetry alpha_n alpha_{n+1} = 4 + 3/(n(n+2)) gives e_n.
//! [R67] Reinsch's form of such recurrences: Gentleman, Computer Journal 12, 160-165 (1969).

mod kernels;

use num_complex::Complex64;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

use self::kernels::Progress;
use self::kernels::Waves;
use self::kernels::add_waves;

/// s_n s_{n+1}/(n+1); the value for which s_n grows as sqrt(n) without alternating.
const SCALE: f64 = std::f64::consts::FRAC_2_PI;

/// From here the asymptotic series of e_n is exact to 1e-20.
const N_ASYMPTOTIC: usize = 64;

/// Waves of one pass over all angles, an even number: the factors of eight series fit into a
/// second-level cache.
const N_PASS: usize = 512;

/// What leads from q_n to q_{n+1}: -e_n and -alpha_n.
type Step = [f64; 2];

/// What q_n is multiplied by: gamma_n s_n and delta_n s_n as real and imaginary part.
type Factors = [f64; 4];

/// Real and imaginary part of U of S1, U of S2, V of S1, V of S2; one element for each pair.
type Parts = [Vec<f64>; 8];

/// a_n and b_n of one series.
pub(crate) type Coefficients<'a> = [&'a [Complex64]; 2];

/// U and V of S1 and S2 for each pair of angles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairSums {
    parts: Parts,
}

impl PairSums {
    /// S1 and S2 at theta'.
    pub(crate) fn forward(&self, pair_index: usize) -> [Complex64; 2] {
        let [u1, u2, v1, v2] = self.at(pair_index);
        [u1 + v1, u2 + v2]
    }

    /// S1 and S2 at 180 degrees - theta'.
    pub(crate) fn backward(&self, pair_index: usize) -> [Complex64; 2] {
        let [u1, u2, v1, v2] = self.at(pair_index);
        [u1 - v1, u2 - v2]
    }

    /// |S1|^2 and |S2|^2 times a factor of all pairs, at theta' and at 180 degrees - theta'.
    pub(crate) fn squares(&self, arch: Arch, factor: f64) -> [Vec<[f64; 2]>; 2] {
        [1.0, -1.0].map(|sign| {
            let mut light = vec![[0.0; 2]; self.parts[0].len()];
            arch.dispatch(Squares {
                parts: &self.parts,
                sign,
                factor,
                light: &mut light,
            });
            light
        })
    }

    fn at(&self, pair_index: usize) -> [Complex64; 4] {
        let part = |part: usize| self.parts[part][pair_index];
        [0, 2, 4, 6].map(|re| Complex64::new(part(re), part(re + 1)))
    }
}

/// [`PairSums::squares`] on one side, V added or taken away.
struct Squares<'a> {
    parts: &'a Parts,
    sign: f64,
    factor: f64,
    light: &'a mut [[f64; 2]],
}

#[allow(
    clippy::inline_always,
    reason = "only what is inlined gets the processor's instructions"
)]
impl WithSimd for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sign, factor, .. } = self;
        let n = self.light.len();
        let [u1, u1_im, u2, u2_im, v1, v1_im, v2, v2_im] = self.parts.each_ref().map(|it| &it[..n]);
        for (pair, light) in self.light.iter_mut().enumerate() {
            let s1 = [u1[pair] + sign * v1[pair], u1_im[pair] + sign * v1_im[pair]];
            let s2 = [u2[pair] + sign * v2[pair], u2_im[pair] + sign * v2_im[pair]];
            *light = [s1, s2].map(|[re, im]| factor * (re * re + im * im));
        }
    }
}

/// The sums of each series over its waves at each w = 2 sin^2(theta'/2), each from low to high n.
pub(crate) fn pair_sums(arch: Arch, series: &[Coefficients], w: &[f64]) -> Vec<PairSums> {
    let n_padded = w.len().next_multiple_of(kernels::MAX_LANES);
    let mut padded_w = w.to_vec();
    padded_w.resize(n_padded, 0.0);
    let zeros = || std::array::from_fn(|_| vec![0.0; n_padded]);
    let mut progress = Progress {
        w: padded_w,
        // q_1 = 1, and d_1 = q_1 - q_0 with q_0 = 0.
        q: vec![1.0; n_padded],
        d: vec![1.0; n_padded],
        sums: series.iter().map(|_| zeros()).collect(),
    };
    let n_waves = series.iter().map(|[a, _]| a.len()).max().unwrap_or(0);
    for first in (1..=n_waves + 1).step_by(N_PASS) {
        let weights = weights(first, (n_waves + 2 - first).min(N_PASS));
        let steps: Vec<Step> = weights.iter().map(|weights| weights.step).collect();
        let factors: Vec<_> = series
            .iter()
            .map(|coefficients| factors(first, &weights, *coefficients))
            .collect();
        let waves = Waves {
            steps: &steps,
            series: &factors,
        };
        add_waves(arch, waves, &mut progress);
    }
    let sums = progress.sums.into_iter();
    sums.map(|parts| PairSums { parts }).collect()
}

/// What one n brings to every series.
struct Weights {
    step: Step,
    /// Of a_n in gamma_n s_n: (2n+1)/(n(n+1)) s_n.
    own: f64,
    /// Of b_{n-1}: (n-1)/n s_n.
    before: f64,
    /// Of b_{n+1}: -(n+2)/(n+1) s_n.
    after: f64,
}

/// Weights of n from `first`; one more than asked for where that makes their number even.
fn weights(first: usize, n_weights: usize) -> Vec<Weights> {
    let low = if first < N_ASYMPTOTIC {
        low_e()
    } else {
        [0.0; N_ASYMPTOTIC]
    };
    let weights = |n: usize| {
        let m = n as f64;
        let e = if n < N_ASYMPTOTIC {
            low[n]
        } else {
            asymptotic_e(n)
        };
        let alpha = 2.0 - e;
        let scale = (SCALE * alpha * m * (m + 1.0) / (2.0 * m + 1.0)).sqrt();
        Weights {
            step: [-e, -alpha],
            own: (2.0 * m + 1.0) / (m * (m + 1.0)) * scale,
            before: (m - 1.0) / m * scale,
            after: -(m + 2.0) / (m + 1.0) * scale,
        }
    };
    let end = first + n_weights.next_multiple_of(2);
    (first..end).map(weights).collect()
}

/// Factors of n from `first`, from coefficients whose index 0 is n = 1.
fn factors(first: usize, weights: &[Weights], [a, b]: Coefficients) -> Vec<Factors> {
    // From n - 1 of the first to n + 1 of the last, 0 where there is none.
    let with_neighbors = |c: &[Complex64]| -> Vec<Complex64> {
        let n = first - 1..first + weights.len() + 1;
        n.map(|n| match n.checked_sub(1) {
            Some(index) => c.get(index).copied().unwrap_or_default(),
            None => Complex64::ZERO,
        })
        .collect()
    };
    let (a, b) = (with_neighbors(a), with_neighbors(b));
    let neighbors = a.windows(3).zip(b.windows(3));
    neighbors
        .zip(weights)
        .map(|((a, b), w)| {
            let gamma = a[1] * w.own + b[0] * w.before + b[2] * w.after;
            let delta = b[1] * w.own + a[0] * w.before + a[2] * w.after;
            [gamma.re, gamma.im, delta.re, delta.im]
        })
        .collect()
}

/// e_n for n below `N_ASYMPTOTIC`, by the recurrence downwards; element 0 is not used.
fn low_e() -> [f64; N_ASYMPTOTIC] {
    let mut low = [0.0; N_ASYMPTOTIC];
    let mut e = asymptotic_e(N_ASYMPTOTIC);
    for n in (1..N_ASYMPTOTIC).rev() {
        let m = n as f64;
        e = -(3.0 / (m * (m + 2.0)) + 2.0 * e) / (2.0 - e);
        low[n] = e;
    }
    low
}

/// e_n in powers of 1/(n + 1/2)^2, from the relation between neighbors.
fn asymptotic_e(n: usize) -> f64 {
    let t = (n as f64 + 0.5).powi(-2);
    -t * (0.75
        + t * (0.046875 + t * (0.310546875 + t * (-1.23028564453125 + t * 9.36911773681641))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_asymptotic_series_joins_the_recurrence() {
        // (2 - e_n)(2 - e_{n+1}) = 4 + 3/(n(n+2)), without the 4 on both sides.
        let is_related = |n: usize, e: f64, next: f64| {
            let expected = 3.0 / (n as f64 * (n as f64 + 2.0));
            // Worst found 4.4e-16.
            (e * next - 2.0 * (e + next) - expected).abs() <= 2e-15 * expected
        };
        for n in N_ASYMPTOTIC..2000 {
            assert!(
                is_related(n, asymptotic_e(n), asymptotic_e(n + 1)),
                "n = {n}"
            );
        }
        let low = low_e();
        for n in 1..N_ASYMPTOTIC - 1 {
            assert!(is_related(n, low[n], low[n + 1]), "n = {n}");
        }
        // 2 - 3 s_1/s_2 with s_1 = 1, s_2 = 4/pi.
        assert!((low_e()[1] - (2.0 - 0.75 * std::f64::consts::PI)).abs() <= 2e-16);
    }

    #[test]
    fn a_single_wave_gives_pi_and_tau() {
        // Sum of one a_n is S1 = (2n+1)/(n(n+1)) pi_n, S2 = (2n+1)/(n(n+1)) tau_n; n = 3 by hand:
        // pi_3 = (15 mu^2 - 3)/2, tau_3 = (45 mu^3 - 33 mu)/2.
        let mut a = vec![Complex64::ZERO; 3];
        a[2] = Complex64::new(1.0, -2.0);
        let b = vec![Complex64::ZERO; 3];
        for theta_deg in [0.0_f64, 10.0, 60.0, 90.0] {
            let w = 2.0 * (0.5 * theta_deg.to_radians()).sin().powi(2);
            let mu = 1.0 - w;
            let sums = &pair_sums(Arch::new(), &[[&a, &b]], &[w])[0];
            let [pi, tau] = [
                (15.0 * mu * mu - 3.0) / 2.0,
                (45.0 * mu.powi(3) - 33.0 * mu) / 2.0,
            ];
            let [s1, s2] = sums.forward(0);
            assert!(
                (s1 - a[2] * (7.0 / 12.0 * pi)).norm() <= 2e-14,
                "{theta_deg}: {s1}"
            );
            assert!(
                (s2 - a[2] * (7.0 / 12.0 * tau)).norm() <= 2e-14,
                "{theta_deg}: {s2}"
            );
            let [s1, s2] = sums.backward(0);
            assert!((s1 - a[2] * (7.0 / 12.0 * pi)).norm() <= 2e-14);
            assert!((s2 + a[2] * (7.0 / 12.0 * tau)).norm() <= 2e-14);
        }
    }
}
