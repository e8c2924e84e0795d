//! What a sample and a cell cost, in a volume that fits the cache and in one that does not.
//!
//! `cargo bench -p niji-dropfield`. Samples go through `black_box`, so that none is optimized away;
//! a time is for 4096 samples or for one ray.

use divan::Bencher;
use divan::black_box;
use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;

const N_SAMPLES: usize = 4096;
const LEVELS: [Interpolation; 2] = [Interpolation::Moments, Interpolation::RadiusDensity];

fn main() {
    divan::main();
}

/// A gradient over a cube of so many voxels.
fn bricks(n_voxels: u32, interpolation: Interpolation) -> Bricks {
    let size = f64::from(n_voxels);
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(size),
        voxel_m: 1.0,
    };
    let field = |position: DVec3| Drops {
        number_density_m3: 1000.0,
        effective_radius_m: (1e-5 + 1.5e-3 * position.y / size) as f32,
        effective_variance: 0.0,
    };
    let mode = DropMode::from_fn("", &grid, field).expect("the grid is sound");
    Bricks::build(&mode, interpolation).expect("the volume is small")
}

/// A number in 0..1 that depends on an index alone (golden ratio sequence per axis).
fn scattered(index: usize, n_voxels: u32) -> DVec3 {
    let step = DVec3::new(0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9);
    (step * index as f64).fract() * f64::from(n_voxels)
}

#[divan::bench(args = LEVELS, consts = [64, 256])]
fn coherent_samples<const N: u32>(bencher: Bencher, interpolation: Interpolation) {
    let bricks = bricks(N, interpolation);
    let step = DVec3::new(0.9, 0.3, 0.2).normalize() * f64::from(N) / N_SAMPLES as f64;
    bencher.bench_local(|| {
        (0..N_SAMPLES)
            .map(|index| bricks.sample(black_box(step * index as f64)).m2)
            .sum::<f32>()
    });
}

#[divan::bench(args = LEVELS, consts = [64, 256])]
fn random_samples<const N: u32>(bencher: Bencher, interpolation: Interpolation) {
    let bricks = bricks(N, interpolation);
    bencher.bench_local(|| {
        (0..N_SAMPLES)
            .map(|index| bricks.sample(black_box(scattered(index, N))).m2)
            .sum::<f32>()
    });
}

/// All cells of a diagonal, with one sample each or none.
#[divan::bench(args = LEVELS, consts = [0, 1])]
fn cells_of_a_ray<const SAMPLES: usize>(bencher: Bencher, interpolation: Interpolation) {
    let bricks = bricks(64, interpolation);
    let direction = DVec3::new(0.9, 0.7, 0.6).normalize();
    bencher.bench_local(|| {
        bricks
            .segments(black_box(DVec3::splat(-10.0)), direction, (0.0, 1e3))
            .map(|cell| {
                let length = (cell.t_exit - cell.t_enter) as f32;
                if SAMPLES == 0 {
                    length
                } else {
                    length * cell.sample(0.5).m2
                }
            })
            .sum::<f32>()
    });
}
