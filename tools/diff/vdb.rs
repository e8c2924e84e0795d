//! Two VDB files, voxel by voxel.

use std::collections::BTreeMap;
use std::path::Path;

use niji_picture::read_vdb;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::VdbFile;

use super::measure::Measure;
use super::measure::same_names;
use crate::failure::Failure;

pub(super) fn compare(reference: &Path, file: &Path) -> Result<Vec<Measure>, Failure> {
    let (reference, found) = (read_vdb(reference, |_| true)?, read_vdb(file, |_| true)?);
    let names = |file: &VdbFile| -> Vec<String> {
        file.grids.iter().map(|grid| grid.name.clone()).collect()
    };
    let (these, those) = (names(&reference), names(&found));
    same_names("grids", &these, &those)?;
    let pairs = reference.grids.iter().filter_map(|grid| {
        let other = found.grids.iter().find(|other| other.name == grid.name)?;
        Some(compare_grids(grid, other))
    });
    pairs.collect()
}

fn compare_grids(reference: &Grid, found: &Grid) -> Result<Measure, Failure> {
    let name = &reference.name;
    if reference.transform != found.transform {
        return Err(Failure::ComparisonFailed(format!(
            "{name}: the lattices differ, {:?} and {:?}",
            reference.transform, found.transform
        )));
    }
    let (Some(these), Some(those)) = (reference.tree.as_float(), found.tree.as_float()) else {
        return Err(Failure::ComparisonFailed(format!(
            "{name}: found a grid that is no float grid, expected two float grids"
        )));
    };
    if (these.background, these.tiles()) != (those.background, those.tiles()) {
        return Err(Failure::ComparisonFailed(format!(
            "{name}: the grids have different backgrounds or tiles"
        )));
    }
    let mut measure = Measure::new(name.clone());
    add_leaves(these, those, &mut measure);
    Ok(measure)
}

/// Adds every voxel that is active in either of the trees, in order of their leaves.
fn add_leaves(these: &FloatTree, those: &FloatTree, measure: &mut Measure) {
    let mut pairs: BTreeMap<[i32; 3], [Option<&Leaf<f32>>; 2]> = BTreeMap::new();
    for (index, tree) in [these, those].into_iter().enumerate() {
        for leaf in tree.leaves() {
            pairs.entry(leaf.origin).or_default()[index] = Some(leaf);
        }
    }
    for pair in pairs.into_values() {
        let Some(leaf) = pair[0].or(pair[1]) else {
            continue;
        };
        for index in 0..leaf.values.len() {
            let is_active = |leaf: &Leaf<f32>| leaf.is_active(index);
            if !pair.into_iter().flatten().any(is_active) {
                continue;
            }
            let voxel = leaf.voxel(index);
            let value = |leaf: Option<&Leaf<f32>>, tree: &FloatTree| {
                f64::from(leaf.map_or_else(|| tree.get(voxel), |leaf| leaf.values[index]))
            };
            let [x, y, z] = voxel;
            measure.add(value(pair[0], these), value(pair[1], those), || {
                format!("({x}, {y}, {z})")
            });
        }
    }
}
