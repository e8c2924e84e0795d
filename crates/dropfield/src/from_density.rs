//! Drops out of a density grid that another program made.
//!
//! Smoke and cloud simulations give one number a voxel and no drop sizes. With one gamma law
//! everywhere ([`crate::Drops`]) the number of drops N follows from that value d, in each of the
//! meanings that such a number has:
//! N = s d                                           drops per cubic metre
//! N = s d/((4/3) pi rho_w <r³>)                     s d is liquid water [g/m³]
//! N = s d/(2 pi <r²>)                               s d is the extinction at Q = 2 [1/m]
//! N = s d/(2 pi <r²> max_line(sum_line(d) h))       s is the largest optical depth at Q = 2 of a
//!                                                   line of voxels along an axis
//! `s` scale, `h` voxel size [m], `<>` mean over the drops: <r²> = r_e² (1 - v_e)(1 - 2 v_e),
//! <r³> = r_e <r²>.
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eqs. 2.53, 2.54, 2.56.

use std::borrow::Cow;
use std::collections::BTreeMap;

use niji_sizes::HansenTravis;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEVEL_SET;
use niji_vdb::Leaf;
use niji_vdb::SparseTree;
use niji_vdb::Tile;
use niji_vdb::Tree;
use niji_vdb::Value;
use niji_vdb::VdbFile;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::DropMode;
use crate::DropVolume;
use crate::Drops;
use crate::Error;
use crate::mode::EXPECT_VARIANCE;
use crate::mode::LARGEST_RADIUS_M;
use crate::mode::sound_variance;
use crate::read_vdb::FloatGrid;
use crate::read_vdb::Rule;
use crate::read_vdb::lattice;
use crate::read_vdb::missing;
use crate::read_vdb::spread;
use crate::summary::largest_line_sum;

/// What the numbers of a foreign density grid mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DensityMeans {
    /// Scale times value is the number of drops per cubic metre (1/m³).
    Number,
    /// Scale times value is liquid water (g/m³).
    Water,
    /// Scale times value is the extinction at Q = 2 (1/m).
    Extinction,
    /// Values are relative: the largest optical depth at Q = 2 of a line of voxels along an axis
    /// of the lattice is the scale.
    OpticalDepth,
}

/// How a density grid becomes drops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DensityImport {
    /// What the numbers mean.
    pub density_means: DensityMeans,
    /// Factor on the numbers or, for [`DensityMeans::OpticalDepth`], the optical depth; above 0.
    pub scale: f64,
    /// Effective radius of all drops (um), above 0 and at most 1e5.
    pub effective_radius_um: f64,
    /// Effective variance of all drops, 0..1/2.
    pub effective_variance: f64,
}

/// What a value of a density grid must be.
const DENSITY_RULE: Rule = Rule {
    is_sound: |value| value.is_finite() && value >= 0.0,
    expected: "a finite density not below 0",
};

impl DropVolume {
    /// One mode without a name from a grid of floats, doubles, halves, int32 or bools (a mask of
    /// zeros and ones). Of several grids of one name the first is taken; `name[1]` is the second.
    /// Only active voxels count; constant regions are filled out.
    ///
    /// ```
    /// use glam::DVec3;
    /// use niji_dropfield::{DensityImport, DensityMeans, DropVolume};
    /// use niji_vdb::{FOG_VOLUME, FloatTree, Grid, Leaf, Transform, VdbFile};
    ///
    /// let mut leaf = Leaf::new([0; 3], 0.0);
    /// leaf.set([1, 2, 3], 0.5);
    /// let transform = Transform::uniform_scale_translate(2.0, DVec3::ZERO);
    /// let tree = FloatTree::from_leaves(0.0, vec![leaf])?;
    /// let file = VdbFile::new(vec![Grid::new("density", FOG_VOLUME, transform, tree)]);
    ///
    /// // 0.6 g of water per cubic metre where the density is 1.
    /// let import = DensityImport {
    ///     density_means: DensityMeans::Water,
    ///     scale: 0.6,
    ///     effective_radius_um: 10.0,
    ///     effective_variance: 0.1,
    /// };
    /// let volume = DropVolume::from_density(&file, "density", &import)?;
    /// assert!((volume.modes[0].total_water_g() - 0.3 * 2.0_f64.powi(3)).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadSetting`]; [`Error::MissingGrid`] with the grids that there are; grids of level
    /// sets or vectors, lattices that are not axis-parallel cubes, a background other than 0, too
    /// many voxels, values that are negative or not finite.
    pub fn from_density(
        file: &VdbFile,
        grid_name: &str,
        import: &DensityImport,
    ) -> Result<Self, Error> {
        import.validate()?;
        let grid = find(file, grid_name).ok_or_else(|| missing(file, grid_name.to_owned()))?;
        if grid.class == LEVEL_SET {
            let grid = grid.name.clone();
            return Err(Error::LevelSet { grid });
        }
        let values = values_as_numbers(grid, import)?;
        let number_per_value = import.number_per_value(&values);
        let mode = values.with_numbers_scaled(|_| number_per_value)?;
        Ok(Self { modes: vec![mode] })
    }
}

impl DensityImport {
    /// Check the scale and the sizes.
    ///
    /// # Errors
    /// [`Error::BadSetting`], naming the setting.
    pub fn validate(&self) -> Result<(), Error> {
        let radius_m = 1e-6 * self.effective_radius_um;
        let checks = [
            (
                self.scale.is_finite() && self.scale > 0.0,
                "scale",
                self.scale,
                "a finite number above 0",
            ),
            (
                // Written so that a radius that vanishes in f32 is refused.
                radius_m as f32 > 0.0 && radius_m as f32 <= LARGEST_RADIUS_M,
                "effective_radius_um",
                self.effective_radius_um,
                "a radius above 0 and at most 1e5 um",
            ),
            (
                sound_variance(self.effective_variance as f32),
                "effective_variance",
                self.effective_variance,
                EXPECT_VARIANCE,
            ),
        ];
        match checks.into_iter().find(|(sound, ..)| !sound) {
            Some((_, parameter, found, expected)) => Err(Error::BadSetting {
                parameter,
                found,
                expected,
            }),
            None => Ok(()),
        }
    }

    /// Drops per cubic metre where the grid says 1 (1/m³). `values` holds the grid's values in
    /// place of the numbers.
    fn number_per_value(&self, values: &DropMode) -> f64 {
        let law = HansenTravis {
            effective_radius_um: self.effective_radius_um,
            effective_variance: self.effective_variance,
            d_min_mm: None,
            d_max_mm: None,
        };
        let one_drop = law.moments().bulk_properties(1.0);
        match self.density_means {
            DensityMeans::Number => self.scale,
            DensityMeans::Water => self.scale / one_drop.lwc_g_m3,
            DensityMeans::Extinction => self.scale / one_drop.extinction_m1,
            DensityMeans::OpticalDepth => {
                let value = |drops: &Drops| f64::from(drops.number_density_m3);
                let sums = [0, 1, 2].map(|axis| largest_line_sum(values, axis, value));
                let largest = sums.into_iter().fold(0.0, f64::max);
                // Without voxels there is nothing to scale.
                if largest > 0.0 {
                    self.scale / (one_drop.extinction_m1 * largest * values.voxel_m())
                } else {
                    0.0
                }
            }
        }
    }
}

/// The first grid of that name, or for `name[k]` the one with k others of its name before it.
fn find<'a>(file: &'a VdbFile, name: &str) -> Option<&'a Grid> {
    file.grid(name).or_else(|| {
        let (name, place) = name.strip_suffix(']')?.rsplit_once('[')?;
        let mut same_name = file.grids.iter().filter(|grid| grid.name == name);
        same_name.nth(place.parse().ok()?)
    })
}

/// A mode with the drop sizes of the import and the grid's values for numbers.
fn values_as_numbers(grid: &Grid, import: &DensityImport) -> Result<DropMode, Error> {
    let (voxel_m, origin_m) = lattice(grid)?;
    let tree = &*floats(grid)?;
    let mut leaves = BTreeMap::new();
    spread(
        FloatGrid { grid, tree },
        DENSITY_RULE,
        &mut leaves,
        |drops, value| {
            if value > 0.0 {
                *drops = Drops {
                    number_density_m3: value,
                    effective_radius_m: (1e-6 * import.effective_radius_um) as f32,
                    effective_variance: import.effective_variance as f32,
                };
            }
        },
    )?;
    leaves.retain(|_, leaf| leaf.drops.iter().any(Drops::exist));
    Ok(DropMode::from_parts(
        String::new(),
        voxel_m,
        origin_m,
        leaves.into_values().collect(),
    ))
}

/// The tree in f32; a density that f32 cannot hold becomes infinite, and is refused as such.
fn floats(grid: &Grid) -> Result<Cow<'_, FloatTree>, Error> {
    let tree = match &grid.tree {
        Tree::Float(tree) => return Ok(Cow::Borrowed(tree)),
        Tree::Double(tree) => converted(tree, |value| value as f32)?,
        Tree::Half(tree) => converted(tree, f32::from)?,
        Tree::Int32(tree) => converted(tree, |value| value as f32)?,
        Tree::Bool(tree) => converted(tree, |value| f32::from(u8::from(value)))?,
        // The list of tree types is open; whatever comes is no plain number.
        _ => {
            return Err(Error::NotScalar {
                grid: grid.name.clone(),
            });
        }
    };
    Ok(Cow::Owned(tree))
}

fn converted<T: Value>(
    tree: &SparseTree<T>,
    to_f32: impl Fn(T) -> f32,
) -> Result<FloatTree, Error> {
    let leaf = |leaf: &Leaf<T>| Leaf {
        origin: leaf.origin,
        mask: leaf.mask,
        values: leaf.values.map(&to_f32),
    };
    let tile = |tile: &Tile<T>| Tile {
        origin: tile.origin,
        level: tile.level,
        active: tile.active,
        value: to_f32(tile.value),
    };
    let leaves = tree.leaves().iter().map(leaf).collect();
    let tiles = tree.tiles().iter().map(tile).collect();
    let background = to_f32(tree.background);
    Ok(FloatTree::from_parts(background, leaves, tiles)?)
}

#[cfg(test)]
#[path = "from_density_tests.rs"]
mod tests;
