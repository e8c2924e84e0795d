//! Partial waves: the coefficients a_n and b_n of one theory, and the sums over them.
//!
//! S1 = sum (2n+1)/(n(n+1)) (a_n pi_n + b_n tau_n),  S2 with a and b exchanged, n from 1.
//! At the poles S(0) = sum (2n+1)/2 (a_n + b_n) and S1(180) = -S2(180) =
//! sum (2n+1)/2 (-1)^n (b_n - a_n), taken from these sums directly: the optical theorem then holds
//! to the last digits.

use num_complex::Complex64;

use crate::amplitudes::Amplitudes;
use crate::angles::Place;
use crate::angles::ScatteringAngles;
use crate::angles::Side;
use crate::wave_sum::PairSums;
use crate::wave_sum::pair_sums;

/// The partial waves of a sphere: of the whole sphere or of one order of the Debye series.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialWaves {
    pub(crate) size_parameter: f64,
    pub(crate) a: Vec<Complex64>,
    pub(crate) b: Vec<Complex64>,
}

impl PartialWaves {
    /// Size parameter x of the sphere.
    pub fn size_parameter(&self) -> f64 {
        self.size_parameter
    }

    /// a_n of the electric waves, n = 1, 2, …
    pub fn a(&self) -> &[Complex64] {
        &self.a
    }

    /// b_n of the magnetic waves, n = 1, 2, …
    pub fn b(&self) -> &[Complex64] {
        &self.b
    }

    /// S1 and S2 at each angle.
    pub fn amplitudes(&self, angles: &ScatteringAngles) -> Amplitudes {
        self.amplitudes_from(angles, &pair_sums(&self.a, &self.b, angles.w()))
    }

    /// (dsigma/dOmega)/(pi a^2) = |S_j|^2/(pi x^2) at each angle, 1/sr, for light polarized
    /// perpendicular and parallel to the scattering plane. Natural light is half the sum.
    pub fn normalized_cross_sections(&self, angles: &ScatteringAngles) -> Vec<[f64; 2]> {
        let per_area = 1.0 / (std::f64::consts::PI * self.size_parameter * self.size_parameter);
        let amplitudes = self.amplitudes(angles);
        amplitudes
            .intensities()
            .map(|pair| pair.map(|i| i * per_area))
            .collect()
    }

    /// S1(0) = S2(0); sums from low to high n.
    pub fn forward_amplitude(&self) -> Complex64 {
        let wave = |n: usize| (n as f64 + 0.5) * (self.a[n - 1] + self.b[n - 1]);
        (1..=self.a.len()).map(wave).sum()
    }

    /// S1(180 deg) = -S2(180 deg); sums from low to high n.
    pub fn backward_amplitude(&self) -> Complex64 {
        let wave = |n: usize| {
            let difference = self.b[n - 1] - self.a[n - 1];
            let signed = if n.is_multiple_of(2) {
                difference
            } else {
                -difference
            };
            (n as f64 + 0.5) * signed
        };
        (1..=self.a.len()).map(wave).sum()
    }

    fn amplitudes_from(&self, angles: &ScatteringAngles, sums: &PairSums) -> Amplitudes {
        let at_poles = [self.forward_amplitude(), self.backward_amplitude()];
        let at = |place: &Place| {
            // A pole is stored as exactly 0.
            let is_pole = angles.w()[place.pair_index] <= 0.0;
            match (place.side, is_pole) {
                (Side::Forward, true) => [at_poles[0]; 2],
                (Side::Backward, true) => [at_poles[1], -at_poles[1]],
                (Side::Forward, false) => sums.forward(place.pair_index),
                (Side::Backward, false) => sums.backward(place.pair_index),
            }
        };
        let (s1, s2) = angles
            .places()
            .iter()
            .map(at)
            .map(|[s1, s2]| (s1, s2))
            .unzip();
        Amplitudes { s1, s2 }
    }
}
