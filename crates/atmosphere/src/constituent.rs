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
    /// Air molecules, which absorb nothing, by wavelength: scattering at sea level (1/m) and King
    /// factor.
    pub(crate) fn molecules(
        scattering_m1: Vec<f64>,
        king_factor: Vec<f64>,
        scale_height_m: f64,
    ) -> Self {
        Self {
            name: "rayleigh".to_owned(),
            profile: DensityProfile::Exponential { scale_height_m },
            extinction_m1: scattering_m1.clone(),
            scattering_m1,
            phase: PhaseFunction::Rayleigh { king_factor },
        }
    }

    /// Optical depth from sea level straight up by wavelength, without an upper end.
    pub fn vertical_optical_depth(&self) -> Vec<f64> {
        let length_m = self.profile.vertical_length_m();
        self.extinction_m1
            .iter()
            .map(|extinction_m1| extinction_m1 * length_m)
            .collect()
    }

    /// As much of it in a vertical column, spread over other heights.
    ///
    /// # Errors
    /// If the profile is none that air can have, or empty.
    pub fn with_column_in(self, profile: DensityProfile) -> Result<Self, Error> {
        let ratio = self.profile.vertical_length_m() / profile.vertical_length_m();
        self.scaled(ratio, profile)
    }

    /// As dense at sea level, spread over other heights.
    ///
    /// # Errors
    /// If the profile is none that air can have, or empty at sea level.
    pub fn with_ground_density_in(self, profile: DensityProfile) -> Result<Self, Error> {
        let ratio = self.profile.at_sea_level() / profile.at_sea_level();
        self.scaled(ratio, profile)
    }

    fn scaled(self, ratio: f64, profile: DensityProfile) -> Result<Self, Error> {
        profile.nodes(f64::INFINITY)?;
        if !ratio.is_finite() {
            let problem = "no density found where the amount is given".to_owned();
            return Err(Error::Profile { problem });
        }
        let times_ratio =
            |spectrum: Vec<f64>| spectrum.into_iter().map(|value| ratio * value).collect();
        Ok(Self {
            name: self.name,
            profile,
            extinction_m1: times_ratio(self.extinction_m1),
            scattering_m1: times_ratio(self.scattering_m1),
            phase: self.phase,
        })
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

#[cfg(test)]
mod tests {
    use niji_exchange::DensityLaw;
    use niji_radiometry::WavelengthGrid;

    use super::*;
    use crate::aerosol::AerosolKind;

    /// Haze that is well mixed up to 1 km and ends at 1.5 km.
    fn mixed() -> DensityProfile {
        DensityProfile::Tabulated {
            law: DensityLaw::Linear,
            nodes: vec![[0.0, 0.5], [1000.0, 0.5], [1500.0, 0.0]],
        }
    }

    fn haze() -> Constituent {
        let grid = WavelengthGrid::visible();
        AerosolKind::Rural.aerosol().constituent(&grid).unwrap()
    }

    #[test]
    fn another_profile_keeps_the_column_or_the_density_at_the_ground() {
        let column = haze().with_column_in(mixed()).unwrap();
        let depths = column.vertical_optical_depth().into_iter();
        for (found, before) in depths.zip(haze().vertical_optical_depth()) {
            assert!((found / before - 1.0).abs() < 1e-14);
        }
        let ground = haze().with_ground_density_in(mixed()).unwrap();
        for (found, before) in ground.extinction_m1.iter().zip(haze().extinction_m1) {
            assert!((0.5 * found / before - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn an_exponential_in_nodes_is_the_exponential() {
        let nodes = (0..=50).map(|i| 900.0 * f64::from(i));
        let nodes = nodes.map(|h| [h, 3.0 * (-h / 2100.0).exp()]).collect();
        let law = DensityLaw::Exponential;
        let profile = DensityProfile::Tabulated { law, nodes };
        let found = haze().with_column_in(profile).unwrap();
        assert!((3.0 * found.extinction_m1[0] / haze().extinction_m1[0] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn a_layer_aloft_has_no_density_at_the_ground_to_keep() {
        let aloft = DensityProfile::Tabulated {
            law: DensityLaw::Linear,
            nodes: vec![[0.0, 0.0], [2000.0, 1.0], [3000.0, 0.0]],
        };
        assert!(haze().with_column_in(aloft.clone()).is_ok());
        assert!(haze().with_ground_density_in(aloft).is_err());
        let empty = DensityProfile::Tabulated {
            law: DensityLaw::Linear,
            nodes: vec![[0.0, 0.0], [2000.0, 0.0]],
        };
        assert!(haze().with_column_in(empty).is_err());
    }
}
