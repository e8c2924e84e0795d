//! Lognormal radii.
//!
//! n(r) = exp(-(ln r - ln r_g)²/(2 s²))/(s r sqrt(2 pi)),   s = ln sigma_g
//! `r_g` median radius [um], sigma_g geometric standard deviation, 1 is a single size.
//!
//! `<r^k>` = r_g^k exp(k² s²/2),   r_e = r_g exp(5 s²/2),   v_e = exp(s²) - 1. From sigma_g = 1.89 on
//! v_e exceeds 1/2, more than a gamma law can have: see [`SizeMoments::with_variance_at_most`].
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eqs. 2.60 to 2.62.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_positive;
use crate::truncated_moments::check_range_mm;
use crate::truncated_moments::radius_range_um;
use crate::truncated_moments::truncated_moments;

/// Largest geometric standard deviation: <r⁴> stays a finite number.
const LARGEST_DEVIATION: f64 = 100.0;

/// Drops whose logarithm of radius is normally distributed.
///
/// ```
/// use niji_sizes::Lognormal;
///
/// // r_e = r_g exp(5/2 ln^2 sigma_g).
/// let spray = Lognormal {
///     radius_median_um: 10.0,
///     geometric_standard_deviation: 2.0,
///     d_min_mm: None,
///     d_max_mm: None,
/// };
/// let expected_um = 10.0 * (2.5 * 2_f64.ln().powi(2)).exp();
/// assert!((spray.moments().effective_radius().0 - expected_um).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lognormal {
    /// Median radius r_g before any cut (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_median_um: f64,
    /// Geometric standard deviation sigma_g, above 1.
    #[schemars(extend("exclusiveMinimum" = 1.0, "maximum" = 100.0))]
    pub geometric_standard_deviation: f64,
    /// Smallest diameter (mm); none stands for 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest diameter (mm); none stands for infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub d_max_mm: Option<f64>,
}

impl Lognormal {
    /// Check the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("radius_median_um", self.radius_median_um)?;
        let deviation = self.geometric_standard_deviation;
        if !(deviation > 1.0 && deviation <= LARGEST_DEVIATION) {
            return Err(Error::Parameter {
                parameter: "geometric_standard_deviation",
                found: deviation,
                expected: "a number above 1, at most 100 (use monodisperse for a single size)",
            });
        }
        check_range_mm(self.d_min_mm, self.d_max_mm)
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let r_g = self.radius_median_um;
        let s2 = self.geometric_standard_deviation.ln().powi(2);
        if self.d_min_mm.is_none() && self.d_max_mm.is_none() {
            return SizeMoments {
                mean_r_um: r_g * (0.5 * s2).exp(),
                mean_r2_um2: r_g.powi(2) * (2.0 * s2).exp(),
                mean_r3_um3: r_g.powi(3) * (4.5 * s2).exp(),
                effective_variance: s2.exp_m1(),
            };
        }
        // r² n(r) r is a normal law in ln r around ln r_g + 2 s².
        let range = radius_range_um(self.d_min_mm, self.d_max_mm);
        truncated_moments(r_g * (2.0 * s2).exp(), range, |v| -v * v / (2.0 * s2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spec_math::NormDist;

    fn law(deviation: f64, d_mm: Option<(f64, f64)>) -> Lognormal {
        Lognormal {
            radius_median_um: 50.0,
            geometric_standard_deviation: deviation,
            d_min_mm: d_mm.map(|(min, _)| min),
            d_max_mm: d_mm.map(|(_, max)| max),
        }
    }

    #[test]
    fn a_cut_has_the_moments_of_the_error_function() {
        // <r^k> over r1..r2 = r_g^k e^(k² s²/2) [Phi(x2 - k s) - Phi(x1 - k s)] / [Phi(x2) - Phi(x1)].
        let s = 2.0_f64.ln();
        let x = |diameter_mm: f64| (500.0 * diameter_mm / 50.0).ln() / s;
        let share = |k: f64| (x(0.6) - k * s).norm_cdf() - (x(0.02) - k * s).norm_cdf();
        let exact = |k: i32| {
            let k_ = f64::from(k);
            50.0_f64.powi(k) * (0.5 * k_ * k_ * s * s).exp() * share(k_) / share(0.0)
        };
        let found = law(2.0, Some((0.02, 0.6))).moments();
        // Measured worst 7e-16.
        assert!((found.mean_r_um / exact(1) - 1.0).abs() < 1e-13);
        assert!((found.mean_r2_um2 / exact(2) - 1.0).abs() < 1e-13);
        assert!((found.mean_r3_um3 / exact(3) - 1.0).abs() < 1e-13);
        assert!((found.mean_r4_um4() / exact(4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn fifteen_percent_of_spread_is_a_variance_of_two_percent() {
        // s = 0.15, as fog bows are often drawn with: v_e = e^0.0225 - 1 = 0.02276.
        let found = law(0.15_f64.exp(), None).moments();
        assert!((found.effective_variance - 0.022755).abs() < 1e-6);
        assert!((found.effective_radius().0 / (50.0 * 0.05625_f64.exp()) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_narrow_law_is_a_single_size() {
        let found = law(1.0 + 1e-7, None).moments();
        assert!((found.effective_variance / 1e-14 - 1.0).abs() < 1e-6);
        let cut = law(1.0 + 1e-7, Some((1e-6, 1.0))).moments();
        assert!((cut.effective_variance / found.effective_variance - 1.0).abs() < 1e-7);
    }

    #[test]
    fn deviations_without_sense_are_refused() {
        for deviation in [1.0, 0.5, f64::NAN, 1e3] {
            assert!(law(deviation, None).validate().is_err());
        }
    }
}
