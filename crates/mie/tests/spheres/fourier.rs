//! The sums at every angle of a grid against their Fourier series.
//!
//! pi_n is the Gegenbauer polynomial of order n - 1 and index 3/2 of cos(theta), so that
//!   S1 = C_0 + 2 sum C_k cos(k theta),  C_k = sum_j gamma_{k+2j+1} g_j g_{k+j}
//!   g_j = (3/2)(5/2)...(j+1/2)/j!
//! and S2 with delta. It shares with the crate the coefficients a_n and b_n and the gamma_n made of
//! them, but neither a recurrence over n nor the folding of angles.

use num_complex::Complex64;

use crate::support::degrees;
use crate::support::sphere;

/// Relative; worst found 6.5e-11 (x = 2e4 at 180 degrees).
const P11: f64 = 1e-9;

/// C_k of gamma_n, n from 1.
fn fourier_coefficients(gamma: &[Complex64]) -> Vec<Complex64> {
    let mut g = vec![1.0];
    for j in 1..gamma.len() {
        g.push(g[j - 1] * (j as f64 + 0.5) / j as f64);
    }
    let coefficient = |k: usize| -> Complex64 {
        let gamma = gamma[k..].iter().step_by(2);
        let products = g.iter().zip(&g[k..]).map(|(g, h)| g * h);
        gamma.zip(products).map(|(gamma, g)| gamma * g).sum()
    };
    (0..gamma.len()).map(coefficient).collect()
}

/// gamma_n, or delta_n with `a` and `b` exchanged.
fn gamma(a: &[Complex64], b: &[Complex64]) -> Vec<Complex64> {
    let wave = |c: &[Complex64], n: usize| {
        let index = n.checked_sub(1);
        index
            .and_then(|index| c.get(index).copied())
            .unwrap_or_default()
    };
    let gamma = |n: usize| {
        let m = n as f64;
        (2.0 * m + 1.0) / (m * (m + 1.0)) * wave(a, n) + (m - 1.0) / m * wave(b, n - 1)
            - (m + 2.0) / (m + 1.0) * wave(b, n + 1)
    };
    (1..=a.len() + 1).map(gamma).collect()
}

#[test]
fn the_phase_function_agrees_at_every_angle_of_a_full_grid() {
    // 0.1 degrees, in which k theta is a whole number: its cosine comes from one turn of 3600.
    let turn: Vec<f64> = (0..3600)
        .map(|i| (f64::from(i) * 0.1).to_radians().cos())
        .collect();
    let grid_deg: Vec<f64> = (0..=1800).map(|i| f64::from(i) / 10.0).collect();
    for (x, n, k) in [
        (30.0, 1.5, 0.1),
        (1000.0, 1.333, 0.0),
        (20000.0, 1.3335, 0.0),
    ] {
        let sphere = sphere(x, n, k);
        let (a, b) = (sphere.waves().a(), sphere.waves().b());
        let [s1, s2] = [gamma(a, b), gamma(b, a)].map(|gamma| fourier_coefficients(&gamma));
        let p11 = sphere.p11(&sphere.amplitudes(&degrees(&grid_deg)));
        for (step, p11) in p11.iter().enumerate() {
            let series = |c: &[Complex64]| -> Complex64 {
                let terms = c.iter().enumerate().skip(1);
                c[0] + 2.0
                    * terms
                        .map(|(k, c)| c * turn[k * step % turn.len()])
                        .sum::<Complex64>()
            };
            let intensity = series(&s1).norm_sqr() + series(&s2).norm_sqr();
            let expected = 2.0 * intensity / (x * x * sphere.efficiencies().q_sca);
            assert!(
                (p11 / expected - 1.0).abs() <= P11,
                "x = {x} at {}",
                grid_deg[step]
            );
        }
    }
}
