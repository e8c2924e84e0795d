//! A view ray by the share of the view that is scattered on it.
//!
//! w(s) = 1 - exp(-tau(s)),   tau(s) = int_0^s pi M2 ds'
//!
//! `s` distance from the eye [m], `tau` optical depth without diffraction. Strata are equal parts of
//! w = 0..1; the last one that the drops reach ends with them.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::Ray;

use crate::lit_drops::extinction_m1;

/// Strata of w: between them the light changes as it does over a mean free path.
pub(super) const N_STRATA: usize = 4;

/// Midpoint steps through the drops.
const N_STEPS: usize = 256;

/// Optical depths by distance.
pub(super) struct Column {
    ray: Ray,
    enter_m: f64,
    step_m: f64,
    /// tau at the end of each step.
    depths: Vec<f64>,
}

/// Part of a column.
pub(super) struct Stratum<'a> {
    column: &'a Column,
    /// Which part of w it is.
    pub(super) index: usize,
    w: (f64, f64),
}

impl Column {
    /// The optical depths along a ray from the eye.
    pub(super) fn along(bricks: &[Bricks], bounds: Aabb, ray: Ray) -> Self {
        let Some((enter_m, leave_m)) = bounds.intersect(&ray) else {
            return Self {
                ray,
                enter_m: 0.0,
                step_m: 0.0,
                depths: Vec::new(),
            };
        };
        let step_m = (leave_m - enter_m) / N_STEPS as f64;
        let mut depth = 0.0;
        let depths = (0..N_STEPS)
            .map(|step| {
                let point = ray.at(enter_m + (step as f64 + 0.5) * step_m);
                depth += step_m * extinction_m1(bricks, point);
                depth
            })
            .collect();
        Self {
            ray,
            enter_m,
            step_m,
            depths,
        }
    }

    /// A stratum; `None` where the drops do not reach it.
    pub(super) fn stratum(&self, index: usize) -> Option<Stratum<'_>> {
        let end = self.end();
        let edge = |index: usize| index as f64 / N_STRATA as f64;
        let from = edge(index);
        (from < end).then(|| Stratum {
            column: self,
            index,
            w: (from, edge(index + 1).min(end)),
        })
    }

    /// The index of a stratum, or of the deepest one that the drops reach.
    pub(super) fn deepest(&self, index: usize) -> usize {
        let reached = (self.end() * N_STRATA as f64).ceil() as usize;
        index.min(reached.saturating_sub(1))
    }

    /// w behind all drops.
    fn end(&self) -> f64 {
        let depth = self.depths.last().copied().unwrap_or(0.0);
        -(-depth).exp_m1()
    }

    /// Where an optical depth is reached.
    fn at_depth(&self, depth: f64) -> DVec3 {
        let step = self.depths.partition_point(|end| *end < depth);
        let step = step.min(N_STEPS - 1);
        let before = if step > 0 { self.depths[step - 1] } else { 0.0 };
        let part = (depth - before) / (self.depths[step] - before);
        let part = if part.is_finite() {
            part.clamp(0.0, 1.0)
        } else {
            0.5
        };
        self.ray
            .at(self.enter_m + (step as f64 + part) * self.step_m)
    }
}

impl Stratum<'_> {
    /// The place at a fraction of the stratum.
    pub(super) fn at(&self, fraction: f64) -> DVec3 {
        let w = self.w.0 + (self.w.1 - self.w.0) * fraction;
        self.column.at_depth(-(-w).ln_1p())
    }

    /// Its part of w = 0..1.
    pub(super) fn share(&self) -> f64 {
        self.w.1 - self.w.0
    }

    /// The place at its middle.
    pub(super) fn middle(&self) -> DVec3 {
        self.at(0.5)
    }

    /// Direction of the view ray.
    pub(super) fn direction(&self) -> DVec3 {
        self.column.ray.direction
    }
}
