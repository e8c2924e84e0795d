//! Lorenz-Mie coefficients.
//!
//! a_n = (q psi_n + m psi_{n+1})/(q xi_n + m xi_{n+1}),  q = (n+1)/x (1/m - m) + E_n(mx)
//! b_n = (m E_n(mx) psi_n + psi_{n+1})/(m E_n(mx) xi_n + xi_{n+1})
//!   E_n(z) = psi'_n(z)/psi_n(z) - (n+1)/z = -psi_{n+1}(z)/psi_n(z),  xi_n = psi_n - i chi_n
//! psi_n and xi_n are those of x; the sums run to N = x + 6 x^(1/3) + 10.
//! This is (BH83, eq. 4.88) with the leading (n+1)/z of the logarithmic derivative subtracted by
//! hand: the textbook form loses b_n where n is well above x, and with it g of small spheres.
//! N after [W80], x + 4.05 x^(1/3) + 2, leaves 1e-7 at 180 degrees and 1e-8 elsewhere.
//! [BH83] Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983).
//! [W80] Wiscombe, Applied Optics 19, 1505-1509 (1980).

use num_complex::Complex64;

use crate::partial_waves::PartialWaves;
use crate::riccati_bessel::psi_and_chi;
use crate::riccati_bessel::psi_ratios;

/// Number of partial waves N.
pub(crate) fn n_partial_waves(x: f64) -> usize {
    (x + 6.0 * x.cbrt() + 10.0) as usize
}

/// a_n and b_n of a sphere of size `x` and index `m`, already checked.
pub(crate) fn partial_waves(x: f64, m: Complex64) -> PartialWaves {
    let n_waves = n_partial_waves(x);
    let (psi, chi) = psi_and_chi(x, n_waves + 1);
    if m.im > 0.0 {
        let ratios = psi_ratios(m * x, n_waves + 1);
        let e = |n: usize| -ratios[n + 1];
        from_functions(x, n_waves, |n| absorbing(n, x, m, e(n), (&psi, &chi)))
    } else {
        let ratios = psi_ratios(m.re * x, n_waves + 1);
        let e = |n: usize| -ratios[n + 1];
        from_functions(x, n_waves, |n| transparent(n, x, m.re, e(n), (&psi, &chi)))
    }
}

fn from_functions(
    size_parameter: f64,
    n_waves: usize,
    coefficients: impl Fn(usize) -> [Complex64; 2],
) -> PartialWaves {
    let (mut a, mut b) = (Vec::with_capacity(n_waves), Vec::with_capacity(n_waves));
    for n in 1..=n_waves {
        let [a_n, b_n] = coefficients(n);
        a.push(a_n);
        b.push(b_n);
    }
    PartialWaves {
        size_parameter,
        a,
        b,
    }
}

/// The transparent sphere: numerators are real, and Re a = p^2/(p^2 + q^2) keeps its relative
/// accuracy however small it is.
fn transparent(n: usize, x: f64, m: f64, e: f64, (psi, chi): (&[f64], &[f64])) -> [Complex64; 2] {
    let q_a = (n + 1) as f64 / x * ((1.0 - m) * (1.0 + m) / m) + e;
    let q_b = m * e;
    let coefficient = |q: f64, m_next: f64| {
        let p = q * psi[n] + m_next * psi[n + 1];
        let r = q * chi[n] + m_next * chi[n + 1];
        // p/(p - i r), scaled so that no square over- or underflows.
        if p.abs() > r.abs() {
            let t = r / p;
            Complex64::new(1.0, t) / (1.0 + t * t)
        } else if r.abs() > 0.0 {
            let t = p / r;
            Complex64::new(t * t, t) / (1.0 + t * t)
        } else {
            Complex64::ZERO
        }
    };
    [coefficient(q_a, m), coefficient(q_b, 1.0)]
}

fn absorbing(
    n: usize,
    x: f64,
    m: Complex64,
    e: Complex64,
    (psi, chi): (&[f64], &[f64]),
) -> [Complex64; 2] {
    let q_a = (n + 1) as f64 / x * ((1.0 - m) * (1.0 + m) / m) + e;
    let q_b = m * e;
    let xi = |n: usize| Complex64::new(psi[n], -chi[n]);
    let coefficient = |q: Complex64, m_next: Complex64| {
        (q * psi[n] + m_next * psi[n + 1]) / (q * xi(n) + m_next * xi(n + 1))
    };
    [coefficient(q_a, m), coefficient(q_b, Complex64::ONE)]
}
