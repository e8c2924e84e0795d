//! The air as a whole: which constituents it has, over which planet, under which sun.

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;

use crate::aerosol::Aerosol;
use crate::constituent::Constituent;
use crate::error::Error;
use crate::error::positive;
use crate::error::within;
use crate::ozone::ozone;
use crate::rayleigh_bodhaine::STANDARD_PRESSURE_PA;
use crate::rayleigh_bodhaine::rayleigh_bodhaine;
use crate::rayleigh_nishita::rayleigh_nishita;

/// Height at which air ends, m: 3.7e-6 of it lie above.
pub const USUAL_TOP_M: f64 = 100_000.0;

/// Something the air is made of, by its usual parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum AirComponent {
    /// Air molecules with the constants of computer graphics.
    RayleighNishita,
    /// Air molecules as measured.
    RayleighBodhaine {
        /// Pressure at sea level, Pa.
        pressure_pa: f64,
    },
    /// A layer of ozone.
    Ozone {
        /// Vertical column, Dobson units; 300 is usual.
        column_dobson: f64,
    },
    /// Haze.
    Aerosol(Aerosol),
    /// Anything else, by its own spectra and profile.
    Custom(Constituent),
}

/// A description of the air, enough to tabulate it.
#[derive(Debug, Clone, PartialEq)]
pub struct AirModel {
    /// The planet below.
    pub planet: Planet,
    /// Height above which there is no air, m.
    pub top_height_m: f64,
    /// Wavelengths of every spectrum.
    pub wavelengths: WavelengthGrid,
    /// Brightness of the sun over that at one astronomical unit; the moon is 2.5e-6 or less.
    pub sun_scale: f64,
    /// Share of the light that the ground gives back, 0 to 1.
    pub ground_albedo: f64,
    /// What the air is made of; none of it is a vacuum.
    pub components: Vec<AirComponent>,
}

impl AirComponent {
    /// Air molecules as measured, at standard pressure.
    pub const STANDARD_RAYLEIGH: Self = Self::RayleighBodhaine {
        pressure_pa: STANDARD_PRESSURE_PA,
    };

    /// The component on a grid of wavelengths.
    ///
    /// # Errors
    /// If a parameter lies outside its range.
    pub fn constituent(&self, wavelengths: &WavelengthGrid) -> Result<Constituent, Error> {
        match self {
            Self::RayleighNishita => Ok(rayleigh_nishita(wavelengths)),
            Self::RayleighBodhaine { pressure_pa } => {
                let pressure_pa = positive("pressure", *pressure_pa, "Pa")?;
                Ok(rayleigh_bodhaine(wavelengths, pressure_pa))
            }
            Self::Ozone { column_dobson } => ozone(wavelengths, *column_dobson),
            Self::Aerosol(aerosol) => aerosol.constituent(wavelengths),
            Self::Custom(constituent) => Ok(constituent.clone()),
        }
    }
}

impl AirModel {
    /// Tabulates the air.
    ///
    /// # Errors
    /// If a number lies outside its range, or two components share a name.
    pub fn tabulate(&self) -> Result<AtmosphereTable, Error> {
        let planet_radius_m = positive("planet radius", self.planet.radius_m, "m")?;
        let top_height_m = positive("top of the air", self.top_height_m, "m")?;
        let sun_scale = within("brightness of the sun", self.sun_scale, [0.0, 1e6])?;
        let albedo = within("ground albedo", self.ground_albedo, [0.0, 1.0])?;
        let mut constituents = Vec::with_capacity(self.components.len());
        for component in &self.components {
            let constituent = component.constituent(&self.wavelengths)?;
            self.check(&constituent)?;
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
            ground_albedo: vec![albedo; self.wavelengths.len()],
            constituents,
        })
    }

    /// Checks the spectra of a constituent, which may come from anywhere.
    fn check(&self, constituent: &Constituent) -> Result<(), Error> {
        let n_wavelengths = self.wavelengths.len() as f64;
        for spectrum in [&constituent.extinction_m1, &constituent.scattering_m1] {
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
