//! Time of the rainbow integral and of the theories of the bow, with the error that the same run has.
//!
//! `cargo bench -p niji-airy`, one thread. Items are values: of f, of a look-up, of a direction (what
//! does not depend on the size, once for an angle) or of a drop size in a direction. Errors of theories
//! are against the exact Debye order of a drop of 100 µm radius at 650 nm within 2 degrees of the
//! primary bow, natural light, RMS of the difference over RMS.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use divan::Bencher;
use divan::black_box;
use divan::counter::ItemsCount;
use niji_airy::AiryBow;
use niji_airy::AiryTable;
use niji_airy::BowDirection;
use niji_airy::GeometricOrder;
use niji_airy::UniformBow;
use niji_airy::airy_integral;
use niji_airy::airy_integral_with_derivative;
use niji_airy::airy_squares;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use spec_math::Bessel;

#[path = "../tests/debye/references.rs"]
#[allow(dead_code, reason = "the tests read the rest of the file")]
mod references;

/// Exact |S|² of one order for drops of one size.
struct Reference {
    x: f64,
    order: u32,
    /// Scattering angle in degrees, (|S1|², |S2|²).
    intensities: &'static [(f64, [f64; 2])],
}

/// z and f(z) in 40-digit arithmetic.
const INTEGRAL: [(f64, f64); 6] = [
    (-12.5, 7.0894455729278062551e-13),
    (-3.0, 0.017303377573352184609),
    (0.5, 0.87916982238593196946),
    (5.0, 0.68182541354080943985),
    (20.0, -0.50467009626956000862),
    (60.0, -0.31752234158150802281),
];

const N: usize = 1024;

fn main() {
    let worst = |f: &dyn Fn(f64) -> f64| {
        let off = |&(z, exact): &(f64, f64)| ((f(z) - exact) / exact).abs();
        INTEGRAL.iter().map(off).fold(0.0, f64::max)
    };
    let table = AiryTable::compute();
    println!("f(z): relative error {:.1e}", worst(&airy_integral));
    println!("table: relative error {:.1e}", worst(&|z| table.value(z)));
    println!("rational approximation: {:.1e}", worst(&rational));
    let (airy, uniform) = (airy(), uniform());
    println!("Airy: {:.1e}", rms(|theta| airy.direction(theta)));
    println!("uniform: {:.1e}", rms(|theta| uniform.direction(theta)));
    let rays = rays();
    println!("geometric: {:.1e}", rms(|theta| only_rays(rays, theta)));
    divan::main();
}

fn rational(z: f64) -> f64 {
    1.873_855_777_601_272_3 * (-0.936_927_888_800_636_4 * z).airy().ai
}

fn airy() -> AiryBow {
    AiryBow::new(references::N, 2).expect("water has a primary bow")
}

fn uniform() -> UniformBow {
    UniformBow::new(references::N, 2).expect("water has a primary bow")
}

fn rays() -> GeometricOrder {
    GeometricOrder::new(references::N, 2).expect("water refracts")
}

fn only_rays(order: GeometricOrder, theta: Radians) -> BowDirection {
    BowDirection {
        argument: 0.0,
        strength: [0.0; 2],
        derivative_strength: [0.0; 2],
        rays: order.normalized_cross_section(theta),
    }
}

fn rms(model: impl Fn(Radians) -> BowDirection) -> f64 {
    let is_it = |reference: &&Reference| reference.x > 900.0 && reference.order == 2;
    let reference = references::BOWS.iter().find(is_it);
    let Reference { x, intensities, .. } = reference.expect("the file holds this drop");
    let (mut difference, mut square) = (0.0, 0.0);
    for (theta_deg, [s, p]) in *intensities {
        let direction = model(Radians::from_degrees(*theta_deg));
        let t = at_size(&direction, *x);
        difference += (PI * x * x * (t[0] + t[1]) - (s + p)).powi(2);
        square += (s + p).powi(2);
    }
    (difference / square).sqrt()
}

fn at_size(direction: &BowDirection, x: f64) -> [f64; 2] {
    direction.normalized_cross_section(Micrometers(x / TAU), Nanometers(1000.0), airy_squares)
}

/// Arguments from −12 to 60, out of order.
fn arguments() -> Vec<f64> {
    let place = |index: usize| (index * 389 % N) as f64 / N as f64;
    (0..N).map(|index| -12.0 + 72.0 * place(index)).collect()
}

/// Angles from 5 degrees outside of the primary bow to 15 inside.
fn angles() -> Vec<Radians> {
    let angle = |index: usize| Radians::from_degrees(132.6 + 20.0 * index as f64 / N as f64);
    (0..N).map(angle).collect()
}

fn bench_over<T: Copy + Sync, R>(bencher: Bencher, inputs: &[T], f: impl Fn(T) -> R + Sync) {
    bencher.counter(ItemsCount::new(inputs.len())).bench(|| {
        for &input in inputs {
            black_box(f(black_box(input)));
        }
    });
}

#[divan::bench]
fn integral(bencher: Bencher) {
    bench_over(bencher, &arguments(), airy_integral);
}

#[divan::bench]
fn integral_with_derivative(bencher: Bencher) {
    bench_over(bencher, &arguments(), airy_integral_with_derivative);
}

#[divan::bench]
fn integral_rational(bencher: Bencher) {
    bench_over(bencher, &arguments(), rational);
}

#[divan::bench]
fn table_look_up(bencher: Bencher) {
    let table = AiryTable::compute();
    bench_over(bencher, &arguments(), |z| table.value(z));
}

#[divan::bench]
fn new_bow_uniform(bencher: Bencher) {
    bencher.bench(|| UniformBow::new(black_box(references::N), 2));
}

#[divan::bench]
fn direction_airy(bencher: Bencher) {
    let bow = airy();
    bench_over(bencher, &angles(), |theta| bow.direction(theta));
}

#[divan::bench]
fn direction_uniform(bencher: Bencher) {
    let bow = uniform();
    bench_over(bencher, &angles(), |theta| bow.direction(theta));
}

#[divan::bench]
fn direction_geometric(bencher: Bencher) {
    let order = rays();
    bench_over(bencher, &angles(), |theta| {
        order.normalized_cross_section(theta)
    });
}

#[divan::bench]
fn size_airy(bencher: Bencher) {
    let bow = airy();
    let directions: Vec<_> = angles()
        .into_iter()
        .map(|theta| bow.direction(theta))
        .collect();
    bench_over(bencher, &directions, |direction| at_size(&direction, 967.0));
}

#[divan::bench]
fn size_uniform(bencher: Bencher) {
    let bow = uniform();
    let directions: Vec<_> = angles()
        .into_iter()
        .map(|theta| bow.direction(theta))
        .collect();
    bench_over(bencher, &directions, |direction| at_size(&direction, 967.0));
}
