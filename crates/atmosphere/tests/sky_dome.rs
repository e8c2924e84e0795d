//! The tabulated sky against rays of its own for every direction.

mod common;

use common::unit_sun_air;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::InScattering;
use niji_atmosphere::PreparedSky;
use niji_atmosphere::ReferenceSky;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::SkyDirection;
use niji_atmosphere::SkyDome;
use niji_atmosphere::SkyMethod;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::spread_directions;
use niji_exchange::AtmosphereTable;
use niji_radiometry::Radians;

/// Domes of 1e-4 with the sun up; worst 7.2e-5.
const DOME_TOLERANCE: f64 = 1e-4;
/// Domes of 1e-4 in twilight and from space, whose shadow has an edge; worst 9.5e-5.
const EDGE_TOLERANCE: f64 = 2e-4;

/// Light below this share of the brightest is dark: its error is relative to the share.
const DARK: f64 = 1e-3;

fn usual_air() -> AtmosphereTable {
    let mut air = unit_sun_air(vec![
        common::molecules(&common::grid()),
        common::haze(AerosolKind::Clear.aerosol(), &common::grid()),
    ]);
    air.ground_albedo = vec![0.2; 3];
    air
}

fn observer(height_m: f64, sun_elevation_deg: f64) -> SkyObserver {
    SkyObserver::from_elevation(height_m, Radians::from_degrees(sun_elevation_deg))
}

fn direction(elevation_deg: f64, azimuth_deg: f64) -> SkyDirection {
    SkyDirection::from_elevation(
        Radians::from_degrees(elevation_deg),
        Radians::from_degrees(azimuth_deg),
    )
}

fn look(dome: &SkyDome, direction: SkyDirection) -> [f32; 3] {
    let mut radiance = [f32::NAN; 3];
    dome.write_radiance(direction, &mut radiance);
    radiance
}

/// Largest error over directions of the whole sphere.
fn worst_error(air: &AtmosphereTable, observer: SkyObserver, tolerance: f64) -> f64 {
    let dome = SkyDome::new(air, observer, tolerance);
    let solver = SingleScattering::new(air, InScattering::STANDARD);
    let directions = spread_directions(Radians::from_degrees(-90.0), 16);
    let exact: Vec<Vec<f64>> = directions
        .iter()
        .map(|&direction| solver.sky_radiance(&observer.ray(direction)))
        .collect();
    let mut worst = 0.0_f64;
    for i in 0..3 {
        let brightest = exact.iter().map(|exact| exact[i]).fold(0.0, f64::max);
        for (&direction, exact) in directions.iter().zip(&exact) {
            let error = f64::from(look(&dome, direction)[i]) - exact[i];
            worst = worst.max(error.abs() / exact[i].max(DARK * brightest));
        }
    }
    worst
}

#[test]
fn a_dome_of_1e_4_holds_it_from_noon_to_sunset_from_below_the_sea_to_an_airliner() {
    let air = usual_air();
    for sun_deg in [60.0, 10.0, 2.0, 0.0] {
        for height_m in [-100.0, 0.0, 2.0, 2e3, 12e3] {
            // Below the sea the sun of 0 degrees stands in the edge of the shadow itself.
            if sun_deg <= 0.0 && height_m < 0.0 {
                continue;
            }
            let worst = worst_error(&air, observer(height_m, sun_deg), 1e-4);
            assert!(
                worst < DOME_TOLERANCE,
                "sun {sun_deg}, height {height_m}: {worst:e}"
            );
        }
    }
}

/// Angle between a direction and the edge of the shadow in front of an observer at sea level: beyond it
/// a ray leaves the air before it leaves the shadow.
fn is_near_shadow_edge(direction: SkyDirection, sun_elevation_deg: f64) -> bool {
    let lit_m = |elevation_deg: f64| {
        let ray = observer(0.0, sun_elevation_deg).ray(SkyDirection {
            cos_zenith: elevation_deg.to_radians().sin(),
            ..direction
        });
        let along = |s: f64| ray.cos_sun_zenith * common::RADIUS_M + s * ray.cos_scattering;
        let end_m = common::exit(0.0, ray.cos_zenith, 100e3);
        let off_axis2 = (common::RADIUS_M + 100e3).powi(2) - along(end_m).powi(2);
        along(end_m) > 0.0 || off_axis2 > common::RADIUS_M.powi(2)
    };
    let elevation_deg = direction.cos_zenith.asin().to_degrees();
    lit_m(elevation_deg - 0.5) != lit_m(elevation_deg + 0.5)
}

#[test]
fn a_dome_of_1e_4_holds_it_in_twilight_half_a_degree_off_the_edge_of_the_shadow() {
    let air = unit_sun_air(vec![
        common::molecules(&common::grid()),
        common::ozone(300.0),
        common::haze(AerosolKind::Clear.aerosol(), &common::grid()),
    ]);
    for sun_deg in [-4.0, -2.0, 0.0] {
        let observer = observer(0.0, sun_deg);
        let dome = SkyDome::new(&air, observer, 1e-4);
        let directions = spread_directions(Radians(0.0), 24);
        let reference = ReferenceSky::new(&air, observer, &directions);
        let exact = reference.radiance();
        let mut brightest = [0.0_f32; 3];
        for exact in exact.chunks(3) {
            for (brightest, light) in brightest.iter_mut().zip(exact) {
                *brightest = brightest.max(*light);
            }
        }
        for (&direction, exact) in directions.iter().zip(exact.chunks(3)) {
            if is_near_shadow_edge(direction, sun_deg) {
                continue;
            }
            let found = look(&dome, direction);
            for i in 0..3 {
                let scale = exact[i].max(1e-3 * brightest[i]);
                let error = f64::from((found[i] - exact[i]).abs() / scale);
                assert!(
                    error < DOME_TOLERANCE,
                    "sun {sun_deg}, {direction:?}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn twilight_and_the_earth_seen_from_space_hold_but_for_the_edge_of_the_shadow() {
    let air = usual_air();
    for (sun_deg, height_m) in [(-4.0, 2.0), (-4.0, 2e3), (60.0, 400e3), (25.0, 400e3)] {
        let worst = worst_error(&air, observer(height_m, sun_deg), 1e-4);
        assert!(
            worst < EDGE_TOLERANCE,
            "sun {sun_deg}, height {height_m}: {worst:e}"
        );
    }
}

#[test]
fn a_coarser_dome_needs_fewer_rays_and_errs_by_more() {
    let air = usual_air();
    let (fine, coarse) = (
        SkyDome::new(&air, observer(2.0, 10.0), 1e-4),
        SkyDome::new(&air, observer(2.0, 10.0), 1e-2),
    );
    assert!(coarse.n_rays() < fine.n_rays());
    assert!(worst_error(&air, observer(2.0, 10.0), 1e-2) < 1e-2);
}

#[test]
fn ground_in_a_vacuum_is_a_diffuse_reflector() {
    let mut vacuum = unit_sun_air(Vec::new());
    vacuum.ground_albedo = vec![0.5; 3];
    let dome = SkyDome::new(&vacuum, observer(100.0, 30.0), 1e-4);
    let expected = 0.5 / std::f64::consts::PI * 0.5;
    for found in look(&dome, direction(-90.0, 0.0)) {
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-6, "{found}");
    }
}

#[test]
fn a_constituent_that_is_off_changes_no_bit() {
    let alone = unit_sun_air(vec![common::molecules(&common::grid())]);
    let mut with_nothing = unit_sun_air(vec![
        common::molecules(&common::grid()),
        common::haze(AerosolKind::Clear.aerosol(), &common::grid()),
    ]);
    let nothing = &mut with_nothing.constituents[1];
    nothing.extinction_m1.fill(0.0);
    nothing.scattering_m1.fill(0.0);
    let ray = observer(2.0, 10.0).ray(direction(15.0, 70.0));
    let radiance = |air| {
        SingleScattering::new(air, InScattering::STANDARD)
            .solve(&ray)
            .radiance
    };
    assert_eq!(radiance(&alone), radiance(&with_nothing));
}

#[test]
fn a_dome_has_the_same_bits_for_any_number_of_threads() {
    let air = usual_air();
    let values = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build();
        let dome = pool
            .unwrap()
            .install(|| SkyDome::new(&air, observer(2.0, 5.0), 1e-2));
        spread_directions(Radians::from_degrees(-90.0), 6)
            .into_iter()
            .map(|direction| look(&dome, direction))
            .collect::<Vec<_>>()
    };
    assert_eq!(values(1), values(3));
}

#[test]
fn methods_have_names_of_their_own_and_their_costs_are_measured_by_the_caller() {
    let labels: std::collections::BTreeSet<String> =
        SkyMethod::ALL.iter().map(|method| method.label()).collect();
    assert_eq!(labels.len(), SkyMethod::ALL.len());

    let air = usual_air();
    let observer = observer(2.0, 20.0);
    let directions = spread_directions(Radians(0.0), 4);
    let reference = ReferenceSky::new(&air, observer, &directions);
    let mut n_measured = 0;
    let mut seconds = |run: &mut dyn FnMut()| {
        run();
        n_measured += 1;
        2.0
    };
    let method = SkyMethod::Rays(InScattering::Midpoint { n_steps: 50 });
    let published = reference.cost(method, &mut seconds);
    assert!(published.worst_error > 1e-3 && published.rms_error < published.worst_error);
    assert!((published.direction_s - 2.0 / 16.0).abs() < 1e-15);
    assert!((published.picture_s(32) - 6.0).abs() < 1e-12);
    let itself = reference.cost(SkyMethod::REFERENCE, &mut seconds);
    assert!(itself.worst_error.abs() <= 0.0);
    assert_eq!(n_measured, 4);
    let exact = PreparedSky::new(&air, observer, SkyMethod::REFERENCE);
    let mut radiance = [0.0; 3];
    exact.write_radiance(directions[0], &mut radiance);
    assert_eq!(radiance, reference.radiance()[..3]);
}
