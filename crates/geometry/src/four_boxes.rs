//! A ray against four boxes at once, in single precision.
//!
//! t = (x - o)/d between the planes x of a box, o origin and d direction of the ray
//! Whatever is rounded is rounded outwards: boxes when they are made, o by `PAD` of it, t by `PAD` of it. So a box that the ray
//! meets is never missed, and one that it passes closely may be met.
//! [I13] T. Ize, J. Computer Graphics Techniques 2(2), 12-27 (2013).

use glam::Vec3;
use glam::Vec4;

use crate::aabb::Aabb;
use crate::ray::Ray;

/// More than four roundings.
const PAD: f32 = 4.0 * f32::EPSILON;

/// The same of an origin at 0.
const LEAST_PAD: f32 = 1e-25;

/// Limits of what is divided by a direction, so that no product with 0 is undefined.
const LARGEST: f64 = 1e38;

/// Four boxes in the world (m), of which none may be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FourBoxes {
    low: [Vec4; 3],
    high: [Vec4; 3],
}

impl FourBoxes {
    /// Boxes that nothing meets.
    pub(crate) const NONE: Self = Self {
        low: [Vec4::INFINITY; 3],
        high: [Vec4::NEG_INFINITY; 3],
    };

    /// Make one of them that around a box.
    pub(crate) fn set(&mut self, index: usize, bounds: &Aabb) {
        let below = |value: f64| {
            let rounded = value as f32;
            if f64::from(rounded) > value {
                rounded.next_down()
            } else {
                rounded
            }
        };
        for axis in 0..3 {
            self.low[axis][index] = below(bounds.min[axis]);
            self.high[axis][index] = -below(-bounds.max[axis]);
        }
    }

    /// One of them; `None` where there is none.
    pub(crate) fn get(&self, index: usize) -> Option<Aabb> {
        let corner = |planes: [Vec4; 3]| Vec3::from_array(planes.map(|it| it[index])).as_dvec3();
        let (min, max) = (corner(self.low), corner(self.high));
        (min.x <= max.x).then_some(Aabb { min, max })
    }
}

/// A ray that is about to meet many boxes.
pub(crate) struct FourSlabs {
    /// Coordinates of the origin, from above and from below.
    origin: [[Vec4; 3]; 2],
    inverse: [Vec4; 3],
    is_forward: [bool; 3],
}

impl FourSlabs {
    pub(crate) fn new(ray: &Ray) -> Self {
        let origin = ray.origin.to_array().map(|value| value as f32);
        let padded = |sign: f32| {
            origin.map(|value| Vec4::splat(value + sign * (PAD * value.abs() + LEAST_PAD)))
        };
        let inverse = |value: f64| {
            let limited = value.recip().abs().clamp(LARGEST.recip(), LARGEST);
            Vec4::splat(limited.copysign(value) as f32)
        };
        let direction = ray.direction.to_array();
        Self {
            origin: [padded(1.0), padded(-1.0)],
            inverse: direction.map(inverse),
            is_forward: direction.map(f64::is_sign_positive),
        }
    }

    /// Distances at which the ray enters boxes; infinite for one that it does not meet between two distances.
    #[inline]
    pub(crate) fn enter(&self, boxes: &FourBoxes, (after, before): (f32, f32)) -> [f32; 4] {
        let (mut enter, mut leave) = (Vec4::splat(after), Vec4::splat(before));
        for axis in 0..3 {
            let inverse = self.inverse[axis];
            let low = (boxes.low[axis] - self.origin[0][axis]) * inverse;
            let high = (boxes.high[axis] - self.origin[1][axis]) * inverse;
            let (near, far) = if self.is_forward[axis] {
                (low, high)
            } else {
                (high, low)
            };
            enter = enter.max(near - PAD * near.abs());
            leave = leave.min(far + PAD * far.abs());
        }
        let is_met = enter.cmple(leave);
        Vec4::select(is_met, enter, Vec4::INFINITY).to_array()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Numbers from -1 to 1 without a pattern.
    fn fraction(index: u32, step: f64) -> f64 {
        (f64::from(index) * step).fract() * 2.0 - 1.0
    }

    fn vector(index: u32) -> DVec3 {
        DVec3::new(
            fraction(index, 0.7548776),
            fraction(index, 0.5698403),
            fraction(index, 0.3247179),
        )
    }

    fn one(bounds: &Aabb) -> FourBoxes {
        let mut boxes = FourBoxes::NONE;
        boxes.set(2, bounds);
        boxes
    }

    #[test]
    fn no_box_around_a_place_of_a_ray_is_missed_wherever_it_stands() {
        for scale in [1e-3, 1.0, 1e4, 1e7] {
            for offset in [0.0, 1.0, 1e3] {
                for index in 1..2000 {
                    let origin = scale * (vector(index) + DVec3::splat(offset));
                    let direction = vector(7 * index).normalize();
                    let ray = Ray { origin, direction };
                    // From a point to a little beside it, as thin as numbers allow.
                    let distance = scale * f64::from(index) / 100.0;
                    let place = ray.at(distance);
                    let other = place + 1e-9 * scale * vector(3 * index);
                    let bounds = Aabb {
                        min: place.min(other),
                        max: place.max(other),
                    };
                    let boxes = one(&bounds);
                    let slabs = FourSlabs::new(&ray);
                    let [_, _, entered, _] = slabs.enter(&boxes, (0.0, f32::INFINITY));
                    // A box entered later would be passed over for a triangle here.
                    assert!(f64::from(entered) <= distance, "{scale} {offset} {index}");
                    let kept = boxes.get(2).unwrap();
                    assert!(kept.min.cmple(bounds.min).all() && kept.max.cmpge(bounds.max).all());
                }
            }
        }
    }

    #[test]
    fn rays_along_axes_meet_boxes_whose_faces_they_lie_in() {
        let bounds = Aabb {
            min: DVec3::new(2.0, 0.0, -1.0),
            max: DVec3::new(3.0, 1.0, 0.0),
        };
        for y in [0.0, 0.5, 1.0] {
            for z in [-1.0, -0.5, 0.0, -0.0] {
                let ray = Ray {
                    origin: DVec3::new(0.0, y, z),
                    direction: DVec3::X,
                };
                let entered = FourSlabs::new(&ray).enter(&one(&bounds), (0.0, 100.0));
                assert!((entered[2] - 2.0).abs() < 1e-5, "{y} {z}: {entered:?}");
                assert_eq!(entered[0], f32::INFINITY);
            }
        }
    }

    #[test]
    fn boxes_beside_behind_or_beyond_are_not_met() {
        let bounds = Aabb {
            min: DVec3::splat(1.0),
            max: DVec3::splat(2.0),
        };
        let ray = |origin: DVec3, direction: DVec3| Ray { origin, direction };
        let beyond = DVec3::splat(1.5);
        let slabs = FourSlabs::new(&ray(DVec3::new(0.0, 1.5, 1.5), DVec3::X));
        assert!(slabs.enter(&one(&bounds), (0.0, 10.0))[2] < 1.001);
        for missed in [(0.0, 0.99), (2.01, 10.0)] {
            assert_eq!(slabs.enter(&one(&bounds), missed), [f32::INFINITY; 4]);
        }
        for beside in [ray(DVec3::ZERO, DVec3::X), ray(beyond, DVec3::NEG_X)] {
            let entered = FourSlabs::new(&beside).enter(&one(&bounds), (0.6, 10.0));
            assert_eq!(entered, [f32::INFINITY; 4]);
        }
    }
}
