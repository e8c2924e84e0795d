//! Partial waves: the coefficients a_n and b_n of one theory, and the sums over them.
//!
//! S1 = sum (2n+1)/(n(n+1)) (a_n pi_n + b_n tau_n),  S2 with a and b exchanged, n from 1.
//! At the poles S(0) = sum (2n+1)/2 (a_n + b_n) and S1(180) = -S2(180) =
//! sum (2n+1)/2 (-1)^n (b_n - a_n), taken from these sums directly: the optical theorem then holds
//! to the last digits.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::Arch;

use crate::amplitudes::Amplitudes;
use crate::angles::Place;
use crate::angles::ScatteringAngles;
use crate::angles::Side;
use crate::wave_sum::Coefficients;
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
        self.amplitudes_by(angles, Arch::new())
    }

    /// S1 and S2 at each angle by chosen instructions: for measuring what each costs.
    #[doc(hidden)]
    pub fn amplitudes_by(&self, angles: &ScatteringAngles, arch: Arch) -> Amplitudes {
        let sums = pair_sums(arch, &[[&self.a, &self.b]], angles.w());
        self.amplitudes_from(angles, &sums[0])
    }

    /// (dsigma/dOmega)/(pi a^2) = |S_j|^2/(pi x^2) at each angle, 1/sr, for light polarized
    /// perpendicular and parallel to the scattering plane. Natural light is half the sum.
    pub fn normalized_cross_sections(&self, angles: &ScatteringAngles) -> Vec<[f64; 2]> {
        incoherent_cross_sections(std::slice::from_ref(self), angles)
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
        let (s1, s2) = self
            .each_amplitude(angles, sums)
            .map(|[s1, s2]| (s1, s2))
            .unzip();
        Amplitudes { s1, s2 }
    }

    fn each_amplitude(
        &self,
        angles: &ScatteringAngles,
        sums: &PairSums,
    ) -> impl Iterator<Item = [Complex64; 2]> {
        let at_poles = angles
            .has_pole()
            .then(|| [self.forward_amplitude(), self.backward_amplitude()]);
        angles
            .places()
            .iter()
            .map(move |place| match (place.side, at_poles) {
                (Side::Forward, Some([forward, _])) if place.pair_index == 0 => [forward; 2],
                (Side::Backward, Some([_, back])) if place.pair_index == 0 => [back, -back],
                (Side::Forward, _) => sums.forward(place.pair_index),
                (Side::Backward, _) => sums.backward(place.pair_index),
            })
    }
}

/// Sum over series of |S_j|^2/(pi x^2) at each angle, 1/sr, from the first series to the last.
pub(crate) fn incoherent_cross_sections(
    series: &[PartialWaves],
    angles: &ScatteringAngles,
) -> Vec<[f64; 2]> {
    let mut sum = vec![[0.0; 2]; angles.len()];
    for light in cross_sections_of_each(series, angles) {
        for ([s, p], light) in sum.iter_mut().zip(light) {
            *s += light[0];
            *p += light[1];
        }
    }
    sum
}

/// (dsigma/dOmega)/(pi a^2) of each series at each angle, 1/sr, as
/// [`PartialWaves::normalized_cross_sections`]: the recurrence over the waves is run once for all of them,
/// so that eight spheres take two thirds of the time of eight calls.
///
/// ```
/// use niji_mie::{RefractiveIndex, ScatteringAngles, Sphere, cross_sections_of_each};
///
/// let water = RefractiveIndex { n: 1.333, k: 0.0 };
/// let spheres = [Sphere::new(50.0, water)?, Sphere::new(51.0, water)?];
/// let angles = ScatteringAngles::from_degrees(&[30.0, 140.0])?;
/// let waves = spheres.each_ref().map(|sphere| sphere.waves().clone());
/// let light = cross_sections_of_each(&waves, &angles);
/// assert_eq!(light[1], waves[1].normalized_cross_sections(&angles));
/// # Ok::<(), niji_mie::Error>(())
/// ```
pub fn cross_sections_of_each(
    series: &[PartialWaves],
    angles: &ScatteringAngles,
) -> Vec<Vec<[f64; 2]>> {
    let coefficients: Vec<Coefficients> =
        series.iter().map(|waves| [waves.a(), waves.b()]).collect();
    let arch = Arch::new();
    let sums = pair_sums(arch, &coefficients, angles.w());
    let of_series = |(waves, sums): (&PartialWaves, &PairSums)| {
        let per_area = 1.0 / (PI * waves.size_parameter * waves.size_parameter);
        let [forward, backward] = sums.squares(arch, per_area);
        let at_poles = angles.has_pole().then(|| {
            let poles = [waves.forward_amplitude(), waves.backward_amplitude()];
            poles.map(|s| [per_area * s.norm_sqr(); 2])
        });
        let light = |place: &Place| match (place.side, at_poles) {
            (Side::Forward, Some([front, _])) if place.pair_index == 0 => front,
            (Side::Backward, Some([_, back])) if place.pair_index == 0 => back,
            (Side::Forward, _) => forward[place.pair_index],
            (Side::Backward, _) => backward[place.pair_index],
        };
        angles.places().iter().map(light).collect()
    };
    series.iter().zip(&sums).map(of_series).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refractive_index::RefractiveIndex;
    use crate::sphere::Sphere;

    #[test]
    fn light_of_each_is_the_squares_of_its_amplitudes_at_poles_and_on_either_side() {
        let index = RefractiveIndex { n: 1.333, k: 1e-4 };
        let sizes = [0.3, 17.0, 230.0];
        let waves = sizes.map(|x| PartialWaves::of_sphere(x, index).unwrap());
        for angles_deg in [
            vec![0.0, 0.1, 30.0, 89.0, 90.0, 138.0, 150.0, 180.0],
            vec![95.0, 110.5, 179.9],
            vec![3.0],
        ] {
            let angles = ScatteringAngles::from_degrees(&angles_deg).unwrap();
            let lights = cross_sections_of_each(&waves, &angles);
            for ((x, waves), light) in sizes.into_iter().zip(&waves).zip(lights) {
                assert_eq!(waves, Sphere::new(x, index).unwrap().waves());
                let per_area = 1.0 / (PI * x * x);
                let squares = waves.amplitudes(&angles);
                let squares = squares
                    .intensities()
                    .map(|both| both.map(|it| per_area * it));
                // The same sums, whatever vectors they were squared in.
                assert_eq!(light, squares.collect::<Vec<_>>());
            }
        }
    }
}
