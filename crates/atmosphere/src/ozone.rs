//! Ozone: the Chappuis band takes 2 to 4 % of yellow and orange light per air mass and keeps the sky
//! of twilight blue.
//!
//! tau = a(lambda) U,  U column in atm cm = 1000 Dobson units
//! a(lambda) absorption coefficient of SPCTRAL2 [BR86], averaged over the bins. Against laboratory
//! cross sections at 223 K it is 7 % low at 550 nm and 15 % low at 600 nm (0.005 in optical depth).
//! The layer is a tent from 10 over 25 to 40 km: its slant factor is not that of the air below.
//! [BR86] Bird and Riordan, J. Climate Appl. Meteorol. 25, 87-97 (1986), table 1.

use niji_radiometry::WavelengthGrid;

use crate::constituent::Constituent;
use crate::density_profile::DensityProfile;
use crate::error::Error;
use crate::error::within;
use crate::gas_absorption::Gas;
use crate::gas_absorption::absorption;
use crate::phase_function::PhaseFunction;

/// Dobson units in one atm cm.
const DOBSON_PER_ATM_CM: f64 = 1000.0;
/// Absurdly many Dobson units, ten times a usual column.
const MOST_DOBSON: f64 = 10_000.0;

/// A layer of ozone that only absorbs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OzoneLayer {
    /// Vertical column, Dobson units.
    pub column_dobson: f64,
    /// Bottom, peak and top of the tent, m.
    heights_m: [f64; 3],
}

impl OzoneLayer {
    /// A column at the usual heights, a tent from 10 over 25 to 40 km.
    pub fn of_column(column_dobson: f64) -> Self {
        Self {
            column_dobson,
            heights_m: [10e3, 25e3, 40e3],
        }
    }

    /// The layer on a grid of wavelengths, averaged over the bins.
    ///
    /// # Errors
    /// If the column is negative or above 10000 Dobson units, or the heights do not rise.
    pub fn constituent(&self, wavelengths: &WavelengthGrid) -> Result<Constituent, Error> {
        let column_dobson = within(
            "ozone column in Dobson units",
            self.column_dobson,
            [0.0, MOST_DOBSON],
        )?;
        let [bottom_m, peak_m, top_m] = self.heights_m;
        let rises = bottom_m < peak_m && peak_m < top_m;
        if !rises {
            let problem = format!(
                "ozone from {bottom_m} over {peak_m} to {top_m} m found, expected rising heights"
            );
            return Err(Error::Profile { problem });
        }
        let profile = DensityProfile::Tent {
            bottom_m,
            peak_m,
            top_m,
        };
        let column_over_length = column_dobson / DOBSON_PER_ATM_CM / profile.vertical_length_m();
        let extinction =
            |index: usize| column_over_length * absorption(Gas::Ozone, wavelengths.edges(index));
        Ok(Constituent {
            name: "ozone".to_owned(),
            profile,
            extinction_m1: (0..wavelengths.len()).map(extinction).collect(),
            scattering_m1: vec![0.0; wavelengths.len()],
            phase: PhaseFunction::Isotropic,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ozone(grid: &WavelengthGrid, column_dobson: f64) -> Result<Constituent, Error> {
        OzoneLayer::of_column(column_dobson).constituent(grid)
    }

    #[test]
    fn a_usual_column_takes_two_to_four_percent_of_yellow_light() {
        let grid = WavelengthGrid::new(550.0, 10.0, 7).unwrap();
        for depth in ozone(&grid, 300.0).unwrap().vertical_optical_depth() {
            assert!((0.02..0.045).contains(&depth), "{depth}");
        }
    }

    #[test]
    fn blue_light_passes() {
        let grid = WavelengthGrid::new(400.0, 10.0, 4).unwrap();
        for depth in ozone(&grid, 300.0).unwrap().vertical_optical_depth() {
            assert!(depth < 1e-12);
        }
    }

    #[test]
    fn no_ozone_is_allowed_and_negative_ozone_is_not() {
        let grid = WavelengthGrid::visible();
        assert!(ozone(&grid, 0.0).is_ok());
        assert!(ozone(&grid, -1.0).is_err());
        assert!(ozone(&grid, f64::NAN).is_err());
    }

    #[test]
    fn a_layer_of_other_heights_has_the_same_column() {
        let grid = WavelengthGrid::visible();
        let usual = ozone(&grid, 300.0).unwrap();
        let higher = OzoneLayer {
            column_dobson: 300.0,
            heights_m: [15e3, 22e3, 50e3],
        };
        let higher = higher.constituent(&grid).unwrap();
        for (usual, higher) in usual
            .vertical_optical_depth()
            .into_iter()
            .zip(higher.vertical_optical_depth())
        {
            assert!((usual - higher).abs() < 1e-15);
        }
        let upside_down = OzoneLayer {
            column_dobson: 300.0,
            heights_m: [40e3, 25e3, 10e3],
        };
        assert!(upside_down.constituent(&grid).is_err());
    }
}
