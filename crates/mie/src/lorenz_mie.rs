//! Lorenz-Mie coefficients.
//!
//! a_n = (q psi_n + m psi_{n+1})/(q xi_n + m xi_{n+1}),  q = (n+1)/x (1/m - m) + E_n(mx)
//! b_n = (m E_n(mx) psi_n + psi_{n+1})/(m E_n(mx) xi_n + xi_{n+1})
//!   E_n(z) = psi'_n(z)/psi_n(z) - (n+1)/z = -psi_{n+1}(z)/psi_n(z),  xi_n = psi_n - i chi_n
//! psi_n and xi_n are those of x; the sums run to N = x + 6 x^(1/3) + 10. Without absorption both
//! fractions are expanded by psi_n(mx), which then needs no division.
//! This is (BH83, eq. 4.88) with the leading (n+1)/z of the logarithmic derivative subtracted by
//! hand: the textbook form loses b_n where n is well above x, and with it g of small spheres.
//! N after [W80], x + 4.05 x^(1/3) + 2, leaves 1e-7 at 180 degrees and 1e-8 elsewhere.
//! [BH83] Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983).
//! [W80] Wiscombe, Applied Optics 19, 1505-1509 (1980).

use num_complex::Complex64;

use crate::partial_waves::PartialWaves;
use crate::riccati_bessel::chi;
use crate::riccati_bessel::neighbors;
use crate::riccati_bessel::psi;
use crate::riccati_bessel::psi_ratios;

/// Number of partial waves N.
pub(crate) fn n_partial_waves(x: f64) -> usize {
    (x + 6.0 * x.cbrt() + 10.0) as usize
}

/// What is outside the sphere in the fractions of one n.
struct Outside {
    n: usize,
    x: f64,
    /// psi and chi of x for n and n + 1.
    psi: [f64; 2],
    chi: [f64; 2],
}

/// a_n and b_n of a sphere of size `x` and index `m`, already checked.
pub(crate) fn partial_waves(x: f64, m: Complex64) -> PartialWaves {
    let n_max = n_partial_waves(x) + 1;
    let outside = neighbors(psi(x, n_max)).zip(neighbors(chi(x, n_max)));
    let outside = (0_usize..).zip(outside).skip(1);
    // Only here put together, so that what the recurrences bring stays in registers.
    let of_wave = |(n, (psi, chi))| Outside { n, x, psi, chi };
    let (a, b) = if m.im > 0.0 {
        outside
            .zip(psi_ratios(m * x, 2, n_max))
            .map(|(outside, ratio)| of_wave(outside).absorbing(m, -ratio))
            .unzip()
    } else {
        outside
            .zip(neighbors(psi(m.re * x, n_max)).skip(1))
            .map(|(outside, psi_mx)| of_wave(outside).transparent(m.re, psi_mx))
            .unzip()
    };
    PartialWaves {
        size_parameter: x,
        a,
        b,
    }
}

impl Outside {
    /// The transparent sphere: numerators are real, and Re a = p^2/(p^2 + r^2) keeps its relative
    /// accuracy however small it is.
    // Inlined, so that what the recurrences bring stays in registers.
    #[inline]
    fn transparent(&self, m: f64, psi_mx: [f64; 2]) -> (Complex64, Complex64) {
        let Self { n, x, psi, chi } = self;
        let q_a = (n + 1) as f64 / x * ((1.0 - m) * (1.0 + m) / m) * psi_mx[0] - psi_mx[1];
        let coefficient = |q: f64, m_next: f64| {
            let p = q * psi[0] + m_next * psi[1];
            let r = q * chi[0] + m_next * chi[1];
            // p/(p - i r), scaled so that no square over- or underflows; 0 if both are. Without a
            // branch, because which of the two is larger changes from wave to wave.
            let scale = 1.0 / p.abs().max(r.abs()).max(f64::MIN_POSITIVE);
            let (p, r) = (p * scale, r * scale);
            let factor = p / (p * p + r * r).max(f64::MIN_POSITIVE);
            Complex64::new(p * factor, r * factor)
        };
        (
            coefficient(q_a, m * psi_mx[0]),
            coefficient(-m * psi_mx[1], psi_mx[0]),
        )
    }

    /// The absorbing sphere; `e` is E_n(mx).
    fn absorbing(&self, m: Complex64, e: Complex64) -> (Complex64, Complex64) {
        let Self { n, x, psi, chi } = self;
        let q_a = (n + 1) as f64 / x * ((1.0 - m) * (1.0 + m) / m) + e;
        let xi = |i: usize| Complex64::new(psi[i], -chi[i]);
        let coefficient = |q: Complex64, m_next: Complex64| {
            (q * psi[0] + m_next * psi[1]) / (q * xi(0) + m_next * xi(1))
        };
        (coefficient(q_a, m), coefficient(m * e, Complex64::ONE))
    }
}
