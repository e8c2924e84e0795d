//! A drop volume and its VDB layout.
//!
//! Per mode, with the mode's name and `_` before each grid name (nothing before them for a mode
//! without a name):
//! `number_density` [1/m³]     drops per cubic metre, of a gamma law ([`crate::Drops`])
//! `effective_radius` [m]      r_e = <r³>/<r²>
//! `effective_variance` [1]    v_e; left out where it is 0 everywhere
//! and for display in programs that draw smoke
//! `density` [1/m]             extinction at Q = 2, of all modes together if they share a lattice,
//!                             else one grid per mode
//! All are `float` grids of class fog volume with background 0. A voxel's index is a node; its
//! world position is the node's. Metadata of the file: `niji:dropVolumeVersion`, `niji:law`, and
//! what the caller adds; of each grid: `units` and `quantity`.

use std::collections::BTreeMap;
use std::collections::BTreeSet;

use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

use crate::AreaMoments;
use crate::DropLeaf;
use crate::DropMode;
use crate::Drops;
use crate::Error;
use crate::read_vdb;

/// Version of this layout, `niji:dropVolumeVersion` in the file.
pub(crate) const FORMAT_VERSION: i32 = 1;
/// Metadata item that holds the version.
pub(crate) const VERSION_ITEM: &str = "niji:dropVolumeVersion";

/// A quantity of the layout: the grid's name without its prefix, its unit and what it says.
pub(crate) struct Quantity {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    meaning: &'static str,
}

pub(crate) const NUMBER_DENSITY: Quantity = Quantity {
    name: "number_density",
    unit: "1/m^3",
    meaning: "drops per cubic metre of air",
};
pub(crate) const EFFECTIVE_RADIUS: Quantity = Quantity {
    name: "effective_radius",
    unit: "m",
    meaning: "effective radius <r^3>/<r^2>",
};
pub(crate) const EFFECTIVE_VARIANCE: Quantity = Quantity {
    name: "effective_variance",
    unit: "1",
    meaning: "effective variance <r^2><r^4>/<r^3>^2 - 1",
};
const DENSITY: Quantity = Quantity {
    name: "density",
    unit: "1/m",
    meaning: "extinction at Q = 2, for display only",
};

/// All drops of a scene's volume.
///
/// ```
/// use glam::DVec3;
/// use niji_dropfield::{DropMode, DropVolume, Drops, GridBox};
///
/// let drops =
///     Drops { number_density_m3: 1000.0, effective_radius_m: 1e-4, effective_variance: 0.1 };
/// let grid = GridBox { min: DVec3::ZERO, max: DVec3::splat(8.0), voxel_m: 1.0 };
/// let volume = DropVolume { modes: vec![DropMode::from_fn("", &grid, |_| drops)?] };
///
/// // As OpenVDB and back; a file holds f32.
/// let again = DropVolume::from_vdb(&volume.to_vdb(&[])?)?;
/// assert!((again.summary().total_drops / (1000.0 * 512.0) - 1.0).abs() < 1e-6);
/// # Ok::<(), niji_dropfield::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DropVolume {
    /// The populations; at any point their moments add.
    pub modes: Vec<DropMode>,
}

impl DropVolume {
    /// Several volumes as one: their modes side by side, each behind the name of its volume.
    ///
    /// ```
    /// use glam::DVec3;
    /// use niji_dropfield::{DropMode, DropVolume, Drops, GridBox};
    ///
    /// let grid = GridBox { min: DVec3::ZERO, max: DVec3::ONE, voxel_m: 1.0 };
    /// let mode = |name: &str| DropMode::from_fn(name, &grid, |_| Drops::NONE);
    /// let volume = |name: &str| mode(name).map(|mode| DropVolume { modes: vec![mode] });
    ///
    /// let parts = [("rain".to_owned(), volume("")?), ("fall".to_owned(), volume("mist")?)];
    /// let names = DropVolume::joined(parts).modes.into_iter().map(|mode| mode.name);
    /// assert_eq!(names.collect::<Vec<_>>(), ["rain", "fall_mist"]);
    /// # Ok::<(), niji_dropfield::Error>(())
    /// ```
    #[must_use]
    pub fn joined(volumes: impl IntoIterator<Item = (String, Self)>) -> Self {
        let mut modes = Vec::new();
        for (name, volume) in volumes {
            for mut mode in volume.modes {
                mode.name = joined_name(&name, &mode.name);
                modes.push(mode);
            }
        }
        Self { modes }
    }

    /// The volume as grids. `metadata` goes to the file as a whole.
    ///
    /// # Errors
    /// [`Error::BadModeName`] if two modes have one name, or a name ends in a way that its grids
    /// would be read as those of another mode.
    pub fn to_vdb(&self, metadata: &[(String, String)]) -> Result<VdbFile, Error> {
        self.check_names()?;
        let mut grids = Vec::new();
        for mode in &self.modes {
            grids.push(grid(mode, &NUMBER_DENSITY, |drops| {
                drops.number_density_m3
            })?);
            grids.push(grid(mode, &EFFECTIVE_RADIUS, |drops| {
                drops.effective_radius_m
            })?);
            if mode
                .nodes()
                .any(|(_, drops)| drops.effective_variance > 0.0)
            {
                grids.push(grid(mode, &EFFECTIVE_VARIANCE, |drops| {
                    drops.effective_variance
                })?);
            }
        }
        grids.extend(self.density_grids()?);
        let mut file = VdbFile::new(grids);
        file.metadata.insert(VERSION_ITEM, FORMAT_VERSION);
        file.metadata
            .insert("niji:law", "gamma (Hansen and Travis 1974)");
        for (name, value) in metadata {
            file.metadata.insert(name.as_str(), value.as_str());
        }
        Ok(file)
    }

    /// Whether a grid of that name is read from a file; the others are for display, or not ours.
    #[must_use]
    pub fn reads_grid(name: &str) -> bool {
        [NUMBER_DENSITY, EFFECTIVE_RADIUS, EFFECTIVE_VARIANCE]
            .iter()
            .any(|quantity| name.ends_with(quantity.name))
    }

    /// The volume that a file holds: a mode for every grid `number_density`, with or without a
    /// prefix. Voxels without drops are dropped; constant regions are filled out.
    ///
    /// # Errors
    /// Grids that are missing, there twice, of the wrong type, unit or lattice; voxels that no drops can have.
    pub fn from_vdb(file: &VdbFile) -> Result<Self, Error> {
        read_vdb::volume(file)
    }

    fn check_names(&self) -> Result<(), Error> {
        let mut seen = BTreeSet::new();
        for mode in &self.modes {
            let fault = mode_name_fault(&mode.name);
            let twice = (!seen.insert(&mode.name)).then_some("is there twice");
            if let Some(reason) = twice.or(fault) {
                return Err(Error::BadModeName {
                    name: mode.name.clone(),
                    reason,
                });
            }
        }
        Ok(())
    }

    fn density_grids(&self) -> Result<Vec<Grid>, Error> {
        let Some(first) = self.modes.first() else {
            return Ok(Vec::new());
        };
        let one_lattice = self
            .modes
            .iter()
            .all(|mode| transform(mode) == transform(first));
        if !one_lattice {
            let per_mode = |mode| grid(mode, &DENSITY, |drops| display_density(drops) as f32);
            return self.modes.iter().map(per_mode).collect();
        }
        let mut sums: BTreeMap<[i32; 3], Leaf> = BTreeMap::new();
        for leaf in self.modes.iter().flat_map(DropMode::leaves) {
            let sum = sums
                .entry(leaf.origin)
                .or_insert_with(|| Leaf::new(leaf.origin, 0.0));
            for (place, drops) in leaf
                .drops
                .iter()
                .enumerate()
                .filter(|(_, drops)| drops.exist())
            {
                sum.set(
                    leaf.node(place),
                    sum.values[place] + display_density(drops) as f32,
                );
            }
        }
        let tree = FloatTree::from_leaves(0.0, sums.into_values().collect())?;
        Ok(vec![described_grid(
            DENSITY.name.to_owned(),
            &DENSITY,
            transform(first),
            tree,
        )])
    }
}

/// Why the grids of a mode could not be told from those of another; `None` where they can. A mode
/// `number` would have a grid `number_density` for display, which is that of a mode without a name.
#[must_use]
pub fn mode_name_fault(name: &str) -> Option<&'static str> {
    if name.ends_with('_') || name.contains(char::is_whitespace) {
        Some("ends with an underscore or holds white space")
    } else if name == "number" || name.ends_with("_number") {
        Some("ends with `number`, so that its grid for display would be read as drops")
    } else {
        None
    }
}

/// Name of a mode's grid.
pub(crate) fn grid_name(mode: &str, quantity: &Quantity) -> String {
    joined_name(mode, quantity.name)
}

/// A name behind another, if there are both.
fn joined_name(first: &str, second: &str) -> String {
    match (first, second) {
        ("", only) | (only, "") => only.to_owned(),
        (first, second) => format!("{first}_{second}"),
    }
}

/// Extinction at Q = 2 (1/m).
fn display_density(drops: &Drops) -> f64 {
    2.0 * AreaMoments::from_drops(drops).extinction_m1_q1()
}

fn transform(mode: &DropMode) -> Transform {
    Transform::uniform_scale_translate(mode.voxel_m(), mode.origin_m())
}

fn grid(
    mode: &DropMode,
    quantity: &Quantity,
    value: impl Fn(&Drops) -> f32,
) -> Result<Grid, Error> {
    let to_leaf = |leaf: &DropLeaf| {
        let mut floats = Leaf::new(leaf.origin, 0.0);
        for (place, drops) in leaf
            .drops
            .iter()
            .enumerate()
            .filter(|(_, drops)| drops.exist())
        {
            floats.set(leaf.node(place), value(drops));
        }
        floats
    };
    let tree = FloatTree::from_leaves(0.0, mode.leaves().iter().map(to_leaf).collect())?;
    Ok(described_grid(
        grid_name(&mode.name, quantity),
        quantity,
        transform(mode),
        tree,
    ))
}

fn described_grid(
    name: String,
    quantity: &Quantity,
    transform: Transform,
    tree: FloatTree,
) -> Grid {
    let mut grid = Grid::new(name, FOG_VOLUME, transform, tree);
    grid.metadata.insert("units", quantity.unit);
    grid.metadata.insert("quantity", quantity.meaning);
    grid
}
