//! Geometric optics of one order: rays, their intensities added.
//!
//! t_j = (1/π) Σ_rays sin i cos i ε_j² / (sin θ |dD/di|)   [1/sr],  t = (dσ/dΩ)/(π a²)
//! D(i) = 2 i − 2 p r + (p − 1) π,   dD/di = 2 − 2 p cos i/(n cos r)
//! `i` incidence of a ray whose deviation D folds to the scattering angle θ. On the axis sin i / sin θ
//! becomes 1/|dD/di|. At the caustic t grows like (D − D_R)^(−1/2); nearer than 0.02 degrees it is
//! replaced by its mean over that width, 2 t(0.02 degrees), which keeps the energy; means over rings need
//! no clipping. Holds for p >= 2 and drops much larger than the wavelength.
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
/// Newton's steps at most; 4 to 6 are usual.
const MOST_STEPS: u32 = 60;
/// A step below this ends the search: the next one would be below rounding.
const CONVERGED_RAD: f64 = 1e-12;

/// Nodes and weights of Gauss and Legendre on −1..1: a ring of the tables spans less than 2 degrees
/// of incidence, over which six nodes reach rounding.
const GAUSS_NODES: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_3),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_3),
];

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

    /// (dσ/dΩ)/(π a²) in 1/sr averaged over the solid angle of the ring between two scattering
    /// angles, for the polarisations s and p: the light of all rays that end in it, so that the
    /// caustic and the poles are exact without clipping.
    ///
    /// t̄ = ∫ 2 sin i cos i ε² di / (2π (cos θ1 − cos θ2))
    #[must_use]
    pub fn mean_over_ring(&self, from: Radians, to: Radians) -> [f64; 2] {
        let (from_rad, to_rad) = (from.0.clamp(0.0, PI), to.0.clamp(0.0, PI));
        // cos θ1 − cos θ2 without cancellation.
        let height = 2.0 * (0.5 * (from_rad + to_rad)).sin() * (0.5 * (to_rad - from_rad)).sin();
        if height <= 0.0 {
            return self.normalized_cross_section(from);
        }
        let mut light = [0.0; 2];
        let n_turns = (self.deviation(0.0) / TAU).ceil() as u32;
        for turn in 0..=n_turns {
            let whole = TAU * f64::from(turn);
            for (low, high) in [
                (whole + from_rad, whole + to_rad),
                (whole - to_rad, whole - from_rad),
            ] {
                for end in [0.0, FRAC_PI_2] {
                    self.add_light(low, high, end, &mut light);
                }
            }
        }
        light.map(|light| light / (PI * height))
    }

    /// Adds ∫ sin i cos i ε² di over the rays between the rainbow ray and incidence `end` whose
    /// deviation lies between `low` and `high`.
    fn add_light(&self, low: f64, high: f64, end: f64, light: &mut [f64; 2]) {
        let bow = (self.ray.deviation_rad, self.ray.incidence_rad);
        let limit = self.deviation(end);
        if high <= bow.0 || low >= limit {
            return;
        }
        let at = |deviation: f64| {
            if deviation <= bow.0 {
                bow.1
            } else {
                self.incidence(deviation, bow.1, end).unwrap_or(end)
            }
        };
        let (one, other) = (at(low.min(limit)), at(high.min(limit)));
        let (middle, half) = (0.5 * (one + other), 0.5 * (other - one).abs());
        for (node, weight) in GAUSS_NODES {
            let (sin_incidence, cos_incidence) = (middle + half * node).sin_cos();
            let cos_refraction = (1.0 - (sin_incidence / self.ray.n).powi(2)).sqrt();
            let amplitudes =
                order_amplitudes(self.ray.n, self.ray.p, cos_incidence, cos_refraction);
            for (light, amplitude) in light.iter_mut().zip(amplitudes) {
                *light += half * weight * sin_incidence * cos_incidence * amplitude * amplitude;
            }
        }
    }

    fn deviation(&self, incidence_rad: f64) -> f64 {
        let order = f64::from(self.ray.p);
        let refraction_rad = (incidence_rad.sin() / self.ray.n).asin();
        2.0 * incidence_rad - 2.0 * order * refraction_rad + (order - 1.0) * PI
    }

    /// dD/di.
    fn slope(&self, incidence_rad: f64) -> f64 {
        let (sin_incidence, cos_incidence) = incidence_rad.sin_cos();
        let n_cos_refraction = (self.ray.n * self.ray.n - sin_incidence * sin_incidence).sqrt();
        2.0 - 2.0 * f64::from(self.ray.p) * cos_incidence / n_cos_refraction
    }

    /// The incidence between `near` (at the rainbow ray) and `far` with the deviation asked for.
    /// Between them the deviation rises monotonically, so Newton's step inside a bracket, and a
    /// halving where the step would leave it, cannot fail.
    fn incidence(&self, deviation_rad: f64, near: f64, far: f64) -> Option<f64> {
        if deviation_rad > self.deviation(far) {
            // Rounding may put the central ray itself a digit beyond the axis.
            let is_central = far < near && deviation_rad < self.deviation(far) + 1e-12;
            return is_central.then_some(far);
        }
        let (mut below, mut above) = (near, far);
        // D − D_R = D'' (i − i0)²/2 with D'' = 2 ((p² − 1)/p²) tan i0.
        let p2 = f64::from(self.ray.p).powi(2);
        let curvature = 2.0 * (p2 - 1.0) / p2 * near.tan();
        let beyond = (deviation_rad - self.ray.deviation_rad).max(0.0);
        let mut incidence = near + (far - near).signum() * (2.0 * beyond / curvature).sqrt();
        for _ in 0..MOST_STEPS {
            if !(incidence > below.min(above) && incidence < below.max(above)) {
                incidence = 0.5 * (below + above);
            }
            let excess = self.deviation(incidence) - deviation_rad;
            if excess < 0.0 {
                below = incidence;
            } else {
                above = incidence;
            }
            let step = excess / self.slope(incidence);
            incidence -= step;
            if step.abs() < CONVERGED_RAD {
                break;
            }
        }
        Some(incidence.clamp(near.min(far), near.max(far)))
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

    /// Energy on the sphere over energy that enters; measured worst 1.3e-12.
    const ENERGY_TOLERANCE: f64 = 1e-11;

    #[test]
    fn rings_share_out_all_the_light_of_an_order() {
        for p in [2, 3, 4, 6] {
            let order = GeometricOrder::new(1.333, p).unwrap();
            let n_rings = 3000;
            let mut over_sphere = [0.0; 2];
            for ring in 0..n_rings {
                let edge = |ring: i32| PI * f64::from(ring) / f64::from(n_rings);
                let mean = order.mean_over_ring(Radians(edge(ring)), Radians(edge(ring + 1)));
                let solid_angle = TAU * (edge(ring).cos() - edge(ring + 1).cos());
                for (sum, mean) in over_sphere.iter_mut().zip(mean) {
                    *sum += mean * solid_angle;
                }
            }
            // 2 ∫ sin i cos i ε² di in one piece of 400 000 midpoints.
            let n_steps = 400_000;
            let mut entering = [0.0; 2];
            for step in 0..n_steps {
                let i = FRAC_PI_2 * (f64::from(step) + 0.5) / f64::from(n_steps);
                let cos_refraction = (1.0 - (i.sin() / 1.333).powi(2)).sqrt();
                let amplitudes = order_amplitudes(1.333, p, i.cos(), cos_refraction);
                for (sum, amplitude) in entering.iter_mut().zip(amplitudes) {
                    *sum +=
                        (2.0 * i).sin() * amplitude * amplitude * FRAC_PI_2 / f64::from(n_steps);
                }
            }
            for j in 0..2 {
                let off = (over_sphere[j] / entering[j] - 1.0).abs();
                assert!(off < ENERGY_TOLERANCE, "p = {p}: off by {off:e}");
            }
        }
    }

    #[test]
    fn a_narrow_ring_has_the_intensity_of_its_middle() {
        for (p, theta_deg) in [(2, 150.0), (2, 175.0), (3, 100.0), (3, 120.0)] {
            let order = GeometricOrder::new(1.333, p).unwrap();
            let at = |deg: f64| Radians::from_degrees(deg);
            let mean = order.mean_over_ring(at(theta_deg - 0.01), at(theta_deg + 0.01));
            let middle = order.normalized_cross_section(at(theta_deg));
            for j in 0..2 {
                assert!((mean[j] / middle[j] - 1.0).abs() < 1e-5);
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
