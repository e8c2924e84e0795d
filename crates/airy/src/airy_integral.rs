//! Airy's rainbow integral.
//!
//! f(z) = ∫_0^∞ cos(π/2 (u³ − z u)) du = (2π²/3)^(1/3) Ai(−(π²/12)^(1/3) z)
//! f'(z) = −(π⁴/18)^(1/3) Ai'(−(π²/12)^(1/3) z),   f'' = −(π²/12) z f
//! `z` is positive inside the bow, where f oscillates, and negative in the dark.
//! Holds for every real z; below z = −110.8 the value is under 1e-307 and 0 is returned. Beyond
//! |z| = 60 the argument itself limits the accuracy: |z f'| eps.
//! Direct quadrature, an ascending series (lost beyond z = −3.5 and 7) and quadrature of the dark side
//! (no relative digits at all) fail; Ai and Ai' come from rational approximations.
//! [A38] G. B. Airy, Trans. Camb. Phil. Soc. 6, 379-403 (1838). [DLMF] dlmf.nist.gov, 9.5.1.

use spec_math::Bessel;

/// (π²/12)^(1/3), the factor of the argument.
pub(crate) const ARGUMENT: f64 = 0.936_927_888_800_636_4;
/// (2π²/3)^(1/3), the factor of the value.
pub(crate) const VALUE: f64 = 1.873_855_777_601_272_3;
/// (π⁴/18)^(1/3) = VALUE * ARGUMENT, the factor of the derivative.
pub(crate) const DERIVATIVE: f64 = VALUE * ARGUMENT;
/// π²/12 of f'' = −(π²/12) z f.
pub(crate) const SECOND_DERIVATIVE: f64 = 0.822_467_033_424_113_2;

/// Beyond it the phase, z^(3/2), leaves the range of f64; the fringes have been noise for long, and the
/// mean of f and of f' over them, 0, stands for both.
const NO_PHASE_LEFT: f64 = 1e200;

/// f(z) and f'(z); NaN for NaN, 0 at infinity.
#[must_use]
pub fn airy_integral_with_derivative(z: f64) -> (f64, f64) {
    if z.is_nan() {
        return (f64::NAN, f64::NAN);
    }
    if z.abs() > NO_PHASE_LEFT {
        return (0.0, 0.0);
    }
    let airy = (-ARGUMENT * z).airy();
    (VALUE * airy.ai, -DERIVATIVE * airy.aip)
}

/// f² and f'².
#[must_use]
pub fn airy_squares(z: f64) -> [f64; 2] {
    let (value, derivative) = airy_integral_with_derivative(z);
    [value * value, derivative * derivative]
}

/// f(z); NaN for NaN, 0 at infinity.
///
/// ```
/// assert!((niji_airy::airy_integral(0.0) - 0.665_271_369_988_222_3).abs() < 1e-15);
/// ```
#[must_use]
pub fn airy_integral(z: f64) -> f64 {
    airy_integral_with_derivative(z).0
}

/// f'(z); NaN for NaN, 0 at infinity.
#[must_use]
pub fn airy_integral_derivative(z: f64) -> f64 {
    airy_integral_with_derivative(z).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z, f(z), f'(z) at 40 digits (mpmath, the closed form above).
    const REFERENCE: [(f64, f64, f64); 20] = [
        (
            -100.0,
            4.5269231756480047419e-264,
            4.1065961410995549513e-263,
        ),
        (
            -60.0,
            1.7866059310714759514e-123,
            1.2558008855071602582e-122,
        ),
        (-30.0, 1.6415483158550334094e-44, 8.1676760827888769108e-44),
        (-12.5, 7.0894455729278062551e-13, 2.2871074232137270579e-12),
        (-6.0, 0.000047141758495404472554, 0.00010660368960337326832),
        (-3.0, 0.017303377573352184609, 0.028473012370053553998),
        (-1.0, 0.27283369711400709766, 0.29446087637866246065),
        (0.0, 0.6652713699882223282, 0.4544008771103258101),
        (0.5, 0.87916982238593196946, 0.37096770251188054121),
        (1.0873761, 1.0037433196855964746, -2.1133768480629911031e-8),
        (2.0, 0.56489972489830343892, -0.97190394788431668066),
        (3.5, -0.78394155343802389411, 0.074510908432071202127),
        (5.0, 0.68182541354080943985, 0.42372158149014158677),
        (8.0, 0.6056481062134832592, -0.54029382995093093461),
        (12.0, 0.40709728782786927212, 1.2776808012012714159),
        (20.0, -0.50467009626956000862, -0.23367064395998857153),
        (33.3, -0.2971941642494827364, -1.7474355049313317567),
        (60.0, -0.31752234158150802281, 1.5443969928171762046),
        (200.0, 0.27653297981121897724, -0.92335103019382211561),
        (1000.0, 0.033559175985303234875, 5.3949867341882526521),
    ];

    /// Relative error on the dark side; measured worst 1.9e-13 on 3000 z down to −110.
    const DARK_TOLERANCE: f64 = 1e-12;
    /// Error over the envelope for 0 <= z <= 60; measured worst on 1600 z 6.9e-14 for f, 8.5e-14 for f'.
    const BRIGHT_TOLERANCE: f64 = 1e-13;

    /// Local amplitude of f for z > 0.
    fn envelope(z: f64) -> f64 {
        VALUE / (std::f64::consts::PI.sqrt() * (ARGUMENT * z).max(1.0).powf(0.25))
    }

    #[test]
    fn forty_digit_values_are_met() {
        for (z, f, dfdz) in REFERENCE {
            let (found, derivative) = airy_integral_with_derivative(z);
            if z < 0.0 {
                assert!(
                    (found / f - 1.0).abs() < DARK_TOLERANCE,
                    "f({z}) = {found:e}"
                );
                assert!(
                    (derivative / dfdz - 1.0).abs() < DARK_TOLERANCE,
                    "f'({z}) = {derivative:e}"
                );
            } else {
                // Beyond 60 the rounding of the argument decides.
                let tolerance = BRIGHT_TOLERANCE + 1e-15 * z.powf(1.5);
                let slope = envelope(z) * (ARGUMENT * z).max(1.0).sqrt();
                assert!(
                    (found - f).abs() < tolerance * envelope(z),
                    "f({z}) = {found}"
                );
                assert!(
                    (derivative - dfdz).abs() < 2.0 * tolerance * slope,
                    "f'({z}) = {derivative}"
                );
            }
        }
    }

    #[test]
    fn zeros_and_extrema_are_the_published_ones() {
        // 60-digit arithmetic; the classical tables give 2.4955 and 1.005 near 1.1.
        for zero in [2.4955041, 4.363142, 5.8921929] {
            assert!(airy_integral(zero).abs() < 2e-7);
        }
        for extremum in [1.0873761, 3.4668597, 5.1445786] {
            assert!(airy_integral_derivative(extremum).abs() < 3e-7);
        }
        assert!((airy_integral(1.0873761).powi(2) - 1.007500652).abs() < 1e-9);
    }

    #[test]
    fn the_integral_solves_its_differential_equation() {
        for z in [-20.0, -4.0, -0.3, 0.7, 6.0, 40.0] {
            let step = 1e-4;
            let slope = |z| airy_integral_derivative(z);
            let second = (slope(z + step) - slope(z - step)) / (2.0 * step);
            let expected = -SECOND_DERIVATIVE * z * airy_integral(z);
            let scale = expected
                .abs()
                .max(z.abs().max(1.0) * airy_integral(z).abs());
            assert!(
                (second - expected).abs() < 1e-4 * scale.max(1e-300),
                "z = {z}"
            );
        }
    }

    #[test]
    fn nothing_strange_comes_of_strange_arguments() {
        assert!(airy_integral(f64::NAN).is_nan());
        assert_eq!(airy_integral(f64::INFINITY), 0.0);
        assert_eq!(airy_integral(f64::NEG_INFINITY), 0.0);
        assert_eq!(airy_integral(-1e9), 0.0);
        for z in [1e9, 1e12, 1e200, 1e201, 1e300, f64::MAX] {
            let (f, dfdz) = airy_integral_with_derivative(z);
            assert!(f.abs() < 1e-2 && dfdz.is_finite(), "f({z:e}) = {f}");
        }
    }
}
