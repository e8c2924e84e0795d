//! Light of all orders against published fluxes, conservation laws and itself at a finer level.

use std::f64::consts::PI;

use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirComponent;
use niji_atmosphere::AirModel;
use niji_atmosphere::Constituent;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::DiffuseLight;
use niji_atmosphere::InScattering;
use niji_atmosphere::PhaseFunction;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::ViewRay;
use niji_atmosphere::sun_transmittance;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_geometry::Planet;
use niji_radiometry::Radians;
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
        cases.len(),
        ground_albedo,
        vec![AirComponent::Custom(constituent)],
    )
}

fn air(
    planet: Planet,
    n_wavelengths: usize,
    ground_albedo: f64,
    components: Vec<AirComponent>,
) -> AtmosphereTable {
    let model = AirModel {
        planet,
        top_height_m: USUAL_TOP_M,
        wavelengths: WavelengthGrid::new(450.0, 100.0, n_wavelengths).expect("within the tables"),
        sun_scale: 1.0,
        ground_albedo,
        components,
    };
    model.tabulate().expect("air that can exist")
}

/// Rayleigh air with haze over a ground of albedo 0.3.
fn hazy() -> AtmosphereTable {
    let haze = AerosolKind::Rural.aerosol();
    air(
        EARTH,
        3,
        0.3,
        vec![AirComponent::STANDARD_RAYLEIGH, AirComponent::Aerosol(haze)],
    )
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

/// Largest error of a flux over the beam's through the top, measured: 3.1e-3.
const FLUX_ERROR: f64 = 5e-3;

#[test]
fn fluxes_agree_with_published_slabs() {
    for problem in published() {
        let table = slab(problem.phase.clone(), &problem.cases, 0.0);
        let diffuse = DiffuseLight::new(&table, ScatteringOrders::STANDARD);
        let down = diffuse.ground_irradiance(problem.cos_sun);
        let net = diffuse.net_flux(USUAL_TOP_M, problem.cos_sun);
        for (i, expected) in problem.fluxes.iter().enumerate() {
            let found = [down[i] / problem.cos_sun, -net[i] / problem.cos_sun];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < FLUX_ERROR);
            }
        }
    }
}

/// Largest change of the net flux with height, over the beam's through the top; measured: 9.0e-3.
const FLUX_LOSS: f64 = 0.012;

#[test]
fn air_that_does_not_absorb_keeps_its_net_flux() {
    for ground_albedo in [0.0, 0.3, 1.0] {
        let table = slab(
            rayleigh(3),
            &[[0.1, 1.0], [0.4, 1.0], [1.0, 1.0]],
            ground_albedo,
        );
        let diffuse = DiffuseLight::new(&table, ScatteringOrders::DRAFT);
        for cos_sun in [1.0, 0.5_f64] {
            let nets = [0.0, 900.0, 5_200.0, USUAL_TOP_M].map(|height_m| {
                let beam = sun_transmittance(&table, height_m, cos_sun, Radians(0.0));
                let net = diffuse.net_flux(height_m, cos_sun).into_iter().zip(beam);
                net.map(|(net, beam)| net / cos_sun + beam)
                    .collect::<Vec<_>>()
            });
            for net in &nets {
                for (i, found) in net.iter().enumerate() {
                    assert!((found - nets[0][i]).abs() < FLUX_LOSS, "{nets:?}");
                    let kept = if ground_albedo < 1.0 {
                        *found
                    } else {
                        1.0 - found.abs()
                    };
                    assert!(kept > 0.05, "a white ground absorbs nothing: {nets:?}");
                }
            }
        }
    }
}

/// Largest difference of a pair, measured: 2.6e-2.
const RECIPROCITY_ERROR: f64 = 0.03;

#[test]
fn reflection_is_reciprocal() {
    let table = slab(rayleigh(3), &[[0.1, 1.0], [0.4, 1.0], [1.0, 0.9]], 0.0);
    let diffuse = DiffuseLight::new(&table, ScatteringOrders::DRAFT);
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
            assert!((there / back - 1.0).abs() < RECIPROCITY_ERROR);
        }
    }
}

/// Largest difference of a hazy sky, all orders, between levels; measured: 0.105.
const LEVEL_ERROR: f64 = 0.12;

#[test]
fn the_coarse_level_agrees_with_the_default_in_hazy_air() {
    let table = hazy();
    let [coarse, standard] = [ScatteringOrders::DRAFT, ScatteringOrders::STANDARD]
        .map(|level| DiffuseLight::new(&table, level));
    let single = SingleScattering::new(&table, InScattering::STANDARD);
    let mut worst = 0.0_f64;
    for sun_deg in [2.0, 20.0, 60.0, 90.0] {
        for view_deg in [2.0, 15.0, 45.0, 90.0] {
            for azimuth_deg in [10.0, 90.0, 180.0_f64] {
                let angles_rad = [view_deg, sun_deg, azimuth_deg].map(f64::to_radians);
                let ray = ViewRay::from_angles(0.0, angles_rad, f64::INFINITY);
                let once = single.solve(&ray).radiance;
                let [found, exact] = [&coarse, &standard].map(|light| light.radiance_per_sun(&ray));
                for (i, (once, sun)) in once.iter().zip(&table.sun_irradiance).enumerate() {
                    let error = (found[i] - exact[i]).abs() / (once / sun + exact[i]);
                    worst = worst.max(error);
                }
            }
        }
    }
    assert!(worst < LEVEL_ERROR, "{worst}");
}

#[test]
fn light_fades_through_twilight_without_a_jump() {
    let table = hazy();
    let diffuse = DiffuseLight::new(&table, ScatteringOrders::DRAFT);
    let mut before = f64::INFINITY;
    for tenth in 0..400 {
        let zenith = (80.0 + 0.1 * f64::from(tenth)).to_radians();
        let light = diffuse.ground_irradiance(zenith.cos())[0];
        assert!(
            light >= 0.0 && light <= before,
            "{tenth}: {light} after {before}"
        );
        if tenth > 0 && tenth < 180 {
            assert!(light > 0.8 * before, "{tenth}: {light} after {before}");
        }
        before = light;
    }
    assert!(before <= 0.0, "night: {before}");
}

#[test]
fn no_ray_gets_a_number_that_is_none() {
    let thick = |ground_albedo| {
        slab(
            rayleigh(3),
            &[[1e-9, 0.0], [5.0, 1.0], [40.0, 1.0]],
            ground_albedo,
        )
    };
    let tables = [
        hazy(),
        thick(0.0),
        thick(1.0),
        air(EARTH, 3, 1.0, Vec::new()),
    ];
    for table in &tables {
        let diffuse = DiffuseLight::new(table, ScatteringOrders::DRAFT);
        for height_m in [-400.0, 0.0, 2e3, 1e5, 4e5] {
            for sun_deg in [-90.0, -30.0, -6.0, -0.1, 0.0, 90.0] {
                for view_deg in [-90.0, -10.0, -1e-9, 0.0, 3.0, 90.0_f64] {
                    for length_m in [0.0, 20.0, 1e4, f64::INFINITY] {
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

#[test]
fn a_vacuum_has_no_diffuse_light() {
    let table = air(EARTH, 2, 1.0, Vec::new());
    let diffuse = DiffuseLight::new(&table, ScatteringOrders::DRAFT);
    assert!(
        diffuse
            .ground_irradiance(0.5)
            .iter()
            .all(|&light| light <= 0.0)
    );
}
