//! Exact tables without a sun's disc, between their angles, against drops that are computed there.

#![allow(
    clippy::unwrap_used,
    reason = "the helpers of these tests fail by panicking"
)]

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_exchange::ScatteringTable;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_sizes::gamma_area_quadrature;

const WAVELENGTHS_NM: [f64; 2] = [450.0, 650.0];
/// Places between two angles: none that halving an interval comes to.
const PLACES: [f64; 3] = [0.17, 0.41, 0.69];
/// Errors over the tolerance, which holds at five points of an interval.
const WORST: f64 = 1.15;

fn request(theory: Theory, (radius_um, variance): (f64, f64)) -> TableRequest<'static> {
    let [first_nm, last_nm] = WAVELENGTHS_NM;
    TableRequest {
        theory,
        orders: (0..8).collect(),
        theta_range_rad: (0.0, PI),
        tolerance: 2e-3,
        wavelengths: WavelengthGrid::new(first_nm, last_nm - first_nm, 2).unwrap(),
        effective_radius_um: vec![radius_um],
        effective_variance: vec![variance],
        rows: SizeRows::Laws,
        motion: None,
        sun_disc_diameter_rad: 0.0,
        water: Water::pure(15.0),
        airy_table: None,
    }
}

fn table(request: &TableRequest) -> ScatteringTable {
    scattering_table(request, &unwatched).unwrap()
}

/// Natural light of a gamma law at some angles, drop after drop at so many radii.
fn literal(
    (theory, wavelength_nm): (Theory, f64),
    (radius_um, variance): (f64, f64),
    theta_rad: &[f64],
) -> Vec<f64> {
    let n_radii = if variance > 0.0 { 3000 } else { 1 };
    let angles: Vec<Radians> = theta_rad.iter().copied().map(Radians).collect();
    let angles = ScatteringAngles::new(&angles).unwrap();
    let wavelength = Nanometers(wavelength_nm);
    let n = Water::pure(15.0).refractive_index(wavelength);
    let index = RefractiveIndex { n, k: 0.0 };
    let mut light = vec![0.0; theta_rad.len()];
    let sizes = gamma_area_quadrature(Micrometers(radius_um), variance, n_radii).unwrap();
    for (radius_um, weight) in sizes.into_iter().filter(|(_, weight)| *weight > 1e-9) {
        let sphere = Sphere::from_radius(Micrometers(radius_um), wavelength, index).unwrap();
        let both = match theory {
            Theory::Debye { max_order } => {
                let orders: Vec<u32> = (0..=max_order).collect();
                let series = sphere.debye_series();
                series.incoherent_cross_sections(&orders, &angles)
            }
            _ => sphere.waves().normalized_cross_sections(&angles),
        };
        for (sum, [s, p]) in light.iter_mut().zip(both) {
            *sum += 0.5 * weight * (s + p);
        }
    }
    light
}

/// The largest error of a table between its angles, in parts of the peak on the same side of 90 degrees.
fn worst_between(table: &ScatteringTable, exact: impl Fn(f64, &[f64]) -> Vec<f64>) -> f64 {
    let theta = &table.theta_rad;
    let mut worst = 0.0_f64;
    for (wavelength, nm) in WAVELENGTHS_NM.into_iter().enumerate() {
        let at = |angle: usize| {
            let of = |j| f64::from(table.values[[j, 0, 0, wavelength, angle]]);
            0.5 * (of(0) + of(1))
        };
        let (mut angles, mut found) = (Vec::new(), Vec::new());
        for index in 1..theta.len() {
            for place in PLACES {
                angles.push(theta[index - 1] * (1.0 - place) + theta[index] * place);
                found.push(at(index - 1) * (1.0 - place) + at(index) * place);
            }
        }
        let exact = exact(nm, &angles);
        for is_behind in [false, true] {
            let of_side = |theta: &f64| (*theta >= FRAC_PI_2) == is_behind;
            let peak = (0..theta.len())
                .filter(|index| of_side(&theta[*index]))
                .map(at);
            let peak = peak.fold(0.0, f64::max);
            let rows = angles.iter().zip(found.iter().zip(&exact));
            for (_, (found, exact)) in rows.filter(|(theta, _)| of_side(theta)) {
                worst = worst.max((found - exact).abs() / peak);
            }
        }
    }
    worst
}

#[test]
fn tables_without_a_disc_keep_their_tolerance_between_angles() {
    let debye = Theory::Debye { max_order: 3 };
    for (theory, law, tolerance) in [
        (Theory::Mie, (3.0, 0.0), 1e-2),
        (Theory::Mie, (31.0, 0.0), 2e-3),
        (Theory::Mie, (110.0, 0.0), 2e-2),
        (Theory::BySize, (9.0, 0.0), 5e-3),
        (debye, (5.0, 0.1), 1e-3),
        (debye, (23.0, 0.0), 5e-3),
        (debye, (70.0, 0.0), 1e-3),
    ] {
        let table = table(&TableRequest {
            tolerance,
            ..request(theory, law)
        });
        let exact = |nm: f64, angles: &[f64]| literal((theory, nm), law, angles);
        let off = worst_between(&table, exact) / tolerance;
        let n = table.theta_rad.len();
        assert!(
            off < WORST,
            "{theory:?} {law:?} {tolerance}: {off} with {n}"
        );
    }
}
