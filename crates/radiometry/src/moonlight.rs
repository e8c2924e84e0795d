//! Moonlight above the air: how much weaker than the sun the moon shines.
//!
//! V = -12.73 + 0.026 |alpha| + 4e-9 alpha^4                                       (KS91, eq. 9)
//! ratio = 10^(-0.4 (V - V_sun)),  V_sun = -26.74
//! `alpha` phase angle in degrees, 0 at full moon; V apparent magnitude at mean distance. The full
//! moon shines like 1/402000 of the sun, the half moon like 1/11 of the full one. Within 7 degrees of
//! full moon the real moon is up to a third brighter. The ratio is that of visual light: the moon's
//! surface also reddens sunlight, by about a third between 450 and 650 nm, which is left out.
//! [KS91] Krisciunas and Schaefer, Publ. Astron. Soc. Pacific 103, 1033-1039 (1991).

use crate::units::Radians;

/// Apparent visual magnitude of the sun.
const SUN_MAGNITUDE: f64 = -26.74;
/// That of the full moon without its opposition surge (KS91).
const FULL_MOON_MAGNITUDE: f64 = -12.73;

/// Irradiance by the moon over that by the sun.
///
/// ```
/// use niji_radiometry::{Radians, moon_over_sun};
///
/// // The full moon is 400000 times weaker than the sun, the half moon another ten times.
/// let full = moon_over_sun(Radians(0.0));
/// assert!((1.0 / full - 4e5).abs() < 1e4);
/// assert!(moon_over_sun(Radians::from_degrees(90.0)) < 0.12 * full);
/// ```
pub fn moon_over_sun(phase_angle: Radians) -> f64 {
    let alpha = phase_angle.to_degrees().abs();
    let magnitude = FULL_MOON_MAGNITUDE + 0.026 * alpha + 4e-9 * alpha.powi(4);
    10.0_f64.powf(-0.4 * (magnitude - SUN_MAGNITUDE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(phase_deg: f64) -> f64 {
        moon_over_sun(Radians::from_degrees(phase_deg))
    }

    #[test]
    fn the_full_moon_is_400_000_times_weaker_than_the_sun() {
        assert!(
            (1.0 / at(0.0) / 4.0e5 - 1.0).abs() < 0.01,
            "{}",
            1.0 / at(0.0)
        );
    }

    #[test]
    fn the_half_moon_has_a_tenth_of_the_light_and_not_half_of_it() {
        // 0.026 * 90 + 4e-9 * 90^4 = 2.60 magnitudes (KS91, eq. 9).
        let ratio = at(90.0) / at(0.0);
        assert!((ratio - 0.091).abs() < 0.002, "{ratio}");
    }

    #[test]
    fn waxing_and_waning_moons_are_alike_and_thinner_ones_darker() {
        assert_eq!(at(-40.0), at(40.0));
        for phase_deg in 0..15 {
            let [fuller, thinner] = [0.0, 10.0].map(|more| at(10.0 * f64::from(phase_deg) + more));
            assert!(thinner < fuller);
        }
    }
}
