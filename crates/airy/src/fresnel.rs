//! Fresnel's amplitude coefficients at the surface of a drop, and what a ray keeps of them.
//!
//! ρ_s = (cos i − n cos r)/(cos i + n cos r),   ρ_p = (n cos i − cos r)/(n cos i + cos r)
//! ε_j = (1 − ρ_j²) ρ_j^(p−1)   for a ray that enters, is reflected p − 1 times and leaves; ε_j = ρ_j
//! for p = 0, a ray that is reflected outside
//! `i` angle of incidence outside, `r` inside, `n` refractive index of the drop relative to the air.
//! The sign of ρ is that of a reflection inside, up to a factor −1 common to all rays of an order.
//! Complex cosines are those of complex rays.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, ch. 12.22 (1957).

use crate::ray_path::Incidence;

/// Amplitude reflection coefficients (s, p) for the cosines of the angles outside and inside.
#[must_use]
pub(crate) fn reflection_coefficients<T: Incidence>(
    n: f64,
    cos_incidence: T,
    cos_refraction: T,
) -> [T; 2] {
    let n = T::real(n);
    let perpendicular = (cos_incidence - n * cos_refraction) / (cos_incidence + n * cos_refraction);
    let parallel = (n * cos_incidence - cos_refraction) / (n * cos_incidence + cos_refraction);
    [perpendicular, parallel]
}

/// ε_s and ε_p of order `p` for the cosines of the angles outside and inside.
#[must_use]
pub(crate) fn order_amplitudes<T: Incidence>(
    n: f64,
    p: u32,
    cos_incidence: T,
    cos_refraction: T,
) -> [T; 2] {
    let coefficients = reflection_coefficients(n, cos_incidence, cos_refraction);
    let Some(n_reflections) = p.checked_sub(1) else {
        return coefficients;
    };
    let exponent = i32::try_from(n_reflections).unwrap_or(i32::MAX);
    coefficients.map(|rho| (T::one() - rho * rho) * rho.powi(exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_reflects_as_the_textbook_says() {
        let [s, p] = reflection_coefficients(1.333, 1.0, 1.0);
        let textbook = ((1.333_f64 - 1.0) / (1.333 + 1.0)).powi(2);
        assert!((s * s - textbook).abs() < 1e-15 && (p * p - textbook).abs() < 1e-15);
    }

    #[test]
    fn grazing_light_is_reflected_whole() {
        let cos_refraction = (1.0 - 1.0 / (1.333_f64 * 1.333)).sqrt();
        for rho in reflection_coefficients(1.333, 0.0, cos_refraction) {
            assert!((rho * rho - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_parallel_component_vanishes_at_brewsters_angle() {
        let n = 1.333_f64;
        let incidence = n.atan();
        let refraction = (incidence.sin() / n).asin();
        let [_, p] = reflection_coefficients(n, incidence.cos(), refraction.cos());
        assert!(p.abs() < 1e-15);
    }
}
