//! Whether a mesh encloses a body.
//!
//! In a closed, consistently oriented surface every edge is run through as often in one direction as
//! in the other. Bodies that touch or overlap pass too: what they enclose together is where the
//! surface winds around a point at least once.

use std::collections::BTreeMap;

use crate::error::Error;
use crate::mesh::TriangleMesh;

impl TriangleMesh {
    /// Checks that the mesh encloses a body.
    ///
    /// # Errors
    /// [`Error::OpenMesh`] if an edge is run through more often in one direction than in the other (a
    /// hole, or triangles that contradict each other about what is outside), [`Error::FlatMesh`] if
    /// nothing is enclosed.
    pub fn check_closed(&self) -> Result<(), Error> {
        let mut surplus: BTreeMap<(u32, u32), i64> = BTreeMap::new();
        for &[a, b, c] in self.triangles() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let sign = if from < to { 1 } else { -1 };
                *surplus.entry((from.min(to), from.max(to))).or_default() += sign;
            }
        }
        let mut open = surplus.iter().filter(|(_, count)| **count != 0);
        if let Some((&(from, to), _)) = open.next() {
            return Err(Error::OpenMesh {
                n_edges: 1 + open.count(),
                from: self.vertices()[from as usize],
                to: self.vertices()[to as usize],
            });
        }
        let size = self.bounds().size();
        // Rounding of a volume is far below this share of the box.
        if self.volume_m3().abs() <= 1e-12 * size.x * size.y * size.z {
            return Err(Error::FlatMesh);
        }
        Ok(())
    }

    /// The mesh with its outside outside: turned over if it encloses a negative volume.
    ///
    /// # Errors
    /// As [`TriangleMesh::check_closed`].
    pub fn into_body(self) -> Result<Self, Error> {
        self.check_closed()?;
        if self.volume_m3() < 0.0 {
            return Ok(self.turned_inside_out());
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::aabb::Aabb;

    fn cube(min: f64, max: f64) -> TriangleMesh {
        let (min, max) = (DVec3::splat(min), DVec3::splat(max));
        TriangleMesh::of_box(Aabb { min, max })
    }

    fn both(a: &TriangleMesh, b: &TriangleMesh) -> TriangleMesh {
        let shift = a.vertices().len() as u32;
        let shifted = b.triangles().iter().map(|t| t.map(|i| i + shift));
        let corners: Vec<_> = a.vertices().iter().chain(b.vertices()).copied().collect();
        let triangles: Vec<_> = a.triangles().iter().copied().chain(shifted).collect();
        TriangleMesh::new(&corners, &triangles).unwrap()
    }

    #[test]
    fn a_cube_without_a_triangle_is_open_at_three_edges() {
        let cube = cube(0.0, 1.0);
        let open = TriangleMesh::new(cube.vertices(), &cube.triangles()[1..]).unwrap();
        assert!(matches!(
            open.check_closed(),
            Err(Error::OpenMesh { n_edges: 3, .. })
        ));
    }

    #[test]
    fn triangles_that_contradict_each_other_are_open() {
        let mut triangles = cube(0.0, 1.0).triangles().to_vec();
        triangles[0].swap(1, 2);
        let twisted = TriangleMesh::new(cube(0.0, 1.0).vertices(), &triangles).unwrap();
        assert!(matches!(
            twisted.check_closed(),
            Err(Error::OpenMesh { n_edges: 3, .. })
        ));
    }

    #[test]
    fn bodies_that_overlap_or_share_an_edge_are_closed() {
        assert!(
            both(&cube(0.0, 1.0), &cube(0.5, 2.0))
                .check_closed()
                .is_ok()
        );
        assert!(
            both(&cube(0.0, 1.0), &cube(1.0, 2.0))
                .check_closed()
                .is_ok()
        );
        let overlap = both(&cube(0.0, 1.0), &cube(0.5, 2.0));
        assert_eq!(overlap.winding_number(DVec3::splat(0.75)), 2);
    }

    #[test]
    fn a_body_turned_inside_out_is_turned_back() {
        let body = cube(0.0, 1.0).turned_inside_out().into_body().unwrap();
        assert_eq!(body.volume_m3(), 1.0);
    }

    #[test]
    fn a_sheet_with_two_sides_encloses_nothing() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let sheet = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 1]]).unwrap();
        assert_eq!(sheet.check_closed(), Err(Error::FlatMesh));
    }
}
