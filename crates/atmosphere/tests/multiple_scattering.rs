//! Light of all orders against published fluxes, discrete ordinates and conservation laws.

mod common;

use std::convert::Infallible;
use std::f64::consts::PI;
use std::sync::Mutex;

use common::grid;
use common::haze;
use common::molecules;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirModel;
use niji_atmosphere::Constituent;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::DiffuseDome;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::PhaseFunction;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::SkyDirection;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::Suns;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::ViewRay;
use niji_atmosphere::diffuse_light;
use niji_atmosphere::diffuse_light_while;
use niji_atmosphere::sun_transmittance;
use niji_atmosphere::with_diffuse_light;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_geometry::Planet;
use niji_radiometry::Radians;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

/// A planet on which the air is plane.
const PLANE: Planet = Planet { radius_m: 1e9 };
/// Scale height of the slabs, m.
const SCALE_HEIGHT_M: f64 = 8000.0;

/// A slab on a planet, one case of optical depth and single-scattering albedo for each wavelength.
fn slab(phase: PhaseFunction, cases: &[[f64; 2]], ground_albedo: f64) -> AtmosphereTable {
    let constituent = Constituent {
        name: "slab".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: SCALE_HEIGHT_M,
        },
        extinction_m1: cases.iter().map(|case| case[0] / SCALE_HEIGHT_M).collect(),
        scattering_m1: cases
            .iter()
            .map(|case| case[0] * case[1] / SCALE_HEIGHT_M)
            .collect(),
        phase,
    };
    air(
        PLANE,
        WavelengthGrid::new(450.0, 100.0, cases.len()).expect("within the tables"),
        ground_albedo,
        vec![constituent],
    )
}

fn air(
    planet: Planet,
    wavelengths: WavelengthGrid,
    ground_albedo: f64,
    constituents: Vec<Constituent>,
) -> AtmosphereTable {
    let model = AirModel {
        planet,
        top_height_m: USUAL_TOP_M,
        wavelengths,
        sun_scale: 1.0,
        ground: Reflectance::Even(ground_albedo),
        constituents,
    };
    model.tabulate().expect("air that can exist")
}

/// Rayleigh air with haze over a ground of albedo 0.3.
fn hazy() -> AtmosphereTable {
    let haze = haze(AerosolKind::Rural.aerosol(), &grid());
    air(EARTH, grid(), 0.3, vec![molecules(&grid()), haze])
}

fn rayleigh(n_wavelengths: usize) -> PhaseFunction {
    PhaseFunction::Rayleigh {
        king_factor: vec![1.0; n_wavelengths],
    }
}

/// Downward and upward diffuse fluxes of published problems, over mu_0 times the beam.
struct Published {
    phase: PhaseFunction,
    cos_sun: f64,
    /// Optical depth and single-scattering albedo.
    cases: Vec<[f64; 2]>,
    fluxes: Vec<[f64; 2]>,
}

/// Test problems 1, 2 and 3 of DISORT: Stamnes, Tsay, Wiscombe and Jayaweera, Appl. Opt. 27,
/// 2502-2509 (1988); values of van de Hulst, Multiple Light Scattering (1980), and Sweigart,
/// Astrophys. J. Suppl. 22, 1-80 (1970).
fn published() -> [Published; 3] {
    let over =
        |scale: f64, fluxes: &[[f64; 2]]| fluxes.iter().map(|f| f.map(|f| f / scale)).collect();
    [
        Published {
            phase: PhaseFunction::Isotropic,
            cos_sun: 0.1,
            cases: vec![[0.03125, 0.2], [0.03125, 1.0]],
            fluxes: over(PI, &[[0.079_410_8, 0.079_945_1], [0.420_233, 0.422_922]]),
        },
        Published {
            phase: rayleigh(2),
            cos_sun: 0.080_442,
            cases: vec![[0.2, 0.5], [0.2, 1.0]],
            fluxes: over(
                0.080_442 * PI,
                &[[0.044_179_1, 0.053_506_3], [0.106_123, 0.125_561]],
            ),
        },
        Published {
            phase: PhaseFunction::HenyeyGreenstein { asymmetry: 0.75 },
            cos_sun: 1.0,
            cases: vec![[1.0, 1.0]],
            fluxes: over(PI, &[[1.738_49, 0.247_374]]),
        },
    ]
}

/// Enough for fluxes.
const COARSE: ScatteringOrders = ScatteringOrders {
    n_layers: 12,
    n_zeniths: 6,
    max_degree: 6,
    tolerance: 2e-3,
};
/// Largest error of a flux over the beam's through the top; measured: 3.3e-3.
const FLUX_ERROR: f64 = 5e-3;

#[test]
fn fluxes_agree_with_published_slabs() {
    for problem in published() {
        let table = slab(problem.phase.clone(), &problem.cases, 0.0);
        let diffuse = diffuse_light(&table, COARSE);
        let down = diffuse.ground_irradiance(problem.cos_sun);
        let net = diffuse.net_flux(USUAL_TOP_M, problem.cos_sun);
        for (i, expected) in problem.fluxes.iter().enumerate() {
            let found = [f64::from(down[i]), -net[i]].map(|flux| flux / problem.cos_sun);
            for (found, expected) in found.into_iter().zip(expected) {
                let error = found - expected;
                assert!(error.abs() < FLUX_ERROR, "{found} {expected}");
            }
        }
    }
}

/// Zenith angle and azimuth of the views of the tables below.
const VIEWS_DEG: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [45.0, 0.0],
    [45.0, 90.0],
    [75.0, 0.0],
    [75.0, 90.0],
    [75.0, 180.0],
];
// Radiance of all orders at the ground over the sun's irradiance, 1/sr, by discrete ordinates with 32
// streams and 28 layers (tests/peers/air_disort.py): rows for 450 nm with the sun 40 and 60 degrees
// from the zenith, then for 650 nm.
/// Molecules over a ground of albedo 0.8.
const CLEAR_SKY: [[f64; 6]; 4] = [
    [
        4.0237e-2, 6.0596e-2, 5.1136e-2, 1.2203e-1, 1.0386e-1, 1.0804e-1,
    ],
    [
        2.8287e-2, 4.7444e-2, 3.7275e-2, 1.0228e-1, 7.7938e-2, 9.0959e-2,
    ],
    [
        9.4016e-3, 1.4744e-2, 1.2123e-2, 3.5043e-2, 2.8927e-2, 3.0305e-2,
    ],
    [
        6.7788e-3, 1.2073e-2, 9.0890e-3, 3.1255e-2, 2.2523e-2, 2.7160e-2,
    ],
];
/// Molecules and maritime haze of 10 km of visibility over black ground.
const HAZY_SKY: [[f64; 6]; 4] = [
    [
        9.7648e-2, 5.1091e-1, 7.7059e-2, 2.1708e-1, 7.3930e-2, 5.5515e-2,
    ],
    [
        4.6574e-2, 2.6942e-1, 5.2532e-2, 3.2010e-1, 5.8558e-2, 4.6908e-2,
    ],
    [
        8.7839e-2, 5.9403e-1, 6.1074e-2, 2.5028e-1, 6.2294e-2, 3.8839e-2,
    ],
    [
        3.6433e-2, 3.3621e-1, 4.0354e-2, 4.7491e-1, 5.3585e-2, 3.4534e-2,
    ],
];
/// Largest relative difference of all light from discrete ordinates; measured: 1.4e-2, and 4e-4
/// without haze.
const SKY_ERROR: f64 = 0.02;

#[test]
fn skies_agree_with_discrete_ordinates() {
    let grid = WavelengthGrid::new(450.0, 200.0, 2).expect("within the tables");
    let hazy = |kind: AerosolKind| {
        let aerosol = kind.aerosol().with_visibility_m(10e3);
        let haze = haze(aerosol.expect("less than clean air"), &grid);
        vec![molecules(&grid), haze]
    };
    let clear = vec![molecules(&grid)];
    for (constituents, albedo, expected) in [
        (clear, 0.8, CLEAR_SKY),
        (hazy(AerosolKind::Maritime), 0.0, HAZY_SKY),
    ] {
        let table = with_diffuse_light(
            air(PLANE, grid, albedo, constituents),
            ScatteringOrders::STANDARD,
        );
        for (row, expected) in expected.iter().enumerate() {
            let sun_deg = [40.0, 60.0][row % 2];
            for ([view_deg, azimuth_deg], expected) in VIEWS_DEG.into_iter().zip(expected) {
                let angles_deg = [90.0 - view_deg, 90.0 - sun_deg, azimuth_deg];
                let found = all_light(&table, 0.0, angles_deg)[row / 2];
                let error = found / expected - 1.0;
                assert!(
                    error.abs() < SKY_ERROR,
                    "row {row}, view {view_deg} {azimuth_deg}: {error}"
                );
            }
        }
    }
}

/// Largest difference over the brightest sky of light for the suns that are seen; measured: 1e-5, of a sun that has set.
const OF_SEEN: f64 = 2e-5;

#[test]
fn light_for_the_suns_that_are_seen_is_that_for_all() {
    // As many orders for both: more than each needs.
    let level = ScatteringOrders {
        tolerance: 1e-6,
        ..ScatteringOrders::DRAFT
    };
    let table = hazy();
    let solved = |suns| {
        let go_on = |_| Ok::<_, Infallible>(());
        let diffuse = diffuse_light_while(go_on, &table, level, suns);
        AtmosphereTable {
            diffuse: diffuse.ok(),
            ..table.clone()
        }
    };
    let of_all = solved(Suns::All);
    for (sun_deg, height_m) in [
        (-3.0, 2.0),
        (1.0, 3e3),
        (20.0, 2.0),
        (41.0, 12e3),
        (80.0, 2.0),
    ] {
        let of_seen = solved(Suns::SeenFrom {
            height_m,
            sun_zenith: Radians::from_degrees(90.0 - sun_deg),
        });
        let (mut worst, mut brightest) = (0.0_f64, 0.0_f64);
        for elevation_deg in [-4.0, -1.0, 0.1, 2.0, 15.0, 60.0] {
            for azimuth_deg in [0.0, 70.0, 130.0, 180.0] {
                let angles_deg = [elevation_deg, sun_deg, azimuth_deg];
                let [found, expected] =
                    [&of_seen, &of_all].map(|air| all_light(air, height_m, angles_deg));
                for (found, expected) in found.into_iter().zip(expected) {
                    worst = worst.max((found - expected).abs());
                    brightest = brightest.max(expected);
                }
            }
        }
        assert!(
            worst < OF_SEEN * brightest,
            "{sun_deg}: {}",
            worst / brightest
        );
    }
}

/// Largest share of the sunlight that is lost at the draft level; measured: 7.0e-3.
const FLUX_LOSS: f64 = 0.01;

#[test]
fn air_that_does_not_absorb_keeps_its_net_flux() {
    for ground_albedo in [0.0, 0.3, 1.0] {
        let cases = [[0.1, 1.0], [0.4, 1.0], [1.0, 1.0]];
        let table = slab(rayleigh(3), &cases, ground_albedo);
        let diffuse = diffuse_light(&table, ScatteringOrders::DRAFT);
        for cos_sun in [1.0, 0.5_f64] {
            let nets = [0.0, 900.0, 5_200.0, USUAL_TOP_M].map(|height_m| {
                let beam = sun_transmittance(&table, height_m, cos_sun, Radians(0.0));
                let net = diffuse.net_flux(height_m, cos_sun).into_iter().zip(beam);
                net.map(|(net, beam)| net / cos_sun + beam)
                    .collect::<Vec<_>>()
            });
            for net in &nets {
                for (found, at_ground) in net.iter().zip(&nets[0]) {
                    assert!((found - at_ground).abs() < FLUX_LOSS, "{nets:?}");
                }
            }
        }
    }
}

#[test]
fn over_white_ground_air_that_does_not_absorb_gives_all_light_back() {
    let table = slab(rayleigh(3), &[[1e-3, 1.0], [0.3, 1.0], [1.0, 1.0]], 1.0);
    let diffuse = diffuse_light(&table, ScatteringOrders::DRAFT);
    for cos_sun in [1.0, 0.6, 0.3] {
        let upward = diffuse.net_flux(USUAL_TOP_M, cos_sun);
        for returned in upward.into_iter().map(|net| -net / cos_sun) {
            assert!((returned - 1.0).abs() < FLUX_LOSS, "{cos_sun}: {returned}");
        }
    }
}

/// Largest difference of a pair; measured: 1.5e-3.
const RECIPROCITY_ERROR: f64 = 3e-3;

#[test]
fn reflection_is_reciprocal() {
    let cases = [[0.1, 1.0], [0.4, 1.0], [1.0, 0.9]];
    let table = with_diffuse_light(slab(rayleigh(3), &cases, 0.0), ScatteringOrders::DRAFT);
    let diffuse = DiffuseSky::new(&table).expect("just solved");
    let seen_from_above = |view_deg: f64, sun_deg: f64| {
        let angles_rad = [view_deg - 90.0, 90.0 - sun_deg, 120.0].map(f64::to_radians);
        let ray = ViewRay::from_angles(USUAL_TOP_M, angles_rad, f64::INFINITY);
        let radiance = diffuse.radiance_per_sun(&ray);
        radiance
            .into_iter()
            .map(move |radiance| radiance / sun_deg.to_radians().cos())
    };
    for (view_deg, sun_deg) in [(20.0, 60.0), (0.0, 45.0), (70.0, 30.0)] {
        let pairs = seen_from_above(view_deg, sun_deg).zip(seen_from_above(sun_deg, view_deg));
        for (there, back) in pairs {
            let error = there / back - 1.0;
            assert!(error.abs() < RECIPROCITY_ERROR, "{error}");
        }
    }
}

#[test]
fn thin_air_scatters_once() {
    let depths = [1e-12, 1e-4, 1e-3];
    let table = slab(rayleigh(3), &depths.map(|depth| [depth, 1.0]), 0.0);
    let table = with_diffuse_light(table, ScatteringOrders::DRAFT);
    let single = SingleScattering::new(&table, InScattering::STANDARD);
    let diffuse = DiffuseSky::new(&table).expect("just solved");
    for view_deg in [15.0, 50.0, 90.0_f64] {
        let angles_rad = [view_deg, 40.0, 70.0].map(f64::to_radians);
        let ray = ViewRay::from_angles(0.0, angles_rad, f64::INFINITY);
        let once = single.solve(&ray).radiance;
        let more = diffuse.radiance_per_sun(&ray);
        for (i, depth) in depths.into_iter().enumerate() {
            // Mean path of diffuse light through a slab: some depths ln(1/depth).
            let share = more[i] / (once[i] / table.sun_irradiance[i]);
            assert!(share >= 0.0 && share < 8.0 * depth * (1.0 - depth.ln()));
        }
    }
}

#[test]
fn brighter_ground_makes_a_brighter_sky() {
    let mut darker = [0.0; 3];
    for ground_albedo in [0.0, 0.1, 0.5, 1.0] {
        let rayleigh = vec![molecules(&grid())];
        let table = air(EARTH, grid(), ground_albedo, rayleigh);
        let table = with_diffuse_light(table, ScatteringOrders::DRAFT);
        let diffuse = DiffuseSky::new(&table).expect("just solved");
        let ray = ViewRay::from_angles(0.0, [0.8, 0.6, 2.0], f64::INFINITY);
        for (found, darker) in diffuse.radiance_per_sun(&ray).into_iter().zip(&mut darker) {
            assert!(found > 1.02 * *darker, "{ground_albedo}: {found} {darker}");
            *darker = found;
        }
    }
}

#[test]
fn light_fades_through_twilight_without_a_jump() {
    let table = with_diffuse_light(hazy(), ScatteringOrders::DRAFT);
    let diffuse = table.diffuse.as_ref().expect("just solved");
    let sky = DiffuseSky::new(&table).expect("just solved");
    let (mut before, mut sky_before) = (f64::INFINITY, f64::INFINITY);
    for tenth in 0..400 {
        let zenith = (80.0 + 0.1 * f64::from(tenth)).to_radians();
        let light = f64::from(diffuse.ground_irradiance(zenith.cos())[0]);
        let ray = ViewRay::from_angles(0.0, [0.5, PI / 2.0 - zenith, 1.0], f64::INFINITY);
        let above = sky.radiance_per_sun(&ray)[0];
        for (now, before) in [(light, before), (above, sky_before)] {
            assert!(now >= 0.0 && now <= before, "{tenth}: {now} after {before}");
            if tenth > 0 && tenth < 180 {
                assert!(now > 0.8 * before, "{tenth}: {now} after {before}");
            }
        }
        (before, sky_before) = (light, above);
    }
    assert!(before <= 0.0 && sky_before <= 0.0, "night: {before}");
}

#[test]
fn no_ray_gets_a_number_that_is_none() {
    let thick = |ground_albedo| {
        let cases = [[1e-12, 0.0], [5.0, 1.0], [1e3, 1.0]];
        slab(rayleigh(3), &cases, ground_albedo)
    };
    let vacuum = air(EARTH, grid(), 1.0, Vec::new());
    for table in [hazy(), thick(0.0), thick(1.0), vacuum] {
        let table = with_diffuse_light(table, ScatteringOrders::DRAFT);
        let diffuse = DiffuseSky::new(&table).expect("just solved");
        for height_m in [-400.0, 0.0, 2e3, 1e5, 4e5] {
            for sun_deg in [-90.0, -30.0, -6.0, -0.1, 0.0, 90.0] {
                for view_deg in [-90.0, -10.0, -1e-9, 0.0, 3.0, 90.0_f64] {
                    for length_m in [0.0, 20.0, f64::INFINITY] {
                        let angles_rad = [view_deg, sun_deg, 30.0].map(f64::to_radians);
                        let ray = ViewRay::from_angles(height_m, angles_rad, length_m);
                        for radiance in diffuse.radiance_per_sun(&ray) {
                            assert!((0.0..1.0).contains(&radiance), "{ray:?}: {radiance}");
                        }
                    }
                }
            }
        }
    }
}

/// Largest difference of the dome from rays, over all light; measured: 3.4e-4.
const DOME_ERROR: f64 = 1e-3;

#[test]
fn the_dome_holds_what_rays_find() {
    let table = with_diffuse_light(hazy(), ScatteringOrders::DRAFT);
    let single = SingleScattering::new(&table, InScattering::STANDARD);
    let sky = DiffuseSky::new(&table).expect("just solved");
    for (height_m, sun_deg) in [(2.0, 20.0), (2.0, 0.0), (2e3, 60.0), (2.0, -4.0)] {
        let observer = SkyObserver::from_elevation(height_m, Radians::from_degrees(sun_deg));
        let dome = DiffuseDome::new(&table, observer).expect("just solved");
        for view_deg in [-80.0, -33.0, -7.0, 1.0, 4.0, 13.0, 41.0, 77.0] {
            for azimuth_deg in [-2.0, 13.0, 67.0, 144.0] {
                let [view, azimuth] = [view_deg, azimuth_deg].map(Radians::from_degrees);
                let direction = SkyDirection::from_elevation(view, azimuth);
                let mut found = vec![0.0_f32; 3];
                dome.add_radiance(direction, &mut found);
                let ray = observer.ray(direction);
                let once = single.sky_radiance(&ray);
                let exact = sky.radiance_per_sun(&ray);
                for (i, found) in found.into_iter().enumerate() {
                    let exact = exact[i] * table.sun_irradiance[i];
                    let error = (f64::from(found) - exact) / (exact + once[i]);
                    assert!(error.abs() < DOME_ERROR, "{sun_deg} {direction:?}: {error}");
                }
            }
        }
    }
}

#[test]
fn a_vacuum_over_black_ground_has_no_diffuse_light() {
    let two = WavelengthGrid::new(450.0, 100.0, 2).expect("within the tables");
    let table = air(EARTH, two, 0.0, Vec::new());
    let diffuse = diffuse_light(&table, ScatteringOrders::DRAFT);
    assert!(diffuse.moments.iter().all(|&moment| moment == 0.0));
}

#[test]
fn a_table_without_diffuse_light_is_no_sky_of_all_orders() {
    let error = DiffuseSky::new(&hazy()).map(|_| ());
    assert_eq!(error, Err(niji_atmosphere::Error::NoDiffuseLight));
}

/// Radiance of all orders over the sun's irradiance by wavelength, 1/sr.
fn all_light(table: &AtmosphereTable, height_m: f64, angles_deg: [f64; 3]) -> Vec<f64> {
    let ray = ViewRay::from_angles(height_m, angles_deg.map(f64::to_radians), f64::INFINITY);
    let once = SingleScattering::new(table, InScattering::STANDARD).solve(&ray);
    let more = DiffuseSky::new(table).expect("solved before");
    let more = more.radiance_per_sun(&ray).into_iter();
    let suns = once.radiance.iter().zip(&table.sun_irradiance);
    more.zip(suns)
        .map(|(more, (once, sun))| more + once / sun)
        .collect()
}

#[test]
fn the_part_that_is_done_goes_from_0_to_1() {
    let heard = Mutex::new(Vec::new());
    let go_on = |part: f64| {
        heard.lock().unwrap().push(part);
        Ok::<_, Infallible>(())
    };
    diffuse_light_while(go_on, &hazy(), ScatteringOrders::STANDARD, Suns::All).unwrap();
    let mut heard = heard.into_inner().unwrap();
    assert_eq!((heard[0], heard[heard.len() - 1]), (0.0, 1.0));
    assert!(heard.windows(2).all(|pair| pair[0] <= pair[1]), "{heard:?}");
    heard.dedup();
    // One a further order.
    assert!(heard.len() >= 4, "{heard:?}");
    // Air without light is done at once.
    let dark = Mutex::new(Vec::new());
    let go_on = |part: f64| {
        dark.lock().unwrap().push(part);
        Ok::<_, Infallible>(())
    };
    let vacuum = AtmosphereTable {
        constituents: Vec::new(),
        ..hazy()
    };
    diffuse_light_while(go_on, &vacuum, ScatteringOrders::DRAFT, Suns::All).unwrap();
    assert_eq!(dark.into_inner().unwrap().last(), Some(&1.0));
}
