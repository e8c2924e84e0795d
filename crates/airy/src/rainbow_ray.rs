//! Descartes' ray: the ray of order p that is deviated least.
//!
//! cos i0 = sqrt((n² − 1)/(p² − 1)),   n cos r0 = p cos i0,
//! D_R = 2 i0 − 2 p r0 + (p − 1) π,   h = ((p² − 1)²/p²) sqrt(p² − n²)/(n² − 1)^(3/2)
//! ε_s = (1 − ρ_s²) ρ_s^(p−1) with ρ_s = −(p − 1)/(p + 1), ρ_p = (n² − p)/(n² + p)
//! `i0`, `r0` angles of incidence and refraction, `D_R` the (smallest) deviation, `h` the curvature of
//! the wavefront that leaves the drop, Y = h X³/(3 a²).
//! A bow of order p exists for 1 < n < p, p >= 2.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, ch. 13.23 (1957).

use std::f64::consts::PI;
use std::f64::consts::TAU;

use crate::fresnel::order_amplitudes;

/// The rainbow ray of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainbowRay {
    /// Refractive index of the drop relative to the air.
    pub n: f64,
    /// Order: 2 primary, 3 secondary.
    pub p: u32,
    /// Angle of incidence in radians.
    pub incidence_rad: f64,
    /// Angle of refraction in radians.
    pub refraction_rad: f64,
    /// Least deviation in radians, not folded.
    pub deviation_rad: f64,
    /// Curvature of the exit wavefront, dimensionless.
    pub wavefront_h: f64,
    /// Fresnel amplitudes (s, p).
    pub amplitudes: [f64; 2],
}

/// The rainbow ray of order `p`, or `None` where there is no bow.
#[must_use]
pub fn rainbow_ray(n: f64, p: u32) -> Option<RainbowRay> {
    let order = f64::from(p);
    if p < 2 || !(n > 1.0 && n < order) {
        return None;
    }
    let (n2, p2) = (n * n, order * order);
    let cos_incidence = ((n2 - 1.0) / (p2 - 1.0)).sqrt();
    let sin_incidence = ((p2 - n2) / (p2 - 1.0)).sqrt();
    let cos_refraction = order * cos_incidence / n;
    let incidence_rad = sin_incidence.atan2(cos_incidence);
    let refraction_rad = (sin_incidence / n).atan2(cos_refraction);
    Some(RainbowRay {
        n,
        p,
        incidence_rad,
        refraction_rad,
        deviation_rad: 2.0 * incidence_rad - 2.0 * order * refraction_rad + (order - 1.0) * PI,
        wavefront_h: (p2 - 1.0).powi(2) / p2 * (p2 - n2).sqrt() / (n2 - 1.0).powf(1.5),
        amplitudes: order_amplitudes(n, p, cos_incidence, cos_refraction),
    })
}

impl RainbowRay {
    /// Scattering angle of the rainbow ray, 0 to π.
    #[must_use]
    pub fn theta_rad(&self) -> f64 {
        let folded = self.deviation_rad.rem_euclid(TAU);
        folded.min(TAU - folded)
    }

    /// +1 if the bright side lies at larger scattering angles (p = 2), −1 if at smaller (p = 3).
    #[must_use]
    pub fn bright_side(&self) -> f64 {
        if (self.deviation_rad / PI).floor().rem_euclid(2.0) < 0.5 {
            1.0
        } else {
            -1.0
        }
    }

    /// c of D − D_R = c (i − i0)² near the rainbow ray: ((p² − 1)/p²) tan i0.
    pub(crate) fn half_curvature(&self) -> f64 {
        let p2 = f64::from(self.p).powi(2);
        (p2 - 1.0) / p2 * self.incidence_rad.tan()
    }

    /// D''' at the rainbow ray: −2 [g² + g tan r/p + 1/(p cos r)² − 1/cos² i], g = tan r/p − tan i.
    pub(crate) fn third_derivative(&self) -> f64 {
        let order = f64::from(self.p);
        let (cos_incidence, cos_refraction) = (self.incidence_rad.cos(), self.refraction_rad.cos());
        let inner = self.refraction_rad.tan() / order;
        let g = inner - self.incidence_rad.tan();
        let secants = (order * cos_refraction).powi(-2) - cos_incidence.powi(-2);
        -2.0 * (g * g + g * inner + secants)
    }

    /// Deviation beyond the rainbow ray, D − D_R, of light at the scattering angle `theta_rad` on the
    /// branch of the bow; negative on the dark side.
    #[must_use]
    pub fn beyond_rad(&self, theta_rad: f64) -> f64 {
        self.bright_side() * (theta_rad - self.theta_rad())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n, p, i0 [deg], D [deg], theta_R [deg], h, eps_s^2, eps_p^2 by the closed forms of vdH57 with
    /// 7 digits.
    #[allow(
        clippy::type_complexity,
        reason = "a row is a line of the published table"
    )]
    const TABLE: [(f64, u32, f64, f64, f64, f64, f64, f64); 8] = [
        (
            1.333, 2, 59.4105, 137.9219, 137.9219, 4.89919, 8.779e-2, 3.465e-3,
        ),
        (
            1.333, 3, 71.8427, 230.8908, 129.1092, 27.9101, 3.516e-2, 3.753e-3,
        ),
        (
            1.333, 4, 76.8454, 318.2627, 41.7373, 77.4500, 1.911e-2, 2.357e-3,
        ),
        (
            1.333, 5, 79.6350, 403.7029, 43.7029, 162.145, 1.204e-2, 1.568e-3,
        ),
        (
            1.333, 6, 81.4318, 488.2287, 128.2287, 290.707, 8.29e-3, 1.11e-3,
        ),
        (
            1.3312, 2, 59.5151, 137.6594, 137.6594, 4.95024, 8.779e-2, 3.624e-3,
        ),
        (
            1.3394, 2, 59.0390, 138.8435, 138.8435, 4.72347, 8.779e-2, 2.931e-3,
        ),
        (
            1.3394, 3, 71.6369, 232.5543, 127.4457, 26.9811, 3.516e-2, 3.514e-3,
        ),
    ];

    #[test]
    fn the_geometry_is_the_published_one() {
        for (n, p, incidence_deg, deviation_deg, theta_deg, h, s2, p2) in TABLE {
            let ray = rainbow_ray(n, p).unwrap();
            assert!((ray.incidence_rad.to_degrees() - incidence_deg).abs() < 6e-5);
            assert!((ray.deviation_rad.to_degrees() - deviation_deg).abs() < 6e-5);
            assert!((ray.theta_rad().to_degrees() - theta_deg).abs() < 6e-5);
            assert!((ray.wavefront_h / h - 1.0).abs() < 4e-6);
            assert!((ray.amplitudes[0].powi(2) / s2 - 1.0).abs() < 6e-4);
            assert!((ray.amplitudes[1].powi(2) / p2 - 1.0).abs() < 5e-3);
        }
    }

    #[test]
    fn the_perpendicular_amplitude_does_not_depend_on_the_index() {
        for n in [1.2, 1.333, 1.6] {
            let primary = rainbow_ray(n, 2).unwrap().amplitudes[0].abs();
            let secondary = rainbow_ray(n, 3).unwrap().amplitudes[0].abs();
            assert!((primary - 8.0 / 27.0).abs() < 1e-14);
            assert!((secondary - 3.0 / 16.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_deviation_is_least_at_the_rainbow_ray() {
        let ray = rainbow_ray(1.333, 3).unwrap();
        let deviation = |i: f64| 2.0 * i - 6.0 * (i.sin() / 1.333).asin() + 2.0 * PI;
        for step in [-1e-3, 1e-3] {
            assert!(deviation(ray.incidence_rad + step) > ray.deviation_rad);
        }
        assert!((deviation(ray.incidence_rad) - ray.deviation_rad).abs() < 1e-14);
    }

    #[test]
    fn bright_sides_point_where_observers_see_them() {
        let side = |p| rainbow_ray(1.333, p).unwrap().bright_side();
        assert_eq!([side(2), side(3), side(4), side(5)], [1.0, -1.0, -1.0, 1.0]);
    }

    #[test]
    fn there_is_no_bow_outside_its_range() {
        for (n, p) in [
            (1.0, 2),
            (2.0, 2),
            (2.5, 2),
            (0.9, 3),
            (f64::NAN, 2),
            (1.333, 1),
            (1.333, 0),
        ] {
            assert_eq!(rainbow_ray(n, p), None);
        }
    }
}
