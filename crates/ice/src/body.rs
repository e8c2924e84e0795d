//! A body of ice, as rays see it.
//!
//! Ice is where the surface winds around a point at least once, so meshes that overlap or cut
//! themselves are the union of what they enclose. A ray counts: plus one where it meets the surface
//! from outside, minus one from inside; only the steps between 0 and 1 are surfaces.
//! Mean chord of isotropic light through a convex body: 4 V/S (Cauchy), 2 s/3 for a cube of edge s.

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::MeshBvh;
use niji_geometry::Ray;
use niji_geometry::TriangleMesh;

use crate::error::Error;
use crate::slopes::Slopes;

/// Crossings nearer than this share of the body's diagonal are the point where the ray starts.
const NEAR: f64 = 1e-9;
/// The same for a body far from the origin, as a share of its coordinates: several roundings.
const NEAR_OF_COORDINATE: f64 = 1e-14;
/// How much farther the next crossing is looked for, so that an edge shared by two triangles counts
/// once.
const BEHIND: f64 = 1.0 + 1e-12;

/// A body of ice.
///
/// ```
/// use niji_geometry::Aabb;
/// use niji_ice::Body;
/// use glam::DVec3;
/// let cube = Body::of_box(Aabb { min: DVec3::ZERO, max: DVec3::splat(3.0) })?;
/// assert_eq!(cube.mean_chord_m(), 2.0);
/// # Ok::<(), niji_ice::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Body {
    shape: Shape,
    near_m: f64,
    volume_m3: f64,
    /// Area of the surface up to and with each part: faces of a box, triangles of a mesh.
    areas_m2: Vec<f64>,
}

#[derive(Debug, Clone)]
enum Shape {
    Box(Aabb),
    Mesh(MeshBvh, Slopes),
}

/// Where a ray enters or leaves a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) distance_m: f64,
    /// Unit vector out of the body.
    pub(crate) normal: DVec3,
    /// The triangle of a mesh; 0 for a box.
    triangle_index: usize,
}

/// How a way inside a body ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// At the surface.
    Out(Crossing),
    /// Inside, as far as it was to go, where the surface winds this often.
    Within(i32),
}

impl Body {
    /// A box.
    ///
    /// # Errors
    /// A box without volume, or one that is not finite.
    pub fn of_box(aabb: Aabb) -> Result<Self, Error> {
        let size = aabb.size();
        // The mesh has the right words for corners that are not finite.
        let mesh = TriangleMesh::of_box(aabb);
        let mesh = TriangleMesh::new(mesh.vertices(), mesh.triangles())?;
        if size.min_element() <= 0.0 {
            return Err(niji_geometry::Error::FlatMesh.into());
        }
        mesh.check_closed()?;
        let face = [size.y * size.z, size.z * size.x, size.x * size.y];
        Ok(Self {
            shape: Shape::Box(aabb),
            near_m: near_m(aabb),
            volume_m3: size.x * size.y * size.z,
            areas_m2: cumulated((0..6).map(|index| face[index / 2])),
        })
    }

    /// What a mesh encloses.
    ///
    /// # Errors
    /// A mesh that is open or encloses nothing.
    pub fn of_mesh(mesh: TriangleMesh) -> Result<Self, Error> {
        let mesh = mesh.into_body()?;
        let n_triangles = mesh.triangles().len();
        let areas = (0..n_triangles).map(|index| mesh.triangle_area_m2(index));
        Ok(Self {
            near_m: near_m(mesh.bounds()),
            volume_m3: mesh.volume_m3(),
            areas_m2: cumulated(areas),
            shape: {
                let slopes = Slopes::new(&mesh);
                Shape::Mesh(MeshBvh::new(mesh), slopes)
            },
        })
    }

    /// Volume, m³; parts that overlap count twice.
    pub fn volume_m3(&self) -> f64 {
        self.volume_m3
    }

    /// Area of the surface, m²; parts inside others count.
    pub fn area_m2(&self) -> f64 {
        self.areas_m2.last().copied().unwrap_or_default()
    }

    /// Mean chord 4 V/S, m.
    pub fn mean_chord_m(&self) -> f64 {
        4.0 * self.volume_m3 / self.area_m2()
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        match &self.shape {
            Shape::Box(aabb) => *aabb,
            Shape::Mesh(bvh, _) => bvh.bounds(),
        }
    }

    /// From corner to corner of that box, m.
    pub(crate) fn diagonal_m(&self) -> f64 {
        self.bounds().size().length()
    }

    /// How often the surface winds around a point: 0 outside.
    pub(crate) fn winding_at(&self, point: DVec3) -> i32 {
        match &self.shape {
            Shape::Box(aabb) => i32::from(aabb.contains(point)),
            Shape::Mesh(bvh, _) => bvh.mesh().winding_number(point),
        }
    }

    /// Where a ray from outside enters; the surface that it starts on does not count.
    pub(crate) fn enter(&self, ray: &Ray) -> Option<Crossing> {
        match &self.shape {
            Shape::Box(aabb) => {
                let (crossing, _) = box_crossings(aabb, ray)?;
                (crossing.distance_m > self.near_m).then_some(crossing)
            }
            Shape::Mesh(bvh, _) => {
                let mut winding = 0;
                self.crossings(bvh, ray, |crossing, step| {
                    winding += step;
                    (winding == 1 && step == 1).then_some(crossing)
                })
            }
        }
    }

    /// How a way from inside ends, at the surface or after `length_m`.
    ///
    /// A way that finds no surface, because rounding put its start outside, ends where it begins.
    pub(crate) fn leave(&self, ray: &Ray, winding: i32, length_m: f64) -> Way {
        let mut winding = winding;
        let here = Crossing {
            distance_m: 0.0,
            normal: ray.direction,
            triangle_index: 0,
        };
        let found = match &self.shape {
            Shape::Box(aabb) => {
                let leaves = box_crossings(aabb, ray).map(|(_, leave)| leave);
                let leaves = leaves.unwrap_or(here);
                if leaves.distance_m > length_m {
                    return Way::Within(1);
                }
                Some(leaves)
            }
            Shape::Mesh(bvh, _) => {
                let mut is_within = false;
                let found = self.crossings(bvh, ray, |crossing, step| {
                    is_within = crossing.distance_m > length_m;
                    if !is_within {
                        winding += step;
                    }
                    (is_within || winding <= 0).then_some(crossing)
                });
                if is_within {
                    return Way::Within(winding);
                }
                found
            }
        };
        Way::Out(found.unwrap_or(here))
    }

    /// Cosine of the angle between the surface and level ground where a way crosses it, smoothed over
    /// the triangles of a mesh.
    pub(crate) fn cos_slope(&self, crossing: &Crossing, point: DVec3) -> f64 {
        match &self.shape {
            Shape::Box(_) => crossing.normal.y,
            Shape::Mesh(bvh, slopes) => slopes.cos_at(bvh.mesh(), crossing.triangle_index, point),
        }
    }

    /// The first crossing that `pick` takes; it is told +1 for every one from outside, -1 from inside.
    fn crossings(
        &self,
        bvh: &MeshBvh,
        ray: &Ray,
        mut pick: impl FnMut(Crossing, i32) -> Option<Crossing>,
    ) -> Option<Crossing> {
        let mut after_m = self.near_m;
        loop {
            let hit = bvh.nearest(ray, after_m)?;
            let crossing = Crossing {
                distance_m: hit.distance_m,
                normal: hit.normal,
                triangle_index: hit.triangle_index,
            };
            let step = if hit.is_from_inside { -1 } else { 1 };
            if let Some(picked) = pick(crossing, step) {
                return Some(picked);
            }
            after_m = hit.distance_m * BEHIND;
        }
    }

    /// A point of the surface and the normal there, uniform by area; for a mesh that overlaps also on
    /// parts inside.
    pub(crate) fn surface_point(&self, [part, u, v]: [f64; 3]) -> (DVec3, DVec3) {
        let wanted_m2 = part * self.area_m2();
        let index = self.areas_m2.partition_point(|&area| area <= wanted_m2);
        let index = index.min(self.areas_m2.len() - 1);
        match &self.shape {
            Shape::Box(aabb) => {
                let (axis, is_high) = (index / 2, index % 2 == 1);
                let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut point = aabb.min;
                point[second] += u * aabb.size()[second];
                point[third] += v * aabb.size()[third];
                if is_high {
                    point[axis] = aabb.max[axis];
                }
                (point, axis_normal(axis, is_high))
            }
            Shape::Mesh(bvh, _) => {
                let [a, b, c] = bvh.mesh().corners(index);
                let root = u.sqrt();
                let point = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
                (point, (b - a).cross(c - a).normalize_or(DVec3::Y))
            }
        }
    }
}

fn near_m(bounds: Aabb) -> f64 {
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    NEAR * bounds.size().length() + NEAR_OF_COORDINATE * farthest
}

fn cumulated(areas: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |area| {
        sum += area;
        sum
    };
    areas.map(add).collect()
}

fn axis_normal(axis: usize, is_high: bool) -> DVec3 {
    let mut normal = DVec3::ZERO;
    normal[axis] = if is_high { 1.0 } else { -1.0 };
    normal
}

/// Where a line enters and leaves a box, if it does ahead of the ray; not before the ray starts.
fn box_crossings(aabb: &Aabb, ray: &Ray) -> Option<(Crossing, Crossing)> {
    let nowhere = |distance_m| Crossing {
        distance_m,
        normal: DVec3::ZERO,
        triangle_index: 0,
    };
    let (mut enter, mut leave) = (nowhere(f64::NEG_INFINITY), nowhere(f64::INFINITY));
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let (low, high) = (aabb.min[axis], aabb.max[axis]);
        // Stored zeros are exact.
        if direction == 0.0 {
            if origin < low || origin > high {
                return None;
            }
            continue;
        }
        let rises = direction > 0.0;
        let (first, last) = if rises { (low, high) } else { (high, low) };
        let (near, far) = ((first - origin) / direction, (last - origin) / direction);
        if near > enter.distance_m {
            enter = Crossing {
                distance_m: near,
                normal: axis_normal(axis, !rises),
                triangle_index: 0,
            };
        }
        if far < leave.distance_m {
            leave = Crossing {
                distance_m: far.max(0.0),
                normal: axis_normal(axis, rises),
                triangle_index: 0,
            };
        }
    }
    (enter.distance_m < leave.distance_m).then_some((enter, leave))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    };

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray {
            origin: DVec3::from(origin),
            direction: DVec3::from(direction).normalize(),
        }
    }

    fn cubes(boxes: &[(f64, f64)]) -> Body {
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        for &(low, high) in boxes {
            let (min, max) = (DVec3::splat(low), DVec3::splat(high));
            let cube = TriangleMesh::of_box(Aabb { min, max });
            let first = corners.len() as u32;
            corners.extend_from_slice(cube.vertices());
            triangles.extend(
                cube.triangles()
                    .iter()
                    .map(|t| t.map(|index| index + first)),
            );
        }
        Body::of_mesh(TriangleMesh::new(&corners, &triangles).unwrap()).unwrap()
    }

    #[test]
    fn a_box_and_its_mesh_are_the_same_body() {
        let (solid, mesh) = (Body::of_box(UNIT).unwrap(), cubes(&[(0.0, 1.0)]));
        assert!((solid.mean_chord_m() - 2.0 / 3.0).abs() < 1e-15);
        assert!((mesh.mean_chord_m() - 2.0 / 3.0).abs() < 1e-15);
        for index in 0..500 {
            let [part, u, v, a, b, c] = crate::chi_square::pseudo_random(index);
            let (point, normal) = solid.surface_point([part, u, v]);
            assert_eq!(mesh.winding_at(point - 1e-6 * normal), 1);
            assert_eq!(mesh.winding_at(point + 1e-6 * normal), 0);
            let towards = DVec3::new(a, b, c) - 0.5;
            let inwards = Ray {
                origin: point,
                direction: (towards - 2.0 * towards.dot(normal).max(0.0) * normal).normalize(),
            };
            let out = |body: &Body| match body.leave(&inwards, 1, f64::INFINITY) {
                Way::Out(crossing) => crossing,
                Way::Within(_) => panic!("no way is that long"),
            };
            let (from_box, from_mesh) = (out(&solid), out(&mesh));
            // Worst found 2e-16.
            assert!((from_box.distance_m - from_mesh.distance_m).abs() < 1e-12);
            assert_eq!(from_box.normal, from_mesh.normal);
        }
    }

    #[test]
    fn the_surface_where_a_ray_starts_does_not_count() {
        for body in [Body::of_box(UNIT).unwrap(), cubes(&[(0.0, 1.0)])] {
            assert_eq!(body.enter(&ray([0.5, 1.0, 0.5], [0.3, 1.0, 0.2])), None);
            let entered = body.enter(&ray([0.5, 3.0, 0.4], [0.0, -1.0, 0.0])).unwrap();
            assert_eq!((entered.distance_m, entered.normal), (2.0, DVec3::Y));
            // Rounding has put the start above the face: the way has no length.
            let start = ray([0.5, 1.0 + 1e-15, 0.5], [0.0, 1.0, 0.0]);
            let Way::Out(here) = body.leave(&start, 1, f64::INFINITY) else {
                panic!("it is out")
            };
            assert_eq!(here.distance_m, 0.0);
        }
    }

    #[test]
    fn overlapping_bodies_are_one_body() {
        let body = cubes(&[(0.0, 1.0), (0.5, 2.0)]);
        assert_eq!(body.winding_at(DVec3::splat(0.75)), 2);
        let through = ray([-1.0, 0.75, 0.75], [1.0, 0.0, 0.0]);
        assert_eq!(
            body.enter(&through).map(|crossing| crossing.distance_m),
            Some(1.0)
        );
        let inside = ray([0.0, 0.75, 0.75], [1.0, 0.0, 0.0]);
        let Way::Out(out) = body.leave(&inside, 1, f64::INFINITY) else {
            panic!("it gets out")
        };
        assert_eq!((out.distance_m, out.normal), (2.0, DVec3::X));
        assert_eq!(body.leave(&inside, 1, 0.75), Way::Within(2));
        assert_eq!(body.leave(&inside, 1, 1.5), Way::Within(1));
    }

    #[test]
    fn bodies_that_are_none_are_refused() {
        let flat = Aabb {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 0.0, 1.0),
        };
        assert!(Body::of_box(flat).is_err());
        let inverted = Aabb {
            min: DVec3::ONE,
            max: DVec3::ZERO,
        };
        assert!(Body::of_box(inverted).is_err());
        let infinite = Aabb {
            min: DVec3::ZERO,
            max: DVec3::INFINITY,
        };
        assert!(Body::of_box(infinite).is_err());
    }
}
