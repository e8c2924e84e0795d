use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;

use super::*;
use crate::lit_drops::depth;
use crate::progress::unwatched;
use crate::shadow_error::point_sequence;

/// Node distance of the drops (m).
const VOXEL_M: f64 = 1.0 / 32.0;

/// Drops of an extinction at Q = 1 [1/m] in a box.
fn bricks((min, max): (DVec3, DVec3), extinction_m1: impl Fn(DVec3) -> f64 + Sync) -> Bricks {
    let grid = GridBox {
        min,
        max,
        voxel_m: VOXEL_M,
    };
    let drops = |point: DVec3| Drops {
        number_density_m3: (extinction_m1(point) / (1e-8 * std::f64::consts::PI)) as f32,
        effective_radius_m: 1e-4,
        effective_variance: 0.0,
    };
    let mode = DropMode::from_fn("", &grid, drops).expect("the drops are sound");
    Bricks::build(&mode, Interpolation::Moments).expect("the volume is small")
}

fn bounds(bricks: &Bricks) -> Aabb {
    let (min, max) = bricks.world_bounds().expect("there are drops");
    Aabb { min, max }
}

/// Slanting, grazing, level, straight along each axis, along diagonals, and as good as along an axis.
fn suns() -> Vec<DVec3> {
    let mut suns = vec![
        DVec3::new(0.3, 0.9, 0.4),
        DVec3::new(-0.9, 0.17, 0.35),
        DVec3::new(0.2, 0.05, -0.9),
        DVec3::new(0.5, 1e-9, 0.8),
        DVec3::new(0.7, 0.0, -0.4),
        DVec3::new(0.2, -0.7, 0.3),
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(-1.0, 1.0, 0.0),
        DVec3::new(1e-310, 1.0, 1e-17),
    ];
    suns.extend(DVec3::AXES);
    suns.extend(DVec3::AXES.map(|axis| -axis));
    suns.into_iter().map(DVec3::normalize).collect()
}

/// Points that fill a box evenly.
fn points(bounds: Aabb, n: usize) -> impl Iterator<Item = DVec3> {
    (1..=n).map(move |index| bounds.min + (bounds.max - bounds.min) * point_sequence(index))
}

fn sweep(bricks: &Bricks, bounds: Aabb, (sun, voxel_m): (DVec3, f64)) -> SunSweep {
    let lattice = SunSweep::over(bounds, sun, voxel_m).expect("it fits");
    let modes = std::slice::from_ref(bricks);
    lattice.through(modes, &unwatched).expect("nobody stops it")
}

/// Distance from a point to the face by which a line leaves a box.
fn way_out(bounds: Aabb, point: DVec3, sun: DVec3) -> f64 {
    let faces = DVec3::select(sun.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
    let ways = DVec3::select(
        sun.cmpeq(DVec3::ZERO),
        DVec3::INFINITY,
        (faces - point) / sun,
    );
    ways.min_element()
}

#[test]
fn even_drops_have_their_depth_at_any_spacing_and_under_any_sun() {
    let extinction_m1 = 3.0;
    let even = bricks((DVec3::ZERO, DVec3::ONE), |_| extinction_m1);
    // Farther from where the drops begin than its own length.
    let inside = Aabb {
        min: DVec3::new(0.4, 0.45, 0.38),
        max: DVec3::new(0.62, 0.55, 0.6),
    };
    for sun in suns() {
        for voxel_m in [0.007, 0.03, 0.1, 5.0] {
            let sweep = sweep(&even, inside, (sun, voxel_m));
            for point in points(inside, 300) {
                let expected = extinction_m1 * way_out(inside, point, sun);
                let found = f64::from(sweep.at(point));
                // Moments and depths in f32.
                let error = (found - expected).abs() / (expected + 1e-3);
                assert!(error < 1e-6, "{sun} {voxel_m} {point}: {found} {expected}");
            }
        }
    }
}

#[test]
fn the_error_falls_with_the_square_of_the_spacing() {
    // A cloud that does not end at a face of its box.
    let cloud = |point: DVec3| 8.0 * (-20.0 * point.distance_squared(DVec3::splat(0.5))).exp();
    let cloud = bricks((DVec3::ZERO, DVec3::ONE), cloud);
    let modes = std::slice::from_ref(&cloud);
    for sun in suns() {
        let errors = [4.0, 2.0].map(|voxels| {
            let sweep = sweep(&cloud, bounds(&cloud), (sun, voxels * VOXEL_M));
            let squares: f64 = points(bounds(&cloud), 2000)
                .map(|point| (f64::from(sweep.at(point)) - depth(modes, point, sun)).powi(2))
                .sum();
            (squares / 2000.0).sqrt()
        });
        assert!(errors[1] < 0.33 * errors[0], "{sun}: {errors:?}");
    }
}

#[test]
fn a_shadow_stays_as_sharp_as_it_was_cast() {
    // A plate that covers half of the way of a slanting sun, 60 voxels before the other end.
    let (min, max) = (DVec3::ZERO, DVec3::new(1.0, 2.0, 1.0));
    let plate = bricks((min, max), |point| {
        let in_plate = point.y > 1.9 && point.x < 0.5;
        // Drops all over the box keep it open for light.
        if in_plate { 50.0 } else { 1e-6 }
    });
    let modes = std::slice::from_ref(&plate);
    for sun in [DVec3::new(0.12, 0.9, 0.07), DVec3::new(-0.13, 0.8, 0.2)] {
        let sun = sun.normalize();
        let sweep = sweep(&plate, bounds(&plate), (sun, VOXEL_M));
        // Whose lines stay in the box along z.
        let below = Aabb {
            min: min.with_z(0.05),
            max: DVec3::new(1.0, 0.3, 0.4),
        };
        let (mut n_off, n) = (0, 4000);
        for point in points(below, n) {
            let expected = depth(modes, point, sun);
            let error = (f64::from(sweep.at(point)) - expected).abs();
            if error > 1e-3 * 50.0 * 0.1 {
                n_off += 1;
                // Next to the edge on both sides of it.
                let beside = [-2.0, 2.0].map(|voxels| {
                    let point = point + voxels * VOXEL_M * DVec3::X;
                    depth(modes, point, sun)
                });
                assert!(
                    (beside[0] - beside[1]).abs() > 2.5,
                    "{sun} {point}: {error}"
                );
            }
        }
        // 2 voxels of 32 beside the plate's edge, and 2 beside that of the box.
        assert!(n_off < n / 7, "{sun}: {n_off}");
    }
}

#[test]
fn nothing_is_negative_and_nothing_fails_in_thin_boxes() {
    for size in [
        DVec3::new(1.0, VOXEL_M, 1.0),
        DVec3::new(VOXEL_M, 1.0, VOXEL_M),
        DVec3::splat(VOXEL_M),
    ] {
        let thin = bricks((DVec3::ZERO, size), |_| 7.0);
        let bounds = bounds(&thin);
        for sun in suns() {
            for voxel_m in [VOXEL_M, 0.3, 50.0] {
                let sweep = sweep(&thin, bounds, (sun, voxel_m));
                for point in points(bounds, 50) {
                    let found = f64::from(sweep.at(point));
                    let most = 7.0 * way_out(bounds, point, sun);
                    assert!((0.0..=1.001 * most).contains(&found), "{sun} {point}");
                }
            }
        }
    }
}
