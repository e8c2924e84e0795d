//! How fast small drops fall through still air at sea level.
//!
//! D < 19 um:    V = Δρ g D² C/(18 η),                    C = 1 + 2.51 l/D
//! D < 1.07 mm:  V = η C exp(Y)/(ρ D),   Y = Σ b_j X^j,   X = ln(4 ρ Δρ g D³/(3 η²))
//! `V` terminal speed (m/s), `D` diameter (m), `ρ` density of air, `Δρ` density of water less that of
//! air (kg/m³), `η` viscosity of air (Pa s), `l` mean free path of its molecules (m), `C` slip. Larger
//! drops have a formula of their own there, which nobody asks for here.
//! [B76] K. V. Beard, J. Atmos. Sci. 33, 851-864 (1976), table 1. It lies below the measurements of [GK49]
//! R. Gunn and G. D. Kinzer, J. Meteorology 6, 243-248 (1949), by 1 % from 0.6 mm up, 2 % from 0.3 mm and
//! 4 % at 0.2 mm.
//!
//! At 19 um the printed formulas leave a step of −0.2 %; here the upper one holds the speed down that
//! little below it, so that V is continuous and never falls.
//!
//! `niji-droplets` has a drag of its own: what flies needs a force at every speed against the air, not
//! the speed of the fall alone, and the axis ratios of falling drops rest on these speeds.

use niji_radiometry::Micrometers;

/// Air at 20 °C and 1013.25 hPa (kg/m³).
const AIR_DENSITY_KG_M3: f64 = 1.204;
/// Air at 20 °C (Pa s), B76.
const AIR_VISCOSITY_PA_S: f64 = 1.818e-5;
/// Mean free path in air at 20 °C and 1013.25 hPa (m), B76.
const MEAN_FREE_PATH_M: f64 = 6.62e-8;
/// Water at 20 °C less air (kg/m³).
const DENSITY_DIFFERENCE_KG_M3: f64 = 998.2 - AIR_DENSITY_KG_M3;
/// Standard gravity (m/s²).
const GRAVITY_M_S2: f64 = 9.80665;

/// Where Stokes' law ends (m), B76.
const STOKES_DIAMETER_M: f64 = 19e-6;
/// Where the second formula ends (m), B76.
const LARGEST_DIAMETER_M: f64 = 1.07e-3;
/// Powers of X from 0 up, B76.
const COEFFICIENTS: [f64; 7] = [
    -0.318657e1,
    0.992696,
    -0.153193e-2,
    -0.987059e-3,
    -0.578878e-3,
    0.855176e-4,
    -0.327815e-5,
];

/// V in m/s of a drop of at most 1.07 mm diameter.
///
/// # Panics
/// In debug builds, for larger drops.
pub(crate) fn terminal_speed_m_s(radius: Micrometers) -> f64 {
    let diameter_m = 2e-6 * radius.0;
    debug_assert!(diameter_m <= LARGEST_DIAMETER_M, "only small drops");
    if diameter_m > STOKES_DIAMETER_M {
        return by_davies_number_m_s(diameter_m);
    }
    let stokes_m_s =
        DENSITY_DIFFERENCE_KG_M3 * GRAVITY_M_S2 * diameter_m / (18.0 * AIR_VISCOSITY_PA_S);
    // D C = D + 2.51 l is finite where C is not.
    let speed_m_s = stokes_m_s * (diameter_m + 2.51 * MEAN_FREE_PATH_M);
    speed_m_s.min(by_davies_number_m_s(STOKES_DIAMETER_M))
}

/// The second formula: Reynolds' number from that of Davies.
fn by_davies_number_m_s(diameter_m: f64) -> f64 {
    let weight = 4.0 * AIR_DENSITY_KG_M3 * DENSITY_DIFFERENCE_KG_M3 * GRAVITY_M_S2 / 3.0;
    let x = (weight * diameter_m.powi(3) / AIR_VISCOSITY_PA_S.powi(2)).ln();
    let y = COEFFICIENTS.iter().rev().fold(0.0, |sum, b| sum * x + b);
    let slip = 1.0 + 2.51 * MEAN_FREE_PATH_M / diameter_m;
    AIR_VISCOSITY_PA_S * slip * y.exp() / (AIR_DENSITY_KG_M3 * diameter_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_fall_as_fast_as_gunn_and_kinzer_measured() {
        // Diameter (mm), speed (m/s), and how far B76 lies below: measured worst 2.2 % and 3.7 %.
        for (diameter_mm, measured, tolerance) in [
            (0.2, 0.72, 0.04),
            (0.3, 1.17, 0.025),
            (0.4, 1.62, 0.025),
            (0.5, 2.06, 0.025),
            (0.6, 2.47, 0.015),
            (0.7, 2.87, 0.01),
            (0.8, 3.27, 0.01),
            (0.9, 3.67, 0.01),
            (1.0, 4.03, 0.01),
        ] {
            let speed = terminal_speed_m_s(Micrometers(500.0 * diameter_mm));
            let low = 1.0 - speed / measured;
            assert!((0.0..tolerance).contains(&low), "{diameter_mm} mm: {speed}");
        }
    }

    #[test]
    fn the_smallest_follow_stokes() {
        // 2 g Δρ r²/(9 η) = 0.1195 mm/s at 1 um, more by 2.51 l/D = 8.3 % of slip.
        let speed = terminal_speed_m_s(Micrometers(1.0));
        assert!((speed / (1.195e-4 * 1.0831) - 1.0).abs() < 1e-3, "{speed}");
        assert_eq!(terminal_speed_m_s(Micrometers(0.0)), 0.0);
    }

    #[test]
    fn speeds_rise_without_a_step() {
        let speeds: Vec<f64> = (0..5200)
            .map(|step| terminal_speed_m_s(Micrometers((0.00125 * f64::from(step)).exp() - 0.9)))
            .collect();
        assert!(speeds.is_sorted());
        // D² at most: 0.25 % a step of 0.125 %, at 0.1 um more by what is taken off.
        let seam = |side: f64| terminal_speed_m_s(Micrometers(0.5e6 * STOKES_DIAMETER_M + side));
        assert!((seam(1e-9) / seam(-1e-9) - 1.0).abs() < 1e-9);
    }
}
