//! Time of a small table by every theory, with its error against the exact solution.
//!
//! 0.1 mm radius, v_e = 0.02, 125 to 143 degrees, the sun's disc, nine wavelengths. The error is the rms
//! over the angles of the difference to the Debye orders 0 to 7 and to Lorenz-Mie in parts of the peak,
//! printed before the times; all theories by orders have the orders 0, 2, 3, 6 and 7.

#![allow(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::f64::consts::PI;

use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;

const THEORIES: [Theory; 6] = [
    Theory::GeometricPublished,
    Theory::Geometric,
    Theory::Airy,
    Theory::Uniform,
    Theory::Debye { max_order: 7 },
    Theory::Mie,
];

fn request(theory: Theory) -> TableRequest<'static> {
    TableRequest {
        theory,
        orders: vec![0, 2, 3, 6, 7],
        theta_range_rad: (125.0_f64.to_radians(), 143.0_f64.to_radians()),
        tolerance: 2e-3,
        wavelengths: WavelengthGrid::new(400.0, 40.0, 9).unwrap(),
        effective_radius_um: vec![100.0],
        effective_variance: vec![0.02],
        rows: SizeRows::Laws,
        motion: None,
        sun_disc_diameter_rad: 0.533 * PI / 180.0,
        water: Water::pure(20.0),
        airy_table: None,
    }
}

/// Natural light at even angles, by wavelength and angle.
fn curve(theory: Theory) -> Vec<f64> {
    let table = scattering_table(&request(theory), &unwatched).unwrap();
    let angles = &table.theta_rad;
    let at = |wavelength: usize, angle: usize| {
        let value = |j| f64::from(table.values[[j, 0, 0, wavelength, angle]]);
        0.5 * (value(0) + value(1))
    };
    let mut curve = Vec::new();
    for wavelength in 0..9 {
        for step in 0..=360 {
            let theta = (125.0 + 0.05 * f64::from(step)).to_radians();
            let above = angles.partition_point(|&angle| angle <= theta);
            let above = above.clamp(1, angles.len() - 1);
            let part = (theta - angles[above - 1]) / (angles[above] - angles[above - 1]);
            curve.push(at(wavelength, above - 1) * (1.0 - part) + at(wavelength, above) * part);
        }
    }
    curve
}

fn rms(curve: &[f64], reference: &[f64]) -> f64 {
    let peak = reference
        .iter()
        .fold(0.0_f64, |peak, &value| peak.max(value));
    let squares = curve
        .iter()
        .zip(reference)
        .map(|(a, b)| ((a - b) / peak).powi(2));
    (squares.sum::<f64>() / curve.len() as f64).sqrt()
}

fn main() {
    let debye = curve(Theory::Debye { max_order: 7 });
    let mie = curve(Theory::Mie);
    for theory in THEORIES {
        let curve = curve(theory);
        println!(
            "{:20} against Debye {:.1e}, against Mie {:.1e}",
            theory.name(),
            rms(&curve, &debye),
            rms(&curve, &mie)
        );
    }
    divan::main();
}

#[divan::bench(args = THEORIES, sample_count = 10, sample_size = 1)]
fn table(theory: Theory) -> f32 {
    scattering_table(&request(theory), &unwatched)
        .unwrap()
        .values[[0; 5]]
}
