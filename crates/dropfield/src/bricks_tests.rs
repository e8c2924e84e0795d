//! Claims about bricks and what is sampled from them.

use super::*;
use crate::DropLeaf;
use crate::Drops;
use crate::test_volumes::grid;
use crate::test_volumes::random;
use crate::test_volumes::random_point;
use crate::test_volumes::sparse;
use crate::test_volumes::varied;

/// Trilinear value at a world position, straight from the nodes, in f64.
fn direct(mode: &DropMode, world: DVec3, value: impl Fn(&Drops) -> f64) -> f64 {
    let position = (world - mode.origin_m()) / mode.voxel_m();
    let low = position.floor();
    let t = position - low;
    (0..8)
        .map(|corner| {
            let upper = IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1);
            let upper_f = upper.as_dvec3();
            let weight = (upper_f * t + (1.0 - upper_f) * (1.0 - t)).element_product();
            weight * value(&mode.drops((low.as_ivec3() + upper).to_array()))
        })
        .sum()
}

fn m2(drops: &Drops) -> f64 {
    f64::from(AreaMoments::from_drops(drops).m2)
}

#[test]
fn samples_equal_the_trilinear_moments_of_the_nodes() {
    let mut seed = 1;
    for mode in [DropMode::from_fn("", &grid(), varied).unwrap(), sparse()] {
        let bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
        let (min, max) = bricks.world_bounds().unwrap();
        for _ in 0..20_000 {
            let world = 0.5 * (min + max) + 0.6 * (max - min) * random_point(&mut seed);
            let expected = direct(&mode, world, m2);
            let found = f64::from(bricks.sample(world).m2);
            // Relative to the nodes around: measured worst 1.6e-7.
            assert!(
                (found - expected).abs() <= 1e-6 * 4e8,
                "{world}: {found} {expected}"
            );
        }
    }
}

#[test]
fn m2_alone_is_bit_for_bit_that_of_the_sample() {
    let mut seed = 4;
    for mode in [DropMode::from_fn("", &grid(), varied).unwrap(), sparse()] {
        for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
            let bricks = Bricks::build(&mode, interpolation).unwrap();
            let (min, max) = bricks.world_bounds().unwrap();
            for _ in 0..20_000 {
                let world = 0.5 * (min + max) + 0.6 * (max - min) * random_point(&mut seed);
                let (alone, sample) = (bricks.m2(world), bricks.sample(world));
                assert_eq!(alone.to_bits(), sample.m2.to_bits(), "{world}");
            }
            assert_eq!(bricks.m2(DVec3::NAN).to_bits(), 0);
        }
    }
}

#[test]
fn m2_in_a_row_is_that_at_each_of_its_points() {
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let bricks = Bricks::build(&sparse(), interpolation).unwrap();
        // The middle of the box, and of two clouds in it.
        let middles = [
            DVec3::splat(32.0),
            DVec3::splat(6.0),
            DVec3::new(50.0, 20.0, 30.0),
        ];
        let mut seed = 11;
        let mut rows: Vec<(DVec3, usize, f64)> = (0..2000)
            .map(|row| {
                let step_m = 10_f64.powf(2.0 * random(&mut seed) - 1.0);
                let near = middles[row % 3] + 5.0 * random_point(&mut seed);
                let before_m = 100.0 * random(&mut seed) * step_m;
                (near - before_m * DVec3::AXES[row % 3], row % 3, step_m)
            })
            .collect();
        // On faces of bricks and of the box, into it and out of it, and not at all.
        for axis in 0..3 {
            for start in [-8.0, 0.0, 8.0, 64.0, 65.0, 72.0, 80.0, f64::NAN] {
                let along = DVec3::splat(8.0) + DVec3::AXES[axis] * (start - 8.0);
                rows.push((along, axis, 1.0));
                rows.push((DVec3::splat(start), axis, 0.37));
            }
        }
        let most = rows
            .iter()
            .map(|(start, ..)| bricks.m2(*start))
            .fold(0.0, f32::max);
        let mut n_with_drops = 0;
        for (start, axis, step_m) in rows {
            let mut sums = [1.0; 100];
            bricks.add_m2_in_row(start, axis, step_m, &mut sums);
            for (index, sum) in (0..).zip(sums) {
                let point = start + f64::from(index) * step_m * DVec3::AXES[axis];
                let m2 = f64::from(bricks.m2(point));
                let error = (sum - 1.0 - m2).abs() / f64::from(most);
                assert!(error < 2e-6, "{start} {axis} {step_m} {index}: {error}");
                n_with_drops += usize::from(m2 > 0.0);
            }
        }
        assert!(n_with_drops > 3000, "{n_with_drops}");
    }
}

#[test]
fn nodes_come_back_from_samples() {
    let mode = DropMode::from_fn("", &grid(), varied).unwrap();
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let bricks = Bricks::build(&mode, interpolation).unwrap();
        for (node, drops) in mode.nodes() {
            let found = bricks.sample(mode.node_position(node)).moments();
            let expected = AreaMoments::from_drops(&drops);
            assert!((found.m2 / expected.m2 - 1.0).abs() < 2e-6);
            assert!((found.effective_variance() - drops.effective_variance).abs() < 2e-6);
        }
    }
}

#[test]
fn literal_interpolation_has_linear_radius_and_density() {
    let mode = DropMode::from_fn("", &grid(), varied).unwrap();
    let bricks = Bricks::build(&mode, Interpolation::RadiusDensity).unwrap();
    let mut seed = 2;
    for _ in 0..5_000 {
        // Inside the outermost nodes.
        let center = 0.5 * (grid().min + grid().max);
        let world = center + 0.4 * (grid().max - grid().min) * random_point(&mut seed);
        let radius_um = 1e6 * direct(&mode, world, |drops| f64::from(drops.effective_radius_m));
        let number = direct(&mode, world, |drops| f64::from(drops.number_density_m3));
        let v_e = direct(&mode, world, |drops| f64::from(drops.effective_variance));
        let found = bricks.sample(world).moments();
        let m2 = number * radius_um * radius_um * (1.0 - v_e) * (1.0 - 2.0 * v_e);
        assert!((f64::from(found.m2) / m2 - 1.0).abs() < 2e-6);
        assert!((f64::from(found.effective_radius_um()) / radius_um - 1.0).abs() < 1e-6);
    }
}

#[test]
fn radius_does_not_fade_at_the_edge() {
    let drops = Drops {
        number_density_m3: 1000.0,
        effective_radius_m: 1e-3,
        effective_variance: 0.0,
    };
    let mode = DropMode::from_fn("", &grid(), |_| drops).unwrap();
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let bricks = Bricks::build(&mode, interpolation).unwrap();
        // 0.9 of a voxel outside the first node.
        let outside = mode.node_position([0, 4, 4]) - DVec3::new(1.8, 0.0, 0.0);
        let found = bricks.sample(outside).moments();
        assert!(
            (found.effective_radius_um() - 1000.0).abs() < 1e-2,
            "{interpolation:?}"
        );
        assert!(
            (found.m2 / (0.1 * 1000.0 * 1e6) - 1.0).abs() < 1e-5,
            "{interpolation:?}"
        );
    }
}

#[test]
fn nothing_outside_and_nothing_in_an_empty_volume() {
    let mode = DropMode::from_fn("", &grid(), varied).unwrap();
    let bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
    let (min, max) = bricks.world_bounds().unwrap();
    for world in [
        min - 1e-9,
        max,
        DVec3::splat(1e9),
        DVec3::NAN,
        -DVec3::NAN,
        DVec3::INFINITY,
        DVec3::NEG_INFINITY,
    ] {
        assert_eq!(bricks.sample(world), Sample::default());
    }
    let empty = DropMode::from_fn("", &grid(), |_| Drops::NONE).unwrap();
    let bricks = Bricks::build(&empty, Interpolation::Moments).unwrap();
    assert_eq!((bricks.world_bounds(), bricks.n_bricks()), (None, 0));
    assert_eq!(bricks.sample(grid().min), Sample::default());
    assert_eq!(bricks.segments(grid().min, DVec3::X, (0.0, 1e9)).count(), 0);
}

#[test]
fn sun_lane_is_trilinear_in_the_values_at_nodes() {
    let mode = sparse();
    let plane = |world: DVec3| (0.25 * world.x + 0.5 * world.y - 0.125 * world.z) as f32;
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let mut bricks = Bricks::build(&mode, interpolation).unwrap();
        let values = bricks.at_nodes(plane);
        bricks.set_tau_sun(&values);
        let mut seed = 4;
        for _ in 0..2_000 {
            let world = DVec3::splat(6.0) + 5.0 * random_point(&mut seed);
            // A linear function is its own interpolant, also between bricks.
            assert!((bricks.sample(world).tau_sun - plane(world)).abs() < 1e-5);
        }
    }
}

#[test]
fn bounds_on_m2_hold_in_every_brick() {
    let mut seed = 5;
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let bricks = Bricks::build(&sparse(), interpolation).unwrap();
        let highest = bricks.max_extinction_m1_q1();
        for _ in 0..300 {
            let origin = DVec3::splat(32.0) + 40.0 * random_point(&mut seed);
            for segment in bricks.segments(origin, random_point(&mut seed), (0.0, 200.0)) {
                let sample = segment.sample(random(&mut seed) as f32);
                let (low, high) = segment.m2_range();
                assert!(low * 0.999_999 <= sample.m2 && sample.m2 <= high * 1.000_001);
                assert!(sample.moments().extinction_m1_q1() <= highest * 1.000_001);
            }
        }
    }
}

#[test]
fn bricks_that_would_not_fit_are_refused() {
    let far_in_space = [i32::MAX / 4; 3].map(|axis| axis & !7);
    // Few bricks, and more cells in a row than a coordinate has bits for.
    let far_in_a_row = [1 << 28, 0, 0];
    for far in [far_in_space, far_in_a_row] {
        let leaves = [[0; 3], far].map(|origin| {
            let mut leaf = DropLeaf::empty(origin);
            leaf.drops[0] = varied(DVec3::ZERO);
            leaf
        });
        let mode = DropMode::from_parts(String::new(), 1.0, DVec3::ZERO, leaves.into());
        let result = Bricks::build(&mode, Interpolation::Moments);
        assert!(matches!(result, Err(Error::TooManyNodes { .. })));
    }
}

#[test]
fn the_sizes_of_bricks_are_those_of_their_nodes_and_of_mixtures_between_neighbors() {
    // Radii grow by a tenth from node to node along x, over more than a brick.
    let drops = |position: DVec3| Drops {
        number_density_m3: 1e6,
        effective_radius_m: 1e-4 * 1.1_f32.powf(0.5 * (position.x + 6.0) as f32),
        effective_variance: 0.02,
    };
    let mode = DropMode::from_fn("", &grid(), drops).unwrap();
    let found = Bricks::build(&mode, Interpolation::Moments).unwrap();
    let sizes = found.size_range().unwrap();
    let (low, high) = sizes.effective_radius_um;
    assert!((low / 100.0 - 1.0).abs() < 1e-5 && (high / 555.99 - 1.0).abs() < 1e-4);
    // 1.02 times 2.1²/(4 times 1.1), less 1.
    let (narrow, broad) = sizes.effective_variance;
    assert!(
        (narrow - 0.02).abs() < 1e-5 && (broad - 0.022_318).abs() < 1e-5,
        "{broad}"
    );
    let own = Bricks::build(&mode, Interpolation::RadiusDensity).unwrap();
    let (narrow, broad) = own.size_range().unwrap().effective_variance;
    assert!((narrow - 0.02).abs() < 1e-6 && (broad - 0.02).abs() < 1e-6);
}
