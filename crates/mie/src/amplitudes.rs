//! Scattering amplitudes and what follows from them at one angle.
//!
//! i_j = |S_j|^2,  degree of polarization = (i1 - i2)/(i1 + i2)

use num_complex::Complex64;

/// Amplitudes at each scattering angle, in the order of the angles.
#[derive(Debug, Clone, PartialEq)]
pub struct Amplitudes {
    /// S1, perpendicular to the scattering plane.
    pub s1: Vec<Complex64>,
    /// S2, parallel to the scattering plane.
    pub s2: Vec<Complex64>,
}

impl Amplitudes {
    /// i1 = |S1|^2 and i2 = |S2|^2 at each angle.
    pub fn intensities(&self) -> impl ExactSizeIterator<Item = [f64; 2]> {
        self.s1
            .iter()
            .zip(&self.s2)
            .map(|(s1, s2)| [s1.norm_sqr(), s2.norm_sqr()])
    }

    /// (i1 - i2)/(i1 + i2) at each angle, positive where the light is polarized perpendicular to
    /// the scattering plane; 0 where there is no light.
    pub fn degrees_of_polarization(&self) -> Vec<f64> {
        let degree = |[i1, i2]: [f64; 2]| {
            if i1 + i2 > 0.0 {
                (i1 - i2) / (i1 + i2)
            } else {
                0.0
            }
        };
        self.intensities().map(degree).collect()
    }
}
