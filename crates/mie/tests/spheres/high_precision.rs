//! Against the references of `reference.py` and `reference_orders.py`, which have 20 correct digits.

use crate::order_references::ORDERS;
use crate::references::DEBYE;
use crate::references::MIE;
use crate::support::DebyeReference;
use crate::support::complex;
use crate::support::degrees;
use crate::support::sphere;

/// Relative; worst found 5.6e-15 (x = 2e4, absorbing).
const EFFICIENCY: f64 = 5e-14;
/// Relative; worst found 1.4e-14 (x = 5e4).
const ASYMMETRY: f64 = 1e-13;
/// Relative; worst found 3.7e-11 (x = 5e4 at 179.5 degrees), 3.5e-11 up to 2e4 (1e4 at 180 degrees).
const P11: f64 = 2e-10;
/// Relative to the larger of |S1| and |S2|; worst found 1.4e-10 (x = 5e4 at 180 degrees).
const AMPLITUDE: f64 = 5e-10;
/// Relative to the largest amplitude of the order; worst found 1.9e-12 (x = 5000, order 6).
const DEBYE_AMPLITUDE: f64 = 1e-11;

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

#[test]
fn efficiencies_agree_from_x_1e_minus_6_to_5e4() {
    for reference in &MIE {
        let (x, n, k) = (reference.x, reference.n, reference.k);
        let sphere = sphere(x, n, k);
        let q = sphere.efficiencies();
        assert!(
            relative(q.q_ext, reference.q_ext) <= EFFICIENCY,
            "{x} {n} {k}: {}",
            q.q_ext
        );
        assert!(
            relative(q.q_sca, reference.q_sca) <= EFFICIENCY,
            "{x} {n} {k}: {}",
            q.q_sca
        );
        assert!(
            relative(q.asymmetry, reference.g) <= ASYMMETRY,
            "{x} {n} {k}: {}",
            q.asymmetry
        );
    }
}

#[test]
fn amplitudes_and_phase_function_agree_at_every_angle_poles_included() {
    for reference in &MIE {
        let (x, n, k) = (reference.x, reference.n, reference.k);
        let sphere = sphere(x, n, k);
        let angles: Vec<f64> = reference.amplitudes.iter().map(|at| at.0).collect();
        let found = sphere.amplitudes(&degrees(&angles));
        let p11 = sphere.p11(&found);
        for (i, (theta_deg, s1, s2)) in reference.amplitudes.iter().enumerate() {
            let (s1, s2) = (complex(*s1), complex(*s2));
            let intensity = s1.norm_sqr() + s2.norm_sqr();
            let expected = 2.0 * intensity / (x * x * reference.q_sca);
            assert!(
                relative(p11[i], expected) <= P11,
                "{x} {n} {k} at {theta_deg}: {}",
                p11[i]
            );
            let error = (found.s1[i] - s1).norm().max((found.s2[i] - s2).norm());
            let scale = s1.norm().max(s2.norm());
            assert!(
                error <= AMPLITUDE * scale,
                "{x} {n} {k} at {theta_deg}: {error}"
            );
        }
    }
}

fn check_orders(references: &[DebyeReference]) {
    for reference in references {
        let sphere = sphere(reference.x, reference.n, reference.k);
        let angles: Vec<f64> = reference.amplitudes.iter().map(|at| at.0).collect();
        let found = sphere.debye(reference.order).amplitudes(&degrees(&angles));
        let moduli = reference.amplitudes.iter().map(|at| complex(at.1).norm());
        let largest = moduli.fold(0.0, f64::max);
        for (i, (theta_deg, s1, s2)) in reference.amplitudes.iter().enumerate() {
            let error = (found.s1[i] - complex(*s1))
                .norm()
                .max((found.s2[i] - complex(*s2)).norm());
            let (x, order) = (reference.x, reference.order);
            assert!(
                error <= DEBYE_AMPLITUDE * largest,
                "{x} order {order} at {theta_deg}: {error}"
            );
        }
    }
}

#[test]
fn orders_of_the_debye_series_agree() {
    check_orders(&DEBYE);
}

#[test]
fn orders_of_raindrops_and_of_absorbing_drops_agree_with_a_second_method() {
    check_orders(&ORDERS);
}
