//! The mist of a waterfall: a plume that drifts away and settles, in a steady state.
//!
//! LWC = Q(s)/U 2/(sqrt(2 pi) b) e^(-y²/2b²) 1/(sqrt(2 pi) a) e^(-n²/2a²)   for y > 0, 0 < s < S
//! a = s0 + 0.08 s,   b = s0 + 0.06 s
//! Q(s) = Q0 (b/s0)^-m,   m = sqrt(2/pi) w/(0.06 U)
//! `s` distance along the drift, `n` across it and `y` above the foot [m]; `Q` flux of water through
//! the plane at s, `Q0` at the foot; `U` speed of the drift and `w` of settling [m/s]. It is the
//! Gaussian plume from the ground with its source depleted by what settles: the layer at the ground
//! falls out, dQ/ds = -w integral of LWC(y = 0) dn, which integrates to the power law [Cha53]. Growth
//! of a and b is that of neutral air over open country [Bri73], valid from 100 m on and extended to
//! the foot, where the plume is as large as the splash, s0 = h0. The plume ends at S = 2 H.
//!
//! total water = Q0 s0/(0.06 U) [(b(S)/s0)^(1 - m) - 1]/(1 - m)
//!
//! Falling water drags air along that flows out at the foot, 0.05 of the speed of impact away from the
//! rock; the mist drifts with this and the wind together, at 0.5 m/s at least, since a plume that
//! stands still has no steady state. Both are chosen, not measured.
//! [Cha53] A. C. Chamberlain, Atomic Energy Research Establishment report HP/R 1261 (1953);
//! [Bri73] G. A. Briggs, Atmospheric Turbulence and Diffusion Laboratory report 79 (1973), class D.

use std::f64::consts::PI;

use glam::DVec2;
use glam::DVec3;

use crate::parcels::CUT;
use crate::parcels::Parcels;
use crate::parcels::Span;
use crate::parcels::cut_normal_share;
use crate::waterfall_frame::Frame;
use crate::waterfall_frame::Part;
use crate::waterfall_frame::Row;
use crate::waterfall_frame::peak_m1;

/// Growth of the plume across with the distance (Bri73).
const GROWTH_ACROSS: f64 = 0.08;

/// Growth of the plume upwards with the distance (Bri73).
const GROWTH_UP: f64 = 0.06;

/// Length of the plume, S, in heights of the fall.
const LENGTH: f64 = 2.0;

/// Speed of the air that flows out at the foot as a part of the speed of impact.
const OUTFLOW: f64 = 0.05;

/// Slowest drift (m/s).
const SLOWEST_DRIFT_M_S: f64 = 0.5;

/// Drifting mist.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mist {
    pub(crate) frame: Frame,
    /// Flow that becomes mist, Q0 (g/s).
    pub(crate) flow_g_s: f64,
    /// Wind, x and z (m/s).
    pub(crate) wind_m_s: DVec2,
    /// Speed at which the drops settle, w (m/s).
    pub(crate) settling_m_s: f64,
}

impl Mist {
    /// Velocity of the drift, x and z (m/s).
    fn drift_m_s(&self) -> DVec2 {
        let outflow = self.frame.forward * (OUTFLOW * self.frame.impact_m_s());
        let drift = self.wind_m_s + outflow;
        let direction = drift.try_normalize().unwrap_or(self.frame.forward);
        direction * drift.length().max(SLOWEST_DRIFT_M_S)
    }

    /// Power of the depletion, m.
    fn depletion(&self) -> f64 {
        (2.0 / PI).sqrt() * self.settling_m_s / (GROWTH_UP * self.drift_m_s().length())
    }

    /// Height of the plume, b (m), after a logarithmic growth ln(b/s0).
    fn height_m(&self, growth: f64) -> f64 {
        self.frame.rise_m() * growth.exp()
    }

    /// Distance s (m) at which the plume has grown by ln(b/s0).
    fn distance_m(&self, growth: f64) -> f64 {
        self.frame.rise_m() * growth.exp_m1() / GROWTH_UP
    }

    /// Spread across the drift, a (m).
    fn spread_m(&self, distance_m: f64) -> f64 {
        self.frame.rise_m() + GROWTH_ACROSS * distance_m
    }

    /// Growth ln(b/s0) at the end of the plume.
    fn whole_growth(&self) -> f64 {
        (GROWTH_UP * LENGTH * self.frame.height_m / self.frame.rise_m()).ln_1p()
    }

    /// Water between two growths (g): integral of Q(s)/U ds.
    fn water_between_g(&self, from: f64, to: f64) -> f64 {
        let power = 1.0 - self.depletion();
        let per_growth_g = self.flow_g_s * self.frame.rise_m()
            / (GROWTH_UP * self.drift_m_s().length())
            * (power * from).exp();
        per_growth_g * (to - from) * relative_expm1(power * (to - from))
    }
}

/// (e^x - 1)/x.
fn relative_expm1(x: f64) -> f64 {
    if x.abs() < f64::EPSILON {
        1.0
    } else {
        x.exp_m1() / x
    }
}

impl Part for Mist {
    fn water_g(&self) -> f64 {
        self.water_between_g(0.0, self.whole_growth())
    }

    fn extent(&self) -> (DVec3, DVec3) {
        let length_m = LENGTH * self.frame.height_m;
        let source = Row {
            middle: self.frame.foot_xz(),
            spread_m: self.spread_m(0.0),
        };
        let way = self.drift_m_s().normalize_or_zero() * length_m;
        let end = Row {
            middle: self.frame.foot_xz() + way,
            spread_m: self.spread_m(length_m),
        };
        let low_m = self.frame.foot.y;
        let high_m = low_m + CUT * self.height_m(self.whole_growth());
        self.frame.extent([source, end], Span { low_m, high_m })
    }

    /// At the ground at the source. Plumes from all places of the width lie side by side in a drift
    /// away from the rock, and in one another in a drift along it.
    fn densest_g_m3(&self) -> f64 {
        let (drift, rise_m) = (self.drift_m_s(), self.frame.rise_m());
        let side_by_side_m1 = (self.frame.width_m * drift.dot(self.frame.forward).abs()).recip();
        let in_one_s_m2 = peak_m1(rise_m) / drift.length();
        // The steps of growing width overlap by up to 1 + 2 (0.08)².
        1.02 * self.flow_g_s * side_by_side_m1.min(in_one_s_m2) * 2.0 * peak_m1(rise_m)
    }

    fn lay(&self, parcels: &mut Parcels) {
        let whole = self.whole_growth();
        // A step of 0.06 in the logarithm moves the plume on by its height, less than its width.
        let n_rows = (whole / GROWTH_UP).ceil() as usize;
        let (low_m, direction) = (self.frame.foot.y, self.drift_m_s().normalize_or_zero());
        for row in 0..n_rows {
            let growth = |index: f64| whole * index / n_rows as f64;
            let (from, to) = (growth(row as f64), growth(row as f64 + 1.0));
            let middle = 0.5 * (from + to);
            let (distance_m, height_m) = (self.distance_m(middle), self.height_m(middle));
            let heights = Span {
                low_m,
                high_m: low_m + CUT * height_m,
            };
            let layers = parcels.layers(heights, |y_m| {
                // The upper half of a normal law.
                2.0 * cut_normal_share((y_m - low_m) / height_m) - 1.0
            });
            let row = Row {
                middle: self.frame.foot_xz() + direction * distance_m,
                spread_m: self.spread_m(distance_m),
            };
            let water_g = self.water_between_g(from, to);
            self.frame.add_row(parcels, water_g, row, &layers);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drag::terminal_speed_m_s;

    /// 20 m high, so that s0 = 1 m and S = 40 m; towards the east.
    fn frame() -> Frame {
        Frame {
            foot: DVec3::ZERO,
            forward: DVec2::X,
            height_m: 20.0,
            width_m: 6.0,
            voxel_m: 1.0,
        }
    }

    #[test]
    fn mist_loses_what_falls_out_of_its_lowest_layer() {
        // dQ/ds = -w (2/(sqrt(2 pi) b)) Q/U, from totals up to neighbouring distances.
        let frame = frame();
        let settling = terminal_speed_m_s(4e-5);
        let mist = Mist {
            frame,
            flow_g_s: 500.0,
            wind_m_s: DVec2::new(2.0, 0.0),
            settling_m_s: settling,
        };
        let drift_m_s = 2.0 + 0.05 * frame.impact_m_s();
        let water_to = |distance_m: f64| mist.water_between_g(0.0, (0.06 * distance_m).ln_1p());
        let step_m = 1e-3;
        let flux =
            |s: f64| drift_m_s * (water_to(s + step_m) - water_to(s - step_m)) / (2.0 * step_m);
        for s in [0.5_f64, 5.0, 25.0] {
            let lost = (flux(s + 0.05) - flux(s - 0.05)) / 0.1;
            let ground = 2.0 / (2.506_628_27 * (1.0 + 0.06 * s)) * flux(s) / drift_m_s;
            assert!(
                (lost / (-settling * ground) - 1.0).abs() < 1e-4,
                "{s}: {lost}"
            );
        }
        assert!((flux(2e-3) / 500.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn mist_that_settles_like_its_plume_widens_has_a_finite_total() {
        // m = 1: Q0 s0/(0.06 U) ln(b/s0).
        let frame = frame();
        let drift_m_s = 2.0 + 0.05 * frame.impact_m_s();
        for off in [0.0, 1e-13, -1e-13] {
            let mist = Mist {
                frame,
                flow_g_s: 500.0,
                wind_m_s: DVec2::new(2.0, 0.0),
                settling_m_s: (1.0 + off) * 0.06 * drift_m_s * (PI / 2.0).sqrt(),
            };
            let expected_g = 500.0 / (0.06 * drift_m_s) * 3.4_f64.ln();
            assert!((mist.water_g() / expected_g - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn drops_settle_as_fast_as_measured() {
        // Gunn and Kinzer, J. Meteorology 6, 243-248 (1949): 0.27, 0.72 and 4.03 m/s; 10 um by Stokes.
        for (radius_um, measured) in [(10.0, 0.012), (50.0, 0.27), (100.0, 0.72), (500.0, 4.03)] {
            let found = terminal_speed_m_s(1e-6 * radius_um);
            assert!((found / measured - 1.0).abs() < 0.1, "{radius_um}: {found}");
        }
    }
}
