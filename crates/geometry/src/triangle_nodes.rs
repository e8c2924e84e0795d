//! Nodes at which a triangle is cut into cells of its own shape.
//!
//! w = (1 - d) (n - i - j, i, j)/n + d (1, 1, 1)/3,   d = 1/(16 n)
//! `w` barycentric weights of node (i, j), `n` cells along a side. Nodes lie a little inside, lest those of an edge lie in a
//! surface that begins there.

use glam::DVec3;

use crate::mesh::TriangleMesh;
use crate::mesh_normals::between;

/// What of a cell the nodes of an edge lie inside it, as seen along the lines to the triangle's middle.
const INSIDE: f64 = 1.0 / 16.0;

/// A node of a triangle: so many steps of so many cells along its sides from the first corner to the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TriangleNode {
    /// Steps towards the second corner, and the third.
    pub steps: [u32; 2],
    /// Cells along a side.
    pub n_cells: u32,
}

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePlace {
    /// Where (m).
    pub point: DVec3,
    /// Unit normal of the triangle, outwards; 0 of one without area.
    pub normal: DVec3,
    /// Unit normal of the smooth surface there: [`normal`](Self::normal) where corners have none.
    pub smooth_normal: DVec3,
}

impl TriangleMesh {
    /// The nodes around a point of a triangle that has so many cells along a side, with their weights there.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn nodes_around(
        &self,
        triangle_index: usize,
        point: DVec3,
        n_cells: u32,
    ) -> [(TriangleNode, f64); 3] {
        let corners = self.corners(triangle_index);
        let [_, b, c] = weights(corners, point).map(|weight| weight * f64::from(n_cells));
        let node = |right: f64, up: f64| TriangleNode {
            steps: [b.floor() + right, c.floor() + up].map(|step| step as u32),
            n_cells,
        };
        let (right, up) = (b.fract(), c.fract());
        let (to_b, to_c) = (node(1.0, 0.0), node(0.0, 1.0));
        if right + up > 1.0 {
            let beyond = right + up - 1.0;
            [
                (node(1.0, 1.0), beyond),
                (to_b, 1.0 - up),
                (to_c, 1.0 - right),
            ]
        } else {
            let rest = 1.0 - right - up;
            [(node(0.0, 0.0), rest), (to_b, right), (to_c, up)]
        }
    }

    /// Where a node of a triangle is.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn place(&self, triangle_index: usize, node: TriangleNode) -> TrianglePlace {
        let corners = self.corners(triangle_index);
        let n_cells = f64::from(node.n_cells);
        let [b, c] = node.steps.map(|step| f64::from(step) / n_cells);
        let inside = INSIDE / n_cells;
        let weights = [1.0 - b - c, b, c].map(|weight| (1.0 - inside) * weight + inside / 3.0);
        let parts = corners
            .iter()
            .zip(weights)
            .map(|(corner, weight)| weight * *corner);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normals = self.normals(triangle_index);
        TrianglePlace {
            point: parts.sum(),
            normal,
            smooth_normal: normals.map_or(normal, |normals| between(normals, weights, normal)),
        }
    }
}

/// Barycentric weights of the place on a triangle nearest to a point over it; those of its first corner where it has no area.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    if area <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let of_b = (point - a).cross(c - a).dot(normal) / area;
    let of_c = (b - a).cross(point - a).dot(normal) / area;
    // A point that a ray met may lie outside by its rounding.
    let weights = [1.0 - of_b - of_c, of_b, of_c].map(|weight| weight.max(0.0));
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(5.0, 2.5, 3.0),
        DVec3::new(2.0, 2.0, -4.0),
    ];

    fn mesh() -> TriangleMesh {
        TriangleMesh::new(&CORNERS, &[[0, 1, 2]]).unwrap()
    }

    fn points() -> impl Iterator<Item = DVec3> {
        let [a, b, c] = CORNERS;
        let corners_and_middle = [a, b, c, (a + b + c) / 3.0, 0.5 * (b + c)];
        let within = (1..200).map(move |n| {
            let [u, v] = [0.7548, 0.5698].map(|step| (f64::from(n) * step).fract());
            let [u, v] = if u + v > 1.0 {
                [1.0 - u, 1.0 - v]
            } else {
                [u, v]
            };
            a + u * (b - a) + v * (c - a)
        });
        corners_and_middle.into_iter().chain(within)
    }

    #[test]
    fn weights_add_up_to_the_point_but_for_the_shift_inwards() {
        let mesh = mesh();
        let size_m = (CORNERS[1] - CORNERS[2]).length();
        for n_cells in [1, 2, 7, 64] {
            for point in points() {
                let nodes = mesh.nodes_around(0, point, n_cells);
                let sum: f64 = nodes.iter().map(|(_, weight)| weight).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
                assert!(nodes.iter().all(|(_, weight)| *weight >= 0.0));
                let mean: DVec3 = nodes
                    .map(|(it, weight)| weight * mesh.place(0, it).point)
                    .iter()
                    .sum();
                let shift_m = INSIDE * size_m / f64::from(n_cells);
                assert!(mean.distance(point) < shift_m, "{mean} {point}");
                // No node that counts lies farther away than a cell.
                for (node, _) in nodes.iter().filter(|(_, weight)| *weight > 1e-12) {
                    let [i, j] = node.steps;
                    assert!(i + j <= n_cells, "{node:?}");
                    let away_m = mesh.place(0, *node).point.distance(point);
                    assert!(away_m < (1.0 + INSIDE) * size_m / f64::from(n_cells));
                }
            }
        }
    }

    #[test]
    fn nodes_lie_inside_of_every_edge() {
        let mesh = mesh();
        let [a, b, c] = CORNERS;
        for (node, away) in [([0, 0], [a, b]), ([4, 0], [b, c]), ([0, 4], [c, a])] {
            let node = TriangleNode {
                steps: node,
                n_cells: 4,
            };
            let place = mesh.place(0, node);
            let across = place.normal.cross(away[1] - away[0]);
            assert!((place.point - away[0]).dot(across) > 0.0, "{place:?}");
        }
    }

    #[test]
    fn triangles_without_area_have_nodes_too() {
        let corners = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        let mesh = TriangleMesh::new(&corners, &[[0, 1, 2]]).unwrap();
        let [(node, weight), ..] = mesh.nodes_around(0, DVec3::X, 3);
        assert_eq!((node.steps, weight), ([0, 0], 1.0));
        assert!(mesh.place(0, node).point.is_finite());
    }

    #[test]
    fn normals_of_corners_are_those_of_the_nodes_there() {
        use glam::Vec3;
        let attributes = crate::TriangleAttributes {
            normals: vec![[Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::Y]],
            ..crate::TriangleAttributes::default()
        };
        let mesh = TriangleMesh::with_attributes(&CORNERS, &[[0, 1, 2]], attributes).unwrap();
        let of = |steps| {
            mesh.place(
                0,
                TriangleNode {
                    steps,
                    n_cells: 1000,
                },
            )
            .smooth_normal
        };
        assert!(of([0, 0]).distance(DVec3::Y) < 1e-3);
        assert!(of([1000, 0]).distance(DVec3::new(0.6, 0.8, 0.0)) < 1e-3);
    }
}
