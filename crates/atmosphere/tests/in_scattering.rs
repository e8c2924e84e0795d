//! Light scattered into view rays against nested adaptive quadrature and published values.

mod common;

use std::f64::consts::PI;

use common::NISHITA_HEIGHT_M;
use common::RADIUS_M;
use common::adaptive;
use common::exit;
use common::height;
use common::nishita;
use common::unit_sun_air;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::InScattering;
use niji_atmosphere::SUN_RADIUS;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::ViewRay;
use niji_atmosphere::chapman_erfcx;
use niji_atmosphere::sun_transmittance;
use niji_exchange::AtmosphereTable;

const TWELVE: InScattering = InScattering::Quadrature { n_nodes: 12 };
const SIXTEEN: InScattering = InScattering::Quadrature { n_nodes: 16 };

/// Whole-sky rays with 12 nodes over sun, view and wavelength; worst 3.5e-5.
const TWELVE_NODES_TOLERANCE: f64 = 1e-4;
/// The same with 16 nodes; worst 2.7e-7.
const SIXTEEN_NODES_TOLERANCE: f64 = 1e-6;
/// Segments of 20 m to 500 km with 16 nodes.
const SEGMENT_TOLERANCE: f64 = 1e-5;
/// Haze of 20 km to 50 m of visibility, 16 nodes against 64; worst 3.2e-4, fog seen from 30 km.
const HAZE_TOLERANCE: f64 = 5e-4;

fn angles(view_deg: f64, sun_deg: f64, azimuth_deg: f64) -> [f64; 3] {
    [
        view_deg.to_radians(),
        sun_deg.to_radians(),
        azimuth_deg.to_radians(),
    ]
}

/// Radiance per irradiance in the papers' air at wavelength `index`, by nested adaptive quadrature.
///
/// The sun's column is the table's, whose error against quadrature is tested with the columns.
fn reference(air: &AtmosphereTable, index: usize, ray: &ViewRay, end_m: f64) -> f64 {
    let beta = air.constituents[0].extinction_m1[index];
    let (h0, mu) = (ray.height_m, ray.cos_zenith);
    let density = |s: f64| (-height(h0, mu, s) / NISHITA_HEIGHT_M).exp();
    let phase = 3.0 / (16.0 * PI) * (1.0 + ray.cos_scattering.powi(2));
    let last = end_m.sqrt();
    // Optical depth of the view ray at equal steps of t = sqrt(s), then by Simpson from the nearest.
    let n = 4000;
    let step = last / f64::from(n);
    let slope = |t: f64| 2.0 * t * density(t * t);
    let mut depth = vec![0.0];
    for i in 0..n {
        let t = f64::from(i) * step;
        let piece = slope(t) + 4.0 * slope(t + 0.5 * step) + slope(t + step);
        depth.push(depth[i as usize] + step / 6.0 * piece);
    }
    let view_length = |t: f64| {
        let i = ((t / step) as usize).min(n as usize - 1);
        let from = i as f64 * step;
        let width = t - from;
        let middle = slope(from + 0.5 * width);
        depth[i] + width / 6.0 * (slope(from) + 4.0 * middle + slope(t))
    };
    let source = |t: f64| {
        let s = t * t;
        let h = height(h0, mu, s);
        let mu_s = ((RADIUS_M + h0) * ray.cos_sun_zenith + s * ray.cos_scattering) / (RADIUS_M + h);
        let sun = air.column_at(0, h, mu_s.clamp(-1.0, 1.0));
        if sun.is_infinite() {
            return 0.0;
        }
        2.0 * t * beta * density(s) * phase * (-beta * (view_length(t) + sun)).exp()
    };
    let scale = source(0.3 * last).max(source(0.05 * last)) * last;
    adaptive(&source, [0.0, last], 1e-8 * scale)
}

#[test]
fn whole_sky_rays_agree_with_adaptive_quadrature() {
    let air = nishita();
    let (twelve, sixteen) = (
        SingleScattering::new(&air, TWELVE),
        SingleScattering::new(&air, SIXTEEN),
    );
    for sun_deg in [2.0, 10.0, 30.0, 60.0] {
        for view_deg in [0.0, 0.5, 5.0, 30.0, 90.0] {
            for azimuth_deg in [0.0, 90.0, 180.0] {
                let angles = angles(view_deg, sun_deg, azimuth_deg);
                let ray = ViewRay::from_angles(0.0, angles, f64::INFINITY);
                let end_m = exit(0.0, ray.cos_zenith, 1e5);
                let twelve = twelve.solve(&ray).radiance;
                let sixteen = sixteen.solve(&ray).radiance;
                for (index, (twelve, sixteen)) in twelve.into_iter().zip(sixteen).enumerate() {
                    let expected = reference(&air, index, &ray, end_m);
                    let errors = [twelve / expected - 1.0, sixteen / expected - 1.0];
                    let where_ = format!("sun {sun_deg} view {view_deg} az {azimuth_deg} {index}");
                    assert!(
                        errors[0].abs() < TWELVE_NODES_TOLERANCE,
                        "{where_}: {errors:?}"
                    );
                    assert!(
                        errors[1].abs() < SIXTEEN_NODES_TOLERANCE,
                        "{where_}: {errors:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn segments_of_20_m_to_500_km_agree_with_adaptive_quadrature() {
    let air = nishita();
    let solver = SingleScattering::new(&air, SIXTEEN);
    for view_deg in [0.5, 5.0, 30.0] {
        for length_m in [20.0_f64, 100.0, 1e3, 10e3, 30e3, 100e3, 500e3] {
            let ray = ViewRay::from_angles(0.0, angles(view_deg, 10.0, 180.0), length_m);
            let light = solver.solve(&ray);
            let end_m = length_m.min(exit(0.0, ray.cos_zenith, 1e5));
            for index in 0..3 {
                let expected = reference(&air, index, &ray, end_m);
                let error = light.radiance[index] / expected - 1.0;
                assert!(
                    error.abs() < SEGMENT_TOLERANCE,
                    "{view_deg} {length_m}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn the_veil_in_front_of_a_bow_has_the_published_strength() {
    // Sun 20 degrees, view 5 degrees up, opposite to the sun, 550 nm, in 1/sr; and transmittance.
    let air = nishita();
    let solver = SingleScattering::new(&air, SIXTEEN);
    let published = [
        (100.0, 1.03e-4, 0.9987),
        (1e3, 1.02e-3, 0.987),
        (10e3, 9.4e-3, 0.886),
        (100e3, 4.7e-2, 0.468),
    ];
    for (length_m, radiance, transmittance) in published {
        let ray = ViewRay::from_angles(0.0, angles(5.0, 20.0, 180.0), length_m);
        let light = solver.solve(&ray);
        assert!(
            (light.radiance[1] / radiance - 1.0).abs() < 6e-3,
            "{length_m}: {light:?}"
        );
        assert!(
            (light.transmittance[1] - transmittance).abs() < 6e-4,
            "{length_m}: {light:?}"
        );
    }
    let ray = ViewRay::from_angles(0.0, angles(5.0, 20.0, 180.0), 10e3);
    let light = solver.solve(&ray);
    assert!(
        (light.radiance[0] / 1.37e-2 - 1.0).abs() < 4e-3,
        "{light:?}"
    );
    assert!((light.transmittance[0] - 0.763).abs() < 6e-4, "{light:?}");
}

#[test]
fn the_published_sum_converges_with_the_square_of_its_steps() {
    let air = nishita();
    let ray = ViewRay::from_angles(0.0, angles(30.0, 10.0, 90.0), f64::INFINITY);
    let exact = SingleScattering::new(&air, SIXTEEN).solve(&ray).radiance;
    let error = |n_steps: usize| {
        let solver = SingleScattering::new(&air, InScattering::Midpoint { n_steps });
        (solver.solve(&ray).radiance[0] / exact[0] - 1.0).abs()
    };
    let (fifty, hundred) = (error(50), error(100));
    assert!((1e-4..2e-2).contains(&fifty), "{fifty:e}");
    assert!((fifty / hundred - 4.0).abs() < 0.2, "{fifty:e} {hundred:e}");
}

#[test]
fn thick_haze_is_resolved_at_every_wavelength() {
    let haze = |visibility_m: f64| {
        let aerosol = AerosolKind::Rural
            .aerosol()
            .with_visibility_m(visibility_m)
            .unwrap();
        unit_sun_air(vec![
            common::molecules(&common::grid()),
            common::haze(aerosol, &common::grid()),
        ])
    };
    for visibility_m in [20e3, 1e3, 50.0] {
        let air = haze(visibility_m);
        let coarse = SingleScattering::new(&air, SIXTEEN);
        let fine = SingleScattering::new(&air, InScattering::Quadrature { n_nodes: 64 });
        for (height_m, view_deg) in [(0.0, 0.0), (0.0, 20.0), (3000.0, -3.0), (30e3, -80.0)] {
            let angles = angles(view_deg, 40.0, 60.0);
            let ray = ViewRay::from_angles(height_m, angles, f64::INFINITY);
            let (coarse, fine) = (coarse.solve(&ray).radiance, fine.solve(&ray).radiance);
            for (coarse, fine) in coarse.into_iter().zip(fine) {
                let error = (coarse - fine).abs();
                assert!(
                    error <= HAZE_TOLERANCE * fine,
                    "{visibility_m} {height_m} {view_deg}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn a_thin_and_a_thick_look_at_the_ground_add_reflected_sunlight() {
    let mut air = nishita();
    air.ground_albedo = vec![0.3; 3];
    let solver = SingleScattering::new(&air, SIXTEEN);
    let ray = ViewRay::from_angles(10.0, angles(-90.0, 30.0, 0.0), f64::INFINITY);
    let light = solver.solve(&ray);
    let sun = sun_transmittance(&air, 0.0, 0.5, SUN_RADIUS);
    for (index, radiance) in solver.sky_radiance(&ray).into_iter().enumerate() {
        let expected =
            light.radiance[index] + light.transmittance[index] * 0.3 / PI * 0.5 * sun[index];
        assert!(
            (radiance / expected - 1.0).abs() < 1e-6,
            "{radiance} {expected}"
        );
    }
}

#[test]
fn constituents_add_and_leave_each_other_alone() {
    let aerosol = common::haze(AerosolKind::Clear.aerosol(), &common::grid());
    let both = unit_sun_air(vec![common::nishita_molecules(), aerosol]);
    let one = nishita();
    assert_eq!(both.constituents[0], one.constituents[0]);
    // A constituent of no amount changes nothing.
    let none = unit_sun_air(vec![common::nishita_molecules(), common::ozone(0.0)]);
    let ray = ViewRay::from_angles(0.0, angles(10.0, 20.0, 0.0), f64::INFINITY);
    let solve = |air| SingleScattering::new(air, SIXTEEN).solve(&ray);
    assert_eq!(solve(&none), solve(&one));
}

#[test]
fn the_level_ray_of_the_chapman_function_is_the_tables() {
    let air = nishita();
    let formula = 7994.0 * chapman_erfcx(RADIUS_M / 7994.0, 0.0);
    assert!((formula / air.column_at(0, 0.0, 0.0) - 1.0).abs() < 6e-4);
}

#[test]
fn a_ray_and_a_sun_that_both_graze_the_ground_have_the_light_of_a_hair_above() {
    let air = nishita();
    for method in [
        InScattering::STANDARD,
        InScattering::Quadrature { n_nodes: 16 },
        InScattering::Nested {
            n_nodes: 16,
            n_sun_nodes: 16,
        },
        InScattering::Midpoint { n_steps: 400 },
    ] {
        let solver = SingleScattering::new(&air, method);
        for azimuth_deg in [0.0_f64, 60.0, 90.0, 135.0, 180.0] {
            let light = |height_m: f64| {
                let angles = [0.0, 0.0, azimuth_deg.to_radians()];
                solver.solve(&ViewRay::from_angles(height_m, angles, f64::INFINITY))
            };
            let (at_sea, above) = (light(0.0), light(1e-3));
            for (found, expected) in at_sea.radiance.iter().zip(&above.radiance) {
                println!("{method:?} {azimuth_deg}: {found} {expected}");
                let error = (found / expected - 1.0).abs();
                assert!(error < 1e-3, "{method:?} {azimuth_deg}: {found} {expected}");
            }
        }
    }
}
