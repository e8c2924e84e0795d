//! Radii spread evenly over a range.
//!
//! n(r) = 1/(b - a) for a <= r <= b, else 0
//!
//! With the middle m = (a + b)/2 and half the width h = (b - a)/2:
//! `<r> = m`,   `<r²> = m² + h²/3`,   `<r³> = m (m² + h²)`,   `<r⁴> = m⁴ + 2 m² h² + h⁴/5`
//! v_e = h² (m⁴/3 - 2 m² h²/15 + h⁴/15)/<r³>²
//!
//! The last line is <r²><r⁴>/<r³>² - 1 with the leading terms cancelled by hand: computed from the
//! moments, v_e of a range of one part in a million would be roundoff.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_not_negative;
use crate::error::require_positive;

/// Every radius of a range is equally frequent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uniform {
    /// Smallest radius a (um); may be 0.
    #[schemars(range(min = 0.0))]
    pub radius_min_um: f64,
    /// Largest radius b (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_max_um: f64,
}

impl Uniform {
    /// Check the range.
    ///
    /// # Errors
    /// [`Error::Parameter`] if an end is negative or not finite, [`Error::EmptyRange`] if the upper
    /// end is below the lower one.
    pub fn validate(&self) -> Result<(), Error> {
        require_not_negative("radius_min_um", self.radius_min_um)?;
        require_positive("radius_max_um", self.radius_max_um)?;
        if self.radius_max_um < self.radius_min_um {
            let (min, max) = (self.radius_min_um, self.radius_max_um);
            return Err(Error::EmptyRange {
                parameter: "radius_um",
                min,
                max,
            });
        }
        Ok(())
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let m = 0.5 * (self.radius_min_um + self.radius_max_um);
        let h = 0.5 * (self.radius_max_um - self.radius_min_um);
        let (m2, h2) = (m * m, h * h);
        let mean_r3_um3 = m * (m2 + h2);
        let spread = h2 * (m2 * m2 / 3.0 - 2.0 * m2 * h2 / 15.0 + h2 * h2 / 15.0);
        SizeMoments {
            mean_r_um: m,
            mean_r2_um2: m2 + h2 / 3.0,
            mean_r3_um3,
            effective_variance: spread / mean_r3_um3.powi(2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(radius_min_um: f64, radius_max_um: f64) -> Uniform {
        Uniform {
            radius_min_um,
            radius_max_um,
        }
    }

    #[test]
    fn moments_match_the_integrals_in_40_digits() {
        // range, <r>, <r²>, <r³>, v_e from mpmath.
        let cases = [
            (
                50.0,
                150.0,
                100.0,
                10833.3333333333333,
                1250000.0,
                0.0486666666666666667,
            ),
            (
                0.0,
                100.0,
                50.0,
                3333.33333333333333,
                250000.0,
                0.0666666666666666667,
            ),
        ];
        for (min, max, r, r2, r3, v_e) in cases {
            let found = uniform(min, max).moments();
            assert!((found.mean_r_um / r - 1.0).abs() < 1e-15);
            assert!((found.mean_r2_um2 / r2 - 1.0).abs() < 1e-15);
            assert!((found.mean_r3_um3 / r3 - 1.0).abs() < 1e-15);
            assert!((found.effective_variance / v_e - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_narrow_range_keeps_its_variance() {
        // One part in a million; from the moments nothing would be left. The ends hold it to
        // 1e-14/1e-4.
        let found = uniform(100.0, 100.0001).moments().effective_variance;
        assert!(
            (found / 8.33332500000125001e-14 - 1.0).abs() < 1e-9,
            "{found:e}"
        );
        assert!(uniform(100.0, 100.0).moments().effective_variance < 1e-300);
    }

    #[test]
    fn fourth_moment_follows_from_the_variance() {
        // (b⁵ - a⁵)/(5 (b - a)) with a = 50, b = 150.
        let exact = (150.0_f64.powi(5) - 50.0_f64.powi(5)) / 500.0;
        assert!((uniform(50.0, 150.0).moments().mean_r4_um4() / exact - 1.0).abs() < 1e-14);
    }

    #[test]
    fn unsound_ranges_are_refused() {
        assert!(matches!(
            uniform(-1.0, 1.0).validate(),
            Err(Error::Parameter { .. })
        ));
        assert!(matches!(
            uniform(1.0, f64::NAN).validate(),
            Err(Error::Parameter { .. })
        ));
        assert!(matches!(
            uniform(0.0, 0.0).validate(),
            Err(Error::Parameter { .. })
        ));
        assert!(matches!(
            uniform(2.0, 1.0).validate(),
            Err(Error::EmptyRange { .. })
        ));
        assert_eq!(uniform(0.0, 1.0).validate(), Ok(()));
    }
}
