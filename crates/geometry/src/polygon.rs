//! Polygons as triangles.

use earcut::Earcut;
use glam::DVec3;

/// Triangles of a polygon in space by the numbers of its corners, turning as it does: a fan where it has no corner that
/// points inwards, else those of its projection along its mean normal (Newell's).
pub(crate) fn triangles_of_polygon(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let n = corners.len();
    let side = |index: usize| corners[(index + 1) % n] - corners[index];
    let normal: DVec3 = (1..n - 1)
        .map(|index| (corners[index] - corners[0]).cross(corners[index + 1] - corners[0]))
        .sum();
    let turns_inwards = |index: usize| side(index).cross(side((index + 1) % n)).dot(normal) < 0.0;
    let fan = || {
        (1..n as u32 - 1)
            .map(|index| [0, index, index + 1])
            .collect()
    };
    if n == 3 || !normal.is_finite() || !(0..n).any(turns_inwards) {
        return fan();
    }
    let (a, b) = normal.normalize_or_zero().any_orthonormal_pair();
    let flat = corners.iter().map(|corner| [corner.dot(a), corner.dot(b)]);
    let mut numbers: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat, &[], &mut numbers);
    let triangles: Vec<[u32; 3]> = numbers
        .chunks_exact(3)
        .map(|it| {
            let at = |index: usize| corners[it[index] as usize];
            let turn = (at(1) - at(0)).cross(at(2) - at(0)).dot(normal);
            if turn < 0.0 {
                [it[0], it[2], it[1]]
            } else {
                [it[0], it[1], it[2]]
            }
        })
        .collect();
    // Of sides that cross, or all in one line, nothing may be left.
    if triangles.is_empty() {
        fan()
    } else {
        triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3], triangles: &[[u32; 3]]) -> (DVec3, f64) {
        let halves = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|number| corners[number as usize]);
            0.5 * (b - a).cross(c - a)
        });
        let halves: Vec<DVec3> = halves.collect();
        (
            halves.iter().sum(),
            halves.iter().map(|half| half.length()).sum(),
        )
    }

    #[test]
    fn an_angle_iron_has_its_area_from_whichever_corner_it_is_listed() {
        // An L of three squares in a tilted plane.
        let (right, up) = (DVec3::new(0.8, 0.0, 0.6), DVec3::new(-0.36, 0.8, 0.48));
        let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
        let corners = outline.map(|(x, y)| f64::from(x) * right + f64::from(y) * up);
        for first in 0..6 {
            let mut turned = corners;
            turned.rotate_left(first);
            let triangles = triangles_of_polygon(&turned);
            assert_eq!(triangles.len(), 4);
            let (sum, lengths) = area(&turned, &triangles);
            let expected = 3.0 * right.cross(up);
            assert!((sum - expected).length() < 1e-12, "{first}: {sum}");
            // None lies outside and is taken off again.
            assert!((lengths - 3.0).abs() < 1e-12, "{first}: {lengths}");
            turned.reverse();
            let (sum, _) = area(&turned, &triangles_of_polygon(&turned));
            assert!((sum + expected).length() < 1e-12, "{first}: {sum}");
        }
    }

    #[test]
    fn polygons_without_an_inward_corner_are_fans() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let square = square.map(|(x, y)| DVec3::new(x, y, 3.0));
        assert_eq!(triangles_of_polygon(&square), [[0, 1, 2], [0, 2, 3]]);
        // All corners in one line: no area, as the file has it.
        let line = [0.0, 2.0, 1.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0));
        assert_eq!(triangles_of_polygon(&line).len(), 2);
    }
}
