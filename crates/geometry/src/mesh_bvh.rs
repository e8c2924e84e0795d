//! The nearest triangle along a ray, through a tree of boxes.
//!
//! Triangles are parted where  A_left n_left + A_right n_right  is smallest over 16 planes of the longest
//! axis (`A` area of the box around, `n` number of triangles): the surface area heuristic. Four parts that follow from each
//! other, the largest parted first, are a node, whose boxes a ray meets at once (`four_boxes`).
//! [W07] I. Wald, IEEE Symposium on Interactive Ray Tracing, 33-40 (2007).
//! [DHK08] H. Dammertz, J. Hanika, A. Keller, Computer Graphics Forum 27, 1225-1233 (2008).

mod horizon;

use std::ops::Range;

use glam::DVec2;
use glam::DVec3;

use crate::aabb::Aabb;
use crate::four_boxes::FourBoxes;
use crate::four_boxes::FourSlabs;
use crate::mesh::TriangleMesh;
use crate::mesh::box_around;
use crate::mesh_normals::between;
use crate::mesh_triangle::ShearedRay;
use crate::ray::Ray;

/// Most triangles in a leaf that could be split.
const LEAF_SIZE: usize = 4;
/// Planes that are tried at every node.
const N_BINS: usize = 16;
/// Triangles are parted no more often than this; balanced trees of 2^32 of them are two thirds as deep.
const MAX_DEPTH: usize = 48;
/// Children of a node.
const WIDTH: usize = 4;
/// Most children that wait: all but one of those of every node down to the deepest.
const MOST_WAITING: usize = (WIDTH - 1) * MAX_DEPTH + 1;

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
    bounds: Aabb,
    /// The first one is the root.
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

/// Up to four children in their boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    boxes: FourBoxes,
    children: [Child; WIDTH],
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Child {
    /// First triangle of a leaf in the order; the node of another one.
    start: u32,
    /// Triangles of a leaf; 0 for another one.
    n_triangles: u32,
}

impl MeshBvh {
    /// Builds the tree.
    #[must_use]
    pub fn new(mesh: TriangleMesh) -> Self {
        let n_triangles = mesh.triangles().len();
        let boxes = (0..n_triangles).map(|index| box_around(mesh.corners(index)));
        let mut builder = Builder {
            boxes: boxes.collect(),
            order: (0..n_triangles as u32).collect(),
        };
        let root = builder.parts(0..n_triangles, 0);
        let mut nodes = Vec::new();
        gather(&root, &mut nodes);
        Self {
            bounds: root.bounds,
            mesh,
            nodes,
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
        self.bounds
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
        let slabs = FourSlabs::new(ray);
        let mut best: Option<(f64, u32, bool)> = None;
        let mut before = f32::INFINITY;
        let after = (after_m as f32).next_down();
        let mut waiting = Waiting::new();
        let mut child = Child::default();
        loop {
            if child.n_triangles == 0 {
                let node = &self.nodes[child.start as usize];
                let entered = slabs.enter(&node.boxes, (after, before));
                waiting.push_nearest_last(child.start, entered);
            }
            for &triangle in self.triangles_of(child) {
                let corners = self.mesh.corners(triangle as usize);
                let Some((distance_m, is_inside)) = sheared.meet(corners) else {
                    continue;
                };
                let is_nearer = best.is_none_or(|(nearest_m, nearest, _)| {
                    (distance_m, triangle) < (nearest_m, nearest)
                });
                if distance_m > after_m && is_nearer {
                    best = Some((distance_m, triangle, is_inside));
                    before = (distance_m as f32).next_up();
                    if wanted == Wanted::Any {
                        return best;
                    }
                }
            }
            child = loop {
                let Some((entered, place)) = waiting.next() else {
                    return best;
                };
                if entered <= before {
                    break self.child(place);
                }
            };
        }
    }

    /// Triangles of a leaf; none of another child.
    fn triangles_of(&self, Child { start, n_triangles }: Child) -> &[u32] {
        if n_triangles == 0 {
            return &[];
        }
        &self.order[start as usize..(start + n_triangles) as usize]
    }

    fn child(&self, place: u32) -> Child {
        let place = place as usize;
        self.nodes[place / WIDTH].children[place % WIDTH]
    }
}

/// Children that are still to be looked at by where a ray enters them and their place among those of all nodes, the last
/// one next.
struct Waiting {
    children: [(f32, u32); MOST_WAITING],
    n: usize,
}

impl Waiting {
    fn new() -> Self {
        Self {
            children: [(0.0, 0); MOST_WAITING],
            n: 0,
        }
    }

    fn next(&mut self) -> Option<(f32, u32)> {
        self.n = self.n.checked_sub(1)?;
        Some(self.children[self.n])
    }

    /// Add the children of a node that are entered at finite distances.
    #[inline]
    fn push_nearest_last(&mut self, node: u32, entered: [f32; WIDTH]) {
        let first = self.n;
        for (index, entered) in entered.into_iter().enumerate() {
            if entered == f32::INFINITY {
                continue;
            }
            let mut place = self.n;
            while place > first && self.children[place - 1].0 < entered {
                self.children[place] = self.children[place - 1];
                place -= 1;
            }
            self.children[place] = (entered, node * WIDTH as u32 + index as u32);
            self.n += 1;
        }
    }
}

/// A part of the triangles, with its halves.
struct Part {
    bounds: Aabb,
    /// Of the order.
    triangles: Range<usize>,
    halves: Option<Box<[Part; 2]>>,
}

/// Adds the node of a part, and all below it; its index.
fn gather(part: &Part, nodes: &mut Vec<Node>) -> u32 {
    let mut parts = vec![part];
    while parts.len() < WIDTH {
        let halved = parts
            .iter()
            .enumerate()
            .filter(|(_, it)| it.halves.is_some());
        let largest =
            halved.max_by(|(_, a), (_, b)| half_area(&a.bounds).total_cmp(&half_area(&b.bounds)));
        let Some((
            index,
            Part {
                halves: Some(halves),
                ..
            },
        )) = largest
        else {
            break;
        };
        parts.splice(index..=index, halves.iter());
    }
    let index = nodes.len();
    nodes.push(Node {
        boxes: FourBoxes::NONE,
        children: [Child::default(); WIDTH],
    });
    for (place, part) in parts.into_iter().enumerate() {
        let child = if part.halves.is_some() {
            Child {
                start: gather(part, nodes),
                n_triangles: 0,
            }
        } else {
            Child {
                start: part.triangles.start as u32,
                n_triangles: part.triangles.len() as u32,
            }
        };
        nodes[index].boxes.set(place, &part.bounds);
        nodes[index].children[place] = child;
    }
    index as u32
}

struct Builder {
    boxes: Vec<Aabb>,
    order: Vec<u32>,
}

impl Builder {
    /// A part of the order, in parts itself.
    fn parts(&mut self, triangles: Range<usize>, depth: usize) -> Part {
        let boxes = self.order[triangles.clone()].iter();
        let boxes = boxes.map(|&index| self.boxes[index as usize]);
        let bounds = boxes.reduce(united).unwrap_or(Aabb {
            // Meshes are not empty, and neither are halves.
            min: DVec3::ZERO,
            max: DVec3::ZERO,
        });
        let Range { start, end } = triangles;
        let may_be_parted = triangles.len() > LEAF_SIZE && depth + 1 < MAX_DEPTH;
        let middle = may_be_parted.then(|| self.split(start, end)).flatten();
        let halves = middle.map(|middle| {
            let halves = [start..middle, middle..end];
            Box::new(halves.map(|half| self.parts(half, depth + 1)))
        });
        Part {
            bounds,
            triangles,
            halves,
        }
    }

    /// Orders `order[first..last]` into two halves and says where the second begins; `None` where all middles coincide.
    fn split(&mut self, first: usize, last: usize) -> Option<usize> {
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
        Some(first + n_left)
    }
}

/// The first bin right of the best plane; the outer bins are never empty, so neither half is.
fn cheapest_plane(bins: &[(usize, Option<Aabb>); N_BINS]) -> usize {
    let cost = |part: &[(usize, Option<Aabb>)]| {
        let count: usize = part.iter().map(|(count, _)| count).sum();
        let bounds = part.iter().filter_map(|(_, bounds)| *bounds).reduce(united);
        bounds.map_or(0.0, |bounds| count as f64 * half_area(&bounds))
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

fn half_area(bounds: &Aabb) -> f64 {
    let size = bounds.size();
    size.x * size.y + size.y * size.z + size.z * size.x
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
