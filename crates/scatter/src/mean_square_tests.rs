use std::f64::consts::PI;
use std::f64::consts::TAU;

use super::*;
use crate::gamma_sample::C;
use niji_radiometry::Micrometers;
use niji_sizes::gamma_area_quadrature;

fn averaging(exponent: f64, effective_variance: f64) -> Averaging<'static> {
    Averaging {
        exponent,
        effective_variance,
        error: FINE,
        highest_z: 120.0,
        airy_table: None,
    }
}

/// The means straight from the quadrature of the size laws, with many nodes.
fn literal(exponent: f64, variance: f64, z: f64) -> [f64; 2] {
    let nodes = gamma_area_quadrature(Micrometers(1.0), variance, 3000).unwrap();
    let mut sums = [0.0; 2];
    for (t, weight) in nodes {
        let [square, derivative] = airy_squares(z * t.powf(2.0 / 3.0));
        sums[0] += weight * t.powf(exponent) * square;
        sums[1] += weight * t.powf(exponent - 2.0 / 3.0) * derivative;
    }
    sums
}

#[test]
fn constants_belong_to_each_other() {
    assert!((C - PI * PI / 12.0).abs() < 1e-15);
    assert!((ARGUMENT - C.cbrt()).abs() < 1e-15);
    assert!((PHASE - 4.0 / 3.0 * C.sqrt()).abs() < 1e-15);
    assert!((MEAN - (2.0 * PI * PI / 3.0).powf(2.0 / 3.0) / TAU).abs() < 1e-15);
}

/// Error over the larger of the value and 1e-3; measured worst 6.4e-5 (the published
/// power at v_e = 1/3).
const MEAN_TOLERANCE: f64 = 1e-4;

#[test]
fn the_means_are_those_of_the_literal_sum_over_sizes() {
    for variance in [0.0, 1e-8, 1e-4, 2e-3, 0.05, 1.0 / 3.0, 0.45] {
        for exponent in [1.0 / 3.0, -2.0 / 3.0] {
            let mean = MeanSquare::compute(averaging(exponent, variance));
            for z in [-10.0, -3.0, -0.5, 0.0, 1.087, 2.4955, 7.3, 21.0, 33.0, 61.0] {
                let expected = literal(exponent, variance, z);
                for (found, expected) in mean.values(z).into_iter().zip(expected) {
                    let off = (found - expected).abs() / expected.max(1e-3);
                    assert!(
                        off < MEAN_TOLERANCE,
                        "v_e = {variance}, q = {exponent}, z = {z}: {found} against {expected}"
                    );
                }
            }
        }
    }
}

/// Of means for an error of 1e-2, the largest F being 0.68; measured worst 1.4e-3.
const COARSE_TOLERANCE: f64 = 3e-3;

#[test]
fn coarse_means_are_those_for_tables_within_their_error() {
    for variance in [0.05, 0.45] {
        for exponent in [1.0 / 3.0, -2.0 / 3.0] {
            let fine = MeanSquare::compute(averaging(exponent, variance));
            let coarse = MeanSquare::compute(Averaging {
                error: 1e-2,
                ..averaging(exponent, variance)
            });
            let worst = (0..2000)
                .map(|step| -12.0 + 0.05 * f64::from(step))
                .map(|z| (coarse.values(z)[0] - fine.values(z)[0]).abs())
                .fold(0.0, f64::max);
            assert!(worst < COARSE_TOLERANCE, "v_e = {variance}: {worst}");
        }
    }
}

#[test]
fn the_primitives_rise_by_the_integrals_of_the_means() {
    for variance in [0.0, 2e-3, 1.0 / 3.0] {
        let mean = MeanSquare::compute(averaging(1.0 / 3.0, variance));
        for (from, to) in [(-8.0, -1.0), (-1.0, 4.0), (4.0, 29.0), (28.0, 44.0)] {
            let n = 20_000;
            let step = (to - from) / f64::from(n);
            let mut integrals = [0.0; 2];
            for i in 0..n {
                let values = mean.values(from + step * (f64::from(i) + 0.5));
                integrals[0] += values[0] / f64::from(n);
                integrals[1] += values[1] / f64::from(n);
            }
            let found = mean.means(&mean.primitives(from), &mean.primitives(to));
            for (found, integral) in found.into_iter().zip(integrals) {
                assert!(
                    (found / integral - 1.0).abs() < 1e-5,
                    "v_e = {variance}, {from} to {to}: {found} against {integral}"
                );
            }
        }
    }
}

#[test]
fn nothing_comes_from_far_in_the_dark_and_nothing_is_strange() {
    for variance in [0.0, 1e-12, 0.1, 0.49] {
        let mean = MeanSquare::compute(averaging(1.0 / 3.0, variance));
        assert_eq!(mean.values(-1e4), [0.0; 2]);
        assert_eq!(mean.primitives(-1e4).values, [0.0; 2]);
        assert_eq!(mean.values(f64::NAN), [0.0; 2]);
        for z in [-30.0, -1.0, 0.0, 100.0, 1e4] {
            for value in mean.values(z) {
                assert!(value.is_finite() && value > -1e-9);
            }
        }
    }
}
