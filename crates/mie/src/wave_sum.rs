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
//! That is 7 vector operations for a wave and a pair, against 24 of the textbook loop, and it keeps
//! its digits at the poles, where mu cannot represent the angle.
//! Symmetry alpha_n alpha_{n+1} = 4 + 3/(n(n+2)) gives e_n.
//! [R67] Reinsch's form of such recurrences: Gentleman, Computer Journal 12, 160-165 (1969).

mod kernels;

use num_complex::Complex64;

use self::kernels::add_waves;

/// s_n s_{n+1}/(n+1); the value for which s_n grows as sqrt(n) without alternating.
const SCALE: f64 = std::f64::consts::FRAC_2_PI;

/// From here the asymptotic series of e_n is exact to 1e-20.
const N_ASYMPTOTIC: usize = 64;

/// Numbers that a wave contributes with: -e_n, -alpha_n, then gamma_n s_n and delta_n s_n as real
/// and imaginary part.
type Row = [f64; 6];

/// U and V of S1 and S2 for each pair of angles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairSums {
    /// Real and imaginary part of U of S1, U of S2, V of S1, V of S2; one element for each pair.
    parts: [Vec<f64>; 8],
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

    fn at(&self, pair_index: usize) -> [Complex64; 4] {
        let part = |part: usize| self.parts[part][pair_index];
        [0, 2, 4, 6].map(|re| Complex64::new(part(re), part(re + 1)))
    }
}

/// The sums over all waves at each w = 2 sin^2(theta'/2), each from low to high n.
pub(crate) fn pair_sums(a: &[Complex64], b: &[Complex64], w: &[f64]) -> PairSums {
    let n_padded = w.len().next_multiple_of(kernels::MAX_LANES);
    let mut padded_w = w.to_vec();
    padded_w.resize(n_padded, 0.0);
    let mut parts = std::array::from_fn(|_| vec![0.0; n_padded]);
    add_waves(&rows(a, b), &padded_w, &mut parts);
    PairSums { parts }
}

/// One row for each n from 1, filled up with empty rows to an even number.
fn rows(a: &[Complex64], b: &[Complex64]) -> Vec<Row> {
    let n_last = a.len() + 1;
    let wave = |c: &[Complex64], n: usize| {
        let index = n.checked_sub(1);
        index
            .and_then(|index| c.get(index))
            .copied()
            .unwrap_or(Complex64::ZERO)
    };
    let low = low_e();
    let row = |n: usize| {
        let (m, e) = (
            n as f64,
            if n < N_ASYMPTOTIC {
                low[n]
            } else {
                asymptotic_e(n)
            },
        );
        let alpha = 2.0 - e;
        let scale = (SCALE * alpha * m * (m + 1.0) / (2.0 * m + 1.0)).sqrt();
        let own = (2.0 * m + 1.0) / (m * (m + 1.0));
        let (before, after) = ((m - 1.0) / m, (m + 2.0) / (m + 1.0));
        let combine = |c: &[Complex64], other: &[Complex64]| {
            (own * wave(c, n) + before * wave(other, n - 1) - after * wave(other, n + 1)) * scale
        };
        let (gamma, delta) = (combine(a, b), combine(b, a));
        [-e, -alpha, gamma.re, gamma.im, delta.re, delta.im]
    };
    let mut rows: Vec<Row> = (1..=n_last).map(row).collect();
    rows.resize(n_last.next_multiple_of(2), [0.0; 6]);
    rows
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
            let sums = pair_sums(&a, &b, &[w]);
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
