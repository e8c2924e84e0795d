//! A gamma law as weights of a few single radii, between which light is interpolated.
//!
//! t(r_e, v_e) = sum_a w_a t(a),   w_a = int p(ln r) h_a(ln r) dln r,   sum w_a = 1
//! `p` share of the cross-section for each ln r, `h_a` the hat of the radius `a`: 1 there, linear in ln r
//! to 0 at its neighbors; beyond the outermost radii these stand for all others. Light of a radius is a mean
//! over the step around it, which makes a law wider by a twelfth of the squared step, and hats do by a sixth, on
//! the mean. So a law narrower by as much is spread over them:
//!   v = v_e − (h²/4)/(dσ²/dv),   σ² = v + v²/2 + v³/6
//!   ln r_e' = ln r_e + m(v_e) − m(v),   m(v) = −v/2 − v²/12
//! `h` step of ln r around r_e, `σ²` variance and `m` mean of ln(r/r_e) over the cross-section of a gamma law.
//! The mean stays. A law of less width than that lies between two radii and has the light of both.
//!
//! A law has drops of every size. [`law_support`] says where all but a given share of its cross-section
//! lies.

use niji_radiometry::Micrometers;

use crate::Error;
use crate::gamma_area_quadrature;

/// Nodes of the quadrature of a law for each step between radii within it, and for any law.
const NODES_PER_STEP: f64 = 4.0;
const N_LEAST_NODES: usize = 64;
/// Standard deviations that a law reaches over, about.
const REACH: f64 = 11.0;
/// Nodes that tell where a law ends.
const N_SUPPORT_NODES: usize = 1024;

/// The radii of a law with their weights, of ascending radii in micrometres; radii without weight are left
/// out.
///
/// # Errors
/// [`Error::Parameter`] if the effective radius is not above 0 or the variance not in 0..1/2.
///
/// # Panics
/// If there are no radii.
pub fn law_weights(
    radii_um: &[f64],
    effective_radius: Micrometers,
    effective_variance: f64,
) -> Result<Vec<(usize, f64)>, Error> {
    assert!(!radii_um.is_empty(), "a law is spread over some radii");
    let efolds = (radii_um[radii_um.len() - 1] / radii_um[0]).ln();
    let ln_step = ln_step_around(radii_um, effective_radius.0);
    let variance = (effective_variance
        - 0.25 * ln_step * ln_step / (1.0 + effective_variance + 0.5 * effective_variance.powi(2)))
    .max(0.0);
    let steps = (radii_um.len() - 1) as f64 * (REACH * variance.sqrt() / efolds).min(1.0);
    // A single radius has no steps, and 0/0 of them.
    let n_nodes = N_LEAST_NODES + (NODES_PER_STEP * steps.max(0.0)).ceil() as usize;
    let moved = (mean_ln(effective_variance) - mean_ln(variance)).exp();
    let radius = Micrometers(effective_radius.0 * moved);
    let nodes = gamma_area_quadrature(radius, variance, n_nodes)?;
    let mut weights = vec![0.0; radii_um.len()];
    for (radius_um, weight) in nodes {
        let (lower, fraction) = place(radii_um, radius_um);
        weights[lower] += weight * (1.0 - fraction);
        // The upper neighbor of the last radius has the weight 0.
        if fraction > 0.0 {
            weights[lower + 1] += weight * fraction;
        }
    }
    let weights = weights.into_iter().enumerate();
    Ok(weights.filter(|(_, weight)| *weight > 0.0).collect())
}

/// The radii in micrometres between which all but the share `left_out` of the cross-section lies on
/// either side.
///
/// # Errors
/// As [`law_weights`].
pub fn law_support(
    effective_radius: Micrometers,
    effective_variance: f64,
    left_out: f64,
) -> Result<(f64, f64), Error> {
    let nodes = gamma_area_quadrature(effective_radius, effective_variance, N_SUPPORT_NODES)?;
    let mut below = 0.0;
    let (mut low_um, mut high_um) = (effective_radius.0, effective_radius.0);
    for (radius_um, weight) in nodes {
        if below <= left_out {
            low_um = low_um.min(radius_um);
            if below + weight > left_out {
                low_um = radius_um.min(effective_radius.0);
            }
        }
        below += weight;
        if below <= 1.0 - left_out {
            high_um = high_um.max(radius_um);
        }
    }
    Ok((low_um, high_um))
}

/// Mean of ln(r/r_e) over the cross-section of a gamma law: ψ(k) − ln k, k = 1/v, to v⁴/120.
fn mean_ln(variance: f64) -> f64 {
    -variance / 2.0 - variance * variance / 12.0
}

/// The step of ln r that a radius lies in; 0 of a single one.
fn ln_step_around(radii_um: &[f64], radius_um: f64) -> f64 {
    let (lower, _) = place(radii_um, radius_um);
    let upper = (lower + 1).min(radii_um.len() - 1);
    (radii_um[upper] / radii_um[upper.saturating_sub(1)]).ln()
}

/// Lower neighbor of a radius and the fraction of the step above it, in ln r; the ends hold beyond.
fn place(radii_um: &[f64], radius_um: f64) -> (usize, f64) {
    let above = radii_um.partition_point(|node| *node <= radius_um);
    if above == 0 || above == radii_um.len() {
        return (above.saturating_sub(1), 0.0);
    }
    let (low, high) = (radii_um[above - 1], radii_um[above]);
    (above - 1, (radius_um / low).ln() / (high / low).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radii at equal ratios.
    fn lattice(first_um: f64, per_efold: f64, efolds: f64) -> Vec<f64> {
        let n = (per_efold * efolds) as u32;
        let radius = |index| first_um * (f64::from(index) / per_efold).exp();
        (0..=n).map(radius).collect()
    }

    fn sum(radii_um: &[f64], (radius_um, variance): (f64, f64), t: impl Fn(f64) -> f64) -> f64 {
        let weights = law_weights(radii_um, Micrometers(radius_um), variance).unwrap();
        weights
            .iter()
            .map(|(index, weight)| weight * t(radii_um[*index]))
            .sum()
    }

    #[test]
    fn weights_are_positive_and_sum_to_one() {
        let radii_um = lattice(1.0, 20.0, 8.0);
        for variance in [0.0, 1e-12, 1e-4, 0.02, 1.0 / 3.0, 0.49] {
            for radius_um in [0.1, 1.0, 33.0, 1e4] {
                let total = sum(&radii_um, (radius_um, variance), |_| 1.0);
                assert!(
                    (total - 1.0).abs() < 1e-12,
                    "{radius_um} {variance}: {total}"
                );
            }
        }
    }

    #[test]
    fn a_size_that_is_a_radius_has_all_of_the_weight() {
        let radii_um = [10.0, 20.0, 40.0];
        for (index, radius_um) in radii_um.into_iter().enumerate() {
            let weights = law_weights(&radii_um, Micrometers(radius_um), 0.0).unwrap();
            assert_eq!(weights, [(index, 1.0)]);
        }
        assert_eq!(
            law_weights(&[7.0], Micrometers(90.0), 0.3).unwrap().len(),
            1
        );
    }

    #[test]
    fn what_is_linear_in_ln_r_has_its_exact_mean() {
        // <ln x> over the cross-section: digamma(k) - ln k, k = 1/v; -0.0508 at k = 10.
        let radii_um = lattice(0.1, 7.0, 12.0);
        let mean = sum(&radii_um, (100.0, 0.1), |radius| (radius / 100.0).ln());
        assert!((mean + 0.050_832_494).abs() < 1e-6, "{mean}");
    }

    #[test]
    fn waves_of_the_radius_are_averaged_as_fine_steps_do() {
        let coarse = lattice(1.0, 20.0, 9.0);
        let fine = lattice(1.0, 2000.0, 9.0);
        for omega in [0.5, 1.0, 2.0_f64] {
            let wave = |radius: f64| (omega * (radius / 100.0).ln()).cos();
            // Over a step of 1/20.
            let half = omega / 40.0;
            let of_step = |radius: f64| wave(radius) * half.sin() / half;
            let found = sum(&coarse, (100.0, 1.0 / 3.0), of_step);
            let exact = sum(&fine, (100.0, 1.0 / 3.0), wave);
            // Of the h² omega²/8 of a wave that steps and hats take, h = 1/20, a narrower law leaves a quarter at most.
            let lost = exact.abs() * (omega / 20.0).powi(2) / 8.0;
            assert!(
                (found - exact).abs() < 0.3 * lost + 1e-6,
                "{omega}: {found} {exact}"
            );
        }
    }

    #[test]
    fn all_but_the_share_left_out_lies_within_the_support() {
        let share = 5e-5;
        for variance in [0.0, 1e-4, 0.1, 1.0 / 3.0, 0.49] {
            let (low, high) = law_support(Micrometers(100.0), variance, share).unwrap();
            let nodes = gamma_area_quadrature(Micrometers(100.0), variance, 4096).unwrap();
            let outside = |is_out: &dyn Fn(f64) -> bool| {
                let out = nodes.iter().filter(|(radius, _)| is_out(*radius));
                out.map(|(_, weight)| weight).sum::<f64>()
            };
            assert!(outside(&|radius| radius < low) <= 1.2 * share);
            assert!(outside(&|radius| radius > high) <= 1.2 * share);
            assert!(variance == 0.0 || low < 100.0 && high > 100.0);
        }
        // A gamma law of 1/3 reaches to 4.9 effective radii.
        let (_, high) = law_support(Micrometers(1.0), 1.0 / 3.0, share).unwrap();
        assert!((4.5..5.2).contains(&high), "{high}");
    }

    #[test]
    fn impossible_laws_are_refused() {
        assert!(law_weights(&[1.0], Micrometers(0.0), 0.1).is_err());
        assert!(law_weights(&[1.0], Micrometers(1.0), 0.5).is_err());
        assert!(law_support(Micrometers(f64::NAN), 0.1, 1e-4).is_err());
    }
}
