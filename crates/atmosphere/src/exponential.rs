//! exp(-x) over whole spectra, in a form that the compiler turns into vector code.
//!
//! exp(-x) = 2^k exp(y),  k = round(-x/ln 2),  y = -x - k ln 2 in -0.35..0.35,  and exp(y) by its Taylor
//! series to the 12th order: relative error below 1e-15 and that of the rounding. The library's `exp`
//! is a call for each element, which keeps a loop over wavelengths scalar.

use std::f64::consts::LOG2_E;

/// 11!, 10!, … 0!.
const FACTORIALS: [f64; 12] = [
    39_916_800.0,
    3_628_800.0,
    362_880.0,
    40_320.0,
    5_040.0,
    720.0,
    120.0,
    24.0,
    6.0,
    2.0,
    1.0,
    1.0,
];
/// Optical depth from which on nothing passes.
const OPAQUE: f64 = 700.0;
/// 1.5 * 2^52: adding it rounds to an integer in the low bits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts, the high one of 33 bits (fdlibm).
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// exp(-x); 0 from x = 700 on, and for NaN. Not for x below -700.
#[inline]
pub(crate) fn exp_minus(x: f64) -> f64 {
    let shifted = -x.min(OPAQUE) * LOG2_E + ROUND;
    let whole = shifted - ROUND;
    // Two-part ln 2 keeps the reduced argument exact (Cody and Waite).
    let y = (-x.min(OPAQUE) - whole * LN_2_HIGH) - whole * LN_2_LOW;
    let mut series = 1.0 / 479_001_600.0;
    for factorial in FACTORIALS {
        series = series * y + 1.0 / factorial;
    }
    // The low bits of `shifted` are k; 1023 is the exponent's bias.
    let exponent = shifted.to_bits().wrapping_add(1023) << 52;
    let value = series * f64::from_bits(exponent);
    if x < OPAQUE { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_minus_is_the_librarys_to_rounding() {
        let mut worst = 0.0_f64;
        for step in 0..70_000 {
            let x = f64::from(step) * 0.01;
            worst = worst.max((exp_minus(x) / (-x).exp() - 1.0).abs());
        }
        // Measured 4e-16.
        assert!(worst < 1e-14, "{worst:e}");
        assert_eq!(exp_minus(0.0), 1.0);
        assert!((1.0 - exp_minus(1e-12) - 1e-12).abs() < 2e-16);
        assert_eq!(exp_minus(700.0), 0.0);
        assert_eq!(exp_minus(f64::INFINITY), 0.0);
        assert_eq!(exp_minus(f64::NAN), 0.0);
    }
}
