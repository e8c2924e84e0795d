//! A homogeneous sphere in a plane wave.
//!
//! x = 2 pi a/lambda,  p11 = 2 (i1 + i2)/(x^2 Q_sca), whose mean over all directions is 1.
//! p11 is normalized by Q_sca and never by an integral over a grid: at x = 2e4, 18000 equal steps
//! miss nearly half of it in the forward peak.

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::size_parameter;
use num_complex::Complex64;

use crate::amplitudes::Amplitudes;
use crate::angles::ScatteringAngles;
use crate::debye::DebyeSeries;
use crate::efficiencies::Efficiencies;
use crate::error::Error;
use crate::lorenz_mie::partial_waves;
use crate::partial_waves::PartialWaves;
use crate::refractive_index::RefractiveIndex;

/// The smallest size parameter: below, only the leading power of x is left.
const MIN_SIZE_PARAMETER: f64 = 1e-6;
/// The largest size parameter; a drop of 6 mm radius at 380 nm. Checked against 60 digits to 5e4.
const MAX_SIZE_PARAMETER: f64 = 1e5;

/// A homogeneous sphere, with its Lorenz-Mie coefficients.
///
/// ```
/// use niji_mie::{RefractiveIndex, ScatteringAngles, Sphere};
/// use niji_radiometry::{Micrometers, Nanometers};
///
/// let water = RefractiveIndex { n: 1.333, k: 0.0 };
/// let droplet = Sphere::from_radius(Micrometers(10.0), Nanometers(550.0), water)?;
/// let angles = ScatteringAngles::from_degrees(&[30.0, 140.0])?;
/// let p11 = droplet.p11(&droplet.amplitudes(&angles));
/// assert!(p11[0] > p11[1]);
/// # Ok::<(), niji_mie::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    m: Complex64,
    waves: PartialWaves,
    efficiencies: Efficiencies,
}

impl Sphere {
    /// A sphere of size parameter x = 2 pi a/lambda, lambda in the surroundings.
    ///
    /// # Errors
    /// If x is not within 1e-6 to 1e5, or the index is not that of a passive medium.
    pub fn new(size_parameter: f64, index: RefractiveIndex) -> Result<Self, Error> {
        let (m, waves) = checked_waves(size_parameter, index)?;
        let efficiencies = Efficiencies::new(&waves);
        Ok(Self {
            m,
            waves,
            efficiencies,
        })
    }

    /// A sphere of this radius in light of this wavelength, both in the surroundings.
    ///
    /// # Errors
    /// As [`Sphere::new`].
    pub fn from_radius(
        radius: Micrometers,
        wavelength: Nanometers,
        index: RefractiveIndex,
    ) -> Result<Self, Error> {
        Self::new(size_parameter(radius, wavelength), index)
    }

    /// Size parameter x.
    pub fn size_parameter(&self) -> f64 {
        self.waves.size_parameter
    }

    /// Refractive index relative to the surroundings.
    pub fn refractive_index(&self) -> RefractiveIndex {
        RefractiveIndex {
            n: self.m.re,
            k: self.m.im,
        }
    }

    /// The Lorenz-Mie coefficients.
    pub fn waves(&self) -> &PartialWaves {
        &self.waves
    }

    /// Extinction, scattering, backscattering and mean cosine.
    pub fn efficiencies(&self) -> &Efficiencies {
        &self.efficiencies
    }

    /// S1 and S2 at each angle, all orders together.
    pub fn amplitudes(&self, angles: &ScatteringAngles) -> Amplitudes {
        self.waves.amplitudes(angles)
    }

    /// Phase function of natural light at each angle; its mean over all directions is 1.
    ///
    /// 0 for a sphere that does not scatter.
    pub fn p11(&self, amplitudes: &Amplitudes) -> Vec<f64> {
        let x = self.waves.size_parameter;
        let q_sca = self.efficiencies.q_sca;
        let factor = if q_sca > 0.0 {
            2.0 / (x * x * q_sca)
        } else {
            0.0
        };
        amplitudes
            .intensities()
            .map(|[i1, i2]| factor * (i1 + i2))
            .collect()
    }

    /// The Debye series of this sphere, from which any order can be taken.
    pub fn debye_series(&self) -> DebyeSeries {
        DebyeSeries::new(self.waves.size_parameter, self.m)
    }

    /// One order of the Debye series: 0 diffraction and reflection, 1 transmission, 2 the primary
    /// bow, 3 the secondary bow. For several orders keep [`Sphere::debye_series`].
    pub fn debye(&self, order: u32) -> PartialWaves {
        self.debye_series().order(order)
    }
}

impl PartialWaves {
    /// The partial waves of a whole sphere alone, without its efficiencies.
    ///
    /// # Errors
    /// As [`Sphere::new`].
    pub fn of_sphere(size_parameter: f64, index: RefractiveIndex) -> Result<Self, Error> {
        checked_waves(size_parameter, index).map(|(_, waves)| waves)
    }
}

/// The index and the waves of a sphere that the recurrences hold for.
fn checked_waves(
    size_parameter: f64,
    index: RefractiveIndex,
) -> Result<(Complex64, PartialWaves), Error> {
    let m = index.checked()?;
    if !(MIN_SIZE_PARAMETER..=MAX_SIZE_PARAMETER).contains(&size_parameter) {
        return Err(Error::SizeParameter {
            found: size_parameter,
            min: MIN_SIZE_PARAMETER,
            max: MAX_SIZE_PARAMETER,
        });
    }
    Ok((m, partial_waves(size_parameter, m)))
}
