//! Volumes that several tests use.

use glam::DVec3;

use crate::DropMode;
use crate::Drops;
use crate::GridBox;

/// A pseudo-random number in 0..1, the same for the same seed (splitmix64).
pub(crate) fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A point with coordinates in -1..1.
pub(crate) fn random_point(seed: &mut u64) -> DVec3 {
    2.0 * DVec3::new(random(seed), random(seed), random(seed)) - 1.0
}

/// A box of 19 x 10 x 8 voxels of 2 m away from the origin.
pub(crate) fn grid() -> GridBox {
    let min = DVec3::new(-7.0, 3.0, 100.0);
    GridBox {
        min,
        max: min + DVec3::new(38.0, 20.0, 16.0),
        voxel_m: 2.0,
    }
}

/// Drops that vary everywhere, smoothly.
pub(crate) fn varied(position: DVec3) -> Drops {
    let wave = (0.3 * position.x).sin() * (0.2 * position.y).cos();
    Drops {
        number_density_m3: (600.0 + 300.0 * wave) as f32,
        effective_radius_m: (5e-4 - 3e-4 * (0.1 * position.z).sin()) as f32,
        effective_variance: (0.1 + 0.05 * wave) as f32,
    }
}

/// A few small clouds far apart, with most of the box empty.
pub(crate) fn sparse() -> DropMode {
    let centers = [
        DVec3::new(6.0, 6.0, 6.0),
        DVec3::new(50.0, 20.0, 30.0),
        DVec3::new(9.0, 57.0, 40.0),
    ];
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(64.0),
        voxel_m: 1.0,
    };
    DropMode::from_fn("", &grid, |position| {
        let near = centers.iter().any(|center| center.distance(position) < 5.0);
        if near { varied(position) } else { Drops::NONE }
    })
    .unwrap()
}
