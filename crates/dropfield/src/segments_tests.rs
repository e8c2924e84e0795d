//! Claims about the cells along a ray.
#![allow(clippy::float_cmp, reason = "values that must come back bit for bit")]

use super::*;
use crate::DropMode;
use crate::Drops;
use crate::GridBox;
use crate::Interpolation;
use crate::test_volumes::grid;
use crate::test_volumes::random;
use crate::test_volumes::random_point;
use crate::test_volumes::sparse;
use crate::test_volumes::varied;

fn full() -> Bricks {
    let mode = DropMode::from_fn("", &grid(), varied).unwrap();
    Bricks::build(&mode, Interpolation::Moments).unwrap()
}

/// Length of a ray inside a box, by the slab method in its plainest form.
fn chord(min: DVec3, max: DVec3, origin: DVec3, direction: DVec3) -> f64 {
    let (a, b) = ((min - origin) / direction, (max - origin) / direction);
    let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    (far - near).max(0.0)
}

#[test]
fn segments_of_random_rays_sum_to_the_chord() {
    let bricks = full();
    let (min, max) = bricks.world_bounds().unwrap();
    let mut seed = 11;
    for _ in 0..10_000 {
        let origin = 0.5 * (min + max) + 40.0 * random_point(&mut seed);
        let direction = random_point(&mut seed).normalize();
        let mut length = 0.0;
        let mut last_exit = None;
        for segment in bricks.segments(origin, direction, (0.0, 1e6)) {
            assert!(segment.t_exit > segment.t_enter);
            assert!(last_exit.is_none_or(|exit: f64| exit == segment.t_enter));
            last_exit = Some(segment.t_exit);
            length += segment.t_exit - segment.t_enter;
        }
        // Measured worst 3.2e-14.
        let error = (length - chord(min, max, origin, direction)).abs();
        assert!(error < 1e-12, "{origin} {direction}: {error:e}");
    }
}

#[test]
fn every_segment_lies_in_one_cell() {
    let bricks = full();
    let mut seed = 12;
    for _ in 0..1_000 {
        let origin = grid().min + 30.0 * random_point(&mut seed);
        let direction = random_point(&mut seed).normalize();
        for segment in bricks.segments(origin, direction, (0.0, 1e6)) {
            // A cell of 2 m is at most 2 sqrt(3) m long.
            assert!(segment.t_exit - segment.t_enter < 3.4642);
            for fraction in [0.0, 0.3, 1.0] {
                let t = segment.t_enter + f64::from(fraction) * (segment.t_exit - segment.t_enter);
                let (in_cell, at_point) = (
                    segment.sample(fraction),
                    bricks.sample(origin + t * direction),
                );
                // f32 coordinates in a cell, steep fields at the edge: measured worst 1.5e-5.
                assert!((in_cell.m2 - at_point.m2).abs() <= 2e-5 * at_point.m2.max(1e6));
            }
        }
    }
}

#[test]
fn the_cubic_of_a_cell_is_its_interpolant_along_the_ray() {
    let mut bricks = full();
    let tau_sun = bricks.at_nodes(|point| (0.1 * (point.x - point.y).sin() + 0.2) as f32);
    bricks.set_tau_sun(&tau_sun);
    let mut seed = 15;
    let (mut worst, mut largest) = (Vec4::ZERO, Vec4::ZERO);
    for _ in 0..500 {
        let origin = grid().min + 30.0 * random_point(&mut seed);
        let direction = random_point(&mut seed).normalize();
        for segment in bricks.segments(origin, direction, (0.0, 1e6)) {
            let [c0, c1, c2, c3] = segment.cubic();
            for x in [0.0, 0.25, 0.5, 0.9, 1.0] {
                let cubic = c0 + x * (c1 + x * (c2 + x * c3));
                let expected = lanes(segment.sample(x));
                worst = worst.max((cubic - expected).abs());
                largest = largest.max(expected.abs());
            }
        }
    }
    // Measured worst 2e-7.
    assert!(
        (worst / largest).max_element() < 1e-6,
        "{}",
        worst / largest
    );
}

#[test]
fn the_cubic_of_an_even_field_is_exactly_constant() {
    let drops = Drops {
        number_density_m3: 812.3,
        effective_radius_m: 3.3e-4,
        effective_variance: 0.07,
    };
    let mode = DropMode::from_fn("", &grid(), |_| drops).unwrap();
    let bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
    let (min, max) = bricks.world_bounds().unwrap();
    // The outermost cells fade out.
    let inside = |point: DVec3| point.cmpgt(min + 2.0).all() && point.cmplt(max - 2.0).all();
    let (origin, direction) = (0.5 * (min + max), DVec3::new(0.3, -0.8, 0.52).normalize());
    let mut values = Vec::new();
    for segment in bricks.segments(origin, direction, (0.0, 1e6)) {
        if inside(origin + segment.t_enter * direction)
            && inside(origin + segment.t_exit * direction)
        {
            let [c0, c1, c2, c3] = segment.cubic();
            assert_eq!([c1, c2, c3], [Vec4::ZERO; 3]);
            values.push(c0);
        }
    }
    assert!(values.len() > 3 && values.iter().all(|value| *value == values[0]));
}

fn lanes(sample: Sample) -> Vec4 {
    Vec4::new(sample.m2, sample.m3, sample.m4, sample.tau_sun)
}

/// Optical depth by the midpoint rule with many steps.
fn fine_sum(bricks: &Bricks, origin: DVec3, direction: DVec3, t_end: f64) -> f64 {
    let n = 20_000;
    let step = t_end / f64::from(n);
    let at = |i: i32| origin + direction * (step * (f64::from(i) + 0.5));
    (0..n)
        .map(|i| f64::from(bricks.sample(at(i)).m2))
        .sum::<f64>()
        * step
}

/// The same by segments: Simpson's rule is exact for the cubic in a cell.
fn segment_sum(segments: Segments) -> f64 {
    let run = |segment: Segment| {
        let [a, b, c] = [0.0, 0.5, 1.0].map(|at| f64::from(segment.sample(at).m2));
        (segment.t_exit - segment.t_enter) * (a + 4.0 * b + c) / 6.0
    };
    segments.map(run).sum()
}

#[test]
fn integrals_through_empty_bricks_miss_nothing() {
    let bricks = Bricks::build(&sparse(), Interpolation::Moments).unwrap();
    let targets = [
        DVec3::new(6.0, 6.0, 6.0),
        DVec3::new(50.0, 20.0, 30.0),
        DVec3::new(9.0, 57.0, 40.0),
    ];
    let mut seed = 13;
    for index in 0..60 {
        let origin = DVec3::splat(32.0) + 60.0 * random_point(&mut seed);
        let target = targets[index % 3] + 3.0 * random_point(&mut seed);
        let direction = (target - origin).normalize();
        let fine = fine_sum(&bricks, origin, direction, 150.0);
        let found = segment_sum(bricks.segments(origin, direction, (0.0, 150.0)));
        // Measured worst 1e-6: the steps of the fine sum.
        assert!(
            (found / fine - 1.0).abs() < 1e-5,
            "{origin} {direction}: {found} {fine}"
        );
    }
}

#[test]
fn cells_without_drops_are_left_out_and_no_others() {
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let bricks = Bricks::build(&sparse(), interpolation).unwrap();
        let mut seed = 17;
        let mut n_empty = 0;
        for _ in 0..300 {
            let target = DVec3::splat(6.0) + 8.0 * random_point(&mut seed);
            let direction = random_point(&mut seed).normalize();
            let origin = target - 20.0 * direction;
            let mut t = 0.0;
            for segment in bricks.segments(origin, direction, (0.0, 40.0)) {
                let has_drops = |fraction| segment.sample(fraction).m2 > 0.0;
                // A ray may run where the interpolant is 0: in the face of a cell.
                assert!([0.1, 0.5, 0.9].into_iter().any(has_drops));
                // Between cells there is nothing.
                let gap = segment.t_enter - t;
                for step in 1..8 {
                    let at = origin + direction * (t + gap * f64::from(step) / 8.0);
                    assert!(gap < 1e-12 || bricks.m2(at) == 0.0, "{at}");
                }
                n_empty += usize::from(gap > 0.0);
                t = segment.t_exit;
            }
        }
        assert!(n_empty > 100, "{n_empty}");
    }
}

#[test]
fn axis_parallel_rays_cross_exactly() {
    let bricks = full();
    let (min, max) = bricks.world_bounds().unwrap();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut direction = DVec3::ZERO;
            direction[axis] = sign;
            let start = 0.5 * (min + max) - 100.0 * direction;
            let found: Vec<_> = bricks.segments(start, direction, (0.0, 1e3)).collect();
            let size = (max - min)[axis];
            assert_eq!(found.len(), (size / 2.0) as usize);
            assert!(
                found
                    .iter()
                    .all(|run| (run.t_exit - run.t_enter - 2.0).abs() < 1e-12)
            );
        }
    }
}

#[test]
fn a_ray_in_a_face_between_cells_is_counted_once() {
    let bricks = full();
    let (min, max) = bricks.world_bounds().unwrap();
    // On the lowest faces, on faces between cells, along an edge; on the highest face nothing.
    for (y, z, n_expected) in [
        (min.y, min.z, 20),
        (min.y + 6.0, min.z + 5.0, 20),
        (min.y + 6.0, min.z + 4.0, 20),
        (max.y, min.z + 4.0, 0),
        (min.y - 1e-9, min.z + 4.0, 0),
    ] {
        let origin = DVec3::new(min.x - 5.0, y, z);
        assert_eq!(
            bricks.segments(origin, DVec3::X, (0.0, 1e3)).count(),
            n_expected
        );
        let back = DVec3::new(max.x + 5.0, y, z);
        assert_eq!(
            bricks.segments(back, DVec3::NEG_X, (0.0, 1e3)).count(),
            n_expected
        );
    }
}

#[test]
fn grazing_diagonals_neither_stop_nor_repeat() {
    let bricks = full();
    let (min, max) = bricks.world_bounds().unwrap();
    // Through the edges of cells, both ways, and almost parallel to a face.
    let diagonal = DVec3::new(1.0, 1.0, 0.0);
    for direction in [
        diagonal,
        -diagonal,
        DVec3::new(1.0, 1e-12, -1e-13),
        DVec3::ONE,
    ] {
        let direction = direction.normalize();
        let origin = min + DVec3::new(4.0, 4.0, 4.0) - 10.0 * direction;
        let sum: f64 = bricks
            .segments(origin, direction, (0.0, 1e3))
            .map(|segment| segment.t_exit - segment.t_enter)
            .sum();
        let expected = chord(min, max, origin, direction);
        assert!(
            (sum - expected).abs() < 1e-11,
            "{direction}: {sum} {expected}"
        );
    }
}

#[test]
fn a_ray_from_inside_starts_where_it_is_told() {
    let bricks = full();
    let (min, max) = bricks.world_bounds().unwrap();
    let mut seed = 14;
    for _ in 0..1_000 {
        let origin = 0.5 * (min + max) + 0.5 * (max - min) * random_point(&mut seed);
        let range = (3.0 * random(&mut seed), 3.0 + 2.0 * random(&mut seed));
        let direction = random_point(&mut seed).normalize();
        let runs: Vec<_> = bricks.segments(origin, direction, range).collect();
        let inside = chord(min, max, origin, direction);
        if inside > range.1 {
            assert_eq!(runs.first().map(|run| run.t_enter), Some(range.0));
            assert_eq!(runs.last().map(|run| run.t_exit), Some(range.1));
        }
    }
}

#[test]
fn rays_without_meaning_give_nothing() {
    let bricks = full();
    for (origin, direction) in [
        (DVec3::NAN, DVec3::X),
        (grid().min, DVec3::NAN),
        (grid().min, DVec3::new(f64::INFINITY, 0.0, 0.0)),
    ] {
        assert_eq!(bricks.segments(origin, direction, (0.0, 1e3)).count(), 0);
    }
    assert_eq!(bricks.segments(grid().min, DVec3::X, (5.0, 5.0)).count(), 0);
    assert_eq!(
        bricks
            .segments(grid().min, DVec3::X, (f64::NAN, f64::NAN))
            .count(),
        0
    );
}

#[test]
fn a_volume_of_one_node_is_a_tent() {
    let drops = Drops {
        number_density_m3: 1.0,
        effective_radius_m: 1e-6,
        effective_variance: 0.0,
    };
    let min = DVec3::new(1e6, 0.0, -1e6);
    let grid = crate::GridBox {
        min,
        max: min + 0.5,
        voxel_m: 0.5,
    };
    let mode = DropMode::from_fn("", &grid, |_| drops).unwrap();
    let bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
    let start = mode.node_position([0; 3]) - DVec3::new(0.0, 20.0, 0.0);
    // A hat of height 1 um²/m³ and half width 0.5 m, 1000 km from the origin.
    assert!((segment_sum(bricks.segments(start, DVec3::Y, (0.0, 100.0))) - 0.5).abs() < 1e-6);
}

/// 48 voxels along each axis, with a wave of a length and a shadow.
fn waves(length_m: f64) -> Bricks {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(48.0),
        voxel_m: 1.0,
    };
    let wave = |at: DVec3| {
        let phase = at * std::f64::consts::TAU / length_m;
        phase.x.sin() * phase.y.cos() * (0.7 * phase.z).sin()
    };
    let drops = |at: DVec3| Drops {
        number_density_m3: (600.0 + 300.0 * wave(at)) as f32,
        effective_radius_m: (4e-4 + 1e-4 * wave(at + 5.0)) as f32,
        effective_variance: 0.1,
    };
    let mode = DropMode::from_fn("", &grid, drops).unwrap();
    let mut bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
    let depths = bricks.at_nodes(|at| (0.3 + 0.2 * wave(at)) as f32);
    bricks.set_tau_sun(&depths);
    bricks
}

#[test]
fn coarse_cells_tile_the_chord_and_err_as_they_tell() {
    for (length_m, allowed, least_saved) in [
        (300.0, 1e-3, 1.3),
        (300.0, 3e-2, 1.3),
        (120.0, 1e-2, 1.3),
        (40.0, 3e-2, 1.3),
        // The radius, which counts eight times, changes by a quarter over ten voxels.
        (40.0, 1e-2, 1.2),
    ] {
        let bricks = waves(length_m);
        let (min, max) = bricks.world_bounds().unwrap();
        let mut seed = 21;
        let (mut n, mut n_fine) = (0, 0);
        let (mut squares, mut told) = (0.0, 0.0);
        for _ in 0..2_000 {
            let origin = 0.5 * (min + max) + 50.0 * random_point(&mut seed);
            let direction = random_point(&mut seed).normalize();
            let (mut length, mut last_exit) = (0.0, None);
            for segment in bricks.coarse_segments(origin, direction, (0.0, 1e6), allowed) {
                assert!(last_exit.is_none_or(|exit: f64| exit == segment.t_enter));
                last_exit = Some(segment.t_exit);
                let run = segment.t_exit - segment.t_enter;
                length += run;
                n += 1;
                let error = f64::from(segment.relative_error());
                assert!(error <= allowed && segment.is_coarse() == (error > 0.0));
                for fraction in [0.2, 0.5, 0.8] {
                    let at = origin + direction * (segment.t_enter + f64::from(fraction) * run);
                    let [found, exact] = [segment.sample(fraction), bricks.sample(at)].map(lanes);
                    let scale = exact.with_w(0.5);
                    if segment.is_coarse() {
                        let mut relative = (found - exact) / scale;
                        // Of the radius, eight times.
                        relative.y = 8.0 * (relative.y - relative.x);
                        let worst = relative.abs().max_element();
                        squares += run * f64::from(worst).powi(2);
                        told += run * error * error;
                    }
                }
            }
            n_fine += bricks.segments(origin, direction, (0.0, 1e6)).count();
            let error = (length - chord(min, max, origin, direction)).abs();
            assert!(error < 1e-11, "{origin} {direction}: {error:e}");
        }
        // The worst lane at each point, relative to its own value: RMS along rays over what is told.
        // Measured 0.77 to 0.88, and 1.25 to 2.9 times fewer cells; most bricks have the rim.
        let ratio = (squares / told).sqrt();
        let saved = n_fine as f64 / n as f64;
        assert!((0.5..1.2).contains(&ratio), "{length_m} {allowed}: {ratio}");
        assert!(saved > least_saved, "{length_m} {allowed}: {saved}");
    }
}

#[test]
fn integrals_by_coarse_cells_keep_to_their_error_behind_a_slanting_face() {
    // Empty cells, even ones and the ends of drops in one brick, the face at all places in it.
    for end in 18..26 {
        let grid = GridBox {
            min: DVec3::ZERO,
            max: DVec3::splat(32.0),
            voxel_m: 1.0,
        };
        let drops = |at: DVec3| Drops {
            number_density_m3: (at.element_sum() - f64::from(end)).max(0.0) as f32,
            effective_radius_m: 1e-4,
            effective_variance: 0.0,
        };
        let mode = DropMode::from_fn("", &grid, drops).unwrap();
        let mut bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
        bricks.set_tau_sun(&bricks.at_nodes(|_| 0.1));
        let mut seed = 5;
        for _ in 0..300 {
            let origin = 16.0 + 40.0 * random_point(&mut seed);
            let towards = 16.0 + 12.0 * random_point(&mut seed);
            let direction = (towards - origin).normalize();
            let [found, exact] = [0.1, 0.0].map(|allowed| {
                segment_sum(bricks.coarse_segments(origin, direction, (0.0, 1e3), allowed))
            });
            assert!(
                (found - exact).abs() <= 0.1 * exact,
                "{end}: {found} {exact}"
            );
        }
    }
}

#[test]
fn drops_that_grow_evenly_from_a_plane_on_are_not_missed() {
    // The same width serves all of a brick, while some of its cells hold drops and some do not.
    for end in 0..32 {
        let first = 16.0 + 0.25 * f64::from(end);
        let grid = GridBox {
            min: DVec3::ZERO,
            max: DVec3::splat(64.0),
            voxel_m: 1.0,
        };
        let drops = |at: DVec3| Drops {
            // A layer at the bottom, where the lattice begins.
            number_density_m3: if at.y < 1.0 {
                1.0
            } else {
                (at.y - first).max(0.0) as f32
            },
            effective_radius_m: 1e-4,
            effective_variance: 0.0,
        };
        let mode = DropMode::from_fn("", &grid, drops).unwrap();
        let mut bricks = Bricks::build(&mode, Interpolation::Moments).unwrap();
        bricks.set_tau_sun(&bricks.at_nodes(|_| 0.1));
        for upwards in [1.0, -1.0] {
            let origin = DVec3::new(30.0, 32.0 - 40.0 * upwards, 31.0);
            let direction = DVec3::new(0.05, upwards, 0.02);
            let [found, exact] = [0.01, 0.0].map(|allowed| {
                segment_sum(bricks.coarse_segments(origin, direction, (0.0, 1e3), allowed))
            });
            let error = found / exact - 1.0;
            assert!(error.abs() < 1e-3, "{first} {upwards}: {error}");
        }
    }
}

#[test]
fn where_no_error_is_allowed_every_cell_is_a_voxel() {
    let bricks = waves(1e9);
    let (origin, direction) = (DVec3::new(-1.0, 20.3, 11.1), DVec3::new(0.9, 0.3, 0.1));
    let range = (0.0, 1e3);
    let whole = bricks.coarse_segments(origin, direction, range, 1e-5);
    // Rim, and the bricks inside.
    assert!(whole.count() < 30);
    let voxels = bricks.coarse_segments(origin, direction, range, 0.0);
    assert!(voxels.count() > 60);
}
