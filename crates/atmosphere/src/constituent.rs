//! One constituent of the air: a density profile, two spectra and a phase function.

use ndarray::Array2;
use niji_exchange::AirConstituent;
use niji_radiometry::Radians;

use crate::density_profile::DensityProfile;
use crate::error::Error;
use crate::phase_function::PhaseFunction;
use crate::reach_table::fill_reaches;

/// Scattering angles of the tabulated phase function: steps of 0.5 degrees, in which the sharpest
/// lobe that is allowed (g = 0.95, half a degree wide at g = 0.99) is interpolated to 1e-4 and
/// Rayleigh's to 1e-9.
const N_ANGLES: usize = 361;

/// One constituent, before it is tabulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Constituent {
    /// Name, unique within the air.
    pub name: String,
    /// Relative density by height.
    pub profile: DensityProfile,
    /// Extinction by wavelength where the relative density is 1, 1/m.
    pub extinction_m1: Vec<f64>,
    /// Scattering by wavelength where the relative density is 1, 1/m.
    pub scattering_m1: Vec<f64>,
    /// Where the scattered light goes.
    pub phase: PhaseFunction,
}

impl Constituent {
    /// Optical depth from sea level straight up by wavelength, without an upper end.
    pub fn vertical_optical_depth(&self) -> Vec<f64> {
        let length_m = self.profile.vertical_length_m();
        self.extinction_m1
            .iter()
            .map(|extinction_m1| extinction_m1 * length_m)
            .collect()
    }

    /// Tabulates profile, columns and phase function for a planet and a top of the air.
    pub(crate) fn tabulate(
        &self,
        planet_radius_m: f64,
        top_height_m: f64,
    ) -> Result<AirConstituent, Error> {
        self.phase.check()?;
        let nodes = self.profile.nodes(top_height_m)?;
        let n_wavelengths = self.extinction_m1.len();
        let last = (N_ANGLES - 1) as f64;
        let phase_angle_rad: Vec<f64> = (0..N_ANGLES)
            .map(|i| std::f64::consts::PI * (i as f64 / last))
            .collect();
        let phase_sr1 = Array2::from_shape_fn((n_wavelengths, N_ANGLES), |(wavelength, angle)| {
            self.phase.at(wavelength, Radians(phase_angle_rad[angle]))
        });
        let mut air = AirConstituent {
            name: self.name.clone(),
            extinction_m1: self.extinction_m1.clone(),
            scattering_m1: self.scattering_m1.clone(),
            law: nodes.law,
            height_m: nodes.height_m,
            density: nodes.density,
            reach_height_m: Vec::new(),
            reach_mu: Vec::new(),
            reach_m: Array2::zeros((0, 0)),
            phase_angle_rad,
            phase_sr1,
        };
        fill_reaches(&mut air, planet_radius_m);
        Ok(air)
    }
}
