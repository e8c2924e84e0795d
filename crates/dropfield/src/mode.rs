//! A population of drops on a sparse lattice.
//!
//! A volume adds modes: rain and mist in one place have sizes that no single gamma law describes.

use glam::DVec3;
use rayon::prelude::*;

use crate::AreaMoments;
use crate::Drops;
use crate::Error;
use crate::GridBox;

/// Nodes along an edge of a leaf.
pub const LEAF_DIM: i32 = 8;

/// Nodes of a leaf.
pub const LEAF_NODES: usize = 512;

/// Part of a voxel within which a node counts as lying at a height.
const ON_GROUND: f64 = 1e-6;

/// A cube of 8³ nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct DropLeaf {
    /// Index of the lowest node, a multiple of 8 on every axis.
    pub origin: [i32; 3],
    /// The drops of node (x, y, z) above the origin, at `x << 6 | y << 3 | z`.
    pub drops: Box<[Drops; LEAF_NODES]>,
}

impl DropLeaf {
    /// A leaf without drops.
    pub(crate) fn empty(origin: [i32; 3]) -> Self {
        Self {
            origin,
            drops: Box::new([Drops::NONE; LEAF_NODES]),
        }
    }

    /// Index of the node at a place in `drops`.
    pub fn node(&self, place: usize) -> [i32; 3] {
        let place = place as i32;
        let [x, y, z] = self.origin;
        [x + (place >> 6), y + (place >> 3 & 7), z + (place & 7)]
    }
}

/// Place of a node in the `drops` of its leaf.
pub(crate) fn place_in_leaf(node: [i32; 3]) -> usize {
    let [x, y, z] = node.map(|axis| (axis & (LEAF_DIM - 1)) as usize);
    x << 6 | y << 3 | z
}

/// Lowest node of the leaf that a node belongs to.
pub(crate) fn leaf_origin(node: [i32; 3]) -> [i32; 3] {
    node.map(|axis| axis & !(LEAF_DIM - 1))
}

/// One population of drops: a name and its nodes.
///
/// Node (i, j, k) sits at `origin_m() + voxel_m() (i, j, k)`; between nodes the field is trilinear,
/// and outside all leaves there are no drops, so that it fades over one voxel beyond the outermost
/// nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct DropMode {
    /// Name, which prefixes the grids in a file (`mist` gives `mist_number_density`); may be empty.
    pub name: String,
    voxel_m: f64,
    origin_m: DVec3,
    leaves: Vec<DropLeaf>,
}

impl DropMode {
    /// Lay a field of drops onto the lattice of a box (in parallel by leaf, the same result for any
    /// number of threads). Leaves that come out empty are not kept.
    ///
    /// The field is asked once per node, at the middle of the part of the node's cell that lies in
    /// the box; the number density is then multiplied by the share of that part, so that a
    /// constant field keeps number density times volume for any voxel size.
    ///
    /// # Errors
    /// As [`GridBox::n_nodes`]; [`Error::BadDrops`] if the field gives a number density or radius
    /// that is negative or not finite, or an effective variance outside 0..1/2.
    pub fn from_fn(
        name: impl Into<String>,
        grid: &GridBox,
        field: impl Fn(DVec3) -> Drops + Sync,
    ) -> Result<Self, Error> {
        let n_nodes = grid.n_nodes()?;
        let [nx, ny, nz] = n_nodes.map(|count| (count + LEAF_DIM - 1) / LEAF_DIM);
        let leaves: Result<Vec<Option<DropLeaf>>, Error> = (0..nx * ny * nz)
            .into_par_iter()
            .map(|leaf| {
                let origin = [leaf / (ny * nz), leaf / nz % ny, leaf % nz].map(|at| at * LEAF_DIM);
                leaf_from_fn(origin, n_nodes, &|node| {
                    let (position, share) = grid.covered(node);
                    let drops = field(position);
                    let number_density_m3 = (f64::from(drops.number_density_m3) * share) as f32;
                    Drops {
                        number_density_m3,
                        ..drops
                    }
                })
            })
            .collect();
        let leaves = leaves?.into_iter().flatten().collect();
        let origin_m = grid.node([0; 3]);
        Ok(Self {
            name: name.into(),
            voxel_m: grid.voxel_m,
            origin_m,
            leaves,
        })
    }

    /// The same drops in other numbers: every number density multiplied by a factor of its leaf's number and its place
    /// in that (in parallel by leaf, the same result for any number of threads).
    ///
    /// # Errors
    /// [`Error::BadDrops`] if a number density becomes negative, not finite or too large.
    pub fn with_numbers_scaled(
        mut self,
        factor: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Result<Self, Error> {
        let scale_leaf = |(index, leaf): (usize, &mut DropLeaf)| -> Result<(), Error> {
            for place in 0..LEAF_NODES {
                let node = leaf.node(place);
                let drops = &mut leaf.drops[place];
                if drops.exist() {
                    let number = f64::from(drops.number_density_m3) * factor(index, place);
                    drops.number_density_m3 = number as f32;
                    check_drops(drops, node)?;
                }
            }
            Ok(())
        };
        let leaves = self.leaves.par_iter_mut().enumerate();
        leaves.try_for_each(scale_leaf)?;
        self.leaves
            .retain(|leaf| leaf.drops.iter().any(Drops::exist));
        Ok(self)
    }

    /// The same drops down to the ground, at y = 0.
    ///
    /// A field fades over the voxel beyond its outermost nodes. Drops that stand on the ground have their lowest
    /// nodes half a voxel above it, and would lose to what lies below up to half of themselves; so those nodes
    /// stand once more a voxel deeper, where nobody sees them. Nodes that are lower or higher stay alone.
    #[must_use]
    pub fn down_to_ground(mut self) -> Self {
        let lowest = (-self.origin_m.y / self.voxel_m - ON_GROUND).ceil();
        let height_m = self.origin_m.y + lowest * self.voxel_m;
        if height_m.abs() <= ON_GROUND * self.voxel_m || height_m > (0.5 + ON_GROUND) * self.voxel_m
        {
            return self;
        }
        let lowest = lowest as i32;
        let on_ground = self.nodes().filter(|([_, y, _], _)| *y == lowest);
        let copies: Vec<_> = on_ground
            .map(|([x, y, z], it)| ([x, y - 1, z], it))
            .collect();
        for (node, drops) in copies {
            let origin = leaf_origin(node);
            let found = self
                .leaves
                .binary_search_by_key(&origin, |leaf| leaf.origin);
            let leaf = found.unwrap_or_else(|place| {
                self.leaves.insert(place, DropLeaf::empty(origin));
                place
            });
            let below = &mut self.leaves[leaf].drops[place_in_leaf(node)];
            if !below.exist() {
                *below = drops;
            }
        }
        self
    }

    /// A mode of leaves in ascending order of their origins, checked by the caller.
    pub(crate) fn from_parts(
        name: String,
        voxel_m: f64,
        origin_m: DVec3,
        leaves: Vec<DropLeaf>,
    ) -> Self {
        debug_assert!(leaves.is_sorted_by_key(|leaf| leaf.origin));
        Self {
            name,
            voxel_m,
            origin_m,
            leaves,
        }
    }

    /// Edge length of a voxel, the distance of neighbouring nodes (m).
    pub fn voxel_m(&self) -> f64 {
        self.voxel_m
    }

    /// World position of node (0, 0, 0) (m).
    pub fn origin_m(&self) -> DVec3 {
        self.origin_m
    }

    /// World position of a node (m).
    pub fn node_position(&self, node: [i32; 3]) -> DVec3 {
        self.origin_m + DVec3::from(node.map(f64::from)) * self.voxel_m
    }

    /// The leaves in ascending order of their origins, x before y before z.
    pub fn leaves(&self) -> &[DropLeaf] {
        &self.leaves
    }

    /// The leaf with that origin.
    pub(crate) fn leaf(&self, origin: [i32; 3]) -> Option<&DropLeaf> {
        let place = self
            .leaves
            .binary_search_by_key(&origin, |leaf| leaf.origin);
        place.ok().map(|place| &self.leaves[place])
    }

    /// The drops of a node.
    pub fn drops(&self, node: [i32; 3]) -> Drops {
        let leaf = self.leaf(leaf_origin(node));
        leaf.map_or(Drops::NONE, |leaf| leaf.drops[place_in_leaf(node)])
    }

    /// The nodes that have drops, with their index, in a fixed order.
    pub fn nodes(&self) -> impl Iterator<Item = ([i32; 3], Drops)> {
        self.leaves.iter().flat_map(|leaf| {
            let drops = leaf
                .drops
                .iter()
                .enumerate()
                .filter(|(_, drops)| drops.exist());
            drops.map(|(place, drops)| (leaf.node(place), *drops))
        })
    }

    /// Lowest and highest index of the nodes that have drops, on each axis; `None` without drops.
    pub fn node_range(&self) -> Option<([i32; 3], [i32; 3])> {
        self.nodes()
            .map(|(node, _)| (node, node))
            .reduce(|(low, high), (node, _)| {
                let lower = std::array::from_fn(|axis| low[axis].min(node[axis]));
                let higher = std::array::from_fn(|axis| high[axis].max(node[axis]));
                (lower, higher)
            })
    }

    /// Drops in the whole volume, the integral of the trilinear number density.
    pub fn total_drops(&self) -> f64 {
        let sum: f64 = self
            .nodes()
            .map(|(_, drops)| f64::from(drops.number_density_m3))
            .sum();
        sum * self.voxel_m.powi(3)
    }

    /// Liquid water in the whole volume, the integral of the trilinear third moment (g).
    pub fn total_water_g(&self) -> f64 {
        let water = |drops: &Drops| AreaMoments::from_drops(drops).liquid_water_g_m3();
        let sum: f64 = self.nodes().map(|(_, drops)| water(&drops)).sum();
        sum * self.voxel_m.powi(3)
    }
}

/// Fill a leaf; `None` if it has no drops.
fn leaf_from_fn(
    origin: [i32; 3],
    n_nodes: [i32; 3],
    field: &impl Fn([i32; 3]) -> Drops,
) -> Result<Option<DropLeaf>, Error> {
    let mut leaf = DropLeaf::empty(origin);
    for place in 0..LEAF_NODES {
        let node = leaf.node(place);
        if (0..3).any(|axis| node[axis] >= n_nodes[axis]) {
            continue;
        }
        let drops = field(node);
        check_drops(&drops, node)?;
        leaf.drops[place] = drops;
    }
    Ok(leaf.drops.iter().any(Drops::exist).then_some(leaf))
}

/// What a number density must be.
pub(crate) const EXPECT_NUMBER: &str = "a number density in 0..1e15 1/m^3";
/// What a radius must be.
pub(crate) const EXPECT_RADIUS: &str = "a radius in 0..0.1 m";
/// What an effective variance must be.
pub(crate) const EXPECT_VARIANCE: &str = "an effective variance in 0..0.5";

/// The bound on radii (m) keeps every f32 moment of up to 1e15 drops finite.
pub(crate) const LARGEST_RADIUS_M: f32 = 0.1;
/// Most drops of a node (1/m³).
pub const LARGEST_NUMBER_M3: f32 = 1e15;

/// Whether a number density can be used.
pub(crate) fn sound_number(value: f32) -> bool {
    (0.0..=LARGEST_NUMBER_M3).contains(&value)
}

/// Whether an effective radius can be used.
pub(crate) fn sound_radius(value: f32) -> bool {
    (0.0..=LARGEST_RADIUS_M).contains(&value)
}

/// Whether an effective variance can be used.
pub(crate) fn sound_variance(value: f32) -> bool {
    (0.0..0.5).contains(&value)
}

pub(crate) fn check_drops(drops: &Drops, node: [i32; 3]) -> Result<(), Error> {
    let Drops {
        number_density_m3,
        effective_radius_m,
        effective_variance,
    } = *drops;
    let checks = [
        (
            sound_number(number_density_m3),
            "number density",
            number_density_m3,
            EXPECT_NUMBER,
        ),
        (
            sound_radius(effective_radius_m),
            "effective radius",
            effective_radius_m,
            EXPECT_RADIUS,
        ),
        (
            sound_variance(effective_variance),
            "effective variance",
            effective_variance,
            EXPECT_VARIANCE,
        ),
    ];
    match checks.into_iter().find(|(sound, ..)| !sound) {
        Some((_, quantity, value, expected)) => Err(Error::BadDrops {
            quantity,
            value,
            node,
            expected,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_volumes::grid;
    use crate::test_volumes::sparse;
    use crate::test_volumes::varied;

    #[test]
    fn a_constant_field_keeps_its_totals_for_any_voxel() {
        let drops = Drops {
            number_density_m3: 1000.0,
            effective_radius_m: 1e-4,
            effective_variance: 0.0,
        };
        for voxel_m in [2.0, 1.7, 3.0, 50.0] {
            let grid = GridBox { voxel_m, ..grid() };
            let mode = DropMode::from_fn("", &grid, |_| drops).unwrap();
            let volume = 38.0 * 20.0 * 16.0;
            // f32 densities and moments.
            assert!(
                (mode.total_drops() / (1000.0 * volume) - 1.0).abs() < 2e-7,
                "{voxel_m}"
            );
            // 1000 drops of (4/3) pi 1e-6 cm³ each.
            let water_g = 4.188_790_204_786_39e-3 * volume;
            assert!(
                (mode.total_water_g() / water_g - 1.0).abs() < 2e-7,
                "{voxel_m}"
            );
        }
    }

    #[test]
    fn nodes_hold_what_the_field_says() {
        let mode = DropMode::from_fn("rain", &grid(), varied).unwrap();
        assert_eq!(mode.nodes().count(), 19 * 10 * 8);
        for (node, drops) in mode.nodes() {
            assert_eq!(drops, varied(mode.node_position(node)));
            assert_eq!(drops, mode.drops(node));
        }
        assert_eq!(mode.drops([-1, 0, 0]), Drops::NONE);
        assert_eq!(mode.drops([19, 0, 0]), Drops::NONE);
        assert_eq!(mode.node_range(), Some(([0; 3], [18, 9, 7])));
    }

    /// Drops above the ground of the trilinear field, by their number: of its layer half a voxel above, what
    /// fades beyond is below.
    fn drops_above_ground(mode: &DropMode) -> f64 {
        let part = |y_m: f64| {
            // Of a hat of two voxels' width and area 1 the part above 0.
            let t = (y_m / mode.voxel_m()).clamp(-1.0, 1.0);
            0.5 + t - 0.5 * t * t.abs()
        };
        let nodes = mode.nodes().map(|(node, drops)| {
            f64::from(drops.number_density_m3) * part(mode.node_position(node).y)
        });
        nodes.sum::<f64>() * mode.voxel_m().powi(3)
    }

    #[test]
    fn drops_on_the_ground_are_all_above_it() {
        let drops = |_: DVec3| Drops {
            number_density_m3: 1000.0,
            effective_radius_m: 1e-4,
            effective_variance: 0.1,
        };
        // From 0 on and from 30 m down, so that the layer below is in another leaf and in the same one.
        for (min_y, max_y) in [(0.0, 20.0), (-30.0, 20.0)] {
            let grid = GridBox {
                min: DVec3::new(-10.0, min_y, -10.0),
                max: DVec3::new(10.0, max_y, 10.0),
                voxel_m: 2.0,
            };
            let mode = DropMode::from_fn("", &grid, drops).unwrap();
            let above = 1000.0 * 20.0 * 20.0 * 20.0;
            let on_ground = mode.clone().down_to_ground();
            let found = drops_above_ground(&on_ground) / above;
            assert!((found - 1.0).abs() < 1e-6, "{min_y}: {found}");
            if min_y < 0.0 {
                assert_eq!(on_ground, mode);
                continue;
            }
            // Without it an eighth of a layer of ten is below.
            let lost = 1.0 - drops_above_ground(&mode) / above;
            assert!((lost - 0.0125).abs() < 1e-6, "{lost}");
            assert_eq!(on_ground.nodes().count(), 11 * mode.nodes().count() / 10);
            assert!(on_ground.leaves().is_sorted_by(|a, b| a.origin < b.origin));
            assert_eq!(on_ground.clone().down_to_ground(), on_ground);
        }
    }

    #[test]
    fn drops_above_the_ground_or_with_nodes_on_it_stay() {
        for (min_y, voxel_m) in [(0.5, 2.0), (30.0, 2.0), (-1.0, 2.0), (-3.0, 2.0)] {
            let grid = GridBox {
                min: DVec3::new(0.0, min_y, 0.0),
                max: DVec3::new(8.0, min_y + 8.0, 8.0),
                voxel_m,
            };
            let mode = DropMode::from_fn("", &grid, varied).unwrap();
            assert_eq!(mode.clone().down_to_ground(), mode, "{min_y}");
        }
    }

    #[test]
    fn leaves_are_sorted_and_none_is_empty() {
        let mode = sparse();
        assert!(mode.leaves().is_sorted_by(|a, b| a.origin < b.origin));
        assert!(
            mode.leaves()
                .iter()
                .all(|leaf| leaf.drops.iter().any(Drops::exist))
        );
        assert!(mode.leaves().len() < 60, "{} of 512", mode.leaves().len());
    }

    #[test]
    fn scaled_numbers_keep_sizes_and_drop_empty_leaves() {
        let mode = DropMode::from_fn("", &grid(), varied).unwrap();
        // Leaves are 16 m wide: from x = 9 on the second and third are emptied.
        let factor = |leaf: usize, place: usize| {
            let node = mode.leaves()[leaf].node(place);
            if mode.node_position(node).x < 9.0 {
                0.5
            } else {
                0.0
            }
        };
        let scaled = mode.clone().with_numbers_scaled(factor).unwrap();
        assert_eq!(scaled.nodes().count(), 8 * 10 * 8);
        assert!(scaled.leaves().iter().all(|leaf| leaf.origin[0] == 0));
        for (node, drops) in scaled.nodes() {
            let before = mode.drops(node);
            assert_eq!(drops.number_density_m3, 0.5 * before.number_density_m3);
            assert_eq!(drops.effective_radius_m, before.effective_radius_m);
        }
        assert!(mode.with_numbers_scaled(|_, _| -1.0).is_err());
    }

    #[test]
    fn one_thread_and_many_give_the_same_volume() {
        let build = || DropMode::from_fn("", &grid(), varied).unwrap();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        assert_eq!(pool.install(build), build());
    }

    #[test]
    fn impossible_drops_are_refused_with_their_node() {
        let sound = varied(DVec3::ZERO);
        let bad = [
            Drops {
                number_density_m3: -1.0,
                ..sound
            },
            Drops {
                number_density_m3: f32::INFINITY,
                ..sound
            },
            Drops {
                effective_radius_m: f32::NAN,
                ..sound
            },
            Drops {
                effective_radius_m: -1e-6,
                ..sound
            },
            Drops {
                effective_radius_m: 1.0,
                ..sound
            },
            Drops {
                effective_variance: 0.5,
                ..sound
            },
            Drops {
                effective_variance: -0.1,
                ..sound
            },
        ];
        for bad in bad {
            let place = DVec3::new(30.0, 4.0, 101.0);
            let field = |position: DVec3| if position == place { bad } else { sound };
            let error = DropMode::from_fn("", &grid(), field).unwrap_err();
            assert!(
                matches!(
                    error,
                    Error::BadDrops {
                        node: [18, 0, 0],
                        ..
                    }
                ),
                "{error}"
            );
        }
    }
}
