//! Normally distributed radii, cut off at r = 0.
//!
//! n(r) = exp(-(r - m)²/(2 s²))/(s sqrt(2 pi) Phi(m/s)) for r > 0, else 0
//! `m` mean and `s` standard deviation before the cut, `Phi` the normal distribution function.
//!
//! Integration by parts gives I_(k+1) = m I_k + k s² I_(k-1) for k >= 1, and at the cut
//! I_1 = m + s phi(m/s)/Phi(m/s), `phi` the normal density. With m > 0 every term is positive, so
//! that the recurrence loses nothing. The same recurrence turns the effective variance into
//! v_e = s² (3 I_2² - 2 I_1 I_3)/I_3²,
//! which stays exact for s << m, where I_2 I_4/I_3² - 1 is roundoff.
//! [JKB94] Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions 1, 2nd ed., Wiley
//! (1994), section 13.10.1.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use spec_math::NormDist;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_not_negative;
use crate::error::require_positive;

/// Radii from a normal law, of which only r > 0 is kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// Mean of the law before it is cut off (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_mean_um: f64,
    /// Standard deviation before it is cut off (um); 0 is a single size.
    #[schemars(range(min = 0.0))]
    pub radius_standard_deviation_um: f64,
}

impl Normal {
    /// Check both parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the mean is not above 0, or the standard deviation is negative, or
    /// one of them is not finite.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("radius_mean_um", self.radius_mean_um)?;
        require_not_negative(
            "radius_standard_deviation_um",
            self.radius_standard_deviation_um,
        )
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let m = self.radius_mean_um;
        let s = self.radius_standard_deviation_um;
        let i1 = m + s * ratio_of_density_to_distribution(m / s);
        let i2 = m * i1 + s * s;
        let i3 = m * i2 + 2.0 * s * s * i1;
        let spread = s * s * (3.0 * i2 * i2 - 2.0 * i1 * i3);
        SizeMoments {
            mean_r_um: i1,
            mean_r2_um2: i2,
            mean_r3_um3: i3,
            effective_variance: spread / (i3 * i3),
        }
    }
}

/// phi(x)/Phi(x) for x > 0, infinity included (a standard deviation of 0).
fn ratio_of_density_to_distribution(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    let distribution = x.norm_cdf();
    density / distribution
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(radius_mean_um: f64, radius_standard_deviation_um: f64) -> Normal {
        Normal {
            radius_mean_um,
            radius_standard_deviation_um,
        }
    }

    #[test]
    fn moments_match_quadrature_in_40_digits() {
        // mean, standard deviation, <r>, <r²>, <r³>, v_e from mpmath.
        let cases = [
            (
                100.0,
                10.0,
                100.0,
                10100.0,
                1030000.0,
                0.00942878687906494486,
            ),
            (
                100.0,
                100.0,
                128.759997093917836,
                22875.9997093917836,
                4862799.91281753508,
                0.134337658353957327,
            ),
            (
                1.0,
                50.0,
                40.2597960536119966,
                2540.259796053612,
                203839.240064113595,
                0.177236831150458549,
            ),
            (
                100.0,
                1e-4,
                100.0,
                10000.00000001,
                1000000.000003,
                9.99999999994e-13,
            ),
        ];
        for (mean, deviation, r, r2, r3, v_e) in cases {
            let found = normal(mean, deviation).moments();
            let pairs = [
                (found.mean_r_um, r),
                (found.mean_r2_um2, r2),
                (found.mean_r3_um3, r3),
                (found.effective_variance, v_e),
            ];
            for (found, expected) in pairs {
                // Measured worst 8e-16.
                assert!(
                    (found / expected - 1.0).abs() < 1e-14,
                    "{mean} {deviation}: {found}"
                );
            }
        }
    }

    #[test]
    fn no_deviation_is_a_single_size() {
        let found = normal(20.0, 0.0).moments();
        assert_eq!(
            (found.mean_r_um, found.mean_r2_um2, found.effective_variance),
            (20.0, 400.0, 0.0)
        );
    }

    #[test]
    fn a_very_wide_law_becomes_half_of_a_normal_one() {
        let found = normal(1e-9, 1.0).moments();
        assert!((found.mean_r_um - (2.0 / PI).sqrt()).abs() < 1e-8);
        assert!((found.effective_variance - (3.0 * PI / 8.0 - 1.0)).abs() < 1e-8);
    }

    #[test]
    fn unsound_parameters_are_named() {
        for (law, name) in [
            (normal(-1.0, 1.0), "radius_mean_um"),
            (normal(f64::NAN, 1.0), "radius_mean_um"),
            (normal(1.0, -0.1), "radius_standard_deviation_um"),
            (normal(1.0, f64::INFINITY), "radius_standard_deviation_um"),
        ] {
            let message = law.validate().unwrap_err().to_string();
            assert!(message.starts_with(name), "{message}");
        }
    }
}
