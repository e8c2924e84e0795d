//! What a VDB file holds.

use std::fmt::Write as _;

use niji_dropfield::DropVolume;
use niji_vdb::Grid;
use niji_vdb::MetaValue;
use niji_vdb::Tree;
use niji_vdb::VdbFile;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use super::Report;
use super::assertion::Ranges;

/// Characters of a metadata value that are shown to people.
const MOST_CHARACTERS: usize = 76;

pub(super) fn report(file: &VdbFile) -> Report {
    let mut text = String::new();
    let mut ranges = Ranges::new();
    let mut grids = Vec::new();
    for grid in &file.grids {
        let range = range(grid);
        if let Some(range) = range {
            ranges.insert(grid.name.clone(), range);
        }
        describe(grid, range, &mut text);
        grids.push(grid_json(grid, range));
    }
    describe_metadata(&file.metadata, &mut text);
    let mut json = json!({ "grids": grids, "metadata": metadata_json(&file.metadata) });
    // Files of other tools hold no drops of ours, which is no fault here.
    if let Ok(volume) = DropVolume::from_vdb(file) {
        let summary = volume.summary();
        let [tau_x, tau_y, tau_z] = summary.optical_depth_q1;
        let _ = writeln!(
            text,
            "drops  liquid water {:.4e} g in all, {:.3e} g/m3 mean; optical depth (Q = 2) across \
             x, y, z {:.3}, {:.3}, {:.3}",
            summary.total_water_g,
            summary.mean_liquid_water_g_m3,
            2.0 * tau_x,
            2.0 * tau_y,
            2.0 * tau_z
        );
        for warning in &summary.warnings {
            let _ = writeln!(text, "warning  {warning}");
        }
        json["drops"] = json!({
            "total_water_g": summary.total_water_g,
            "mean_liquid_water_g_m3": summary.mean_liquid_water_g_m3,
            "max_liquid_water_g_m3": summary.max_liquid_water_g_m3,
            "max_extinction_m1": 2.0 * summary.max_extinction_m1_q1,
            "optical_depth": summary.optical_depth_q1.map(|tau| 2.0 * tau),
            "effective_radius_um": summary.effective_radius_um,
            "effective_variance": summary.effective_variance,
            "warnings": summary.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
    }
    Report { text, json, ranges }
}

/// Smallest, largest and mean active value of a grid of floats; NaN where one is no number, so that no condition
/// on them holds.
fn range(grid: &Grid) -> Option<[f64; 3]> {
    let tree = grid.tree.as_float()?;
    let (mut min, mut max, mut sum, mut n) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0_u64);
    for (_, value) in tree.leaves().iter().flat_map(niji_vdb::Leaf::active) {
        let value = f64::from(value);
        (min, max, sum, n) = (min.min(value), max.max(value), sum + value, n + 1);
    }
    if sum.is_nan() {
        return Some([f64::NAN; 3]);
    }
    (n > 0).then(|| [min, max, sum / n as f64])
}

fn kind(grid: &Grid) -> &'static str {
    match grid.tree {
        Tree::Float(_) => "float",
        Tree::Double(_) => "double",
        Tree::Vec3s(_) => "vec3s",
        Tree::Int32(_) => "int32",
        Tree::Bool(_) => "bool",
        _ => "other",
    }
}

fn describe(grid: &Grid, range: Option<[f64; 3]>, text: &mut String) {
    let voxel_m = grid.transform.voxel_size();
    let _ = write!(
        text,
        "{}  {}, {}, {} active voxels of {} x {} x {} m",
        grid.name,
        kind(grid),
        grid.class,
        active_voxels(grid),
        voxel_m.x,
        voxel_m.y,
        voxel_m.z
    );
    if let Some([min, max, mean]) = range {
        let _ = if mean.is_nan() {
            write!(text, "; some values are no numbers (NaN)")
        } else {
            write!(text, "; {min:.6e} .. {max:.6e}, mean {mean:.6e}")
        };
    }
    text.push('\n');
    describe_metadata(&grid.metadata, text);
}

fn active_voxels(grid: &Grid) -> u64 {
    match &grid.tree {
        Tree::Float(tree) => tree.active_voxel_count(),
        Tree::Double(tree) => tree.active_voxel_count(),
        Tree::Vec3s(tree) => tree.active_voxel_count(),
        Tree::Int32(tree) => tree.active_voxel_count(),
        Tree::Bool(tree) => tree.active_voxel_count(),
        _ => 0,
    }
}

fn describe_metadata(metadata: &niji_vdb::Metadata, text: &mut String) {
    for (name, value) in metadata.iter() {
        let value = value_json(value).to_string();
        let shown: String = value.chars().take(MOST_CHARACTERS).collect();
        let rest = if shown.len() < value.len() {
            " …"
        } else {
            ""
        };
        let _ = writeln!(text, "  {name} = {shown}{rest}");
    }
}

fn metadata_json(metadata: &niji_vdb::Metadata) -> Map<String, Value> {
    metadata
        .iter()
        .map(|(name, value)| (name.to_owned(), value_json(value)))
        .collect()
}

fn value_json(value: &MetaValue) -> Value {
    match value {
        MetaValue::Bool(value) => json!(value),
        MetaValue::Int32(value) => json!(value),
        MetaValue::Int64(value) => json!(value),
        MetaValue::Float(value) => json!(value),
        MetaValue::Double(value) => json!(value),
        MetaValue::String(value) => json!(value),
        MetaValue::Vec3i(value) => json!(value),
        MetaValue::Vec3s(value) => json!(value),
        MetaValue::Vec3d(value) => json!(value),
        other => json!(format!("{other:?}")),
    }
}

fn grid_json(grid: &Grid, range: Option<[f64; 3]>) -> Value {
    let voxel_m = grid.transform.voxel_size().to_array();
    let origin_m = grid.transform.translation().to_array();
    let mut json = json!({
        "name": grid.name,
        "type": kind(grid),
        "class": grid.class,
        "active_voxels": active_voxels(grid),
        "voxel_m": voxel_m,
        "origin_m": origin_m,
        "metadata": metadata_json(&grid.metadata),
    });
    if let Some([min, max, mean]) = range {
        json["min"] = json!(min);
        json["max"] = json!(max);
        json["mean"] = json!(mean);
    }
    json
}
