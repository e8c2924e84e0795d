//! Harmonics of a direction: associated Legendre functions without the Condon-Shortley phase.
//!
//! Y_lm(mu) = sqrt((l-m)!/(l+m)!) P_l^m(mu),   |Y_lm| <= 1
//! P_l(cos gamma) = sum over m of (2 - delta_m0) Y_lm(mu) Y_lm(mu') cos m(phi - phi')
//! the addition theorem, so that a phase function  P = sum of (2l+1)/(4 pi) p_l P_l  scatters each
//! moment of the light on its own. Pairs (l, m), 0 <= m <= l, are numbered with l slowest.
//! [AS64] Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 8.5.3 and 8.6.6.

use std::f64::consts::PI;

/// Number of pairs (l, m) up to a degree.
pub fn n_moments(max_degree: usize) -> usize {
    (max_degree + 1) * (max_degree + 2) / 2
}

/// Number of the pair (l, m), `degree` = l and `order` = m.
pub fn moment_index(degree: usize, order: usize) -> usize {
    degree * (degree + 1) / 2 + order
}

/// All Y_lm at the cosine of a zenith angle, by upward recurrence in l (AS64, 8.5.3).
pub fn harmonics(max_degree: usize, cos_zenith: f64) -> Vec<f64> {
    let mu = cos_zenith;
    let sin = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
    let mut y = vec![0.0; n_moments(max_degree)];
    let mut diagonal = 1.0;
    for m in 0..=max_degree {
        let m_f = m as f64;
        if m > 0 {
            diagonal *= sin * ((2.0 * m_f - 1.0) / (2.0 * m_f)).sqrt();
        }
        y[moment_index(m, m)] = diagonal;
        for l in m + 1..=max_degree {
            let l_f = l as f64;
            let below = if l >= m + 2 {
                y[moment_index(l - 2, m)]
            } else {
                0.0
            };
            let step_down = (((l_f - 1.0).powi(2) - m_f * m_f).max(0.0)).sqrt();
            let step = (l_f * l_f - m_f * m_f).sqrt();
            y[moment_index(l, m)] =
                ((2.0 * l_f - 1.0) * mu * y[moment_index(l - 1, m)] - step_down * below) / step;
        }
    }
    y
}

/// (2 - delta_m0) (2l+1)/(4 pi) of every pair: the weights of the expansion of a source.
pub fn expansion_weights(max_degree: usize) -> Vec<f64> {
    let mut weights = Vec::with_capacity(n_moments(max_degree));
    for l in 0..=max_degree {
        for m in 0..=l {
            let twice = if m == 0 { 1.0 } else { 2.0 };
            weights.push(twice * (2.0 * l as f64 + 1.0) / (4.0 * PI));
        }
    }
    weights
}

/// Legendre polynomials of degree 0 to `max_degree`.
pub fn legendre_polynomials(max_degree: usize, x: f64) -> Vec<f64> {
    let y = harmonics(max_degree, x);
    (0..=max_degree).map(|l| y[moment_index(l, 0)]).collect()
}

/// Writes cos(m phi) for m = 0, 1, … from cos(phi) (AS64, 22.3.15).
pub fn cosines_of_multiples(cos_phi: f64, cosines: &mut [f64]) {
    for m in 0..cosines.len() {
        cosines[m] = match m {
            0 => 1.0,
            1 => cos_phi,
            _ => 2.0 * cos_phi * cosines[m - 1] - cosines[m - 2],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worst is 4e-16.
    const ROUNDING: f64 = 1e-13;

    #[test]
    fn low_degrees_have_their_known_forms() {
        for mu in [-1.0, -0.3, 0.0, 0.6, 1.0_f64] {
            let y = harmonics(2, mu);
            let sin = (1.0 - mu * mu).sqrt();
            let known = [
                1.0,
                mu,
                sin * 0.5_f64.sqrt(),
                1.5 * mu * mu - 0.5,
                1.5_f64.sqrt() * mu * sin,
                0.375_f64.sqrt() * sin * sin,
            ];
            for (found, known) in y.into_iter().zip(known) {
                assert!((found - known).abs() < ROUNDING, "{mu}: {found} {known}");
            }
        }
    }

    #[test]
    fn the_addition_theorem_holds() {
        let (mu, mu_other, phi) = (0.3_f64, -0.8_f64, 1.1_f64);
        let sines = ((1.0 - mu * mu) * (1.0 - mu_other * mu_other)).sqrt();
        let direct = legendre_polynomials(12, mu * mu_other + sines * phi.cos());
        let (a, b) = (harmonics(12, mu), harmonics(12, mu_other));
        for (l, direct) in direct.into_iter().enumerate() {
            let term = |m: usize| {
                let twice = if m == 0 { 1.0 } else { 2.0 };
                let pair = moment_index(l, m);
                twice * a[pair] * b[pair] * (m as f64 * phi).cos()
            };
            let sum: f64 = (0..=l).map(term).sum();
            assert!((sum - direct).abs() < ROUNDING, "degree {l}");
        }
    }

    #[test]
    fn multiples_of_an_angle_follow_from_its_cosine() {
        let mut cosines = [0.0; 10];
        cosines_of_multiples(0.7_f64.cos(), &mut cosines);
        for (m, cosine) in cosines.into_iter().enumerate() {
            assert!((cosine - (0.7 * m as f64).cos()).abs() < ROUNDING);
        }
    }
}
