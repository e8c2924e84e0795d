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
//! <r³> = r_e <r²>. Where r_e is a formula of other grids (temperature, age) it holds voxel by voxel, with values that
//! are trilinear between the voxels of those.
//!
//! Files have a world of their own: [`DensityImport::to_metres`] takes it to metres with y up, and a lattice that is
//! not made of axis-parallel cubes there is resampled (`resample.rs`).
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eqs. 2.53, 2.54, 2.56.

use std::borrow::Cow;
use std::collections::BTreeMap;

use glam::DMat3;
use niji_sizes::HansenTravis;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEVEL_SET;
use niji_vdb::Leaf;
use niji_vdb::SparseTree;
use niji_vdb::Tile;
use niji_vdb::Transform;
use niji_vdb::Tree;
use niji_vdb::Value;
use niji_vdb::VdbFile;
use rayon::prelude::*;
use schemars::JsonSchema;
use schemars::Schema;
use schemars::SchemaGenerator;
use schemars::json_schema;
use serde::Deserialize;
use serde::Serialize;

use crate::DropLeaf;
use crate::DropMode;
use crate::DropVolume;
use crate::Drops;
use crate::Error;
use crate::local_radius::LocalRadius;
use crate::local_radius::is_radius;
use crate::mode::EXPECT_VARIANCE;
use crate::mode::LEAF_NODES;
use crate::mode::check_drops;
use crate::mode::sound_variance;
use crate::radius_formula::RadiusFormula;
use crate::read_vdb::FloatGrid;
use crate::read_vdb::Rule;
use crate::read_vdb::missing;
use crate::read_vdb::spread;
use crate::resample::Lattice;
use crate::summary::max_optical_depth_q1;

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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DensityImport {
    /// What the numbers mean.
    pub density_means: DensityMeans,
    /// Factor on the numbers or, for [`DensityMeans::OpticalDepth`], the optical depth; above 0.
    pub scale: f64,
    /// Effective radius of the drops (um), above 0 and at most 1e5.
    pub effective_radius_um: EffectiveRadius,
    /// Effective variance of all drops, 0..1/2.
    pub effective_variance: f64,
    /// By columns, the matrix from the file's world to metres with y up.
    #[serde(default = "identity", skip_serializing_if = "is_identity")]
    pub to_metres: [[f64; 3]; 3],
    /// Edge of the voxels of the drops (m): the shortest step of the grid where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub voxel_m: Option<f64>,
}

fn identity() -> [[f64; 3]; 3] {
    DMat3::IDENTITY.to_cols_array_2d()
}

fn is_identity(matrix: &[[f64; 3]; 3]) -> bool {
    *matrix == identity()
}

impl DensityImport {
    /// Of a file in metres with y up, on its own voxels.
    #[must_use]
    pub fn in_metres(
        (density_means, scale): (DensityMeans, f64),
        effective_radius_um: EffectiveRadius,
        effective_variance: f64,
    ) -> Self {
        Self {
            density_means,
            scale,
            effective_radius_um,
            effective_variance,
            to_metres: identity(),
            voxel_m: None,
        }
    }
}

/// An effective radius (um). A text that is a number is that number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, from = "NumberOrText")]
pub enum EffectiveRadius {
    /// The same everywhere.
    Um(f64),
    /// A formula of the names of grids, voxel by voxel.
    Formula(String),
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a radius, or a formula of grids")]
enum NumberOrText {
    Number(f64),
    Text(String),
}

impl From<NumberOrText> for EffectiveRadius {
    fn from(found: NumberOrText) -> Self {
        match found {
            NumberOrText::Number(radius_um) => Self::Um(radius_um),
            NumberOrText::Text(text) => match text.trim().parse() {
                Ok(radius_um) => Self::Um(radius_um),
                Err(_) => Self::Formula(text),
            },
        }
    }
}

impl JsonSchema for EffectiveRadius {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "EffectiveRadius".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": ["number", "string"],
            "exclusiveMinimum": 0.0,
            "maximum": LARGEST_RADIUS_UM,
            "minLength": 1,
        })
    }
}

/// Largest radius [um].
const LARGEST_RADIUS_UM: f64 = 1e5;
const EXPECT_RADIUS: &str = "a radius above 0 and at most 1e5 um";

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
    /// use niji_dropfield::{DensityImport, DensityMeans, DropVolume, EffectiveRadius};
    /// use niji_vdb::{FOG_VOLUME, FloatTree, Grid, Leaf, Transform, VdbFile};
    ///
    /// let mut leaf = Leaf::new([0; 3], 0.0);
    /// leaf.set([1, 2, 3], 0.5);
    /// let transform = Transform::uniform_scale_translate(2.0, DVec3::ZERO);
    /// let tree = FloatTree::from_leaves(0.0, vec![leaf])?;
    /// let file = VdbFile::new(vec![Grid::new("density", FOG_VOLUME, transform, tree)]);
    ///
    /// // 0.6 g of water per cubic metre where the density is 1.
    /// let water = (DensityMeans::Water, 0.6);
    /// let import = DensityImport::in_metres(water, EffectiveRadius::Um(10.0), 0.1);
    /// let volume = DropVolume::from_density(&file, "density", &import)?;
    /// assert!((volume.modes[0].total_water_g() - 0.3 * 2.0_f64.powi(3)).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadSetting`]; [`Error::BadFormula`]; [`Error::MissingGrid`] and [`Error::UnknownName`] with the grids
    /// that there are; grids of level sets or vectors, a background other than 0, too many voxels, values that are
    /// negative or not finite, a formula that comes to no radius ([`Error::BadVoxel`]).
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
        let radius = LocalRadius::new(file, grid, import)?;
        let leaves = import.drops(grid, &radius)?;
        let to_metres = DMat3::from_cols_array_2d(&import.to_metres);
        let linear = to_metres * grid.transform.linear();
        let origin = to_metres * grid.transform.translation();
        let lattice = Lattice {
            transform: Transform::affine(linear, origin)?,
            leaves,
        };
        let mode = lattice.on_cubes(import.voxel_m)?;
        let scale = import.scale_of_all(&mode);
        let mode = mode.with_numbers_scaled(|_, _| scale)?;
        Ok(Self { modes: vec![mode] })
    }
}

impl DensityImport {
    /// Check the scale and the sizes.
    ///
    /// # Errors
    /// [`Error::BadSetting`], naming the setting.
    pub fn validate(&self) -> Result<(), Error> {
        let radius_um = match &self.effective_radius_um {
            EffectiveRadius::Um(radius_um) => *radius_um,
            EffectiveRadius::Formula(text) => {
                RadiusFormula::parse(text)?;
                LARGEST_RADIUS_UM
            }
        };
        let linear = DMat3::from_cols_array_2d(&self.to_metres);
        let voxel_m = self.voxel_m.unwrap_or(1.0);
        let checks = [
            (
                self.scale.is_finite() && self.scale > 0.0,
                "scale",
                self.scale,
                "a finite number above 0",
            ),
            (
                is_radius(radius_um),
                "effective_radius_um",
                radius_um,
                EXPECT_RADIUS,
            ),
            (
                linear.is_finite() && linear.determinant() != 0.0,
                "to_metres",
                linear.determinant(),
                "a matrix with an inverse",
            ),
            (
                voxel_m.is_finite() && voxel_m > 0.0,
                "voxel_m",
                voxel_m,
                "a finite edge above 0",
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

    /// Drops per cubic metre where the grid says 1 and drops have a radius (1/m³), but for what is scaled as a whole.
    fn number_per_value(&self, radius_um: f64) -> f64 {
        let law = HansenTravis {
            effective_radius_um: radius_um,
            effective_variance: self.effective_variance,
            d_min_mm: None,
            d_max_mm: None,
        };
        let one_drop = law.moments().bulk_properties(1.0);
        match self.density_means {
            DensityMeans::Number => self.scale,
            DensityMeans::Water => self.scale / one_drop.lwc_g_m3,
            DensityMeans::Extinction => self.scale / one_drop.extinction_m1,
            DensityMeans::OpticalDepth => 1.0 / one_drop.extinction_m1,
        }
    }

    /// What all numbers are scaled with in the end.
    fn scale_of_all(&self, mode: &DropMode) -> f64 {
        if self.density_means != DensityMeans::OpticalDepth {
            return 1.0;
        }
        let depths = [0, 1, 2].map(|axis| 2.0 * max_optical_depth_q1(mode, axis));
        let largest = depths.into_iter().fold(0.0, f64::max);
        // Without voxels there is nothing to scale.
        if largest > 0.0 {
            self.scale / largest
        } else {
            0.0
        }
    }

    /// The drops of a grid on its own lattice.
    fn drops(
        &self,
        grid: &Grid,
        radius: &LocalRadius,
    ) -> Result<BTreeMap<[i32; 3], DropLeaf>, Error> {
        let tree = &*floats(grid)?;
        let mut leaves = BTreeMap::new();
        // Values in place of numbers.
        let set = |drops: &mut Drops, value| drops.number_density_m3 = value;
        spread(FloatGrid { grid, tree }, DENSITY_RULE, &mut leaves, set)?;
        let everywhere = match radius {
            LocalRadius::Everywhere(radius_um) => {
                Some((*radius_um, self.number_per_value(*radius_um)))
            }
            LocalRadius::Formula { .. } => None,
        };
        leaves.par_iter_mut().try_for_each(|(_, leaf)| {
            for place in 0..LEAF_NODES {
                let node = leaf.node(place);
                let drops = &mut leaf.drops[place];
                if drops.number_density_m3 > 0.0 {
                    let (radius_um, per_value) = if let Some(known) = everywhere {
                        known
                    } else {
                        let radius_um = radius.at(node, grid)?;
                        (radius_um, self.number_per_value(radius_um))
                    };
                    let number = per_value * f64::from(drops.number_density_m3);
                    *drops = Drops {
                        number_density_m3: number as f32,
                        effective_radius_m: (1e-6 * radius_um) as f32,
                        effective_variance: self.effective_variance as f32,
                    };
                    check_drops(drops, node)?;
                }
            }
            Ok::<_, Error>(())
        })?;
        leaves.retain(|_, leaf| leaf.drops.iter().any(Drops::exist));
        Ok(leaves)
    }
}

/// The first grid of that name, or for `name[k]` the one with k others of its name before it.
pub(crate) fn find<'a>(file: &'a VdbFile, name: &str) -> Option<&'a Grid> {
    file.grid(name).or_else(|| {
        let (name, place) = name.strip_suffix(']')?.rsplit_once('[')?;
        let mut same_name = file.grids.iter().filter(|grid| grid.name == name);
        same_name.nth(place.parse().ok()?)
    })
}

/// The tree in f32; a density that f32 cannot hold becomes infinite, and is refused as such.
pub(crate) fn floats(grid: &Grid) -> Result<Cow<'_, FloatTree>, Error> {
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
