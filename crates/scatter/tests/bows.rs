//! Where the bows of a scattering table lie, how high they are, and what the table keeps.

#![allow(
    clippy::unwrap_used,
    reason = "the helpers of these tests fail by panicking"
)]

use std::f64::consts::PI;

use niji_airy::AiryBow;
use niji_airy::AiryTable;
use niji_airy::airy_squares;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::water_refractive_index;
use niji_scatter::Error;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::airy_from_file;
use niji_scatter::airy_to_file;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_sizes::gamma_area_quadrature;
use niji_sizes::radius_axis;

/// Apparent diameter of the sun.
const SUN_DISC_DEG: f64 = 0.533;

fn request(theory: Theory, radii_um: &[f64]) -> TableRequest<'static> {
    TableRequest {
        theory,
        orders: vec![2, 3],
        theta_range_rad: (120.0_f64.to_radians(), 150.0_f64.to_radians()),
        tolerance: 1e-3,
        wavelengths: WavelengthGrid::new(560.0, 10.0, 1).unwrap(),
        effective_radius_um: radii_um.to_vec(),
        effective_variance: vec![0.0],
        rows: SizeRows::Laws,
        motion: None,
        sun_disc_diameter_rad: SUN_DISC_DEG.to_radians(),
        water: Water::pure(20.0),
        airy_table: None,
    }
}

fn table(request: &TableRequest) -> ScatteringTable {
    scattering_table(request, &unwatched).unwrap()
}

/// Natural light at one row and wavelength against the bow angle in degrees.
fn curve(table: &ScatteringTable, row: [usize; 2], wavelength: usize) -> Vec<(f64, f64)> {
    let [radius, variance] = row;
    (0..table.theta_rad.len())
        .map(|angle| {
            let at = |j| f64::from(table.values[[j, radius, variance, wavelength, angle]]);
            (
                180.0 - table.theta_rad[angle].to_degrees(),
                0.5 * (at(0) + at(1)),
            )
        })
        .collect()
}

fn peak_deg(curve: &[(f64, f64)], from_deg: f64, to_deg: f64) -> f64 {
    let inside = curve
        .iter()
        .filter(|(angle, _)| (from_deg..to_deg).contains(angle));
    inside.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
}

#[test]
fn small_drops_put_the_primary_at_41_degrees_and_large_ones_near_descartes() {
    // Lorenz-Mie at 560 nm: 40.30, 40.97 and 41.40 degrees for 0.05, 0.1 and 0.25 mm.
    let table = table(&request(Theory::Airy, &[50.0, 100.0, 250.0, 1000.0]));
    let peaks: Vec<f64> = (0..4)
        .map(|radius| peak_deg(&curve(&table, [radius, 0], 0), 35.0, 46.0))
        .collect();
    // The exact peak of a single small size is moved by the ripple between orders 0 and 2.
    for (found, (expected, tolerance)) in
        peaks
            .iter()
            .zip([(40.30, 0.25), (40.97, 0.1), (41.40, 0.1)])
    {
        assert!(
            (found - expected).abs() < tolerance,
            "{found} against {expected}"
        );
    }
    // The rainbow ray of n(560 nm) lies at 42.1 degrees; the disc pulls the peak a little inside.
    assert!((peaks[3] - 41.9).abs() < 0.2, "{}", peaks[3]);
}

#[test]
fn the_secondary_lies_where_the_wave_puts_it() {
    let table = table(&request(Theory::Airy, &[100.0, 500.0, 1000.0]));
    let peak = |radius| peak_deg(&curve(&table, [radius, 0], 0), 48.0, 58.0);
    assert!((peak(0) - 52.7).abs() < 0.3, "0.1 mm: {}", peak(0));
    for radius in [1, 2] {
        assert!((51.2..51.9).contains(&peak(radius)), "{}", peak(radius));
    }
}

#[test]
fn the_colors_of_the_secondary_run_the_other_way() {
    let mut request = request(Theory::Airy, &[500.0]);
    request.wavelengths = WavelengthGrid::new(450.0, 100.0, 3).unwrap();
    let table = table(&request);
    let peak = |wavelength, from, to| peak_deg(&curve(&table, [0, 0], wavelength), from, to);
    assert!(
        peak(2, 35.0, 46.0) > peak(0, 35.0, 46.0) + 1.0,
        "red outside in the primary"
    );
    assert!(
        peak(2, 48.0, 58.0) < peak(0, 48.0, 58.0) - 1.5,
        "red inside in the secondary"
    );
}

#[test]
fn airy_meets_lorenz_mie_where_it_is_said_to() {
    // 0.1 mm, 5 % spread of sizes, after the disc: position and height of the primary.
    let with = |theory| {
        let mut request = request(theory, &[100.0]);
        request.effective_variance = vec![0.0025];
        request.theta_range_rad = (136.0_f64.to_radians(), 142.0_f64.to_radians());
        curve(&table(&request), [0, 0], 0)
    };
    let (airy, mie) = (with(Theory::Airy), with(Theory::Mie));
    let highest = |curve: &[(f64, f64)]| curve.iter().fold(0.0_f64, |a, b| a.max(b.1));
    assert!((peak_deg(&airy, 39.0, 43.0) - peak_deg(&mie, 39.0, 43.0)).abs() < 0.08);
    let ratio = highest(&airy) / highest(&mie);
    assert!((ratio - 1.0).abs() < 0.06, "Airy/Mie peak {ratio}");
}

#[test]
fn debye_orders_without_background_lie_below_mie_in_alexanders_band() {
    let band = |theory, orders: &[u32]| {
        let mut request = request(theory, &[50.0]);
        request.orders = orders.to_vec();
        request.effective_variance = vec![0.01];
        request.theta_range_rad = (131.0_f64.to_radians(), 135.0_f64.to_radians());
        let curve = curve(&table(&request), [0, 0], 0);
        curve.iter().map(|(_, t)| t).sum::<f64>() / curve.len() as f64
    };
    let (airy, debye, mie) = (
        band(Theory::Airy, &[2, 3]),
        band(Theory::Debye { max_order: 7 }, &[0, 1, 2, 3, 4, 5, 6, 7]),
        band(Theory::Mie, &[]),
    );
    assert!(
        airy < 0.2 * mie,
        "the bows alone leave the band dark: {airy} against {mie}"
    );
    assert!(
        (debye / mie - 1.0).abs() < 0.15,
        "orders 0 to 7: {debye} against {mie}"
    );
}

#[test]
fn the_energy_of_the_table_is_that_of_its_rays() {
    // Orders 2 and 3 over the whole sphere against geometric optics: Airy only moves light around.
    let total = |theory| {
        let mut request = request(theory, &[300.0]);
        request.theta_range_rad = (0.0, PI);
        let table = table(&request);
        let curve = curve(&table, [0, 0], 0);
        let terms = curve.windows(2).enumerate().map(|(index, pair)| {
            let (from, to) = (table.theta_rad[index], table.theta_rad[index + 1]);
            PI * (pair[0].1 * from.sin() + pair[1].1 * to.sin()) * (to - from)
        });
        terms.sum::<f64>()
    };
    let (airy, rays) = (total(Theory::Airy), total(Theory::Geometric));
    assert!((airy / rays - 1.0).abs() < 0.02, "{airy} against {rays}");
}

#[test]
fn the_table_of_airys_integral_changes_nothing_visible() {
    let airy = AiryTable::compute();
    let exact = table(&request(Theory::Airy, &[200.0]));
    let looked_up = table(&TableRequest {
        airy_table: Some(&airy),
        ..request(Theory::Airy, &[200.0])
    });
    assert_eq!(exact.theta_rad, looked_up.theta_rad);
    let peak = exact.values.iter().fold(0.0_f32, |a, &b| a.max(b));
    for (a, b) in exact.values.iter().zip(&looked_up.values) {
        assert!((a - b).abs() < 1e-6 * peak);
    }
}

#[test]
fn interpolation_between_radii_keeps_its_tolerance() {
    let tolerance = 5e-3;
    let nodes = radius_axis((100.0, 200.0), 0.0, tolerance).unwrap();
    let middle = (nodes[3] * nodes[4]).sqrt();
    let table = table(&request(Theory::Airy, &[nodes[3], middle, nodes[4]]));
    let [low, exact, high] = [0, 1, 2].map(|radius| curve(&table, [radius, 0], 0));
    let peak = exact.iter().fold(0.0_f64, |a, b| a.max(b.1));
    let squares = exact
        .iter()
        .enumerate()
        .map(|(i, (_, value))| ((0.5 * (low[i].1 + high[i].1) - value) / peak).powi(2));
    let rms = (squares.sum::<f64>() / exact.len() as f64).sqrt();
    assert!(rms < tolerance, "rms {rms}");
}

/// Natural light at one row, wavelength and angle, linear between the angles of the table.
fn natural(table: &ScatteringTable, row: [usize; 2], wavelength: usize, theta_rad: f64) -> f64 {
    let angles = &table.theta_rad;
    let above = angles.partition_point(|&angle| angle <= theta_rad);
    let above = above.clamp(1, angles.len() - 1);
    let part = (theta_rad - angles[above - 1]) / (angles[above] - angles[above - 1]);
    let at = |angle| {
        let value = |j| f64::from(table.values[[j, row[0], row[1], wavelength, angle]]);
        0.5 * (value(0) + value(1))
    };
    at(above - 1) * (1.0 - part) + at(above) * part
}

#[test]
fn the_angles_keep_their_tolerance_at_every_wavelength() {
    // Judged at three wavelengths only, broad rain was off by 6 % of its peak between them.
    let tolerance = 3e-3;
    let mut request = request(Theory::Airy, &[1000.0]);
    request.effective_variance = vec![1.0 / 3.0];
    request.wavelengths = WavelengthGrid::new(400.0, 40.0, 9).unwrap();
    request.tolerance = tolerance;
    let coarse = table(&request);
    request.tolerance = 2e-5;
    let fine = table(&request);
    assert!(
        coarse.theta_rad.len() < 200,
        "{} angles",
        coarse.theta_rad.len()
    );
    for wavelength in 0..9 {
        let curve = curve(&fine, [0, 0], wavelength);
        let peak = curve.iter().fold(0.0_f64, |a, b| a.max(b.1));
        for (&theta_rad, (_, expected)) in fine.theta_rad.iter().zip(curve) {
            let found = natural(&coarse, [0, 0], wavelength, theta_rad);
            assert!((found - expected).abs() < 1.1 * tolerance * peak);
        }
    }
}

#[test]
fn without_a_disc_the_table_is_the_theory() {
    let mut request = request(Theory::Airy, &[30.0, 200.0]);
    request.sun_disc_diameter_rad = 0.0;
    let table = table(&request);
    let index = water_refractive_index(Nanometers(560.0), 20.0);
    let bows = [2, 3].map(|p| AiryBow::new(index, p).unwrap());
    let largest = table.values.iter().fold(0.0_f32, |a, &b| a.max(b));
    for (radius, radius_um) in [(0, 30.0), (1, 200.0)] {
        for (angle, &theta_rad) in table.theta_rad.iter().enumerate() {
            let terms = bows.iter().map(|bow| {
                bow.direction(Radians(theta_rad)).normalized_cross_section(
                    Micrometers(radius_um),
                    Nanometers(560.0),
                    airy_squares,
                )
            });
            let expected = terms.fold([0.0; 2], |sum, t| [sum[0] + t[0], sum[1] + t[1]]);
            for (j, expected) in expected.into_iter().enumerate() {
                let found = table.values[[j, radius, 0, 0, angle]];
                assert!((f64::from(found) - expected).abs() < 1e-6 * f64::from(largest));
            }
        }
    }
}

#[test]
fn a_row_of_many_sizes_is_the_mean_of_their_single_rows() {
    let variance = 0.02;
    let sizes = gamma_area_quadrature(Micrometers(60.0), variance, 41).unwrap();
    let radii: Vec<f64> = sizes.iter().map(|(radius_um, _)| *radius_um).collect();
    let mut request = request(Theory::Airy, &radii);
    let single = table(&request);
    request.effective_radius_um = vec![60.0];
    request.effective_variance = vec![variance];
    let mixed = table(&request);
    let peak = curve(&mixed, [0, 0], 0)
        .iter()
        .fold(0.0_f64, |a, b| a.max(b.1));
    for &theta_rad in &mixed.theta_rad {
        let terms = sizes.iter().enumerate();
        let expected: f64 = terms
            .map(|(radius, (_, weight))| weight * natural(&single, [radius, 0], 0, theta_rad))
            .sum();
        let found = natural(&mixed, [0, 0], 0, theta_rad);
        assert!(
            (found - expected).abs() < 2e-3 * peak,
            "{found} against {expected}"
        );
    }
}

#[test]
fn the_same_request_gives_the_same_table_on_any_number_of_threads() {
    let mut request = request(Theory::Airy, &[80.0, 90.0]);
    request.effective_variance = vec![0.0, 0.1];
    request.wavelengths = WavelengthGrid::new(400.0, 30.0, 7).unwrap();
    let on = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build()
            .unwrap();
        pool.install(|| table(&request))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
}

#[test]
fn tables_survive_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scatter.exr");
    let mut request = request(Theory::Airy, &[80.0, 90.0]);
    request.effective_variance = vec![0.0, 0.1];
    request.wavelengths = WavelengthGrid::new(400.0, 12.5, 3).unwrap();
    let table = table(&request);
    let mut file = std::fs::File::create(&path).unwrap();
    table
        .to_file(Provenance::default())
        .write(&mut file)
        .unwrap();
    let read = TableFile::read(&path).unwrap();
    assert!(
        matches!(airy_from_file(&read), Err(Error::AiryTable(_))),
        "another quantity"
    );
    assert_eq!(ScatteringTable::from_file(read).unwrap(), table);

    let airy = AiryTable::compute();
    let mut file = std::fs::File::create(&path).unwrap();
    airy_to_file(&airy, Provenance::default())
        .write(&mut file)
        .unwrap();
    let back = airy_from_file(&TableFile::read(&path).unwrap()).unwrap();
    assert_eq!(back.z, airy.z);
    assert!(ScatteringTable::from_file(TableFile::read(&path).unwrap()).is_err());
}
