//! The air as a whole: which constituents it has, over which planet, under which sun.

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;

use crate::constituent::Constituent;
use crate::error::Error;
use crate::error::positive;
use crate::error::within;
use crate::phase_function::PhaseFunction;

/// Height at which air ends, m: 3.7e-6 of it lie above.
pub const USUAL_TOP_M: f64 = 100_000.0;

/// A description of the air, enough to tabulate it.
#[derive(Debug, Clone, PartialEq)]
pub struct AirModel {
    /// The planet below.
    pub planet: Planet,
    /// Height above which there is no air, m. An exponential constituent ends at 22 scale heights if that is
    /// lower, 176 km for 8 km: 3e-10 of it is above.
    pub top_height_m: f64,
    /// Wavelengths of every spectrum.
    pub wavelengths: WavelengthGrid,
    /// Brightness of the sun over that at one astronomical unit; the moon is 2.5e-6 or less.
    pub sun_scale: f64,
    /// Share of the light that the ground gives back, 0 to 1 at every wavelength.
    pub ground: Reflectance,
    /// What the air is made of; none of it is a vacuum.
    pub constituents: Vec<Constituent>,
}

impl AirModel {
    /// Tabulates the air.
    ///
    /// # Errors
    /// If a number lies outside its range, or two constituents share a name.
    pub fn tabulate(&self) -> Result<AtmosphereTable, Error> {
        let planet_radius_m = positive("planet radius", self.planet.radius_m, "m")?;
        let top_height_m = positive("top of the air", self.top_height_m, "m")?;
        let sun_scale = within("brightness of the sun", self.sun_scale, [0.0, 1e6])?;
        let ground_albedo = self.ground.on(&self.wavelengths);
        for albedo in &ground_albedo {
            within("ground albedo", *albedo, [0.0, 1.0])?;
        }
        let mut constituents = Vec::with_capacity(self.constituents.len());
        for constituent in &self.constituents {
            self.check(constituent)?;
            let table = constituent.tabulate(planet_radius_m, top_height_m)?;
            if constituents
                .iter()
                .any(|other: &niji_exchange::AirConstituent| other.name == table.name)
            {
                return Err(Error::DuplicateName { name: table.name });
            }
            constituents.push(table);
        }
        let sun = solar_irradiance(&self.wavelengths);
        Ok(AtmosphereTable {
            planet_radius_m,
            top_height_m,
            wavelengths: self.wavelengths,
            sun_irradiance: sun
                .into_iter()
                .map(|irradiance| sun_scale * irradiance)
                .collect(),
            ground_albedo,
            constituents,
            diffuse: None,
        })
    }

    /// Checks the spectra of a constituent, which may come from anywhere.
    fn check(&self, constituent: &Constituent) -> Result<(), Error> {
        let name = &constituent.name;
        // Names become names of parts and channels, joined by commas.
        if name.is_empty() || name.contains(',') {
            return Err(Error::Name { name: name.clone() });
        }
        let n_wavelengths = self.wavelengths.len() as f64;
        let mut spectra = vec![&constituent.extinction_m1, &constituent.scattering_m1];
        if let PhaseFunction::Rayleigh { king_factor } = &constituent.phase {
            spectra.push(king_factor);
        }
        for spectrum in spectra {
            let found = spectrum.len() as f64;
            within(
                "number of values of a spectrum",
                found,
                [n_wavelengths, n_wavelengths],
            )?;
        }
        let pairs = constituent
            .extinction_m1
            .iter()
            .zip(&constituent.scattering_m1);
        for (&extinction_m1, &scattering_m1) in pairs {
            within("extinction in 1/m", extinction_m1, [0.0, f64::MAX])?;
            // Rounding may put scattering a digit above.
            within(
                "scattering in 1/m",
                scattering_m1,
                [0.0, extinction_m1 * (1.0 + 1e-12)],
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use niji_exchange::DensityLaw;
    use niji_geometry::EARTH;

    use super::*;
    use crate::density_profile::DensityProfile;

    fn model(constituents: Vec<Constituent>) -> AirModel {
        AirModel {
            planet: EARTH,
            top_height_m: USUAL_TOP_M,
            wavelengths: WavelengthGrid::visible(),
            sun_scale: 1.0,
            ground: Reflectance::Even(0.2),
            constituents,
        }
    }

    fn custom(extinction_m1: f64, scattering_m1: f64) -> Constituent {
        let n = WavelengthGrid::visible().len();
        Constituent {
            name: "smoke".to_owned(),
            profile: DensityProfile::Exponential {
                scale_height_m: 500.0,
            },
            extinction_m1: vec![extinction_m1; n],
            scattering_m1: vec![scattering_m1; n],
            phase: PhaseFunction::Isotropic,
        }
    }

    #[test]
    fn the_table_holds_the_bin_means_of_the_sun() {
        let air = model(Vec::new()).tabulate().unwrap();
        assert_eq!(
            air.sun_irradiance,
            solar_irradiance(&WavelengthGrid::visible())
        );
        let moon = AirModel {
            sun_scale: 2.5e-6,
            ..model(Vec::new())
        }
        .tabulate()
        .unwrap();
        assert!((moon.sun_irradiance[7] / air.sun_irradiance[7] / 2.5e-6 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn air_that_cannot_exist_is_refused() {
        let refused = |constituent: Constituent| model(vec![constituent]).tabulate().is_err();
        assert!(!refused(custom(1e-4, 1e-4)));
        assert!(refused(custom(1e-4, 2e-4)));
        assert!(refused(custom(-1e-4, 0.0)));
        assert!(refused(custom(f64::NAN, 0.0)));
        assert!(refused(Constituent {
            name: "a,b".to_owned(),
            ..custom(1e-4, 0.0)
        }));
        assert!(refused(Constituent {
            extinction_m1: vec![1e-4],
            ..custom(1e-4, 0.0)
        }));
        let phase = PhaseFunction::Rayleigh {
            king_factor: vec![1.0],
        };
        assert!(refused(Constituent {
            phase,
            ..custom(1e-4, 0.0)
        }));
        assert!(
            AirModel {
                ground: Reflectance::Even(1.1),
                ..model(Vec::new())
            }
            .tabulate()
            .is_err()
        );
        assert!(
            AirModel {
                top_height_m: f64::NAN,
                ..model(Vec::new())
            }
            .tabulate()
            .is_err()
        );
    }

    #[test]
    fn look_ups_have_the_column_from_sea_level() {
        let tent = |bottom_m: f64| DensityProfile::Tent {
            bottom_m,
            peak_m: 900.0,
            top_m: 3e3,
        };
        let nodes = |heights_m: [f64; 2], density: [f64; 2]| DensityProfile::Tabulated {
            law: DensityLaw::Linear,
            nodes: vec![[heights_m[0], density[0]], [heights_m[1], density[1]]],
        };
        for profile in [
            nodes([2e3, 4e3], [1.0, 1.0]),
            nodes([500.0, 1500.0], [1.0, 0.0]),
            nodes([-430.0, 8e3], [1.0, 0.2]),
            tent(400.0),
            tent(-700.0),
        ] {
            let usual = custom(1e-4, 1e-4);
            let layered = usual.clone().with_column_in(profile.clone()).unwrap();
            let depth = model(vec![layered]).tabulate().unwrap();
            let found = depth.optical_depth_at(7, 0.0, 1.0);
            let expected = usual.vertical_optical_depth()[7];
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{profile:?}: {found} {expected}"
            );
        }
    }

    #[test]
    fn king_factors_of_no_molecule_are_refused() {
        let with_factor = |factor: f64| {
            let king_factor = vec![factor; WavelengthGrid::visible().len()];
            let molecules = Constituent {
                phase: PhaseFunction::Rayleigh { king_factor },
                ..custom(1e-5, 1e-5)
            };
            model(vec![molecules]).tabulate()
        };
        assert!(with_factor(1.0).is_ok() && with_factor(1.05).is_ok());
        for factor in [f64::NAN, 0.0, -5.0, 100.0, f64::INFINITY] {
            let refused = with_factor(factor);
            let is_of_factor = |what: &str| what == "King factor";
            assert!(
                matches!(refused, Err(Error::OutOfRange { what, .. }) if is_of_factor(what)),
                "{factor}: {refused:?}"
            );
        }
    }

    #[test]
    fn two_constituents_of_one_name_are_refused() {
        let twice = [1e-4, 2e-4].map(|m1| custom(m1, m1));
        let error = model(twice.to_vec()).tabulate();
        assert!(
            matches!(error, Err(Error::DuplicateName { .. })),
            "{error:?}"
        );
    }
}
