//! Normals of the smooth surface that a mesh stands for.
//!
//! n = sum_i b_i n_i / |sum_i b_i n_i|
//! `b_i` barycentric coordinates of a place on a triangle, `n_i` unit normals at its corners. [P75]
//!
//! A normal at a corner counts on the outer side of its triangle; where it is on the other, or has no length, the
//! triangle's own takes its place. So every n between them is on that side too, and never 0. A triangle whose three
//! normals all stand behind it runs the other way round than its file's normals, and they are turned over: surfaces are
//! seen from both sides.
//! [P75] B. T. Phong, Communications of the ACM 18, 311-317 (1975).

use glam::DVec3;
use glam::Vec3;

/// Unit normals at the corners of a triangle, each on its outer side.
pub(crate) fn on_its_side(normals: [Vec3; 3], [a, b, c]: [DVec3; 3]) -> [Vec3; 3] {
    let own = (b - a).cross(c - a).normalize_or_zero();
    let cosines = normals.map(|normal| {
        let normal = normal.as_dvec3().normalize_or_zero();
        (normal, normal.dot(own))
    });
    let sign = if cosines.iter().all(|(_, cosine)| *cosine < 0.0) {
        -1.0
    } else {
        1.0
    };
    cosines.map(|(normal, cosine)| {
        let is_outside = sign * cosine > 0.0;
        (if is_outside { sign * normal } else { own }).as_vec3()
    })
}

/// The unit normal at a place on a triangle, or its own where its corners have none.
pub(crate) fn between(normals: [Vec3; 3], weights: [f64; 3], own: DVec3) -> DVec3 {
    let [a, b, c] = normals.map(Vec3::as_dvec3);
    let sum = weights[0] * a + weights[1] * b + weights[2] * c;
    sum.normalize_or(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn tilted(deg: f32) -> Vec3 {
        Vec3::new(deg.to_radians().sin(), 0.0, deg.to_radians().cos())
    }

    #[test]
    fn normals_on_the_outer_side_stay_and_become_unit_vectors() {
        let found = on_its_side([3.0 * Vec3::Z, tilted(89.0), 1e-3 * tilted(-40.0)], CORNERS);
        for (found, expected) in found
            .into_iter()
            .zip([Vec3::Z, tilted(89.0), tilted(-40.0)])
        {
            assert!((found - expected).length() < 1e-6, "{found}");
        }
    }

    #[test]
    fn normals_behind_their_triangle_or_without_length_become_its_own() {
        for odd in [Vec3::ZERO, Vec3::X, tilted(91.0), -Vec3::Z] {
            assert_eq!(on_its_side([odd, Vec3::Z, odd], CORNERS), [Vec3::Z; 3]);
        }
        // A sliver has none of its own, and no number that is not finite.
        let sliver = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        let found = on_its_side([Vec3::Z; 3], sliver);
        assert_eq!(found, [Vec3::ZERO; 3]);
        assert_eq!(between(found, [0.2, 0.3, 0.5], DVec3::ZERO), DVec3::ZERO);
    }

    #[test]
    fn normals_of_a_triangle_that_runs_the_other_way_are_turned_over() {
        let behind = [-Vec3::Z, -tilted(30.0), -tilted(-30.0)];
        let found = on_its_side(behind, CORNERS);
        for (found, behind) in found.into_iter().zip(behind) {
            assert!((found + behind).length() < 1e-6, "{found}");
        }
    }

    #[test]
    fn the_normal_at_a_place_on_a_triangle_in_a_sphere_is_radial() {
        let corners = [
            DVec3::new(0.1, 0.2, 1.0),
            DVec3::new(0.4, 0.1, 1.0),
            DVec3::new(0.2, 0.5, 1.0),
        ];
        let corners = corners.map(DVec3::normalize);
        let normals = on_its_side(corners.map(DVec3::as_vec3), corners);
        let weights = [0.2, 0.5, 0.3];
        let place: DVec3 = corners
            .iter()
            .zip(weights)
            .map(|(at, weight)| weight * *at)
            .sum();
        // f32.
        assert!((between(normals, weights, DVec3::Z) - place.normalize()).length() < 1e-7);
    }
}
