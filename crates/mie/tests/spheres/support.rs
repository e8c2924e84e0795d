//! What the tests share: references, and the textbook sum as a slow literal one.

use niji_mie::PartialWaves;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use num_complex::Complex64;

/// Angle in degrees, S1 and S2 as (real, imaginary).
pub(crate) type AmplitudeReference = (f64, (f64, f64), (f64, f64));

/// A sphere in high precision.
pub(crate) struct MieReference {
    pub(crate) x: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) q_ext: f64,
    pub(crate) q_sca: f64,
    pub(crate) g: f64,
    pub(crate) amplitudes: &'static [AmplitudeReference],
}

/// An order of the Debye series in high precision.
pub(crate) struct DebyeReference {
    pub(crate) x: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) order: u32,
    pub(crate) amplitudes: &'static [AmplitudeReference],
}

/// A sphere, by numbers that are known to be good.
pub(crate) fn sphere(x: f64, n: f64, k: f64) -> Sphere {
    Sphere::new(x, RefractiveIndex { n, k }).expect("the tests pass numbers of real spheres")
}

/// Angles in degrees, known to be good.
pub(crate) fn degrees(angles_deg: &[f64]) -> ScatteringAngles {
    ScatteringAngles::from_degrees(angles_deg).expect("the tests pass 0 to 180 degrees")
}

/// (x, y) as a complex number.
pub(crate) fn complex((re, im): (f64, f64)) -> Complex64 {
    Complex64::new(re, im)
}

/// S1 and S2 by the sum over pi_n and tau_n as the textbooks print it, on cos(theta), term by term.
pub(crate) fn textbook_amplitudes(waves: &PartialWaves, theta_deg: f64) -> [Complex64; 2] {
    let mu = theta_deg.to_radians().cos();
    let (mut pi_before, mut pi) = (0.0, 1.0);
    let mut s = [Complex64::ZERO; 2];
    for (index, (a, b)) in waves.a().iter().zip(waves.b()).enumerate() {
        let n = (index + 1) as f64;
        let tau = n * mu * pi - (n + 1.0) * pi_before;
        let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
        s[0] += weight * (a * pi + b * tau);
        s[1] += weight * (a * tau + b * pi);
        (pi_before, pi) = (pi, ((2.0 * n + 1.0) * mu * pi - (n + 1.0) * pi_before) / n);
    }
    s
}
