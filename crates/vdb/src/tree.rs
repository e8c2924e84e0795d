//! A sparse volume: leaves of 8³ voxels and constant tiles over a background.
//!
//! OpenVDB's tree of a root over nodes of 32³, 16³ and 8³ slots is flattened into two sorted
//! lists; the internal nodes carry nothing that their leaves and tiles do not say.

use crate::Error;
use crate::Value;

/// Edge length of a leaf in voxels.
pub const LEAF_DIM: i32 = 8;

/// Number of voxels of a leaf.
pub const LEAF_VOXELS: usize = 512;

/// Slots of a node right under the root: 32³, of 128³ voxels each.
pub(crate) const ROOT_NODE_SLOTS: usize = 1 << 15;

/// Slots of a node above the leaves: 16³, of 8³ voxels each.
pub(crate) const NODE_SLOTS: usize = 1 << 12;

/// A cube of 8³ voxels with a value each; a bit of the mask says which are active.
#[derive(Debug, Clone, PartialEq)]
pub struct Leaf<T = f32> {
    /// The lowest voxel, a multiple of 8 on every axis.
    pub origin: [i32; 3],
    /// Which voxels are active: bit `index & 63` of word `index >> 6`.
    pub mask: [u64; 8],
    /// Values of all voxels, active or not, at `index = x << 6 | y << 3 | z`.
    pub values: [T; LEAF_VOXELS],
}

impl<T: Value> Leaf<T> {
    /// Bytes that a leaf takes in memory.
    pub(crate) const MEMORY: u64 = size_of::<Self>() as u64;

    /// A leaf without active voxels.
    pub fn new(origin: [i32; 3], background: T) -> Self {
        Self {
            origin,
            mask: [0; 8],
            values: [background; LEAF_VOXELS],
        }
    }

    /// Index into `values` of a voxel, of which only the place inside the leaf counts.
    pub fn index(voxel: [i32; 3]) -> usize {
        let [x, y, z] = voxel.map(|coordinate| (coordinate & (LEAF_DIM - 1)) as usize);
        x << 6 | y << 3 | z
    }

    /// The voxel at an index into `values`.
    pub fn voxel(&self, index: usize) -> [i32; 3] {
        let index = index as i32;
        let [x, y, z] = self.origin;
        [x + (index >> 6 & 7), y + (index >> 3 & 7), z + (index & 7)]
    }

    /// Set a voxel's value and make it active.
    pub fn set(&mut self, voxel: [i32; 3], value: T) {
        let index = Self::index(voxel);
        self.values[index] = value;
        self.mask[index >> 6] |= 1 << (index & 63);
    }

    /// Whether the voxel at an index into `values` is active.
    pub fn is_active(&self, index: usize) -> bool {
        self.mask[index >> 6] >> (index & 63) & 1 == 1
    }

    /// Number of active voxels.
    pub fn active_count(&self) -> u32 {
        self.mask.iter().map(|word| word.count_ones()).sum()
    }

    /// Lowest and highest coordinates of active voxels.
    fn active_corners(&self) -> Option<[[i32; 3]; 2]> {
        let range = |bits: u64| [bits.trailing_zeros(), bits.ilog2()];
        // A word holds one x, a byte of it one y, a bit of that one z.
        let x = (0..8).fold(0, |x, word| x | u64::from(self.mask[word] != 0) << word);
        let yz = self.mask.iter().fold(0, |all, word| all | word);
        if yz == 0 {
            return None;
        }
        let rows = yz.to_le_bytes();
        let y = (0..8).fold(0, |y, row| y | u64::from(rows[row] != 0) << row);
        let z = u64::from(rows.iter().fold(0, |all, row| all | row));
        let [x, y, z] = [x, y, z].map(range);
        let corner = |end: usize| {
            let [x0, y0, z0] = self.origin;
            [x0 + x[end] as i32, y0 + y[end] as i32, z0 + z[end] as i32]
        };
        Some([corner(0), corner(1)])
    }

    /// Indices and values of the active voxels in the order of the indices.
    pub fn active(&self) -> impl Iterator<Item = (usize, T)> {
        (0..LEAF_VOXELS)
            .filter(|&index| self.is_active(index))
            .map(|index| (index, self.values[index]))
    }
}

/// How large a tile is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TileLevel {
    /// 8³ voxels, in the place of a leaf.
    Leaf,
    /// 128³ voxels.
    Lower,
    /// 4096³ voxels, an entry of the root.
    Upper,
}

impl TileLevel {
    /// Edge length in voxels.
    pub fn dim(self) -> i32 {
        match self {
            Self::Leaf => LEAF_DIM,
            Self::Lower => 128,
            Self::Upper => 4096,
        }
    }

    /// The origin, if it lies on the lattice of this level.
    pub(crate) fn check(self, origin: [i32; 3]) -> Result<[i32; 3], Error> {
        let dim = self.dim();
        let aligned = origin.iter().all(|axis| axis & (dim - 1) == 0);
        aligned
            .then_some(origin)
            .ok_or(Error::Misaligned { origin, dim })
    }

    /// The origin of a slot, as large as this level, of the node that starts at `node`.
    pub(crate) fn slot_origin(self, node: [i32; 3], slot: usize) -> [i32; 3] {
        let log2_slots = match self {
            Self::Leaf => 4,
            Self::Lower | Self::Upper => 5,
        };
        let slot = slot as i32;
        let along = |shift: u32| (slot >> shift & ((1 << log2_slots) - 1)) * self.dim();
        let [x, y, z] = node;
        [
            x + along(2 * log2_slots),
            y + along(log2_slots),
            z + along(0),
        ]
    }
}

/// A cube of voxels that all have one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tile<T = f32> {
    /// The lowest voxel, a multiple of the edge length on every axis.
    pub origin: [i32; 3],
    /// Edge length.
    pub level: TileLevel,
    /// Whether the voxels are active.
    pub active: bool,
    /// The value of every voxel.
    pub value: T,
}

impl<T> Tile<T> {
    /// Whether a voxel lies inside.
    pub fn covers(&self, voxel: [i32; 3]) -> bool {
        let corner = voxel.map(|axis| axis & !(self.level.dim() - 1));
        corner == self.origin
    }
}

/// A sparse volume of values over a background.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseTree<T> {
    /// The value of every voxel that no leaf and no tile covers.
    pub background: T,
    leaves: Vec<Leaf<T>>,
    tiles: Vec<Tile<T>>,
}

/// A sparse volume of `f32`.
pub type FloatTree = SparseTree<f32>;

/// Place in the order of a file: root entry, slot of the 32³ node, slot of the 16³ node.
pub(crate) type TreeOrder = ([i32; 3], u32, u32);

fn slot(origin: [i32; 3], shift: u32, log2_slots: u32) -> u32 {
    let mask = (1 << log2_slots) - 1;
    origin.into_iter().fold(0, |slot, axis| {
        slot << log2_slots | ((axis >> shift) as u32 & mask)
    })
}

/// The order in which a file holds leaves and tiles.
pub(crate) fn tree_order(origin: [i32; 3]) -> TreeOrder {
    (
        origin.map(|axis| axis >> 12),
        slot(origin, 7, 5),
        slot(origin, 3, 4),
    )
}

impl<T: Value> SparseTree<T> {
    /// An empty volume.
    pub fn new(background: T) -> Self {
        Self {
            background,
            leaves: Vec::new(),
            tiles: Vec::new(),
        }
    }

    /// A volume of leaves, in any order.
    ///
    /// # Errors
    /// [`Error::Misaligned`] or [`Error::Overlap`] if an origin is not a multiple of 8 or comes
    /// twice.
    pub fn from_leaves(background: T, leaves: Vec<Leaf<T>>) -> Result<Self, Error> {
        Self::from_parts(background, leaves, Vec::new())
    }

    /// A volume of leaves and tiles, in any order.
    ///
    /// # Errors
    /// [`Error::Misaligned`] or [`Error::Overlap`] if an origin is not on the lattice of its level
    /// or two of the cubes overlap.
    pub fn from_parts(
        background: T,
        mut leaves: Vec<Leaf<T>>,
        mut tiles: Vec<Tile<T>>,
    ) -> Result<Self, Error> {
        // By their places, so that every leaf moves once, and none if they are in order.
        leaves.sort_by_cached_key(|leaf| tree_order(leaf.origin));
        // Of tiles that start at the same voxel the largest comes first, so that it covers the next.
        tiles.sort_unstable_by_key(|tile| (tree_order(tile.origin), std::cmp::Reverse(tile.level)));
        let tree = Self {
            background,
            leaves,
            tiles,
        };
        tree.check()?;
        Ok(tree)
    }

    fn check(&self) -> Result<(), Error> {
        for leaf in &self.leaves {
            TileLevel::Leaf.check(leaf.origin)?;
        }
        for tile in &self.tiles {
            tile.level.check(tile.origin)?;
            // What lies inside the tile stands right behind its first voxel in the order.
            let before = |leaf: &Leaf<T>| tree_order(leaf.origin) < tree_order(tile.origin);
            let next = self.leaves.get(self.leaves.partition_point(before));
            if next.is_some_and(|leaf| tile.covers(leaf.origin)) {
                return Err(Error::Overlap {
                    origin: tile.origin,
                });
            }
        }
        let twice = self
            .leaves
            .windows(2)
            .find(|pair| pair[0].origin == pair[1].origin);
        let twice = twice.map(|pair| pair[0].origin);
        let covered = |pair: &&[Tile<T>]| pair[0].covers(pair[1].origin);
        let covered = self
            .tiles
            .windows(2)
            .find(covered)
            .map(|pair| pair[1].origin);
        twice
            .or(covered)
            .map_or(Ok(()), |origin| Err(Error::Overlap { origin }))
    }

    /// The leaves, in the order of a file: by root entry of 4096³ voxels, then by node of 128³,
    /// then by leaf; x before y before z at each level.
    pub fn leaves(&self) -> &[Leaf<T>] {
        &self.leaves
    }

    /// The leaves themselves, in the same order.
    pub fn into_leaves(self) -> Vec<Leaf<T>> {
        self.leaves
    }

    /// The tiles, in the same order as the leaves.
    pub fn tiles(&self) -> &[Tile<T>] {
        &self.tiles
    }

    /// The leaf that covers a voxel.
    pub fn leaf(&self, voxel: [i32; 3]) -> Option<&Leaf<T>> {
        let key = tree_order(voxel);
        let place = self
            .leaves
            .binary_search_by_key(&key, |leaf| tree_order(leaf.origin));
        place.ok().map(|place| &self.leaves[place])
    }

    /// The value of a voxel.
    pub fn get(&self, voxel: [i32; 3]) -> T {
        if let Some(leaf) = self.leaf(voxel) {
            return leaf.values[Leaf::<T>::index(voxel)];
        }
        self.tile(voxel).map_or(self.background, |tile| tile.value)
    }

    /// Whether a voxel is active.
    pub fn is_active(&self, voxel: [i32; 3]) -> bool {
        match self.leaf(voxel) {
            Some(leaf) => leaf.is_active(Leaf::<T>::index(voxel)),
            None => self.tile(voxel).is_some_and(|tile| tile.active),
        }
    }

    /// The tile that covers a voxel: in the order of the tree, none stands between it and the voxel.
    fn tile(&self, voxel: [i32; 3]) -> Option<&Tile<T>> {
        let key = tree_order(voxel);
        let end = self
            .tiles
            .partition_point(|tile| tree_order(tile.origin) <= key);
        self.tiles[..end].last().filter(|tile| tile.covers(voxel))
    }

    /// Bytes that the leaves and tiles take in memory.
    pub(crate) fn memory(&self) -> u64 {
        let tiles = self.tiles.len() * size_of::<Tile<T>>();
        self.leaves.len() as u64 * Leaf::<T>::MEMORY + tiles as u64
    }

    /// Number of active voxels, those of tiles included.
    pub fn active_voxel_count(&self) -> u64 {
        let in_leaves: u64 = self
            .leaves
            .iter()
            .map(|leaf| u64::from(leaf.active_count()))
            .sum();
        let active = self.tiles.iter().filter(|tile| tile.active);
        in_leaves
            + active
                .map(|tile| (tile.level.dim() as u64).pow(3))
                .sum::<u64>()
    }

    /// Lowest and highest active voxel on each axis; `None` if no voxel is active.
    pub fn active_bounds(&self) -> Option<([i32; 3], [i32; 3])> {
        let mut bounds: Option<([i32; 3], [i32; 3])> = None;
        let mut add = |low: [i32; 3], high: [i32; 3]| {
            let (min, max) = bounds.get_or_insert((low, high));
            for axis in 0..3 {
                min[axis] = min[axis].min(low[axis]);
                max[axis] = max[axis].max(high[axis]);
            }
        };
        for leaf in &self.leaves {
            if let Some([low, high]) = leaf.active_corners() {
                add(low, high);
            }
        }
        for tile in self.tiles.iter().filter(|tile| tile.active) {
            add(
                tile.origin,
                tile.origin.map(|axis| axis + (tile.level.dim() - 1)),
            );
        }
        bounds
    }
}
