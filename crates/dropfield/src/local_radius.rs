//! The radius of drops voxel by voxel, by a formula of grids that may have lattices of their own.

use std::borrow::Cow;

use glam::DVec3;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

use crate::DensityImport;
use crate::EffectiveRadius;
use crate::Error;
use crate::from_density::find;
use crate::from_density::floats;
use crate::mode::LARGEST_RADIUS_M;
use crate::radius_formula::RadiusFormula;

/// Part of a voxel within which a place is that voxel.
const ON_VOXEL: f64 = 1e-6;

/// Written so that a radius that vanishes in f32 is refused.
pub(crate) fn is_radius(radius_um: f64) -> bool {
    let radius_m = (1e-6 * radius_um) as f32;
    radius_m > 0.0 && radius_m <= LARGEST_RADIUS_M
}

/// The radius of drops at the voxels of a grid.
pub(crate) enum LocalRadius<'a> {
    Everywhere(f64),
    Formula {
        formula: RadiusFormula,
        /// What its names stand for, in their order, with their places.
        grids: Vec<(Cow<'a, FloatTree>, Transform)>,
    },
}

impl<'a> LocalRadius<'a> {
    pub(crate) fn new(
        file: &'a VdbFile,
        grid: &Grid,
        import: &DensityImport,
    ) -> Result<Self, Error> {
        let text = match &import.effective_radius_um {
            EffectiveRadius::Um(radius_um) => return Ok(Self::Everywhere(*radius_um)),
            EffectiveRadius::Formula(text) => text,
        };
        let formula = RadiusFormula::parse(text)?;
        let named = |name: &str| {
            // The density itself by its plain name, whichever of its name it is.
            let found = if name == grid.name {
                None
            } else {
                find(file, name)
            };
            let found = found.or_else(|| file.grids.iter().find(|it| it.name == name));
            let names = || file.grids.iter().map(|grid| grid.name.clone()).collect();
            let found = found.ok_or_else(|| formula.unknown(name, names()))?;
            Ok((floats(found)?, found.transform))
        };
        let grids = formula.names().map(named);
        let grids = grids.collect::<Result<_, Error>>()?;
        Ok(Self::Formula { formula, grids })
    }

    /// At a voxel of the grid of the density.
    pub(crate) fn at(&self, voxel: [i32; 3], grid: &Grid) -> Result<f64, Error> {
        let (formula, grids) = match self {
            Self::Everywhere(radius_um) => return Ok(*radius_um),
            Self::Formula { formula, grids } => (formula, grids),
        };
        let place = grid
            .transform
            .index_to_world(DVec3::from(voxel.map(f64::from)));
        let values = grids.iter();
        let values = values.map(|(tree, own)| trilinear(tree, own.world_to_index(place)));
        let radius_um = formula.value(&values.collect::<Vec<f64>>());
        if is_radius(radius_um) {
            return Ok(radius_um);
        }
        Err(Error::BadVoxel {
            grid: grid.name.clone(),
            voxel,
            value: radius_um as f32,
            expected: "a formula that comes to a radius above 0 and at most 1e5 um where there are drops",
        })
    }
}

/// The value of a tree at a place in its indices.
fn trilinear(tree: &FloatTree, index: DVec3) -> f64 {
    // Of a grid with the same lattice, a voxel and no more.
    let near = index.round();
    let index = if (index - near).abs().max_element() < ON_VOXEL {
        near
    } else {
        index
    };
    let low = index.floor();
    let part = index - low;
    let low = low.to_array().map(|axis| axis as i32);
    let corners = (0..8).map(|corner| {
        let step = [0, 1, 2].map(|axis| corner >> axis & 1);
        let weights = [0, 1, 2].map(|axis| {
            if step[axis] == 1 {
                part[axis]
            } else {
                1.0 - part[axis]
            }
        });
        let weight: f64 = weights.iter().product();
        let node = [0, 1, 2].map(|axis| low[axis].saturating_add(step[axis]));
        // No 0 times what is not finite.
        if weight > 0.0 {
            weight * f64::from(tree.get(node))
        } else {
            0.0
        }
    });
    corners.sum()
}
