//! Air: closed forms in a layer of constant density, and effects that are off.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_exchange::AtmosphereTable;
use niji_render::AirPath;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::render;

const EXTINCTION: [f64; 3] = [4e-5, 2e-5, 1e-5];
const SCATTERING: [f64; 3] = [3e-5, 1.5e-5, 0.5e-5];
/// 1/(4 pi).
const PHASE: f64 = 0.25 * std::f64::consts::FRAC_1_PI;

const PATHS: [AirPath; 4] = [
    AirPath::Constant,
    AirPath::Midpoint { n_steps: 40 },
    AirPath::Quadrature { n_nodes: 8 },
    AirPath::Table,
];

/// A thin sheet of drops, `distance_m` to the north and high enough to stay above the horizon.
fn sheet(distance_m: f64, sun: DVec3) -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-20.0, 980.0, -distance_m - 5.0),
        max: DVec3::new(20.0, 1020.0, -distance_m + 5.0),
        voxel_m: 5.0,
    };
    LitDrops::new(vec![bricks(&grid, |_| 1e-3)], sun, SunPath::Ignore).unwrap()
}

const EYE: DVec3 = DVec3::new(0.0, 1000.0, 0.0);

#[test]
fn air_in_front_of_the_drops_dims_them_by_its_depth() {
    let sun = sun_in_the_south(30.0);
    let air = air(EXTINCTION, SCATTERING);
    let table = isotropic(0.1);
    let camera = one_ray(EYE);
    for distance_m in [10.0, 1e3, 3e4] {
        let drops = sheet(distance_m, sun);
        let mut request = request(&camera, sun, &drops, &table);
        let bare = rendered(&request).radiance;
        request.air = Some(&air);
        request.effects.air_extinction = Toggle::On;
        for path in PATHS {
            request.levels.air_path = path;
            let found = rendered(&request).radiance;
            for wavelength in 0..3 {
                let through = f64::from(found[[wavelength, 0, 0]] / bare[[wavelength, 0, 0]]);
                let expected = (-EXTINCTION[wavelength] * distance_m).exp();
                assert!(
                    relative(through, expected) < 3e-6,
                    "{path:?} {distance_m}: {through} for {expected}"
                );
            }
        }
    }
}

#[test]
fn air_above_the_drops_dims_the_sunlight() {
    let table = isotropic(0.1);
    let camera = one_ray(EYE);
    for elevation_deg in [90.0, 30.0, 2.0_f64] {
        let sun = sun_in_the_south(elevation_deg);
        let drops = sheet(200.0, sun);
        let extinction = EXTINCTION.map(|beta| 0.1 * beta);
        let air = air(extinction, [0.0; 3]);
        let mut request = request(&camera, sun, &drops, &table);
        let bare = rendered(&request).radiance;
        request.air = Some(&air);
        request.effects.sunlight_through_air = Toggle::On;
        // Chord from 1000 m to 100 km over the sphere.
        let (planet_m, sin) = (6_371_000.0_f64, elevation_deg.to_radians().sin());
        let (r, top) = (planet_m + 1e3, planet_m + 1e5);
        let length_m = (r * r * sin * sin + top * top - r * r).sqrt() - r * sin;
        for path in PATHS {
            request.levels.air_path = path;
            let found = rendered(&request).radiance;
            for wavelength in 0..3 {
                let through = f64::from(found[[wavelength, 0, 0]] / bare[[wavelength, 0, 0]]);
                let expected = (-extinction[wavelength] * length_m).exp();
                // The sheet is 200 m away, where a low sun stands 0.0018 degrees lower or higher.
                assert!(
                    relative(through, expected) < 2e-3,
                    "{path:?} {elevation_deg}: {through} for {expected}"
                );
            }
        }
    }
}

#[test]
fn drops_behind_the_planet_see_no_sun() {
    let sun = sun_in_the_south(-3.0);
    let drops = sheet(200.0, sun);
    let air = air(EXTINCTION, SCATTERING);
    let table = isotropic(0.1);
    let camera = one_ray(EYE);
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.effects = RenderEffects::ALL;
    request.effects.drop_shadow = Toggle::Off;
    for path in PATHS {
        request.levels.air_path = path;
        let picture = rendered(&request);
        assert!(
            picture[PictureLayer::BowPrimary]
                .iter()
                .all(|value| *value == 0.0),
            "{path:?}"
        );
    }
}

#[test]
fn a_short_stretch_of_air_glows_by_its_length() {
    let sun = sun_in_the_south(90.0);
    let air = air(EXTINCTION, SCATTERING);
    let camera = one_ray(EYE);
    let table = isotropic(0.1);
    for distance_m in [100.0, 1e3] {
        let drops = sheet(distance_m, sun);
        let far_side_m = -drops.bounds().unwrap().min.z;
        let mut request = request(&camera, sun, &drops, &table);
        request.air = Some(&air);
        request.effects = RenderEffects {
            air_inscatter: Toggle::On,
            ..RenderEffects::BOWS_ONLY
        };
        request.effects.primary_bow = Toggle::Off;
        request.effects.secondary_bow = Toggle::Off;
        let found = rendered(&request).radiance;
        for wavelength in 0..3 {
            let beta = EXTINCTION[wavelength];
            let lit = SUN[wavelength] * (-beta * 99e3).exp();
            let expected =
                lit * SCATTERING[wavelength] * PHASE * -(-beta * far_side_m).exp_m1() / beta;
            let error = relative(f64::from(found[[wavelength, 0, 0]]), expected);
            assert!(error < 3e-5, "{distance_m}: {error}");
        }
    }
}

#[test]
fn the_sky_overhead_has_its_closed_form() {
    // Straight up in a layer of depth h, sun at the zenith angle with cosine mu in a flat layer:
    // L = E b P int_0^h exp(-beta (z + (h - z)/mu)) dz. The layer is 1 % of the radius deep.
    let sun = sun_in_the_south(90.0);
    let air = air(EXTINCTION, SCATTERING);
    let drops = LitDrops::none();
    let table = isotropic(0.1);
    let camera = camera(DVec3::ZERO, (0.0, 90.0), 1e-3, (1, 1));
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.effects.sky = Toggle::On;
    for path in [AirPath::Quadrature { n_nodes: 8 }, AirPath::Table] {
        request.levels.air_path = path;
        let found = rendered(&request).radiance;
        for wavelength in 0..3 {
            let beta = EXTINCTION[wavelength];
            let expected =
                SUN[wavelength] * SCATTERING[wavelength] * PHASE * 1e5 * (-beta * 1e5).exp();
            let error = relative(f64::from(found[[wavelength, 0, 0]]), expected);
            assert!(error < 1e-5, "{path:?}: {error}");
        }
    }
    request.levels.sky_model = SkyModel::None;
    assert!(
        rendered(&request)
            .radiance
            .iter()
            .all(|value| *value == 0.0)
    );
}

#[test]
fn the_ground_shines_as_a_lambertian_surface() {
    let sun = sun_in_the_south(90.0);
    let mut air = air([0.0; 3], [0.0; 3]);
    air.ground_albedo = vec![0.1, 0.3, 0.5];
    let drops = LitDrops::none();
    let table = isotropic(0.1);
    let camera = camera(DVec3::new(0.0, 2.0, 0.0), (0.0, -90.0), 1e-3, (1, 1));
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.effects.sky = Toggle::On;
    let found = rendered(&request).radiance;
    for wavelength in 0..3 {
        let expected = SUN[wavelength] * air.ground_albedo[wavelength] / std::f64::consts::PI;
        assert!(relative(f64::from(found[[wavelength, 0, 0]]), expected) < 1e-6);
    }
}

#[test]
fn what_shines_through_is_dimmed_without_diffraction() {
    let sun = sun_in_the_south(40.0);
    let air = air(EXTINCTION, SCATTERING);
    let table = isotropic(0.1);
    let grid = GridBox {
        min: DVec3::new(-20.0, 980.0, -60.0),
        max: DVec3::new(20.0, 1020.0, -20.0),
        voxel_m: 5.0,
    };
    let drops = LitDrops::new(vec![bricks(&grid, |_| 0.025)], sun, SunPath::Ignore).unwrap();
    let camera = one_ray(EYE);
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.effects.primary_bow = Toggle::Off;
    request.effects.secondary_bow = Toggle::Off;
    request.effects.sky = Toggle::On;
    let bare = f64::from(rendered(&request).radiance[[1, 0, 0]]);
    // A matte has what the drops let pass, whether the picture dims what is behind them or not.
    let matte = rendered(&request)[PictureLayer::Transmittance][[0, 0, 0]];
    assert!(
        relative(f64::from(matte), (-1.0_f64).exp()) < 1e-5,
        "{matte}"
    );
    request.effects.drop_extinction = Toggle::On;
    for model in [
        niji_render::DropExtinctionModel::WithoutDiffraction,
        niji_render::DropExtinctionModel::Full,
    ] {
        request.levels.drop_extinction_model = model;
        let picture = rendered(&request);
        let dimmed = f64::from(picture.radiance[[1, 0, 0]]);
        assert!(
            relative(dimmed / bare, (-1.0_f64).exp()) < 1e-5,
            "{model:?}"
        );
        let transmittance = f64::from(picture[PictureLayer::Transmittance][[0, 0, 0]]);
        assert!(relative(transmittance, (-1.0_f64).exp()) < 1e-5);
    }
    // Drops that scatter their surroundings give light back.
    request.effects.skylit_drops = Toggle::On;
    let skylit = f64::from(rendered(&request).radiance[[1, 0, 0]]);
    assert!(
        skylit > 0.5 * bare && skylit < 2.0 * bare,
        "{skylit} of {bare}"
    );
}

#[test]
fn air_of_zero_coefficients_is_a_vacuum() {
    let sun = sun_in_the_south(30.0);
    let drops = sheet(100.0, sun);
    let table = table(|w, theta| 0.01 * (1.0 + w as f64) * theta);
    let camera = camera(EYE, (0.0, 0.0), 30.0, (12, 9));
    let mut request = request(&camera, sun, &drops, &table);
    let vacuum = rendered(&request).radiance;
    let air = air([0.0; 3], [0.0; 3]);
    request.air = Some(&air);
    request.effects.sunlight_through_air = Toggle::On;
    request.effects.air_extinction = Toggle::On;
    request.effects.air_inscatter = Toggle::On;
    for path in PATHS {
        request.levels.air_path = path;
        assert_eq!(rendered(&request).radiance, vacuum, "{path:?}");
    }
}

#[test]
fn an_effect_that_is_off_is_as_if_its_input_were_not_there() {
    let sun = sun_in_the_south(30.0);
    let drops = sheet(100.0, sun);
    let table = isotropic(0.1);
    let air = air(EXTINCTION, SCATTERING);
    let camera = camera(EYE, (0.0, 0.0), 30.0, (12, 9));
    let mut request = request(&camera, sun, &drops, &table);
    let without = rendered(&request);
    request.air = Some(&air);
    assert!(
        rendered(&request) == without,
        "air is there, but its effects are off"
    );
    let path = SunPath::Volume { voxel_m: 5.0 };
    let shadowed = LitDrops::new(drops.bricks().to_vec(), sun, path).unwrap();
    request.drops = &shadowed;
    assert!(
        rendered(&request).radiance == without.radiance,
        "shadows are there, but their effect is off"
    );
}

#[test]
fn observers_below_sea_level_and_above_the_air_see_finite_light() {
    let sun = sun_in_the_south(20.0);
    let air = air(EXTINCTION, SCATTERING);
    let table = isotropic(0.1);
    let drops = LitDrops::none();
    for height_m in [-50.0, 0.0, 2.0, 99_999.0, 3e5] {
        for elevation_deg in [-60.0, -0.5, 0.0, 5.0, 60.0] {
            let eye = DVec3::new(0.0, height_m, 0.0);
            let camera = camera(eye, (0.0, elevation_deg), 30.0, (4, 3));
            let mut request = request(&camera, sun, &drops, &table);
            request.air = Some(&air);
            request.effects.sky = Toggle::On;
            for path in PATHS {
                request.levels.air_path = path;
                rendered(&request);
            }
        }
    }
}

#[test]
fn air_inside_a_deep_volume_dims_its_far_end_more() {
    // Drops from 1 to 11 km: L = E t sigma int exp(-beta s) ds over a trapezoid of density, whose
    // integral is that of the box times (sinh(beta h/2)/(beta h/2))² with voxels of h.
    let sun = sun_in_the_south(30.0);
    let (voxel_m, near_m, far_m) = (500.0, 1e3, 11e3);
    let grid = GridBox {
        min: DVec3::new(-1000.0, 500.0, -far_m),
        max: DVec3::new(1000.0, 2500.0, -near_m),
        voxel_m,
    };
    let drops = LitDrops::new(vec![bricks(&grid, |_| 1e-6)], sun, SunPath::Ignore).unwrap();
    let air = air(EXTINCTION.map(|beta| 5.0 * beta), [0.0; 3]);
    let table = isotropic(0.1);
    let camera = one_ray(DVec3::new(0.0, 1500.0, 0.0));
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.effects.air_extinction = Toggle::On;
    for path in PATHS {
        request.levels.air_path = path;
        let picture = rendered(&request);
        for wavelength in 0..3 {
            let beta = 5.0 * EXTINCTION[wavelength];
            let nodes = (0..20).map(|node| near_m + (f64::from(node) + 0.5) * voxel_m);
            let half = 0.5 * beta * voxel_m;
            // Each node is a tent of base 2h: transform h (sinh(x)/x)² with x = beta h/2.
            let tent = voxel_m * (half.sinh() / half).powi(2);
            let sum: f64 = nodes.map(|s| tent * (-beta * s).exp()).sum();
            let expected = SUN[wavelength] * 0.1 * 1e-6 * sum;
            let error = relative(f64::from(picture.radiance[[wavelength, 0, 0]]), expected);
            println!("{path:?} {wavelength}: {error:.1e}");
            assert!(error < 2e-4, "{path:?} {wavelength}: {error}");
        }
    }
}

#[test]
fn air_and_white_ground_in_even_light_are_as_bright_as_the_light() {
    let sun = sun_in_the_south(90.0);
    let mut air = air(EXTINCTION, EXTINCTION);
    air.ground_albedo = vec![1.0; 3];
    air.diffuse = Some(uniform_light(0.25));
    let drops = LitDrops::none();
    let table = isotropic(0.1);
    for view_deg in [-90.0, -20.0, 30.0, 90.0] {
        let camera = camera(DVec3::new(0.0, 100.0, 0.0), (0.0, view_deg), 1e-3, (1, 1));
        let mut request = request(&camera, sun, &drops, &table);
        request.air = Some(&air);
        request.effects.sky = Toggle::On;
        let once = rendered(&request).radiance;
        request.levels.sky_model = SkyModel::MultipleScattering;
        let all = rendered(&request).radiance;
        for wavelength in 0..3 {
            let place = [wavelength, 0, 0];
            let found = f64::from((all[place] - once[place]) / SUN[wavelength] as f32);
            // Looking up, the air is what it absorbs of the dark behind it.
            let length_m = if view_deg > 0.0 {
                let planet = niji_geometry::EARTH;
                let mu = f64::to_radians(view_deg).sin();
                planet.shell_chord(100.0, mu, 1e5).unwrap().1
            } else {
                f64::INFINITY
            };
            let expected = 0.25 * -(-EXTINCTION[wavelength] * length_m).exp_m1();
            assert!(relative(found, expected) < 2e-4, "{view_deg}: {found}");
        }
    }
}

#[test]
fn multiple_scattering_wants_an_air_table_that_holds_it() {
    let sun = sun_in_the_south(90.0);
    let mut air = air(EXTINCTION, SCATTERING);
    let drops = LitDrops::none();
    let table = isotropic(0.1);
    let camera = camera(DVec3::ZERO, (0.0, 90.0), 1e-3, (1, 1));
    let refused = |air: &AtmosphereTable| {
        let mut request = request(&camera, sun, &drops, &table);
        request.air = Some(air);
        request.effects.sky = Toggle::On;
        request.levels.sky_model = SkyModel::MultipleScattering;
        render(&request, &|_| ())
    };
    let error = refused(&air);
    assert!(
        matches!(error, Err(Error::MissingInput { .. })),
        "{error:?}"
    );
    let mut light = uniform_light(0.25);
    light.moments.pop();
    air.diffuse = Some(light);
    let error = refused(&air);
    assert!(matches!(error, Err(Error::BadTable { .. })), "{error:?}");
}
