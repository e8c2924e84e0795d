//! The curtain of a waterfall: a sheet of drops in free fall.
//!
//! Water in a layer = F (t(h2) - t(h1)),   t(h) = sqrt(2 h/g)
//! total water = F sqrt(2 H/g)
//! `F` flow, `h` depth below the lip: as much passes every height, and water is thinner where it is
//! faster. The sheet leaves the lip level with the speed u and the depth b of a free overfall,
//! u = (g q)^(1/3)/0.715,   b = 0.715 (q²/g)^(1/3)   [Rou36]
//! `q` flow of volume per width of the lip [m²/s]: the depth at the brink is 0.715 of the critical
//! depth. It lands u sqrt(2 H/g) away from the lip. Across, it is Gaussian; its edge at two
//! deviations begins at b/2 and spreads by 3.5 % of the fall, as jets in air do [EF87]:
//! s = b/4 + 0.0175 h
//! [Rou36] H. Rouse, Civil Engineering 6, 257-260 (1936);
//! [EF87] Ervine and Falvey, Proc. Institution of Civil Engineers 83, 295-314 (1987).

use glam::DVec2;
use glam::DVec3;

use crate::drag::GRAVITY_M_S2;
use crate::drag::WATER_DENSITY_KG_M3;
use crate::parcels::Parcels;
use crate::parcels::Span;
use crate::parcels::resolved_spread_m;
use crate::strands::Strands;
use crate::waterfall_frame::Frame;
use crate::waterfall_frame::Part;
use crate::waterfall_frame::Row;
use crate::waterfall_frame::peak_m1;

/// Depth at the brink of a free overfall as a part of the critical depth (Rou36).
const BRINK_DEPTH: f64 = 0.715;

/// Growth of the standard deviation with the depth of the fall: half of the 3.5 % of its edge (EF87).
const SPREAD_GROWTH: f64 = 0.0175;

/// Fewest steps in time of the fall.
const FEWEST_STEPS: f64 = 16.0;

/// The falling sheet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curtain {
    pub(crate) frame: Frame,
    /// Flow F (g/s).
    pub(crate) flow_g_s: f64,
    /// What it falls apart into.
    pub(crate) strands: Option<Strands>,
}

impl Curtain {
    /// Flow of volume per width, q (m²/s).
    fn unit_discharge_m2_s(&self) -> f64 {
        1e-3 * self.flow_g_s / (WATER_DENSITY_KG_M3 * self.frame.width_m)
    }

    /// Speed at the lip, u (m/s).
    fn lip_m_s(&self) -> f64 {
        (GRAVITY_M_S2 * self.unit_discharge_m2_s()).cbrt() / BRINK_DEPTH
    }

    /// Standard deviation of the sheet at a depth, s (m).
    fn spread_m(&self, depth_m: f64) -> f64 {
        let critical_m = (self.unit_discharge_m2_s().powi(2) / GRAVITY_M_S2).cbrt();
        0.25 * BRINK_DEPTH * critical_m + SPREAD_GROWTH * depth_m
    }

    /// Middle of the sheet after a time of fall, x and z (m).
    fn middle(&self, time_s: f64) -> DVec2 {
        let to_go_s = Frame::fall_s(self.frame.height_m) - time_s;
        self.frame.foot_xz() - self.frame.forward * (self.lip_m_s() * to_go_s)
    }

    /// Steps in time, in each of which the sheet moves on by no more than its spread.
    fn n_steps(&self) -> usize {
        let whole_s = Frame::fall_s(self.frame.height_m);
        let spread_m = resolved_spread_m(self.spread_m(0.0), self.frame.voxel_m);
        let level = self.lip_m_s() * whole_s / spread_m;
        let upright = self.frame.height_m / self.frame.voxel_m;
        level.max(upright).max(FEWEST_STEPS).ceil() as usize
    }
}

impl Part for Curtain {
    fn water_g(&self) -> f64 {
        self.flow_g_s * Frame::fall_s(self.frame.height_m)
    }

    fn extent(&self) -> (DVec3, DVec3) {
        let height_m = self.frame.height_m;
        let lip = Row {
            middle: self.middle(0.0),
            spread_m: self.spread_m(0.0),
        };
        let foot = Row {
            middle: self.frame.foot_xz(),
            spread_m: self.spread_m(height_m),
        };
        let low_m = self.frame.foot.y;
        let heights = Span {
            low_m,
            high_m: low_m + height_m,
        };
        self.frame.extent([lip, foot], heights)
    }

    /// Slowest and thinnest at the lip. A cell holds no more than its diagonal's part of the width.
    fn densest_g_m3(&self) -> f64 {
        let voxel_m = self.frame.voxel_m;
        let layer_m = voxel_m.min(self.frame.height_m);
        let spread_m = resolved_spread_m(self.spread_m(0.0), voxel_m);
        let across_m2 = peak_m1(spread_m).min(2.0_f64.sqrt() / voxel_m) / self.frame.width_m;
        let layer_g = self.flow_g_s * Frame::fall_s(layer_m);
        let factor = self.strands.map_or(1.0, |it| it.max_factor());
        factor * layer_g / voxel_m * across_m2.min(voxel_m.powi(-2))
    }

    fn lay(&self, parcels: &mut Parcels) {
        let lip_y_m = self.frame.foot.y + self.frame.height_m;
        let strands = self
            .strands
            .map(|it| it.falling(self.unit_discharge_m2_s()));
        let n_steps = self.n_steps();
        let step_s = Frame::fall_s(self.frame.height_m) / n_steps as f64;
        let depth_m = |time_s: f64| 0.5 * GRAVITY_M_S2 * time_s * time_s;
        for step in 0..n_steps {
            let (from_s, middle_s) = (step as f64 * step_s, (step as f64 + 0.5) * step_s);
            let to_s = from_s + step_s;
            let heights = Span {
                low_m: lip_y_m - depth_m(to_s),
                high_m: lip_y_m - depth_m(from_s),
            };
            let layers = parcels.layers(heights, |height_m| {
                (to_s - Frame::fall_s(lip_y_m - height_m)) / step_s
            });
            let row = Row {
                middle: self.middle(middle_s),
                spread_m: self.spread_m(depth_m(middle_s)),
            };
            let water_g = self.flow_g_s * step_s;
            let mut of_row = self.frame.parcels(row);
            if let Some(strands) = &strands {
                strands.gather(&mut of_row, &self.frame, depth_m(middle_s));
            }
            parcels.add_row(water_g, &of_row, row.spread_m, &layers);
        }
    }
}
