//! What a mesh sees around it, looked for at nodes of its triangles.
//!
//! n = L/s to the nearest power of two
//! `n` cells along a side of a triangle, `L` the longest one, `s` width of a cell (`node_views`). Triangles no wider than a few
//! pixels have no nodes: these would not save a look.

use std::sync::Arc;

use glam::DVec3;
use niji_geometry::TriangleMesh;
use niji_geometry::TriangleNode;
use niji_geometry::TrianglePlace;

use crate::node_views::NodeViews;
use crate::node_views::Seen;
use crate::node_views::View;
use crate::node_views::between;
use crate::surfaces::Face;

/// Triangles that are not as wide everywhere, in cells, have no nodes.
const LEAST_CELLS: f64 = 0.5;

/// Cells along a side of a triangle are no more.
const MOST_CELLS: f64 = (1 << 20) as f64;

/// A node of a side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    triangle: u32,
    is_inside: bool,
    node: TriangleNode,
}

/// A mesh whose nodes look around.
#[derive(Debug)]
pub(crate) struct MeshView<'a> {
    mesh: &'a TriangleMesh,
    known: NodeViews<Key>,
}

impl<'a> MeshView<'a> {
    /// One of which nobody has asked yet.
    pub(crate) fn new(mesh: &'a TriangleMesh) -> Self {
        let known = NodeViews::new();
        Self { mesh, known }
    }

    /// What a place on a face sees, where `look` tells it of a node; `None` where nodes do not know.
    pub(crate) fn at(
        &self,
        (point, face): (DVec3, &Face),
        seen: Seen,
        look: impl Fn(TrianglePlace) -> View,
    ) -> Option<View> {
        let triangle = face.triangle as usize;
        let n_cells = cells(self.mesh.corners(triangle), seen.cell_m())?;
        let nodes = self.mesh.nodes_around(triangle, point, n_cells);
        let views = nodes.map(|(node, weight)| {
            (weight > 0.0).then(|| (self.of_node((node, face), &look), weight))
        });
        between(&views)
    }

    fn of_node(
        &self,
        (node, face): (TriangleNode, &Face),
        look: impl Fn(TrianglePlace) -> View,
    ) -> Arc<View> {
        let mut place = self.mesh.place(face.triangle as usize, node);
        let is_inside = place.normal.dot(face.side) < 0.0;
        let key = Key {
            triangle: face.triangle,
            is_inside,
            node,
        };
        if is_inside {
            place.normal = -place.normal;
            place.smooth_normal = -place.smooth_normal;
        }
        self.known.of(key, || look(place))
    }
}

/// Cells of about a width along a side of a triangle; `None` where nodes would not save a look.
fn cells([a, b, c]: [DVec3; 3], cell_m: f64) -> Option<u32> {
    let longest_m = (b - a).length().max((c - b).length()).max((a - c).length());
    let area_m2 = (b - a).cross(c - a).length();
    let n_cells = (longest_m / cell_m).log2().round().exp2().max(1.0);
    let narrowest_m = area_m2 / longest_m;
    (narrowest_m >= LEAST_CELLS * cell_m && n_cells <= MOST_CELLS).then_some(n_cells as u32)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use glam::DVec2;

    use super::*;

    const PIXEL: Seen = Seen {
        pixel_m: 1.0,
        cosine: 1.0,
    };

    /// A level square of two triangles, 64 m wide.
    fn square() -> TriangleMesh {
        let corners = [
            DVec3::ZERO,
            DVec3::new(0.0, 0.0, 64.0),
            DVec3::new(64.0, 0.0, 64.0),
            DVec3::new(64.0, 0.0, 0.0),
        ];
        TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    fn face(triangle: u32, side: DVec3) -> Face {
        Face {
            side,
            normal: side,
            solid: 0,
            triangle,
            painted: (0, DVec2::ZERO),
        }
    }

    /// A point of the square, and a face of the triangle that it is on.
    fn place(x: f64, z: f64) -> (DVec3, Face) {
        let triangle = u32::from(x > z);
        (DVec3::new(x, 0.0, z), face(triangle, DVec3::Y))
    }

    fn free(free: f64) -> View {
        View { free, ..View::OPEN }
    }

    #[test]
    fn shares_that_change_evenly_are_those_of_the_place_to_the_shift_of_nodes() {
        let mesh = square();
        let view = MeshView::new(&mesh);
        let even = |point: DVec3| 0.3 + 0.002 * point.x + 0.005 * point.z;
        for (x, z) in [(1.0, 60.0), (33.3, 33.2), (63.9, 0.1), (20.0, 7.0)] {
            let (point, face) = place(x, z);
            let seen = view.at((point, &face), PIXEL, |node| free(even(node.point)));
            let found = seen.unwrap().free;
            assert!((found - even(point)).abs() < 0.001, "{found}");
        }
    }

    #[test]
    fn both_sides_of_a_triangle_look_for_themselves_and_once() {
        let mesh = square();
        let view = MeshView::new(&mesh);
        let n_looks = Cell::new(0);
        let point = DVec3::new(10.3, 0.0, 40.4);
        for (side, n_expected) in [(DVec3::Y, 3), (DVec3::NEG_Y, 6), (DVec3::Y, 6)] {
            let seen = view.at((point, &face(0, side)), PIXEL, |node| {
                n_looks.set(n_looks.get() + 1);
                assert_eq!((node.normal, node.smooth_normal), (side, side));
                free(0.75 + 0.1 * side.y)
            });
            assert!((seen.unwrap().free - 0.75 - 0.1 * side.y).abs() < 1e-12);
            assert_eq!(n_looks.get(), n_expected);
        }
    }

    #[test]
    fn a_place_looks_for_itself_where_nodes_disagree_or_see_no_sky() {
        let mesh = square();
        let view = MeshView::new(&mesh);
        let (point, face) = place(10.0, 31.0);
        let closer = Seen {
            pixel_m: 0.5,
            ..PIXEL
        };
        let wall = |node: TrianglePlace| free(if node.point.z > 31.0 { 1.0 } else { 0.5 });
        assert!(view.at((point, &face), PIXEL, wall).is_none());
        assert!(view.at((point, &face), closer, |_| free(0.0)).is_none());
    }

    #[test]
    fn cells_are_a_few_pixels_wide_and_slivers_have_none() {
        let wide = [DVec3::ZERO, 64.0 * DVec3::X, 64.0 * DVec3::Z];
        let longest_m = 64.0 * std::f64::consts::SQRT_2;
        for cell_m in [0.01, 0.5, 3.0, 50.0] {
            let n_cells = f64::from(cells(wide, cell_m).unwrap());
            let ratio = longest_m / n_cells / cell_m;
            assert!((0.7..1.42).contains(&ratio), "{cell_m}: {ratio}");
        }
        assert_eq!(cells(wide, 200.0), None);
        assert_eq!(
            cells([DVec3::ZERO, 64.0 * DVec3::X, 0.1 * DVec3::Z], 1.0),
            None
        );
        assert_eq!(cells([DVec3::ZERO; 3], 1.0), None);
        assert_eq!(cells(wide, 1e-9), None);
    }
}
