//! Claims about drops of turned and stretched lattices.

use glam::DMat3;

use super::*;

/// f32 numbers; worst found 6e-8.
const WATER_TOLERANCE: f64 = 5e-7;

fn transform(linear: DMat3) -> Transform {
    Transform::affine(linear, DVec3::new(3.0, -2.0, 7.0)).unwrap()
}

/// Drops at nodes from -n to n on every axis; their number by the index.
fn lattice(linear: DMat3, n: i32, number: impl Fn(DVec3) -> f64) -> Lattice {
    let mut leaves = Leaves::new();
    let line = || -n..=n;
    for node in line().flat_map(|x| line().flat_map(move |y| line().map(move |z| [x, y, z]))) {
        let number = number(DVec3::from(node.map(f64::from)));
        if number > 0.0 {
            let origin = leaf_origin(node);
            let leaf = leaves
                .entry(origin)
                .or_insert_with(|| DropLeaf::empty(origin));
            leaf.drops[place_in_leaf(node)] = Drops {
                number_density_m3: number as f32,
                effective_radius_m: 2e-5,
                effective_variance: 0.1,
            };
        }
    }
    Lattice {
        transform: transform(linear),
        leaves,
    }
}

fn total_water_g(lattice: &Lattice) -> f64 {
    let per_node = niji_sizes::liquid_water_g_m3(water(&lattice.leaves));
    per_node * lattice.transform.linear().determinant().abs()
}

/// Turned about no axis of its own, and stretched: what no cube fits.
fn askew() -> DMat3 {
    DMat3::from_rotation_y(0.5)
        * DMat3::from_rotation_x(0.3)
        * DMat3::from_diagonal(DVec3::new(0.5, 0.8, 0.6))
}

#[test]
fn quarter_turns_and_mirrors_keep_every_node_as_it_is() {
    let z_up = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    for turn in [
        z_up,
        z_up * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
    ] {
        let number = |index: DVec3| 1e7 + 1e3 * index.dot(DVec3::new(1.0, 20.0, 400.0));
        let lattice = lattice(0.25 * turn, 9, number);
        let (place, before) = (lattice.transform, lattice.leaves.clone());
        let mode = lattice.on_cubes(None).unwrap();
        assert!((mode.voxel_m() - 0.25).abs() < 1e-15);
        assert_eq!(mode.nodes().count(), 19 * 19 * 19);
        for leaf in before.values() {
            for (at, drops) in leaf.drops.iter().enumerate().filter(|it| it.1.exist()) {
                let index = DVec3::from(leaf.node(at).map(f64::from));
                let steps = (place.index_to_world(index) - mode.origin_m()) / mode.voxel_m();
                let node = steps.round().to_array().map(|axis| axis as i32);
                assert_eq!(mode.drops(node), *drops);
            }
        }
    }
}

#[test]
fn a_lattice_that_is_askew_gives_all_its_water_in_its_place() {
    let blob = |index: DVec3| 1e8 * (1.0 - index.length() / 10.0).max(0.0);
    for (voxel_m, off_voxels) in [(None, 0.02), (Some(0.3), 0.02), (Some(1.7), 0.02)] {
        let lattice = lattice(askew(), 10, blob);
        let expected = total_water_g(&lattice);
        let centre = lattice.transform.translation();
        let mode = lattice.on_cubes(voxel_m).unwrap();
        assert!((mode.voxel_m() - voxel_m.unwrap_or(0.5)).abs() < 1e-12);
        assert!((mode.total_water_g() / expected - 1.0).abs() < WATER_TOLERANCE);
        let numbers: f64 = mode
            .nodes()
            .map(|it| f64::from(it.1.number_density_m3))
            .sum();
        let weighted = mode
            .nodes()
            .map(|(node, drops)| f64::from(drops.number_density_m3) * mode.node_position(node));
        let found = weighted.sum::<DVec3>() / numbers;
        assert!(
            (found - centre).length() < off_voxels * mode.voxel_m(),
            "{found}"
        );
        for (_, drops) in mode.nodes() {
            assert!((drops.effective_radius_m / 2e-5 - 1.0).abs() < 1e-5);
            assert!((drops.effective_variance - 0.1).abs() < 1e-4);
        }
    }
}

#[test]
fn inside_a_field_that_is_linear_stays_itself() {
    let slope = DVec3::new(2e6, -3e6, 1e6);
    let lattice = lattice(askew(), 12, |index| 1e8 + slope.dot(index));
    let place = lattice.transform;
    let mode = lattice.on_cubes(None).unwrap();
    let mut n_inside = 0;
    for (node, drops) in mode.nodes() {
        let index = place.world_to_index(mode.node_position(node));
        if index.abs().max_element() < 10.0 {
            let expected = 1e8 + slope.dot(index);
            // The factor that keeps all of the water; worst found 3e-4.
            let error = f64::from(drops.number_density_m3) / expected - 1.0;
            assert!(error.abs() < 2e-3, "{node:?} {error}");
            n_inside += 1;
        }
    }
    assert!(n_inside > 10_000, "{n_inside}");
}

#[test]
fn sizes_that_meet_keep_water_and_area_of_both() {
    let mut two = lattice(askew(), 6, |_| 1e6);
    for leaf in two.leaves.values_mut() {
        for place in 0..LEAF_NODES {
            if leaf.drops[place].exist() && leaf.node(place)[0] > 0 {
                leaf.drops[place].effective_radius_m = 4e-5;
            }
        }
    }
    let expected = total_water_g(&two);
    let mode = two.on_cubes(None).unwrap();
    assert!((mode.total_water_g() / expected - 1.0).abs() < WATER_TOLERANCE);
    let between = mode.nodes().filter(|it| it.1.effective_variance > 0.11);
    assert!(between.count() > 100);
}

#[test]
fn voxels_that_are_too_coarse_or_too_many_are_refused() {
    let made = |voxel_m| lattice(askew(), 3, |_| 1.0).on_cubes(Some(voxel_m));
    assert!(made(4.0).is_ok());
    let error = made(4.1).unwrap_err();
    assert!(error.to_string().starts_with("voxel_m = 4.1"), "{error}");
    for voxel_m in [1e-4, 1e-12, f64::MIN_POSITIVE] {
        let error = made(voxel_m).unwrap_err();
        assert!(matches!(error, Error::TooManyNodes { .. }), "{error}");
    }
}

#[test]
fn one_thread_and_many_give_the_same_drops() {
    let made = || {
        lattice(askew(), 6, |index| 1e6 + 1e4 * index.x)
            .on_cubes(None)
            .unwrap()
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(made), made());
}
