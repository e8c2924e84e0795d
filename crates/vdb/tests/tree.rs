//! Trees: what covers a voxel, what may not cover it twice, and counts and bounds.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use common::Random;
use glam::DMat3;
use glam::DVec3;
use niji_vdb::Error;
use niji_vdb::FloatTree;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::Transform;

fn tile(origin: [i32; 3], level: TileLevel, value: f32) -> Tile {
    Tile {
        origin,
        level,
        active: true,
        value,
    }
}

fn tree(leaves: &[[i32; 3]], tiles: Vec<Tile>) -> Result<FloatTree, Error> {
    let leaves = leaves
        .iter()
        .map(|&origin| Leaf::new(origin, 0.0))
        .collect();
    FloatTree::from_parts(0.0, leaves, tiles)
}

#[test]
fn the_index_in_a_leaf_has_z_fastest() {
    assert_eq!(Leaf::<f32>::index([0, 0, 1]), 1);
    assert_eq!(Leaf::<f32>::index([0, 1, 0]), 8);
    assert_eq!(Leaf::<f32>::index([1, 0, 0]), 64);
    assert_eq!(Leaf::<f32>::index([-1, -1, -1]), 511);
    let leaf = Leaf::new([-8, 16, 0], 0.0);
    for index in 0..LEAF_VOXELS {
        assert_eq!(Leaf::<f32>::index(leaf.voxel(index)), index);
    }
}

#[test]
fn a_voxel_has_the_value_of_the_leaf_or_tile_around_it() {
    let mut leaf = Leaf::new([0; 3], 1.0);
    leaf.set([1, 2, 3], 2.0);
    let mut unset = tile([16, 0, 0], TileLevel::Leaf, 9.0);
    unset.active = false;
    let tiles = vec![
        tile([8, 0, 0], TileLevel::Leaf, 3.0),
        unset,
        tile([128, 0, 0], TileLevel::Lower, 4.0),
        tile([-4096, -4096, 0], TileLevel::Upper, 5.0),
    ];
    let tree = FloatTree::from_parts(1.0, vec![leaf], tiles).unwrap();
    let expected = [
        ([1, 2, 3], 2.0, true),
        ([1, 2, 4], 1.0, false),
        ([15, 7, 7], 3.0, true),
        ([23, 7, 7], 9.0, false),
        ([24, 0, 0], 1.0, false),
        ([255, 127, 127], 4.0, true),
        ([256, 0, 0], 1.0, false),
        ([-1, -1, 4095], 5.0, true),
        ([-1, 0, 0], 1.0, false),
    ];
    for (voxel, value, active) in expected {
        assert_eq!(
            (tree.get(voxel), tree.is_active(voxel)),
            (value, active),
            "{voxel:?}"
        );
    }
    assert_eq!(
        tree.active_voxel_count(),
        1 + 512 + 128 * 128 * 128 + 4096 * 4096 * 4096
    );
    assert_eq!(
        tree.active_bounds(),
        Some(([-4096, -4096, 0], [255, 127, 4095]))
    );
}

#[test]
fn bounds_hold_the_active_voxels_and_no_more() {
    let mut random = Random(7);
    for n_voxels in [1, 2, 3, 20] {
        let mut leaf = Leaf::new([-8, 0, 16], 0.0);
        for _ in 0..n_voxels {
            leaf.set(leaf.voxel(random.below(LEAF_VOXELS)), 1.0);
        }
        let voxels = leaf
            .active()
            .map(|(index, _)| leaf.voxel(index))
            .collect::<Vec<_>>();
        let end = |axis: usize| {
            let along = || voxels.iter().map(|voxel| voxel[axis]);
            (along().min().unwrap(), along().max().unwrap())
        };
        let [x, y, z] = [0, 1, 2].map(end);
        let tree = FloatTree::from_leaves(0.0, vec![leaf]).unwrap();
        assert_eq!(
            tree.active_bounds(),
            Some(([x.0, y.0, z.0], [x.1, y.1, z.1]))
        );
    }
}

#[test]
fn origins_off_the_lattice_are_refused() {
    for origin in [[4, 0, 0], [0, -7, 0], [0, 0, 1]] {
        let error = tree(&[origin], vec![]).unwrap_err();
        assert!(matches!(error, Error::Misaligned { dim: 8, .. }));
    }
    let error = tree(&[], vec![tile([8, 0, 0], TileLevel::Lower, 1.0)]).unwrap_err();
    assert!(matches!(
        error,
        Error::Misaligned {
            origin: [8, 0, 0],
            dim: 128
        }
    ));
}

#[test]
fn voxels_covered_twice_are_refused() {
    let leaf = [-3968, 8, 8];
    let covers = [
        tile(leaf, TileLevel::Leaf, 1.0),
        tile([-3968, 0, 0], TileLevel::Lower, 1.0),
        tile([-4096, 0, 0], TileLevel::Upper, 1.0),
    ];
    assert!(tree(&[leaf, leaf], vec![]).is_err());
    for (place, &first) in covers.iter().enumerate() {
        let error = tree(&[[0; 3], leaf, [-3968, 8, 16]], vec![first]).unwrap_err();
        assert!(matches!(error, Error::Overlap { .. }));
        for &second in &covers[place..] {
            assert!(tree(&[], vec![first, second]).is_err());
            assert!(tree(&[], vec![second, first]).is_err());
        }
    }
    let beside = tile([-3968, 8, 16], TileLevel::Leaf, 1.0);
    assert!(tree(&[leaf, [-3968, 8, 0]], vec![beside]).is_ok());
}

#[test]
fn leaves_are_found_whatever_order_they_came_in() {
    let mut random = Random(3);
    let mut origins = (0..300)
        .map(|n| [n % 7 - 3, n / 7 % 7 - 3, n / 49 - 3])
        .collect::<Vec<_>>();
    let far = |axis: i32| if axis == 3 { 4096 * 500 } else { 8 * axis };
    for origin in &mut origins {
        *origin = origin.map(far);
    }
    for place in (1..origins.len()).rev() {
        origins.swap(place, random.below(place + 1));
    }
    let tree = tree(&origins, vec![]).unwrap();
    for origin in origins {
        assert_eq!(
            tree.leaf(origin.map(|axis| axis + 7)).unwrap().origin,
            origin
        );
    }
    assert!(tree.leaf([8 * 100, 0, 0]).is_none());
}

#[test]
fn a_transform_leads_there_and_back() {
    let linear = DMat3::from_cols_array(&[2.0, 0.5, 0.0, 0.1, 3.0, 0.2, -0.3, 0.0, 1.5]);
    let transform = Transform::affine(linear, DVec3::new(10.0, -20.0, 30.0)).unwrap();
    assert_eq!(
        transform.index_to_world(DVec3::X),
        DVec3::new(12.0, -19.5, 30.0)
    );
    let index = DVec3::new(-3.5, 7.0, 1e3);
    let back = transform.world_to_index(transform.index_to_world(index));
    assert!(back.abs_diff_eq(index, 1e-11), "{back}");
    assert_eq!(transform.uniform_voxel_size(), None);
    let cubes = Transform::uniform_scale_translate(0.25, DVec3::ONE);
    assert_eq!(cubes.uniform_voxel_size(), Some(0.25));
    // Skewed by the roundoff of f32, and by more.
    for (skew, expected) in [(1e-8, Some(0.25)), (1e-5, None)] {
        let linear = cubes.linear() + DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X) * skew;
        let skewed = Transform::affine(linear, DVec3::ONE).unwrap();
        assert_eq!(skewed.uniform_voxel_size(), expected, "{skew}");
    }
    assert_eq!(cubes.world_to_index(DVec3::splat(1.5)), DVec3::splat(2.0));
}

#[test]
fn transforms_without_an_inverse_are_refused() {
    let flat = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
    let error = Transform::affine(flat, DVec3::ZERO).unwrap_err();
    assert!(matches!(error, Error::SingularTransform { .. }));
    assert!(Transform::affine(DMat3::IDENTITY, DVec3::new(f64::NAN, 0.0, 0.0)).is_err());
    assert!(
        Transform::affine(
            DMat3::from_diagonal(DVec3::splat(f64::INFINITY)),
            DVec3::ZERO
        )
        .is_err()
    );
    let tiny = DMat3::from_diagonal(DVec3::splat(1e-90));
    assert!(Transform::affine(tiny, DVec3::ZERO).is_ok());
}
