//! exp(-x) for x >= 0 over whole spectra, in a form that the compiler turns into vector code.
//!
//! exp(-x) = 2^k 2^f, k = round(-x / ln 2), f in -1/2..1/2, and 2^f by its Taylor series in f ln 2 to
//! the sixth order. f32: relative error below 4e-7 for x < 20 (mostly the rounding of x itself), and
//! spectra leave in f32. The library's `exp` is a call for each element, which keeps a loop over
//! wavelengths scalar. Below exp(-87) the result is 0: no denormals.

/// Optical depth from which on nothing passes.
const OPAQUE: f32 = 87.0;

/// 1.5 * 2^23: adding it rounds to an integer in the low bits of the sum.
const ROUND: f32 = 12_582_912.0;

/// exp(-x); 1 for x <= 0, 0 for x >= 87, and 0 for NaN.
#[allow(
    clippy::inline_always,
    reason = "a call from code with wider vectors would have the narrowest again"
)]
#[inline(always)]
pub(crate) fn transmittance(optical_depth: f32) -> f32 {
    let x = optical_depth.clamp(0.0, OPAQUE);
    let scaled = -x * std::f32::consts::LOG2_E;
    let shifted = scaled + ROUND;
    let whole = shifted - ROUND;
    // Two-part ln 2 keeps the reduced argument exact (Cody and Waite).
    let y = (-x - whole * 0.693_359_4) + whole * 2.121_944_4e-4;
    // In pairs: fewer steps wait for each other than in one nest.
    let (y2, y4) = (y * y, (y * y) * (y * y));
    let (low, middle) = (1.0 + y, 0.5 + y * (1.0 / 6.0));
    let high = (1.0 / 24.0 + y * (1.0 / 120.0)) + y2 * (1.0 / 720.0);
    let series = (low + y2 * middle) + y4 * high;
    // The low bits of `shifted` are k; 127 is the exponent's bias.
    let exponent = shifted.to_bits().wrapping_add(127) << 23;
    let value = series * f32::from_bits(exponent);
    if optical_depth < OPAQUE { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_the_library_where_f32_can() {
        let mut worst = 0.0_f64;
        for step in 0..20_000 {
            let x = step as f32 * 1e-3;
            let expected = (-f64::from(x)).exp();
            worst = worst.max((f64::from(transmittance(x)) / expected - 1.0).abs());
        }
        // Measured 1.3e-7.
        assert!(worst < 4e-7, "{worst}");
    }

    #[test]
    fn the_ends_are_one_and_zero_and_nothing_is_denormal() {
        assert_eq!(transmittance(0.0), 1.0);
        assert_eq!(transmittance(-3.0), 1.0);
        assert_eq!(transmittance(87.0), 0.0);
        assert_eq!(transmittance(f32::INFINITY), 0.0);
        assert_eq!(transmittance(f32::NAN), 0.0);
        assert!(transmittance(86.9).is_normal());
    }
}
