//! Efficiencies: cross-sections divided by pi a^2, and the mean cosine.
//!
//! Q_ext = 2/x^2 sum (2n+1) Re(a_n + b_n),  Q_sca = 2/x^2 sum (2n+1) (|a_n|^2 + |b_n|^2)
//! Q_sca g = 4/x^2 sum [n(n+2)/(n+1) Re(a_n a*_{n+1} + b_n b*_{n+1})
//!                      + (2n+1)/(n(n+1)) Re(a_n b*_n)]
//! Q_back = 4 |S(180)|^2/x^2, so that a perfect mirror sphere has 1.
//! Sums run from low to high n. (BH83, eqs. 4.61, 4.62 and sections 4.5, 4.6)
//! [BH83] Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983).

use crate::partial_waves::PartialWaves;

/// What a sphere takes from a beam, as fractions of its geometric cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Efficiencies {
    /// Extinction: scattered and absorbed, with diffraction; tends to 2 for large spheres.
    pub q_ext: f64,
    /// Scattering, diffraction included.
    pub q_sca: f64,
    /// Radar backscattering: 4 pi times the differential one at 180 degrees.
    pub q_back: f64,
    /// Mean cosine of the scattering angle, g; 0 for a sphere that does not scatter.
    pub asymmetry: f64,
}

impl Efficiencies {
    /// Absorption: what is extinguished and not scattered.
    pub fn q_abs(&self) -> f64 {
        self.q_ext - self.q_sca
    }

    pub(crate) fn new(waves: &PartialWaves) -> Self {
        let (a, b) = (&waves.a, &waves.b);
        let (mut ext, mut sca, mut asymmetric) = (0.0, 0.0, 0.0);
        for (index, (a_n, b_n)) in a.iter().zip(b).enumerate() {
            let n = (index + 1) as f64;
            ext += (2.0 * n + 1.0) * (a_n + b_n).re;
            sca += (2.0 * n + 1.0) * (a_n.norm_sqr() + b_n.norm_sqr());
            asymmetric += (2.0 * n + 1.0) / (n * (n + 1.0)) * (a_n * b_n.conj()).re;
            if let (Some(a_next), Some(b_next)) = (a.get(index + 1), b.get(index + 1)) {
                let neighbors = (a_n * a_next.conj() + b_n * b_next.conj()).re;
                asymmetric += n * (n + 2.0) / (n + 1.0) * neighbors;
            }
        }
        let x2 = waves.size_parameter * waves.size_parameter;
        Self {
            q_ext: 2.0 / x2 * ext,
            q_sca: 2.0 / x2 * sca,
            q_back: 4.0 / x2 * waves.backward_amplitude().norm_sqr(),
            asymmetry: if sca > 0.0 {
                2.0 * asymmetric / sca
            } else {
                0.0
            },
        }
    }
}
