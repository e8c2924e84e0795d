//! The Debye series as a whole.

use num_complex::Complex64;

use crate::support::degrees;
use crate::support::sphere;

fn sum_of_orders(x: f64, (n, k): (f64, f64), n_orders: u32, angles_deg: &[f64]) -> Vec<Complex64> {
    let series = sphere(x, n, k).debye_series();
    let angles = degrees(angles_deg);
    let mut sum = vec![Complex64::ZERO; angles_deg.len()];
    for order in 0..n_orders {
        for (sum, s1) in sum
            .iter_mut()
            .zip(series.order(order).amplitudes(&angles).s1)
        {
            *sum += s1;
        }
    }
    sum
}

#[test]
fn without_absorption_the_series_is_slow_and_the_glory_the_slowest() {
    let angles_deg = [60.0, 90.0, 120.0, 180.0];
    let mie = sphere(1000.0, 1.333, 0.0)
        .amplitudes(&degrees(&angles_deg))
        .s1;
    let error = |n_orders| -> Vec<f64> {
        let sum = sum_of_orders(1000.0, (1.333, 0.0), n_orders, &angles_deg);
        sum.iter()
            .zip(&mie)
            .map(|(sum, mie)| (sum - mie).norm() / mie.norm())
            .collect()
    };
    let (few, many) = (error(3), error(1000));
    for (few, many) in few.iter().zip(&many).take(3) {
        assert!(*many < 1e-3 && *few > 10.0 * many, "{few} {many}");
    }
    assert!(
        few[3] > 0.5 && many[3] > 1e-4,
        "the glory needs more than a few orders"
    );
}

#[test]
fn the_primary_bow_has_its_peak_where_airy_puts_it_and_a_dark_side() {
    // Theta_R = 137.9219 degrees for n = 1.333; the first maximum of Ai lies at
    // 1.01879 h^(1/3) x^(-2/3) = 0.339 degrees beyond, h = 4.89919 (x = 5000).
    let angles_deg: Vec<f64> = (0..=1000).map(|i| 134.0 + 0.01 * f64::from(i)).collect();
    let waves = sphere(5000.0, 1.333, 0.0).debye(2);
    let i1: Vec<f64> = waves
        .amplitudes(&degrees(&angles_deg))
        .s1
        .iter()
        .map(num_complex::Complex::norm_sqr)
        .collect();
    let peak = (0..i1.len())
        .max_by(|a, b| i1[*a].total_cmp(&i1[*b]))
        .unwrap();
    assert!(
        (angles_deg[peak] - 138.261).abs() <= 0.02,
        "{}",
        angles_deg[peak]
    );
    let dark = &i1[25..380];
    assert!(
        dark.windows(2).all(|pair| pair[0] < pair[1]),
        "no fringe on the dark side"
    );
    // Amplitudes end in a floor at 1e-12 of the peak.
    assert!(
        i1[300] < 1e-3 * i1[peak] && dark[0] < 1e-20 * i1[peak],
        "{} {}",
        i1[300],
        dark[0]
    );
}

#[test]
fn the_bow_is_polarized_as_fresnel_says() {
    // eps_p^2/eps_s^2 = 3.465e-3/8.779e-2 for the primary bow at n = 1.333; wave optics of a large
    // drop comes within 5 percent of it at the peak.
    let amplitudes = sphere(20000.0, 1.333, 0.0)
        .debye(2)
        .amplitudes(&degrees(&[138.057]));
    let [i1, i2] = amplitudes.intensities().next().unwrap();
    assert!(
        (i2 / i1 / (3.465e-3 / 8.779e-2) - 1.0).abs() <= 0.05,
        "{}",
        i2 / i1
    );
}

#[test]
fn incoherent_orders_are_the_sum_of_single_ones_to_the_last_bit() {
    // Orders share their pass over the waves, which must not show; 1060 waves take three passes.
    let sphere = sphere(1000.0, 1.333, 0.0);
    let angles_deg: Vec<f64> = (0..=90).map(|i| 2.0 * f64::from(i)).collect();
    let angles = degrees(&angles_deg);
    let orders = [0, 2, 3, 7];
    let found = sphere
        .debye_series()
        .incoherent_cross_sections(&orders, &angles);
    let mut sum = vec![[0.0; 2]; angles_deg.len()];
    for order in orders {
        let of_order = sphere.debye(order).normalized_cross_sections(&angles);
        for (sum, [s, p]) in sum.iter_mut().zip(of_order) {
            *sum = [sum[0] + s, sum[1] + p];
        }
    }
    assert_eq!(found, sum);
    let nothing = sphere
        .debye_series()
        .incoherent_cross_sections(&[], &angles);
    assert!(nothing.iter().all(|pair| *pair == [0.0; 2]));
}
