//! Equivalent lengths against adaptive quadrature and published values.

mod common;

use common::RADIUS_M;
use common::exit;
use common::length;
use common::nishita;
use common::unit_sun_air;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::OpticalLength;
use niji_atmosphere::chapman_erfcx;
use niji_atmosphere::optical_length_m;
use niji_exchange::AtmosphereTable;
use niji_exchange::AttributeValue;
use niji_exchange::Provenance;
use niji_exchange::TableFile;

/// Table against quadrature up to nine tenths of a constituent's height; worst 6.5e-7.
const TABLE_TOLERANCE: f64 = 1e-6;
/// The same in the last tenth, which holds 1e-5 of all air; worst 3.1e-5.
const TOP_TOLERANCE: f64 = 5e-5;
/// Sixteen Gauss-Legendre nodes a leg; worst 2.4e-7.
const SIXTEEN_NODES_TOLERANCE: f64 = 1e-6;
/// Segments of 20 m to 500 km; worst 3.3e-6.
const SEGMENT_TOLERANCE: f64 = 1e-5;
/// Segments from a table that went through f32.
const F32_SEGMENT_TOLERANCE: f64 = 1e-5;

const HEIGHTS_M: [f64; 16] = [
    -100.0, 0.0, 2.0, 137.0, 1500.0, 4321.0, 9e3, 13e3, 22e3, 26e3, 31e3, 39e3, 47e3, 73e3, 90e3,
    99e3,
];

fn three_constituents() -> AtmosphereTable {
    unit_sun_air(vec![
        common::nishita_molecules(),
        common::haze(AerosolKind::Clear.aerosol(), &common::grid()),
        common::ozone(300.0),
    ])
}

/// Cosines from the horizon of a height to the zenith, dense at grazing.
fn cosines(height_m: f64) -> Vec<f64> {
    let rising = (0..60).map(|i| (f64::from(i) / 59.3).powi(2).min(1.0));
    let dip = if height_m > 0.0 {
        ((2.0 * RADIUS_M + height_m) * height_m).sqrt() / (RADIUS_M + height_m)
    } else {
        return rising.collect();
    };
    rising
        .chain((0..20).map(|i| -dip * (f64::from(i) + 0.3) / 20.1))
        .collect()
}

/// Length by adaptive quadrature, in pieces between the kinks of the profile.
fn reference(air: &AtmosphereTable, index: usize, [h, mu]: [f64; 2], ends: [f64; 2]) -> f64 {
    let constituent = &air.constituents[index];
    let mut cuts = vec![ends[0], ends[1]];
    for kink_m in &constituent.height_m {
        let (r0, rk) = (RADIUS_M + h, RADIUS_M + kink_m);
        let d2 = r0 * r0 * (mu * mu - 1.0) + rk * rk;
        if d2 > 0.0 {
            cuts.extend([-r0 * mu - d2.sqrt(), -r0 * mu + d2.sqrt()]);
        }
    }
    cuts.retain(|&cut| cut >= ends[0] && cut <= ends[1]);
    cuts.sort_by(f64::total_cmp);
    let density = |height_m: f64| constituent.density_at(height_m);
    cuts.windows(2)
        .map(|pair| length(&density, [h, mu], [pair[0], pair[1]]))
        .sum()
}

fn round_trip(air: &AtmosphereTable) -> AtmosphereTable {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("air.exr");
    let file = std::fs::File::create(&path).expect("a new file");
    let written = air.to_file(Provenance::default()).write(file);
    written.expect("the table is finite");
    let file = TableFile::read(&path).expect("the file was just written");
    AtmosphereTable::from_file(&file).expect("the file holds a table")
}

#[test]
fn columns_agree_with_adaptive_quadrature_at_any_height_and_angle() {
    let computed = three_constituents();
    let read = round_trip(&computed);
    for (index, constituent) in computed.constituents.iter().enumerate() {
        let top_m = constituent.height_m[constituent.height_m.len() - 1];
        for h in HEIGHTS_M.into_iter().filter(|&h| h < top_m) {
            let tolerance = if h < 0.91 * top_m {
                TABLE_TOLERANCE
            } else {
                TOP_TOLERANCE
            };
            for mu in cosines(h) {
                let expected = reference(&computed, index, [h, mu], [0.0, exit(h, mu, top_m)]);
                for air in [&computed, &read] {
                    let error = air.column_at(index, h, mu) / expected - 1.0;
                    assert!(
                        error.abs() < tolerance,
                        "{} {h} m {mu}: {error:e}",
                        constituent.name
                    );
                }
                let sixteen = OpticalLength::GaussLegendre { n_nodes: 16 };
                let found = optical_length_m(&computed, index, sixteen, [h, mu]);
                let error = found / expected - 1.0;
                assert!(
                    error.abs() < SIXTEEN_NODES_TOLERANCE,
                    "{h} m, {mu}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn segments_of_20_m_to_500_km_agree_with_adaptive_quadrature() {
    let computed = three_constituents();
    let read = round_trip(&computed);
    for (index, constituent) in computed.constituents.iter().enumerate() {
        let top_m = constituent.height_m[constituent.height_m.len() - 1];
        for h in HEIGHTS_M.into_iter().filter(|&h| h < 0.9 * top_m) {
            for mu in cosines(h) {
                for length_m in [20.0_f64, 300.0, 7e3, 30e3, 120e3, 500e3] {
                    let end = length_m.min(exit(h, mu, top_m));
                    let expected = reference(&computed, index, [h, mu], [0.0, end]);
                    if expected < 1e-6 {
                        continue;
                    }
                    for (air, tolerance) in [
                        (&computed, SEGMENT_TOLERANCE),
                        (&read, F32_SEGMENT_TOLERANCE),
                    ] {
                        let found = air.segment_length(index, h, mu, length_m);
                        let error = found / expected - 1.0;
                        let name = &constituent.name;
                        assert!(
                            error.abs() < tolerance,
                            "{name} {h} {mu} {length_m}: {error:e}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn segments_down_to_the_ground_agree_with_adaptive_quadrature() {
    let air = three_constituents();
    for (index, [h, mu, length_m]) in [
        (0, [100.0, -1.0, 100.0]),
        (0, [2000.0, -0.5, 3900.0]),
        (0, [50e3, -0.7, 69e3]),
        (1, [20e3, -0.3, 60e3]),
        (2, [60e3, -0.9, 60e3]),
    ] {
        let expected = reference(&air, index, [h, mu], [0.0, length_m]);
        let error = air.segment_length(index, h, mu, length_m) / expected - 1.0;
        assert!(
            error.abs() < SEGMENT_TOLERANCE,
            "{index} {h} {mu}: {error:e}"
        );
    }
}

#[test]
fn segments_add_up() {
    let air = three_constituents();
    for index in 0..3 {
        for (h, mu) in [
            (0.0, 0.0),
            (3e3, 0.4),
            (12e3, -0.05),
            (30e3, -0.09),
            (70e3, 0.01),
        ] {
            let whole = air.segment_length(index, h, mu, 300e3);
            let first = air.segment_length(index, h, mu, 1e3);
            let r0 = RADIUS_M + h;
            let end = common::height(h, mu, 1e3);
            let mu_end = (r0 * mu + 1e3) / (RADIUS_M + end);
            let rest = air.segment_length(index, end, mu_end, 299e3);
            let error = (first + rest - whole).abs();
            assert!(
                error <= 1e-5 * whole,
                "{index} {h} {mu}: {error:e} of {whole}"
            );
        }
    }
}

#[test]
fn the_level_column_is_the_bessel_function() {
    // X e^X K1(X) at X = 6371/7.994 by mpmath, less what lies above the top, 3.0 m of 283 km.
    let found = nishita().column_at(0, 0.0, 0.0) / 7994.0;
    assert!((found / 35.398_583_995_490_1 - 1.0).abs() < 2e-5, "{found}");
}

#[test]
fn direct_sunlight_has_the_published_transmittance() {
    let air = nishita();
    let published = [
        (30.0_f64, [0.635, 0.816, 0.901]),
        (10.0, [0.282, 0.567, 0.748]),
        (5.0, [0.099, 0.355, 0.588]),
        (2.0, [0.014, 0.148, 0.376]),
        (0.0, [0.0003, 0.027, 0.157]),
    ];
    for (elevation_deg, transmittances) in published {
        for (wavelength, expected) in transmittances.into_iter().enumerate() {
            let mu = elevation_deg.to_radians().sin();
            let found = (-air.optical_depth_at(wavelength, 0.0, mu)).exp();
            let rounding = if expected < 1e-3 { 5.1e-5 } else { 5.1e-4 };
            assert!(
                (found - expected).abs() < rounding,
                "{elevation_deg}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_horizon_of_a_mountain_lets_less_and_less_through() {
    let air = nishita();
    // 450 nm, sun 1 and 1.4 degrees below the horizontal, seen from 2 km.
    for (elevation_deg, expected) in [(-1.0_f64, 5.7e-5), (-1.4, 5.9e-6)] {
        let found = (-air.optical_depth_at(0, 2000.0, elevation_deg.to_radians().sin())).exp();
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{elevation_deg}: {found:e}"
        );
    }
}

#[test]
fn cheap_methods_have_the_errors_that_their_documentation_states() {
    let air = nishita();
    let worst = |method: OpticalLength| {
        let mut worst = 0.0_f64;
        for degrees in 0..=90 {
            let mu = f64::from(degrees).to_radians().cos();
            let exact = optical_length_m(
                &air,
                0,
                OpticalLength::GaussLegendre { n_nodes: 64 },
                [0.0, mu],
            );
            worst = worst.max((optical_length_m(&air, 0, method, [0.0, mu]) / exact - 1.0).abs());
        }
        worst
    };
    let fifty = worst(OpticalLength::Midpoint { n_steps: 50 });
    assert!((2.5e-3..2.7e-3).contains(&fifty), "{fifty:e}");
    let hundred = worst(OpticalLength::Midpoint { n_steps: 100 });
    assert!((fifty / hundred - 4.0).abs() < 0.05, "{hundred:e}");
    let chapman = worst(OpticalLength::Chapman);
    assert!((4e-4..1.3e-3).contains(&chapman), "{chapman:e}");
    assert!(worst(OpticalLength::Table) < 1e-6);
    assert!(worst(OpticalLength::GaussLegendre { n_nodes: 16 }) < 1e-9);
    // One function call, where the table asks for none.
    assert!(chapman_erfcx(797.0, 0.0) > 35.0);
}

#[test]
fn the_file_keeps_everything() {
    let air = three_constituents();
    let read = round_trip(&air);
    assert_eq!(read.wavelengths, air.wavelengths);
    for (a, b) in air.constituents.iter().zip(&read.constituents) {
        assert_eq!((&a.name, a.law), (&b.name, b.law));
        assert_eq!((&a.height_m, &a.reach_mu), (&b.height_m, &b.reach_mu));
        for (a, b) in a.phase_sr1.iter().zip(&b.phase_sr1) {
            assert!((a - b).abs() <= 1e-7 * a);
        }
        for (a, b) in a.extinction_m1.iter().zip(&b.extinction_m1) {
            assert!((a - b).abs() <= 1e-7 * a);
        }
    }
    // The second round trip changes nothing more.
    assert_eq!(round_trip(&read), read);
}

#[test]
fn interpolated_phase_functions_follow_their_formulas() {
    let air = three_constituents();
    for i in 0..=1000 {
        let theta = std::f64::consts::PI * f64::from(i) / 1000.0;
        let angle = niji_radiometry::Radians(theta);
        let rayleigh = niji_atmosphere::rayleigh_phase(1.0, angle);
        assert!((air.phase_at(0, 1, theta) / rayleigh - 1.0).abs() < 1e-8);
        let aerosol = niji_atmosphere::cornette_shanks(0.7, angle);
        assert!((air.phase_at(1, 1, theta) / aerosol - 1.0).abs() < 1e-6);
    }
}

#[test]
fn damaged_tables_are_refused_and_never_panic() {
    let good = three_constituents().to_file(Provenance::default());
    assert!(AtmosphereTable::from_file(&good).is_ok());
    let refused = |damage: &dyn Fn(&mut TableFile)| {
        let mut file = good.clone();
        damage(&mut file);
        AtmosphereTable::from_file(&file).is_err()
    };
    assert!(refused(&|file| file.quantity = "scattering".to_owned()));
    assert!(refused(&|file| file.parts.clear()));
    for index in 1..good.parts.len() {
        assert!(
            refused(&|file| drop(file.parts.remove(index))),
            "part {index}"
        );
        assert!(refused(
            &|file| file.parts[index].channels[0].values[[0, 0]] = -1.0
        ));
        assert!(refused(
            &|file| file.parts[index].channels[0].values[[0, 0]] = f32::NAN
        ));
    }
    for name in good.parts[0].attributes.keys() {
        assert!(
            refused(&|file| drop(file.parts[0].attributes.remove(name))),
            "{name}"
        );
    }
    assert!(refused(&|file| {
        let radius = AttributeValue::Number(0.0);
        file.parts[0]
            .attributes
            .insert("niji:planetRadiusM".to_owned(), radius);
    }));
    assert!(refused(&|file| {
        let law = AttributeValue::Text("quadratic".to_owned());
        file.parts[1]
            .attributes
            .insert("niji:densityLaw".to_owned(), law);
    }));
    // A density of 0 has no logarithm.
    assert!(refused(
        &|file| file.parts[1].channels[0].values[[0, 1]] = 0.0
    ));
}
