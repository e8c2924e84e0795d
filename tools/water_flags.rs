//! The water of the drops by flags.

use clap::Args;
use niji_radiometry::Water;
use serde::Serialize;

use crate::failure::Failure;

/// What the drops are made of.
#[derive(Clone, Copy, Debug, Args, Serialize)]
pub(crate) struct WaterFlags {
    /// Temperature of the water.
    #[arg(
        long,
        value_name = "C",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    temperature_c: f64,
    /// Salinity of the water: 35 in the open sea.
    #[arg(long, value_name = "PER_MILLE", default_value_t = 0.0)]
    salinity_per_mille: f64,
}

impl WaterFlags {
    /// The water.
    ///
    /// # Errors
    /// As [`Water::check`].
    pub(crate) fn water(self) -> Result<Water, Failure> {
        let water = Water {
            temperature_c: self.temperature_c,
            salinity_per_mille: self.salinity_per_mille,
        };
        let sound = water.check().map(|()| water);
        sound.map_err(|error| Failure::Usage(error.to_string()))
    }
}

impl From<Water> for WaterFlags {
    fn from(water: Water) -> Self {
        Self {
            temperature_c: water.temperature_c,
            salinity_per_mille: water.salinity_per_mille,
        }
    }
}
