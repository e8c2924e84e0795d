//! Modified gamma law of cloud drops.
//!
//! n(r) = A r^alpha exp(-B r^gamma)
//! `r` radius [um], alpha > -1, `B` [um^-gamma], gamma > 0.
//!
//! integral r^(alpha + k) exp(-B r^gamma) dr = Gamma(a_k)/(gamma B^a_k),  a_k = (alpha + k + 1)/gamma,
//! so that `<r^k>` = B^(-k/gamma) Gamma(a_k)/Gamma(a_0).
//! [Dei69] D. Deirmendjian, Electromagnetic Scattering on Spherical Polydispersions, Elsevier (1969),
//! eq. 62; [HKS98] Hess, Koepke and Schult, Bull. Am. Meteorol. Soc. 79, 831-844 (1998), eq. 3b.

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

/// Up to here differences of ln Gamma keep v_e to 1e-9.
const LARGEST_EXPONENT: f64 = 1000.0;

/// Cloud drops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModifiedGamma {
    /// Exponent alpha, above -1, at most 1000.
    #[schemars(extend("exclusiveMinimum" = -1.0, "maximum" = 1000.0))]
    pub alpha: f64,
    /// Factor B in the exponential (um^-gamma).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub b_per_um_gamma: f64,
    /// Exponent gamma, above 0, at most 1000.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1000.0))]
    pub gamma: f64,
    /// Smallest diameter (mm); none stands for 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest diameter (mm); none stands for infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: Option<f64>,
}

impl ModifiedGamma {
    /// Drops of all diameters.
    pub fn untruncated(alpha: f64, b_per_um_gamma: f64, gamma: f64) -> Self {
        Self {
            alpha,
            b_per_um_gamma,
            gamma,
            d_min_mm: None,
            d_max_mm: None,
        }
    }

    /// Check the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("b_per_um_gamma", self.b_per_um_gamma)?;
        require_positive("gamma", self.gamma)?;
        let expected = "a number above -1 (there the number of drops diverges), at most 1000";
        for (parameter, found) in [("alpha", self.alpha), ("gamma", self.gamma)] {
            if !(found > -1.0 && found <= LARGEST_EXPONENT) {
                return Err(Error::Parameter {
                    parameter,
                    found,
                    expected,
                });
            }
        }
        check_range_mm(self.d_min_mm, self.d_max_mm)
    }

    /// A for one drop per unit of volume, that is gamma B^a_0/Gamma(a_0) (um^-(alpha + 1)).
    pub fn normalization(&self) -> f64 {
        let a_0 = (self.alpha + 1.0) / self.gamma;
        self.gamma * (a_0 * self.b_per_um_gamma.ln() - a_0.lgamma()).exp()
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let (alpha, b, gamma) = (self.alpha, self.b_per_um_gamma, self.gamma);
        if self.d_min_mm.is_none() && self.d_max_mm.is_none() {
            let ln_gamma = |k: f64| ((alpha + k + 1.0) / gamma).lgamma();
            let ln_scale = -b.ln() / gamma;
            let mean = |k: f64| (k * ln_scale + ln_gamma(k) - ln_gamma(0.0)).exp();
            return SizeMoments {
                mean_r_um: mean(1.0),
                mean_r2_um2: mean(2.0),
                mean_r3_um3: mean(3.0),
                effective_variance: (ln_gamma(4.0) - 2.0 * ln_gamma(3.0) + ln_gamma(2.0)).exp_m1(),
            };
        }
        // r³ n(r) has its maximum where B r^gamma = (alpha + 3)/gamma.
        let at_peak = (alpha + 3.0) / gamma;
        let peak_um = (at_peak / b).powf(1.0 / gamma);
        let range = radius_range_um(self.d_min_mm, self.d_max_mm);
        truncated_moments(peak_um, range, |v| -at_peak * exp_minus_linear(gamma * v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_that_takes_nothing_leaves_the_closed_forms() {
        for (alpha, b, gamma) in [(5.0, 0.938, 1.05), (8.0, 0.247, 2.15), (900.0, 90.0, 1.0)] {
            let whole = ModifiedGamma::untruncated(alpha, b, gamma);
            let cut = ModifiedGamma {
                d_min_mm: Some(1e-9),
                d_max_mm: Some(10.0),
                ..whole
            };
            let (found, exact) = (cut.moments(), whole.moments());
            // Measured worst 1e-12, in v_e 9e-10, from ln Gamma(900).
            assert!(
                (found.mean_r_um / exact.mean_r_um - 1.0).abs() < 1e-11,
                "{alpha}"
            );
            assert!(
                (found.mean_r3_um3 / exact.mean_r3_um3 - 1.0).abs() < 1e-10,
                "{alpha}"
            );
            let ratio = found.effective_variance / exact.effective_variance;
            assert!((ratio - 1.0).abs() < 1e-8, "{alpha}: {ratio}");
        }
    }

    #[test]
    fn gamma_one_is_the_gamma_law() {
        // alpha = mu, B = 2 Lambda per unit of radius: v_e = 1/(alpha + 3), r_e = (alpha + 3)/B.
        let found = ModifiedGamma::untruncated(6.0, 1.5, 1.0).moments();
        assert!((found.effective_variance - 1.0 / 9.0).abs() < 1e-14);
        assert!((found.effective_radius().0 - 6.0).abs() < 1e-13);
    }

    #[test]
    fn exponents_without_sense_are_refused() {
        for (alpha, b, gamma) in [
            (-1.0, 1.0, 1.0),
            (1.0, 0.0, 1.0),
            (1.0, 1.0, 0.0),
            (2e3, 1.0, 1.0),
        ] {
            assert!(
                ModifiedGamma::untruncated(alpha, b, gamma)
                    .validate()
                    .is_err()
            );
        }
    }
}
