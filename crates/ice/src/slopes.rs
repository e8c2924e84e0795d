//! How steep a mesh is, smoothed over its triangles.
//!
//! At a corner of a triangle: the mean of the normals of the triangles that meet there, by area, without
//! those that a crease divides from it; between the corners linear. So a slope changes within a triangle
//! instead of at its edges, but a cube keeps its faces.
//! [G71] H. Gouraud, IEEE Trans. Computers C-20, 623-629 (1971).

use glam::DVec3;
use niji_geometry::TriangleMesh;

/// Triangles whose normals are farther apart than 60 degrees meet in a crease.
const COS_CREASE: f64 = 0.5;

/// The upward part of the normals of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Slopes {
    /// By triangle and corner: cosine of the angle from level ground. f32: it draws a line, no more.
    corner_cosines: Vec<[f32; 3]>,
}

impl Slopes {
    /// The slopes of a mesh.
    pub(crate) fn new(mesh: &TriangleMesh) -> Self {
        let area_normals: Vec<DVec3> = (0..mesh.triangles().len())
            .map(|index| {
                let [a, b, c] = mesh.corners(index);
                (b - a).cross(c - a)
            })
            .collect();
        let around = triangles_around(mesh);
        let of_corner = |own: DVec3, vertex: u32| {
            let own = own.normalize_or_zero();
            let near = around[vertex as usize]
                .iter()
                .map(|&index| area_normals[index as usize])
                .filter(|normal| normal.dot(own) >= COS_CREASE * normal.length());
            near.sum::<DVec3>().normalize_or(own).y as f32
        };
        let corners = mesh.triangles().iter().zip(&area_normals);
        Self {
            corner_cosines: corners
                .map(|(vertices, &own)| vertices.map(|vertex| of_corner(own, vertex)))
                .collect(),
        }
    }

    /// Cosine of the slope at a point of a triangle.
    pub(crate) fn cos_at(&self, mesh: &TriangleMesh, triangle_index: usize, point: DVec3) -> f64 {
        let [a, b, c] = mesh.corners(triangle_index);
        let [at_a, at_b, at_c] = self.corner_cosines[triangle_index].map(f64::from);
        let across = (b - a).cross(c - a);
        let squared = across.length_squared();
        // Stored zeros are exact: a triangle without area has one slope.
        if squared == 0.0 {
            return at_a;
        }
        let to_b = (point - a).cross(c - a).dot(across) / squared;
        let to_c = (b - a).cross(point - a).dot(across) / squared;
        at_a + to_b * (at_b - at_a) + to_c * (at_c - at_a)
    }
}

/// The triangles at every vertex.
fn triangles_around(mesh: &TriangleMesh) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); mesh.vertices().len()];
    for (index, vertices) in mesh.triangles().iter().enumerate() {
        for &vertex in vertices {
            around[vertex as usize].push(index as u32);
        }
    }
    around
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_geometry::Aabb;

    #[test]
    fn a_cube_keeps_its_faces() {
        let (min, max) = (DVec3::ZERO, DVec3::ONE);
        let cube = TriangleMesh::of_box(Aabb { min, max });
        let slopes = Slopes::new(&cube);
        for index in 0..12 {
            let [a, b, c] = cube.corners(index);
            let normal = (b - a).cross(c - a).normalize();
            for point in [a, b, (a + b + c) / 3.0] {
                assert!((slopes.cos_at(&cube, index, point) - normal.y).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn the_slope_is_the_same_on_both_sides_of_an_edge_of_a_ball() {
        let iceberg = crate::iceberg::Iceberg {
            length_m: 1.0,
            seed: 0,
            ruggedness: 0.0,
        };
        let mesh = iceberg.mesh().unwrap();
        let slopes = Slopes::new(&mesh);
        let around = triangles_around(&mesh);
        let mut worst: f64 = 0.0;
        for (triangles, &point) in around.iter().zip(mesh.vertices()).take(200) {
            let at = |&index: &u32| slopes.cos_at(&mesh, index as usize, point);
            let found: Vec<f64> = triangles.iter().map(at).collect();
            for cosine in &found {
                worst = worst.max((cosine - found[0]).abs());
            }
        }
        // f32: found 6e-8.
        assert!(worst < 1e-6, "{worst}");
    }
}
