//! The hard cases of the ray integral by name: none may give NaN, and each has a known answer.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_geometry::Ray;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_render::Toggle;

const INTEGRATIONS: [Integration; 3] = [
    Integration::CellExact,
    Integration::Adaptive {
        relative_error: 1e-4,
    },
    Integration::FixedStep { step_m: 0.05 },
];

/// A cube of 4 m, 20 m to the north of the origin.
fn cube(offset: DVec3) -> GridBox {
    GridBox {
        min: offset + DVec3::new(-2.0, -2.0, -22.0),
        max: offset + DVec3::new(2.0, 2.0, -18.0),
        voxel_m: 0.5,
    }
}

fn lit(grid: &GridBox, extinction_m1: f64) -> LitDrops {
    let sun = sun_in_the_south(25.0);
    let path = SunPath::Volume { voxel_m: 0.25 };
    LitDrops::new(vec![bricks(grid, |_| extinction_m1)], sun, path).unwrap()
}

/// Light of one ray through drops in an isotropic table of 1/sr and sun of 2.
fn light_along(drops: &LitDrops, eye: DVec3, effects: RenderEffects, level: Integration) -> f64 {
    let camera = one_ray(eye);
    let table = isotropic(1.0);
    let mut request = request(&camera, sun_in_the_south(25.0), drops, &table);
    request.effects = effects;
    request.levels.integration = level;
    f64::from(rendered(&request).radiance[[0, 0, 0]]) / SUN[0]
}

#[test]
fn an_empty_volume_is_black_and_transparent() {
    let empty = LitDrops::new(
        vec![bricks(&cube(DVec3::ZERO), |_| 0.0)],
        sun_in_the_south(25.0),
        SunPath::Volume { voxel_m: 1.0 },
    );
    for drops in [empty.unwrap(), LitDrops::none()] {
        let camera = camera(DVec3::ZERO, (0.0, 0.0), 40.0, (8, 6));
        let table = isotropic(1.0);
        let mut request = request(&camera, sun_in_the_south(25.0), &drops, &table);
        request.effects = with_shadow();
        let picture = rendered(&request);
        assert!(picture.radiance.iter().all(|value| *value == 0.0));
        assert!(picture.transmittance.iter().all(|value| *value == 1.0));
    }
}

#[test]
fn one_voxel_shines_as_its_column() {
    let grid = GridBox {
        min: DVec3::new(-0.5, -0.5, -20.5),
        max: DVec3::new(0.5, 0.5, -19.5),
        voxel_m: 1.0,
    };
    let drops = lit(&grid, 0.3);
    for level in INTEGRATIONS {
        // A tent of height 0.3 and base 2.
        let found = light_along(&drops, DVec3::ZERO, RenderEffects::BOWS_ONLY, level);
        assert!(relative(found, 0.3) < 1e-3, "{level:?}: {found}");
    }
}

#[test]
fn a_ray_from_inside_sees_what_lies_ahead() {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    for level in INTEGRATIONS {
        let found = light_along(
            &drops,
            DVec3::new(0.0, 0.0, -20.0),
            with_extinction(),
            level,
        );
        assert!(
            relative(found, -(-0.6_f64).exp_m1()) < 1e-3,
            "{level:?}: {found}"
        );
    }
}

#[test]
fn a_direction_component_of_zero_is_the_limit_of_small_ones() {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    let exact = |eye: DVec3| {
        let camera = one_ray(eye);
        let ray: Ray = camera.ray(0.5, 0.5).unwrap();
        assert!(ray.direction.x == 0.0 && ray.direction.y == 0.0);
        light_along(&drops, eye, with_extinction(), Integration::CellExact)
    };
    // On a face between cells, in the middle of a cell, and along an edge of the lattice.
    for eye in [
        DVec3::ZERO,
        DVec3::new(0.25, 0.25, 0.0),
        DVec3::new(0.25, 0.0, 0.0),
    ] {
        assert!(
            relative(exact(eye), -(-1.2_f64).exp_m1()) < 1e-6,
            "{eye}: {}",
            exact(eye)
        );
    }
}

#[test]
fn a_ray_that_grazes_a_face_of_the_field_sees_next_to_nothing() {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    let bounds = drops.bounds().unwrap();
    for level in INTEGRATIONS {
        for x in [bounds.max.x, bounds.min.x, bounds.max.x - 1e-9] {
            let found = light_along(
                &drops,
                DVec3::new(x, 0.0, 0.0),
                RenderEffects::BOWS_ONLY,
                level,
            );
            assert!((0.0..1e-6).contains(&found), "{level:?} {x}: {found}");
        }
    }
}

#[test]
fn a_thin_shell_between_two_samples_is_not_missed() {
    // Drops at one layer of nodes only; a march of 3 m sees it by luck, cells see it always.
    let grid = GridBox {
        min: DVec3::new(-2.0, -2.0, -40.0),
        max: DVec3::new(2.0, 2.0, -20.0),
        voxel_m: 0.25,
    };
    let volume = bricks(&grid, |point| {
        if (point.z + 30.0).abs() < 0.2 && point.z < -30.0 {
            1.0
        } else {
            0.0
        }
    });
    let drops = LitDrops::new(vec![volume], sun_in_the_south(25.0), SunPath::Ignore).unwrap();
    let found = light_along(
        &drops,
        DVec3::ZERO,
        RenderEffects::BOWS_ONLY,
        Integration::CellExact,
    );
    assert!(relative(found, 0.25) < 1e-6, "{found}");
}

#[test]
fn a_scene_1000_km_away_looks_the_same() {
    let picture = |offset: DVec3| {
        let drops = lit(&cube(offset), 0.2);
        let camera = camera(offset, (3.0, 2.0), 20.0, (16, 12));
        let table = table(|w, theta| 0.01 * (1.0 + w as f64) * (1.0 + (9.0 * theta).cos()));
        let mut request = request(&camera, sun_in_the_south(25.0), &drops, &table);
        request.effects = with_shadow();
        rendered(&request).radiance
    };
    let here = picture(DVec3::ZERO);
    let peak = here.iter().copied().fold(0.0, f32::max);
    for offset in [DVec3::new(1e3, 0.0, -2e3), DVec3::new(1e6, 500.0, -1e6)] {
        for (far, near) in picture(offset).iter().zip(&here) {
            // The spacing of f64 at 1000 km is 1e-10 m; measured 3e-6 of the peak.
            assert!(
                (far - near).abs() < 2e-5 * peak,
                "{offset}: {far} for {near}"
            );
        }
    }
}

#[test]
fn the_antisolar_point_and_the_sun_itself_are_ordinary_directions() {
    let sun = DVec3::Z;
    let drops = LitDrops::new(
        vec![bricks(&cube(DVec3::ZERO), |_| 0.1)],
        sun,
        SunPath::March { step_m: 0.1 },
    )
    .unwrap();
    let table = table(|_, theta| theta);
    for (eye, azimuth_deg, theta) in [
        (DVec3::ZERO, 0.0, std::f64::consts::PI),
        (DVec3::new(0.0, 0.0, -40.0), 180.0, 0.0),
    ] {
        let camera = camera(eye, (azimuth_deg, 0.0), 1e-4, (1, 1));
        let mut request = request(&camera, sun, &drops, &table);
        for footprint in [
            PixelFootprint::Center,
            PixelFootprint::Prefiltered,
            PixelFootprint::Grid { n: 2 },
        ] {
            request.levels.pixel_footprint = footprint;
            let found = f64::from(rendered(&request).radiance[[0, 0, 0]]);
            assert!(
                (found - SUN[0] * 0.4 * theta).abs() < 1e-5,
                "{theta} {footprint:?}: {found}"
            );
        }
    }
}

#[test]
fn optical_depths_from_1e_12_to_1e3_stay_finite_and_ordered() {
    let effects = with_shadow();
    let mut last = 0.0;
    for depth in [1e-12, 1e-6, 1e-2, 1.0, 30.0, 1e3] {
        let drops = lit(&cube(DVec3::ZERO), depth / 4.0);
        for level in INTEGRATIONS {
            let found = light_along(&drops, DVec3::ZERO, effects, level);
            assert!(found > 0.0 && found <= 1.0, "{depth} {level:?}: {found}");
        }
        let found = light_along(&drops, DVec3::ZERO, effects, Integration::CellExact);
        assert!(found > last || depth > 1.0, "{depth}: {found} after {last}");
        last = found;
    }
}

#[test]
fn voxels_without_drops_next_to_drops_do_not_divide_by_zero() {
    // A checkerboard of rain and nothing, of two sizes.
    let field = |point: DVec3| {
        let odd = ((point.x.floor() + point.y.floor() + point.z.floor()) as i64).rem_euclid(2);
        let radius_m = if point.y > 0.0 { 1e-3 } else { 1e-4 };
        Drops {
            number_density_m3: if odd == 1 { 1000.0 } else { 0.0 },
            effective_radius_m: radius_m,
            effective_variance: 0.0,
        }
    };
    let mode = DropMode::from_fn("", &cube(DVec3::ZERO), field).unwrap();
    let radii: Vec<f64> = (0..60).map(|step| 90.0 * 1.045_f64.powi(step)).collect();
    let table = sized_table(&radii, |radius, _, theta| 0.01 * radius.ln() * theta);
    for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
        let volume = Bricks::build(&mode, interpolation).unwrap();
        let path = SunPath::Volume { voxel_m: 0.5 };
        let drops = LitDrops::new(vec![volume], sun_in_the_south(25.0), path).unwrap();
        let camera = camera(DVec3::ZERO, (0.0, 0.0), 20.0, (24, 18));
        let mut request = request(&camera, sun_in_the_south(25.0), &drops, &table);
        request.effects = with_shadow();
        for level in INTEGRATIONS {
            request.levels.integration = level;
            assert!(rendered(&request).radiance.iter().any(|value| *value > 0.0));
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let volume = bricks(&cube(DVec3::ZERO), |point| {
        0.2 + 0.1 * (3.0 * point.x).sin() * point.y.cos()
    });
    let table = table(|w, theta| 0.01 * (1.0 + w as f64) * (1.0 + (30.0 * theta).cos()));
    let air = air([2e-5, 1e-5, 5e-6], [2e-5, 1e-5, 5e-6]);
    let camera = camera(DVec3::ZERO, (0.0, 3.0), 30.0, (37, 23));
    let picture = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build()
            .unwrap();
        pool.install(|| {
            let path = SunPath::Volume { voxel_m: 0.4 };
            let drops = LitDrops::new(vec![volume.clone()], sun_in_the_south(25.0), path).unwrap();
            let mut request = request(&camera, sun_in_the_south(25.0), &drops, &table);
            request.effects = RenderEffects::ALL;
            request.air = Some(&air);
            rendered(&request)
        })
    };
    let one = picture(1);
    for n_threads in [2, 7] {
        assert!(
            picture(n_threads) == one,
            "{n_threads} threads differ from one"
        );
    }
}

#[test]
fn progress_counts_every_pixel_once() {
    let drops = lit(&cube(DVec3::ZERO), 0.2);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (13, 7));
    let table = isotropic(0.1);
    let done = std::sync::atomic::AtomicU64::new(0);
    let count = |pixels| {
        done.fetch_add(pixels, std::sync::atomic::Ordering::Relaxed);
    };
    let request = request(&camera, sun_in_the_south(25.0), &drops, &table);
    niji_render::render(&request, &count).unwrap();
    assert_eq!(done.into_inner(), 13 * 7);
}

#[test]
fn an_off_bow_is_black_and_needs_no_table() {
    let drops = lit(&cube(DVec3::ZERO), 0.2);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (13, 7));
    let table = isotropic(0.1);
    let mut request = request(&camera, sun_in_the_south(25.0), &drops, &table);
    request.effects.primary_bow = Toggle::Off;
    request.effects.secondary_bow = Toggle::Off;
    request.table = None;
    let picture = rendered(&request);
    assert!(picture.radiance.iter().all(|value| *value == 0.0));
}

#[test]
fn light_of_neither_bow_shows_on_both_sides_of_the_split() {
    let drops = lit(&cube(DVec3::ZERO), 0.2);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 10.0, (13, 7));
    let mut table = isotropic(0.1);
    let sun = sun_in_the_south(25.0);
    // The picture lies wholly on one side, then on the other.
    for split_deg in [100.0_f64, 179.0] {
        table.split_theta_rad = split_deg.to_radians();
        let mut request = request(&camera, sun, &drops, &table);
        let both_bows = rendered(&request).radiance;
        request.effects.primary_bow = Toggle::Off;
        request.effects.secondary_bow = Toggle::Off;
        request.effects.higher_orders = Toggle::On;
        assert!(rendered(&request).radiance == both_bows);
        request.table = None;
        assert!(niji_render::render(&request, &|_| ()).is_err());
    }
}

#[test]
fn sweep_and_march_agree_for_suns_in_all_directions() {
    // A ball with a sharp edge, empty space around it.
    let grid = GridBox {
        min: DVec3::splat(-4.0),
        max: DVec3::splat(4.0),
        voxel_m: 0.25,
    };
    let ball = bricks(&grid, |point| if point.length() < 3.0 { 0.5 } else { 0.0 });
    let slanting = DVec3::new(0.4, 0.7, -0.6).normalize();
    for sun in [
        DVec3::X,
        DVec3::NEG_X,
        DVec3::Y,
        DVec3::NEG_Z,
        slanting,
        -slanting,
    ] {
        let [swept, marched] = [
            SunPath::Volume { voxel_m: 0.25 },
            SunPath::March { step_m: 0.05 },
        ]
        .map(|path| LitDrops::new(vec![ball.clone()], sun, path).unwrap());
        let (mut square, mut n) = (0.0, 0);
        for step in 0..1000 {
            let at = f64::from(step);
            let inside = DVec3::new((at * 0.71).sin(), (at * 1.13).sin(), (at * 0.37).cos());
            let [a, b] = [&swept, &marched]
                .map(|drops| f64::from(drops.bricks()[0].sample(1.7 * inside).tau_sun));
            square += (a - b).powi(2);
            n += 1;
        }
        // Depths reach 3; measured 0.007.
        let rms = (square / f64::from(n)).sqrt();
        println!("{sun}: {rms:.4}");
        assert!(rms < 0.02, "{sun}: {rms}");
    }
}

#[test]
fn a_uniform_surround_hides_drops_of_any_thickness() {
    // Air and white ground that shine evenly from everywhere, and a sun below the horizon.
    let sun = sun_in_the_south(-30.0);
    let mut air = air([1e-4; 3], [1e-4; 3]);
    air.ground_albedo = vec![1.0; 3];
    air.diffuse = Some(uniform_light(0.25));
    let camera = camera(DVec3::new(0.0, 100.0, 0.0), (0.0, 0.0), 20.0, (8, 6));
    let table = isotropic(1.0);
    for depth in [0.0, 1e-6, 0.3, 3.0, 1e3] {
        let grid = cube(DVec3::new(0.0, 100.0, 0.0));
        let volume = bricks(&grid, |_| depth / 4.0);
        let drops = LitDrops::new(vec![volume], sun, SunPath::Ignore).unwrap();
        let mut request = request(&camera, sun, &drops, &table);
        request.air = Some(&air);
        request.levels.sky_model = SkyModel::MultipleScattering;
        request.effects = RenderEffects {
            primary_bow: Toggle::Off,
            secondary_bow: Toggle::Off,
            sky: Toggle::On,
            skylit_drops: Toggle::On,
            air_extinction: Toggle::On,
            air_inscatter: Toggle::On,
            ..with_extinction()
        };
        let picture = rendered(&request);
        for (wavelength, plane) in picture.radiance.outer_iter().enumerate() {
            for value in plane {
                let error = relative(f64::from(*value), 0.25 * SUN[wavelength]);
                assert!(error < 1e-3, "{depth}: {error}");
            }
        }
    }
}

#[test]
fn denormals_are_next_to_nothing() {
    let grid = cube(DVec3::ZERO);
    for density in [f32::from_bits(1), 1e-42, f32::MIN_POSITIVE] {
        let drops = Drops {
            number_density_m3: density,
            effective_radius_m: RADIUS_M as f32,
            effective_variance: 0.0,
        };
        let mode = DropMode::from_fn("", &grid, |_| drops).unwrap();
        for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
            let volume = Bricks::build(&mode, interpolation).unwrap();
            let path = SunPath::Volume { voxel_m: 0.5 };
            let drops = LitDrops::new(vec![volume], sun_in_the_south(25.0), path).unwrap();
            for level in INTEGRATIONS {
                let found = light_along(&drops, DVec3::ZERO, with_shadow(), level);
                assert!(
                    (0.0..1e-36).contains(&found),
                    "{density} {level:?}: {found}"
                );
            }
        }
    }
    // Behind a depth of 86 what the sun leaves is the smallest normal number.
    let drops = lit(&grid, 86.0 / 4.0);
    for level in INTEGRATIONS {
        let found = light_along(&drops, DVec3::ZERO, with_shadow(), level);
        assert!(found > 0.1 && found < 1.0, "{level:?}: {found}");
    }
}

#[test]
fn nan_voxels_never_reach_the_renderer() {
    // Those of files are refused on reading, with their grid and place (niji-dropfield).
    for field in [
        |_: DVec3| Drops {
            number_density_m3: f32::NAN,
            ..drops(0.1)
        },
        |_: DVec3| Drops {
            effective_radius_m: f32::NAN,
            ..drops(0.1)
        },
    ] {
        assert!(DropMode::from_fn("", &cube(DVec3::ZERO), field).is_err());
    }
}
