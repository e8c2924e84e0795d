//! What is told of the error of shadows, against shadows of the same drops that are far finer.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Axis;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::Rendered;
use niji_render::SunPath;

fn luminance(picture: &Rendered) -> Vec<f64> {
    let [primary, secondary] = [PictureLayer::BowPrimary, PictureLayer::BowSecondary]
        .map(|bow| picture[bow].index_axis(Axis(0), 1).mapv(f64::from));
    (primary + secondary).into_iter().collect()
}

/// Drops by their extinction at Q = 1 in a box from 0 to `size_m`.
struct Field {
    name: &'static str,
    size_m: DVec3,
    extinction_m1: fn(DVec3) -> f64,
}

const FLAT: DVec3 = DVec3::new(3.0, 1.0, 3.0);

const FIELDS: [Field; 8] = [
    Field {
        name: "slab",
        size_m: FLAT,
        extinction_m1: |_| 1.0,
    },
    Field {
        name: "exponential",
        size_m: FLAT,
        extinction_m1: |p| 3.0 * (-4.0 * p.y).exp(),
    },
    Field {
        name: "linear",
        size_m: FLAT,
        extinction_m1: |p| 2.0 * (1.0 - p.y),
    },
    Field {
        name: "layers",
        size_m: FLAT,
        extinction_m1: |p| if p.y < 0.4 { 2.0 } else { 0.4 },
    },
    Field {
        name: "sphere",
        size_m: DVec3::ONE,
        extinction_m1: |p| {
            if p.distance(DVec3::splat(0.5)) < 0.4 {
                3.0
            } else {
                0.0
            }
        },
    },
    Field {
        name: "smooth sphere",
        size_m: DVec3::ONE,
        extinction_m1: |p| 5.0 * (-30.0 * p.distance_squared(DVec3::splat(0.5))).exp(),
    },
    Field {
        name: "cone",
        size_m: DVec3::ONE,
        extinction_m1: |p| if from_axis(p) < 0.45 * p.y { 3.0 } else { 0.0 },
    },
    Field {
        name: "smooth cone",
        size_m: DVec3::ONE,
        extinction_m1: |p| 4.0 * (-(from_axis(p) / (0.05 + 0.2 * p.y)).powi(2)).exp(),
    },
];

fn from_axis(point: DVec3) -> f64 {
    (point.x - 0.5).hypot(point.z - 0.5)
}

/// A field at `n` nodes a metre; `finer` times as many of the same interpolant.
fn field_bricks(field: &Field, n: u32, finer: u32) -> Bricks {
    let voxel_m = 1.0 / f64::from(n);
    let grid = GridBox {
        min: DVec3::ZERO,
        max: field.size_m,
        voxel_m,
    };
    let coarse = bricks(&grid, field.extinction_m1);
    if finer == 1 {
        return coarse;
    }
    // Nodes among which are those of the coarse one: `finer` is odd.
    let grid = GridBox {
        min: grid.min - 3.0 * voxel_m,
        max: grid.max + 3.0 * voxel_m,
        voxel_m: voxel_m / f64::from(finer),
    };
    let held = |point: DVec3| Drops {
        number_density_m3: coarse.sample(point).m2 / (1e12 * RADIUS_M * RADIUS_M) as f32,
        ..drops(0.0)
    };
    let mode = DropMode::from_fn("", &grid, held).unwrap();
    Bricks::build(&mode, Interpolation::Moments).unwrap()
}

/// Told over true error of all rays that err by more than 3e-6 of the brightest.
fn ratios(field: &Field, sun: DVec3, (n, finer): (u32, u32)) -> Vec<f64> {
    let eye = 0.5 * field.size_m + DVec3::new(0.0, 0.35, 3.0 * field.size_m.z);
    let camera = camera(eye, (0.0, -8.0), 25.0, (30, 14));
    let [fine, found] = [finer, 1].map(|finer| {
        let voxel_m = 1.0 / f64::from(n * finer);
        let volume = field_bricks(field, n, finer);
        let drops = LitDrops::new(vec![volume], sun, SunPath::Volume { voxel_m }).unwrap();
        shaded(&drops, sun, &camera)
    });
    let told = found.error_from("shadow").unwrap();
    let (fine, found) = (luminance(&fine), luminance(&found));
    let peak = fine.iter().copied().fold(0.0, f64::max);
    let errors = fine.iter().zip(&found).map(|(a, b)| (a - b).abs());
    errors
        .zip(&told)
        .filter(|(error, _)| *error > 3e-6 * peak)
        .map(|(error, told)| f64::from(*told) / error)
        .collect()
}

/// Part of the ratios that are at least 1, and their median.
fn covered_and_median(mut ratios: Vec<f64>) -> (f64, f64) {
    ratios.sort_by(f64::total_cmp);
    let n_covered = ratios.iter().filter(|ratio| **ratio >= 1.0).count();
    let covered = n_covered as f64 / ratios.len() as f64;
    (covered, ratios[ratios.len() / 2])
}

#[test]
fn what_is_told_covers_the_error_under_any_sun_and_is_seldom_far_above_it() {
    let mut all = Vec::new();
    for field in &FIELDS {
        let mut of_field = Vec::new();
        for (index, elevation_deg) in [5.0_f64, 10.0, 30.0, 60.0, 80.0].into_iter().enumerate() {
            // Azimuths in the golden angle.
            let azimuth_rad = 2.4 * (all.len() % 97 + index) as f64;
            let (sin, cos) = elevation_deg.to_radians().sin_cos();
            let sun = DVec3::new(cos * azimuth_rad.sin(), sin, cos * azimuth_rad.cos());
            for nodes in [(4, 5), (8, 5), (16, 3)] {
                of_field.extend(ratios(field, sun, nodes));
            }
        }
        let (covered, median) = covered_and_median(of_field.clone());
        println!("{}: covered {covered:.3}, median {median:.1}", field.name);
        assert!(
            covered > 0.92 && median < 6.0,
            "{}: {covered} {median}",
            field.name
        );
        all.extend(of_field);
    }
    let (covered, median) = covered_and_median(all);
    println!("all: covered {covered:.3}, median {median:.1}");
    assert!(covered > 0.98 && median < 5.0, "{covered} {median}");
}

#[test]
fn what_is_told_covers_a_low_sun_on_a_flat_topped_slab() {
    for (zenith_deg, n) in [60.0, 80.0, 85.0]
        .into_iter()
        .flat_map(|zenith_deg| [8, 16, 32, 64].map(|n| (zenith_deg, n)))
    {
        let slab = flat_topped_slab(zenith_deg, n);
        let sun = sun_in_the_south(90.0 - zenith_deg);
        let voxel_m = slab.voxel_m;
        let drops = LitDrops::new(
            vec![bricks(&slab, |_| 1.0)],
            sun,
            SunPath::Volume { voxel_m },
        );
        let picture = shaded(&drops.unwrap(), sun, &from_above(&slab));
        let both = 1.0 + 1.0 / zenith_deg.to_radians().cos();
        let expected = SUN[0] * SHADED_SR1 * -(-both).exp_m1() / both;
        let error = relative(f64::from(picture.radiance[[0, 0, 0]]), expected);
        let told = picture.error_from("shadow").unwrap()[[0, 0]];
        let told = f64::from(told) / luminance(&picture)[0];
        println!("{zenith_deg} {n}: {error:.1e}, told {told:.1e}");
        assert!(
            error < told && told < 15.0 * error,
            "{zenith_deg} {n}: {error} {told}"
        );
    }
}
