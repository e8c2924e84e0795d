//! Water vapor and oxygen: bands of lines in the red, 590, 690 (B), 720 and 760 nm (A).
//!
//! water vapor  T = exp(-0.2385 x/(1 + 20.07 x)^0.45),  x = a_w W M              (BR86, eq. 8)
//! oxygen       T = exp(-1.41 y/(1 + 118.3 y)^0.45),    y = a_u (p/p0) M         (BR86, eq. 11)
//! `a` coefficient of the band, `W` precipitable water in cm, `M` air mass: length of the path through
//! the gas over the vertical one. -ln T grows like M where a band is weak and like M^0.55 where its
//! lines are black in their middle: it is no coefficient times a length, as the table of the air and
//! whoever sums lengths want it. A sum of exponentials would fit T, but would need every wavelength
//! several times over in every sum along every ray. So the law is replaced by its chord
//!   extinction * length = M/M0 * (-ln T(M0)),
//! exact for the path M0 that matters most, that of sunlight to the ground. Shorter paths are then
//! a little too clear, longer ones a little too dark. Largest error of T from 380 to 780 nm with
//! 1.42 cm of water and p = p0, over all M0 from 1 to 35:
//!   M/M0         1/2     2/3     1    3/2     2
//!   error      0.114   0.067     0  0.067  0.114   at 720 to 770 nm
//!   < 650 nm   0.020   0.014     0  0.025  0.051   at 590 nm, vapor on the longest paths
//! The vapor has a scale height of 2000 m (usual are 2.0 to 2.4 km), the oxygen that of the air.
//! [BR86] Bird and Riordan, J. Climate Appl. Meteorol. 25, 87-97 (1986); the report of 1984 prints
//! 118.93 in the place of 118.3.

use niji_geometry::Planet;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::chapman::chapman_erfcx;
use crate::constituent::Constituent;
use crate::density_profile::DensityProfile;
use crate::error::Error;
use crate::error::positive;
use crate::error::within;
use crate::gas_absorption::Gas;
use crate::gas_absorption::absorption;
use crate::phase_function::PhaseFunction;
use crate::rayleigh_bodhaine::STANDARD_PRESSURE_PA;
use crate::rayleigh_bodhaine::equivalent_height_m;

/// Scale height of water vapor, m.
const VAPOR_HEIGHT_M: f64 = 2000.0;
/// More water than any air holds, cm.
const MOST_WATER_CM: f64 = 20.0;

/// A gas that absorbs in bands of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BandGas {
    /// Water vapor.
    WaterVapor {
        /// Water in a vertical column, cm; 1.42 is that of the US standard atmosphere.
        precipitable_cm: f64,
    },
    /// Oxygen.
    Oxygen {
        /// Pressure of the air at sea level, Pa.
        pressure_pa: f64,
    },
}

impl BandGas {
    /// Name of the constituent.
    pub fn name(self) -> &'static str {
        match self {
            Self::WaterVapor { .. } => "water-vapor",
            Self::Oxygen { .. } => "oxygen",
        }
    }

    /// Share of the light between two wavelengths that passes a path of an air mass, by the law of the
    /// band itself.
    pub fn transmittance(self, edges: (Nanometers, Nanometers), air_mass: f64) -> f64 {
        (-self.optical_depth(edges, air_mass)).exp()
    }

    /// Length of the sun's path to sea level over the vertical one; that of the level path for a sun
    /// below the horizon.
    pub fn air_mass(self, planet: Planet, cos_sun_zenith: f64) -> f64 {
        let scale_heights = planet.radius_m / self.scale_height_m();
        chapman_erfcx(scale_heights, cos_sun_zenith.clamp(0.0, 1.0))
    }

    /// The gas with the chord of its law at an air mass, averaged over the bins.
    ///
    /// # Errors
    /// If an amount lies outside its range, or the air mass is no positive number.
    pub fn constituent(
        self,
        wavelengths: &WavelengthGrid,
        air_mass: f64,
    ) -> Result<Constituent, Error> {
        match self {
            Self::WaterVapor { precipitable_cm: w } => {
                within("precipitable water in cm", w, [0.0, MOST_WATER_CM])?
            }
            Self::Oxygen { pressure_pa } => positive("pressure", pressure_pa, "Pa")?,
        };
        let air_mass = positive("air mass", air_mass, "vertical columns")?;
        let scale_height_m = self.scale_height_m();
        let extinction = |index: usize| {
            self.optical_depth(wavelengths.edges(index), air_mass) / (air_mass * scale_height_m)
        };
        Ok(Constituent {
            name: self.name().to_owned(),
            profile: DensityProfile::Exponential { scale_height_m },
            extinction_m1: (0..wavelengths.len()).map(extinction).collect(),
            scattering_m1: vec![0.0; wavelengths.len()],
            phase: PhaseFunction::Isotropic,
        })
    }

    /// -ln T (BR86, eqs. 8 and 11).
    fn optical_depth(self, edges: (Nanometers, Nanometers), air_mass: f64) -> f64 {
        match self {
            Self::WaterVapor { precipitable_cm } => {
                let x = absorption(Gas::WaterVapor, edges) * precipitable_cm * air_mass;
                0.2385 * x / (1.0 + 20.07 * x).powf(0.45)
            }
            Self::Oxygen { pressure_pa } => {
                let pressure_ratio = pressure_pa / STANDARD_PRESSURE_PA;
                let y = absorption(Gas::Oxygen, edges) * pressure_ratio * air_mass;
                1.41 * y / (1.0 + 118.3 * y).powf(0.45)
            }
        }
    }

    fn scale_height_m(self) -> f64 {
        match self {
            Self::WaterVapor { .. } => VAPOR_HEIGHT_M,
            Self::Oxygen { .. } => equivalent_height_m(),
        }
    }
}

#[cfg(test)]
mod tests {
    use niji_geometry::EARTH;

    use super::*;

    const VAPOR: BandGas = BandGas::WaterVapor {
        precipitable_cm: 1.42,
    };
    const OXYGEN: BandGas = BandGas::Oxygen {
        pressure_pa: STANDARD_PRESSURE_PA,
    };
    /// Path over the chord's own path, worst error of transmittance, the same below 650 nm.
    const CHORD_ERRORS: [[f64; 3]; 5] = [
        [0.5, 0.1141, 0.0200],
        [2.0 / 3.0, 0.0671, 0.0140],
        [1.0, 1e-12, 1e-12],
        [1.5, 0.0671, 0.0250],
        [2.0, 0.1143, 0.0510],
    ];

    fn at(nm: f64) -> (Nanometers, Nanometers) {
        (Nanometers(nm), Nanometers(nm))
    }

    /// Transmittance of a constituent over an air mass.
    fn by_chord(gas: BandGas, grid: &WavelengthGrid, chord_mass: f64, air_mass: f64) -> Vec<f64> {
        let constituent = gas.constituent(grid, chord_mass).unwrap();
        let depths = constituent.vertical_optical_depth();
        depths
            .iter()
            .map(|depth| (-depth * air_mass).exp())
            .collect()
    }

    #[test]
    fn band_transmittances_are_those_of_the_formulas() {
        // BR86, eqs. 8 and 11 in Python with the coefficients 2.5 and 4.0 of their table 1.
        for (gas, nm, air_mass, expected) in [
            (VAPOR, 724.4, 1.0, 0.8839279586),
            (VAPOR, 724.4, 5.6, 0.7262389702),
            (OXYGEN, 762.5, 1.0, 0.7029643494),
            (OXYGEN, 762.5, 35.0, 0.0826557641),
        ] {
            let found = gas.transmittance(at(nm), air_mass);
            assert!(
                (found - expected).abs() < 1e-6,
                "{nm} nm, {air_mass}: {found}"
            );
        }
    }

    #[test]
    fn the_chord_is_exact_on_its_own_path_and_has_the_stated_errors_on_others() {
        let grid = WavelengthGrid::visible();
        for [ratio, stated, stated_below] in CHORD_ERRORS {
            let (mut worst, mut worst_below) = (0.0_f64, 0.0_f64);
            for (gas, step) in [VAPOR, OXYGEN]
                .into_iter()
                .flat_map(|gas| (0..=48).map(move |step| (gas, step)))
            {
                let chord_mass = 35.0_f64.powf(f64::from(step) / 48.0);
                let air_mass = ratio * chord_mass;
                let found = by_chord(gas, &grid, chord_mass, air_mass);
                for (index, found) in found.into_iter().enumerate() {
                    let error = (found - gas.transmittance(grid.edges(index), air_mass)).abs();
                    worst = worst.max(error);
                    if grid.center(index).0 < 650.0 {
                        worst_below = worst_below.max(error);
                    }
                }
            }
            assert!(
                worst <= stated && worst_below <= stated_below,
                "{ratio}: {worst}, {worst_below}"
            );
            assert!(worst >= 0.95 * stated - 1e-11, "{ratio}: {worst}");
        }
    }

    #[test]
    fn weak_bands_obey_beer_and_thick_ones_the_power_0_55() {
        let slope = |gas: BandGas, nm: f64, air_mass: f64| {
            let ratio =
                gas.optical_depth(at(nm), 1.001 * air_mass) / gas.optical_depth(at(nm), air_mass);
            ratio.ln() / 1.001_f64.ln()
        };
        assert!((slope(VAPOR, 593.0, 1e-6) - 1.0).abs() < 1e-4);
        assert!((slope(OXYGEN, 762.5, 1e6) - 0.55).abs() < 1e-4);
    }

    #[test]
    fn the_low_sun_crosses_more_vapor_than_its_air_mass() {
        // Level path: sqrt(pi R/(2 H)) = 70.7 for vapor, 34.4 for air, to first order in H/R.
        assert!((VAPOR.air_mass(EARTH, 0.0) - 70.74).abs() < 0.05);
        assert!((OXYGEN.air_mass(EARTH, 0.0) - 34.42).abs() < 0.05);
        assert!((VAPOR.air_mass(EARTH, 1.0) - 1.0).abs() < 1e-3);
        let below = VAPOR.air_mass(EARTH, -0.1);
        assert!((below - VAPOR.air_mass(EARTH, 0.0)).abs() < 1e-12);
    }

    #[test]
    fn amounts_that_no_air_has_are_refused() {
        let grid = WavelengthGrid::visible();
        let vapor = |precipitable_cm| BandGas::WaterVapor { precipitable_cm };
        assert!(vapor(0.0).constituent(&grid, 1.0).is_ok());
        assert!(vapor(-1.0).constituent(&grid, 1.0).is_err());
        assert!(vapor(f64::NAN).constituent(&grid, 1.0).is_err());
        assert!(VAPOR.constituent(&grid, 0.0).is_err());
        let vacuum = BandGas::Oxygen { pressure_pa: 0.0 };
        assert!(vacuum.constituent(&grid, 1.0).is_err());
    }
}
