//! Moved rows against means, sums and mirrors written down here.

use ndarray::Array4;
use ndarray::Array5;
use niji_dropfield::SizeRange;
use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::RowUse;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;

use super::*;

/// More wavelengths than two lanes, no multiple of them.
const N_WAVELENGTHS: usize = 19;
/// T² and B² at which nothing but the shift of first order is left.
const ALONG_T: [f64; 2] = [1.0, 0.0];

/// A shift of e k (T² − B²) alone, by wavelength.
fn shifts(k_rad: impl Fn(usize) -> f64) -> Vec<BowShift> {
    let shift = |wavelength| BowShift {
        coefficients_rad: [k_rad(wavelength), 0.0, 0.0, 0.0, 0.0],
    };
    (0..N_WAVELENGTHS).map(shift).collect()
}

/// Drops that neither tilt nor tremble.
fn still(eccentricity: f64) -> FallingDrops {
    FallingDrops {
        eccentricity,
        eccentricity_sd: 0.0,
        mean_sin2: 0.0,
        mean_sin4: 0.0,
    }
}

/// A table of which all moves, by radius, wavelength and angle.
fn table(
    (theta_rad, radii_um): (Vec<f64>, Vec<f64>),
    drops: impl Fn(f64) -> FallingDrops,
    shifts: Vec<BowShift>,
    value: impl Fn(usize, f64) -> f64,
) -> ScatteringTable {
    let shape = (2, radii_um.len(), N_WAVELENGTHS, theta_rad.len());
    let values = Array4::from_shape_fn(shape, |(j, _, wavelength, angle)| {
        ([0.5, 1.5][j] * value(wavelength, theta_rad[angle])) as f32
    });
    let of_sizes = (2, shape.1, 1, shape.2, shape.3);
    let order = MovedOrder {
        order: 2,
        shifts,
        theta_rad: theta_rad.clone(),
        values: values.clone(),
    };
    ScatteringTable {
        theory: "test".into(),
        orders: "2".into(),
        wavelengths: WavelengthGrid::new(400.0, 20.0, N_WAVELENGTHS).unwrap(),
        values: Array5::from_shape_fn(of_sizes, |(j, r, _, w, a)| values[[j, r, w, a]]),
        moved: Some(MovedBows {
            drops: radii_um.iter().map(|radius_um| drops(*radius_um)).collect(),
            orders: vec![order],
        }),
        theta_rad,
        effective_radius_um: radii_um,
        effective_variance: vec![0.0],
        row_use: RowUse::Sums,
        relative_error: 5e-3,
        sun_disc_diameter_rad: 0.0,
        split_theta_rad: 2.2,
        forward_fraction_left_out: 0.0,
        water: Water::pure(20.0),
        phase_functions: None,
        interpolation_error: None,
    }
}

/// Its moved rows at its own sizes.
fn rows(table: &ScatteringTable) -> MovedRows {
    let weights = [1.0; N_WAVELENGTHS];
    MovedRows::new(table, &SizeNodes::of_table(table), &weights, 0.0).unwrap()
}

/// Moved light of the first size along the axis of T.
fn shaded(rows: &MovedRows, theta_rad: f64, width_rad: f64) -> Vec<f32> {
    let mut stencil = MovedStencil::default();
    let place = MovedPlace {
        theta_rad,
        width_rad,
        axis_squares: ALONG_T,
    };
    rows.place(&place, &mut stencil);
    let mut spectrum = vec![0.0; N_WAVELENGTHS];
    rows.add(&[(0, 1.0)], &mut stencil, &mut spectrum);
    spectrum
}

fn even(first: f64, step: f64, n: u32) -> Vec<f64> {
    (0..n)
        .map(|index| first + step * f64::from(index))
        .collect()
}

/// From 0 to 180 degrees.
fn all_angles() -> Vec<f64> {
    even(0.0, PI / 3600.0, 3601)
}

/// f32 integrals over steps of 0.05 degrees; measured 4.7e-7.
const SUM_ERROR: f64 = 2e-6;

#[test]
fn light_moves_and_widens_without_loss() {
    let bow = |wavelength: usize, theta: f64| {
        let off = (theta - 2.4) / 0.01;
        (1.0 + wavelength as f64) * (-0.5 * off * off).exp()
    };
    let k_rad = |wavelength: usize| 1.5 + 4e-4 * wavelength as f64;
    let mut moments = Vec::new();
    for (eccentricity, eccentricity_sd) in [(0.01, 0.0), (0.1, 0.0), (0.1, 0.02)] {
        let drops = |_| FallingDrops {
            eccentricity_sd,
            ..still(eccentricity)
        };
        let table = table((all_angles(), vec![100.0]), drops, shifts(k_rad), bow);
        let rows = rows(&table);
        let step = PI / 3600.0;
        let mut sums = [[0.0; 3]; N_WAVELENGTHS];
        for theta in even(1.8, step, 4000)
            .into_iter()
            .filter(|theta| *theta < 3.0)
        {
            let spectrum = shaded(&rows, theta, 0.0);
            for (value, sums) in spectrum.into_iter().zip(&mut sums) {
                for (power, sum) in (0..).zip(sums) {
                    *sum += step * f64::from(value) * (theta - 2.4).powi(power);
                }
            }
        }
        for (wavelength, [sum, first, second]) in sums.into_iter().enumerate() {
            let whole = (1.0 + wavelength as f64) * 0.01 * (2.0 * PI).sqrt();
            assert!((sum / whole - 1.0).abs() < SUM_ERROR, "{sum} {whole}");
            let (mean, shift) = (first / sum, eccentricity * k_rad(wavelength));
            // Wavelengths that go together.
            let sd = (second / sum - mean * mean).sqrt();
            let spread = eccentricity_sd * k_rad(N_WAVELENGTHS / 2);
            let apart = 0.5 * APART_RAD.max(APART_OF_WIDTH * 12.0_f64.sqrt() * spread);
            moments.push(((mean - shift).abs(), apart, sd, 0.01_f64.hypot(spread)));
        }
    }
    for (off, apart, sd, expected) in moments {
        assert!(off < apart, "{off} {apart}");
        // Means over steps add about half of their square; measured 1.9e-3.
        assert!((sd / expected - 1.0).abs() < 2.5e-3, "{sd} {expected}");
    }
}

#[test]
fn beyond_0_and_180_degrees_light_is_mirrored() {
    let slanted = |wavelength: usize, theta: f64| (1.0 + wavelength as f64) * (1.0 + theta);
    for (k_rad, theta) in [(0.4, 0.1), (-0.4, PI - 0.1), (0.7, 0.02), (0.4, 1.0)] {
        let drops = |_| still(1.0);
        let table = table(
            (all_angles(), vec![100.0]),
            drops,
            shifts(|_| k_rad),
            slanted,
        );
        let moved: f64 = theta - k_rad;
        let source = if moved > PI {
            2.0 * PI - moved
        } else {
            moved.abs()
        };
        for (wavelength, found) in shaded(&rows(&table), theta, 0.0).iter().enumerate() {
            let error = f64::from(*found) / slanted(wavelength, source) - 1.0;
            // f32 integrals of all angles; measured 3.1e-4.
            assert!(error.abs() < 6e-4, "{theta} {k_rad}: {error}");
        }
    }
    // A table that ends before them is dark there.
    let drops = |_| still(1.0);
    let part = table(
        (even(1.0, 0.01, 100), vec![100.0]),
        drops,
        shifts(|_| 0.4),
        slanted,
    );
    assert_eq!(shaded(&rows(&part), 1.39, 0.0), [0.0; N_WAVELENGTHS]);
    assert!(
        shaded(&rows(&part), 1.41, 0.0)
            .iter()
            .all(|value| *value > 0.0)
    );
}

#[test]
fn the_widest_vectors_and_none_give_the_same_bits() {
    let wave = |wavelength: usize, theta: f64| 1.0 + (50.0 * theta + wavelength as f64).sin();
    let drops = |radius_um: f64| FallingDrops {
        eccentricity_sd: 1e-5 * radius_um,
        ..still(1e-4 * radius_um)
    };
    let radii_um = vec![100.0, 200.0, 800.0];
    let table = table(
        (all_angles(), radii_um),
        drops,
        shifts(|w| 1.0 + 0.1 * w as f64),
        wave,
    );
    let rows = rows(&table);
    let mut stencil = MovedStencil::default();
    let place = MovedPlace {
        theta_rad: 2.41,
        width_rad: 1e-3,
        axis_squares: [0.6, 0.1],
    };
    rows.place(&place, &mut stencil);
    let weights: Vec<f32> = (0..rows.drops.len())
        .map(|index| 0.3 / (1.0 + index as f32))
        .collect();
    let add = |sums: &mut [f32], is_wide: bool| -> f64 {
        let adding = Adding {
            rows: &rows,
            place: &stencil.place,
            attitude: &stencil.attitude,
            seen: &stencil.seen,
            weights: &weights,
            sums,
        };
        if is_wide {
            Arch::new().dispatch(adding)
        } else {
            adding.with_simd(pulp::Scalar::new())
        }
    };
    let mut sums = [false, true].map(|_| vec![0.0; rows.n_padded]);
    let mut peaks = [0.0; 2];
    for (index, is_wide) in [false, true].into_iter().enumerate() {
        peaks[index] = add(&mut sums[index], is_wide);
    }
    assert_eq!(peaks[0], peaks[1]);
    assert!(sums[0][..N_WAVELENGTHS].iter().all(|sum| *sum > 0.0));
    assert_eq!(sums[0], sums[1]);
    // Lanes behind the last wavelength hold nothing.
    assert!(sums[0][N_WAVELENGTHS..].iter().all(|sum| *sum == 0.0));
}

#[test]
fn the_bows_of_neighbors_lie_over_stretches_that_touch() {
    let radii_um = vec![100.0, 110.0, 300.0, 900.0];
    let drops = |radius_um: f64| still(1e-4 * radius_um);
    let table = table(
        (vec![2.0, 2.1], radii_um),
        drops,
        shifts(|_| 1.5),
        |_, _| 1.0,
    );
    let nodes = SizeNodes::of_table(&table);
    let radii = MovedRadii::new(&table, table.moved.as_ref().unwrap(), &nodes, 0.0);
    for (place, around) in radii.drops.iter().enumerate() {
        let last = radii.drops.len() - 1;
        let eccentricity = |place: usize| radii.drops[place].drops.eccentricity;
        let half = |place: usize| 0.5 * (eccentricity(place + 1) - eccentricity(place));
        let below = if place > 0 { half(place - 1) } else { 0.0 };
        let above = if place < last { half(place) } else { 0.0 };
        assert!((around.eccentricity_step - below - above).abs() < 1e-15);
    }
}

#[test]
fn blurred_light_has_fewer_rows_and_is_the_same() {
    let bow = |_: usize, theta: f64| (-0.5 * ((theta - 2.4) / 0.01).powi(2)).exp();
    let radii_um = niji_sizes::bins((60.0, 1500.0), 0.07);
    let drops = |radius_um: f64| still(8e-8 * radius_um * radius_um);
    let table = table((all_angles(), radii_um), drops, shifts(|_| 1.5), bow);
    let range = SizeRange {
        effective_radius_um: (300.0, 300.0),
        effective_variance: (0.25, 0.25),
    };
    let nodes = SizeNodes::of_drops(&table, Some(range));
    let rows =
        |apart_rad: f64| MovedRows::new(&table, &nodes, &[1.0; N_WAVELENGTHS], apart_rad).unwrap();
    let (all, few) = (rows(0.0), rows(0.08));
    assert!(10 * few.drops.len() < 6 * all.drops.len() && few.drops.len() > 5);
    assert_eq!(rows(1e-6).drops.len(), all.drops.len());
    // However far bows may lie apart, a law is still a sum.
    assert!(rows(10.0).drops.len() >= 5);
    let seen = |rows: &MovedRows, theta_rad| f64::from(shaded(rows, theta_rad, 0.3)[0]);
    let angles = || even(2.2, 0.01, 60).into_iter();
    let peak = angles().map(|theta| seen(&all, theta)).fold(0.0, f64::max);
    for theta in angles() {
        let change = (seen(&few, theta) - seen(&all, theta)).abs() / peak;
        assert!(change < 0.01, "{theta}: {change}");
    }
}

#[test]
fn moved_light_is_what_still_rows_leave_out() {
    // Bows lie far apart behind the last row that stays.
    for radii_um in [
        vec![10.0, 400.0, 900.0],
        niji_sizes::bins((10.0, 3000.0), 0.053),
    ] {
        let drops = |radius_um: f64| still(3e-8 * radius_um * radius_um);
        let angles = even(2.0, 0.1, 3);
        let mut table = table(
            (angles, radii_um.clone()),
            drops,
            shifts(|_| 2.0),
            |_, _| 1.0,
        );
        let first = radii_um.len() / 3;
        let moved = table.moved.as_mut().unwrap();
        moved.drops.drain(..first);
        let order = &mut moved.orders[0];
        order.values = order.values.slice(s![.., first.., .., ..]).to_owned();
        let range = SizeRange {
            effective_radius_um: (60.0, 500.0),
            effective_variance: (0.1, 0.1),
        };
        let nodes = SizeNodes::of_drops(&table, Some(range));
        let rows = MovedRows::new(&table, &nodes, &[1.0; N_WAVELENGTHS], 0.0).unwrap();
        for (bin, law) in rows.laws.iter().enumerate() {
            let of_rows = nodes.weights(bin, &radii_um).into_iter();
            let staying: f64 = of_rows
                .filter(|(row, _)| *row < first)
                .map(|(_, w)| w)
                .sum();
            let moving: f64 = law.weights.iter().copied().map(f64::from).sum();
            // Quadratures of hats with kinks at different radii; measured 1.5e-4.
            assert!(
                (staying + moving - 1.0).abs() < 2e-4,
                "{bin}: {staying} {moving}"
            );
        }
    }
}

#[test]
fn light_diffracted_forward_is_no_peak_of_a_bow() {
    let bow = |_: usize, theta: f64| (-0.5 * ((theta - 2.4) / 0.01).powi(2)).exp();
    let lobe = |wavelength: usize, theta: f64| bow(wavelength, theta) + 1e5 * (-50.0 * theta).exp();
    let with = |value: fn(f64, f64) -> f64| {
        let value = |w: usize, theta: f64| value(bow(w, theta), lobe(w, theta));
        let drops = |_| still(0.01);
        let table = table((all_angles(), vec![100.0]), drops, shifts(|_| 1.0), value);
        let rows = rows(&table);
        let mut stencil = MovedStencil::default();
        let place = MovedPlace {
            theta_rad: 2.3,
            width_rad: 0.0,
            axis_squares: ALONG_T,
        };
        rows.place(&place, &mut stencil);
        rows.add(&[(0, 1.0)], &mut stencil, &mut [0.0; N_WAVELENGTHS])
    };
    let [alone, beside] = [with(|bow, _| bow), with(|_, lobe| lobe)];
    assert!(alone > 0.0);
    assert_eq!(alone, beside);
}
