//! Triangle meshes.
//!
//! V = sum over triangles  a · (b × c) / 6,   A = sum |(b − a) × (c − a)| / 2
//! `a, b, c` corners in metres, counterclockwise seen from outside, so that a closed body has V > 0.

use std::collections::HashMap;

use glam::DAffine3;
use glam::DVec3;
use glam::Vec2;
use glam::Vec3;

use crate::aabb::Aabb;
use crate::error::Error;
use crate::mesh_normals::on_its_side;

/// Triangles over shared corners; finite, with indices that exist, and not empty.
///
/// ```
/// use niji_geometry::{Aabb, TriangleMesh};
/// use glam::DVec3;
/// let cube = TriangleMesh::of_box(Aabb { min: DVec3::ZERO, max: DVec3::splat(2.0) });
/// assert_eq!((cube.volume_m3(), cube.area_m2()), (8.0, 24.0));
/// assert!(cube.check_closed().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Of as many triangles as there are, or of none.
    attributes: TriangleAttributes,
}

/// What is known of triangles beside their corners: each list has as many entries as there are triangles, or fewer,
/// where nothing is known of the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleAttributes {
    /// Normals at the corners of a smooth surface of any length; 0 where the triangle is its own surface.
    // f32: as files have them, and light leaves in f32.
    pub normals: Vec<[Vec3; 3]>,
    /// Texture coordinates at the corners: u to the right and v down from the first texel of a picture, 1 a whole one.
    pub uv: Vec<[Vec2; 3]>,
    /// Which of the materials of a file ([`MeshMaterial`](crate::MeshMaterial)).
    pub materials: Vec<u32>,
}

impl TriangleMesh {
    /// A mesh from corners in metres and triples of their indices.
    ///
    /// Corners at equal positions become one, so that files which repeat them at every triangle
    /// (STL) hold bodies too. Triangles with two equal corners have no area and no edge that counts,
    /// and are left out; slivers of area 0 with three different corners stay, because their
    /// neighbors need their edges.
    ///
    /// # Errors
    /// A corner that is not finite, an index without a corner, or nothing left.
    pub fn new(corners: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, Error> {
        Self::with_attributes(corners, triangles, TriangleAttributes::default())
    }

    /// The same of triangles of which more is known.
    ///
    /// Normals become unit vectors. Those that cannot be of a surface near their triangle become its own
    /// (`mesh_normals`).
    ///
    /// # Errors
    /// As [`TriangleMesh::new`], and a normal or a texture coordinate that is not finite.
    pub fn with_attributes(
        corners: &[DVec3],
        triangles: &[[u32; 3]],
        mut attributes: TriangleAttributes,
    ) -> Result<Self, Error> {
        if let Some(index) = corners.iter().position(|corner| !corner.is_finite()) {
            return Err(Error::VertexNotFinite { index });
        }
        let n_vertices = corners.len();
        let missing = triangles.iter().flatten();
        if let Some(&index) = missing.into_iter().find(|&&i| i as usize >= n_vertices) {
            return Err(Error::VertexIndex { index, n_vertices });
        }
        let is_finite = |normals: &[Vec3; 3]| normals.iter().all(|normal| normal.is_finite());
        if let Some(index) = attributes.normals.iter().position(|it| !is_finite(it)) {
            return Err(Error::NormalNotFinite { index });
        }
        let is_finite = |uv: &[Vec2; 3]| uv.iter().all(|uv| uv.is_finite());
        if let Some(index) = attributes.uv.iter().position(|it| !is_finite(it)) {
            return Err(Error::UvNotFinite { index });
        }
        let (vertices, renamed) = welded(corners);
        let triangles = triangles
            .iter()
            .map(|triangle| triangle.map(|index| renamed[index as usize]));
        let has_area: Vec<bool> = triangles
            .clone()
            .map(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let triangles: Vec<[u32; 3]> = kept(triangles, &has_area).collect();
        if triangles.is_empty() {
            return Err(Error::EmptyMesh);
        }
        attributes.keep(&has_area, triangles.len());
        let mut mesh = Self {
            vertices,
            triangles,
            attributes,
        };
        mesh.mend_normals();
        Ok(mesh)
    }

    /// Leaves no normal that its triangle could not have.
    fn mend_normals(&mut self) {
        let mut normals = std::mem::take(&mut self.attributes.normals);
        for (index, normals) in normals.iter_mut().enumerate() {
            *normals = on_its_side(*normals, self.corners(index));
        }
        self.attributes.normals = normals;
    }

    /// The surface of a box.
    #[must_use]
    pub fn of_box(aabb: Aabb) -> Self {
        let corner = |index: usize| {
            let pick = |axis: usize| {
                if index >> axis & 1 == 1 {
                    aabb.max[axis]
                } else {
                    aabb.min[axis]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        // Corner numbers hold x, y, z in their bits 0, 1, 2.
        let faces = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let triangles = faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        Self {
            vertices: (0..8).map(corner).collect(),
            triangles: triangles.collect(),
            attributes: TriangleAttributes::default(),
        }
    }

    /// Corners in metres.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Indices of the corners of every triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Unit normals of the smooth surface at the corners of a triangle, on its outer side; `None` of a mesh that has none.
    #[must_use]
    pub fn normals(&self, triangle_index: usize) -> Option<[Vec3; 3]> {
        self.attributes.normals.get(triangle_index).copied()
    }

    /// Material of a triangle and texture coordinates at its corners; 0 where none are known.
    #[must_use]
    pub fn painted(&self, triangle_index: usize) -> (u32, [Vec2; 3]) {
        let TriangleAttributes { uv, materials, .. } = &self.attributes;
        let material = materials.get(triangle_index).copied().unwrap_or_default();
        (
            material,
            uv.get(triangle_index).copied().unwrap_or_default(),
        )
    }

    /// Whether more is known of a triangle than its corners.
    pub(crate) fn has_attributes(&self) -> bool {
        let TriangleAttributes {
            normals,
            uv,
            materials,
        } = &self.attributes;
        !(normals.is_empty() && uv.is_empty() && materials.is_empty())
    }

    /// The three corners of a triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    #[inline]
    pub fn corners(&self, triangle_index: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle_index];
        let vertices = &self.vertices;
        // An array's `map` was a call for each of them.
        [
            vertices[a as usize],
            vertices[b as usize],
            vertices[c as usize],
        ]
    }

    /// The smallest box around the mesh.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        box_around(self.vertices.iter().copied())
    }

    /// Signed volume inside, m³: positive where triangles run counterclockwise seen from outside.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        // About the middle of the box: far from the origin the terms would cancel.
        let bounds = self.bounds();
        let middle = 0.5 * (bounds.min + bounds.max);
        let signed = |index| {
            let [a, b, c] = self.corners(index).map(|corner| corner - middle);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.triangles.len()).map(signed).sum()
    }

    /// Area, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        (0..self.triangles.len())
            .map(|index| self.triangle_area_m2(index))
            .sum()
    }

    /// Area of one triangle, m².
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn triangle_area_m2(&self, triangle_index: usize) -> f64 {
        let [a, b, c] = self.corners(triangle_index);
        0.5 * (b - a).cross(c - a).length()
    }

    /// The mesh turned, stretched and moved, with all that is known of its triangles.
    ///
    /// Normals go by the inverse transpose, which keeps them across the surface.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`] for the moved corners.
    pub fn placed(&self, to_world: &DAffine3) -> Result<Self, Error> {
        let place = |&corner: &DVec3| to_world.transform_point3(corner);
        let corners: Vec<DVec3> = self.vertices.iter().map(place).collect();
        let mut attributes = self.attributes.clone();
        let across = to_world.matrix3.inverse().transpose();
        for normal in attributes.normals.iter_mut().flatten() {
            *normal = (across * normal.as_dvec3()).normalize_or_zero().as_vec3();
        }
        Self::with_attributes(&corners, &self.triangles, attributes)
    }

    /// The shape alone with every corner moved by `place`.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`] for the moved corners.
    pub fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Result<Self, Error> {
        let corners: Vec<DVec3> = self.vertices.iter().map(|&corner| place(corner)).collect();
        Self::new(&corners, &self.triangles)
    }

    /// The mesh turned inside out.
    #[must_use]
    pub fn turned_inside_out(mut self) -> Self {
        for [_, b, c] in &mut self.triangles {
            std::mem::swap(b, c);
        }
        for [a, b, c] in &mut self.attributes.normals {
            std::mem::swap(b, c);
            [*a, *b, *c] = [-*a, -*b, -*c];
        }
        for [_, b, c] in &mut self.attributes.uv {
            std::mem::swap(b, c);
        }
        self
    }

    /// How often the surface winds around a point: 1 inside a simple body, 0 outside.
    ///
    /// Sum of the signed solid angles of all triangles over 4 pi, which is an integer for a closed
    /// mesh: tan(Omega/2) = a·(b×c) / (abc + (a·b)c + (b·c)a + (c·a)b), A. van Oosterom and
    /// J. Strackee, IEEE Trans. Biomedical Engineering 30, 125-126 (1983).
    #[must_use]
    pub fn winding_number(&self, point: DVec3) -> i32 {
        let half_angle = |index| {
            let [a, b, c] = self.corners(index).map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            a.dot(b.cross(c)).atan2(below)
        };
        let sum: f64 = (0..self.triangles.len()).map(half_angle).sum();
        (sum / std::f64::consts::TAU).round() as i32
    }
}

impl TriangleAttributes {
    /// Leaves those of triangles that are kept, `n` of them; nothing where nothing is known.
    fn keep(&mut self, is_kept: &[bool], n: usize) {
        keep(&mut self.normals, is_kept, n);
        keep(&mut self.uv, is_kept, n);
        keep(&mut self.materials, is_kept, n);
    }
}

/// Leaves of a list those that are kept, `n` of them, the rest unknown; nothing where nothing is known.
fn keep<T: Copy + Default + PartialEq>(list: &mut Vec<T>, is_kept: &[bool], n: usize) {
    let unknown = T::default();
    if list.iter().all(|it| *it == unknown) {
        *list = Vec::new();
    } else {
        *list = kept(list.iter().copied(), is_kept).collect();
        list.resize(n, unknown);
    }
}

/// Those of some things that are kept.
fn kept<T>(things: impl Iterator<Item = T>, is_kept: &[bool]) -> impl Iterator<Item = T> {
    let pairs = things.zip(is_kept);
    pairs.filter_map(|(thing, is_kept)| is_kept.then_some(thing))
}

/// The smallest box around points; one that contains nothing for no points.
pub(crate) fn box_around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
    let nothing = Aabb {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    points.into_iter().fold(nothing, |aabb, point| Aabb {
        min: aabb.min.min(point),
        max: aabb.max.max(point),
    })
}

/// Different corners, and for each given corner the number of the one it became.
fn welded(corners: &[DVec3]) -> (Vec<DVec3>, Vec<u32>) {
    let mut numbers = HashMap::new();
    let mut vertices = Vec::new();
    let renamed = corners.iter().map(|&corner| {
        // Adding 0 makes -0 and 0 one position.
        let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
        *numbers.entry(key).or_insert_with(|| {
            vertices.push(corner);
            vertices.len() as u32 - 1
        })
    });
    let renamed = renamed.collect();
    (vertices, renamed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> TriangleMesh {
        TriangleMesh::of_box(Aabb {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        })
    }

    #[test]
    fn a_cube_has_the_volume_and_area_of_a_cube_wherever_it_stands() {
        assert_eq!(cube().volume_m3(), 8.0);
        assert_eq!(cube().area_m2(), 24.0);
        let far = cube().moved(|corner| corner + 1e6).unwrap();
        assert_eq!(far.volume_m3(), 8.0);
        assert_eq!(cube().turned_inside_out().volume_m3(), -8.0);
    }

    #[test]
    fn the_winding_number_is_one_inside_and_zero_outside() {
        assert_eq!(cube().winding_number(DVec3::splat(0.9)), 1);
        assert_eq!(cube().winding_number(DVec3::splat(1.1)), 0);
        assert_eq!(cube().turned_inside_out().winding_number(DVec3::ZERO), -1);
    }

    #[test]
    fn repeated_corners_become_one_and_collapsed_triangles_go() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let minus_zero = DVec3::new(-0.0, 0.0, -0.0);
        let mesh = TriangleMesh::new(&[a, b, c, minus_zero], &[[0, 1, 2], [0, 1, 3]]).unwrap();
        assert_eq!(mesh.vertices().len(), 3);
        assert_eq!(mesh.triangles(), &[[0, 1, 2]]);
    }

    #[test]
    fn a_mesh_that_is_placed_or_turned_over_keeps_its_normals_across_its_surface() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let attributes = TriangleAttributes {
            normals: vec![[Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::Z]],
            ..TriangleAttributes::default()
        };
        let mesh = TriangleMesh::with_attributes(&corners, &[[0, 1, 2]], attributes).unwrap();
        // A plane across (0.6, 0, 0.8) holds (0.8, 0, -0.6), which becomes (1.6, 0, -0.6).
        let placed = mesh
            .placed(&DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0)))
            .unwrap();
        let expected = Vec3::new(0.6, 0.0, 1.6).normalize();
        assert!((placed.normals(0).unwrap()[1] - expected).length() < 1e-6);
        let over = placed.turned_inside_out();
        assert!((over.normals(0).unwrap()[2] + expected).length() < 1e-6);
    }

    #[test]
    fn impossible_meshes_are_refused() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let nan = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, f64::NAN, 0.0)];
        assert_eq!(
            TriangleMesh::new(&nan, &[[0, 1, 2]]),
            Err(Error::VertexNotFinite { index: 2 })
        );
        let attributes = TriangleAttributes {
            normals: vec![[Vec3::Z, Vec3::NAN, Vec3::Z]],
            ..TriangleAttributes::default()
        };
        assert_eq!(
            TriangleMesh::with_attributes(&corners, &[[0, 1, 2]], attributes),
            Err(Error::NormalNotFinite { index: 0 })
        );
        let missing = TriangleMesh::new(&corners, &[[0, 1, 3]]);
        assert!(matches!(missing, Err(Error::VertexIndex { index: 3, .. })));
        assert_eq!(TriangleMesh::new(&corners, &[]), Err(Error::EmptyMesh));
        let collapsed = TriangleMesh::new(&corners, &[[0, 1, 1]]);
        assert_eq!(collapsed, Err(Error::EmptyMesh));
    }
}
