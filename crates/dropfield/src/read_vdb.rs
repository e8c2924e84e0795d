//! Drop volumes out of VDB files, ours and those of other programs.
//!
//! Everything is checked here, so that nothing behind it meets a NaN: types, units, lattices, and
//! every voxel of every grid that is used.

use std::collections::BTreeMap;

use glam::DVec3;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::MetaValue;
use niji_vdb::VdbFile;

use crate::DropLeaf;
use crate::DropMode;
use crate::DropVolume;
use crate::Drops;
use crate::Error;
use crate::LEAF_DIM;
use crate::grid_box::node_limit;
use crate::mode::EXPECT_NUMBER;
use crate::mode::EXPECT_RADIUS;
use crate::mode::EXPECT_VARIANCE;
use crate::mode::LEAF_NODES;
use crate::mode::sound_number;
use crate::mode::sound_radius;
use crate::mode::sound_variance;
use crate::volume::EFFECTIVE_RADIUS;
use crate::volume::EFFECTIVE_VARIANCE;
use crate::volume::FORMAT_VERSION;
use crate::volume::NUMBER_DENSITY;
use crate::volume::Quantity;
use crate::volume::VERSION_ITEM;
use crate::volume::grid_name;

/// Node indices beyond this leave no room for the neighbours.
const FARTHEST_INDEX: i32 = 1 << 30;

/// Lattices of one mode may differ by roundoff only: this part of a voxel, over the whole volume.
const LATTICE_TOLERANCE: f64 = 1e-6;

/// What a number of the layout must be.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    pub(crate) is_sound: fn(f32) -> bool,
    pub(crate) expected: &'static str,
}

const NUMBER_RULE: Rule = Rule {
    is_sound: sound_number,
    expected: EXPECT_NUMBER,
};
const RADIUS_RULE: Rule = Rule {
    is_sound: sound_radius,
    expected: EXPECT_RADIUS,
};
const VARIANCE_RULE: Rule = Rule {
    is_sound: sound_variance,
    expected: EXPECT_VARIANCE,
};

/// Read all modes of a file.
pub(crate) fn volume(file: &VdbFile) -> Result<DropVolume, Error> {
    if let Some(MetaValue::Int32(found)) = file.metadata.get(VERSION_ITEM)
        && *found > FORMAT_VERSION
    {
        return Err(Error::FormatVersion {
            found: *found,
            newest: FORMAT_VERSION,
        });
    }
    let names = file.grids.iter().filter_map(|grid| mode_name(&grid.name));
    let modes = names
        .map(|name| mode(file, name))
        .collect::<Result<Vec<_>, Error>>()?;
    if modes.is_empty() {
        return Err(missing(file, NUMBER_DENSITY.name.to_owned()));
    }
    Ok(DropVolume { modes })
}

/// The mode whose number density a grid of that name holds.
fn mode_name(grid: &str) -> Option<&str> {
    let prefix = grid.strip_suffix(NUMBER_DENSITY.name)?;
    if prefix.is_empty() {
        Some(prefix)
    } else {
        prefix.strip_suffix('_')
    }
}

pub(crate) fn missing(file: &VdbFile, expected: String) -> Error {
    let found = file.grids.iter().map(|grid| grid.name.clone()).collect();
    Error::MissingGrid { expected, found }
}

fn mode(file: &VdbFile, name: &str) -> Result<DropMode, Error> {
    let required = |quantity: &Quantity| {
        let grid = find(file, name, quantity)?;
        grid.ok_or_else(|| missing(file, grid_name(name, quantity)))
    };
    let number = required(&NUMBER_DENSITY)?;
    let radius = required(&EFFECTIVE_RADIUS)?;
    let variance = find(file, name, &EFFECTIVE_VARIANCE)?;
    let (voxel_m, origin_m) = lattice(number.grid)?;
    for other in [Some(radius), variance].into_iter().flatten() {
        check_lattice(number, other)?;
    }

    let mut leaves: BTreeMap<[i32; 3], DropLeaf> = BTreeMap::new();
    spread(number, NUMBER_RULE, &mut leaves, |drops, value| {
        drops.number_density_m3 = value;
    })?;
    // The other grids say something only where there are drops.
    leaves.retain(|_, leaf| leaf.drops.iter().any(|drops| drops.number_density_m3 > 0.0));
    overlay(radius, RADIUS_RULE, &mut leaves, |drops, value| {
        drops.effective_radius_m = value;
    })?;
    if let Some(variance) = variance {
        let set = |drops: &mut Drops, value| drops.effective_variance = value;
        overlay(variance, VARIANCE_RULE, &mut leaves, set)?;
    }
    for drops in leaves.values_mut().flat_map(|leaf| leaf.drops.iter_mut()) {
        if !drops.exist() {
            *drops = Drops::NONE;
        }
    }
    leaves.retain(|_, leaf| leaf.drops.iter().any(Drops::exist));
    Ok(DropMode::from_parts(
        name.to_owned(),
        voxel_m,
        origin_m,
        leaves.into_values().collect(),
    ))
}

/// A grid and its tree.
#[derive(Clone, Copy)]
pub(crate) struct FloatGrid<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) tree: &'a FloatTree,
}

fn find<'a>(
    file: &'a VdbFile,
    mode: &str,
    quantity: &Quantity,
) -> Result<Option<FloatGrid<'a>>, Error> {
    let name = grid_name(mode, quantity);
    let mut of_name = file.grids.iter().filter(|grid| grid.name == name);
    let Some(grid) = of_name.next() else {
        return Ok(None);
    };
    if of_name.next().is_some() {
        return Err(Error::GridTwice { grid: name });
    }
    let tree = grid.tree.as_float().ok_or_else(|| Error::NotFloat {
        grid: grid.name.clone(),
    })?;
    match grid.metadata.get_str("units") {
        Some(found) if found != quantity.unit => {
            let (grid, found) = (grid.name.clone(), found.to_owned());
            Err(Error::Units {
                grid,
                found,
                expected: quantity.unit,
            })
        }
        Some(_) | None => Ok(Some(FloatGrid { grid, tree })),
    }
}

/// Voxel size and position of node (0, 0, 0).
pub(crate) fn lattice(grid: &Grid) -> Result<(f64, DVec3), Error> {
    let not_cubic = || Error::NotCubic {
        grid: grid.name.clone(),
    };
    let voxel_m = grid.transform.uniform_voxel_size().ok_or_else(not_cubic)?;
    Ok((voxel_m, grid.transform.translation()))
}

/// Whether two grids have their nodes in the same places, as far as the first one has any.
fn check_lattice(reference: FloatGrid, other: FloatGrid) -> Result<(), Error> {
    let (voxel_m, origin_m) = lattice(reference.grid)?;
    let (other_voxel_m, other_origin_m) = lattice(other.grid)?;
    let reach = farthest_index(reference.tree) * (other_voxel_m - voxel_m).abs();
    let shift = (other_origin_m - origin_m).abs().max_element();
    if reach + shift <= LATTICE_TOLERANCE * voxel_m {
        return Ok(());
    }
    let (grid, reference) = (other.grid.name.clone(), reference.grid.name.clone());
    Err(Error::TransformMismatch { grid, reference })
}

/// The largest coordinate of a leaf or tile, away from 0.
fn farthest_index(tree: &FloatTree) -> f64 {
    let leaves = tree.leaves().iter().map(|leaf| (leaf.origin, LEAF_DIM));
    let tiles = tree
        .tiles()
        .iter()
        .map(|tile| (tile.origin, tile.level.dim()));
    let far = leaves.chain(tiles).flat_map(|(origin, dim)| {
        origin.map(|axis| {
            f64::from(axis)
                .abs()
                .max((f64::from(axis) + f64::from(dim)).abs())
        })
    });
    far.fold(0.0, f64::max)
}

/// Make leaves from a grid: one for each of its leaves, and as many as its tiles cover.
pub(crate) fn spread(
    grid: FloatGrid,
    rule: Rule,
    leaves: &mut BTreeMap<[i32; 3], DropLeaf>,
    set: impl Fn(&mut Drops, f32),
) -> Result<(), Error> {
    check_background(grid)?;
    check_range(grid)?;
    for leaf in grid.tree.leaves() {
        let target = leaves
            .entry(leaf.origin)
            .or_insert_with(|| DropLeaf::empty(leaf.origin));
        for (index, value) in leaf.active() {
            check(grid, rule, leaf.voxel(index), value)?;
            set(&mut target.drops[index], value);
        }
    }
    let filled = || {
        grid.tree
            .tiles()
            .iter()
            .filter(|tile| tile.active && tile.value != 0.0)
    };
    let n_nodes: f64 = filled()
        .map(|tile| f64::from(tile.level.dim()).powi(3))
        .sum();
    if n_nodes + (leaves.len() * LEAF_NODES) as f64 > node_limit() as f64 {
        return Err(Error::too_many_nodes(n_nodes));
    }
    for tile in filled() {
        check(grid, rule, tile.origin, tile.value)?;
        let n = tile.level.dim() / LEAF_DIM;
        for index in 0..n * n * n {
            let step = [index / (n * n), index / n % n, index % n];
            let origin = std::array::from_fn(|axis| tile.origin[axis] + step[axis] * LEAF_DIM);
            let leaf = leaves
                .entry(origin)
                .or_insert_with(|| DropLeaf::empty(origin));
            leaf.drops
                .iter_mut()
                .for_each(|drops| set(drops, tile.value));
        }
    }
    Ok(())
}

/// Check all values of a grid, and put those over leaves that exist into them. Where the grid has
/// no voxel its background counts, so that one radius everywhere needs no voxels.
fn overlay(
    grid: FloatGrid,
    rule: Rule,
    leaves: &mut BTreeMap<[i32; 3], DropLeaf>,
    set: impl Fn(&mut Drops, f32),
) -> Result<(), Error> {
    check_range(grid)?;
    let background = grid.tree.background;
    check(grid, rule, [0; 3], background)?;
    leaves
        .values_mut()
        .flat_map(|leaf| leaf.drops.iter_mut())
        .for_each(|drops| set(drops, background));
    for leaf in grid.tree.leaves() {
        let mut target = leaves.get_mut(&leaf.origin);
        for (index, value) in leaf.active() {
            check(grid, rule, leaf.voxel(index), value)?;
            if let Some(target) = &mut target {
                set(&mut target.drops[index], value);
            }
        }
    }
    for tile in grid.tree.tiles().iter().filter(|tile| tile.active) {
        check(grid, rule, tile.origin, tile.value)?;
        let last = tile
            .origin
            .map(|axis| axis.saturating_add(tile.level.dim() - LEAF_DIM));
        let along_x = leaves.range_mut(tile.origin..=last).map(|(_, leaf)| leaf);
        let covered = along_x.filter(|leaf| {
            (0..3).all(|axis| (tile.origin[axis]..=last[axis]).contains(&leaf.origin[axis]))
        });
        covered
            .flat_map(|leaf| leaf.drops.iter_mut())
            .for_each(|drops| set(drops, tile.value));
    }
    Ok(())
}

fn check(grid: FloatGrid, rule: Rule, voxel: [i32; 3], value: f32) -> Result<(), Error> {
    if (rule.is_sound)(value) {
        return Ok(());
    }
    let grid = grid.grid.name.clone();
    Err(Error::BadVoxel {
        grid,
        voxel,
        value,
        expected: rule.expected,
    })
}

/// A number density as background would fill all of space.
fn check_background(grid: FloatGrid) -> Result<(), Error> {
    let value = grid.tree.background;
    // Against the stored value.
    if value == 0.0 {
        return Ok(());
    }
    Err(Error::Background {
        grid: grid.grid.name.clone(),
        value,
    })
}

fn check_range(grid: FloatGrid) -> Result<(), Error> {
    if farthest_index(grid.tree) <= f64::from(FARTHEST_INDEX) {
        return Ok(());
    }
    Err(Error::TooFar {
        grid: grid.grid.name.clone(),
        farthest: FARTHEST_INDEX,
    })
}

#[cfg(test)]
#[path = "vdb_tests.rs"]
mod tests;
