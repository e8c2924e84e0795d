//! Spheres that break other programs, bad input, and every set of vector instructions.

use niji_mie::Error;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use num_complex::Complex64;
use pulp::Arch;

use crate::support::complex;
use crate::support::degrees;
use crate::support::sphere;

/// Nothing, nearly nothing, bubbles, metals, mirrors, crystals, black spheres.
const INDICES: [(f64, f64); 17] = [
    (1.0, 0.0),
    (1.0, 1e-8),
    (1.000000000001, 0.0),
    (0.75, 0.0),
    (0.05, 0.0),
    (1e-6, 0.0),
    (1e-3, 1e-3),
    (0.05, 3.0),
    (1e-9, 99.0),
    (1.5, 1.0),
    (10.0, 10.0),
    (70.0, 70.0),
    (99.0, 0.0),
    (1.333, 1e-300),
    (1.333, 1e-12),
    (1.333, 0.5),
    (1.333, 30.0),
];

/// Of each part of a coefficient relative to itself; worst found 1.3e-12.
const TUNNELLING: f64 = 1e-11;

#[test]
fn no_size_or_index_gives_a_nan_or_light_from_nothing() {
    let angles = degrees(&[0.0, 1e-9, 0.01, 90.0, 138.0, 179.99, 180.0]);
    for x in [1e-6, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4] {
        for (n, k) in INDICES {
            let sphere = sphere(x, n, k);
            let q = sphere.efficiencies();
            assert!(
                q.q_sca >= 0.0 && q.q_abs() >= -1e-14 * q.q_ext && q.asymmetry.abs() <= 1.0,
                "x = {x}, m = {n} + {k}i: {q:?}"
            );
            let p11 = sphere.p11(&sphere.amplitudes(&angles));
            assert!(
                p11.iter().all(|p| p.is_finite() && *p >= 0.0),
                "x = {x}, m = {n} + {k}i: {p11:?}"
            );
        }
    }
}

#[test]
fn no_size_or_index_gives_a_nan_in_an_order_of_debye() {
    for x in [1e-6, 0.1, 10.0, 1e3] {
        for (n, k) in INDICES {
            let series = sphere(x, n, k).debye_series();
            for order in 0..8 {
                let waves = series.order(order);
                let mut coefficients = waves.a().iter().chain(waves.b());
                assert!(
                    coefficients.all(|c| c.is_finite()),
                    "x = {x}, m = {n} + {k}i, order {order}"
                );
            }
        }
    }
}

#[test]
fn a_sphere_of_air_in_air_does_exactly_nothing() {
    for x in [0.1, 100.0, 1e4] {
        let sphere = sphere(x, 1.0, 0.0);
        let q = sphere.efficiencies();
        assert_eq!([q.q_ext, q.q_sca, q.q_back, q.asymmetry], [0.0; 4]);
        let amplitudes = sphere.amplitudes(&degrees(&[0.0, 30.0, 180.0]));
        assert!(amplitudes.s1.iter().all(|s| *s == Complex64::ZERO));
        assert_eq!(sphere.p11(&amplitudes), [0.0; 3]);
        // What passes through cancels the shadow, wave by wave.
        let (shadow, through) = (sphere.debye(0), sphere.debye(1));
        for (shadow, through) in shadow.a().iter().zip(through.a()) {
            assert_eq!(*shadow, -through);
        }
    }
}

#[test]
fn waves_that_tunnel_keep_their_digits() {
    // x, n, a_n, b_n for m = 1.333, n > x, by `reference.py`.
    for (x, n, a, b) in [
        (
            100.0,
            105,
            (5.8008984486199226868e-4, 2.4078067626657257531e-2),
            (8.9941908980721674078e-4, 2.9976826635054403279e-2),
        ),
        (
            100.0,
            115,
            (4.4037508759451471720e-13, -6.6360763075353555415e-7),
            (8.3693042607927253186e-13, 9.1483901648244762611e-7),
        ),
        (
            100.0,
            125,
            (3.8728261293918431650e-21, -6.2232034591453324627e-11),
            (2.9613259274122086916e-19, -5.4418066185892793913e-10),
        ),
        (
            1000.0,
            1010,
            (8.4214550711369802626e-4, -2.9007521404948514467e-2),
            (8.9645278485599784846e-5, -9.4676946618300393996e-3),
        ),
        (
            1000.0,
            1040,
            (4.7473265942767187853e-14, 2.1788360641123263302e-7),
            (2.5023887253443922639e-14, 1.5818940310097669891e-7),
        ),
        (
            1000.0,
            1065,
            (4.5090732749189162129e-28, -2.1234578580510883812e-14),
            (1.7887233040662419651e-27, -4.2293300936037635854e-14),
        ),
    ] {
        let sphere = sphere(x, 1.333, 0.0);
        let waves = sphere.waves();
        for (found, expected) in [
            (waves.a()[n - 1], complex(a)),
            (waves.b()[n - 1], complex(b)),
        ] {
            for (found, expected) in [(found.re, expected.re), (found.im, expected.im)] {
                let error = (found / expected - 1.0).abs();
                assert!(error <= TUNNELLING, "x = {x}, n = {n}: {error:e}");
            }
        }
    }
}

#[test]
fn every_processor_with_fused_multiply_add_gives_the_same_bits() {
    let mut fused = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        fused.extend(pulp::x86::V3::try_new().map(Arch::V3));
        fused.extend(pulp::x86::V4::try_new().map(Arch::V4));
    }
    #[cfg(target_arch = "aarch64")]
    fused.extend(pulp::aarch64::Neon::try_new().map(Arch::Neon));
    let grid: Vec<f64> = (0..=180).map(f64::from).collect();
    let angles = degrees(&grid);
    for (x, n, k) in [
        (0.5, 1.333, 0.0),
        (600.0, 1.333, 1e-4),
        (5000.0, 1.333, 0.0),
    ] {
        let sphere = sphere(x, n, k);
        let best = sphere.amplitudes(&angles);
        for arch in &fused {
            assert_eq!(
                sphere.waves().amplitudes_by(&angles, *arch),
                best,
                "x = {x}"
            );
        }
        let plain = sphere.waves().amplitudes_by(&angles, Arch::Scalar);
        for (best, plain) in best.s1.iter().zip(&plain.s1) {
            // Without it the last digits differ: worst found 2.2e-13.
            assert!(
                (best - plain).norm() <= 2e-12 * best.norm(),
                "{best} {plain}"
            );
        }
    }
}

#[test]
fn spheres_that_cannot_be_are_typed_errors() {
    let water = RefractiveIndex::from(1.333);
    for x in [0.0, -1.0, 1e-7, 1e6, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(Sphere::new(x, water), Err(Error::SizeParameter { .. })),
            "{x}"
        );
    }
    for (n, k) in [
        (1.333, -1e-9),
        (0.0, 0.0),
        (-1.3, 0.0),
        (f64::NAN, 0.0),
        (1.3, f64::NAN),
        (1e9, 0.0),
    ] {
        let found = Sphere::new(1.0, RefractiveIndex { n, k });
        assert!(
            matches!(found, Err(Error::RefractiveIndex { .. })),
            "{n} {k}"
        );
    }
    let zero = Micrometers(0.0);
    assert!(Sphere::from_radius(zero, Nanometers(500.0), water).is_err());
    assert!(Sphere::from_radius(Micrometers(1.0), Nanometers(0.0), water).is_err());
}

#[test]
fn an_error_says_what_was_found_and_what_was_expected() {
    let message = |x, n, k| {
        let found = Sphere::new(x, RefractiveIndex { n, k });
        found.unwrap_err().to_string()
    };
    assert_eq!(
        message(0.0, 1.333, 0.0),
        "size parameter 0 found, expected 0.000001 to 100000"
    );
    assert_eq!(
        message(1.0, 1.333, -1e-9),
        "refractive index 1.333 + -0.000000001i found, expected a real part above 0, an imaginary \
         part of at least 0 and a modulus of at most 100"
    );
    let message = ScatteringAngles::from_degrees(&[0.0, 180.5]).unwrap_err();
    assert_eq!(
        message.to_string(),
        "scattering angle number 1 is 180.5 degrees, expected 0 to 180"
    );
}
