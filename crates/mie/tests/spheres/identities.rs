//! What must hold for every sphere, and limits.

use std::f64::consts::PI;

use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use num_complex::Complex64;

use crate::support::degrees;
use crate::support::sphere;
use crate::support::textbook_amplitudes;

const SPHERES: [(f64, f64, f64); 8] = [
    (1e-6, 1.333, 0.0),
    (0.3, 1.333, 1e-3),
    (5.213, 1.55, 0.0),
    (62.8, 1.3337, 0.0),
    (100.0, 0.75, 0.0),
    (1000.0, 1.333, 1e-5),
    (10000.0, 1.333, 0.0),
    (100_000.0, 1.333, 0.0),
];

/// Nodes and weights of Gauss-Legendre quadrature on -1..1.
fn gauss_legendre(n_nodes: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut mu = (PI * (i as f64 + 0.75) / (n_nodes as f64 + 0.5)).cos();
        let mut derivative = 1.0;
        for _ in 0..8 {
            let (mut before, mut p) = (1.0, mu);
            for n in 1..n_nodes {
                let n = n as f64;
                (before, p) = (p, ((2.0 * n + 1.0) * mu * p - n * before) / (n + 1.0));
            }
            derivative = n_nodes as f64 * (mu * p - before) / (mu * mu - 1.0);
            mu -= p / derivative;
        }
        (mu, 2.0 / ((1.0 - mu * mu) * derivative * derivative))
    };
    (0..n_nodes).map(node).collect()
}

#[test]
fn the_phase_function_has_mean_1_and_the_mean_cosine_g() {
    for (x, n, k) in [
        (0.01, 1.333, 0.0),
        (5.0, 1.333, 0.0),
        (60.0, 1.333, 0.0),
        (60.0, 1.5, 0.1),
    ] {
        let sphere = sphere(x, n, k);
        // p11 is a polynomial of cos(theta) of degree 2N, which 2N nodes integrate exactly.
        let nodes = gauss_legendre(220);
        let angles: Vec<Radians> = nodes.iter().map(|node| Radians(node.0.acos())).collect();
        let angles = ScatteringAngles::new(&angles).unwrap();
        let p11 = sphere.p11(&sphere.amplitudes(&angles));
        let mean: f64 = p11
            .iter()
            .zip(&nodes)
            .map(|(p, node)| 0.5 * p * node.1)
            .sum();
        let cosine: f64 = p11
            .iter()
            .zip(&nodes)
            .map(|(p, node)| 0.5 * p * node.1 * node.0)
            .sum();
        // Worst found 2.4e-13.
        assert!((mean - 1.0).abs() <= 2e-12, "x = {x}: {mean}");
        assert!(
            (cosine - sphere.efficiencies().asymmetry).abs() <= 2e-12,
            "x = {x}: {cosine}"
        );
    }
}

#[test]
fn both_polarizations_are_equal_at_the_poles() {
    for (x, n, k) in SPHERES {
        let sphere = sphere(x, n, k);
        let amplitudes = sphere.amplitudes(&degrees(&[0.0, 180.0]));
        assert_eq!(amplitudes.s1[0], amplitudes.s2[0]);
        assert_eq!(amplitudes.s1[1], -amplitudes.s2[1]);
        assert_eq!(amplitudes.degrees_of_polarization(), [0.0, 0.0]);
        let q_back = 4.0 * amplitudes.s1[1].norm_sqr() / (x * x);
        assert!((q_back / sphere.efficiencies().q_back - 1.0).abs() <= 1e-15);
    }
}

#[test]
fn folded_sums_agree_with_the_textbook_loop() {
    for (x, n, k) in [
        (0.5, 1.333, 0.0),
        (40.0, 1.5, 0.1),
        (1000.0, 1.333, 0.0),
        (5000.0, 1.333, 0.0),
    ] {
        let sphere = sphere(x, n, k);
        let angles_deg: Vec<f64> = (1..60).map(|i| 3.0 * f64::from(i)).collect();
        let found = sphere.amplitudes(&degrees(&angles_deg));
        for (i, theta_deg) in angles_deg.iter().enumerate() {
            let [s1, s2] = textbook_amplitudes(sphere.waves(), *theta_deg);
            let error = (found.s1[i] - s1).norm().max((found.s2[i] - s2).norm());
            // Worst found 3.4e-12.
            assert!(
                error <= 5e-11 * s1.norm().max(s2.norm()),
                "x = {x} at {theta_deg}: {error}"
            );
        }
    }
}

#[test]
fn an_amplitude_does_not_depend_on_the_other_angles() {
    let sphere = sphere(1000.0, 1.333, 0.0);
    let grid: Vec<f64> = (0..=180).map(f64::from).collect();
    let together = sphere.amplitudes(&degrees(&grid));
    for i in [0, 1, 42, 90, 138, 179, 180] {
        let alone = sphere.amplitudes(&degrees(&grid[i..=i]));
        assert_eq!(
            (alone.s1[0], alone.s2[0]),
            (together.s1[i], together.s2[i]),
            "{i} degrees"
        );
    }
}

#[test]
fn a_small_sphere_is_a_dipole() {
    for (n, k) in [(1.333, 0.0), (1.5, 0.5)] {
        let x = 1e-5;
        let sphere = sphere(x, n, k);
        let m2 = Complex64::new(n, k) * Complex64::new(n, k);
        let polarizability = (m2 - 1.0) / (m2 + 2.0);
        let q = sphere.efficiencies();
        let q_sca = 8.0 / 3.0 * x.powi(4) * polarizability.norm_sqr();
        assert!((q.q_sca / q_sca - 1.0).abs() <= 1e-9, "{} {q_sca}", q.q_sca);
        let q_abs = 4.0 * x * polarizability.im;
        assert!((q.q_abs() - q_abs).abs() <= 1e-9 * q_abs + 1e-14 * q_sca);
        assert!(q.asymmetry.abs() <= 1e-9);
        let p11 = sphere.p11(&sphere.amplitudes(&degrees(&[0.0, 60.0, 90.0, 180.0])));
        for (p, rayleigh) in p11.iter().zip([1.5, 0.9375, 0.75, 1.5]) {
            assert!((p - rayleigh).abs() <= 1e-9, "{p}");
        }
    }
}

#[test]
fn a_faint_sphere_scatters_as_the_square_of_its_contrast() {
    // Rayleigh and Gans: Q_sca is proportional to (m - 1)^2 while x (m - 1) << 1.
    let q_sca = |contrast: f64| sphere(10.0, 1.0 + contrast, 0.0).efficiencies().q_sca;
    assert!((q_sca(2e-6) / q_sca(1e-6) - 4.0).abs() <= 1e-4);
}

#[test]
fn a_radius_and_a_wavelength_make_a_size_parameter() {
    let water = RefractiveIndex::from(1.333);
    let sphere = Sphere::from_radius(Micrometers(100.0), Nanometers(500.0), water).unwrap();
    assert!((sphere.size_parameter() - 400.0 * PI).abs() <= 1e-12);
    assert_eq!(sphere.refractive_index(), water);
}
