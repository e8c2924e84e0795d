//! The whole sky by every level against nested adaptive quadrature, with three constituents.

mod common;

use common::adaptive_sky::Density;
use common::adaptive_sky::Layer;
use common::adaptive_sky::Ray;
use common::adaptive_sky::henyey_greenstein;
use common::adaptive_sky::radiance;
use common::adaptive_sky::rayleigh;
use common::unit_sun_air;
use niji_atmosphere::Constituent;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::InScattering;
use niji_atmosphere::PhaseFunction;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::ViewRay;
use niji_exchange::AtmosphereTable;
use niji_exchange::Provenance;
use rayon::iter::IntoParallelRefIterator;
use rayon::iter::ParallelIterator;

/// Whole-sky rays at the default level, none excepted; worst 9.1e-7, sun at 0 degrees.
const SKY_TOLERANCE: f64 = 3e-6;
/// Segments at the default level; worst 6.9e-7, under a sun at 2 degrees.
const SEGMENT_TOLERANCE: f64 = 3e-6;
/// Fixed rules of 16 nodes on each leg of whole-sky rays from the ground; worst 7.5e-7, nested, sun at
/// -1 degree.
const FIXED_TOLERANCE: f64 = 3e-6;

/// Rayleigh scattering at 450, 550 and 650 nm, 1/m, and its scale height and King factor.
const RAYLEIGH_M1: [f64; 3] = [2.6e-5, 1.15e-5, 5.8e-6];
const RAYLEIGH_HEIGHT_M: f64 = 8400.0;
const KING_FACTOR: f64 = 1.049;
/// Extinction at the peak of the ozone tent, 1/m: 300 Dobson units.
const OZONE_M1: [f64; 3] = [1.1e-7, 1.83e-6, 1.36e-6];
const OZONE_HEIGHTS_M: [f64; 3] = [10e3, 25e3, 40e3];
/// Extinction of the aerosol at the ground, 1/m, of which 90 % is scattering.
const AEROSOL_M1: [f64; 3] = [6.3e-5, 5.4e-5, 4.7e-5];
const AEROSOL_ALBEDO: f64 = 0.9;
const AEROSOL_HEIGHT_M: f64 = 1200.0;
const AEROSOL_G: f64 = 0.7;

fn air() -> AtmosphereTable {
    let rayleigh = Constituent {
        name: "rayleigh".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: RAYLEIGH_HEIGHT_M,
        },
        extinction_m1: RAYLEIGH_M1.to_vec(),
        scattering_m1: RAYLEIGH_M1.to_vec(),
        phase: PhaseFunction::Rayleigh {
            king_factor: vec![KING_FACTOR; 3],
        },
    };
    let [bottom_m, peak_m, top_m] = OZONE_HEIGHTS_M;
    let ozone = Constituent {
        name: "ozone".to_owned(),
        profile: DensityProfile::Tent {
            bottom_m,
            peak_m,
            top_m,
        },
        extinction_m1: OZONE_M1.to_vec(),
        scattering_m1: vec![0.0; 3],
        phase: PhaseFunction::Isotropic,
    };
    let aerosol = Constituent {
        name: "aerosol".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: AEROSOL_HEIGHT_M,
        },
        extinction_m1: AEROSOL_M1.to_vec(),
        scattering_m1: AEROSOL_M1.map(|m1| AEROSOL_ALBEDO * m1).to_vec(),
        phase: PhaseFunction::HenyeyGreenstein {
            asymmetry: AEROSOL_G,
        },
    };
    unit_sun_air(vec![rayleigh, ozone, aerosol])
}

fn reference(ray: &ViewRay) -> [f64; 3] {
    let nu = ray.cos_scattering;
    let layers = [
        Layer {
            density: Density::Exponential(RAYLEIGH_HEIGHT_M),
            extinction_m1: RAYLEIGH_M1,
            directed_m1: RAYLEIGH_M1.map(|m1| m1 * rayleigh(KING_FACTOR, nu)),
        },
        Layer {
            density: Density::Tent(OZONE_HEIGHTS_M),
            extinction_m1: OZONE_M1,
            directed_m1: [0.0; 3],
        },
        Layer {
            density: Density::Exponential(AEROSOL_HEIGHT_M),
            extinction_m1: AEROSOL_M1,
            directed_m1: AEROSOL_M1
                .map(|m1| AEROSOL_ALBEDO * m1 * henyey_greenstein(AEROSOL_G, nu)),
        },
    ];
    radiance(
        &layers,
        &Ray {
            height_m: ray.height_m,
            mu: ray.cos_zenith,
            mu_s: ray.cos_sun_zenith,
            nu,
            length_m: ray.length_m,
        },
    )
}

fn rays(height_m: f64, view_elevations_deg: &[f64], sun_deg: f64) -> Vec<ViewRay> {
    let mut rays = Vec::new();
    for view_deg in view_elevations_deg {
        for azimuth_deg in [0.0_f64, 60.0, 180.0] {
            let angles = [*view_deg, sun_deg, azimuth_deg].map(f64::to_radians);
            rays.push(ViewRay::from_angles(height_m, angles, f64::INFINITY));
        }
    }
    rays
}

/// The air as it is, and after a file of f32.
fn in_f64_and_f32() -> [AtmosphereTable; 2] {
    let air = air();
    let file = air.to_file(Provenance::default());
    let read = AtmosphereTable::from_file(&file).expect("it was just written");
    [air, read]
}

/// Largest relative error of a method over rays and wavelengths; where the reference is black, the
/// method must be.
fn worst_error(air: &AtmosphereTable, method: InScattering, solved: &[(ViewRay, [f64; 3])]) -> f64 {
    let solver = SingleScattering::new(air, method);
    let mut worst = 0.0_f64;
    for (ray, expected) in solved {
        let found = solver.solve(ray).radiance;
        for (found, expected) in found.into_iter().zip(expected) {
            if *expected > 0.0 {
                worst = worst.max((found / expected - 1.0).abs());
            } else {
                assert!(found.abs() <= 0.0, "{found:e} where it is black: {ray:?}");
            }
        }
    }
    worst
}

fn solved(rays: &[ViewRay]) -> Vec<(ViewRay, [f64; 3])> {
    rays.par_iter().map(|ray| (*ray, reference(ray))).collect()
}

#[test]
fn the_default_level_holds_over_the_whole_sky_at_any_height_under_any_sun() {
    let airs = in_f64_and_f32();
    for sun_deg in [60.0, 10.0, 2.0, 0.0, -1.0, -5.0] {
        for (height_m, views_deg) in [
            (-100.0, [90.0, 45.0, 10.0, 2.0, 0.5]),
            (0.0, [90.0, 45.0, 10.0, 2.0, 0.5]),
            (2e3, [90.0, 10.0, 0.5, -1.0, -5.0]),
            (12e3, [90.0, 10.0, 0.5, -2.0, -50.0]),
            (400e3, [5.0, -19.0, -19.9, -40.0, -90.0]),
        ] {
            let solved = solved(&rays(height_m, &views_deg, sun_deg));
            for air in &airs {
                let worst = worst_error(air, InScattering::STANDARD, &solved);
                assert!(
                    worst < SKY_TOLERANCE,
                    "sun {sun_deg}, height {height_m}: {worst:e}"
                );
            }
        }
    }
}

#[test]
fn segments_of_20_m_to_500_km_hold_in_air_of_three_constituents() {
    let airs = in_f64_and_f32();
    for sun_deg in [40.0, 10.0, 2.0] {
        for height_m in [0.0, 2.0, 3e3] {
            let mut segments = rays(height_m, &[0.3, 5.0, 40.0], sun_deg);
            let lengths_m = [20.0, 300.0, 3e3, 12e3, 60e3, 500e3];
            segments = segments
                .into_iter()
                .flat_map(|ray| lengths_m.map(|length_m| ViewRay { length_m, ..ray }))
                .collect();
            let solved = solved(&segments);
            for air in &airs {
                let worst = worst_error(air, InScattering::STANDARD, &solved);
                assert!(
                    worst < SEGMENT_TOLERANCE,
                    "sun {sun_deg}, height {height_m}: {worst:e}"
                );
            }
        }
    }
}

#[test]
fn fixed_levels_hold_under_any_sun_because_rays_are_cut_where_columns_have_kinks() {
    let air = air();
    let worst = |method: InScattering, sun_deg: f64| {
        let rays = rays(0.0, &[90.0, 45.0, 10.0, 2.0, 0.5], sun_deg);
        worst_error(&air, method, &solved(&rays))
    };
    let sixteen = InScattering::Quadrature { n_nodes: 16 };
    let nested = InScattering::Nested {
        n_nodes: 16,
        n_sun_nodes: 12,
    };
    for sun_deg in [60.0, 2.0, -1.0, -4.0] {
        for method in [sixteen, nested] {
            let found = worst(method, sun_deg);
            assert!(
                found < FIXED_TOLERANCE,
                "sun {sun_deg}, {method:?}: {found:e}"
            );
        }
    }
    let published = worst(InScattering::Midpoint { n_steps: 50 }, 60.0);
    assert!((1e-2..0.3).contains(&published), "{published:e}");
}
