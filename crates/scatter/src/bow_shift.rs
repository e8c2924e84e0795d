//! How far flattened drops move a bow, to second order of their eccentricity.
//!
//! Δθ = e k (T² − B²) + e² [ a (T⁴ + B⁴) + c T² B² + f T² N² + g B² N² ],   N² = 1 − T² − B²
//! `Δθ` shift of the scattering angle of the bow in radians, e = (1 − q)/(1 + q) with the axis ratio `q`
//! of [`crate::axis_ratio()`]; `T`, `B`, `N` components of the drop's short axis, for falling drops of the
//! vertical, along (s + d)/|s + d|, (s − d)/|s − d| and the normal of both; `s` towards the sun, `d` from
//! the eye into the view; `k` that of [`crate::moebius_shift`]; `k`, `a`, `c`, `f`, `g` numbers of order
//! and index alone.
//!
//! # What is shifted
//! Drops of one shape and attitude send light of order p into some directions and not into others. With
//! the sun fixed, the edge between them, the caustic, is a curve on the sphere of directions: there the
//! map of the points where light enters (two coordinates) to the directions in which it leaves (two) is
//! folded. For spheres the curve is the circle θ = θ_R. **A direction d lies on the curve of flattened
//! drops where θ(d) = θ_R + Δθ(T(d), B(d))**: the light of spheres at θ − Δθ, with T and B of the
//! direction one looks into, has its bow there. Along a plane through the sun θ has an extreme on it, and
//! the bow's bright side stays on the side it was. Rays leave the plane of s and d on their way, all of
//! that is in the second order.
//!
//! # Why this form
//! Whether d is on the caustic for light from s is the same question for light from d towards s: its
//! paths are those of the other, backwards. Exchanging s and d turns B into −B, the mirror in the plane of
//! s and d turns N into −N, and the axis has no sign; so the shift is even in T, B and N each. κ (x·z)²,
//! κ = 4 e + 8 e² + ..., is all that the surface has of z: polynomials of degree 2 for e and 4 for e².
//! An axis along N leaves a circle for a section, hence no N² and no N⁴. An axis in the plane (N = 0)
//! leaves an ellipse; exchanging its axes is e → −e with T and B exchanged, hence −k, and one `a`.
//!
//! # The coefficients
//! In the plane φ = const of the sphere's ray, θ(b, c, e) and φ(b, c, e) by the point of entry (b in the
//! plane, c across) and e, at θ_b = θ_c = 0 and with the derivatives that [`crate::spheroid_ray`] traces,
//!   c' = −φ_e/φ_c,   Θ_ee = θ_ee + 2 θ_ce c' + θ_cc c'²,   Θ = θ_R + e θ_e + e²/2 (Θ_ee − θ_be²/θ_bb)
//! is the extreme along the plane, exactly to this order: no differences, no fit. Here the axis is held
//! against the direction of the *sphere's* bow; in the coordinates above, the second order differs by
//! 2 T B k² (T² − B²), since T and B turn by half of what d does. Four axes for which that is 0 give the
//! four coefficients.
//!
//! # How good
//! Worst error in degrees against rays traced in three dimensions, n = 1.333, sun from 0 to 40 degrees,
//! all around the bow; in brackets without the second order:
//!   diameter   primary           secondary         p = 4        p = 5        p = 6        p = 7
//!   0.5 mm     0.00001 (0.001)   0.00001 (0.002)   0.00004      0.00003      0.0001       0.0002
//!   0.7 mm     0.0002 (0.009)    0.0001 (0.013)    0.0009       0.0007       0.0021       0.0040
//!   1.0 mm     0.0031 (0.067)    0.0025 (0.097)    0.019        0.013        0.043        0.073
//!   1.5 mm     0.047 (0.43)      0.038 (0.58)
//!   2.0 mm     0.27 (1.4)        0.21
//! What is left grows with e³. The higher an order, the nearer its ray passes the rim, and the smaller the
//! drops for which the series still serves.

use niji_airy::RainbowRay;
use niji_airy::rainbow_ray;
use niji_exchange::BowShift;

use crate::moebius_shift::scattering_angle_shift;
use crate::spheroid_ray::ACROSS;
use crate::spheroid_ray::ECCENTRICITY;
use crate::spheroid_ray::Entry;
use crate::spheroid_ray::IN_PLANE;
use crate::spheroid_ray::exit_direction;

/// The shift of the bow of order `p` for drops of a refractive index; `None` where there is no bow.
///
/// ```
/// use niji_radiometry::Micrometers;
/// use niji_scatter::{bow_shift, eccentricity};
///
/// let shift = bow_shift(1.333, 2).expect("water has a primary bow");
/// // Straight above the sun's shadow, the sun half of a bow angle high: the axis lies along s + d.
/// let drop = eccentricity(Micrometers(500.0));
/// let deg = shift.shift_rad(drop, 1.0, 0.0).to_degrees();
/// assert!((2.2..2.4).contains(&deg), "{deg}");
/// ```
pub fn bow_shift(index: f64, p: u32) -> Option<BowShift> {
    let ray = rainbow_ray(index, p)?;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let second = |axis| fixed_plane_rad(&ray, axis)[1];
    let a = second([1.0, 0.0, 0.0]);
    // With squares of one half the form is (2 a + c)/4, (a + f)/4 and (a + g)/4.
    let c = 4.0 * second([half, half, 0.0]) - 2.0 * a;
    let f = 4.0 * second([half, 0.0, half]) - a;
    let g = 4.0 * second([0.0, half, half]) - a;
    Some(BowShift {
        coefficients_rad: [scattering_angle_shift(&ray), a, c, f, g],
    })
}

/// Factors of e and e² in the extreme of θ along the plane of the sphere's ray, for an axis with
/// components along T, B and N of the sphere's bow.
fn fixed_plane_rad(ray: &RainbowRay, axis: [f64; 3]) -> [f64; 2] {
    let [t, b, n] = axis;
    // The light turns towards +y or −y; T bisects the directions it goes in, B is across.
    let side = -ray.deviation_rad.sin().signum();
    let (sine, cosine) = (0.5 * ray.theta_rad()).sin_cos();
    let upright = [t * cosine - b * sine, side * (t * sine + b * cosine), n];
    let entry = Entry {
        index: ray.n,
        order: ray.p,
        offset: ray.incidence_rad.sin(),
    };
    let [forward, lateral, across] = exit_direction(entry, upright);
    let theta = forward.acos();
    let azimuth = across * lateral.recip();
    let c_slope = -azimuth.first[ECCENTRICITY] / azimuth.first[ACROSS];
    let bend = theta.second(ECCENTRICITY, ECCENTRICITY)
        + 2.0 * theta.second(ACROSS, ECCENTRICITY) * c_slope
        + theta.second(ACROSS, ACROSS) * c_slope * c_slope;
    let mixed = theta.second(IN_PLANE, ECCENTRICITY);
    let second = 0.5 * (bend - mixed * mixed / theta.second(IN_PLANE, IN_PLANE));
    [theta.first[ECCENTRICITY], second]
}

#[cfg(test)]
#[path = "bow_shift_tests.rs"]
mod tests;
