//! How flat a drop is that falls through still air.
//!
//! D >= 0.7 mm:  q = 1.0048 + 0.00057 D − 0.02628 D² + 0.003682 D³ − 0.0001677 D⁴
//! D < 0.7 mm:   1 − q = (1 − q(0.7 mm)) We(D)/We(0.7 mm),   We = ρ V² D/σ
//! e = (1 − q)/(1 + q)
//! `q` axis ratio, short over long axis, 1 for a sphere; `D` diameter in mm of the sphere of equal
//! volume, `We` Weber's number: what the air's pressure can do against the surface tension σ; `ρ` density
//! of air, `V` terminal speed of [`crate::terminal_speed`]. In the ratio ρ and σ cancel.
//!
//! The polynomial is a fit from 1 mm up; carried on below, it passes 1 at 0.44 mm. Yet every falling drop
//! is flattened, the small ones in proportion to Weber's number [TA64: at small Reynolds numbers; that
//! the factor stays up to 0.7 mm is assumed]. So the upper formula is followed down to the joint and
//! the lower one from there; they meet by construction, and the slope goes from −0.028 to −0.031 a
//! millimetre. Beyond 8 mm, where drops break up, q stays.
//! [BC87] K. V. Beard and C. Chuang, J. Atmos. Sci. 44, 1509-1524 (1987): the chord ratio. [TA64] T. D.
//! Taylor and A. Acrivos, J. Fluid Mech. 18, 466-476 (1964).

use niji_radiometry::Micrometers;

use crate::terminal_speed::terminal_speed_m_s;

/// Powers of the diameter in mm from 0 up, BC87.
const COEFFICIENTS: [f64; 5] = [1.0048, 5.7e-4, -2.628e-2, 3.682e-3, -1.677e-4];
/// Diameter at which the two formulas meet (mm).
const JOINT_MM: f64 = 0.7;
/// Largest diameter in mm of the measurements behind BC87; larger drops break up.
const LARGEST_DIAMETER_MM: f64 = 8.0;

/// q, short over long axis of a drop that falls through still air.
pub fn axis_ratio(radius: Micrometers) -> f64 {
    let diameter_mm = 2e-3 * radius.0;
    if diameter_mm >= JOINT_MM {
        return beard_chuang(diameter_mm.min(LARGEST_DIAMETER_MM));
    }
    let joint = Micrometers(500.0 * JOINT_MM);
    let weber = |radius: Micrometers| terminal_speed_m_s(radius).powi(2) * radius.0;
    1.0 - (1.0 - beard_chuang(JOINT_MM)) * weber(radius) / weber(joint)
}

/// e = (1 − q)/(1 + q), from 0 for a sphere to 1.
pub fn eccentricity(radius: Micrometers) -> f64 {
    let q = axis_ratio(radius);
    (1.0 - q) / (1.0 + q)
}

fn beard_chuang(diameter_mm: f64) -> f64 {
    let power = |sum: f64, coefficient: &f64| sum * diameter_mm + coefficient;
    COEFFICIENTS.iter().rev().fold(0.0, power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(diameter_mm: f64) -> f64 {
        axis_ratio(Micrometers(500.0 * diameter_mm))
    }

    #[test]
    fn large_drops_are_as_flat_as_published() {
        for (diameter_mm, expected) in [(1.0, 0.983), (2.0, 0.928), (3.0, 0.856), (6.0, 0.640)] {
            assert!((ratio(diameter_mm) - expected).abs() < 6e-4);
        }
        assert_eq!(ratio(20.0), ratio(8.0));
    }

    #[test]
    fn small_drops_are_flattened_by_webers_number() {
        assert!((1.0 - ratio(0.7) - 0.00646).abs() < 5e-6);
        let half = 1.0 - ratio(0.5);
        assert!((0.0022..0.0024).contains(&half), "{half}");
        // By hand with the speeds of Gunn and Kinzer, 2 % and 0.6 % above those used.
        let by_hand = 0.006456 * (2.06_f64 / 2.87).powi(2) * 0.5 / 0.7;
        assert!((half / by_hand - 1.0).abs() < 0.04, "{half} {by_hand}");
    }

    #[test]
    fn the_formulas_meet_without_a_step() {
        let step = ratio(0.7 - 1e-9) - ratio(0.7);
        assert!((0.0..1e-10).contains(&step), "{step}");
    }

    #[test]
    fn ratios_fall_with_size_and_never_pass_1() {
        let ratios: Vec<f64> = (0..4000)
            .map(|step| ratio(2.5e-3 * f64::from(step)))
            .collect();
        assert!(ratios[0] == 1.0 && ratios.is_sorted_by(|a, b| a >= b));
        assert!(ratios[3200] > 0.5);
        // Strictly, where the digits allow it.
        assert!(ratios[8..3200].is_sorted_by(|a, b| a > b));
        assert_eq!(eccentricity(Micrometers(0.0)), 0.0);
    }
}
