//! Shadows of drops on drops against closed forms.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_render::LitDrops;
use niji_render::SunPath;

/// Relative error of the light of a flat-topped slab of optical depth 1 over `n` voxels, seen from above.
fn slab_error(zenith_deg: f64, n: u32) -> f64 {
    let slab = flat_topped_slab(zenith_deg, n);
    let sun = sun_in_the_south(90.0 - zenith_deg);
    let voxel_m = slab.voxel_m;
    let drops = LitDrops::new(
        vec![bricks(&slab, |_| 1.0)],
        sun,
        SunPath::Volume { voxel_m },
    );
    let picture = shaded(&drops.unwrap(), sun, &from_above(&slab));
    let found = f64::from(picture.radiance[[0, 0, 0]]) / SUN[0];
    let both = 1.0 + 1.0 / zenith_deg.to_radians().cos();
    found / (SHADED_SR1 * -(-both).exp_m1() / both) - 1.0
}

#[test]
fn a_flat_topped_slab_keeps_its_light_under_a_low_sun() {
    // What is left is that nodes hold the depth and cells interpolate it, h²: of a march in steps of a
    // fiftieth of a voxel -0.57 % at 80 degrees and 16 voxels.
    for (zenith_deg, errors) in [
        (60.0, [9e-3, 2.7e-3, 6e-4, 1.4e-4]),
        (80.0, [5.4e-2, 1.3e-2, 3.4e-3, 1e-3]),
    ] {
        for (n, most) in [8, 16, 32, 64].into_iter().zip(errors) {
            let error = slab_error(zenith_deg, n);
            println!("{zenith_deg} {n}: {error:.1e}");
            assert!(error.abs() < most, "{zenith_deg} {n}: {error}");
        }
    }
}

#[test]
fn a_sun_straight_above_level_or_next_to_it_dims_an_even_box_by_its_depth() {
    // On the way through the middle of a box of depth 1 to a face, for each sun a different one.
    let voxel_m = 1.0 / 32.0;
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::ONE,
        voxel_m,
    };
    let eye = DVec3::new(0.5, 0.5, 4.0);
    for sun in [
        DVec3::Y,
        DVec3::X,
        DVec3::NEG_X,
        DVec3::new(1.0, 1e-12, 0.0),
        DVec3::new(-1.0, 1e-300, 0.0),
        DVec3::new(1.0, 1e-3, 0.0),
    ] {
        let sun = sun.normalize();
        let volume = bricks(&grid, |_| 1.0);
        let drops = LitDrops::new(vec![volume], sun, SunPath::Volume { voxel_m }).unwrap();
        let picture = shaded(&drops, sun, &camera(eye, (0.0, 0.0), 1e-3, (1, 1)));
        let found = f64::from(picture.radiance[[0, 0, 0]]) / SUN[0];
        let expected = SHADED_SR1 * -(-1.0_f64).exp_m1() * (-0.5_f64).exp();
        // Over the voxel where drops begin, at both ends of the view path, they shade each other less.
        assert!(
            relative(found, expected) < 1e-2,
            "{sun}: {found} {expected}"
        );
    }
}
