//! What is written is read again, whatever it is; the same content gives the same bytes.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use common::bytes;
use common::small_file;
use common::small_tree;
use common::transform;
use glam::DMat3;
use glam::DVec3;
use half::f16;
use niji_vdb::Compression;
use niji_vdb::Error;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::MetaValue;
use niji_vdb::SparseTree;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::Transform;
use niji_vdb::Tree;
use niji_vdb::Value;
use niji_vdb::VdbFile;

const BOTH: [Compression; 2] = [Compression::None, Compression::Zip];

fn again(file: &VdbFile, compression: Compression) -> VdbFile {
    VdbFile::parse(&bytes(file, compression)).unwrap()
}

fn tile<T>(origin: [i32; 3], level: TileLevel, active: bool, value: T) -> Tile<T> {
    Tile {
        origin,
        level,
        active,
        value,
    }
}

/// Leaves whose inactive voxels need each of the codes 0 to 6, and tiles of every size.
fn varied_tree<T: Value>(background: T, minus: T, others: [T; 3]) -> SparseTree<T> {
    let [a, b, c] = others;
    let choices: [&[T]; 8] = [
        &[background],
        &[minus],
        &[a],
        &[minus, background],
        &[background, a],
        &[a, b],
        &[a, b, c],
        &[background, minus],
    ];
    let leaf = |(place, choice): (usize, &[T])| {
        let place = place as i32;
        let mut leaf = Leaf::new(
            [8 * (place - 4), -8 * place, 4096 * (place % 3)],
            background,
        );
        for index in 0..LEAF_VOXELS {
            leaf.values[index] = choice[index * index / 5 % choice.len()];
        }
        for index in (0..LEAF_VOXELS).filter(|index| index % 3 == 0) {
            leaf.set(leaf.voxel(index), others[index % 2]);
        }
        leaf
    };
    let leaves = choices.into_iter().enumerate().map(leaf).collect();
    let tiles = vec![
        tile([8, 1024, 16], TileLevel::Leaf, true, a),
        tile([16, 1024, 16], TileLevel::Leaf, false, b),
        tile([-128, 2048, 0], TileLevel::Lower, true, background),
        tile([-256, 2048, 0], TileLevel::Lower, false, minus),
        tile([8192, -8192, 4096], TileLevel::Upper, true, a),
        tile([-8192, -8192, 4096], TileLevel::Upper, false, c),
    ];
    SparseTree::from_parts(background, leaves, tiles).unwrap()
}

fn half(value: f32) -> f16 {
    f16::from_f32(value)
}

#[test]
fn only_grids_of_halves_need_the_newest_version() {
    let mut file = small_file();
    let version = |file: &VdbFile| bytes(file, Compression::None)[8..20].to_vec();
    let words = |words: [u32; 3]| words.map(u32::to_le_bytes).concat();
    assert_eq!(version(&file), words([224, 10, 0]));
    let tree = SparseTree::new(half(1.5));
    file.grids
        .push(Grid::new("short", FOG_VOLUME, transform(), tree));
    assert_eq!(version(&file), words([225, 13, 0]));
}

#[test]
fn every_type_with_every_kind_of_inactive_value_and_tile_comes_back() {
    let trees: [Tree; 6] = [
        varied_tree(3.0_f32, -3.0, [7.5, f32::MIN_POSITIVE / 2.0, f32::INFINITY]).into(),
        varied_tree(3.0_f64, -3.0, [7.5, 1e300, 0.1]).into(),
        varied_tree(
            half(3.0),
            half(-3.0),
            [half(7.5), f16::MIN_POSITIVE, f16::INFINITY],
        )
        .into(),
        varied_tree(
            [0.5_f32; 3],
            [-0.5; 3],
            [[1.0, 2.0, 3.0], [0.1; 3], [-0.0; 3]],
        )
        .into(),
        varied_tree(5_i32, -5, [7, i32::MIN, i32::MAX]).into(),
        varied_tree(false, true, [true; 3]).into(),
    ];
    let grids = trees.map(|tree| Grid::new("varied", "unknown", transform(), tree));
    let file = VdbFile::new(grids.to_vec());
    for compression in BOTH {
        let read = again(&file, compression);
        for (grid, expected) in read.grids.iter().zip(&file.grids) {
            assert!(
                grid.tree == expected.tree,
                "{compression:?}, {:?}",
                std::mem::discriminant(&grid.tree)
            );
        }
    }
}

#[test]
fn nan_and_minus_zero_keep_their_bits() {
    let nan = f32::from_bits(0x7fc1_2345);
    let mut leaf = Leaf::new([0; 3], 0.0);
    leaf.set([1, 2, 3], nan);
    leaf.values[7] = -0.0;
    let tree = FloatTree::from_leaves(0.0, vec![leaf]).unwrap();
    let file = VdbFile::new(vec![Grid::new("odd", FOG_VOLUME, transform(), tree)]);
    for compression in BOTH {
        let read = again(&file, compression);
        let tree = read.grids[0].tree.as_float().unwrap();
        assert_eq!(tree.get([1, 2, 3]).to_bits(), nan.to_bits());
        assert_eq!(tree.get([0, 0, 7]).to_bits(), (-0.0_f32).to_bits());
        assert_eq!(tree.get([0, 0, 6]).to_bits(), 0);
    }
}

#[test]
fn a_file_is_read_as_it_was_and_written_again_as_it_was() {
    let file = small_file();
    for compression in BOTH {
        let first = bytes(&file, compression);
        assert_eq!(first, bytes(&file, compression));
        let read = VdbFile::parse(&first).unwrap();
        assert_eq!(read.grids[0].tree, file.grids[0].tree);
        assert_eq!(read.grids[0].transform, file.grids[0].transform);
        assert_eq!(read.metadata, file.metadata);
        assert_eq!(bytes(&read, compression), first);
    }
}

#[test]
fn the_uuid_follows_from_the_content() {
    let uuid = |file: &VdbFile| String::from_utf8(bytes(file, Compression::None)[21..57].to_vec());
    let file = small_file();
    let first = uuid(&file).unwrap();
    let groups = first.split('-').map(str::len).collect::<Vec<_>>();
    assert_eq!(groups, [8, 4, 4, 4, 12]);
    assert_eq!(&first[14..15], "8");
    let mut other = small_file();
    let mut leaves = small_tree().into_leaves();
    leaves[0].set([8, 16, 24], 1.5);
    other.grids[0].tree = FloatTree::from_leaves(0.0, leaves).unwrap().into();
    assert_ne!(uuid(&other).unwrap(), first);
}

#[test]
fn metadata_of_every_type_comes_back() {
    let mut file = small_file();
    let unknown = MetaValue::Unknown {
        type_name: "vec2i".to_owned(),
        bytes: vec![1; 8],
    };
    let values: [MetaValue; 10] = [
        true.into(),
        (-7).into(),
        (1_i64 << 40).into(),
        0.1_f32.into(),
        0.1.into(),
        "units m⁻³".into(),
        [1, -2, i32::MAX].into(),
        [1.0_f32, 0.1, -3.0].into(),
        [1.0, 0.1, -1e300].into(),
        unknown,
    ];
    for (index, value) in values.into_iter().enumerate() {
        file.metadata.insert(format!("item {index}"), value.clone());
        file.grids[0]
            .metadata
            .insert(format!("item {index}"), value);
    }
    let read = again(&file, Compression::None);
    assert_eq!(read.metadata, file.metadata);
    for (name, value) in file.grids[0].metadata.iter() {
        assert_eq!(read.grids[0].metadata.get(name), Some(value));
    }
}

#[test]
fn items_that_follow_from_the_grid_are_written_anew() {
    let mut file = small_file();
    file.grids[0].metadata.insert("file_voxel_count", 1_i64);
    file.grids[0]
        .metadata
        .insert("is_saved_as_half_float", true);
    let read = again(&file, Compression::Zip);
    let items = &read.grids[0].metadata;
    assert_eq!(
        items.get("file_voxel_count"),
        Some(&MetaValue::Int64(512 + 256 + 1))
    );
    assert_eq!(
        items.get("file_bbox_min"),
        Some(&MetaValue::Vec3i([8, 16, 24]))
    );
    assert_eq!(
        items.get("file_bbox_max"),
        Some(&MetaValue::Vec3i([23, 72, 31]))
    );
    assert_eq!(
        items.get_str("file_compression"),
        Some("zip + active values")
    );
    assert_eq!(
        items.get("is_saved_as_half_float"),
        Some(&MetaValue::Bool(false))
    );
    assert_eq!(read.grids[0].class, FOG_VOLUME);
    assert_eq!(read.grids[0].name, "density");
}

#[test]
fn transforms_of_every_kind_come_back_exactly() {
    let linear = DMat3::from_cols_array(&[2.0, 0.5, 0.0, 0.1, 3.0, 0.2, -0.3, 0.0, 1.5]);
    let uneven = DMat3::from_diagonal(DVec3::new(0.1, 0.2, -0.3));
    let transforms = [
        Transform::uniform_scale_translate(0.1, DVec3::ZERO),
        Transform::uniform_scale_translate(0.3, DVec3::new(0.1, -7.0, 1e6)),
        Transform::affine(uneven, DVec3::ZERO).unwrap(),
        Transform::affine(uneven, DVec3::new(0.1, 0.2, 0.3)).unwrap(),
        Transform::affine(linear, DVec3::new(10.0, 20.0, 30.0)).unwrap(),
    ];
    for transform in transforms {
        let file = VdbFile::new(vec![Grid::new("map", FOG_VOLUME, transform, small_tree())]);
        assert_eq!(
            again(&file, Compression::None).grids[0].transform,
            transform
        );
    }
}

#[test]
fn grids_of_one_name_and_of_none_stay_apart() {
    let value = |value: f32| {
        let mut leaf = Leaf::new([0; 3], 0.0);
        leaf.set([0; 3], value);
        FloatTree::from_leaves(0.0, vec![leaf]).unwrap()
    };
    let names = ["twin", "twin", "", "twin", ""];
    let grids = names.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0]);
    let grids = grids.map(|(name, of)| Grid::new(*name, FOG_VOLUME, transform(), value(of)));
    let read = again(&VdbFile::new(grids.collect()), Compression::None);
    let found = read
        .grids
        .iter()
        .map(|grid| grid.tree.as_float().unwrap().get([0; 3]));
    assert_eq!(found.collect::<Vec<_>>(), [1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(
        read.grids
            .iter()
            .map(|grid| grid.name.as_str())
            .collect::<Vec<_>>(),
        names
    );
}

#[test]
fn an_empty_file_and_an_empty_grid_come_back() {
    assert_eq!(
        again(&VdbFile::default(), Compression::None),
        VdbFile::default()
    );
    let file = VdbFile::new(vec![Grid::new(
        "none",
        "",
        transform(),
        FloatTree::new(2.5),
    )]);
    let read = again(&file, Compression::Zip);
    assert_eq!(read.grids[0].tree, Tree::Float(FloatTree::new(2.5)));
    assert_eq!(read.grids[0].tree.as_float().unwrap().active_bounds(), None);
}

#[test]
fn the_corners_of_index_space_can_be_used() {
    let low = Leaf::new([i32::MIN; 3], 0.0);
    let mut high = Leaf::new([i32::MAX - 7; 3], 0.0);
    high.set([i32::MAX; 3], 2.0);
    let tiles = vec![tile([i32::MAX - 4095, 0, 0], TileLevel::Upper, true, 1.0)];
    let tree = FloatTree::from_parts(0.0, vec![high, low], tiles).unwrap();
    let file = VdbFile::new(vec![Grid::new(
        "far",
        FOG_VOLUME,
        transform(),
        tree.clone(),
    )]);
    assert_eq!(
        again(&file, Compression::None).grids[0].tree,
        tree.clone().into()
    );
    assert_eq!(tree.get([i32::MAX; 3]), 2.0);
    assert_eq!(tree.get([i32::MAX, 4095, 0]), 1.0);
    let expected = ([i32::MAX - 4095, 0, 0], [i32::MAX; 3]);
    assert_eq!(tree.active_bounds(), Some(expected));
}

#[test]
fn a_stream_that_does_not_start_at_zero_is_written_from_where_it_stands() {
    let file = small_file();
    let mut output = std::io::Cursor::new(vec![7; 10]);
    output.set_position(10);
    file.write(&mut output, Compression::None).unwrap();
    assert_eq!(output.get_ref()[10..], bytes(&file, Compression::None));
    assert_eq!(output.position(), output.get_ref().len() as u64);
}

#[test]
fn a_file_on_disk_is_read_like_its_bytes() {
    let path = std::env::temp_dir().join(format!("niji-vdb-{}.vdb", std::process::id()));
    let bytes = bytes(&small_file(), Compression::Zip);
    std::fs::write(&path, &bytes).unwrap();
    let read = VdbFile::read(&path);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read.unwrap(), VdbFile::parse(&bytes).unwrap());
    let error = VdbFile::read(&path).unwrap_err();
    assert!(matches!(&error, Error::Open { path: named, .. } if *named == path));
}

#[test]
fn a_ball_that_openvdb_wrote_with_blosc_is_read_exactly() {
    let file = VdbFile::parse(common::BLOSC).unwrap();
    let ball = file
        .grid("ball")
        .and_then(|grid| grid.tree.as_float())
        .unwrap();
    let mut n_active = 0;
    for (x, y, z) in (0..33 * 33 * 33).map(|n| (n / 33 / 33 - 16, n / 33 % 33 - 16, n % 33 - 16)) {
        let voxel = [x + 16, y + 16, z + 16];
        let inside = x * x + y * y + z * z < 100;
        let value = if inside {
            0.25 * ((7 * x + 3 * y + z) & 63) as f32
        } else {
            0.0
        };
        assert_eq!((ball.is_active(voxel), ball.get(voxel)), (inside, value));
        n_active += u64::from(inside);
    }
    assert_eq!(ball.active_voxel_count(), n_active);
}
