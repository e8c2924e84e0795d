//! Marshall-Palmer rain by what a radar measures.
//!
//! Z = 720 N0/Lambda⁷,   dBZ = 10 log10 Z
//! `Z` radar reflectivity factor [mm⁶/m³] of drops of all diameters, `N0` and Lambda as in
//! [`crate::MarshallPalmer`]. The largest drops carry Z: a radar sees 35.0 dBZ in rain of 5 mm/h.
//! [MP48] Marshall and Palmer, J. Meteorology 5, 165-166 (1948), eq. 4.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::MarshallPalmer;
use crate::SizeMoments;

/// Reflectivities that are read (dBZ): rain has 10 to 60, the law itself knows no limit.
const REFLECTIVITY_RANGE_DBZ: std::ops::RangeInclusive<f64> = -100.0..=80.0;

/// Raindrops of natural rain, by radar reflectivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarshallPalmerDbz {
    /// Radar reflectivity of the drops before any cut (dBZ).
    #[schemars(range(min = -100.0, max = 80.0))]
    pub reflectivity_dbz: f64,
    /// Smallest diameter D1 (mm); none stands for 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest diameter D2 (mm); none stands for infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: Option<f64>,
}

impl MarshallPalmerDbz {
    /// Check the reflectivity and the range of diameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        if !REFLECTIVITY_RANGE_DBZ.contains(&self.reflectivity_dbz) {
            return Err(Error::Parameter {
                parameter: "reflectivity_dbz",
                found: self.reflectivity_dbz,
                expected: "a number from -100 to 80",
            });
        }
        self.as_marshall_palmer().validate()
    }

    /// The same law by rain rate.
    pub fn as_marshall_palmer(&self) -> MarshallPalmer {
        MarshallPalmer {
            d_min_mm: self.d_min_mm,
            d_max_mm: self.d_max_mm,
            ..MarshallPalmer::from_reflectivity_dbz(self.reflectivity_dbz)
        }
    }

    /// Drops per cubic metre, which the law fixes by itself.
    pub fn number_density_m3(&self) -> f64 {
        self.as_marshall_palmer().number_density_m3()
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        self.as_marshall_palmer().moments()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rain(reflectivity_dbz: f64) -> MarshallPalmerDbz {
        MarshallPalmerDbz {
            reflectivity_dbz,
            d_min_mm: None,
            d_max_mm: None,
        }
    }

    #[test]
    fn the_radar_sees_the_rain_it_was_made_from() {
        for dbz in [-20.0, 35.0, 60.0] {
            let found = rain(dbz).as_marshall_palmer().reflectivity_dbz();
            assert!((found - dbz).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn steady_rain_of_five_millimetres_an_hour_has_35_dbz() {
        // Z = 296 R^1.47, the power law of the same two constants.
        let dbz = 10.0 * (296.0 * 5.0_f64.powf(1.47)).log10();
        assert!((dbz - 34.988).abs() < 1e-3);
        // The power law is rounded to three digits: measured 5.6e-4.
        let rate = rain(dbz).as_marshall_palmer().rain_rate_mm_h;
        assert!((rate / 5.0 - 1.0).abs() < 2e-3, "{rate}");
    }

    #[test]
    fn a_reflectivity_without_rain_is_refused() {
        assert!(rain(f64::NAN).validate().is_err() && rain(1e3).validate().is_err());
        let empty = MarshallPalmerDbz {
            d_min_mm: Some(3.0),
            d_max_mm: Some(2.0),
            ..rain(40.0)
        };
        assert!(matches!(empty.validate(), Err(Error::EmptyRange { .. })));
    }
}
