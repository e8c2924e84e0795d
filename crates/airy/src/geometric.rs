//! Geometric optics of one order: rays, their intensities added.
//!
//! t_j = (1/π) Σ_rays sin i cos i ε_j² / (sin θ |dD/di|)   [1/sr],  t = (dσ/dΩ)/(π a²)
//! D(i) = 2 i − 2 p r + (p − 1) π,   dD/di = 2 − 2 p cos i/(n cos r)
//! `i` incidence of a ray whose deviation D folds to the scattering angle θ. On the axis sin i / sin θ
//! becomes 1/|dD/di|. At the caustic t grows like (D − D_R)^(−1/2); nearer than 0.02 degrees it is
//! replaced by its mean over that width, 2 t(0.02 degrees), which keeps the energy. Holds for p >= 2
//! and drops much larger than the wavelength.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, ch. 12.21 (1957).

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_radiometry::Radians;

use crate::fresnel::order_amplitudes;
use crate::rainbow_ray::RainbowRay;
use crate::rainbow_ray::rainbow_ray;

/// Half-width of the caustic that is replaced by its mean.
const CAUSTIC_RAD: f64 = 0.02 * PI / 180.0;
/// sin θ below which a ray counts as axial.
const AXIAL_SIN: f64 = 1e-9;

/// The rays of one order through a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometricOrder {
    ray: RainbowRay,
}

impl GeometricOrder {
    /// The rays of order `p`, or `None` where that order has no bow.
    #[must_use]
    pub fn new(n: f64, p: u32) -> Option<Self> {
        rainbow_ray(n, p).map(|ray| Self { ray })
    }

    /// (dσ/dΩ)/(π a²) in 1/sr for the polarisations s and p.
    #[must_use]
    pub fn normalized_cross_section(&self, theta: Radians) -> [f64; 2] {
        let theta_rad = theta.0.clamp(0.0, PI);
        let central = self.deviation(0.0);
        let mut sum = [0.0; 2];
        // Every deviation that folds to θ, up to that of the central ray, the largest.
        let n_turns = (central / TAU).ceil() as u32;
        for turn in 0..=n_turns {
            let whole = TAU * f64::from(turn);
            let on_axis = theta_rad.sin() < AXIAL_SIN;
            let sides: &[f64] = if on_axis { &[1.0] } else { &[1.0, -1.0] };
            for side in sides {
                self.add(whole + side * theta_rad, theta_rad, &mut sum);
            }
        }
        sum
    }

    fn add(&self, deviation_rad: f64, theta_rad: f64, sum: &mut [f64; 2]) {
        let beyond_rad = deviation_rad - self.ray.deviation_rad;
        if beyond_rad < 0.0 {
            return;
        }
        // On the clipped caustic the mean of a (D − D_R)^(−1/2) law is twice its value at the end.
        let (deviation_rad, weight) = if beyond_rad < CAUSTIC_RAD {
            (self.ray.deviation_rad + CAUSTIC_RAD, 2.0)
        } else {
            (deviation_rad, 1.0)
        };
        for (inner, outer) in [
            (self.ray.incidence_rad, 0.0),
            (self.ray.incidence_rad, FRAC_PI_2),
        ] {
            let Some(incidence_rad) = self.incidence(deviation_rad, inner, outer) else {
                continue;
            };
            let intensity = self.intensity(incidence_rad, theta_rad);
            sum[0] += weight * intensity[0];
            sum[1] += weight * intensity[1];
        }
    }

    fn deviation(&self, incidence_rad: f64) -> f64 {
        let order = f64::from(self.ray.p);
        let refraction_rad = (incidence_rad.sin() / self.ray.n).asin();
        2.0 * incidence_rad - 2.0 * order * refraction_rad + (order - 1.0) * PI
    }

    /// The incidence between `near` (at the rainbow ray) and `far` with the deviation asked for.
    /// Between them the deviation rises monotonically, so bisection cannot fail; 60 halvings reach
    /// the last digit.
    fn incidence(&self, deviation_rad: f64, near: f64, far: f64) -> Option<f64> {
        if deviation_rad > self.deviation(far) {
            // Rounding may put the central ray itself a digit beyond the axis.
            let is_central = far < near && deviation_rad < self.deviation(far) + 1e-12;
            return is_central.then_some(far);
        }
        let (mut below, mut above) = (near, far);
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            if self.deviation(middle) < deviation_rad {
                below = middle;
            } else {
                above = middle;
            }
        }
        Some(0.5 * (below + above))
    }

    fn intensity(&self, incidence_rad: f64, theta_rad: f64) -> [f64; 2] {
        let (n, order) = (self.ray.n, f64::from(self.ray.p));
        let (sin_incidence, cos_incidence) = incidence_rad.sin_cos();
        let cos_refraction = (1.0 - (sin_incidence / n).powi(2)).sqrt();
        let slope = (2.0 - 2.0 * order * cos_incidence / (n * cos_refraction)).abs();
        let sin_theta = theta_rad.sin();
        let spread = if sin_theta < AXIAL_SIN {
            1.0 / slope
        } else {
            sin_incidence / sin_theta
        };
        order_amplitudes(n, self.ray.p, cos_incidence, cos_refraction)
            .map(|amplitude| spread * cos_incidence * amplitude * amplitude / (PI * slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_of_an_order_is_what_fresnel_lets_through() {
        // ∫ t dΩ = ∫ 2 sin i cos i ε² di, both by the midpoint rule.
        for p in [2, 3] {
            let order = GeometricOrder::new(1.333, p).unwrap();
            let n_steps = 40_000;
            let (mut over_sphere, mut over_incidence) = ([0.0; 2], [0.0; 2]);
            for step in 0..n_steps {
                let part = (f64::from(step) + 0.5) / f64::from(n_steps);
                let theta = PI * part;
                let t = order.normalized_cross_section(Radians(theta));
                let incidence = FRAC_PI_2 * part;
                let cos_refraction = (1.0 - (incidence.sin() / 1.333).powi(2)).sqrt();
                let amplitudes = order_amplitudes(1.333, p, incidence.cos(), cos_refraction);
                for j in 0..2 {
                    over_sphere[j] += TAU * theta.sin() * t[j] * PI / f64::from(n_steps);
                    over_incidence[j] +=
                        (2.0 * incidence).sin() * amplitudes[j].powi(2) * FRAC_PI_2
                            / f64::from(n_steps);
                }
            }
            for j in 0..2 {
                assert!(
                    (over_sphere[j] / over_incidence[j] - 1.0).abs() < 5e-3,
                    "p = {p}: {over_sphere:?} against {over_incidence:?}"
                );
            }
        }
    }

    #[test]
    fn alexanders_band_is_dark_and_the_poles_are_finite() {
        let primary = GeometricOrder::new(1.333, 2).unwrap();
        let secondary = GeometricOrder::new(1.333, 3).unwrap();
        for theta_deg in [129.5, 133.0, 137.5] {
            let theta = Radians::from_degrees(theta_deg);
            assert_eq!(primary.normalized_cross_section(theta), [0.0; 2]);
            assert_eq!(secondary.normalized_cross_section(theta), [0.0; 2]);
        }
        for (order, pole_deg) in [(primary, 180.0), (secondary, 0.0)] {
            let at = order.normalized_cross_section(Radians::from_degrees(pole_deg))[0];
            let near_deg = (pole_deg - 1e-4_f64).abs();
            let near = order.normalized_cross_section(Radians::from_degrees(near_deg))[0];
            assert!(
                at > 0.0 && (at / near - 1.0).abs() < 1e-6,
                "{at} at the pole, {near} beside"
            );
        }
    }

    #[test]
    fn past_the_grazing_ray_a_single_ray_is_left() {
        // p = 2, n = 1.333: the grazing ray leaves at D = 165.63 degrees, with no light of its own.
        let order = GeometricOrder::new(1.333, 2).unwrap();
        let at = |deg| order.normalized_cross_section(Radians::from_degrees(deg))[0];
        assert!(
            (at(165.5) / at(165.8) - 1.0).abs() < 0.02,
            "continuous across the grazing ray"
        );
    }
}
