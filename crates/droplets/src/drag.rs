//! Drag of still or moving air on a drop, taken as a rigid sphere.
//!
//! dv/dt = (w - v)/tau + g,   tau = 2 rho_w r²/(9 mu F),   F = C_d Re/24,   Re = 2 rho_a r u/mu
//! C_d = max(24/Re (1 + 0.15 Re^0.687), 0.44)
//! `v` velocity, `w` wind, u = |v - w|, `r` radius, `rho_w`, `rho_a` densities of water and air, `mu`
//! viscosity of air, `F` drag as a multiple of Stokes' drag. Buoyancy, 0.1 % of the weight, is left
//! out. [SN33] Schiller and Naumann, Z. VDI 77, 318-320 (1933), for Re < 1000; above, Newton's
//! constant. The usual switch at Re = 1000 jumps by 0.4 %; the maximum changes over at Re = 990,
//! where both are equal.
//!
//! Drops above 2 mm diameter flatten and fall more slowly than spheres: against [GK49] the terminal
//! speed is 4 % low at 1 mm, 7 % high at 2 mm and 13 % high at 4 mm.
//! [GK49] Gunn and Kinzer, J. Meteorology 6, 243-248 (1949).

/// Air at 20 °C and 1013 hPa (kg/m³).
const AIR_DENSITY_KG_M3: f64 = 1.2;

/// Air at 20 °C (Pa s).
const AIR_VISCOSITY_PA_S: f64 = 1.81e-5;

/// Water (kg/m³).
pub(crate) const WATER_DENSITY_KG_M3: f64 = 1e-3 * niji_sizes::WATER_DENSITY_G_M3;

/// Standard gravity (m/s²).
pub(crate) const GRAVITY_M_S2: f64 = 9.80665;

/// Drag coefficient at high Reynolds numbers (Newton's range).
const NEWTON_DRAG: f64 = 0.44;

/// Drag as a multiple of Stokes' drag, F(Re) (SN33).
fn over_stokes(reynolds: f64) -> f64 {
    let schiller_naumann = 1.0 + 0.15 * reynolds.powf(0.687);
    schiller_naumann.max(NEWTON_DRAG * reynolds / 24.0)
}

/// Time in which a drop takes on the velocity of the air, tau (s), at a speed relative to the air.
pub(crate) fn response_time_s(radius_m: f64, speed_m_s: f64) -> f64 {
    let reynolds = 2.0 * AIR_DENSITY_KG_M3 * radius_m * speed_m_s / AIR_VISCOSITY_PA_S;
    let stokes_s = 2.0 * WATER_DENSITY_KG_M3 * radius_m * radius_m / (9.0 * AIR_VISCOSITY_PA_S);
    stokes_s / over_stokes(reynolds)
}

/// Speed at which a drop falls through still air, u = g tau(u) (m/s).
pub(crate) fn terminal_speed_m_s(radius_m: f64) -> f64 {
    // u - g tau(u) rises with u; Stokes' drag is the least. 64 halvings exhaust the digits.
    let (mut low, mut high) = (0.0, GRAVITY_M_S2 * response_time_s(radius_m, 0.0));
    for _ in 0..64 {
        let speed = 0.5 * (low + high);
        if speed < GRAVITY_M_S2 * response_time_s(radius_m, speed) {
            low = speed;
        } else {
            high = speed;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_coefficients_are_those_of_spheres() {
        // Lapple and Shepherd, Ind. Eng. Chem. 32, 605-617 (1940). Measured worst 5 % (Re = 1000).
        for (reynolds, measured) in [
            (0.1, 240.0),
            (1.0, 26.5),
            (10.0, 4.1),
            (100.0, 1.07),
            (1000.0, 0.46),
            (10_000.0, 0.405),
        ] {
            let drag: f64 = 24.0 / reynolds * over_stokes(reynolds);
            assert!((drag / measured - 1.0).abs() < 0.09, "{reynolds}: {drag}");
        }
    }

    #[test]
    fn drops_fall_as_fast_as_measured() {
        // GK49: diameter (mm), speed (m/s); tolerances are the flattening above 1 mm.
        for (diameter_mm, measured, tolerance) in [
            (0.1, 0.27, 0.10),
            (0.2, 0.72, 0.03),
            (0.5, 2.06, 0.03),
            (1.0, 4.03, 0.05),
            (2.0, 6.49, 0.08),
            (4.0, 8.83, 0.14),
        ] {
            let speed = terminal_speed_m_s(0.5e-3 * diameter_mm);
            assert!((speed / measured - 1.0).abs() < tolerance, "{speed}");
        }
    }

    #[test]
    fn small_drops_follow_stokes() {
        // u = 2 g (rho_w) r²/(9 mu): 1 um falls at 0.12 mm/s, Re = 2e-5.
        for radius_m in [1e-7, 1e-6] {
            let stokes = 2.0 * 9.80665 * 1000.0 * radius_m * radius_m / (9.0 * 1.81e-5);
            // 0.15 Re^0.687 is 8e-5 at 1 um.
            assert!((terminal_speed_m_s(radius_m) / stokes - 1.0).abs() < 1e-4);
        }
        assert_eq!(over_stokes(0.0), 1.0);
    }

    #[test]
    fn drag_rises_without_a_jump() {
        let at = |index: i32| over_stokes(980.0 + 0.1 * f64::from(index));
        for index in 0..400 {
            let (here, next) = (at(index), at(index + 1));
            assert!(next > here && next < here * 1.0002, "{index}");
        }
    }
}
