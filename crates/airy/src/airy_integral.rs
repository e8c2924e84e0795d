//! Airy's rainbow integral.
//!
//! f(z) = ∫_0^∞ cos(π/2 (u³ − z u)) du = (2π²/3)^(1/3) Ai(−(π²/12)^(1/3) z)
//! f'(z) = −(π⁴/18)^(1/3) Ai'(−(π²/12)^(1/3) z),   f'' = −(π²/12) z f
//! `z` is positive inside the bow, where f oscillates, and negative in the dark.
//! Holds for every real z; below z = −111 the value is under 2e-308 and 0 is returned. Beyond
//! |z| = 60 the argument itself limits the accuracy: |z f'| eps.
//!
//! Up to z = 60 f is its Taylor series about the nearest of nodes that are 1/4 apart. From node to node
//! it follows from the differential equation alone, always in the direction in which f is not the
//! small solution: from z = −111 up to 0 (with any value there, which f(0) then sets), and from 0 on.
//! Beyond it is the asymptotic series with ξ = π (z/3)^(3/2) (DLMF 9.7.9 to 9.7.10), the turns of which
//! are taken off exactly.
//! Direct quadrature, a series about 0 (lost beyond z = −3.5 and 7) and quadrature of the dark side
//! (no relative digits at all) fail; rational approximations of Ai take 5 to 10 times as long.
//! [A38] G. B. Airy, Trans. Camb. Phil. Soc. 6, 379-403 (1838). [DLMF] dlmf.nist.gov, ch. 9.

use std::f64::consts::PI;

/// (π²/12)^(1/3), the factor of the argument.
pub(crate) const ARGUMENT: f64 = 0.936_927_888_800_636_4;
/// (2π²/3)^(1/3), the factor of the value.
pub(crate) const VALUE: f64 = 1.873_855_777_601_272_3;
/// (π⁴/18)^(1/3) = VALUE * ARGUMENT, the factor of the derivative.
pub(crate) const DERIVATIVE: f64 = VALUE * ARGUMENT;
/// π²/12 of f'' = −(π²/12) z f.
pub(crate) const SECOND_DERIVATIVE: f64 = 0.822_467_033_424_113_2;
/// f(0) and f'(0), with 40 digits 0.66527136998822232820 and 0.45440087711032581010.
const AT_ZERO: [f64; 2] = [0.665_271_369_988_222_3, 0.454_400_877_110_325_8];

/// First and last node, and the distance between two, a power of 2.
const LOWEST_Z: f64 = -111.0;
const HIGHEST_Z: f64 = 60.0;
const SPACING: f64 = 0.25;
const ZERO_INDEX: usize = 444;
const N_NODES: usize = 685;
/// f'/f at the first node (40-digit arithmetic).
const LOWEST_SLOPE: f64 = 9.557_031_966_231_602;
/// Any value for the first node, small enough for what f grows to at 0.
const LOWEST_VALUE: f64 = 1e-300;
/// Terms of a series: half a spacing away the next one is 3e-16 at z = 60, 1e-15 at z = −111.
const N_TERMS: usize = 18;
/// Terms of a step from node to node.
const N_STEP_TERMS: usize = 40;

/// Beyond it the phase, z^(3/2), leaves the range of f64; the fringes have been noise for long, and the
/// mean of f and of f' over them, 0, stands for both.
const NO_PHASE_LEFT: f64 = 1e200;
/// V/(sqrt(π) A^(1/4)), the amplitude of f times z^(1/4).
const AMPLITUDE: f64 = 1.074_569_931_823_542;
/// V A^(5/4)/sqrt(π), the amplitude of f' times z^(−1/4).
const SLOPE_AMPLITUDE: f64 = 0.974_527_129_583_373_6;
/// u_k of DLMF 9.7.2, with the signs of 9.7.9.
const U: [f64; 6] = [
    1.0,
    5.0 / 72.0,
    -385.0 / 10368.0,
    -85085.0 / 2239488.0,
    37182145.0 / 644972544.0,
    5391411025.0 / 46438023168.0,
];

/// v_k = u_k (6k + 1)/(1 − 6k) with the signs of 9.7.10.
const V: [f64; 6] = [
    U[0],
    -7.0 / 5.0 * U[1],
    -13.0 / 11.0 * U[2],
    -19.0 / 17.0 * U[3],
    -25.0 / 23.0 * U[4],
    -31.0 / 29.0 * U[5],
];

/// Taylor coefficients about every node.
static NODES: [[f64; N_TERMS]; N_NODES] = nodes();

const fn node_z(index: usize) -> f64 {
    LOWEST_Z + SPACING * index as f64
}

/// a_(n+2) = −c (z a_n + a_(n−1))/((n + 1)(n + 2)) from a_0 = f and a_1 = f'.
const fn taylor<const N: usize>(z: f64, [f, slope]: [f64; 2]) -> [f64; N] {
    let mut a = [0.0; N];
    (a[0], a[1]) = (f, slope);
    a[2] = -0.5 * SECOND_DERIVATIVE * z * f;
    let mut n = 1;
    while n + 2 < N {
        a[n + 2] = -SECOND_DERIVATIVE * (z * a[n] + a[n - 1]) / ((n + 1) * (n + 2)) as f64;
        n += 1;
    }
    a
}

/// f and f' one spacing on.
const fn step(z: f64, from: [f64; 2]) -> [f64; 2] {
    let a = taylor::<N_STEP_TERMS>(z, from);
    let (mut value, mut slope) = (0.0, 0.0);
    let mut n = N_STEP_TERMS;
    while n > 0 {
        n -= 1;
        slope = slope * SPACING + value;
        value = value * SPACING + a[n];
    }
    [value, slope]
}

#[allow(
    clippy::large_stack_arrays,
    reason = "the compiler evaluates it, nothing of it runs"
)]
const fn nodes() -> [[f64; N_TERMS]; N_NODES] {
    let mut nodes = [[0.0; N_TERMS]; N_NODES];
    let mut dark = [[0.0; 2]; ZERO_INDEX + 1];
    dark[0] = [LOWEST_VALUE, LOWEST_VALUE * LOWEST_SLOPE];
    let mut index = 0;
    while index < ZERO_INDEX {
        dark[index + 1] = step(node_z(index), dark[index]);
        index += 1;
    }
    let scale = AT_ZERO[0] / dark[ZERO_INDEX][0];
    index = 0;
    while index < ZERO_INDEX {
        let [value, slope] = dark[index];
        nodes[index] = taylor(node_z(index), [scale * value, scale * slope]);
        index += 1;
    }
    let mut bright = AT_ZERO;
    while index < N_NODES {
        nodes[index] = taylor(node_z(index), bright);
        bright = step(node_z(index), bright);
        index += 1;
    }
    nodes
}

/// f(z) and f'(z); NaN for NaN, 0 at infinity.
#[must_use]
#[inline]
pub fn airy_integral_with_derivative(z: f64) -> (f64, f64) {
    if z.is_nan() {
        return (z, z);
    }
    if !(LOWEST_Z..=NO_PHASE_LEFT).contains(&z) {
        return (0.0, 0.0);
    }
    if z <= HIGHEST_Z {
        near_node(z)
    } else {
        fringes(z)
    }
}

#[inline]
fn near_node(z: f64) -> (f64, f64) {
    let index = ((z - LOWEST_Z) / SPACING + 0.5) as usize;
    let a = &NODES[index];
    let t = z - node_z(index);
    let square = t * t;
    // Even and odd powers side by side: half the latency.
    let (mut even, mut odd, mut even_slope, mut odd_slope) = (0.0, 0.0, 0.0, 0.0);
    for n in (0..N_TERMS).step_by(2).rev() {
        even = even * square + a[n];
        odd = odd * square + a[n + 1];
        odd_slope = odd_slope * square + (n + 1) as f64 * a[n + 1];
    }
    for n in (2..N_TERMS).step_by(2).rev() {
        even_slope = even_slope * square + n as f64 * a[n];
    }
    (even + t * odd, odd_slope + t * even_slope)
}

/// The asymptotic series inside the bow.
fn fringes(z: f64) -> (f64, f64) {
    // ξ/π and its part within a turn.
    let turns = z / 3.0 * (z / 3.0).sqrt();
    let part = turns - 2.0 * (0.5 * turns).round();
    let (sin, cos) = (PI * (part - 0.25)).sin_cos();
    let inverse = 1.0 / (PI * turns);
    let square = inverse * inverse;
    let sums = |u: [f64; 6]| {
        let even = u[0] + square * (u[2] + square * u[4]);
        let odd = inverse * (u[1] + square * (u[3] + square * u[5]));
        (even, odd)
    };
    let (even, odd) = sums(U);
    let (even_slope, odd_slope) = sums(V);
    let quarter = z.sqrt().sqrt();
    (
        AMPLITUDE / quarter * (cos * even + sin * odd),
        SLOPE_AMPLITUDE * quarter * (cos * odd_slope - sin * even_slope),
    )
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
    use spec_math::Bessel;

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
        (33.25, -0.20070374687847287543, -2.0900644314795639182),
        (60.0, -0.31752234158150802281, 1.5443969928171762046),
        (200.0, 0.27653297981121897724, -0.92335103019382211561),
        (1000.0, 0.033559175985303234875, 5.3949867341882526521),
    ];

    /// Relative error on the dark side; measured worst on 2000 z down to −110.5 7e-15 for f, 1.4e-13
    /// for f' (below z = −100; 5e-15 above).
    const DARK_TOLERANCE: f64 = 5e-13;
    /// Error over the envelope for 0 <= z <= 60; measured worst on 2500 z 2.6e-15 for f and f'.
    const BRIGHT_TOLERANCE: f64 = 1e-14;
    /// Difference from the rational approximations of Cephes, over the envelope or on the dark side
    /// relative; measured worst 2.3e-13, their error.
    const CEPHES_TOLERANCE: f64 = 3e-13;

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
                let argument = if z > 60.0 { 1e-15 * z.powf(1.5) } else { 0.0 };
                let tolerance = BRIGHT_TOLERANCE + argument;
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
    fn rational_approximations_of_ai_agree_at_every_argument() {
        for step in -11_000..6_000 {
            let z = 0.01 * f64::from(step) + 0.003;
            let (f, dfdz) = airy_integral_with_derivative(z);
            let airy = (-ARGUMENT * z).airy();
            let (value, slope) = (VALUE * airy.ai, -DERIVATIVE * airy.aip);
            let (scale, slope_scale) = if z < 0.0 {
                (value, slope)
            } else {
                (envelope(z), envelope(z) * (ARGUMENT * z).max(1.0).sqrt())
            };
            let off = (f - value).abs() / scale;
            let slope_off = (dfdz - slope).abs() / slope_scale;
            assert!(
                off.max(slope_off) < CEPHES_TOLERANCE,
                "z = {z}: {off:e}, {slope_off:e}"
            );
        }
    }

    #[test]
    fn no_step_is_left_between_nodes_and_at_the_asymptotic_series() {
        for seam in [-0.125_f64, 1.125, 30.375, 60.0] {
            let (below, above) = (seam.next_down(), seam.next_up());
            let (f0, d0) = airy_integral_with_derivative(below);
            let (f1, d1) = airy_integral_with_derivative(above);
            assert!((f1 - f0 - (above - below) * d0).abs() < 1e-14);
            assert!((d1 - d0 + (above - below) * SECOND_DERIVATIVE * below * f0).abs() < 3e-14);
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
}
