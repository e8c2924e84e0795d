//! How far flattened drops move a bow, to first order of their eccentricity.
//!
//! δD_p = m e k_p,   e = (1 − q)/(1 + q),
//! k_2 = 16 sin r0 cos³ r0,   k_3 = −64 sin r0 cos³ r0 cos 2 r0   [rad]
//! `δD_p` change of the deviation of the rainbow ray of order p, `q` axis ratio of the drop (short over
//! long, 1 for a sphere), `r0` refraction of the rainbow ray of that order, `m` from −1 to 1 what the
//! directions make of it: the shift of a scattering table. The scattering angle of the bow
//! is D for the primary and 2π − D for the secondary, so **a positive m raises θ_R of the primary and
//! narrows it, and lowers θ_R of the secondary and widens it** (k_3 is 0.25 against 4.6 for water:
//! the secondary hardly moves).
//!
//! # The meaning of m
//! With unit vectors `s` towards the sun, `d` from the eye into the view, `z` straight up:
//!
//! m = ((s + d)·z)² / |s + d|² − ((s − d)·z)² / |s − d|²,   |s ± d|² = 2 (1 ± s·d),   s·d = cos θ
//!
//! One formula for every order. At the top of a bow with the sun on the horizon m = cos θ_b, θ_b the
//! bow angle (0.74 for the primary); 1 where the sun is half of a bow angle high; 0 at its feet with
//! the sun on the horizon. In the forward direction the first term alone is left and the bow is
//! elsewhere; at the antisolar point the first term depends on the side from which it is approached,
//! up to 1 − (s·z)²; half of that is the mean.
//!
//! # Derivation
//! A drop falls with its short axis upright. To first order its radius is a (1 − 2 e (u·z)²) + const in
//! the direction `u`. In the plane of scattering, with normal N, u·z = sqrt(1 − (N·z)²) cos χ, χ the
//! angle from the projection of z; so the section is an ellipse r = const − a e_N cos 2χ with
//! e_N = e (1 − (N·z)²). (Normals tilted out of the plane move light along the bow: second order.)
//!
//! A ray of order p meets the surface at φ_k = φ_B + (p/2 − k) α, k = 0 to p, α = π − 2r, symmetric to
//! the direction φ_B that bisects the directions s (back along the incoming ray) and −d (along the
//! outgoing ray): 2 φ_B = π − D when the light travels towards φ = 0 and is turned clockwise. A surface
//! that lies δr_k further out makes the path longer by Σ w_k δr_k with w = n cos r − cos i at both ends
//! and 2 n cos r at the reflections. The path of the light that leaves by D has dG/dD = b = sin i
//! (units of a), so F = G − b D has dF/db = −D, and at fixed b
//!   δD = −d/db Σ w_k δr_k = e_N d/db Σ w_k cos 2(φ_k − φ_z).
//! At the rainbow ray dD/db = 0, hence this is the shift of the bow, whichever ray now makes it. The sum
//! over points symmetric to φ_B is cos 2(φ_B − φ_z) Σ w_k cos((p − 2k) α), and φ_B does not change
//! with b. With dr/di = 1/p and n cos r = p cos i,
//!   k_p = −(1/cos i) d/di Σ w_k cos((p − 2k) α),   m = −(1 − (N·z)²) cos 2(φ_B − φ_z).
//! The unit vectors B = (s − d)/|s − d| and T = (s + d)/|s + d| span the plane, which turns m into
//! (T·z)² − (B·z)². The sum gives the closed forms above for p = 2 and 3.
//!
//! The second order is left out here; [`crate::bow_shift`] has it and the errors of both.
//! [M10] W. Möbius, Ann. Phys. 338, 1493-1558 (1910): the primary.

use niji_airy::RainbowRay;
/// dθ_R/d(m e) in radians: k_p, with the sign of the scattering angle on the branch of the bow.
pub(crate) fn scattering_angle_shift(ray: &RainbowRay) -> f64 {
    ray.bright_side() * deviation_shift(ray)
}

/// k_p in radians.
fn deviation_shift(ray: &RainbowRay) -> f64 {
    let order = f64::from(ray.p);
    let angle = std::f64::consts::PI - 2.0 * ray.refraction_rad;
    let tangent = ray.refraction_rad.tan();
    let terms = (0..=ray.p).map(|point| {
        let steps = order - 2.0 * f64::from(point);
        let is_end = point == 0 || point == ray.p;
        // w_k and dw_k/di over cos i, with tan i = p tan r.
        let (weight, slope) = if is_end {
            (order - 1.0, (order - 1.0) * tangent)
        } else {
            (2.0 * order, -2.0 * tangent)
        };
        let (sine, cosine) = (steps * angle).sin_cos();
        slope * cosine + 2.0 * steps / order * weight * sine
    });
    -terms.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_airy::rainbow_ray;

    const N: f64 = 1.333;

    #[test]
    fn the_primary_moves_as_moebius_found() {
        for n in [1.2, N, 1.34] {
            let ray = rainbow_ray(n, 2).unwrap();
            let (sine, cosine) = ray.refraction_rad.sin_cos();
            let expected = 16.0 * sine * cosine.powi(3);
            assert!((deviation_shift(&ray) - expected).abs() < 1e-13);
            assert!(scattering_angle_shift(&ray) > 0.0);
        }
    }

    #[test]
    fn the_secondary_moves_as_the_closed_form_says() {
        for n in [1.2, N, 1.34] {
            let ray = rainbow_ray(n, 3).unwrap();
            let (sine, cosine) = ray.refraction_rad.sin_cos();
            let expected = -64.0 * sine * cosine.powi(3) * (2.0 * ray.refraction_rad).cos();
            assert!((deviation_shift(&ray) - expected).abs() < 1e-13);
        }
        let ray = rainbow_ray(N, 3).unwrap();
        // 64 · 0.7128 · 0.7014³ · 0.0162 by hand.
        assert!(
            (scattering_angle_shift(&ray) + 0.255).abs() < 1e-3,
            "{}",
            scattering_angle_shift(&ray)
        );
    }
}
