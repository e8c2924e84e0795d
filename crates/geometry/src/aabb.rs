//! Axis-parallel boxes and where a ray is inside them.

use glam::DVec3;

use crate::ray::Ray;

/// An axis-parallel box in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Aabb {
    /// Extent along each axis, m.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Whether a point lies inside or on a face.
    #[must_use]
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// The distances at which a ray enters and leaves, both at least 0; `None` if it misses.
    ///
    /// A ray within a face counts as inside, one that only touches an edge or a corner misses, and
    /// so does a ray that is not finite.
    /// The slab method divides by the direction; where a component is 0 the ray is inside that slab
    /// for ever or never, which is asked instead of computing 0/0.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, f64)> {
        if !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let mut enter_m = 0.0_f64;
        let mut leave_m = f64::INFINITY;
        for axis in 0..3 {
            let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
            let (low, high) = (self.min[axis], self.max[axis]);
            // Stored zeros are exact.
            if direction == 0.0 {
                if origin < low || origin > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - origin) / direction, (high - origin) / direction);
            enter_m = enter_m.max(a.min(b));
            leave_m = leave_m.min(a.max(b));
        }
        (enter_m < leave_m).then_some((enter_m, leave_m))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "these distances are exact")]

    use super::*;

    const UNIT: Aabb = Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    };

    fn chord(origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, f64)> {
        let direction = DVec3::from(direction).normalize();
        UNIT.intersect(&Ray {
            origin: DVec3::from(origin),
            direction,
        })
    }

    #[test]
    fn a_diagonal_is_as_long_as_pythagoras_says() {
        let (enter, leave) = chord([-1.0; 3], [1.0; 3]).unwrap();
        assert!((leave - enter - 3.0_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_ray_inside_enters_at_zero() {
        assert_eq!(chord([0.5; 3], [0.0, 0.0, 1.0]), Some((0.0, 0.5)));
    }

    #[test]
    fn a_ray_that_leads_away_misses() {
        assert_eq!(chord([2.0, 0.5, 0.5], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn rays_that_are_not_finite_miss() {
        let nan = Ray {
            origin: DVec3::splat(0.5),
            direction: DVec3::NAN,
        };
        assert_eq!(UNIT.intersect(&nan), None);
        let nan = Ray {
            origin: DVec3::new(f64::NAN, 0.5, 0.5),
            direction: DVec3::X,
        };
        assert_eq!(UNIT.intersect(&nan), None);
    }
}
