//! Claims about drop volumes in VDB files.
#![allow(clippy::float_cmp, reason = "values that must come back bit for bit")]

use glam::DMat3;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::Leaf;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::Transform;
use niji_vdb::Tree;

use super::*;
use crate::test_volumes::grid;
use crate::test_volumes::sparse;
use crate::test_volumes::varied;

fn rain() -> DropVolume {
    DropVolume {
        modes: vec![DropMode::from_fn("", &grid(), varied).unwrap()],
    }
}

fn named(name: &str, mode: DropMode) -> DropMode {
    let mut mode = mode;
    name.clone_into(&mut mode.name);
    mode
}

fn rain_and_mist() -> DropVolume {
    let mist = DropMode::from_fn("mist", &grid(), |_| Drops {
        number_density_m3: 1e8,
        effective_radius_m: 1e-5,
        effective_variance: 0.0,
    });
    DropVolume {
        modes: vec![named("rain", sparse()), mist.unwrap()],
    }
}

/// Through the bytes of a file.
fn through_a_file(volume: &DropVolume, compression: Compression) -> DropVolume {
    let file = volume
        .to_vdb(&[("niji:tool".into(), "test".into())])
        .unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    file.write(&mut bytes, compression).unwrap();
    let again = VdbFile::parse(bytes.get_ref()).unwrap();
    assert_eq!(again.metadata.get_str("niji:tool"), Some("test"));
    DropVolume::from_vdb(&again).unwrap()
}

#[test]
fn a_volume_comes_back_from_its_file() {
    for volume in [rain(), rain_and_mist()] {
        for compression in [Compression::None, Compression::Zip] {
            assert_eq!(through_a_file(&volume, compression), volume);
        }
    }
}

#[test]
fn grids_have_the_names_and_units_of_the_layout() {
    let file = rain_and_mist().to_vdb(&[]).unwrap();
    let names: Vec<_> = file.grids.iter().map(|grid| grid.name.as_str()).collect();
    // Mist has no variance, and the lattices differ: no common display grid.
    let expected = [
        "rain_number_density",
        "rain_effective_radius",
        "rain_effective_variance",
        "mist_number_density",
        "mist_effective_radius",
        "rain_density",
        "mist_density",
    ];
    assert_eq!(names, expected);
    assert!(file.grids.iter().all(|grid| grid.class == FOG_VOLUME));
    let units = |name: &str| {
        file.grid(name)
            .unwrap()
            .metadata
            .get_str("units")
            .unwrap()
            .to_owned()
    };
    assert_eq!(units("rain_number_density"), "1/m^3");
    assert_eq!(units("mist_effective_radius"), "m");
    assert_eq!(file.metadata.get(VERSION_ITEM), Some(&MetaValue::Int32(1)));
}

#[test]
fn voxels_sit_where_the_nodes_are() {
    let volume = rain();
    let file = volume.to_vdb(&[]).unwrap();
    let transform = file.grid("number_density").unwrap().transform;
    for node in [[0, 0, 0], [18, 9, 7]] {
        let world = transform.index_to_world(DVec3::from(node.map(f64::from)));
        assert!(world.distance(volume.modes[0].node_position(node)) < 1e-12);
    }
}

#[test]
fn display_density_is_the_sum_of_extinctions_at_q_2() {
    let one = rain().modes.remove(0);
    let two = DropVolume {
        modes: vec![named("a", one.clone()), named("b", one.clone())],
    };
    let file = two.to_vdb(&[]).unwrap();
    let density = file.grid("density").unwrap().tree.as_float().unwrap();
    let drops = one.drops([3, 4, 5]);
    let sigma = crate::AreaMoments::from_drops(&drops).extinction_m1_q1();
    assert!((f64::from(density.get([3, 4, 5])) / (4.0 * sigma) - 1.0).abs() < 1e-6);
}

#[test]
fn mode_names_that_collide_are_refused() {
    let one = rain().modes.remove(0);
    let twice = DropVolume {
        modes: vec![one.clone(), one.clone()],
    };
    assert!(matches!(twice.to_vdb(&[]), Err(Error::BadModeName { .. })));
    for name in ["rain_", "two words", "number", "a_number"] {
        let volume = DropVolume {
            modes: vec![named(name, one.clone())],
        };
        assert!(matches!(volume.to_vdb(&[]), Err(Error::BadModeName { .. })));
    }
}

/// The error of a rain volume whose file was changed.
fn error_after(change: impl Fn(&mut VdbFile)) -> Error {
    let mut file = rain().to_vdb(&[]).unwrap();
    change(&mut file);
    DropVolume::from_vdb(&file).unwrap_err()
}

fn set_voxel(file: &mut VdbFile, name: &str, voxel: [i32; 3], value: f32) {
    let grid = file
        .grids
        .iter_mut()
        .find(|grid| grid.name == name)
        .unwrap();
    let tree = grid.tree.as_float().unwrap();
    let mut leaves = tree.leaves().to_vec();
    let home = voxel.map(|axis| axis & !7);
    leaves
        .iter_mut()
        .find(|leaf| leaf.origin == home)
        .unwrap()
        .set(voxel, value);
    grid.tree = FloatTree::from_leaves(tree.background, leaves)
        .unwrap()
        .into();
}

#[test]
fn impossible_voxels_are_named_with_their_grid() {
    let cases = [
        ("number_density", -1.0),
        ("number_density", f32::NAN),
        ("number_density", f32::INFINITY),
        ("effective_radius", -1e-4),
        ("effective_radius", f32::NAN),
        ("effective_radius", 100.0),
        ("effective_variance", 0.5),
        ("effective_variance", f32::NAN),
    ];
    for (name, bad) in cases {
        let error = error_after(|file| set_voxel(file, name, [9, 3, 5], bad));
        let text = error.to_string();
        assert!(text.contains(name) && text.contains("[9, 3, 5]"), "{text}");
    }
}

#[test]
fn missing_grids_are_named_beside_those_that_are_there() {
    let error = error_after(|file| file.grids.retain(|grid| grid.name != "effective_radius"));
    assert!(
        error.to_string().contains("`effective_radius` is missing"),
        "{error}"
    );
    assert!(error.to_string().contains("number_density"), "{error}");
    let error = error_after(|file| file.grids.retain(|grid| grid.name == "density"));
    assert!(
        error.to_string().contains("`number_density` is missing"),
        "{error}"
    );
    let error = DropVolume::from_vdb(&VdbFile::default()).unwrap_err();
    assert!(matches!(error, Error::MissingGrid { .. }));
}

#[test]
fn two_grids_of_one_name_are_refused() {
    // The first of a name stood for both modes, so that its drops were there twice and the others not at all.
    for name in ["number_density", "effective_radius", "effective_variance"] {
        let error = error_after(|file| file.grids.push(file.grid(name).unwrap().clone()));
        assert!(
            error
                .to_string()
                .starts_with(&format!("grid `{name}` is there twice, expected once")),
            "{error}"
        );
    }
    // Those for display are not read.
    let mut file = rain().to_vdb(&[]).unwrap();
    file.grids.push(file.grid("density").unwrap().clone());
    assert_eq!(DropVolume::from_vdb(&file).unwrap(), rain());
}

#[test]
fn a_missing_variance_is_a_single_size() {
    let mut file = rain().to_vdb(&[]).unwrap();
    file.grids.retain(|grid| grid.name != "effective_variance");
    let volume = DropVolume::from_vdb(&file).unwrap();
    assert!(
        volume.modes[0]
            .nodes()
            .all(|(_, drops)| drops.effective_variance == 0.0)
    );
}

#[test]
fn lattices_that_do_not_fit_are_refused() {
    let shift = Transform::uniform_scale_translate(2.0, DVec3::ZERO);
    let error = error_after(|file| file.grids[1].transform = shift);
    assert!(matches!(error, Error::TransformMismatch { .. }), "{error}");
    let flat = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 1.0));
    let flat = Transform::affine(flat, DVec3::ZERO).unwrap();
    let error = error_after(|file| file.grids.iter_mut().for_each(|grid| grid.transform = flat));
    assert!(matches!(error, Error::NotCubic { .. }), "{error}");
}

#[test]
fn grids_for_display_are_not_read() {
    for volume in [rain(), rain_and_mist()] {
        let mut file = volume.to_vdb(&[]).unwrap();
        let (read, unread): (Vec<_>, Vec<_>) = file
            .grids
            .drain(..)
            .partition(|grid| DropVolume::reads_grid(&grid.name));
        assert!(!unread.is_empty());
        for grid in &unread {
            let quantity = grid.name.rsplit('_').next();
            assert_eq!(quantity, Some("density"), "{}", grid.name);
            assert!(!grid.name.ends_with("number_density"), "{}", grid.name);
        }
        file.grids = read;
        assert_eq!(DropVolume::from_vdb(&file).unwrap(), volume);
    }
}

#[test]
fn roundoff_between_lattices_is_accepted() {
    let mut file = rain().to_vdb(&[]).unwrap();
    let nearly = file.grids[1].transform.translation() + 1e-12;
    file.grids[1].transform = Transform::uniform_scale_translate(2.0 + 1e-14, nearly);
    assert_eq!(DropVolume::from_vdb(&file).unwrap(), rain());
}

#[test]
fn other_units_types_and_versions_are_refused() {
    let error = error_after(|file| file.grids[1].metadata.insert("units", "mm"));
    assert!(matches!(error, Error::Units { .. }), "{error}");
    let doubles = niji_vdb::SparseTree::<f64>::new(0.0);
    let error = error_after(|file| file.grids[0].tree = Tree::Double(doubles.clone()));
    assert!(matches!(error, Error::NotFloat { .. }), "{error}");
    let error = error_after(|file| file.metadata.insert(VERSION_ITEM, 2));
    assert!(
        matches!(
            error,
            Error::FormatVersion {
                found: 2,
                newest: 1
            }
        ),
        "{error}"
    );
}

/// Grids as another program might write them: no metadata, tiles, one radius as a background.
fn foreign(number: FloatTree, radius_m: f32) -> VdbFile {
    let transform = Transform::uniform_scale_translate(0.5, DVec3::ZERO);
    let radius = FloatTree::new(radius_m);
    VdbFile::new(vec![
        Grid::new("spray_number_density", FOG_VOLUME, transform, number),
        Grid::new("spray_effective_radius", FOG_VOLUME, transform, radius),
    ])
}

fn tile(origin: [i32; 3], level: TileLevel, value: f32) -> Tile {
    Tile {
        origin,
        level,
        active: true,
        value,
    }
}

#[test]
fn tiles_are_filled_out_and_backgrounds_count() {
    let mut leaf = Leaf::new([-8, 0, 0], 0.0);
    leaf.set([-1, 2, 3], 7.0);
    let tiles = vec![
        tile([0; 3], TileLevel::Leaf, 5.0),
        tile([128, 0, 0], TileLevel::Lower, 9.0),
    ];
    let number = FloatTree::from_parts(0.0, vec![leaf], tiles).unwrap();
    let volume = DropVolume::from_vdb(&foreign(number, 1e-4)).unwrap();
    let mode = &volume.modes[0];
    assert_eq!(mode.name, "spray");
    assert_eq!(mode.nodes().count(), 1 + 512 + 128 * 128 * 128);
    assert!(
        mode.nodes()
            .all(|(_, drops)| drops.effective_radius_m == 1e-4)
    );
    let numbers = [[-1, 2, 3], [7, 7, 7], [255, 127, 0]].map(|node| mode.drops(node));
    assert_eq!(
        numbers.map(|drops| drops.number_density_m3),
        [7.0, 5.0, 9.0]
    );
}

#[test]
fn voxels_without_number_or_size_are_no_drops() {
    let mut file = rain().to_vdb(&[]).unwrap();
    set_voxel(&mut file, "number_density", [1, 1, 1], 0.0);
    set_voxel(&mut file, "effective_radius", [2, 2, 2], 0.0);
    let volume = DropVolume::from_vdb(&file).unwrap();
    assert_eq!(volume.modes[0].drops([1, 1, 1]), Drops::NONE);
    assert_eq!(volume.modes[0].drops([2, 2, 2]), Drops::NONE);
    assert_eq!(volume.modes[0].nodes().count(), 19 * 10 * 8 - 2);
}
