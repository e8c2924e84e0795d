//! The splash at the foot of a waterfall: drops thrown up that fall back.
//!
//! total water = f F T,   T = sqrt(2 pi h0/g)
//! `F` flow, `f` the share of it that splashes, `T` mean time in the air. The heights h to which drops
//! rise are exponentially distributed, of mean h0; a drop is in the air for 2 sqrt(2 h/g) and passes
//! the height y < h at speed sqrt(2 g (h - y)) twice, so that
//! LWC ~ integral from y of e^(-h/h0)/h0 2/sqrt(2 g (h - y)) dh = T/h0 e^(-y/h0)
//! is exponential too, as measured above a pool in rain [LZD24], and the mean of 2 sqrt(2 h/g) is T.
//!
//! From above it is as measured where a nappe strikes a pool [SYS23]: a gamma law away from the foot,
//! p(u) = u/d² e^(-u/d), and Gaussian across. The mean distance 2 d = 4 h0 is that of a launch at 45°
//! and the deviation across is h0, both chosen; along, the same Gaussian smooths the gamma law. The
//! splash is cut at u = 8 d and y = 6 h0, and what is inside holds all of the water.
//! [LZD24] Liu, Zheng and Duncan, Spray in the atmospheric surface layer by raindrops impacting water
//! surface, J. Fluid Mech. (2024);
//! [SYS23] Sun, Yuan and others, Frontiers in Environmental Science 11, 1096960 (2023).

use glam::DVec3;

use crate::drag::GRAVITY_M_S2;
use crate::parcels::Parcels;
use crate::parcels::Span;
use crate::parcels::resolved_spread_m;
use crate::waterfall_frame::Frame;
use crate::waterfall_frame::Part;
use crate::waterfall_frame::Row;
use crate::waterfall_frame::SQRT_TAU;
use crate::waterfall_frame::peak_m1;

/// Scale of the distance, d, in mean rises.
const DISTANCE: f64 = 2.0;

/// Largest distance, in scales d.
const FARTHEST: f64 = 8.0;

/// Largest height, in mean rises.
const HIGHEST: f64 = 6.0;

/// Drops thrown up at the foot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Splash {
    pub(crate) frame: Frame,
    /// Flow that splashes, f F (g/s).
    pub(crate) flow_g_s: f64,
}

impl Splash {
    /// Scale of the distance, d (m).
    fn distance_m(&self) -> f64 {
        DISTANCE * self.frame.rise_m()
    }

    /// Heights that it reaches.
    fn heights(&self) -> Span {
        let low_m = self.frame.foot.y;
        Span {
            low_m,
            high_m: low_m + HIGHEST * self.frame.rise_m(),
        }
    }
}

/// Share of the gamma law of shape 2 within a distance, in scales d.
fn gamma_share(distance: f64) -> f64 {
    1.0 - (1.0 + distance) * (-distance).exp()
}

/// Share of the exponential law below a height, in mean rises.
fn exponential_share(height: f64) -> f64 {
    -(-height).exp_m1()
}

impl Part for Splash {
    fn water_g(&self) -> f64 {
        self.flow_g_s * SQRT_TAU * (self.frame.rise_m() / GRAVITY_M_S2).sqrt()
    }

    fn extent(&self) -> (DVec3, DVec3) {
        let rise_m = self.frame.rise_m();
        let farthest = self.frame.forward * (FARTHEST * self.distance_m());
        let rows = [self.frame.foot_xz(), self.frame.foot_xz() + farthest];
        let rows = rows.map(|middle| Row {
            middle,
            spread_m: rise_m,
        });
        self.frame.extent(rows, self.heights())
    }

    /// At the ground, one scale d from the foot: p(d) = 1/(e d).
    fn densest_g_m3(&self) -> f64 {
        let rise_m = self.frame.rise_m();
        let inside = gamma_share(FARTHEST) * exponential_share(HIGHEST);
        let upright_m1 = (rise_m * inside).recip();
        let along_m1 = (-1.0_f64).exp() / self.distance_m();
        let across_m1 = self.frame.densest_across_m1(rise_m);
        self.water_g() * upright_m1 * along_m1.min(peak_m1(rise_m)) * across_m1
    }

    fn lay(&self, parcels: &mut Parcels) {
        let (rise_m, low_m) = (self.frame.rise_m(), self.frame.foot.y);
        let layers = parcels.layers(self.heights(), |y_m| {
            exponential_share((y_m - low_m) / rise_m) / exponential_share(HIGHEST)
        });
        let reach_m = FARTHEST * self.distance_m();
        let spacing_m = resolved_spread_m(rise_m, parcels.voxel_m());
        let n_rows = (reach_m / spacing_m).ceil() as usize;
        for row in 0..n_rows {
            let place = |index: f64| FARTHEST * index / n_rows as f64;
            let (near, far) = (place(row as f64), place(row as f64 + 1.0));
            let share = (gamma_share(far) - gamma_share(near)) / gamma_share(FARTHEST);
            let water_g = self.water_g() * share;
            let along_m = 0.5 * (near + far) * self.distance_m();
            let row = Row {
                middle: self.frame.foot_xz() + self.frame.forward * along_m,
                spread_m: rise_m,
            };
            self.frame.add_row(parcels, water_g, row, &layers);
        }
    }
}
