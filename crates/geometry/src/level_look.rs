//! A horizontal look along an azimuth, over rectangles of the plane.

use glam::DVec2;

/// A look from a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelLook {
    pub(crate) from: DVec2,
    pub(crate) along: DVec2,
    inverse: DVec2,
}

impl LevelLook {
    /// The look along a unit vector.
    pub(crate) fn new(from: DVec2, along: DVec2) -> Self {
        Self {
            from,
            along,
            inverse: along.recip(),
        }
    }

    /// Distances between which it crosses a rectangle, from 0 on; `None` where it passes by.
    pub(crate) fn within(&self, low: DVec2, high: DVec2) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..2 {
            let inverse = self.inverse[axis];
            let ends = [low, high].map(|it| (it[axis] - self.from[axis]) * inverse);
            let forward = inverse.is_sign_positive();
            // A look along a side makes 0 times infinity; `max` and `min` pass over the NaN.
            enter = enter.max(ends[usize::from(!forward)]);
            leave = leave.min(ends[usize::from(forward)]);
        }
        (enter <= leave).then_some((enter, leave))
    }
}
