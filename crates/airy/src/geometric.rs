//! Geometric optics of one order: rays, their intensities added.
//!
//! t_j = (1/π) Σ_rays sin i cos i ε_j² / (sin θ |dD/di|)   [1/sr],  t = (dσ/dΩ)/(π a²)
//! `i` incidence of a ray whose deviation D folds to the scattering angle θ. p = 0 is the light
//! reflected outside (without diffraction), p = 1 goes through, p >= 2 makes a bow where 1 < n < p.
//! On the axis sin i / sin θ becomes 1/|dD/di|, the limit of the central ray; a ray that crosses the
//! axis elsewhere focuses there without bound, and is given its value beside it. At the caustic t grows
//! like (D − D_R)^(−1/2); nearer than 0.02 degrees it is replaced by its mean over that width,
//! 2 t(0.02 degrees), which keeps the energy; means over rings need no clipping. Holds for n > 1 and
//! drops much larger than the wavelength.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, ch. 12.21 (1957).

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_radiometry::Radians;

use crate::rainbow_ray::RainbowRay;
use crate::rainbow_ray::rainbow_ray;
use crate::ray_path::RayPath;

/// Half-width of the caustic that is replaced by its mean.
const CAUSTIC_RAD: f64 = 0.02 * PI / 180.0;
/// sin θ below which a ray counts as axial.
const AXIAL_SIN: f64 = 1e-9;
/// Difference of deviations that are the same.
const SAME_RAD: f64 = 1e-9;
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

/// The same of three nodes, which reach rounding over a fifth of a degree.
const FEW_NODES: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 0.555_555_555_555_555_6),
    (0.0, 0.888_888_888_888_888_9),
    (0.774_596_669_241_483_4, 0.555_555_555_555_555_6),
];
/// Half of that, rad.
const FEW_UP_TO_RAD: f64 = 2e-3;

/// The rays of one order through a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometricOrder {
    path: RayPath,
    bow: Option<RainbowRay>,
    /// Least deviation, and those of the central and of the grazing ray.
    least_rad: f64,
    central_rad: f64,
    grazing_rad: f64,
}

/// Where a branch of rays ends that begins at the least deviated one.
#[derive(Clone, Copy, Debug)]
struct End {
    incidence_rad: f64,
    deviation_rad: f64,
}

impl GeometricOrder {
    /// The rays of order `p`, or `None` unless 1 < n < ∞. An order without a rainbow ray (p = 0, p = 1
    /// and n >= p) has rays all the same.
    #[must_use]
    pub fn new(n: f64, p: u32) -> Option<Self> {
        if !(n > 1.0 && n.is_finite()) {
            return None;
        }
        let path = RayPath { n, p };
        let bow = rainbow_ray(n, p);
        let deviation = |incidence: f64| path.ray(incidence).deviation;
        Some(Self {
            path,
            bow,
            least_rad: deviation(bow.map_or(0.0, |ray| ray.incidence_rad)),
            central_rad: deviation(0.0),
            grazing_rad: deviation(FRAC_PI_2),
        })
    }

    /// (dσ/dΩ)/(π a²) in 1/sr for the polarisations s and p.
    #[must_use]
    pub fn normalized_cross_section(&self, theta: Radians) -> [f64; 2] {
        let theta_rad = theta.0.clamp(0.0, PI);
        self.sum(theta_rad, |deviation_rad| {
            self.at_deviation(deviation_rad, theta_rad)
        })
    }

    /// The same of all rays that are not deviated by `deviation_rad`: what other turns of the
    /// deviation bring to the place of a bow; `light` is that of the rays of a deviation.
    pub(crate) fn beside_deviation(
        &self,
        deviation_rad: f64,
        theta_rad: f64,
        light: impl Fn(f64) -> [f64; 2],
    ) -> [f64; 2] {
        self.sum(theta_rad, |other| {
            let is_own = (other - deviation_rad).abs() <= SAME_RAD;
            if is_own { [0.0; 2] } else { light(other) }
        })
    }

    /// Sum of the light of the deviations that fold to θ.
    fn sum(&self, theta_rad: f64, light: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
        let on_axis = theta_rad.sin() < AXIAL_SIN;
        // On the axis both sides are the same deviation, a turn apart at π.
        let (first, sides): (i32, &[f64]) = if on_axis {
            (-1, &[1.0])
        } else {
            (0, &[1.0, -1.0])
        };
        let mut sum = [0.0; 2];
        for turn in first..=self.n_turns() {
            for side in sides {
                let light = light(TAU * f64::from(turn) + side * theta_rad);
                sum[0] += light[0];
                sum[1] += light[1];
            }
        }
        sum
    }

    /// The light of the rays that are deviated by `deviation_rad`, which folds to `theta_rad`; 1/sr.
    pub(crate) fn at_deviation(&self, deviation_rad: f64, theta_rad: f64) -> [f64; 2] {
        let (mut deviation_rad, mut weight) = (deviation_rad, 1.0);
        let least = self.least_rad;
        if deviation_rad < least {
            return [0.0; 2];
        }
        // On the clipped caustic the mean of a (D − D_R)^(−1/2) law is twice its value at the end.
        if self.bow.is_some() && deviation_rad < least + CAUSTIC_RAD {
            (deviation_rad, weight) = (least + CAUSTIC_RAD, 2.0);
        }
        let mut sum = [0.0; 2];
        for end in self.ends() {
            let Some(incidence_rad) = self.incidence(deviation_rad, end) else {
                continue;
            };
            let intensity = self.intensity(incidence_rad, theta_rad);
            sum[0] += weight * intensity[0];
            sum[1] += weight * intensity[1];
        }
        sum
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
        for turn in 0..=self.n_turns() {
            let whole = TAU * f64::from(turn);
            for (low, high) in [
                (whole + from_rad, whole + to_rad),
                (whole - to_rad, whole - from_rad),
            ] {
                for end in self.ends() {
                    self.add_light(low, high, end, &mut light);
                }
            }
        }
        light.map(|light| light / (PI * height))
    }

    /// Adds ∫ sin i cos i ε² di over the rays of the branch up to `end` whose deviation lies between
    /// `low` and `high`.
    fn add_light(&self, low: f64, high: f64, end: End, light: &mut [f64; 2]) {
        let limit = end.deviation_rad;
        if high <= self.least_rad || low >= limit {
            return;
        }
        let at = |deviation: f64| {
            if deviation <= self.least_rad {
                self.least_deviated()
            } else {
                let incidence = self.incidence(deviation, end);
                incidence.unwrap_or(end.incidence_rad)
            }
        };
        let (one, other) = (at(low.min(limit)), at(high.min(limit)));
        let (middle, half) = (0.5 * (one + other), 0.5 * (other - one).abs());
        let nodes: &[(f64, f64)] = if half < FEW_UP_TO_RAD {
            &FEW_NODES
        } else {
            &GAUSS_NODES
        };
        for (node, weight) in nodes {
            let ray = self.path.ray(middle + half * node);
            for (light, amplitude) in light.iter_mut().zip(ray.amplitudes()) {
                *light +=
                    half * weight * ray.sin_incidence * ray.cos_incidence * amplitude * amplitude;
            }
        }
    }

    /// Incidence of the ray with the least deviation: the rainbow ray, or the central one.
    fn least_deviated(&self) -> f64 {
        self.bow.map_or(0.0, |ray| ray.incidence_rad)
    }

    /// The ends of the branches of rays.
    fn ends(&self) -> impl Iterator<Item = End> {
        let without_central = usize::from(self.bow.is_none());
        let central = End {
            incidence_rad: 0.0,
            deviation_rad: self.central_rad,
        };
        let grazing = End {
            incidence_rad: FRAC_PI_2,
            deviation_rad: self.grazing_rad,
        };
        [central, grazing].into_iter().skip(without_central)
    }

    /// Whole turns up to the largest deviation.
    fn n_turns(&self) -> i32 {
        (self.central_rad.max(self.grazing_rad) / TAU).ceil() as i32
    }

    /// The incidence of the ray of a bow with a deviation that is nearer to the center: at most the central ray.
    pub(crate) fn inner_incidence(&self, deviation_rad: f64) -> f64 {
        self.incidence_or_end(deviation_rad, 0.0, self.central_rad)
    }

    /// That of the other one, which follows the formulas on beyond the grazing ray.
    pub(crate) fn outer_incidence(&self, deviation_rad: f64) -> f64 {
        self.incidence_or_end(deviation_rad, PI, self.path.ray(PI).deviation)
    }

    fn incidence_or_end(
        &self,
        deviation_rad: f64,
        incidence_rad: f64,
        end_deviation_rad: f64,
    ) -> f64 {
        let end = End {
            incidence_rad,
            deviation_rad: end_deviation_rad,
        };
        self.incidence(deviation_rad, end).unwrap_or(incidence_rad)
    }

    /// The incidence on the branch up to `end` with the deviation asked for. Along it the deviation
    /// rises monotonically (for a bow even beyond the grazing ray, up to incidence π), so Newton's step
    /// inside a bracket, and a halving where the step would leave it, cannot fail.
    fn incidence(&self, deviation_rad: f64, end: End) -> Option<f64> {
        let (near, far) = (self.least_deviated(), end.incidence_rad);
        if deviation_rad > end.deviation_rad {
            // Rounding may put the last ray itself a digit beyond the axis.
            return (deviation_rad < end.deviation_rad + 1e-12).then_some(far);
        }
        let (mut below, mut above) = (near, far);
        let mut incidence = self.first_guess(deviation_rad, far);
        for _ in 0..MOST_STEPS {
            if !(incidence > below.min(above) && incidence < below.max(above)) {
                incidence = 0.5 * (below + above);
            }
            let ray = self.path.ray(incidence);
            let excess = ray.deviation - deviation_rad;
            if excess < 0.0 {
                below = incidence;
            } else {
                above = incidence;
            }
            let step = excess / ray.slope;
            incidence -= step;
            if step.abs() < CONVERGED_RAD {
                break;
            }
        }
        Some(incidence.clamp(near.min(far), near.max(far)))
    }

    fn first_guess(&self, deviation_rad: f64, far: f64) -> f64 {
        let Some(bow) = self.bow else {
            let part = (deviation_rad - self.central_rad) / (self.grazing_rad - self.central_rad);
            return part * far;
        };
        let beyond = (deviation_rad - bow.deviation_rad).max(0.0);
        let away = (beyond / bow.half_curvature()).sqrt();
        bow.incidence_rad + (far - bow.incidence_rad).signum() * away
    }

    fn intensity(&self, incidence_rad: f64, theta_rad: f64) -> [f64; 2] {
        let ray = self.path.ray(incidence_rad);
        let sin_theta = theta_rad.sin();
        let focus = if self.path.p == 0 {
            // D = 2 i − π: sin i cos i/(sin θ dD/di) = 1/4 at every angle.
            0.25
        } else if sin_theta < AXIAL_SIN {
            ray.cos_incidence / (ray.slope * ray.slope)
        } else {
            ray.sin_incidence * ray.cos_incidence / (sin_theta * ray.slope.abs())
        };
        ray.amplitudes()
            .map(|amplitude| focus * amplitude * amplitude / PI)
    }
}

#[cfg(test)]
mod tests;
