//! Drops of a spray by share of the water.
//!
//! Q(D) = 1 - exp(-(D/X)^n)
//! `Q` share of the water in drops up to the diameter `D` [mm], `X` characteristic diameter [mm],
//! `n` spread. Number per diameter: proportional to D^(n - 4) exp(-(D/X)^n).
//!
//! r_e = X/(2 Gamma(1 - 1/n)),   v_e = (pi/n)/sin(pi/n) - 1,
//! `<D^k>` = X^k Gamma(1 + (k - 3)/n)/Gamma(1 - 3/n).
//! The number of drops diverges at small diameters for n <= 3 and their area for n <= 1: without a
//! smallest diameter such laws are refused. v_e is below 1/2 from n = 2.11 on.
//! [RR33] Rosin and Rammler, J. Institute of Fuel 7, 29-36 (1933); [LM17] Lefebvre and McDonell,
//! Atomization and Sprays, 2nd ed., CRC (2017), section 3.4.3.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use spec_math::Gamma;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_positive;
use crate::truncated_moments::check_range_mm;
use crate::truncated_moments::exp_minus_linear;
use crate::truncated_moments::radius_range_um;
use crate::truncated_moments::truncated_moments;

/// Spread up to which the closed form of v_e, of the order 1/n², keeps 12 digits.
const LARGEST_SPREAD: f64 = 100.0;

/// Drops of a spray.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RosinRammler {
    /// Characteristic diameter X: 63 % of the water is in smaller drops (mm).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub diameter_mm: f64,
    /// Spread n; sprays have 1.5 to 4.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 100.0))]
    pub spread: f64,
    /// Smallest diameter (mm); required for n <= 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest diameter (mm); none stands for infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: Option<f64>,
}

impl RosinRammler {
    /// Check the parameters.
    ///
    /// # Errors
    /// [`Error::AreaDiverges`] for n <= 1 and [`Error::NumberDiverges`] for n <= 3 without a smallest
    /// diameter; [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("diameter_mm", self.diameter_mm)?;
        let spread = self.spread;
        if !(spread > 0.0 && spread <= LARGEST_SPREAD) {
            return Err(Error::Parameter {
                parameter: "spread",
                found: spread,
                expected: "a number above 0, at most 100",
            });
        }
        check_range_mm(self.d_min_mm, self.d_max_mm)?;
        let cut = self.d_min_mm.is_some_and(|min| min > 0.0);
        if cut || spread > 3.0 {
            Ok(())
        } else if spread > 1.0 {
            Err(Error::NumberDiverges { spread })
        } else {
            Err(Error::AreaDiverges { spread })
        }
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let (x, n) = (500.0 * self.diameter_mm, self.spread);
        if self.d_min_mm.is_none() && self.d_max_mm.is_none() {
            let weighted = |k: f64| (1.0 + (k - 3.0) / n).lgamma().exp();
            let number = weighted(0.0);
            return SizeMoments {
                mean_r_um: x * weighted(1.0) / number,
                mean_r2_um2: x.powi(2) * weighted(2.0) / number,
                mean_r3_um3: x.powi(3) / number,
                effective_variance: (PI / n) / (PI / n).sin() - 1.0,
            };
        }
        // r² n(r) r = r^(n - 1) e^(-(r/x)^n); its peak, for n > 1, is at (1 - 1/n)^(1/n) x.
        let range = radius_range_um(self.d_min_mm, self.d_max_mm);
        if n > 1.5 {
            let at_peak = (n - 1.0) / n;
            let peak = x * at_peak.powf(1.0 / n);
            truncated_moments(peak, range, |v| -at_peak * exp_minus_linear(n * v))
        } else {
            truncated_moments(x, range, |v| (n - 1.0) * v - (n * v).exp())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(spread: f64, d_min_mm: Option<f64>) -> RosinRammler {
        RosinRammler {
            diameter_mm: 1.0,
            spread,
            d_min_mm,
            d_max_mm: d_min_mm.map(|_| 100.0),
        }
    }

    #[test]
    fn the_cut_law_joins_the_whole_one() {
        for spread in [3.5, 6.0, 40.0] {
            let (whole, cut) = (
                law(spread, None).moments(),
                law(spread, Some(1e-9)).moments(),
            );
            // What is below 1 nm: (1e-9)^0.5 of the number at n = 3.5.
            let missing = 3.0 * 1e-9_f64.powf(spread - 3.0) + 1e-12;
            assert!(
                (cut.mean_r2_um2 / whole.mean_r2_um2 - 1.0).abs() < missing,
                "{spread}"
            );
            let (found, exact) = (cut.effective_variance, whole.effective_variance);
            assert!((found / exact - 1.0).abs() < 1e-10, "{spread}");
        }
    }

    #[test]
    fn sauter_diameters_follow_the_gamma_function() {
        // n = 2: SMD = X/Gamma(1/2) = X/sqrt(pi) (LM17); v_e = pi/2 - 1, the smallest drops hardly count.
        let found = law(2.0, Some(1e-7)).moments();
        let smd_um = 2.0 * found.effective_radius().0;
        assert!((smd_um / (1000.0 / PI.sqrt()) - 1.0).abs() < 1e-6);
        assert!((found.effective_variance - (0.5 * PI - 1.0)).abs() < 1e-6);
    }

    #[test]
    fn laws_with_infinitely_many_drops_are_refused_by_name() {
        assert_eq!(
            law(3.0, None).validate(),
            Err(Error::NumberDiverges { spread: 3.0 })
        );
        assert_eq!(
            law(1.0, None).validate(),
            Err(Error::AreaDiverges { spread: 1.0 })
        );
        assert_eq!(law(3.0, Some(0.01)).validate(), Ok(()));
        assert_eq!(law(3.01, None).validate(), Ok(()));
        assert!(law(f64::NAN, Some(0.1)).validate().is_err());
    }
}
