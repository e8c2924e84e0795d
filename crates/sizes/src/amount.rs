//! How many drops there are, said in one of three ways.
//!
//! N = LWC/((4/3) pi rho_w <r³>)     from liquid water [g/m³]
//! N = sigma/(2 pi <r²>)             from the extinction at Q = 2 [1/m]
//! `N` number density [1/m³]. A law of many small drops has a number that no picture shows; water or
//! extinction say more.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_not_negative;

/// How much of a size law a cubic metre holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Amount {
    /// Drops per cubic metre (1/m³).
    #[serde(rename = "number_density_m3")]
    NumberDensity(f64),
    /// Liquid water content (g/m³).
    #[serde(rename = "lwc_g_m3")]
    LiquidWater(f64),
    /// Extinction at Q = 2 (1/m).
    #[serde(rename = "extinction_m1")]
    Extinction(f64),
}

impl Amount {
    /// Check that the amount is a finite number not below 0.
    ///
    /// # Errors
    /// [`Error::Parameter`], naming the amount.
    pub fn validate(&self) -> Result<(), Error> {
        match *self {
            Self::NumberDensity(found) => require_not_negative("number_density_m3", found),
            Self::LiquidWater(found) => require_not_negative("lwc_g_m3", found),
            Self::Extinction(found) => require_not_negative("extinction_m1", found),
        }
    }

    /// Drops per cubic metre (1/m³) of a law with these moments.
    pub fn number_density_m3(&self, moments: &SizeMoments) -> f64 {
        let one = moments.bulk_properties(1.0);
        match *self {
            Self::NumberDensity(number) => number,
            Self::LiquidWater(water) => water / one.lwc_g_m3,
            Self::Extinction(extinction) => extinction / one.extinction_m1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CloudPreset;

    #[test]
    fn the_three_ways_say_the_same() {
        let moments = CloudPreset::Fog.law().moments();
        let bulk = moments.bulk_properties(1.5e7);
        for amount in [
            Amount::NumberDensity(1.5e7),
            Amount::LiquidWater(bulk.lwc_g_m3),
            Amount::Extinction(bulk.extinction_m1),
        ] {
            assert!((amount.number_density_m3(&moments) / 1.5e7 - 1.0).abs() < 1e-14);
        }
        assert!(Amount::LiquidWater(-1.0).validate().is_err());
    }

    #[test]
    fn an_amount_is_written_with_its_unit() {
        let text = serde_json::to_string(&Amount::LiquidWater(0.2)).unwrap();
        assert_eq!(text, r#"{"lwc_g_m3":0.2}"#);
    }
}
