//! Gamma law of raindrops by shape and slope.
//!
//! N(D) = N0 D^mu exp(-Lambda D)
//! `D` drop *diameter* [mm], `mu` shape > -1, Lambda slope [1/mm]; mu = 0 is Marshall and Palmer's.
//!
//! r_e = (mu + 3)/(2 Lambda),   v_e = 1/(mu + 3): the gamma law of Hansen and Travis with
//! mu = (1 - 3b)/b, so that each law is written in one place only.
//! [Ulb83] C. W. Ulbrich, J. Climate and Applied Meteorology 22, 1764-1775 (1983), eq. 6.

use niji_radiometry::Micrometers;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::HansenTravis;
use crate::SizeMoments;
use crate::error::require_positive;

/// Raindrops of a gamma law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ulbrich {
    /// Shape mu, above -1.
    #[schemars(extend("exclusiveMinimum" = -1.0))]
    pub shape: f64,
    /// Slope Lambda (1/mm).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub slope_per_mm: f64,
    /// Smallest diameter (mm); none stands for 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest diameter (mm); none stands for infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: Option<f64>,
}

impl Ulbrich {
    /// Check the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("slope_per_mm", self.slope_per_mm)?;
        if !(self.shape.is_finite() && self.shape > -1.0) {
            return Err(Error::Parameter {
                parameter: "shape",
                found: self.shape,
                expected: "a number above -1 (there the number of drops diverges)",
            });
        }
        self.as_hansen_travis().validate()
    }

    /// The same law by effective radius and effective variance.
    pub fn as_hansen_travis(&self) -> HansenTravis {
        let mu = self.shape;
        let r_e_um = 1000.0 * (mu + 3.0) / (2.0 * self.slope_per_mm);
        HansenTravis {
            d_min_mm: self.d_min_mm,
            d_max_mm: self.d_max_mm,
            ..HansenTravis::untruncated(Micrometers(r_e_um), 1.0 / (mu + 3.0))
        }
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        self.as_hansen_travis().moments()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MarshallPalmer;

    fn law(shape: f64, slope_per_mm: f64) -> Ulbrich {
        Ulbrich {
            shape,
            slope_per_mm,
            d_min_mm: None,
            d_max_mm: None,
        }
    }

    #[test]
    fn shape_zero_is_marshall_palmer() {
        let rain = MarshallPalmer::untruncated(10.0);
        let (found, rain) = (law(0.0, rain.slope_per_mm()).moments(), rain.moments());
        assert!((found.mean_r_um / rain.mean_r_um - 1.0).abs() < 1e-14);
        assert!((found.mean_r3_um3 / rain.mean_r3_um3 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn moments_are_ratios_of_factorials() {
        // mu = 4, as in advection fog: <D^k> = (k + 4)!/4! Lambda^-k.
        let found = law(4.0, 2.0).moments();
        assert!((found.mean_r_um / (500.0 * 5.0 / 2.0) - 1.0).abs() < 1e-14);
        assert!((found.mean_r2_um2 / (500.0_f64.powi(2) * 30.0 / 4.0) - 1.0).abs() < 1e-14);
        assert!((found.mean_r3_um3 / (500.0_f64.powi(3) * 210.0 / 8.0) - 1.0).abs() < 1e-14);
        assert!((found.effective_variance - 1.0 / 7.0).abs() < 1e-15);
    }

    #[test]
    fn a_huge_shape_is_a_single_size() {
        let found = law(1e12, 1e12).moments();
        assert!((found.mean_r_um / 500.0 - 1.0).abs() < 1e-11);
        assert!((found.effective_variance * 1e12 - 1.0).abs() < 1e-11);
    }

    #[test]
    fn shapes_with_infinitely_many_drops_are_refused() {
        for shape in [-1.0, -3.0, f64::NAN] {
            assert!(law(shape, 1.0).validate().is_err());
        }
        assert!(law(0.0, 0.0).validate().is_err());
    }
}
