//! Riccati-Bessel functions.
//!
//! psi_n(z) = z j_n(z),  chi_n(z) = -z y_n(z),  r_n = psi_n/psi_{n-1}
//!   r_n = 1/((2n+1)/z - r_{n+1})            downwards, for psi
//!   w_{n+1} = (2n+1)/z w_n - w_{n-1}        upwards, for chi, and for psi while n <= x
//! psi must not be recurred upwards past n = x: there it decays and the error, a bit of chi, grows.
//! [W80] Wiscombe, Applied Optics 19, 1505-1509 (1980).

use std::ops::Add;
use std::ops::Div;
use std::ops::Sub;

use num_complex::Complex64;

/// Numbers in which r_n can be recurred.
pub(crate) trait Argument:
    Copy + Add<Output = Self> + Sub<Output = Self> + Div<Output = Self> + From<f64>
{
    fn modulus(self) -> f64;
}

impl Argument for f64 {
    fn modulus(self) -> f64 {
        self.abs()
    }
}

impl Argument for Complex64 {
    fn modulus(self) -> f64 {
        self.norm()
    }
}

/// r_n for n = 1 to `n_max`; element 0 is not used.
///
/// Starting 15 or 16 terms above |z|, as classical programs do, is wrong by 1e-3 in Q_ext of a drop
/// without absorption: between |z| and the start the recurrence only gains the digits that
/// the decay of psi_n gives it, and that sets in over some |z|^(1/3) terms.
pub(crate) fn psi_ratios<T: Argument>(z: T, n_max: usize) -> Vec<T> {
    let modulus = z.modulus();
    let start = (n_max as f64).max(modulus) + 8.0 * modulus.cbrt() + 16.0;
    let mut ratios = vec![T::from(0.0); n_max + 1];
    let mut ratio = T::from(0.0);
    for n in (1..=start as usize).rev() {
        let mut denominator = T::from((2 * n + 1) as f64) / z - ratio;
        if denominator.modulus() <= 0.0 {
            // A zero of psi_{n-1} to the last bit; the next step forgets what stands here.
            denominator = T::from(f64::EPSILON);
        }
        ratio = T::from(1.0) / denominator;
        if n <= n_max {
            ratios[n] = ratio;
        }
    }
    ratios
}

/// psi_n and chi_n of a real argument for n = 0 to `n_max`.
pub(crate) fn psi_and_chi(x: f64, n_max: usize) -> (Vec<f64>, Vec<f64>) {
    let ratios = psi_ratios(x, n_max);
    let (sin_x, cos_x) = x.sin_cos();
    let mut psi = vec![sin_x];
    let mut chi = vec![cos_x];
    // psi_{-1} = cos x, chi_{-1} = -sin x.
    let (mut psi_before, mut chi_before) = (cos_x, -sin_x);
    for (n, ratio) in ratios.iter().enumerate().skip(1) {
        let factor = (2 * n - 1) as f64 / x;
        let (psi_last, chi_last) = (psi[n - 1], chi[n - 1]);
        psi.push(if n as f64 <= x {
            factor * psi_last - psi_before
        } else {
            ratio * psi_last
        });
        chi.push(factor * chi_last - chi_before);
        (psi_before, chi_before) = (psi_last, chi_last);
    }
    (psi, chi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_orders_are_the_elementary_functions() {
        for x in [0.1_f64, 1.0, 4.0, 30.0] {
            let (psi, chi) = psi_and_chi(x, 3);
            let (s, c) = x.sin_cos();
            assert!((psi[1] - (s / x - c)).abs() <= 1e-15 * (1.0 + c.abs() / x));
            assert!((chi[1] - (c / x + s)).abs() <= 1e-15 * (1.0 + 1.0 / x));
        }
    }

    #[test]
    fn the_wronskian_is_one_far_into_the_decay() {
        for x in [1e-6, 0.3, 7.0, 200.0, 1e4] {
            let n_max = (x + 6.0 * f64::cbrt(x)) as usize + 10;
            let (psi, chi) = psi_and_chi(x, n_max);
            for n in 1..=n_max {
                // psi_{n-1} chi_n - psi_n chi_{n-1} = 1; worst found 4.5e-14 at 1e4.
                let wronskian = psi[n - 1] * chi[n] - psi[n] * chi[n - 1];
                assert!(
                    (wronskian - 1.0).abs() <= 5e-13,
                    "x = {x}, n = {n}: {wronskian}"
                );
            }
        }
    }

    #[test]
    fn small_arguments_follow_the_leading_power() {
        // psi_n -> x^(n+1)/(2n+1)!!, chi_n -> (2n-1)!!/x^n.
        let x = 1e-6;
        let (psi, chi) = psi_and_chi(x, 3);
        assert!((psi[3] / (x.powi(4) / 105.0) - 1.0).abs() <= 1e-11);
        assert!((chi[3] / (15.0 / x.powi(3)) - 1.0).abs() <= 1e-11);
    }

    #[test]
    fn a_zero_of_psi_is_no_nan() {
        // (2n+1)/z - r_{n+1} is exactly 0 for z = 0 only; infinities must not survive a step.
        for z in [
            std::f64::consts::PI,
            2.0 * std::f64::consts::PI,
            1e3 * std::f64::consts::PI,
        ] {
            assert!(psi_ratios(z, 20).iter().all(|r| r.is_finite()));
        }
    }
}
