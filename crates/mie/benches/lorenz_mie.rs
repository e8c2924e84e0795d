//! Time of spheres of water, with the error that the same run has.
//!
//! `cargo bench -p niji-mie`, one thread. A whole job is the coefficients and the sums over 1801
//! angles from 0 to 180 degrees, which fold into 901 mirrored pairs. The last group is the textbook
//! loop over pi_n and tau_n on 1801 angles, for scale.

use divan::black_box;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use num_complex::Complex64;

const WATER: RefractiveIndex = RefractiveIndex { n: 1.333, k: 0.0 };

/// x and S1 at 138 degrees in 60-digit arithmetic, by `tests/spheres/reference.py`.
const REFERENCES: [(f64, f64, f64); 3] = [
    (1e3, 4.2990258278324541636e1, 6.1294286035491479721e2),
    (1e4, -1.0669013474506131235e4, 1.2923414117007629618e3),
    (5e4, 6.2733523409394128006e4, -5.6862809524007516355e4),
];

const SIZES: [f64; 4] = [1e3, 1e4, 2e4, 5e4];

fn main() {
    for (x, re, im) in REFERENCES {
        let angles = ScatteringAngles::from_degrees(&[138.0]).expect("138 degrees is an angle");
        let s1 = sphere(x).amplitudes(&angles).s1[0];
        let expected = Complex64::new(re, im);
        let error = (s1 - expected).norm() / expected.norm();
        println!("x = {x}: relative error of S1 at 138 degrees {error:.1e}");
    }
    divan::main();
}

fn sphere(x: f64) -> Sphere {
    Sphere::new(x, WATER).expect("a drop of water is a sphere")
}

fn grid() -> ScatteringAngles {
    let angles_deg: Vec<f64> = (0..=1800).map(|i| f64::from(i) / 10.0).collect();
    ScatteringAngles::from_degrees(&angles_deg).expect("a grid from 0 to 180 degrees")
}

#[divan::bench(args = SIZES)]
fn efficiencies(x: f64) -> f64 {
    sphere(black_box(x)).efficiencies().q_ext
}

#[divan::bench(args = SIZES)]
fn whole_job_1801_angles(bencher: divan::Bencher, x: f64) {
    let angles = grid();
    bencher.bench_local(|| sphere(black_box(x)).amplitudes(&angles));
}

/// A table of the bows: 2500 angles, none of which has its mirror image in the grid.
fn bow_grid() -> ScatteringAngles {
    let angles_deg: Vec<f64> = (0..2500).map(|i| 118.0 + 0.0108 * f64::from(i)).collect();
    ScatteringAngles::from_degrees(&angles_deg).expect("a grid from 118 to 145 degrees")
}

#[divan::bench(args = SIZES, sample_count = 20)]
fn whole_job_2500_bow_angles(bencher: divan::Bencher, x: f64) {
    let angles = bow_grid();
    bencher.bench_local(|| {
        sphere(black_box(x))
            .waves()
            .normalized_cross_sections(&angles)
    });
}

#[divan::bench(args = SIZES, sample_count = 20)]
fn debye_order_2_2500_bow_angles(bencher: divan::Bencher, x: f64) {
    debye(bencher, x, &[2]);
}

#[divan::bench(args = SIZES, sample_count = 20)]
fn debye_orders_0_to_7_2500_bow_angles(bencher: divan::Bencher, x: f64) {
    debye(bencher, x, &[0, 1, 2, 3, 4, 5, 6, 7]);
}

fn debye(bencher: divan::Bencher, x: f64, orders: &[u32]) {
    let (sphere, angles) = (sphere(x), bow_grid());
    bencher.bench_local(|| {
        let series = black_box(&sphere).debye_series();
        series.incoherent_cross_sections(orders, &angles)
    });
}

#[divan::bench(args = [1e3, 1e4], sample_count = 5)]
fn textbook_loop_1801_angles(bencher: divan::Bencher, x: f64) {
    let cosines: Vec<f64> = (0..=1800)
        .map(|i| (f64::from(i) / 10.0).to_radians().cos())
        .collect();
    bencher.bench_local(|| {
        let sphere = sphere(black_box(x));
        let waves = sphere.waves();
        cosines
            .iter()
            .map(|mu| textbook(waves.a(), waves.b(), *mu))
            .collect::<Vec<_>>()
    });
}

fn textbook(a: &[Complex64], b: &[Complex64], mu: f64) -> [Complex64; 2] {
    let (mut pi_before, mut pi) = (0.0, 1.0);
    let mut s = [Complex64::ZERO; 2];
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        let n = (index + 1) as f64;
        let tau = n * mu * pi - (n + 1.0) * pi_before;
        let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
        s[0] += weight * (a * pi + b * tau);
        s[1] += weight * (a * tau + b * pi);
        (pi_before, pi) = (pi, ((2.0 * n + 1.0) * mu * pi - (n + 1.0) * pi_before) / n);
    }
    s
}
