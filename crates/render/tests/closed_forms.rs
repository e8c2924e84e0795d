//! The ray integral against closed forms.
//!
//! A slab whose density varies along one axis only, seen along that axis, has optical depths to the
//! eye and to the sun that are proportional everywhere, tau_sun = tau/mu, whatever the profile:
//! L = E t (1 - exp(-Q tau_0 (1 + 1/mu))) / (Q (1 + 1/mu)),   `mu` cosine of the angle of the sun.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_render::DropExtinctionModel;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::SunPath;

const VALUE_SR1: f64 = 0.05;

/// A slab of 8 m along z, wide enough for a slanting sun, `n` voxels deep.
fn slab(n: u32) -> GridBox {
    let voxel_m = 8.0 / f64::from(n);
    GridBox {
        min: DVec3::new(-1.0, -2.0, -28.0),
        max: DVec3::new(1.0, 8.0, -20.0),
        voxel_m,
    }
}

fn radiance(drops: &LitDrops, sun: DVec3, set: impl Fn(&mut niji_render::RenderRequest)) -> f64 {
    let camera = one_ray(DVec3::ZERO);
    let table = isotropic(VALUE_SR1);
    let mut request = request(&camera, sun, drops, &table);
    set(&mut request);
    let picture = rendered(&request);
    for (wavelength, sun) in SUN.iter().enumerate() {
        let grey = picture.radiance[[wavelength, 0, 0]] / picture.radiance[[0, 0, 0]];
        assert!(
            relative(f64::from(grey), sun / SUN[0]) < 1e-6,
            "isotropic drops are grey"
        );
    }
    f64::from(picture.radiance[[0, 0, 0]]) / SUN[0]
}

/// A slab of extinction `1/m` and a sun at the zenith angle 0 of its face.
fn unshadowed(extinction_m1: impl Fn(DVec3) -> f64 + Sync) -> LitDrops {
    let sun = sun_in_the_south(0.0);
    LitDrops::new(vec![bricks(&slab(16), extinction_m1)], sun, SunPath::Ignore).unwrap()
}

#[test]
fn a_transparent_slab_shines_as_its_column() {
    let sun = sun_in_the_south(20.0);
    for depth in [1e-9, 1e-3, 2.0] {
        let drops = unshadowed(|_| depth / 8.0);
        let found = radiance(&drops, sun, |_| ());
        // f32 moments; measured 2e-7.
        assert!(relative(found, VALUE_SR1 * depth) < 1e-6, "{depth}");
    }
}

#[test]
fn extinction_on_the_view_path_is_exact_for_any_thickness() {
    let sun = sun_in_the_south(20.0);
    for (model, efficiency) in [
        (DropExtinctionModel::WithoutDiffraction, 1.0),
        (DropExtinctionModel::Full, 2.0),
    ] {
        for depth in [1e-9, 1e-3, 1.0, 12.0, 1e3] {
            let drops = unshadowed(|_| depth / 8.0);
            let found = radiance(&drops, sun, |request| {
                request.effects = with_extinction();
                request.levels.drop_extinction_model = model;
            });
            let expected = VALUE_SR1 * -(-efficiency * depth).exp_m1() / efficiency;
            // f32 moments; measured 3e-7.
            assert!(
                relative(found, expected) < 1e-6,
                "{depth} at Q = {efficiency}"
            );
        }
    }
}

#[test]
fn linear_and_exponential_profiles_have_their_columns() {
    let sun = sun_in_the_south(20.0);
    let from_front = |point: DVec3| -20.0 - point.z;
    let linear = unshadowed(|point| 0.1 * from_front(point));
    let found = radiance(&linear, sun, |_| ());
    assert!(relative(found, VALUE_SR1 * 0.1 * 32.0) < 1e-6);
    let exponential = unshadowed(|point| 0.3 * (-0.25 * from_front(point)).exp());
    let depth = 0.3 * (1.0 - (-2.0_f64).exp()) / 0.25;
    let found = radiance(&exponential, sun, |request| {
        request.effects = with_extinction();
    });
    // A midpoint sum at nodes: (h/4)²/24 = 6.5e-4 of the column.
    assert!(relative(found, VALUE_SR1 * -(-depth).exp_m1()) < 7e-4);
}

#[test]
fn extinction_on_both_paths_has_the_slabs_closed_form() {
    let (elevation_deg, n) = (30.0_f64, 64);
    let sun = sun_in_the_south(elevation_deg);
    let both = 1.0 + 1.0 / elevation_deg.to_radians().cos();
    // Linear interpolation of the sun's depth between nodes; the march adds its steps' errors at the
    // faces, where the density rises over a voxel.
    for (depth, of_sweep, of_march) in [(0.01, 1e-6, 3e-5), (1.0, 2e-4, 3e-3), (12.0, 3e-2, 4e-2)] {
        let volume = bricks(&slab(n), |_| depth / 8.0);
        for (sun_path, tolerance) in [
            (SunPath::Volume { voxel_m: 0.125 }, of_sweep),
            (SunPath::March { step_m: 0.1 }, of_march),
        ] {
            let drops = LitDrops::new(vec![volume.clone()], sun, sun_path).unwrap();
            for (model, q) in [
                (DropExtinctionModel::WithoutDiffraction, 1.0),
                (DropExtinctionModel::Full, 2.0),
            ] {
                let found = radiance(&drops, sun, |request| {
                    request.effects = with_shadow();
                    request.levels.drop_extinction_model = model;
                });
                let expected = VALUE_SR1 * -(-q * depth * both).exp_m1() / (q * both);
                let error = relative(found, expected);
                println!("{depth} {sun_path:?} {model:?}: {error:.1e}");
                assert!(error < tolerance, "{depth} {sun_path:?} {model:?}: {error}");
            }
        }
    }
}

#[test]
fn the_literal_march_converges_to_the_closed_form_with_the_square_of_the_step() {
    let sun = sun_in_the_south(20.0);
    let drops = unshadowed(|_| 0.25);
    let error = |step_m: f64| {
        let found = radiance(&drops, sun, |request| {
            request.effects = with_extinction();
            request.levels.integration = Integration::FixedStep { step_m };
        });
        relative(found, VALUE_SR1 * -(-2.0_f64).exp_m1())
    };
    let errors = [1.0, 0.5, 0.25].map(error);
    assert!(errors[0] < 1e-2 && errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1]);
}

#[test]
fn the_adaptive_level_keeps_to_its_error() {
    let elevation_deg = 30.0_f64;
    let sun = sun_in_the_south(elevation_deg);
    let both = 1.0 + 1.0 / elevation_deg.to_radians().cos();
    let volume = bricks(&slab(16), |_| 0.25);
    let drops = LitDrops::new(vec![volume], sun, SunPath::March { step_m: 0.02 }).unwrap();
    let expected = VALUE_SR1 * -(-2.0 * both).exp_m1() / both;
    // What is left is the linear interpolation of the sun's depth over half a metre.
    for (relative_error, tolerance) in [(1e-1, 1e-1), (1e-2, 1e-2), (1e-6, 3e-3)] {
        let found = radiance(&drops, sun, |request| {
            request.effects = with_shadow();
            request.levels.integration = Integration::Adaptive { relative_error };
        });
        let error = relative(found, expected);
        assert!(error < tolerance, "{relative_error}: {error}");
    }
}

#[test]
fn modes_add() {
    let sun = sun_in_the_south(30.0);
    let whole = bricks(&slab(16), |_| 0.4);
    let parts = vec![bricks(&slab(16), |_| 0.1), bricks(&slab(16), |_| 0.3)];
    // A lattice of its own for the second mode: pieces between the faces of both.
    let crossed = vec![bricks(&slab(16), |_| 0.1), bricks(&slab(23), |_| 0.3)];
    let draft = Integration::Adaptive {
        relative_error: 1e-2,
    };
    let volumes = [vec![whole], parts, crossed]
        .map(|modes| LitDrops::new(modes, sun, SunPath::Volume { voxel_m: 0.25 }).unwrap());
    for integration in [Integration::CellExact, draft] {
        let [whole, parts, crossed] = volumes.each_ref().map(|drops| {
            radiance(drops, sun, |request| {
                request.effects = with_shadow();
                request.levels.integration = integration;
            })
        });
        let [of_parts, of_crossed] = [parts, crossed].map(|found| relative(found, whole));
        assert!(of_parts < 2e-6, "{integration:?}: {of_parts}");
        assert!(of_crossed < 1e-2, "{integration:?}: {of_crossed}");
    }
}
