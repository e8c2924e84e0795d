//! From the leaves of a mode to the nodes of its bricks.

use glam::IVec3;
use glam::Vec4;

use crate::AreaMoments;
use crate::DropLeaf;
use crate::DropMode;
use crate::Drops;
use crate::Error;
use crate::Interpolation;
use crate::SizeRange;
use crate::bricks::BRICK_DIM;
use crate::bricks::BRICK_NODES;
use crate::bricks::MOST_CELLS;
use crate::bricks::NO_BRICK;
use crate::bricks::NODES_PER_BRICK;
use crate::bricks::STRIDE_X;
use crate::bricks::STRIDE_Y;
use crate::mode::leaf_origin;
use crate::mode::place_in_leaf;

/// Largest number of bricks in the bounding box, of which each takes 4 bytes even if it is empty.
const MOST_BRICK_SLOTS: f64 = (1_u32 << 28) as f64;

/// Where the field of a mode is: from its lowest node, one below the first one with drops, over so
/// many cells, in so many bricks.
pub(crate) struct Lattice {
    pub(crate) low: IVec3,
    pub(crate) n_cells: IVec3,
    pub(crate) n_slots: IVec3,
}

impl Lattice {
    pub(crate) fn of(mode: &DropMode) -> Result<Self, Error> {
        let Some((first, last)) = mode.node_range() else {
            return Ok(Self {
                low: IVec3::ZERO,
                n_cells: IVec3::ZERO,
                n_slots: IVec3::ZERO,
            });
        };
        let (first, last) = (IVec3::from(first), IVec3::from(last));
        let extent = last.as_dvec3() - first.as_dvec3();
        let most_slots = (extent / f64::from(BRICK_DIM) + 2.0).element_product();
        if most_slots > MOST_BRICK_SLOTS || extent.max_element() + 2.0 > MOST_CELLS {
            return Err(Error::too_many_nodes(most_slots * NODES_PER_BRICK as f64));
        }
        // The field fades to the node before the first one and to the one after the last.
        let low = first - 1;
        let n_cells = last + 1 - low;
        Ok(Self {
            low,
            n_cells,
            n_slots: (n_cells + BRICK_DIM - 1) / BRICK_DIM,
        })
    }
}

/// The bricks with drops: their numbers by place in the bounding box, and their places by number.
pub(crate) fn occupied(mode: &DropMode, low: IVec3, n_slots: IVec3) -> (Vec<u32>, Vec<IVec3>) {
    let slot = |place: IVec3| ((place.x * n_slots.y + place.y) * n_slots.z + place.z) as usize;
    let mut slots = vec![NO_BRICK; n_slots.element_product() as usize];
    for (node, _) in mode.nodes() {
        let node = IVec3::from(node) - low;
        // A node belongs to the cells below and above it.
        let (from, to) = ((node - 1) >> 3, node >> 3);
        for corner in 0..8 {
            let upper = IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1);
            slots[slot(from + upper * (to - from))] = 0;
        }
    }
    let mut places = Vec::new();
    for (index, slot) in slots
        .iter_mut()
        .enumerate()
        .filter(|(_, slot)| **slot != NO_BRICK)
    {
        let index = index as i32;
        let (x, rest) = (
            index / (n_slots.y * n_slots.z),
            index % (n_slots.y * n_slots.z),
        );
        *slot = places.len() as u32;
        places.push(IVec3::new(x, rest / n_slots.z, rest % n_slots.z));
    }
    (slots, places)
}

/// Fill the lanes of the brick whose lowest node is that of the mode.
pub(crate) fn fill_brick(
    mode: &DropMode,
    interpolation: Interpolation,
    low: IVec3,
    lanes: &mut [Vec4],
) {
    // Nine nodes in a row touch two leaves.
    let leaves: [Option<&DropLeaf>; 8] = std::array::from_fn(|corner| {
        let corner = corner as i32;
        let upper = IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1);
        mode.leaf(leaf_origin((low + upper * BRICK_DIM).to_array()))
    });
    let low_leaf = IVec3::from(leaf_origin(low.to_array()));
    for (index, lanes) in lanes.iter_mut().enumerate() {
        let node = low + node_in_brick(index);
        let upper: IVec3 = (node - low_leaf) >> 3;
        let leaf = leaves[(upper.x << 2 | upper.y << 1 | upper.z) as usize];
        if let Some(leaf) = leaf {
            *lanes = lanes_of(interpolation, &leaf.drops[place_in_leaf(node.to_array())]);
        }
    }
}

fn lanes_of(interpolation: Interpolation, drops: &Drops) -> Vec4 {
    if !drops.exist() {
        return Vec4::ZERO;
    }
    match interpolation {
        Interpolation::RadiusDensity => {
            let radius_um = (1e6 * f64::from(drops.effective_radius_m)) as f32;
            Vec4::new(
                radius_um,
                drops.number_density_m3,
                drops.effective_variance,
                0.0,
            )
        }
        Interpolation::Moments => {
            let AreaMoments { m2, m3, m4 } = AreaMoments::from_drops(drops);
            Vec4::new(m2, m3, m4, 0.0)
        }
    }
}

/// Bounds on M2 between the nodes of a brick.
pub(crate) fn m2_range(interpolation: Interpolation, lanes: &[Vec4]) -> (f32, f32) {
    let (low, high) = lanes
        .iter()
        .fold((Vec4::INFINITY, Vec4::ZERO), |(low, high), lanes| {
            (low.min(*lanes), high.max(*lanes))
        });
    match interpolation {
        Interpolation::Moments => (low.x, high.x),
        Interpolation::RadiusDensity => {
            let spread = |v_e: f32| (1.0 - v_e) * (1.0 - 2.0 * v_e);
            let smallest = low.y * low.x * low.x * spread(high.z);
            (smallest, high.y * high.x * high.x * spread(low.z))
        }
    }
}

/// A bit for each cell of a brick: a word for x, in it bit 8 y + z.
pub(crate) type CellMask = [u64; BRICK_DIM as usize];

/// Which drops a brick has; `None` if it has none.
pub(crate) fn brick_sizes(interpolation: Interpolation, lanes: &[Vec4]) -> Option<SizeRange> {
    let node = |lanes: &Vec4| match interpolation {
        Interpolation::RadiusDensity => {
            (lanes.x > 0.0).then(|| SizeRange::of(f64::from(lanes.x), f64::from(lanes.z)))
        }
        Interpolation::Moments => {
            let moments = AreaMoments {
                m2: lanes.x,
                m3: lanes.y,
                m4: lanes.z,
            };
            let radius_um = f64::from(moments.effective_radius_um());
            let variance = f64::from(moments.effective_variance());
            (radius_um > 0.0).then(|| SizeRange::of(radius_um, variance))
        }
    };
    let nodes: Vec<Option<SizeRange>> = lanes.iter().map(node).collect();
    let union = |a: SizeRange, b| a.union(b);
    let of_nodes = nodes.iter().copied().flatten().reduce(union)?;
    if interpolation == Interpolation::RadiusDensity {
        return Some(of_nodes);
    }
    let corners = [0, STRIDE_X].map(|x| [0, STRIDE_Y].map(|y| [x + y, x + y + 1]));
    let cells = (0..NODES_PER_BRICK).filter(|node| {
        let place = [
            node / STRIDE_X,
            node / STRIDE_Y % BRICK_NODES,
            node % BRICK_NODES,
        ];
        place.iter().all(|coordinate| coordinate + 1 < BRICK_NODES)
    });
    let of_cell = |cell: usize| {
        let corners = corners.as_flattened().as_flattened().iter();
        let nodes = corners.filter_map(|corner| nodes[cell + corner]);
        nodes.reduce(union).map(SizeRange::with_mixtures)
    };
    cells
        .filter_map(of_cell)
        .reduce(union)
        .map(|of_cells| of_cells.union(of_nodes))
}

/// The cells of a brick at whose corners there are no drops.
pub(crate) fn cells_without_drops(lanes: &[Vec4]) -> CellMask {
    // A bit for each node of a row along z, then for each two neighbors. Without drops M2 is 0, and
    // so is the radius.
    let pairs: [[u64; BRICK_NODES]; BRICK_NODES] = std::array::from_fn(|x| {
        std::array::from_fn(|y| {
            let row = &lanes[x * STRIDE_X + y * STRIDE_Y..][..BRICK_NODES];
            let nodes = (0..)
                .zip(row)
                .map(|(z, lanes)| u64::from(lanes.x <= 0.0) << z);
            let nodes = nodes.fold(0, |row, node| row | node);
            nodes & nodes >> 1
        })
    });
    let cells = |x: usize, y: usize| {
        let corners = pairs[x][y] & pairs[x][y + 1] & pairs[x + 1][y] & pairs[x + 1][y + 1];
        corners << (BRICK_DIM as usize * y)
    };
    std::array::from_fn(|x| (0..BRICK_DIM as usize).fold(0, |layer, y| layer | cells(x, y)))
}

/// Lattice coordinates inside a brick of a node's place in it.
pub(crate) fn node_in_brick(index: usize) -> IVec3 {
    place_in_cube(BRICK_NODES, index)
}

/// Place of a number in a cube of `n` along each side, z fastest.
pub(crate) fn place_in_cube(n: usize, index: usize) -> IVec3 {
    let (x, y, z) = (index / (n * n), index / n % n, index % n);
    IVec3::new(x as i32, y as i32, z as i32)
}
