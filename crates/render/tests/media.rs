//! Named media against closed forms, along a ray across plane layers.
//!
//! Whatever the profile, with Q = 0 (no extinction), 1 or 2 and no shadow,
//! L = E t (1 - exp(-Q tau_0)) / Q   (E t tau_0 at Q = 0),
//! and with the shadow of a sun whose way through the layers is 1/mu times the view ray's
//! L = E t (1 - exp(-Q tau_0 (1 + 1/mu))) / (Q (1 + 1/mu)).
//! `tau_0` column of extinction [-], `mu` cosine of the angle between ray and sun.
//!
//! Two media are meant. The *interpolant* is what the renderer is given: extinction linear between
//! nodes, falling to zero over the voxel beyond the last ones, and the sun's depth linear between
//! nodes too. Without shadow its column is the sum over nodes and the closed form holds; with
//! shadow the integral over each voxel is taken here by Simpson's rule. The *true medium* is the
//! profile itself; the interpolant approaches it with the square of the voxel.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_render::DropExtinctionModel;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::RenderEffects;
use niji_render::SunPath;

const VALUE_SR1: f64 = 0.05;

/// Where the layers begin, and how thick they are together (m).
const FRONT_M: f64 = 20.0;
const THICK_M: f64 = 8.0;

/// Elevation of the sun behind the eye; the ray is level.
const SUN_DEG: f64 = 30.0;

/// At the reference level: the rounding of moments in f32. Measured 4e-7.
const OF_THE_INTERPOLANT: f64 = 1e-6;

/// Nodes of the interpolant that stands for the true medium, and what they add to the rounding of
/// moments in f32. Measured 7e-7.
const FINE: u32 = 512;
const OF_FINE_MOMENTS: f64 = 2e-6;

/// The level that references are made with.
const REFERENCE: Integration = Integration::Adaptive {
    relative_error: 1e-8,
};

/// Extinction at Q = 1 by depth behind the front [1/m], and its column.
struct Medium {
    name: &'static str,
    extinction_m1: fn(f64) -> f64,
    column: f64,
    /// Largest extinction [1/m].
    largest_m1: f64,
    /// Error of the column of the interpolant through [`FINE`] nodes.
    column_error: f64,
}

/// The named media of this test. A profile's column at its nodes is a midpoint sum: exact where it
/// is linear between voxel faces, and for a Gaussian that vanishes at the ends.
fn media() -> [Medium; 7] {
    [
        Medium {
            name: "homogeneous",
            extinction_m1: |_| 0.1,
            column: 0.8,
            largest_m1: 0.1,
            column_error: 0.0,
        },
        Medium {
            name: "thick",
            extinction_m1: |_| 1.5,
            column: 12.0,
            largest_m1: 1.5,
            column_error: 0.0,
        },
        Medium {
            name: "exponential",
            extinction_m1: |depth_m| 0.4 * (-0.5 * depth_m).exp(),
            column: 0.8 * (1.0 - (-4.0_f64).exp()),
            largest_m1: 0.4,
            // (h/l)²/24, h = 8 m / 512, l = 2 m.
            column_error: 2.6e-6,
        },
        Medium {
            name: "linear",
            extinction_m1: |depth_m| 0.05 * depth_m,
            column: 1.6,
            largest_m1: 0.4,
            column_error: 0.0,
        },
        Medium {
            name: "two-layer",
            extinction_m1: |depth_m| if depth_m < 3.0 { 0.05 } else { 0.6 },
            column: 3.15,
            largest_m1: 0.6,
            column_error: 0.0,
        },
        Medium {
            name: "Gaussian",
            extinction_m1: |depth_m| 0.7 * (-0.5 * ((depth_m - 4.0) / 0.6).powi(2)).exp(),
            column: 0.42 * (2.0 * PI).sqrt(),
            largest_m1: 0.7,
            column_error: 0.0,
        },
        Medium {
            name: "thin shell",
            extinction_m1: |depth_m| {
                if (4.0..4.125).contains(&depth_m) {
                    8.0
                } else {
                    0.0
                }
            },
            column: 1.0,
            largest_m1: 8.0,
            column_error: 0.0,
        },
    ]
}

/// Extinction and shadow as a level takes them.
#[derive(Clone, Copy, Debug)]
struct Dimming {
    model: DropExtinctionModel,
    shadow: bool,
}

const DIMMINGS: [Dimming; 4] = [
    Dimming {
        model: DropExtinctionModel::WithoutDiffraction,
        shadow: false,
    },
    Dimming {
        model: DropExtinctionModel::Full,
        shadow: false,
    },
    Dimming {
        model: DropExtinctionModel::WithoutDiffraction,
        shadow: true,
    },
    Dimming {
        model: DropExtinctionModel::Full,
        shadow: true,
    },
];

impl Dimming {
    fn effects(self) -> RenderEffects {
        if self.shadow {
            with_shadow()
        } else {
            with_extinction()
        }
    }

    /// Most that the sun's depth, linear over a voxel of v = Q (1 + 1/mu) sigma h, takes from the
    /// light where the extinction has a kink: v²/8.
    fn kink_error(self, medium: &Medium) -> f64 {
        if !self.shadow {
            return 0.0;
        }
        let paths = 1.0 + 1.0 / SUN_DEG.to_radians().cos();
        let voxel_m = THICK_M / f64::from(FINE);
        (self.model.efficiency() * paths * medium.largest_m1 * voxel_m).powi(2) / 8.0
    }

    /// Light of a column.
    fn closed_form(self, column: f64) -> f64 {
        let mu = SUN_DEG.to_radians().cos();
        let paths = if self.shadow { 1.0 + 1.0 / mu } else { 1.0 };
        let q = self.model.efficiency() * paths;
        VALUE_SR1 * -(-q * column).exp_m1() / q
    }
}

/// Layers `n` voxels deep, wide enough that the sun shines in through their front alone.
fn layers(medium: &Medium, n: u32) -> LitDrops {
    let voxel_m = THICK_M / f64::from(n);
    let sunlit_m = SUN_DEG.to_radians().tan() * THICK_M + 4.0 * voxel_m;
    let grid = GridBox {
        min: DVec3::new(-2.0 * voxel_m, -2.0 * voxel_m, -FRONT_M - THICK_M),
        max: DVec3::new(2.0 * voxel_m, sunlit_m, -FRONT_M),
        voxel_m,
    };
    let volume = bricks(&grid, |point| (medium.extinction_m1)(-FRONT_M - point.z));
    let sun_path = SunPath::Volume { voxel_m };
    LitDrops::new(vec![volume], sun_in_the_south(SUN_DEG), sun_path).unwrap()
}

fn light(drops: &LitDrops, dimming: Dimming, integration: Integration) -> f64 {
    let camera = one_ray(DVec3::ZERO);
    let table = isotropic(VALUE_SR1);
    let mut request = request(&camera, sun_in_the_south(SUN_DEG), drops, &table);
    request.effects = dimming.effects();
    request.levels.drop_extinction_model = dimming.model;
    request.levels.integration = integration;
    f64::from(rendered(&request).radiance[[0, 0, 0]]) / SUN[0]
}

/// Light of the interpolant through `n` nodes.
fn light_of_interpolant(medium: &Medium, n: u32, dimming: Dimming) -> f64 {
    let h = THICK_M / f64::from(n);
    // Nodes stand in the middles of voxels; one without drops on either side.
    let node = |index: u32| match index {
        0 => 0.0,
        index if index > n => 0.0,
        index => (medium.extinction_m1)((f64::from(index) - 0.5) * h),
    };
    if !dimming.shadow {
        return dimming.closed_form((1..=n).map(|index| node(index) * h).sum());
    }
    let q = dimming.model.efficiency();
    let per_depth = 1.0 / SUN_DEG.to_radians().cos();
    let (mut sum, mut before) = (0.0, 0.0);
    for index in 0..=n {
        let (a, b) = (node(index), node(index + 1));
        let depth = |x: f64| h * x * (a + 0.5 * x * (b - a));
        let source = |x: f64| {
            let tau_sun = per_depth * (before + x * depth(1.0));
            (a + x * (b - a)) * (-q * (before + depth(x) + tau_sun)).exp()
        };
        sum += h * simpson(source);
        before += depth(1.0);
    }
    VALUE_SR1 * sum
}

/// Simpson's rule of 64 intervals on 0..1.
fn simpson(f: impl Fn(f64) -> f64) -> f64 {
    let n = 64;
    let weight = |index: u32| match index {
        0 => 1.0,
        index if index == n => 1.0,
        index if index % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let terms = (0..=n).map(|index| weight(index) * f(f64::from(index) / f64::from(n)));
    terms.sum::<f64>() / f64::from(3 * n)
}

#[test]
fn every_medium_has_the_light_of_its_interpolant() {
    for medium in media() {
        let drops = layers(&medium, 64);
        for dimming in DIMMINGS {
            let found = light(&drops, dimming, REFERENCE);
            let expected = light_of_interpolant(&medium, 64, dimming);
            let error = relative(found, expected);
            println!("{} {dimming:?}: {error:.1e}", medium.name);
            assert!(
                error < OF_THE_INTERPOLANT,
                "{} {dimming:?}: {error:.1e}",
                medium.name
            );
        }
    }
}

#[test]
fn every_medium_approaches_its_closed_form_with_its_voxels() {
    for medium in media() {
        let drops = layers(&medium, FINE);
        for dimming in DIMMINGS {
            let found = light(&drops, dimming, REFERENCE);
            let error = relative(found, dimming.closed_form(medium.column));
            let tolerance = OF_FINE_MOMENTS + medium.column_error + dimming.kink_error(&medium);
            println!(
                "{} {dimming:?}: {error:.1e} of {tolerance:.1e}",
                medium.name
            );
            assert!(
                error < tolerance,
                "{} {dimming:?}: {error:.1e}",
                medium.name
            );
        }
    }
}

#[test]
fn every_medium_keeps_to_the_error_that_is_asked_for() {
    for medium in media() {
        let drops = layers(&medium, 64);
        for dimming in DIMMINGS {
            let expected = light_of_interpolant(&medium, 64, dimming);
            for relative_error in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
                let found = light(&drops, dimming, Integration::Adaptive { relative_error });
                let error = relative(found, expected);
                println!("{} {dimming:?} {relative_error}: {error:.1e}", medium.name);
                let tolerance = relative_error.max(OF_THE_INTERPOLANT);
                assert!(
                    error < tolerance,
                    "{} {dimming:?} at {relative_error}: {error:.1e}",
                    medium.name
                );
            }
        }
    }
}
