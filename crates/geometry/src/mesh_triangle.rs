//! Where a ray meets a triangle, without gaps between neighbors.
//!
//! The triangle is sheared so that the ray runs along an axis; the ray passes inside if the three
//! edge functions U, V, W have no two different signs, at distance t = (U z_a + V z_b + W z_c)/(U+V+W).
//! Neighbors compute the function of their common edge from the same numbers in the opposite order,
//! hence exactly the negative of each other: no ray slips between them.
//! [WBW13] S. Woop, C. Benthin, I. Wald, J. Computer Graphics Techniques 2(1), 65-82 (2013).

use glam::DVec3;

use crate::ray::Ray;

/// A ray with what all triangles need of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: [f64; 3],
}

impl ShearedRay {
    /// A ray; `None` if it is not finite or has no direction.
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        if !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let size = ray.direction.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        if size[z] <= 0.0 {
            return None;
        }
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        // Keeps the sense of rotation, so that the sign of the area says which side is met.
        if ray.direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let along = ray.direction[z];
        Some(Self {
            origin: ray.origin,
            axes: [x, y, z],
            shear: [
                ray.direction[x] / along,
                ray.direction[y] / along,
                1.0 / along,
            ],
        })
    }

    /// Distance to a triangle on the line of the ray, and whether the ray meets it from inside,
    /// that is from the side from which its corners run clockwise.
    pub(crate) fn meet(&self, corners: [DVec3; 3]) -> Option<(f64, bool)> {
        let ([a, b, c], [u, v, w]) = self.edges(corners);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let area = u + v + w;
        // Exactly edge-on: a stored 0.
        if area == 0.0 {
            return None;
        }
        let distance_m = (u * a.z + v * b.z + w * c.z) / area;
        distance_m.is_finite().then_some((distance_m, area < 0.0))
    }

    /// Barycentric coordinates of the place where the ray meets a triangle, which it does: none is below 0.
    pub(crate) fn weights(&self, corners: [DVec3; 3]) -> [f64; 3] {
        let (_, [u, v, w]) = self.edges(corners);
        [u, v, w].map(|edge| edge / (u + v + w))
    }

    /// Sheared corners and edge functions U, V, W.
    #[inline]
    fn edges(&self, corners: [DVec3; 3]) -> ([DVec3; 3], [f64; 3]) {
        let [a, b, c] = [
            self.sheared(corners[0]),
            self.sheared(corners[1]),
            self.sheared(corners[2]),
        ];
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        ([a, b, c], [u, v, w])
    }

    #[inline]
    fn sheared(&self, corner: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        // Of an array: a vector's component was a choice between three.
        let from = (corner - self.origin).to_array();
        DVec3::new(
            from[x] - self.shear[0] * from[z],
            from[y] - self.shear[1] * from[z],
            self.shear[2] * from[z],
        )
    }
}
