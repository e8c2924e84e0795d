//! The frame in which the parts of a waterfall are laid out, and what they have in common.
//!
//! Water falls freely, since it drags the air along: a depth h takes t = sqrt(2 h/g), and the foot is
//! struck at v = sqrt(2 g H). What is thrown up again rises by h0 = 0.05 H on average, 5 % of the
//! energy; chosen, not measured.
//! `H` height of the fall [m], `g` gravity.

use glam::DVec2;
use glam::DVec3;

use crate::drag::GRAVITY_M_S2;
use crate::parcels::CUT;
use crate::parcels::Parcel;
use crate::parcels::Parcels;
use crate::parcels::Shares;
use crate::parcels::Span;
use crate::parcels::resolved_spread_m;

/// Mean rise of the splash as a part of the height of the fall, h0/H.
const RISE_SHARE: f64 = 0.05;

/// sqrt(2 pi).
pub(crate) const SQRT_TAU: f64 = 2.506_628_274_631_000_5;

/// Place and size of a fall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// Middle of the foot (m).
    pub(crate) foot: DVec3,
    /// Unit vector away from the rock, x and z.
    pub(crate) forward: DVec2,
    /// Height of the lip above the foot (m).
    pub(crate) height_m: f64,
    /// Width (m).
    pub(crate) width_m: f64,
    /// Edge length of a voxel (m).
    pub(crate) voxel_m: f64,
}

/// A row of parcels across the whole width of a fall, all with the same spread.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    /// Its middle, x and z (m).
    pub(crate) middle: DVec2,
    /// Standard deviation of each parcel across (m).
    pub(crate) spread_m: f64,
}

/// A population of drops of a fall.
pub(crate) trait Part {
    /// Water in the air (g).
    fn water_g(&self) -> f64;
    /// Lowest and highest corner of the region of the drops (m).
    fn extent(&self) -> (DVec3, DVec3);
    /// Upper bound on the liquid water content of a cell (g/m³).
    fn densest_g_m3(&self) -> f64;
    /// Lay the water out.
    fn lay(&self, parcels: &mut Parcels);
}

impl Frame {
    /// Time of fall from the lip to a depth (s); heights that roundoff puts above the lip take none.
    pub(crate) fn fall_s(depth_m: f64) -> f64 {
        (2.0 * depth_m.max(0.0) / GRAVITY_M_S2).sqrt()
    }

    /// Speed at the foot, v (m/s).
    pub(crate) fn impact_m_s(&self) -> f64 {
        (2.0 * GRAVITY_M_S2 * self.height_m).sqrt()
    }

    /// Mean rise of the splash, h0 (m).
    pub(crate) fn rise_m(&self) -> f64 {
        RISE_SHARE * self.height_m
    }

    /// Middle of the foot, x and z (m).
    pub(crate) fn foot_xz(&self) -> DVec2 {
        DVec2::new(self.foot.x, self.foot.z)
    }

    /// Lay out water evenly over a row.
    pub(crate) fn add_row(&self, parcels: &mut Parcels, water_g: f64, row: Row, layers: &Shares) {
        let even = self.parcels(row);
        parcels.add_row(water_g, &even, row.spread_m, layers);
    }

    /// The parcels of a row, of equal water.
    pub(crate) fn parcels(&self, row: Row) -> Vec<Parcel> {
        let spacing_m = resolved_spread_m(row.spread_m, self.voxel_m);
        let n_parcels = (self.width_m / spacing_m).ceil().max(1.0) as usize;
        let across = self.forward.perp() * self.width_m;
        let parcel = |index| Parcel {
            middle: row.middle + across * ((index as f64 + 0.5) / n_parcels as f64 - 0.5),
            share: 1.0 / n_parcels as f64,
        };
        (0..n_parcels).map(parcel).collect()
    }

    /// Lowest and highest corner of rows of parcels, between two heights (m).
    pub(crate) fn extent(&self, rows: [Row; 2], heights: Span) -> (DVec3, DVec3) {
        let corners = rows.map(|Row { middle, spread_m }| {
            let reach_m = CUT * resolved_spread_m(spread_m, self.voxel_m);
            let reach = self.forward.perp().abs() * (0.5 * self.width_m) + reach_m;
            (middle - reach, middle + reach)
        });
        let low = corners[0].0.min(corners[1].0);
        let high = corners[0].1.max(corners[1].1);
        (
            DVec3::new(low.x, heights.low_m, low.y),
            DVec3::new(high.x, heights.high_m, high.y),
        )
    }

    /// Largest share of a row's water per metre of its width (1/m).
    pub(crate) fn densest_across_m1(&self, spread_m: f64) -> f64 {
        self.width_m.recip().min(peak_m1(spread_m))
    }
}

/// Largest share of a parcel's water per metre (1/m).
pub(crate) fn peak_m1(spread_m: f64) -> f64 {
    (SQRT_TAU * spread_m).recip()
}
