//! A ray against many boxes.

use glam::DVec3;

use crate::aabb::Aabb;
use crate::ray::Ray;

/// Boxes are left this much later than computed, so that rounding cuts off no triangle (three
/// roundings, WBW13 as in `mesh_triangle`).
const LATER: f64 = 1.0 + 4.0 * f64::EPSILON;

/// A ray for many boxes.
pub(crate) struct Slabs {
    origin: DVec3,
    inverse: DVec3,
}

impl Slabs {
    pub(crate) fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            inverse: ray.direction.recip(),
        }
    }

    /// Whether the ray meets a box between two distances; sometimes yes where it just misses.
    pub(crate) fn meets(&self, bounds: &Aabb, after_m: f64, before_m: f64) -> bool {
        let (mut enter_m, mut leave_m) = (after_m, before_m);
        for axis in 0..3 {
            let inverse = self.inverse[axis];
            let low = (bounds.min[axis] - self.origin[axis]) * inverse;
            let high = (bounds.max[axis] - self.origin[axis]) * inverse;
            let (near, far) = if inverse.is_sign_positive() {
                (low, high)
            } else {
                (high, low)
            };
            // A ray within a face makes 0 times infinity; `max` and `min` pass over the NaN.
            enter_m = enter_m.max(near);
            leave_m = leave_m.min(far * LATER);
        }
        enter_m <= leave_m
    }
}
