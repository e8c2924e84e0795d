//! Riccati-Bessel functions.
//!
//! psi_n(z) = z j_n(z),  chi_n(z) = -z y_n(z),  r_n = psi_n/psi_{n-1}
//!   r_n = 1/((2n+1)/z - r_{n+1})            downwards, for psi
//!   w_{n+1} = (2n+1)/z w_n - w_{n-1}        upwards, for chi, and for psi while n <= x
//! psi must not be recurred upwards past n = x: there it decays and the error, a bit of chi, grows.
//! [W80] Wiscombe, Applied Optics 19, 1505-1509 (1980).

use std::ops::Div;
use std::ops::Sub;

use num_complex::Complex64;

/// Numbers in which r_n can be recurred.
pub(crate) trait Argument:
    Copy + Sub<Output = Self> + Div<Output = Self> + From<f64>
{
    fn modulus(self) -> f64;
    fn is_zero(self) -> bool;
}

impl Argument for f64 {
    fn modulus(self) -> f64 {
        self.abs()
    }

    fn is_zero(self) -> bool {
        self.abs() <= 0.0
    }
}

impl Argument for Complex64 {
    fn modulus(self) -> f64 {
        self.norm()
    }

    fn is_zero(self) -> bool {
        self.l1_norm() <= 0.0
    }
}

/// r_n for n = `n_min` to `n_max`, from element 0.
///
/// Starting 15 or 16 terms above |z|, as classical programs do, is wrong by 1e-3 in Q_ext of a drop
/// without absorption: between |z| and the start the recurrence only gains the digits that
/// the decay of psi_n gives it, and that sets in over some |z|^(1/3) terms.
pub(crate) fn psi_ratios<T: Argument>(z: T, n_min: usize, n_max: usize) -> Vec<T> {
    let modulus = z.modulus();
    let start = (n_max as f64).max(modulus) + 8.0 * modulus.cbrt() + 16.0;
    let mut ratios = vec![T::from(0.0); (n_max + 1).saturating_sub(n_min)];
    let mut ratio = T::from(0.0);
    for n in (n_min..=start as usize).rev() {
        let mut denominator = T::from((2 * n + 1) as f64) / z - ratio;
        if denominator.is_zero() {
            // A zero of psi_{n-1} to the last bit; the next step forgets what stands here.
            denominator = T::from(f64::EPSILON);
        }
        ratio = T::from(1.0) / denominator;
        if n <= n_max {
            ratios[n - n_min] = ratio;
        }
    }
    ratios
}

/// psi_n of a real argument from n = 0 to `n_max`.
pub(crate) fn psi(x: f64, n_max: usize) -> impl Iterator<Item = f64> {
    let (sin_x, cos_x) = x.sin_cos();
    // Upwards to the last n <= x, from there by the ratios.
    let n_upwards = n_max.min(x as usize);
    let ratios = psi_ratios(x, n_upwards + 1, n_max);
    let mut upwards = upwards(x, [cos_x, sin_x]);
    let mut last = 1.0;
    (0..=n_max).map(move |n| {
        last = match n.checked_sub(n_upwards + 1) {
            Some(beyond) => last * ratios[beyond],
            None => upwards(n),
        };
        last
    })
}

/// chi_n of a real argument from n = 0 to `n_max`.
pub(crate) fn chi(x: f64, n_max: usize) -> impl Iterator<Item = f64> {
    let (sin_x, cos_x) = x.sin_cos();
    (0..=n_max).map(upwards(x, [-sin_x, cos_x]))
}

/// [w_n, w_{n+1}] from n = 0.
pub(crate) fn neighbors(mut w: impl Iterator<Item = f64>) -> impl Iterator<Item = [f64; 2]> {
    let mut last = w.next().unwrap_or_default();
    w.map(move |next| [std::mem::replace(&mut last, next), next])
}

/// w_n for one n after the other from 0, by recurrence from w_{-1} and w_0.
fn upwards(x: f64, [mut before, mut last]: [f64; 2]) -> impl FnMut(usize) -> f64 {
    move |n| {
        if n > 0 {
            (before, last) = (last, (2 * n - 1) as f64 / x * last - before);
        }
        last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vectors(x: f64, n_max: usize) -> (Vec<f64>, Vec<f64>) {
        (psi(x, n_max).collect(), chi(x, n_max).collect())
    }

    #[test]
    fn low_orders_are_the_elementary_functions() {
        for x in [0.1_f64, 1.0, 4.0, 30.0] {
            let (psi, chi) = vectors(x, 3);
            let (s, c) = x.sin_cos();
            assert!((psi[1] - (s / x - c)).abs() <= 1e-15 * (1.0 + c.abs() / x));
            assert!((chi[1] - (c / x + s)).abs() <= 1e-15 * (1.0 + 1.0 / x));
        }
    }

    #[test]
    fn the_wronskian_is_one_far_into_the_decay() {
        for x in [1e-6, 0.3, 7.0, 200.0, 1e4] {
            let n_max = (x + 6.0 * f64::cbrt(x)) as usize + 10;
            let (psi, chi) = vectors(x, n_max);
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
        let (psi, chi) = vectors(x, 3);
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
            assert!(psi_ratios(z, 1, 20).iter().all(|r| r.is_finite()));
        }
    }
}
