//! What OpenVDB must find in a VDB file of ours, for `check_vdb.py`, and files to try it with.

use glam::DMat3;
use glam::DVec3;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::MetaValue;
use niji_vdb::Metadata;
use niji_vdb::SparseTree;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::Transform;
use niji_vdb::Tree;
use niji_vdb::Value;
use niji_vdb::VdbFile;
use serde_json::json;

/// Every voxel of every leaf, a voxel of every tile, the transforms and the metadata.
///
/// # Panics
/// If a grid is neither float, vec3s nor bool: OpenVDB's Python module knows no others.
pub fn expected(file: &VdbFile) -> serde_json::Value {
    let grids = file.grids.iter().map(|grid| match &grid.tree {
        Tree::Float(tree) => expected_grid(grid, tree, "float", |value| json!(value)),
        Tree::Vec3s(tree) => expected_grid(grid, tree, "vec3s", |value| json!(value)),
        Tree::Bool(tree) => expected_grid(grid, tree, "bool", |value| json!(value)),
        other => panic!("OpenVDB's Python module reads no {other:?}"),
    });
    let grids = grids.collect::<Vec<_>>();
    json!({ "items": expected_items(&file.metadata), "grids": grids })
}

fn expected_grid<T: Value>(
    grid: &Grid,
    tree: &SparseTree<T>,
    kind: &str,
    value: impl Fn(T) -> serde_json::Value,
) -> serde_json::Value {
    let mut voxels = Vec::new();
    for leaf in tree.leaves() {
        for index in 0..LEAF_VOXELS {
            let [x, y, z] = leaf.voxel(index);
            voxels.push(json!([
                x,
                y,
                z,
                leaf.is_active(index),
                value(leaf.values[index])
            ]));
        }
    }
    for tile in tree.tiles() {
        let [x, y, z] = tile.origin.map(|axis| axis + tile.level.dim() - 1);
        voxels.push(json!([x, y, z, tile.active, value(tile.value)]));
    }
    let index = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::new(-3.5, 100.0, 1e4),
    ];
    let world = index.map(|index| {
        let world = grid.transform.index_to_world(index);
        json!([index.to_array(), world.to_array()])
    });
    json!({
        "name": grid.name,
        "class": grid.class,
        "type": kind,
        "background": value(tree.background),
        "n_active": tree.active_voxel_count(),
        "bounds": tree.active_bounds(),
        "items": expected_items(&grid.metadata),
        "world": world,
        "voxels": voxels,
    })
}

fn expected_items(items: &Metadata) -> serde_json::Value {
    let items = items.iter().map(|(name, value)| {
        let value = match value {
            MetaValue::Bool(value) => json!(value),
            MetaValue::Int32(value) => json!(value),
            MetaValue::Int64(value) => json!(value),
            MetaValue::Float(value) => json!(value),
            MetaValue::Double(value) => json!(value),
            MetaValue::String(value) => json!(value),
            MetaValue::Vec3i(value) => json!(value),
            MetaValue::Vec3s(value) => json!(value),
            MetaValue::Vec3d(value) => json!(value),
            other => panic!("an item of another type: {other:?}"),
        };
        (name.to_owned(), value)
    });
    items.collect()
}

/// Files of every kind that we write, with their names.
pub fn samples() -> Vec<(&'static str, VdbFile)> {
    let density = Grid::new("density", FOG_VOLUME, uniform(), cloud(0.0));
    let radius = Grid::new("radius", FOG_VOLUME, uniform(), cloud(0.0));
    let twin = Grid::new(
        "radius",
        "unknown",
        Transform::affine_scale(),
        inactive_values(),
    );
    let mut described = VdbFile::new(vec![density, radius, twin]);
    describe(&mut described.metadata);
    describe(&mut described.grids[0].metadata);
    let others = vec![
        Grid::new("direction", "unknown", sheared(), vectors()),
        Grid::new("inside", "unknown", uniform(), bits()),
        Grid::new("nothing", FOG_VOLUME, uniform(), FloatTree::new(2.5)),
        Grid::new(
            "tiles",
            "unknown",
            Transform::uniform_scale_translate(2.0, DVec3::ZERO),
            tiles(),
        ),
    ];
    vec![("described", described), ("others", VdbFile::new(others))]
}

trait AffineScale {
    fn affine_scale() -> Self;
}

impl AffineScale for Transform {
    fn affine_scale() -> Self {
        let scale = DMat3::from_diagonal(DVec3::new(0.5, 0.1, -3.0));
        Self::affine(scale, DVec3::new(1.0, 2.0, 0.1)).expect("an invertible map")
    }
}

fn uniform() -> Transform {
    Transform::uniform_scale_translate(0.1, DVec3::new(-20.5, 0.05, 1e4))
}

fn sheared() -> Transform {
    let linear = DMat3::from_cols_array(&[2.0, 0.5, 0.0, 0.1, 3.0, 0.2, -0.3, 0.0, 1.5]);
    Transform::affine(linear, DVec3::new(10.0, -20.0, 30.0)).expect("an invertible map")
}

fn describe(items: &mut Metadata) {
    items.insert("a_bool", true);
    items.insert("a_double", 0.1);
    items.insert("a_float", 0.1_f32);
    items.insert("a_string", "units m⁻³, two words");
    items.insert("a_vec3d", [1.0, 0.1, -1e300]);
    items.insert("a_vec3i", [1, -2, i32::MAX]);
    items.insert("a_vec3s", [1.0_f32, 0.1, -3.0]);
    items.insert("an_int32", -7);
    items.insert("an_int64", 1_i64 << 40);
}

/// Leaves around the origin, and so under eight root entries, full and sparse.
fn cloud(background: f32) -> FloatTree {
    let origins = [
        [0; 3],
        [-8, 0, 0],
        [0, -8, 16],
        [-4096, 4088, -8],
        [80, 8, -8],
    ];
    let leaf = |(place, origin): (usize, [i32; 3])| {
        let mut leaf = Leaf::new(origin, background);
        for index in (0..LEAF_VOXELS).filter(|index| place == 0 || index * index % 7 == place) {
            leaf.set(
                leaf.voxel(index),
                (index as f32 + 0.1) * 1e-3f32.powi(place as i32),
            );
        }
        leaf
    };
    let leaves = origins.into_iter().enumerate().map(leaf).collect();
    FloatTree::from_leaves(background, leaves).expect("leaves apart")
}

/// Inactive voxels with none to three values of their own: each way to store them.
fn inactive_values() -> FloatTree {
    let background = 3.0;
    let choices: [&[f32]; 7] = [
        &[3.0],
        &[-3.0],
        &[7.5],
        &[-3.0, 3.0],
        &[7.5, 3.0],
        &[7.5, 9.25],
        &[7.5, 9.25, 3.0],
    ];
    let leaf = |(place, choice): (usize, &[f32])| {
        let mut leaf = Leaf::new([8 * place as i32, 64, -8], background);
        for index in 0..LEAF_VOXELS {
            leaf.values[index] = choice[index * index / 5 % choice.len()];
        }
        for index in (0..LEAF_VOXELS).filter(|index| index % 3 == 0) {
            leaf.set(leaf.voxel(index), index as f32);
        }
        leaf
    };
    let leaves = choices.into_iter().enumerate().map(leaf).collect();
    FloatTree::from_leaves(background, leaves).expect("leaves apart")
}

fn vectors() -> SparseTree<[f32; 3]> {
    let mut leaf = Leaf::new([8, 8, 8], [0.0; 3]);
    leaf.set([9, 10, 11], [0.1, -0.2, 1e-30]);
    SparseTree::from_leaves([0.0; 3], vec![leaf]).expect("one leaf")
}

fn bits() -> SparseTree<bool> {
    let mut leaf = Leaf::new([-8, 0, 8], false);
    for index in (0..LEAF_VOXELS).step_by(3) {
        leaf.set(leaf.voxel(index), index % 2 == 0);
    }
    let tile = Tile {
        origin: [0, 128, 0],
        level: TileLevel::Leaf,
        active: true,
        value: true,
    };
    SparseTree::from_parts(false, vec![leaf], vec![tile]).expect("apart")
}

fn tiles() -> FloatTree {
    let tile = |origin, level, active, value| Tile {
        origin,
        level,
        active,
        value,
    };
    let tiles = vec![
        tile([8, 0, 0], TileLevel::Leaf, true, 1.5),
        tile([16, 0, 0], TileLevel::Leaf, false, 2.5),
        tile([128, 0, 0], TileLevel::Lower, true, 3.5),
        tile([-4096, 0, 4096], TileLevel::Upper, true, 4.5),
        tile([8192, 0, 4096], TileLevel::Upper, false, 5.5),
    ];
    let leaf = Leaf::new([0; 3], 1.0);
    FloatTree::from_parts(1.0, vec![leaf], tiles).expect("apart")
}
