//! Inputs that contradict each other are refused with what was found and what was expected.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_geometry::Aabb;
use niji_radiometry::WavelengthGrid;
use niji_render::AirPath;
use niji_render::Deadline;
use niji_render::Error;
use niji_render::Input;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::render;
use niji_render::render_in_strips;
use niji_render::unwatched;

fn drops(sun_path: SunPath) -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-2.0, -2.0, -22.0),
        max: DVec3::new(2.0, 2.0, -18.0),
        voxel_m: 1.0,
    };
    LitDrops::new(
        vec![bricks(&grid, |_| 0.1)],
        sun_in_the_south(30.0),
        sun_path,
    )
    .unwrap()
}

/// What the renderer says to a request that `spoil` has changed.
fn refusal(spoil: impl Fn(&mut RenderRequest)) -> Error {
    let drops = drops(SunPath::Volume { voxel_m: 1.0 });
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (4, 3));
    let table = isotropic(0.1);
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    render(&request, &|_| ()).unwrap();
    spoil(&mut request);
    render(&request, &|_| ()).unwrap_err()
}

#[test]
fn wavelengths_must_agree() {
    let air = air([0.0; 3], [0.0; 3]);
    let mut other = isotropic(0.1);
    other.wavelengths = WavelengthGrid::new(400.0, 100.0, 3).unwrap();
    let found = refusal(|request| {
        // Lifetimes: the table outlives the closure, not the request.
        request.wavelengths = WavelengthGrid::new(400.0, 100.0, 3).unwrap();
    });
    assert!(matches!(
        found,
        Error::Wavelengths {
            input: Input::ScatteringTable,
            ..
        }
    ));
    let text = found.to_string();
    assert!(text.contains("3 x 100 nm from 450 nm"), "{text}");
    drop((air, other));
}

#[test]
fn air_without_a_profile_is_refused() {
    let spoils: [fn(&mut AirConstituent); 4] = [
        |air| air.height_m.clear(),
        |air| air.density.clear(),
        |air| air.height_m.reverse(),
        // Which needs reaches.
        |air| air.law = DensityLaw::Exponential,
    ];
    for (index, spoil) in spoils.into_iter().enumerate() {
        let mut air = air([1e-5; 3], [1e-5; 3]);
        spoil(&mut air.constituents[0]);
        let found = with_air(&air);
        let input = Input::AtmosphereTable;
        assert!(
            matches!(found, Err(Error::BadTable { input: of, .. }) if of == input),
            "{index}: {found:?}"
        );
    }
    with_air(&air([1e-5; 3], [1e-5; 3])).unwrap();
}

/// What the renderer says to a request with extinction by that air.
fn with_air(air: &AtmosphereTable) -> Result<Rendered, Error> {
    let drops = drops(SunPath::Volume { voxel_m: 1.0 });
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (4, 3));
    let table = isotropic(0.1);
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    request.air = Some(air);
    request.effects.air_extinction = Toggle::On;
    render(&request, &|_| ())
}

#[test]
fn angles_of_the_rays_must_be_in_the_table() {
    let drops = drops(SunPath::Ignore);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 5.0, (4, 3));
    let mut table = isotropic(0.1);
    table.theta_rad = (0..1801).map(|step| 2.7 + 1e-4 * f64::from(step)).collect();
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    match render(&request, &|_| ()) {
        Err(Error::AngleRange {
            found_deg,
            expected_deg,
        }) => {
            assert!((found_deg.0 - 2.7_f64.to_degrees()).abs() < 1e-9);
            assert!(expected_deg.0 > 145.0 && expected_deg.1 < 155.0);
        }
        other => panic!("{other:?}"),
    }
    // All of them are on the primary side; a secondary bow alone needs none of them.
    request.effects.primary_bow = Toggle::Off;
    render(&request, &|_| ()).unwrap();
}

#[test]
fn values_that_no_drop_scatters_are_refused_before_a_row_of_them_is_handed_over() {
    let drops = drops(SunPath::Ignore);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 5.0, (4, 8));
    for bad in [-0.1, f32::NAN, f32::INFINITY] {
        let mut table = isotropic(0.1);
        table.values.fill(bad);
        let request = request(&camera, sun_in_the_south(30.0), &drops, &table);
        let rendered = render_in_strips(&request, (&unwatched, Deadline::NEVER), 1, &mut |_, _| {
            panic!("no row is due")
        });
        assert!(matches!(rendered, Err(Error::BadTable { .. })), "{bad}");
    }
}

#[test]
fn whoever_waits_stops_the_lighting_of_drops() {
    let grid = GridBox {
        min: DVec3::splat(-40.0),
        max: DVec3::splat(40.0),
        voxel_m: 1.0,
    };
    let sun = sun_in_the_south(30.0);
    let lit = |sun_path: SunPath, n_most: u64| {
        let n_heard = AtomicU64::new(0);
        let progress = |_| match n_heard.fetch_add(1, Ordering::Relaxed) {
            n if n < n_most => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        };
        let lit = LitDrops::watched(vec![bricks(&grid, |_| 0.1)], sun, sun_path, &progress);
        (lit.err(), n_heard.into_inner())
    };
    for sun_path in [
        SunPath::Volume { voxel_m: 1.0 },
        SunPath::March { step_m: 20.0 },
    ] {
        let (none, n_all) = lit(sun_path, u64::MAX);
        assert_eq!(none, None);
        let (stopped, n_heard) = lit(sun_path, 20);
        assert_eq!(stopped, Some(Error::Stopped), "{sun_path:?}");
        assert!(n_heard < n_all / 2, "{sun_path:?}: {n_heard} of {n_all}");
    }
}

#[test]
fn sizes_of_the_drops_must_be_in_the_table() {
    let drops = drops(SunPath::Ignore);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (4, 3));
    let table = sized_table(&[10.0, 99.0], |_, _, _| 0.1);
    let request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    let found = render(&request, &|_| ()).unwrap_err();
    assert!(
        matches!(
            found,
            Error::SizeRange {
                found_um: (10.0, 99.0),
                ..
            }
        ),
        "{found}"
    );
}

#[test]
fn shadows_must_be_those_of_the_sun() {
    let other_sun = refusal(|request| {
        request.effects = with_shadow();
        request.sun_direction = sun_in_the_south(31.0);
    });
    assert!(matches!(other_sun, Error::ShadowOfAnotherSun { .. }));
    let unlit = drops(SunPath::Ignore);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (4, 3));
    let table = isotropic(0.1);
    let mut request = request(&camera, sun_in_the_south(30.0), &unlit, &table);
    request.effects = with_shadow();
    assert_eq!(render(&request, &|_| ()), Err(Error::NoShadow));
}

#[test]
fn inputs_of_effects_must_be_there() {
    let no_table = refusal(|request| request.table = None);
    assert!(matches!(
        no_table,
        Error::MissingInput {
            input: Input::ScatteringTable,
            ..
        }
    ));
    for spoil in [
        |request: &mut RenderRequest| request.effects.air_extinction = Toggle::On,
        |request: &mut RenderRequest| request.effects.sunlight_through_air = Toggle::On,
        |request: &mut RenderRequest| request.effects.air_inscatter = Toggle::On,
        |request: &mut RenderRequest| request.effects.sky = Toggle::On,
    ] {
        let found = refusal(spoil);
        assert!(matches!(
            found,
            Error::MissingInput {
                input: Input::AtmosphereTable,
                ..
            }
        ));
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    for sun in [DVec3::ZERO, DVec3::NAN, DVec3::new(0.0, 2.0, 0.0)] {
        assert!(matches!(
            refusal(|request| request.sun_direction = sun),
            Error::SunDirection { .. }
        ));
    }
    for irradiance in [&[1.0, 2.0][..], &[1.0, f64::NAN, 1.0], &[1.0, -1.0, 1.0]] {
        let irradiance: &'static [f64] = irradiance.to_vec().leak();
        assert!(matches!(
            refusal(|request| request.sun_irradiance = irradiance),
            Error::SunIrradiance { .. }
        ));
    }
    for integration in [
        Integration::FixedStep { step_m: 0.0 },
        Integration::FixedStep { step_m: 1e-9 },
        Integration::FixedStep { step_m: f64::NAN },
        Integration::Adaptive {
            relative_error: 0.0,
        },
    ] {
        let found = refusal(|request| request.levels.integration = integration);
        assert!(matches!(found, Error::Level { .. }), "{found}");
    }
    let found = refusal(|request| request.levels.pixel_footprint = PixelFootprint::Grid { n: 0 });
    assert!(matches!(found, Error::Level { .. }));
    let found = refusal(|request| request.levels.air_path = AirPath::Midpoint { n_steps: 0 });
    assert!(matches!(found, Error::Level { .. }));
}

#[test]
fn a_sun_volume_that_does_not_fit_says_which_would() {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(100.0),
        voxel_m: 10.0,
    };
    let volume = bricks(&grid, |_| 0.1);
    let sun = sun_in_the_south(30.0);
    let path = SunPath::Volume { voxel_m: 0.01 };
    let found = LitDrops::new(vec![volume.clone()], sun, path).unwrap_err();
    assert!(matches!(found, Error::SunVolumeTooLarge { smallest_m, .. } if smallest_m > 0.1));
    // What is told fits, and what fits stays.
    let (min, max) = volume.world_bounds().unwrap();
    let bounds = Aabb { min, max };
    let fitting = path.fitting(bounds);
    assert!(LitDrops::new(vec![volume.clone()], sun, fitting).is_ok());
    assert_eq!(fitting.fitting(bounds), fitting);
    for path in [
        SunPath::Volume { voxel_m: -1.0 },
        SunPath::March {
            step_m: f64::INFINITY,
        },
        SunPath::March { step_m: 1e-9 },
    ] {
        let found = LitDrops::new(vec![volume.clone()], sun, path).unwrap_err();
        assert!(matches!(found, Error::Level { .. }), "{path:?}");
    }
}

#[test]
fn no_light_at_all_is_a_black_picture() {
    let drops = drops(SunPath::Ignore);
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 30.0, (4, 3));
    let table = isotropic(0.1);
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    request.sun_irradiance = &[0.0, 0.0, 0.0];
    assert!(
        rendered(&request)
            .radiance
            .iter()
            .all(|value| *value == 0.0)
    );
}
