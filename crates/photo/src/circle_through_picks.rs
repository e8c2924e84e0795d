//! The circle of view directions through three picks.
//!
//! d_i . s = cos(theta);   n = d1 x d2 + d2 x d3 + d3 x d1,   det = d1 . (d2 x d3)
//! s = sign(det) n/|n|,   cos(theta) = |det|/|n|
//! `d_i` unit view directions, `s` unit vector to the antisolar point, `theta` the bow angle. No bow
//! angle is assumed: it comes out, and is a check. |n| is twice the area of the triangle of the picks
//! on the unit sphere: 0 for coincident picks, for which no circle follows. det = 0 is a great circle,
//! a straight line in the picture, with theta = 90 degrees; solving A s = (c, c, c) fails there.

use glam::DVec3;
use niji_radiometry::Radians;

/// Least |n| over the longest side for which rounding leaves three digits of the direction: a side
/// carries the rounding 2e-16 of two unit vectors.
const LEAST_HEIGHT: f64 = 4e-13;

/// A circle on the sphere of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickCircle {
    /// Unit vector to its middle, the antisolar point.
    pub antisolar: DVec3,
    /// Its radius, the bow angle, 0 to π/2.
    pub bow_angle: Radians,
    /// Twice the area of the triangle of the picks on the unit sphere: small where they are close to a
    /// line and tell the circle badly.
    pub doubled_area: f64,
}

/// The circle through three unit vectors; `None` where two of them coincide.
#[must_use]
pub fn circle_through_picks(picks: [DVec3; 3]) -> Option<PickCircle> {
    let [d1, d2, d3] = picks;
    // d1 x d2 + d2 x d3 + d3 x d1 without its cancellation for close picks.
    let normal = (d2 - d1).cross(d3 - d1);
    let doubled_area = normal.length();
    let longest = d1.distance(d2).max(d2.distance(d3)).max(d3.distance(d1));
    // False for NaN too.
    let is_sound = doubled_area > LEAST_HEIGHT * longest;
    if !is_sound {
        return None;
    }
    // d1 . (d2 x d3), equal to d1 . n.
    let determinant = d1.dot(normal);
    let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
    let antisolar = sign * normal / doubled_area;
    Some(PickCircle {
        antisolar,
        bow_angle: Radians(angle_between(antisolar, d1)),
        doubled_area,
    })
}

/// Angle between two unit vectors, exact for small and for right angles alike.
pub(crate) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(theta_deg: f64, clocks_deg: [f64; 3]) -> [DVec3; 3] {
        let (sin, cos) = theta_deg.to_radians().sin_cos();
        clocks_deg.map(|clock_deg| {
            let (s, c) = clock_deg.to_radians().sin_cos();
            DVec3::new(sin * c, sin * s, cos)
        })
    }

    #[test]
    fn the_textbook_matrix_gives_the_same_direction() {
        let [d1, d2, d3] = ring(42.0, [10.0, 55.0, 77.0]);
        let circle = circle_through_picks([d1, d2, d3]).unwrap();
        let matrix = glam::DMat3::from_cols(d1, d2, d3).transpose();
        for cosine in [42.0_f64.to_radians().cos(), 0.5, 1.0] {
            let solved = matrix.inverse() * DVec3::splat(cosine);
            // Rounding times the condition of the matrix, 60.
            assert!(solved.normalize().distance(circle.antisolar) < 1e-13);
            let found = circle.bow_angle.0.cos();
            assert!((cosine / solved.length() - found).abs() < 1e-13);
        }
    }

    #[test]
    fn the_conditioning_of_the_picks_is_that_of_the_published_table() {
        // Condition of the matrix of picks for arcs of 90, 60, 40, 20, 10 and 5 degrees at 42
        // degrees, by the singular values: square roots of the eigenvalues of A A^T.
        for (arc_deg, expected) in [
            (90.0, 12.0),
            (60.0, 29.0),
            (40.0, 68.0),
            (20.0, 278.0),
            (10.0, 1118.0),
            (5.0, 4480.0),
        ] {
            let picks = ring(42.0, [-0.5 * arc_deg, 0.0, 0.5 * arc_deg]);
            let found = condition(picks);
            assert!((found / expected - 1.0).abs() < 0.05, "{arc_deg}: {found}");
        }
    }

    /// Largest over smallest singular value, by power iteration on A^T A and on its inverse.
    fn condition([d1, d2, d3]: [DVec3; 3]) -> f64 {
        let rows = glam::DMat3::from_cols(d1, d2, d3);
        let squared = rows * rows.transpose();
        let largest = |matrix: glam::DMat3| {
            let mut vector = DVec3::new(0.3, 0.5, 0.8);
            for _ in 0..200 {
                vector = (matrix * vector).normalize();
            }
            vector.dot(matrix * vector)
        };
        (largest(squared) * largest(squared.inverse())).sqrt()
    }

    #[test]
    fn a_great_circle_is_90_degrees_and_coincident_picks_are_none() {
        let great = ring(90.0, [0.0, 20.0, 50.0]);
        let circle = circle_through_picks(great).unwrap();
        assert!((circle.bow_angle.0 - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let [d1, d2, _] = great;
        assert_eq!(circle_through_picks([d1, d2, d2]), None);
        assert_eq!(circle_through_picks([d1, d1, d1]), None);
        assert_eq!(circle_through_picks([DVec3::NAN, d1, d2]), None);
    }

    #[test]
    fn close_picks_keep_their_circle() {
        // A hundredth of a degree of arc.
        let circle = circle_through_picks(ring(42.0, [0.0, 5e-3, 1e-2])).unwrap();
        assert!((circle.bow_angle.to_degrees() - 42.0).abs() < 1e-3);
    }
}
