//! Drops of a foreign lattice, brought to one of axis-parallel cubes.
//!
//! M'(j) = f/n³ sum_a M(T^-1(x_j + h a)),   f = |det T| sum_i M3(i) / (h³ sum_j M3'(j) at f = 1)
//! `M` area moments, trilinear between the nodes i of the foreign lattice, `T` from its indices to metres, `x_j` the
//! nodes of the new one, `h` their distance, `a` the middles of n³ equal parts of a voxel, n = ceil(2 h/s), `s` the
//! shortest step of the foreign lattice. So each node is the mean of the field over its voxel, a field that is linear
//! stays itself, and the water of the whole is that of the file: f takes up what a sum of few places misses.
//! A lattice that is only turned by quarters, mirrored, or both keeps its nodes and their values as they are.

use std::collections::BTreeMap;
use std::collections::BTreeSet;

use glam::DVec3;
use niji_vdb::Transform;
use rayon::prelude::*;

use crate::AreaMoments;
use crate::DropLeaf;
use crate::DropMode;
use crate::Drops;
use crate::Error;
use crate::LEAF_DIM;
use crate::area_moments::MAX_EFFECTIVE_VARIANCE;
use crate::grid_box::node_limit;
use crate::mode::LEAF_NODES;
use crate::mode::leaf_origin;
use crate::mode::place_in_leaf;

/// Steps of a lattice that differ by less than this part are equal: matrices in f32 have 6e-8.
const CUBE_TOLERANCE: f64 = 1e-6;
/// Most parts of an edge of a voxel.
const MAX_PARTS: f64 = 16.0;
/// Parts of a voxel along a foreign step.
const PARTS_PER_STEP: f64 = 2.0;

/// Largest index on the new lattice.
const FARTHEST: f64 = 1e9;

/// Leaves by their origin.
type Leaves = BTreeMap<[i32; 3], DropLeaf>;

/// A lattice with its drops.
pub(crate) struct Lattice {
    /// From indices to metres.
    pub(crate) transform: Transform,
    pub(crate) leaves: Leaves,
}

impl Lattice {
    /// The drops on cubes, of this edge if there is one.
    ///
    /// # Errors
    /// [`Error::BadSetting`] for an edge of more than eight of the shortest steps; more nodes than fit into memory.
    pub(crate) fn on_cubes(self, voxel_m: Option<f64>) -> Result<DropMode, Error> {
        let steps = self.transform.voxel_size();
        let shortest_m = steps.min_element();
        let turned = Turn::of(&self.transform);
        let is_wanted = |size_m: f64| {
            voxel_m.is_none_or(|wanted| (wanted / size_m - 1.0).abs() < CUBE_TOLERANCE)
        };
        let (voxel_m, leaves) = match turned {
            Some((turn, size_m)) if is_wanted(size_m) => (size_m, turn.leaves(self.leaves)),
            Some(_) | None => {
                let voxel_m = voxel_m.unwrap_or(shortest_m);
                let most = MAX_PARTS / PARTS_PER_STEP * shortest_m;
                if voxel_m > most {
                    return Err(Error::BadSetting {
                        parameter: "voxel_m",
                        found: voxel_m,
                        expected: "at most eight of the shortest steps between the grid's voxels",
                    });
                }
                (voxel_m, self.means(voxel_m)?)
            }
        };
        let origin_m = self.transform.translation();
        let leaves = leaves.into_values();
        Ok(DropMode::from_parts(
            String::new(),
            voxel_m,
            origin_m,
            leaves.collect(),
        ))
    }

    /// Means over the voxels of a lattice with the same node (0, 0, 0), as much water in all.
    fn means(&self, voxel_m: f64) -> Result<Leaves, Error> {
        let field = Field::new(&self.leaves);
        let origins = self.leaves_met(voxel_m)?;
        let shortest_m = self.transform.voxel_size().min_element();
        let n = (PARTS_PER_STEP * voxel_m / shortest_m).ceil().max(1.0) as usize;
        let middle = |part: usize| voxel_m * ((part as f64 + 0.5) / n as f64 - 0.5);
        let origin_m = self.transform.translation();
        let mean = |node: [i32; 3]| {
            let mut sum = [0.0; 3];
            for part in 0..n * n * n {
                let offset = [part / (n * n), part / n % n, part % n].map(middle);
                let place = DVec3::from(node.map(f64::from)) * voxel_m + DVec3::from(offset);
                let index = self.transform.world_to_index(origin_m + place);
                field.add(index, &mut sum);
            }
            drops_of(sum.map(|sum| sum / (n * n * n) as f64))
        };
        let leaf = |origin: &[i32; 3]| {
            let mut leaf = DropLeaf::empty(*origin);
            for place in 0..LEAF_NODES {
                leaf.drops[place] = mean(leaf.node(place));
            }
            let any = leaf.drops.iter().any(Drops::exist);
            any.then_some((*origin, leaf))
        };
        let origins: Vec<[i32; 3]> = origins.into_iter().collect();
        let mut leaves: Leaves = origins.par_iter().filter_map(leaf).collect();
        let before = self.transform.linear().determinant().abs() * water(&self.leaves);
        let after = voxel_m.powi(3) * water(&leaves);
        if after > 0.0 {
            let nodes = leaves.values_mut().flat_map(|leaf| leaf.drops.iter_mut());
            for drops in nodes {
                let number = f64::from(drops.number_density_m3) * before / after;
                drops.number_density_m3 = number as f32;
            }
        }
        Ok(leaves)
    }

    /// Origins of the new leaves that the field may reach: it fades over one voxel beyond its nodes.
    fn leaves_met(&self, voxel_m: f64) -> Result<BTreeSet<[i32; 3]>, Error> {
        let mut met = BTreeSet::new();
        for origin in self.leaves.keys() {
            let ends =
                [-1, LEAF_DIM].map(|end| origin.map(|axis| f64::from(axis) + f64::from(end)));
            let corners = (0..8).map(|corner| {
                let index = [0, 1, 2].map(|axis| ends[corner >> axis & 1][axis]);
                self.transform.linear() * DVec3::from(index) / voxel_m
            });
            let around = |corner: DVec3| (corner, corner);
            let box_of = corners.map(around);
            let Some((low, high)) = box_of.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else {
                continue;
            };
            let n_around = ((high - low) / f64::from(LEAF_DIM) + 2.0).element_product();
            let n_nodes = n_around * LEAF_NODES as f64;
            if n_nodes > node_limit() as f64 || low.abs().max(high.abs()).max_element() > FARTHEST {
                return Err(Error::too_many_nodes(n_nodes));
            }
            let [first, last] = [low.floor() - 1.0, high.ceil() + 1.0]
                .map(|end| leaf_origin(end.to_array().map(|axis| axis as i32)));
            let count = |axis: usize| (last[axis] - first[axis]) / LEAF_DIM + 1;
            for place in 0..count(0) * count(1) * count(2) {
                let steps = [
                    place / (count(1) * count(2)),
                    place / count(2) % count(1),
                    place % count(2),
                ];
                met.insert([0, 1, 2].map(|axis| first[axis] + LEAF_DIM * steps[axis]));
            }
            let n_nodes = met.len() * LEAF_NODES;
            if n_nodes as u64 > node_limit() {
                return Err(Error::too_many_nodes(n_nodes as f64));
            }
        }
        Ok(met)
    }
}

/// Sum of the third moment over all nodes.
fn water(leaves: &Leaves) -> f64 {
    let nodes = leaves.values().flat_map(|leaf| leaf.drops.iter());
    nodes
        .map(|drops| f64::from(AreaMoments::from_drops(drops).m3))
        .sum()
}

/// Drops of a gamma law with these moments.
fn drops_of([m2, m3, m4]: [f64; 3]) -> Drops {
    // f32: what files hold; moments below its range are no drops.
    let moments = AreaMoments {
        m2: m2 as f32,
        m3: m3 as f32,
        m4: m4 as f32,
    };
    if moments.m2 <= 0.0 || moments.m3 <= 0.0 {
        return Drops::NONE;
    }
    let radius_um = m3 / m2;
    let most = f64::from(MAX_EFFECTIVE_VARIANCE);
    // Of equal drops rounding leaves 1e-16.
    let variance = (m4 / m3 * (m2 / m3) - 1.0).clamp(0.0, most);
    let variance = if variance < 1e-6 { 0.0 } else { variance };
    let per_drop = radius_um * radius_um * (1.0 - variance) * (1.0 - 2.0 * variance);
    Drops {
        number_density_m3: (m2 / per_drop) as f32,
        effective_radius_m: (1e-6 * radius_um) as f32,
        effective_variance: variance as f32,
    }
}

/// Area moments between the nodes of leaves.
struct Field {
    leaves: BTreeMap<[i32; 3], Box<[AreaMoments]>>,
}

impl Field {
    fn new(leaves: &Leaves) -> Self {
        let moments = |leaf: &DropLeaf| leaf.drops.iter().map(AreaMoments::from_drops).collect();
        Self {
            leaves: leaves.iter().map(|it| (*it.0, moments(it.1))).collect(),
        }
    }

    /// Adds the moments at a place in indices, trilinear.
    fn add(&self, index: DVec3, sum: &mut [f64; 3]) {
        let low = index.floor();
        let part = index - low;
        let low = low.to_array().map(|axis| axis as i32);
        let first = self.leaves.get(&leaf_origin(low));
        for corner in 0..8_usize {
            let step = [0, 1, 2].map(|axis| (corner >> axis & 1) as i32);
            let node = [0, 1, 2].map(|axis| low[axis].saturating_add(step[axis]));
            let is_first = leaf_origin(node) == leaf_origin(low);
            let leaf = if is_first {
                first
            } else {
                self.leaves.get(&leaf_origin(node))
            };
            let Some(leaf) = leaf else { continue };
            let moments = leaf[place_in_leaf(node)];
            let weight: f64 = [0, 1, 2]
                .map(|axis| {
                    if step[axis] == 1 {
                        part[axis]
                    } else {
                        1.0 - part[axis]
                    }
                })
                .iter()
                .product();
            for (sum, moment) in sum.iter_mut().zip([moments.m2, moments.m3, moments.m4]) {
                *sum += weight * f64::from(moment);
            }
        }
    }
}

/// Which axis of an index becomes which, and whether it turns round.
#[derive(Clone, Copy)]
struct Turn {
    axes: [usize; 3],
    signs: [i32; 3],
}

impl Turn {
    /// That of a transform which does nothing but turn by quarters, mirror and scale, with the size of its cubes.
    fn of(transform: &Transform) -> Option<(Self, f64)> {
        let columns = transform.linear().to_cols_array_2d();
        let size = transform.voxel_size().x;
        let mut turn = Self {
            axes: [3; 3],
            signs: [1; 3],
        };
        for (from, column) in columns.iter().enumerate() {
            let to = (0..3).max_by(|a, b| column[*a].abs().total_cmp(&column[*b].abs()))?;
            let rest = (0..3)
                .filter(|axis| *axis != to)
                .map(|axis| column[axis].abs());
            let off = rest.fold((column[to].abs() - size).abs(), f64::max);
            if off > CUBE_TOLERANCE * size || turn.axes.contains(&to) {
                return None;
            }
            turn.axes[from] = to;
            turn.signs[from] = if column[to] < 0.0 { -1 } else { 1 };
        }
        Some((turn, size))
    }

    fn node(&self, node: [i32; 3]) -> [i32; 3] {
        let mut turned = [0; 3];
        for (from, axis) in node.into_iter().enumerate() {
            turned[self.axes[from]] = self.signs[from] * axis;
        }
        turned
    }

    /// The same drops at the nodes that they come to.
    fn leaves(&self, leaves: Leaves) -> Leaves {
        if self.axes == [0, 1, 2] && self.signs == [1; 3] {
            return leaves;
        }
        let mut turned = Leaves::new();
        for leaf in leaves.values() {
            for (place, drops) in leaf.drops.iter().enumerate().filter(|it| it.1.exist()) {
                let node = self.node(leaf.node(place));
                let origin = leaf_origin(node);
                let leaf = turned
                    .entry(origin)
                    .or_insert_with(|| DropLeaf::empty(origin));
                leaf.drops[place_in_leaf(node)] = *drops;
            }
        }
        turned
    }
}

#[cfg(test)]
#[path = "resample_tests.rs"]
mod tests;
