//! Light that drops scatter more than once, against photons followed one by one, against the integral
//! equation of a slab, and in its limits.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

#[path = "../common/mod.rs"]
mod common;
mod paths;
mod slab_photons;

use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use common::*;
use glam::DVec3;
use ndarray::Axis;
use niji_dropfield::GridBox;
use niji_exchange::ScatteringTable;
use niji_geometry::Camera;
use niji_geometry::PixelRegion;
use niji_render::Deadline;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::Progress;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::STANDARD_ERRORS;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::render;
use niji_render::render_in_strips;
use slab_photons::Slab;
use slab_photons::all_orders;

/// The sun of all tests here.
const ZENITH: DVec3 = DVec3::Y;

/// Green light of the tests' wavelengths [um].
const GREEN_UM: f64 = 0.55;

/// All orders against photons; measured at most 2.7 %, 1 % of it the chance of both.
const PHOTON_TOLERANCE: f64 = 0.03;

/// The bow's excess in the first order against all orders, measured 1 and 4 %.
const EXCESS_TOLERANCE: f64 = 0.05;

/// All orders against the integral equation, measured 0.8 %.
const EQUATION_TOLERANCE: f64 = 0.015;

/// A bow, a fainter one beyond a dark band, and light straight through: about as drops of water do it.
fn bow_like(theta: f64) -> f64 {
    let deg = theta.to_degrees();
    let bow = 0.9 * (-0.5 * ((deg - 139.5) / 1.2).powi(2)).exp();
    let inside = 0.28 / (1.0 + (-(deg - 139.5) / 0.5).exp());
    let outside = 0.12 / (1.0 + (deg - 127.0).exp());
    let forward = 30.0 * (-theta / 0.35).exp();
    0.04 * (bow + inside + outside) + 0.02 * forward + 0.004
}

/// What makes its integral over the sphere 1.
fn norm() -> f64 {
    let n = 20_000;
    let step = PI / f64::from(n);
    let ring = |theta: f64| TAU * theta.sin() * bow_like(theta) * step;
    let middles = (0..n).map(|index| (f64::from(index) + 0.5) * step);
    1.0 / middles.map(ring).sum::<f64>()
}

fn bow_table() -> ScatteringTable {
    let norm = norm();
    table(|_, theta| norm * bow_like(theta))
}

/// Drops of one size in a box `half_m` wide to each side of the middle and 4 m thick.
fn slab(depth_q1: f64, half_m: f64, voxel_m: f64) -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-half_m, -2.0, -half_m),
        max: DVec3::new(half_m, 2.0, half_m),
        voxel_m,
    };
    let path = SunPath::Volume {
        voxel_m: 0.5 * voxel_m,
    };
    LitDrops::new(vec![bricks(&grid, |_| depth_q1 / 4.0)], ZENITH, path).unwrap()
}

/// A slab so wide that light does not leave at its sides: thin ones let it fly far.
fn wide_slab(depth_q1: f64) -> LitDrops {
    if depth_q1 < 0.3 {
        slab(depth_q1, 160.0, 1.0)
    } else {
        slab(depth_q1, 60.0, 0.5)
    }
}

/// One ray from above the slab, `angle_deg` from straight down.
fn looking_down(angle_deg: f64) -> Camera {
    let position = DVec3::new(0.0, 10.0, 10.0 * angle_deg.to_radians().tan());
    camera(position, (0.0, angle_deg - 90.0), 1e-3, (1, 1))
}

/// One ray from below the slab, `angle_deg` from straight up.
fn looking_up(angle_deg: f64) -> Camera {
    let position = DVec3::new(0.0, -10.0, 10.0 * angle_deg.to_radians().tan());
    camera(position, (0.0, 90.0 - angle_deg), 1e-3, (1, 1))
}

fn request_of_all_orders<'a>(
    camera: &'a Camera,
    drops: &'a LitDrops,
    table: &'a ScatteringTable,
    (nodes_across, paths_per_node): (usize, usize),
) -> RenderRequest<'a> {
    let mut request = request(camera, ZENITH, drops, table);
    request.effects = with_shadow();
    request.levels.drop_orders = DropOrders::MultipleScattering {
        nodes_across,
        paths_per_node,
    };
    request
}

/// Green radiance over irradiance of the first pixel [1/sr].
fn green(picture: &Rendered) -> f64 {
    f64::from(picture.radiance[[1, 0, 0]]) / SUN[1]
}

/// All orders and the first one on one ray.
fn both(camera: &Camera, drops: &LitDrops, table: &ScatteringTable, n_paths: usize) -> [f64; 2] {
    let mut request = request_of_all_orders(camera, drops, table, (2, n_paths));
    let all = green(&rendered(&request));
    request.levels.drop_orders = DropOrders::SingleScattering;
    [all, green(&rendered(&request))]
}

#[test]
fn all_orders_are_those_of_photons_followed_one_by_one() {
    let angles_deg = [32.0, 40.5, 45.0, 60.0];
    let (norm, table) = (norm(), bow_table());
    // The thinner the slab, the fewer drops on a path, and the fewer paths with any.
    for (depth_q2, n_photons, n_paths) in [
        (0.3, 500_000, 32_768),
        (1.0, 250_000, 8192),
        (4.0, 80_000, 8192),
    ] {
        let photons = all_orders(&Slab {
            depth: depth_q2,
            phase_sr1: &|theta| norm * bow_like(theta),
            size_parameter: TAU * 1e6 * RADIUS_M / GREEN_UM,
            view_angles_deg: &angles_deg,
            n_photons,
        });
        let drops = wide_slab(0.5 * depth_q2);
        let found = angles_deg.map(|angle| both(&looking_down(angle), &drops, &table, n_paths));
        for ((angle, [all, _]), expected) in angles_deg.iter().zip(found).zip(&photons) {
            let error = relative(all, *expected);
            assert!(error < PHOTON_TOLERANCE, "{depth_q2} {angle}: {error}");
        }
        if depth_q2 <= 1.0 {
            let first = found[1][1] - found[2][1];
            let error = relative(first, photons[1] - photons[2]);
            assert!(error < EXCESS_TOLERANCE, "{depth_q2}: {error}");
        }
    }
}

/// int_0^1 exp(-x/mu) dmu.
fn exponential_integral_2(x: f64) -> f64 {
    let n = 2000;
    (0..n)
        .map(|index| (-x * f64::from(n) / (f64::from(index) + 0.5)).exp())
        .sum::<f64>()
        / f64::from(n)
}

/// Source function of isotropic conservative drops in a slab under the zenith sun, cell by cell:
/// S(tau) = exp(-tau)/(4 pi) + 1/2 int E1(|tau - tau'|) S dtau'.
fn isotropic_source(depth: f64) -> Vec<f64> {
    let n: usize = 100;
    let step = depth / n as f64;
    let e2: Vec<f64> = (0..2 * n)
        .map(|half| exponential_integral_2(0.5 * step * half as f64))
        .collect();
    let kernel = |distance: usize| match distance {
        0 => 1.0 - e2[1],
        distance => 0.5 * (e2[2 * distance - 1] - e2[2 * distance + 1]),
    };
    let kernel: Vec<f64> = (0..n).map(kernel).collect();
    let first: Vec<f64> = (0..n)
        .map(|cell| (-(cell as f64 + 0.5) * step).exp() / (4.0 * PI))
        .collect();
    let mut source = first.clone();
    for _ in 0..100 {
        source = (0..n)
            .map(|cell| {
                let others = source.iter().enumerate();
                first[cell]
                    + others
                        .map(|(other, value)| kernel[cell.abs_diff(other)] * value)
                        .sum::<f64>()
            })
            .collect();
    }
    source
}

#[test]
fn isotropic_light_solves_the_integral_equation_of_a_slab() {
    let table = isotropic(0.25 / PI);
    for depth in [0.5, 2.0] {
        let source = isotropic_source(depth);
        let step = depth / source.len() as f64;
        let drops = wide_slab(depth);
        for angle_deg in [0.0_f64, 60.0] {
            let cosine = angle_deg.to_radians().cos();
            let through = |edge: usize| (-(edge as f64) * step / cosine).exp();
            let cells = source.iter().enumerate();
            let expected: f64 = cells
                .map(|(cell, value)| value * (through(cell) - through(cell + 1)))
                .sum();
            let [all, _] = both(&looking_down(angle_deg), &drops, &table, 8192);
            let error = relative(all, expected);
            assert!(error < EQUATION_TOLERANCE, "{depth} {angle_deg}: {error}");
        }
    }
}

#[test]
fn all_sunlight_that_falls_on_a_slab_leaves_it() {
    let table = bow_table();
    let drops = wide_slab(1.0);
    // Gauss nodes of mu on 0..1; light leaves at most angles, little of it at grazing ones.
    let nodes = [
        (0.069_431_844_202_973_7, 0.173_927_422_568_727),
        (0.330_009_478_207_572, 0.326_072_577_431_273),
        (0.669_990_521_792_428, 0.326_072_577_431_273),
        (0.930_568_155_797_026, 0.173_927_422_568_727),
    ];
    let mut leaves = (-1.0_f64).exp();
    for (cosine, weight) in nodes {
        let angle_deg = f64::acos(cosine).to_degrees();
        for camera in [looking_down(angle_deg), looking_up(angle_deg)] {
            let [all, _] = both(&camera, &drops, &table, 4096);
            leaves += TAU * weight * cosine * all;
        }
    }
    // Four nodes for the bow and the forward peak; measured 1 %.
    assert!((leaves - 1.0).abs() < 0.04, "{leaves}");
}

/// Drops in a cube of 8 m.
fn cube(extinction_m1: f64) -> LitDrops {
    let grid = GridBox {
        min: DVec3::splat(-4.0),
        max: DVec3::splat(4.0),
        voxel_m: 1.0,
    };
    let path = SunPath::Volume { voxel_m: 0.5 };
    LitDrops::new(vec![bricks(&grid, |_| extinction_m1)], ZENITH, path).unwrap()
}

#[test]
fn the_second_order_vanishes_in_proportion_to_the_optical_depth() {
    let table = bow_table();
    let camera = looking_down(45.0);
    let ratio = |extinction_m1: f64| {
        let [all, first] = both(&camera, &cube(extinction_m1), &table, 8192);
        all / first - 1.0
    };
    let (thin, thinner) = (ratio(2e-3), ratio(1e-3));
    assert!(thinner < 0.05, "{thinner}");
    // The same paths: measured 2 %.
    assert!(relative(thin, 2.0 * thinner) < 0.1, "{thin} {thinner}");
}

#[test]
fn both_models_of_extinction_come_to_the_same_light() {
    let table = bow_table();
    let drops = cube(0.2);
    for angle_deg in [30.0, 40.5, 42.0, 50.0] {
        let camera = looking_down(angle_deg);
        let mut request = request_of_all_orders(&camera, &drops, &table, (2, 16));
        let without = green(&rendered(&request));
        request.levels.drop_extinction_model = DropExtinctionModel::Full;
        let full = green(&rendered(&request));
        // f32; measured 4e-7.
        assert!(relative(full, without) < 1e-5, "{full} {without}");
    }
}

#[test]
fn what_diffraction_changes_out_of_sight_is_left_out_and_told() {
    let (table, drops) = (bow_table(), cube(0.3));
    // From the antisolar point past the bow, 0.2 degrees a pixel.
    let position = DVec3::new(0.0, 10.0, 10.0);
    let camera = camera(position, (0.0, -60.0), 60.0, (300, 1));
    let luminance = |picture: &Rendered| {
        let light = picture[PictureLayer::BowMultiple].index_axis(Axis(0), 1);
        light.mapv(f64::from)
    };
    let told = |picture: &Rendered| picture.error_from("orders").unwrap().mapv(f64::from);
    let mut request = request_of_all_orders(&camera, &drops, &table, (2, 64));
    // With a tolerance, too, each pixel has a ray of its own.
    request.levels.pixel_footprint = PixelFootprint::Grid { n: 1 };
    let whole = rendered(&request);
    let first_order = whole[PictureLayer::BowPrimary].iter().copied();
    let peak = f64::from(first_order.fold(0.0, f32::max));
    for tolerance in [0.1, 0.02] {
        request.tolerance_cd_m2 = Some(tolerance * peak);
        let picture = rendered(&request);
        let changes = luminance(&picture) - luminance(&whole);
        let more_told = told(&picture) - told(&whole);
        let n_changed = changes.iter().filter(|it| **it != 0.0).count();
        // The bow is as it was.
        assert!((30..270).contains(&n_changed), "{tolerance}: {n_changed}");
        for ((change, more), told) in changes.iter().zip(&more_told).zip(&told(&picture)) {
            let unseen = 0.1 * tolerance * peak;
            assert!(
                change.abs() <= unseen && *more >= 0.0,
                "{tolerance}: {change}"
            );
            assert!(change.abs() <= *told, "{tolerance}: {change} {told}");
        }
    }
}

/// A small picture of a slab with the bow in it.
fn wide_camera() -> Camera {
    camera(DVec3::new(0.0, 12.0, 10.0), (0.0, -50.0), 60.0, (12, 9))
}

#[test]
fn the_parts_of_the_light_sum_to_the_radiance_and_off_is_what_it_was() {
    let table = bow_table();
    let drops = cube(0.3);
    let camera = wide_camera();
    let mut request = request_of_all_orders(&camera, &drops, &table, (4, 32));
    let all = rendered(&request);
    request.levels.drop_orders = DropOrders::SingleScattering;
    let first = rendered(&request);
    assert!(first.layer(PictureLayer::BowMultiple).is_none());
    assert_eq!(
        all[PictureLayer::BowPrimary],
        first[PictureLayer::BowPrimary]
    );
    assert_eq!(
        all[PictureLayer::BowSecondary],
        first[PictureLayer::BowSecondary]
    );
    assert_eq!(
        all[PictureLayer::Transmittance],
        first[PictureLayer::Transmittance]
    );
    let sum = all.radiance.sum() - first.radiance.sum();
    assert!(sum > 0.0);
}

#[test]
fn one_voxel_no_drops_and_an_eye_inside_are_no_trouble() {
    let table = bow_table();
    let camera = wide_camera();
    let nothing = LitDrops::none();
    let picture = rendered(&request_of_all_orders(&camera, &nothing, &table, (4, 32)));
    assert!(
        picture.layer(PictureLayer::BowMultiple).is_none()
            && picture.radiance.iter().all(|value| *value == 0.0)
    );
    let grid = GridBox {
        min: DVec3::splat(-0.5),
        max: DVec3::splat(0.5),
        voxel_m: 1.0,
    };
    let path = SunPath::Volume { voxel_m: 0.5 };
    let voxel = LitDrops::new(vec![bricks(&grid, |_| 1.0)], ZENITH, path).unwrap();
    let picture = rendered(&request_of_all_orders(&camera, &voxel, &table, (4, 32)));
    assert!(
        picture[PictureLayer::BowMultiple]
            .iter()
            .any(|value| *value > 0.0)
    );
    // Solid and inside: nearly all that is seen was scattered many times.
    let inside = common::camera(DVec3::ZERO, (0.0, -40.0), 80.0, (5, 4));
    for extinction_m1 in [1e-12, 0.3, 30.0] {
        let drops = cube(extinction_m1);
        let picture = rendered(&request_of_all_orders(&inside, &drops, &table, (3, 16)));
        assert!(
            picture
                .radiance
                .iter()
                .all(|value| value.is_finite() && *value >= 0.0)
        );
    }
}

#[test]
fn two_halves_of_the_drops_are_as_bright_as_the_whole() {
    let table = bow_table();
    let camera = looking_down(45.0);
    let grid = GridBox {
        min: DVec3::splat(-4.0),
        max: DVec3::splat(4.0),
        voxel_m: 1.0,
    };
    let path = SunPath::Volume { voxel_m: 0.5 };
    let halves = vec![bricks(&grid, |_| 0.1), bricks(&grid, |_| 0.1)];
    let halves = LitDrops::new(halves, ZENITH, path).unwrap();
    let [two, _] = both(&camera, &halves, &table, 4096);
    let [one, _] = both(&camera, &cube(0.2), &table, 4096);
    // Paths part where a bound is rounded otherwise; measured 1e-3.
    assert!(relative(two, one) < 0.02, "{two} {one}");
}

#[test]
fn a_table_that_holds_the_diffracted_light_makes_the_same_further_orders() {
    let norm = norm();
    let sharp = table(|_, theta| norm * bow_like(theta));
    // A lobe of 0.4 degrees that holds as much light as all the rest.
    let width = 0.4_f64.to_radians();
    let lobe = |theta: f64| (-0.5 * (theta / width).powi(2)).exp() / (TAU * width * width);
    let whole = table(|_, theta| norm * bow_like(theta) + lobe(theta));
    let drops = cube(0.3);
    let camera = looking_down(45.0);
    let [without, _] = both(&camera, &drops, &sharp, 4096);
    let [with, _] = both(&camera, &drops, &whole, 4096);
    // What of the forward light lies below the plateau; measured 1 %.
    assert!(relative(with, without) < 0.03, "{with} {without}");
}
