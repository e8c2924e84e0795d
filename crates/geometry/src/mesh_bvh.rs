//! The nearest triangle along a ray, through a tree of boxes.
//!
//! Nodes are split where  A_left n_left + A_right n_right  is smallest over 16 planes of the longest
//! axis (`A` area of the box around, `n` number of triangles): the surface area heuristic.
//! [W07] I. Wald, IEEE Symposium on Interactive Ray Tracing, 33-40 (2007).

mod horizon;

use glam::DVec2;
use glam::DVec3;

use crate::aabb::Aabb;
use crate::mesh::TriangleMesh;
use crate::mesh::box_around;
use crate::mesh_normals::between;
use crate::mesh_triangle::ShearedRay;
use crate::ray::Ray;
use crate::slabs::Slabs;

/// Most triangles in a leaf that could be split.
const LEAF_SIZE: usize = 4;
/// Planes that are tried at every node.
const N_BINS: usize = 16;
/// Deeper nodes than this become leaves; balanced trees of 2^32 triangles are half as deep.
const MAX_DEPTH: usize = 64;

/// Where a ray meets a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance from the origin of the ray, in lengths of its direction, m for a unit vector.
    pub distance_m: f64,
    /// The triangle.
    pub triangle_index: usize,
    /// Unit normal away from the body.
    pub normal: DVec3,
    /// The same of the smooth surface that the mesh stands for; that of the triangle where it has no normals.
    pub smooth_normal: DVec3,
    /// Material and texture coordinates there, right and down; 0 of a mesh that has none.
    pub painted: (u32, DVec2),
    /// Whether the ray meets it from inside.
    pub is_from_inside: bool,
}

/// What is asked of the surfaces along a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    /// The first of them.
    Nearest,
    /// Whether there is one.
    Any,
}

/// A mesh with a tree over it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBvh {
    mesh: TriangleMesh,
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: Aabb,
    /// First triangle of a leaf; right child of an inner node, whose left child is the next node.
    start: u32,
    /// Triangles of a leaf; 0 for an inner node.
    n_triangles: u32,
    /// Axis along which the left child of an inner node lies before the right one.
    axis: u8,
}

impl MeshBvh {
    /// Builds the tree.
    #[must_use]
    pub fn new(mesh: TriangleMesh) -> Self {
        let n_triangles = mesh.triangles().len();
        let boxes = (0..n_triangles).map(|index| box_around(mesh.corners(index)));
        let mut builder = Builder {
            boxes: boxes.collect(),
            nodes: Vec::with_capacity(2 * n_triangles),
            order: (0..n_triangles as u32).collect(),
        };
        builder.build(0, n_triangles, 0);
        Self {
            mesh,
            nodes: builder.nodes,
            order: builder.order,
        }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The smallest box around the mesh.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.nodes[0].bounds
    }

    /// The nearest triangle farther along the ray than `after_m`; the lowest index of several.
    ///
    /// A ray that is not finite meets nothing, nor does a ray within the plane of a triangle meet
    /// that one.
    #[must_use]
    pub fn nearest(&self, ray: &Ray, after_m: f64) -> Option<MeshHit> {
        let (distance_m, triangle, is_from_inside) = self.search(ray, after_m, Wanted::Nearest)?;
        let triangle_index = triangle as usize;
        let corners = self.mesh.corners(triangle_index);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let mut hit = MeshHit {
            distance_m,
            triangle_index,
            normal,
            smooth_normal: normal,
            painted: (0, DVec2::ZERO),
            is_from_inside,
        };
        if self.mesh.has_attributes() {
            let weights = ShearedRay::new(ray)?.weights(corners);
            let (material, uv) = self.mesh.painted(triangle_index);
            let uv = uv
                .iter()
                .zip(weights)
                .map(|(uv, weight)| weight * uv.as_dvec2());
            hit.painted = (material, uv.sum());
            if let Some(normals) = self.mesh.normals(triangle_index) {
                hit.smooth_normal = between(normals, weights, normal);
            }
        }
        Some(hit)
    }

    /// Whether there is any triangle farther along the ray than `after_m`: what a shadow asks.
    #[must_use]
    pub fn is_met(&self, ray: &Ray, after_m: f64) -> bool {
        self.search(ray, after_m, Wanted::Any).is_some()
    }

    /// Distance, triangle, and whether it is met from inside.
    fn search(&self, ray: &Ray, after_m: f64, wanted: Wanted) -> Option<(f64, u32, bool)> {
        let sheared = ShearedRay::new(ray)?;
        let slabs = Slabs::new(ray);
        let mut best: Option<(f64, u32, bool)> = None;
        let mut waiting = Waiting::at_root();
        while let Some(index) = waiting.next() {
            let nearest_m = best.map_or(f64::INFINITY, |(distance_m, ..)| distance_m);
            if !slabs.meets(&self.nodes[index].bounds, after_m, nearest_m) {
                continue;
            }
            for &triangle in self.opened(index, ray.direction, &mut waiting) {
                let corners = self.mesh.corners(triangle as usize);
                let Some((distance_m, is_inside)) = sheared.meet(corners) else {
                    continue;
                };
                let is_nearer = best.is_none_or(|(nearest_m, nearest, _)| {
                    (distance_m, triangle) < (nearest_m, nearest)
                });
                if distance_m > after_m && is_nearer {
                    best = Some((distance_m, triangle, is_inside));
                    if wanted == Wanted::Any {
                        return best;
                    }
                }
            }
        }
        best
    }

    /// The triangles of a leaf; of another node none, and its children wait, the nearer one next.
    fn opened(&self, index: usize, towards: DVec3, waiting: &mut Waiting) -> &[u32] {
        let node = &self.nodes[index];
        if node.n_triangles == 0 {
            let children = [index as u32 + 1, node.start];
            let near_is_right = towards[usize::from(node.axis)] < 0.0;
            waiting.push(children[usize::from(!near_is_right)]);
            waiting.push(children[usize::from(near_is_right)]);
            return &[];
        }
        &self.order[node.start as usize..(node.start + node.n_triangles) as usize]
    }
}

/// Nodes that are still to be looked at, the last one next.
struct Waiting {
    nodes: [u32; MAX_DEPTH + 1],
    n: usize,
}

impl Waiting {
    fn at_root() -> Self {
        Self {
            nodes: [0; MAX_DEPTH + 1],
            n: 1,
        }
    }

    fn next(&mut self) -> Option<usize> {
        self.n = self.n.checked_sub(1)?;
        Some(self.nodes[self.n] as usize)
    }

    fn push(&mut self, node: u32) {
        self.nodes[self.n] = node;
        self.n += 1;
    }
}

struct Builder {
    boxes: Vec<Aabb>,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Builder {
    /// Builds the node of `order[first..last]` and all below it.
    fn build(&mut self, first: usize, last: usize, depth: usize) {
        let of_order = |order: &[u32], index: usize| order[index] as usize;
        let bounds = (first..last)
            .map(|index| self.boxes[of_order(&self.order, index)])
            .reduce(united);
        // Meshes are not empty, and neither are halves.
        let Some(bounds) = bounds else { return };
        let node_index = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            start: first as u32,
            n_triangles: (last - first) as u32,
            axis: 0,
        });
        if last - first <= LEAF_SIZE || depth + 1 >= MAX_DEPTH {
            return;
        }
        let Some((axis, middle)) = self.split(first, last) else {
            return;
        };
        self.build(first, middle, depth + 1);
        let right = self.nodes.len() as u32;
        let node = &mut self.nodes[node_index];
        (node.start, node.n_triangles, node.axis) = (right, 0, axis as u8);
        self.build(middle, last, depth + 1);
    }

    /// Orders `order[first..last]` into two halves along an axis and says where the second begins; `None` where all
    /// middles coincide.
    fn split(&mut self, first: usize, last: usize) -> Option<(usize, usize)> {
        let middle_of = |triangle: u32| {
            let bounds = &self.boxes[triangle as usize];
            0.5 * (bounds.min + bounds.max)
        };
        let span = box_around(
            self.order[first..last]
                .iter()
                .map(|&index| middle_of(index)),
        );
        let size = span.size();
        let axis = (0..3).fold(
            0,
            |best, axis| if size[axis] > size[best] { axis } else { best },
        );
        if size[axis] <= 0.0 {
            return None;
        }
        let scale = N_BINS as f64 / size[axis];
        let bin_of = |triangle: u32| {
            let along = (middle_of(triangle)[axis] - span.min[axis]) * scale;
            (along as usize).min(N_BINS - 1)
        };
        let mut bins = [(0_usize, None::<Aabb>); N_BINS];
        for &triangle in &self.order[first..last] {
            let (count, bounds) = &mut bins[bin_of(triangle)];
            let own = self.boxes[triangle as usize];
            *count += 1;
            *bounds = Some(bounds.map_or(own, |bounds| united(bounds, own)));
        }
        let plane = cheapest_plane(&bins);
        let part = &mut self.order[first..last];
        // Stable, so that the tree depends on nothing but the mesh.
        part.sort_by_key(|&triangle| bin_of(triangle) >= plane);
        let n_left: usize = bins[..plane].iter().map(|(count, _)| count).sum();
        Some((axis, first + n_left))
    }
}

/// The first bin right of the best plane; the outer bins are never empty, so neither half is.
fn cheapest_plane(bins: &[(usize, Option<Aabb>); N_BINS]) -> usize {
    let cost = |part: &[(usize, Option<Aabb>)]| {
        let count: usize = part.iter().map(|(count, _)| count).sum();
        let bounds = part.iter().filter_map(|(_, bounds)| *bounds).reduce(united);
        bounds.map_or(0.0, |bounds| {
            let size = bounds.size();
            count as f64 * (size.x * size.y + size.y * size.z + size.z * size.x)
        })
    };
    let mut best = (f64::INFINITY, N_BINS / 2);
    for plane in 1..N_BINS {
        let both = cost(&bins[..plane]) + cost(&bins[plane..]);
        if both < best.0 {
            best = (both, plane);
        }
    }
    best.1
}

fn united(a: Aabb, b: Aabb) -> Aabb {
    Aabb {
        min: a.min.min(b.min),
        max: a.max.max(b.max),
    }
}

#[cfg(test)]
#[path = "mesh_bvh_tests.rs"]
mod tests;
