//! What a sample and a cell cost, in a volume that fits the cache and in one that does not.
//!
//! `cargo bench -p niji-dropfield`. Samples go through `black_box`, so that none is optimized away;
//! a time is for 4096 samples or for one ray. Printed beside the times: how far samples are from the
//! trilinear interpolant in f64.

use std::sync::LazyLock;

use divan::Bencher;
use divan::black_box;
use glam::DVec3;
use niji_dropfield::AreaMoments;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;

const N_SAMPLES: usize = 4096;
const LEVELS: [Interpolation; 2] = [Interpolation::Moments, Interpolation::RadiusDensity];
const VOLUMES: [Volume; 2] = [Volume::Gradient64, Volume::Sparse512];

/// A volume to sample.
#[derive(Debug, Clone, Copy)]
enum Volume {
    /// Drops everywhere, 8 MB of bricks.
    Gradient64,
    /// Clouds in a twentieth of the box, 160 MB of bricks.
    Sparse512,
}

/// Each volume, laid out for each level.
static BRICKS: LazyLock<[[Bricks; 2]; 2]> = LazyLock::new(|| {
    VOLUMES.map(|volume| {
        let mode = mode(volume);
        let bricks = LEVELS.map(|level| Bricks::build(&mode, level).expect("the volume is small"));
        let error = worst_error(volume, &mode, &bricks[0]);
        let megabytes = bricks[0].memory_bytes() >> 20;
        println!(
            "{volume:?}: {} bricks, {megabytes} MB, M2 within {error:.1e} of f64",
            bricks[0].n_bricks()
        );
        bricks
    })
});

fn main() {
    LazyLock::force(&BRICKS);
    divan::main();
}

fn bricks(volume: Volume, interpolation: Interpolation) -> &'static Bricks {
    &BRICKS[volume as usize][usize::from(interpolation == LEVELS[1])]
}

fn size(volume: Volume) -> f64 {
    match volume {
        Volume::Gradient64 => 64.0,
        Volume::Sparse512 => 512.0,
    }
}

fn mode(volume: Volume) -> DropMode {
    let size = size(volume);
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(size),
        voxel_m: 1.0,
    };
    // The clouds touch the diagonal, so that a ray along it meets all of them.
    let clouds = (0..11).map(|cloud| {
        let along = DVec3::splat(60.0 + 39.0 * f64::from(cloud));
        along + 12.0 * (2.0 * scattered(cloud as usize, 1.0) - 1.0)
    });
    let clouds = clouds.collect::<Vec<_>>();
    let field = |position: DVec3| {
        let inside = match volume {
            Volume::Gradient64 => true,
            Volume::Sparse512 => clouds.iter().any(|cloud| cloud.distance(position) < 52.0),
        };
        let effective_radius_m = (1e-5 + 1.5e-3 * position.y / size) as f32;
        let drops = Drops {
            number_density_m3: 1000.0,
            effective_radius_m,
            effective_variance: 0.0,
        };
        if inside { drops } else { Drops::NONE }
    };
    DropMode::from_fn("", &grid, field).expect("the grid is sound")
}

/// Largest error of M2 at the random points, relative to the largest M2.
fn worst_error(volume: Volume, mode: &DropMode, bricks: &Bricks) -> f64 {
    let m2 = |node: [i32; 3]| f64::from(AreaMoments::from_drops(&mode.drops(node)).m2);
    let largest = 1000.0 * 1510.0 * 1510.0;
    let errors = (0..N_SAMPLES).map(|index| {
        let position = scattered(index, size(volume));
        let lattice = (position - mode.origin_m()) / mode.voxel_m();
        let (low, t) = (lattice.floor(), lattice.fract_gl());
        let corners = (0..8).map(|corner| {
            let upper = DVec3::new(
                f64::from(corner >> 2),
                f64::from(corner >> 1 & 1),
                f64::from(corner & 1),
            );
            let weight = upper * t + (1.0 - upper) * (1.0 - t);
            weight.element_product() * m2((low + upper).as_ivec3().to_array())
        });
        (f64::from(bricks.sample(position).m2) - corners.sum::<f64>()).abs() / largest
    });
    errors.fold(0.0, f64::max)
}

/// A point that depends on an index alone (golden ratio sequence per axis).
fn scattered(index: usize, size: f64) -> DVec3 {
    let step = DVec3::new(0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9);
    (step * index as f64).fract() * size
}

#[divan::bench(args = VOLUMES, consts = [0, 1])]
fn coherent_samples<const LEVEL: usize>(bencher: Bencher, volume: Volume) {
    let bricks = bricks(volume, LEVELS[LEVEL]);
    // Half a voxel a step, along the diagonal.
    let step = 0.5 * DVec3::new(1.0, 1.01, 0.99).normalize();
    let n_steps = (size(volume) * 1.5) as usize;
    bencher.bench_local(|| {
        (0..N_SAMPLES)
            .map(|index| bricks.sample(black_box(step * (index % n_steps) as f64)).m2)
            .sum::<f32>()
    });
}

#[divan::bench(args = VOLUMES, consts = [0, 1])]
fn random_samples<const LEVEL: usize>(bencher: Bencher, volume: Volume) {
    let bricks = bricks(volume, LEVELS[LEVEL]);
    let mut start = 0;
    bencher.bench_local(|| {
        // Other points each time, so that the caches do not learn them.
        start += N_SAMPLES;
        (start..start + N_SAMPLES)
            .map(|index| bricks.sample(black_box(scattered(index, size(volume)))).m2)
            .sum::<f32>()
    });
}

/// All cells of a diagonal, with one sample each or none.
#[divan::bench(args = LEVELS, consts = [0, 1])]
fn cells_of_a_ray<const SAMPLES: usize>(bencher: Bencher, interpolation: Interpolation) {
    let bricks = bricks(Volume::Gradient64, interpolation);
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
