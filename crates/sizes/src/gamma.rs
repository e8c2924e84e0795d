//! The gamma law by effective radius and effective variance.
//!
//! n(r) = C r^((1 - 3b)/b) exp(-r/(a b))
//! `a` effective radius, `b` effective variance, 0 < b < 1/2.
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eq. 2.56.
//!
//! Weighted by cross-section, r² n(r), it is a gamma distribution of shape k = 1/b and mean a,
//! with x = r/a:
//! ln p(x) = ln c(k) - ln x + k (ln x - x + 1),   c(k) = k^k e^-k/Gamma(k)
//! The powers are never formed: b = 1e-12 has an exponent of 1e12. ln x - x + 1 comes from
//! x - 1 by a series that does not cancel, and ln c(k) from Stirling's series where k is large.

use std::f64::consts::PI;

use niji_radiometry::Micrometers;
use spec_math::Gamma;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_positive;

/// Below this |x - 1| the logarithm and its argument cancel, and the series is used.
const SERIES_RANGE: f64 = 0.25;

/// Terms of the series: 0.25/(2 - 0.25) squared to the 11th power is below 1e-18.
const N_SERIES_TERMS: u32 = 11;

/// From this shape on Stirling's series with three terms is good to 1e-16.
const STIRLING_FROM: f64 = 200.0;

/// A gamma law of radii.
///
/// ```
/// use niji_radiometry::Micrometers;
/// use niji_sizes::GammaSizes;
///
/// // <r> = a (1 - 2b) and <r^2> = a^2 (1 - b)(1 - 2b).
/// let moments = GammaSizes::new(Micrometers(10.0), 0.1)?.moments();
/// assert!((moments.mean_r_um - 8.0).abs() < 1e-12);
/// assert!((moments.mean_r2_um2 - 72.0).abs() < 1e-10);
/// # Ok::<(), niji_sizes::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GammaSizes {
    effective_radius_um: f64,
    effective_variance: f64,
}

impl GammaSizes {
    /// A law of that effective radius and effective variance; 0 is a single size.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the radius is not above 0 or the variance is not in 0..1/2.
    pub fn new(effective_radius: Micrometers, effective_variance: f64) -> Result<Self, Error> {
        require_positive("effective_radius_um", effective_radius.0)?;
        if !(0.0..0.5).contains(&effective_variance) {
            let expected = "a number from 0 to below 1/2 (there the number of drops diverges)";
            let (parameter, found) = ("effective_variance", effective_variance);
            return Err(Error::Parameter {
                parameter,
                found,
                expected,
            });
        }
        Ok(Self {
            effective_radius_um: effective_radius.0,
            effective_variance,
        })
    }

    /// Effective radius a.
    pub fn effective_radius(&self) -> Micrometers {
        Micrometers(self.effective_radius_um)
    }

    /// Effective variance b.
    pub fn effective_variance(&self) -> f64 {
        self.effective_variance
    }

    /// Moments per drop (HT74, section 2.4): `<r> = a (1 - 2b)`, `<r²> = a² (1 - b)(1 - 2b)`.
    pub fn moments(&self) -> SizeMoments {
        let (a, b) = (self.effective_radius_um, self.effective_variance);
        let mean_r2_um2 = a * a * (1.0 - b) * (1.0 - 2.0 * b);
        SizeMoments {
            mean_r_um: a * (1.0 - 2.0 * b),
            mean_r2_um2,
            mean_r3_um3: a * mean_r2_um2,
            effective_variance: b,
        }
    }

    /// Share of the cross-section per relative radius x = r/a, given as x - 1, as a logarithm.
    ///
    /// x - 1 and not x, because a law of b = 1e-12 is only 1e-6 wide. Minus infinity at x <= 0.
    /// The law must not be of a single size.
    pub fn ln_area_density(&self, relative_radius_minus_1: f64) -> f64 {
        if relative_radius_minus_1 <= -1.0 {
            return f64::NEG_INFINITY;
        }
        let shape = 1.0 / self.effective_variance;
        let log = relative_radius_minus_1.ln_1p();
        ln_norm(shape) - log + shape * ln_minus_linear(relative_radius_minus_1)
    }
}

/// ln(1 + d) - d. With q = d/(2 + d): ln(1 + d) = 2 atanh q, and 2q - d = -d²/(2 + d).
fn ln_minus_linear(d: f64) -> f64 {
    if d.abs() > SERIES_RANGE {
        return d.ln_1p() - d;
    }
    let q = d / (2.0 + d);
    let q2 = q * q;
    let tail = (1..=N_SERIES_TERMS)
        .rev()
        .fold(0.0, |sum, term| q2 * (sum + 1.0 / f64::from(2 * term + 1)));
    -d * d / (2.0 + d) + 2.0 * q * tail
}

/// ln c(k), c(k) = k^k e^-k/Gamma(k), near sqrt(k/(2 pi)).
fn ln_norm(k: f64) -> f64 {
    if k < STIRLING_FROM {
        return k * k.ln() - k - k.lgamma();
    }
    let correction = 1.0 / (12.0 * k) - 1.0 / (360.0 * k.powi(3)) + 1.0 / (1260.0 * k.powi(5));
    0.5 * (k / (2.0 * PI)).ln() - correction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_of_the_density_match_40_digit_arithmetic() {
        // (b, x - 1, ln p), with mpmath from k ln k - ln Gamma(k) + (k - 1) ln x - k x, k = 1/b.
        let cases = [
            (0.1, 0.5, -1.1267905771675333),
            (0.004, -0.1, 0.606690193772145),
            (0.49, -0.99, -3.3755175826884324),
        ];
        for (b, d, expected) in cases {
            let found = GammaSizes::new(Micrometers(1.0), b)
                .unwrap()
                .ln_area_density(d);
            // Measured worst 4.4e-15.
            assert!(
                (found - expected).abs() < 2e-14,
                "b {b}, d {d}: {found} {expected}"
            );
        }
    }

    #[test]
    fn branches_agree_where_they_meet() {
        for d in [-SERIES_RANGE, SERIES_RANGE] {
            let (inside, outside) = (ln_minus_linear(d), d.ln_1p() - d);
            assert!((inside / outside - 1.0).abs() < 1e-14);
        }
        let below = ln_norm(STIRLING_FROM * (1.0 - 1e-15));
        assert!((below - ln_norm(STIRLING_FROM)).abs() < 1e-12);
    }

    #[test]
    fn moments_close_on_effective_radius_and_variance() {
        let moments = GammaSizes::new(Micrometers(30.0), 0.2).unwrap().moments();
        assert!((moments.effective_radius().0 - 30.0).abs() < 1e-12);
        let v_e = moments.mean_r2_um2 * moments.mean_r4_um4() / moments.mean_r3_um3.powi(2) - 1.0;
        assert!((v_e - 0.2).abs() < 1e-14);
    }

    #[test]
    fn untruncated_marshall_palmer_is_the_gamma_law_of_one_third() {
        // Number densities per radius are proportional: r^((1 - 3b)/b) = r^0 at b = 1/3.
        let rain = crate::MarshallPalmer::untruncated(5.0);
        let law = GammaSizes::new(
            rain.moments().effective_radius(),
            rain.moments().effective_variance,
        );
        let law = law.unwrap();
        let ratio = |diameter_mm: f64| {
            let relative = 500.0 * diameter_mm / law.effective_radius().0;
            let area = law.ln_area_density(relative - 1.0).exp();
            area / (relative * relative * rain.density_per_m3_mm(diameter_mm))
        };
        for diameter_mm in [0.1, 1.0, 6.0] {
            assert!((ratio(diameter_mm) / ratio(0.5) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn no_drop_has_a_radius_below_zero() {
        let law = GammaSizes::new(Micrometers(1.0), 0.3).unwrap();
        assert!(law.ln_area_density(-1.0).is_infinite());
        assert!(law.ln_area_density(-2.0).is_infinite());
    }
}
