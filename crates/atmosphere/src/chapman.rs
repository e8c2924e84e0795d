//! Chapman's grazing incidence function by a scaled complementary error function.
//!
//! Ch(X, mu) = integral over s of exp(-(r - r0)/H) ds/H  ~  sqrt(pi X/2) erfcx(mu sqrt(X/2))
//! X = r0/H,  mu = cosine of the zenith angle, 0..1;  erfcx(x) = exp(x^2) erfc(x)
//! Leading term for large X: error -1.3e-3 to -4.7e-4 at X = 800 (Earth's air), smaller for thinner
//! layers; the exact value at mu = 0 is X e^X K1(X).
//! [C31] Chapman, Proc. Phys. Soc. 43, 26-45 and 483-501 (1931).
//! [G66] Green and Martin, Applied Optics 5, 1141 (1966): the form with the error function.

use std::f64::consts::PI;

use spec_math::Erf;

/// Where exp(x^2) erfc(x) changes to its asymptotic series: erfc underflows at 26.
const ASYMPTOTIC_FROM: f64 = 10.0;

/// Chapman's function, for rays that do not lead downwards.
pub fn chapman_erfcx(radius_over_scale_height: f64, cos_zenith: f64) -> f64 {
    let (x, mu) = (radius_over_scale_height, cos_zenith.clamp(0.0, 1.0));
    (0.5 * PI * x).sqrt() * erfcx(mu * (0.5 * x).sqrt())
}

/// exp(x^2) erfc(x) for x >= 0, to 1e-12.
fn erfcx(x: f64) -> f64 {
    if x < ASYMPTOTIC_FROM {
        return (x * x).exp() * Erf::erfc(&x);
    }
    // 1/(x sqrt(pi)) sum over k of (-1)^k (2k - 1)!!/(2 x^2)^k: 8 terms reach 1e-12 from x = 10 on.
    let step = 1.0 / (2.0 * x * x);
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..=8 {
        term *= -f64::from(2 * k - 1) * step;
        sum += term;
    }
    sum / (x * PI.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erfcx_agrees_with_published_values() {
        // mpmath, exp(x^2) erfc(x) with 40 digits.
        let values = [
            (0.0, 1.0),
            (0.5, 0.615690344192925874),
            (1.0, 0.427583576155807005),
            (5.0, 0.110704637733068626),
            (9.99, 0.0561966407068588213),
            (10.0, 0.0561409927438225859),
            (30.0, 0.0187958888614167515),
        ];
        for (x, value) in values {
            assert!((erfcx(x) / value - 1.0).abs() < 2e-12, "{x}: {}", erfcx(x));
        }
    }

    #[test]
    fn the_level_ray_is_within_5e_4_of_the_bessel_function() {
        // X e^X K1(X) at X = 6371/7.994, mpmath.
        let exact = 35.398_583_995_490_1;
        let found = chapman_erfcx(6371.0 / 7.994, 0.0);
        assert!((found / exact - 1.0).abs() < 6e-4, "{found}");
    }

    #[test]
    fn a_flat_planet_has_the_secant() {
        let found = chapman_erfcx(1e9, 0.5);
        assert!((found - 2.0).abs() < 1e-7, "{found}");
    }
}
