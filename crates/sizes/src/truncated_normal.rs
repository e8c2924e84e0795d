//! Normally distributed radii between two diameters.
//!
//! n(r) proportional to exp(-(r - m)²/(2 s²)) for d_min <= 2r <= d_max, else 0
//! `m` mean and `s` standard deviation before the cut [um].
//!
//! [`crate::Normal`] is the law that is cut at 0 only, in closed form. Between two diameters its
//! recurrence subtracts, and the moments come from quadrature instead. With v = ln(r/c), c the root
//! of c (c - m) = 3 s² where r³ n(r) has its maximum, r - m = (c - m) + c (e^v - 1).
//! [JKB94] Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions 1, 2nd ed., Wiley
//! (1994), section 13.10.1.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_positive;
use crate::truncated_moments::check_range_mm;
use crate::truncated_moments::radius_range_um;
use crate::truncated_moments::truncated_moments;

/// Radii from a normal law, cut at both ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TruncatedNormal {
    /// Mean of the law before it is cut (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_mean_um: f64,
    /// Standard deviation before it is cut (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_standard_deviation_um: f64,
    /// Smallest diameter (mm).
    #[schemars(range(min = 0.0))]
    pub d_min_mm: f64,
    /// Largest diameter (mm).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: f64,
}

impl TruncatedNormal {
    /// Check the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("radius_mean_um", self.radius_mean_um)?;
        let deviation = self.radius_standard_deviation_um;
        require_positive("radius_standard_deviation_um", deviation)?;
        check_range_mm(Some(self.d_min_mm), Some(self.d_max_mm))
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let (m, s2) = (
            self.radius_mean_um,
            self.radius_standard_deviation_um.powi(2),
        );
        let c = 0.5 * (m + (m * m + 12.0 * s2).sqrt());
        // c - m without cancellation for s << m.
        let off = 3.0 * s2 / c;
        let range = radius_range_um(Some(self.d_min_mm), Some(self.d_max_mm));
        truncated_moments(c, range, |v| {
            // (r - m)² - (c - m)² = c (e^v - 1) [2 (c - m) + c (e^v - 1)].
            let rise = c * v.exp_m1();
            3.0 * v - rise * (2.0 * off + rise) / (2.0 * s2)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Normal;
    use spec_math::NormDist;

    fn law(s: f64, d_min_mm: f64, d_max_mm: f64) -> TruncatedNormal {
        TruncatedNormal {
            radius_mean_um: 100.0,
            radius_standard_deviation_um: s,
            d_min_mm,
            d_max_mm,
        }
    }

    #[test]
    fn a_cut_at_zero_is_the_normal_law() {
        for s in [1e-4, 10.0, 60.0] {
            let found = law(s, 0.0, 10.0).moments();
            let exact = Normal {
                radius_mean_um: 100.0,
                radius_standard_deviation_um: s,
            }
            .moments();
            assert!(
                (found.mean_r_um / exact.mean_r_um - 1.0).abs() < 1e-12,
                "{s}"
            );
            assert!(
                (found.mean_r3_um3 / exact.mean_r3_um3 - 1.0).abs() < 1e-12,
                "{s}"
            );
            let ratio = found.effective_variance / exact.effective_variance;
            assert!((ratio - 1.0).abs() < 1e-8, "{s}: {ratio}");
        }
    }

    #[test]
    fn a_cut_moves_the_mean_by_the_inverse_mills_ratio() {
        // Above m - s: mean m + s phi(1)/Phi(1) (JKB94).
        let found = law(10.0, 0.18, 100.0).moments();
        let phi = (-0.5_f64).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let exact = 100.0 + 10.0 * phi / 1.0_f64.norm_cdf();
        assert!((found.mean_r_um / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_cut_in_the_far_tail_still_has_drops() {
        // 40 standard deviations out the density is e^-800; what is left hugs the end of the range.
        let found = law(1.0, 0.28, 1.0).moments();
        assert!((found.mean_r_um - 140.025).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn empty_cuts_are_refused() {
        assert!(law(1.0, 0.3, 0.2).validate().is_err());
        assert!(law(0.0, 0.1, 0.2).validate().is_err());
    }
}
