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

/// Light of waves that leave bows apart.
const IN_WAVES: Blur = Blur::Waves { apart_rad: 0.0 };

/// The moved rows of tables, one a polarization, at their own sizes.
fn rows_of(tables: &[ScatteringTable], blur: Blur) -> MovedRows {
    let nodes = SizeNodes::of_table(&tables[0]);
    MovedRows::new(tables, &nodes, &[1.0; N_WAVELENGTHS], blur).unwrap()
}

/// Those of natural light that nothing blurs.
fn rows(table: &ScatteringTable) -> MovedRows {
    rows_of(std::slice::from_ref(table), Blur::Pixel)
}

/// Moved light of the first size along the axis of T, by polarization.
fn lights(rows: &MovedRows, theta_rad: f64, width_rad: f64) -> Vec<MovedLight> {
    let mut stencil = MovedStencil::default();
    let place = MovedPlace {
        theta_rad,
        width_rad,
        axis_squares: ALONG_T,
    };
    rows.place(&place, &mut stencil);
    rows.shade(&[(0, 1.0)], &mut stencil);
    stencil.lights
}

/// The spectrum of the first of them.
fn shaded(rows: &MovedRows, theta_rad: f64, width_rad: f64) -> Vec<f32> {
    let mut spectrum = lights(rows, theta_rad, width_rad).swap_remove(0).spectrum;
    spectrum.truncate(N_WAVELENGTHS);
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
    same_bits::<2>(&rows(&table));
    same_bits::<3>(&rows_of(&[table.clone(), table], IN_WAVES));
}

fn same_bits<const PLACES: usize>(rows: &MovedRows) {
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
    let shade = |is_wide: bool| {
        let dark = MovedLight {
            spectrum: vec![0.0; rows.n_padded],
            error_cd_m2: 0.0,
        };
        let mut lights = vec![dark; rows.n_polarizations];
        let shading = Shading::<PLACES> {
            rows,
            place: &stencil.place,
            attitude: &stencil.attitude,
            seen: &stencil.seen,
            weights: &weights,
            lights: &mut lights,
        };
        if is_wide {
            Arch::new().dispatch(shading);
        } else {
            shading.with_simd(pulp::Scalar::new());
        }
        lights
    };
    for (narrow, wide) in shade(false).into_iter().zip(shade(true)) {
        assert_eq!(narrow.error_cd_m2, wide.error_cd_m2);
        assert_eq!(narrow.spectrum, wide.spectrum);
        let (light, behind) = wide.spectrum.split_at(N_WAVELENGTHS);
        assert!(light.iter().all(|sum| *sum > 0.0));
        // Lanes behind the last wavelength hold nothing.
        assert!(behind.iter().all(|sum| *sum == 0.0));
    }
}

/// A bow that rises in front of 2.4 and falls off slowly behind, as the primary does.
fn one_sided(wavelength: usize, theta: f64) -> f64 {
    let rise = 1.0 / (1.0 + (-(theta - 2.4) / 0.004).exp());
    (1.0 + 0.02 * wavelength as f64) * rise * (0.2 + 0.8 * (-(theta - 2.4).max(0.0) / 0.05).exp())
}

#[test]
fn polarizations_together_are_each_alone() {
    let drops = |radius_um: f64| FallingDrops {
        eccentricity_sd: 1e-5 * radius_um,
        ..still(1e-4 * radius_um)
    };
    let of = |value: fn(usize, f64) -> f64| {
        let axes = (all_angles(), vec![100.0, 200.0]);
        table(axes, drops, shifts(|w| 1.0 + 0.1 * w as f64), value)
    };
    let tables = [
        of(one_sided),
        of(|_, theta| 0.3 * one_sided(0, theta - 0.1)),
    ];
    let together = rows_of(&tables, IN_WAVES);
    for theta in even(2.3, 0.013, 30) {
        for (table, light) in tables.iter().zip(lights(&together, theta, 0.02)) {
            let [alone] = &lights(&rows_of(std::slice::from_ref(table), IN_WAVES), theta, 0.02)[..]
            else {
                panic!()
            };
            assert_eq!(light.error_cd_m2, alone.error_cd_m2);
            // Where one of both is lit they are not the same: the dark one has a millionth.
            for (light, alone) in light.spectrum.iter().zip(&alone.spectrum) {
                assert!((light - alone).abs() < 1e-4, "{light} {alone}");
            }
        }
    }
}

/// Drops of one size whose light does not move.
fn one_sided_table() -> ScatteringTable {
    table(
        (all_angles(), vec![100.0]),
        |_| still(0.0),
        shifts(|_| 0.0),
        one_sided,
    )
}

#[test]
fn a_tent_shows_what_a_gaussian_does() {
    let table = one_sided_table();
    let rows = rows_of(&[table], IN_WAVES);
    let step = 1e-3;
    for sd_rad in [0.02, 0.05, 0.15] {
        let gaussian = |theta: f64| {
            let offs = even(-4.5 * sd_rad, step, (9.0 * sd_rad / step) as u32 + 1);
            let terms = offs.into_iter().map(|off| {
                let weight = (-0.5 * (off / sd_rad).powi(2)).exp();
                [weight, weight * one_sided(3, theta + off)]
            });
            let [all, sum] = terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]]);
            sum / all
        };
        let angles = || even(1.8, 0.02, 40).into_iter().filter(|it| *it < 2.5);
        let peak = angles().map(gaussian).fold(0.0, f64::max);
        for theta in angles() {
            let seen = f64::from(shaded(&rows, theta, 12.0_f64.sqrt() * sd_rad)[3]);
            let off = (seen - gaussian(theta)).abs() / peak;
            assert!(off < 0.045, "{sd_rad} {theta}: {off}");
        }
    }
}

#[test]
fn tents_lose_no_light_and_rounding_is_a_thousandth_of_the_narrowest() {
    let table = one_sided_table();
    let (even_rows, tents) = (
        rows(&table),
        rows_of(std::slice::from_ref(&table), IN_WAVES),
    );
    let step = PI / 3600.0;
    // No tent is narrower than two steps.
    for theta in even(2.3, 0.7 * step, 400) {
        let [found, expected] = [shaded(&tents, theta, 0.0), shaded(&even_rows, theta, 0.0)];
        for (found, expected) in found.iter().zip(expected) {
            // Steps on the steepest rise differ by a part of it.
            assert!(
                (found - expected).abs() < 0.03,
                "{theta}: {found} {expected}"
            );
        }
    }
    for width_rad in [0.01, 0.1, 0.4] {
        let sum: f64 = even(1.5, 1e-3, 2200)
            .into_iter()
            .filter(|theta| *theta < 2.75)
            .map(|theta| 1e-3 * f64::from(shaded(&tents, theta, width_rad)[0]))
            .sum();
        let expected: f64 = even(1.5, 1e-3, 1250)
            .into_iter()
            .map(|theta| 1e-3 * one_sided(0, theta))
            .sum();
        // Even light beyond 2.75 comes in as much as goes out.
        assert!(
            (sum / expected - 1.0).abs() < 5e-3,
            "{width_rad}: {sum} {expected}"
        );
    }
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
    let rows = |blur| {
        MovedRows::new(
            std::slice::from_ref(&table),
            &nodes,
            &[1.0; N_WAVELENGTHS],
            blur,
        )
        .unwrap()
    };
    let apart = |apart_rad: f64| rows(Blur::Waves { apart_rad });
    let (all, few) = (apart(0.0), apart(0.08));
    assert!(10 * few.drops.len() < 6 * all.drops.len() && few.drops.len() > 5);
    assert_eq!(apart(1e-6).drops.len(), all.drops.len());
    // However far bows may lie apart, a law is still a sum.
    assert!(apart(10.0).drops.len() >= 5);
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
        let rows = MovedRows::new(&[table], &nodes, &[1.0; N_WAVELENGTHS], Blur::Pixel).unwrap();
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
fn light_diffracted_forward_is_no_peak_of_light_elsewhere() {
    let bow = |_: usize, theta: f64| (-0.5 * ((theta - 2.4) / 0.01).powi(2)).exp();
    let lobe = |wavelength: usize, theta: f64| bow(wavelength, theta) + 1e5 * (-50.0 * theta).exp();
    let with = |value: fn(f64, f64) -> f64, seen_rad: f64| {
        let value = |w: usize, theta: f64| value(bow(w, theta), lobe(w, theta));
        let drops = |_| still(0.01);
        let table = table((all_angles(), vec![100.0]), drops, shifts(|_| 1.0), value);
        lights(&rows(&table), seen_rad, 0.0)[0].error_cd_m2
    };
    let [alone, beside] = [with(|bow, _| bow, 2.3), with(|_, lobe| lobe, 2.3)];
    assert!(alone > 0.0);
    assert_eq!(alone, beside);
    // In front as well: 45 degrees of the lobe bring 1e-17 of its middle.
    assert!(with(|_, lobe| lobe, 1.2) < 1e-6 * alone);
    assert!(with(|_, lobe| lobe, 0.001) > 1e4 * alone);
}

/// Of a table that was made for nothing, what lines between its angles miss.
#[test]
fn what_lines_between_angles_miss_is_told() {
    let lobe = |_: usize, theta: f64| (-2.0 * theta).exp();
    let of_steps = |n: u32| {
        let angles = even(0.0, PI / f64::from(n - 1), n);
        let still_drops = |_| still(1e-9);
        let mut table = table((angles, vec![100.0]), still_drops, shifts(|_| 1.0), lobe);
        table.relative_error = 0.0;
        rows(&table)
    };
    let [coarse, fine] = [of_steps(31), of_steps(30_001)];
    for theta_rad in even(0.2, 0.05, 50) {
        // Two steps wide.
        let of = |rows: &MovedRows| lights(rows, theta_rad, PI / 15.0).remove(0);
        let light = |of: &MovedLight| of.spectrum[..N_WAVELENGTHS].iter().sum::<f32>();
        let (found, expected) = (of(&coarse), of(&fine));
        let off = f64::from((light(&found) - light(&expected)).abs());
        assert!(off > 1e-6, "{theta_rad}");
        assert!(off <= found.error_cd_m2, "{theta_rad}: {off}");
    }
}
