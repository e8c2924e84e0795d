//! Where the light of a path is added up.

use crate::light::Light;
use crate::light::Sky;
use crate::light::SkyPart;
use crate::transmittance_table::TransmittanceTable;

use glam::DVec3;

/// The wavelengths that a path carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CarriedWavelengths {
    All,
    /// From the first in equal steps, around the end of the spectrum.
    Some {
        first: usize,
        step: usize,
        count: usize,
    },
}

impl CarriedWavelengths {
    /// The wavelength that decides the way of a path; the middle one for all.
    pub(crate) fn leading(self, n_wavelengths: usize) -> usize {
        match self {
            Self::All => n_wavelengths / 2,
            Self::Some { first, .. } => first,
        }
    }
}

/// Spectral radiance that gathers what paths find.
pub(crate) struct RadianceSum<'a> {
    pub(crate) table: &'a TransmittanceTable,
    pub(crate) light: &'a Light,
    pub(crate) carried: CarriedWavelengths,
    /// W m^-2 sr^-1 nm^-1, the sum over the paths so far.
    pub(crate) radiance: &'a mut [f64],
    /// Room for one spectrum.
    pub(crate) scratch: &'a mut [f64],
}

impl RadianceSum<'_> {
    /// Adds light of a spectrum that has come `ice_m` through ice.
    pub(crate) fn add(&mut self, spectrum: &[f64], weight: f64, ice_m: f64) {
        let n_wavelengths = self.radiance.len();
        let (below, above, share) = self.table.rows(ice_m);
        match self.carried {
            CarriedWavelengths::All => {
                let values = spectrum.iter().zip(below.iter().zip(above));
                for (sum, (value, (below, above))) in self.radiance.iter_mut().zip(values) {
                    *sum += weight * value * f64::from(below + share * (above - below));
                }
            }
            CarriedWavelengths::Some { first, step, count } => {
                let weight = weight * n_wavelengths as f64 / count as f64;
                for place in 0..count {
                    let index = (first + place * step) % n_wavelengths;
                    let passed = below[index] + share * (above[index] - below[index]);
                    self.radiance[index] += weight * spectrum[index] * f64::from(passed);
                }
            }
        }
    }

    /// Adds sunlight, as the share of its irradiance that reaches the eye, 1/sr.
    pub(crate) fn add_sun(&mut self, share_per_sr: f64, ice_m: f64) {
        let light = self.light;
        self.add(&light.sun_irradiance, share_per_sr, ice_m);
    }

    /// Adds the sky in a direction.
    pub(crate) fn add_sky(&mut self, direction: DVec3, weight: f64, ice_m: f64) {
        let light = self.light;
        if let Sky::Uniform(radiance) = &light.sky {
            self.add(radiance, weight, ice_m);
            return;
        }
        let scratch = std::mem::take(&mut self.scratch);
        scratch.fill(0.0);
        light.for_sky(direction, |part: SkyPart| part.add_to(scratch, 1.0));
        self.add(scratch, weight, ice_m);
        self.scratch = scratch;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_radiometry::Radians;

    #[test]
    fn every_choice_of_wavelengths_has_the_same_mean() {
        let absorption = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5];
        let table = TransmittanceTable::new(&absorption);
        let light = Light {
            sun_direction: DVec3::Y,
            sun_radius: Radians(0.0),
            sun_irradiance: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            sky: Sky::Uniform(vec![1.0; 6]),
        };
        let sum = |all: &[CarriedWavelengths]| {
            let mut radiance = [0.0; 6];
            for &carried in all {
                let mut sum = RadianceSum {
                    table: &table,
                    light: &light,
                    carried,
                    radiance: &mut radiance,
                    scratch: &mut [0.0; 6],
                };
                sum.add_sun(1.0, 2.0);
                sum.add_sky(DVec3::Y, 0.5, 0.0);
            }
            radiance.map(|value| value / all.len() as f64)
        };
        let all = sum(&[CarriedWavelengths::All]);
        for (step, count) in [(1, 1), (2, 3)] {
            let carried = |first| CarriedWavelengths::Some { first, step, count };
            let found = sum(&[0, 1, 2, 3, 4, 5].map(carried));
            for (found, expected) in found.iter().zip(all) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
        for (index, found) in all.iter().enumerate() {
            let expected = light.sun_irradiance[index] * (-2.0 * absorption[index]).exp() + 0.5;
            // The error of the table.
            assert!((found - expected).abs() < 3e-4);
        }
    }
}
