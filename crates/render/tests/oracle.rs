//! The renderer against a literal sum written down here, and its levels against each other.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::ScatteringTable;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::SunPath;

/// Radius and density that change in all directions, as rain under a cloud.
fn gradient(interpolation: Interpolation) -> Bricks {
    let grid = GridBox {
        min: DVec3::new(-20.0, -20.0, -70.0),
        max: DVec3::new(20.0, 20.0, -30.0),
        voxel_m: 2.5,
    };
    let field = |point: DVec3| {
        let up = (point.y + 20.0) / 40.0;
        let radius_m = 4e-4 * (1.0 - up) + 5e-5 * up;
        let wave = 1.0 + 0.6 * (0.2 * point.x).sin() * (0.13 * point.z).cos();
        Drops {
            number_density_m3: (0.02 * wave / (std::f64::consts::PI * radius_m * radius_m)) as f32,
            effective_radius_m: radius_m as f32,
            effective_variance: 0.0,
        }
    };
    let mode = DropMode::from_fn("", &grid, field).unwrap();
    Bricks::build(&mode, interpolation).unwrap()
}

fn fringes() -> ScatteringTable {
    let radii: Vec<f64> = (0..80).map(|step| 45.0 * 1.03_f64.powi(step)).collect();
    sized_table(&radii, |radius, wavelength, theta| {
        let off = theta - 2.4;
        0.02 * (1.0 + (off * (12.0 + 4.0 * radius.ln()) + wavelength as f64).sin())
    })
}

/// t at (r_e, theta), by bilinear interpolation in ln r_e and theta.
fn lookup(table: &ScatteringTable, radius_um: f64, wavelength: usize, theta: f64) -> f64 {
    let radii = &table.effective_radius_um;
    let r = radii
        .partition_point(|node| *node <= radius_um)
        .clamp(1, radii.len() - 1)
        - 1;
    let angles = &table.theta_rad;
    let a = angles
        .partition_point(|node| *node <= theta)
        .clamp(1, angles.len() - 1)
        - 1;
    let fr = (radius_um / radii[r]).ln() / (radii[r + 1] / radii[r]).ln();
    let fa = (theta - angles[a]) / (angles[a + 1] - angles[a]);
    let at = |r: usize, a: usize| {
        let [s, p] = [0, 1].map(|j| f64::from(table.values[[j, r, 0, wavelength, a]]));
        0.5 * (s + p)
    };
    (1.0 - fr) * ((1.0 - fa) * at(r, a) + fa * at(r, a + 1))
        + fr * ((1.0 - fa) * at(r + 1, a) + fa * at(r + 1, a + 1))
}

/// The integral as it is written, 20000 midpoints, f64.
fn literal(
    drops: &LitDrops,
    table: &ScatteringTable,
    origin: DVec3,
    direction: DVec3,
    sun: DVec3,
) -> f64 {
    let theta = sun.dot(direction).acos();
    let volume = &drops.bricks()[0];
    let (n, length_m) = (20_000, 120.0);
    let step_m = length_m / f64::from(n);
    let (mut sum, mut depth) = (0.0, 0.0);
    for step in 0..n {
        let sample = volume.sample(origin + (f64::from(step) + 0.5) * step_m * direction);
        if sample.m2 > 0.0 {
            let sigma = 1e-12 * std::f64::consts::PI * f64::from(sample.m2);
            let radius_um = f64::from(sample.m3) / f64::from(sample.m2);
            let dimmed = (-(depth + 0.5 * sigma * step_m) - f64::from(sample.tau_sun)).exp();
            sum += sigma * lookup(table, radius_um, 1, theta) * dimmed * step_m;
            depth += sigma * step_m;
        }
    }
    SUN[1] * sum
}

#[test]
fn deposit_and_shade_is_the_literal_sum() {
    let sun = sun_in_the_south(25.0);
    let table = fringes();
    for (interpolation, tolerance) in [
        (Interpolation::Moments, 3e-4),
        (Interpolation::RadiusDensity, 3e-3),
    ] {
        let path = SunPath::Volume { voxel_m: 2.0 };
        let drops = LitDrops::new(vec![gradient(interpolation)], sun, path).unwrap();
        let camera = camera(DVec3::new(3.0, -5.0, 0.0), (2.0, 5.0), 50.0, (7, 5));
        let mut request = request(&camera, sun, &drops, &table);
        request.effects = with_shadow();
        let picture = rendered(&request);
        let peak = f64::from(picture.radiance.iter().copied().fold(0.0, f32::max));
        for y in 0..5_u32 {
            for x in 0..7_u32 {
                let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5).unwrap();
                let expected = literal(&drops, &table, ray.origin, ray.direction, sun);
                let found = f64::from(picture.radiance[[1, y as usize, x as usize]]);
                let error = (found - expected).abs() / peak;
                assert!(error < tolerance, "{interpolation:?} {x} {y}: {error}");
            }
        }
    }
}

#[test]
fn a_smaller_tolerance_never_makes_the_picture_worse() {
    let sun = sun_in_the_south(25.0);
    let table = fringes();
    let path = SunPath::Volume { voxel_m: 2.0 };
    let drops = LitDrops::new(vec![gradient(Interpolation::Moments)], sun, path).unwrap();
    let camera = camera(DVec3::new(3.0, -5.0, 0.0), (2.0, 5.0), 50.0, (32, 24));
    let mut request = request(&camera, sun, &drops, &table);
    request.effects = with_shadow();
    let mut picture = |relative_error: f64| {
        request.levels.integration = Integration::Adaptive { relative_error };
        rendered(&request).radiance
    };
    let reference = picture(1e-10);
    let norm: f32 = reference.iter().map(|value| value * value).sum();
    let mut last = f32::INFINITY;
    for relative_error in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
        let found = picture(relative_error);
        let sum: f32 = found
            .iter()
            .zip(&reference)
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        let error = (sum / norm).sqrt();
        assert!(error < relative_error as f32, "{error} of {relative_error}");
        assert!(error <= last + 1e-6, "{error} after {last}");
        last = error;
    }
}

#[test]
fn a_prefiltered_pixel_is_the_mean_of_many_rays() {
    let sun = sun_in_the_south(25.0);
    let table = table(|_, theta| 0.02 * (1.0 + (120.0 * theta).sin()));
    let grid = GridBox {
        min: DVec3::new(-40.0, -40.0, -70.0),
        max: DVec3::new(40.0, 40.0, -30.0),
        voxel_m: 10.0,
    };
    let drops = LitDrops::new(vec![bricks(&grid, |_| 1e-3)], sun, SunPath::Ignore).unwrap();
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 24.0, (24, 18));
    let mut request = request(&camera, sun, &drops, &table);
    let mut picture = |footprint| {
        request.levels.pixel_footprint = footprint;
        rendered(&request)
    };
    let reference = picture(PixelFootprint::Grid { n: 8 }).radiance;
    let mut error = |footprint| {
        let found = picture(footprint).radiance;
        let peak = reference.iter().copied().fold(0.0, f32::max);
        let sum: f32 = found
            .iter()
            .zip(&reference)
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        (sum / reference.len() as f32).sqrt() / peak
    };
    let center = error(PixelFootprint::Center);
    let prefiltered = error(PixelFootprint::Prefiltered);
    println!("center {center:.1e} prefiltered {prefiltered:.1e}");
    assert!(prefiltered < 0.15 * center, "{prefiltered} of {center}");
}

#[test]
fn the_estimate_covers_the_error_of_pixel_centers() {
    let sun = sun_in_the_south(25.0);
    let table = fringes();
    let path = SunPath::Volume { voxel_m: 2.0 };
    let drops = LitDrops::new(vec![gradient(Interpolation::Moments)], sun, path).unwrap();
    let camera = camera(DVec3::new(3.0, -5.0, 0.0), (2.0, 5.0), 30.0, (24, 18));
    let mut request = request(&camera, sun, &drops, &table);
    request.effects = with_shadow();
    let center = rendered(&request);
    request.levels.pixel_footprint = PixelFootprint::Grid { n: 6 };
    let fine = rendered(&request);
    let luminance = |picture: &niji_render::Rendered, y: usize, x: usize| {
        picture[PictureLayer::BowPrimary][[1, y, x]]
            + picture[PictureLayer::BowSecondary][[1, y, x]]
    };
    let (mut n_covered, mut n) = (0, 0);
    for y in 1..17 {
        for x in 1..23 {
            let error = (luminance(&center, y, x) - luminance(&fine, y, x)).abs();
            if error > 1e-4 * luminance(&fine, y, x) {
                n += 1;
                n_covered += usize::from(error <= 2.0 * center.error_from("Y").unwrap()[[y, x]]);
            }
        }
    }
    println!("{n_covered} of {n}");
    assert!(n > 20 && n_covered * 10 >= n * 9, "{n_covered} of {n}");
}
