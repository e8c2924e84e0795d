//! The uniform theory of the rainbow: the two rays of the bright side, joined across the caustic.
//!
//! t_j = (1/sin θ) [(A_a + A_b)² ζ^(1/2) Ai²(−ζ) + (A_a − A_b)² ζ^(−1/2) Ai'²(−ζ)],   t = (dσ/dΩ)/(π a²)
//! ζ = [(3/4) x (G(i_b) − G(i_a))]^(2/3),   A = sqrt(sin i cos i/|dD/di|) ε_j(i)
//! `i_a` < i0 < `i_b` incidences of the rays with the deviation D, `G` their optical paths, x = 2π a/λ.
//!
//! With d = D − D_R = σ² the incidence i(σ) is one smooth function, i_a = i(−σ) and i_b = i(σ), and
//! everything follows from B(σ) = ε_j sqrt(sin i cos i σ/(dD/di)) = E(d) + σ O(d):
//!
//! ζ = (x e(d))^(2/3) d,   A_a + A_b = 2 E d^(−1/4),   A_b − A_a = 2 O d^(1/4),   e = (3/4) ΔG d^(−3/2)
//! `e`, `E` and `O` are analytic at d = 0 and do not know the size of the drop. Where d is small the
//! differences of the two rays have lost their digits: there a Taylor series stands for them, whose
//! coefficients come from rays on a circle of complex σ (Cauchy's integral). Farther on the bright side
//! they follow from the two real rays, on the dark side from the complex ray i(i sqrt(−d)), so that
//! exponentially small values keep their relative accuracy.
//!
//! Beyond the grazing ray, which carries no light, i_b is gone: there A_b = 0, which leaves the light
//! of ray `a` with a ripple of (1/6)/ζ^(3/2), and a quarter as far again this has faded into rays. On
//! the axis the theory, without glory or forward focusing, is that of the rays. Within 21 degrees of
//! the forward direction the dark side of the primary bow keeps its coefficients: i(σ) ends at 0.
//!
//! Against the exact Debye order (see the tests): 2e-4 RMS within 2 degrees for 1 mm, 2e-3 for 100 µm,
//! 6 % for 10 µm radius.
//! [CFU57] C. Chester, B. Friedman and F. Ursell, Proc. Camb. Phil. Soc. 53, 599-611 (1957).
//! [KN74] V. Khare and H. M. Nussenzveig, Phys. Rev. Lett. 33, 976-980 (1974). [A02] J. A. Adam,
//! Phys. Rep. 356, 229-365 (2002), ch. 5.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_radiometry::Radians;
use num_complex::Complex64;

use crate::airy_integral::ARGUMENT;
use crate::airy_integral::DERIVATIVE;
use crate::airy_integral::VALUE;
use crate::bow_direction::BowDirection;
use crate::geometric::GeometricOrder;
use crate::rainbow_ray::RainbowRay;
use crate::rainbow_ray::rainbow_ray;
use crate::ray_branch::RayBranch;
use crate::ray_path::Incidence;
use crate::ray_path::Ray;
use crate::ray_path::RayPath;

/// Terms of the series, its reach and the circle of its coefficients in parts of the distance to the
/// nearest singularity: 0.3^28 is below rounding.
const N_TERMS: usize = 28;
const SERIES_REACH: f64 = 0.3;
const CIRCLE: f64 = 0.5;
/// Rays on half of the circle of σ.
const N_HALF_CIRCLE: usize = 64;
/// How far beyond the grazing ray the form has faded into rays, in its distance.
const FADED: f64 = 1.25;
/// Part of [`FADED`] at which the fading begins: the grazing ray.
const FADES_FROM: f64 = 0.8;
/// Least deviation of a complex ray, in parts of that of the rainbow ray: below 21 degrees for the
/// primary bow of water.
const DARKEST: f64 = 0.15;
/// Smallest sin θ: on the bright side the form has faded into rays long before; on the dark side the
/// factor stops where a drop of 4 µm radius no longer focuses, 1/x.
const SMALLEST_SIN: f64 = 0.02;
/// sin θ from which the light of a ray follows from its strength.
const NEAR_AXIS_SIN: f64 = 1e-3;
/// Newton's steps at most; 4 to 7 are usual.
const MOST_STEPS: u32 = 40;
/// The step after one below this is below rounding.
const CONVERGED_RAD: f64 = 1e-9;

/// The bow of one order in the uniform theory.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformBow {
    path: RayPath,
    ray: RainbowRay,
    rays: GeometricOrder,
    /// Terms of the series in d, and how far it holds.
    series: [[f64; 5]; N_TERMS],
    series_rad: f64,
    /// d between which the form fades into rays.
    fading_rad: (f64, f64),
    /// Least d from which there is light.
    darkest_rad: f64,
    /// d of the central ray, and where the direction of the bow meets the axis.
    central_rad: f64,
    axis_rad: f64,
    /// Ray `a` from the end of the series to the central ray.
    inner: RayBranch,
    /// Ray `b` from there to the axis.
    outer: RayBranch,
}

/// What the two rays of a deviation have in common.
#[derive(Clone, Copy, Debug)]
struct RayPair {
    /// e.
    stretch: f64,
    /// E for each polarisation.
    even: [f64; 2],
    /// O for each polarisation.
    odd: [f64; 2],
}

impl UniformBow {
    /// The bow of order `p` for drops of index `n`, or `None` where there is none.
    #[must_use]
    pub fn new(n: f64, p: u32) -> Option<Self> {
        let ray = rainbow_ray(n, p)?;
        let rays = GeometricOrder::new(n, p)?;
        let path = RayPath { n, p };
        let beyond = |incidence| path.ray::<f64>(incidence).deviation - ray.deviation_rad;
        let (central_rad, grazing_rad) = (beyond(0.0), beyond(FRAC_PI_2));
        let reach_rad = central_rad.min(grazing_rad);
        // The next direction along the axis ends the branch.
        let axis_rad = PI - ray.deviation_rad.rem_euclid(PI);
        let faded_rad = (FADED * grazing_rad).min(axis_rad);
        let series_rad = SERIES_REACH * reach_rad;
        let branch = |to_rad: f64, incidence: &dyn Fn(f64) -> f64| {
            RayBranch::new((series_rad, to_rad), |beyond_rad| {
                let ray = path.ray(incidence(ray.deviation_rad + beyond_rad));
                let spread = (beyond_rad.sqrt() / ray.slope.abs()).sqrt();
                let [s, p] = ray.amplitudes().map(|amplitude| amplitude * spread);
                [
                    ray.optical_path(),
                    ray.sin_incidence * ray.cos_incidence,
                    s,
                    p,
                ]
            })
        };
        let mut bow = Self {
            path,
            ray,
            rays,
            series: [[0.0; 5]; N_TERMS],
            series_rad,
            fading_rad: (FADES_FROM * faded_rad, faded_rad),
            darkest_rad: f64::NEG_INFINITY,
            central_rad,
            axis_rad,
            inner: branch(central_rad.max(axis_rad), &|deviation_rad| {
                rays.inner_incidence(deviation_rad)
            }),
            outer: branch(axis_rad, &|deviation_rad| {
                rays.outer_incidence(deviation_rad)
            }),
        };
        bow.series = bow.caustic_series((CIRCLE * reach_rad).sqrt());
        Some(bow)
    }

    /// The same without the light whose z x^(−2/3) is less than about `argument`, which is negative: the
    /// exponentially small light of the dark side costs more than all other.
    #[must_use]
    pub fn above(mut self, argument: f64) -> Self {
        let end = self.near_caustic(-self.series_rad).argument(-1.0);
        self.darkest_rad = (-argument / end).min(-self.series_rad);
        self
    }

    /// The rainbow ray.
    #[must_use]
    pub fn ray(&self) -> &RainbowRay {
        &self.ray
    }

    /// z x^(−2/3) in the direction θ, [`BowDirection::argument`] alone; rises with the deviation.
    #[must_use]
    pub fn argument(&self, theta: Radians) -> f64 {
        let beyond_rad = self.ray.beyond_rad(theta.0);
        self.pair(beyond_rad).argument(beyond_rad)
    }

    /// What does not depend on the size of the drop.
    #[must_use]
    pub fn direction(&self, theta: Radians) -> BowDirection {
        BowDirection {
            rays: self.rays_beside(theta),
            ..self.wave(theta)
        }
    }

    /// The same without rays.
    #[must_use]
    pub fn wave(&self, theta: Radians) -> BowDirection {
        let beyond_rad = self.ray.beyond_rad(theta.0);
        let pair = self.pair(beyond_rad);
        let root = pair.stretch.cbrt();
        // 4/(sin θ V²) and 4/(sin θ (V A)²): Ai = f/V, Ai' = −f'/(V A).
        let part = 1.0 - self.rays_weight(beyond_rad);
        let wave = 4.0 * part / theta.0.sin().max(SMALLEST_SIN);
        let (value, derivative) = (
            wave * root / (VALUE * VALUE),
            wave / (root * DERIVATIVE * DERIVATIVE),
        );
        BowDirection {
            argument: pair.argument(beyond_rad),
            strength: pair.even.map(|even| value * even * even),
            derivative_strength: pair.odd.map(|odd| derivative * odd * odd),
            rays: [0.0; 2],
        }
    }

    /// Light of the rays that make no bow in a direction, in 1/sr: those beyond the grazing one, and those of
    /// other turns.
    #[must_use]
    pub fn rays_beside(&self, theta: Radians) -> [f64; 2] {
        let beyond_rad = self.ray.beyond_rad(theta.0);
        let deviation_rad = self.ray.deviation_rad + beyond_rad;
        let light = |other| self.light_of_rays(other, theta.0);
        let beside = self.rays.beside_deviation(deviation_rad, theta.0, light);
        let weight = self.rays_weight(beyond_rad);
        if weight <= 0.0 {
            return beside;
        }
        let own = self.light_of_rays(deviation_rad, theta.0);
        [0, 1].map(|j| beside[j] + weight * own[j])
    }

    /// Light of both rays of a deviation that folds to θ; 1/sr.
    fn light_of_rays(&self, deviation_rad: f64, theta_rad: f64) -> [f64; 2] {
        let beyond_rad = deviation_rad - self.ray.deviation_rad;
        if beyond_rad <= self.series_rad || theta_rad.sin() <= NEAR_AXIS_SIN {
            self.rays.at_deviation(deviation_rad, theta_rad)
        } else if beyond_rad <= self.central_rad {
            self.bright_side(beyond_rad)
                .light_of_both(beyond_rad, theta_rad)
        } else {
            [0.0; 2]
        }
    }

    /// 0 up to the grazing ray, 1 where the form has faded, smooth between.
    fn rays_weight(&self, beyond_rad: f64) -> f64 {
        let (from, to) = self.fading_rad;
        let part = ((beyond_rad - from) / (to - from)).clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    }

    fn pair(&self, beyond_rad: f64) -> RayPair {
        if beyond_rad.abs() <= self.series_rad {
            self.near_caustic(beyond_rad)
        } else if beyond_rad < self.darkest_rad {
            let end = self.near_caustic(-self.series_rad);
            RayPair {
                even: [0.0; 2],
                odd: [0.0; 2],
                ..end
            }
        } else if beyond_rad < 0.0 {
            self.dark_side(beyond_rad)
        } else {
            self.bright_side(beyond_rad)
        }
    }

    fn near_caustic(&self, beyond_rad: f64) -> RayPair {
        let mut sums = [0.0; 5];
        for terms in self.series.iter().rev() {
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum = *sum * beyond_rad + term;
            }
        }
        let [stretch, even_s, even_p, odd_s, odd_p] = sums;
        RayPair {
            stretch,
            even: [even_s, even_p],
            odd: [odd_s, odd_p],
        }
    }

    fn bright_side(&self, beyond_rad: f64) -> RayPair {
        let sigma = beyond_rad.sqrt();
        let [inner_path, inner @ ..] = self.inner.at(beyond_rad);
        // The phase goes on beyond the grazing ray, whose light ends there.
        let [outer_path, outer @ ..] = if beyond_rad <= self.axis_rad {
            self.outer.at(beyond_rad)
        } else {
            [0.0; 4]
        };
        let [inner, outer] = [inner, outer].map(|[product, s, p]| {
            let root = product.max(0.0).sqrt();
            [root * s, root * p]
        });
        RayPair {
            stretch: 0.75 * (outer_path - inner_path) / (beyond_rad * sigma),
            even: [0, 1].map(|j| 0.5 * (outer[j] + inner[j])),
            odd: [0, 1].map(|j| 0.5 * (outer[j] - inner[j]) / sigma),
        }
    }

    fn dark_side(&self, beyond_rad: f64) -> RayPair {
        let beyond_rad = beyond_rad.max((DARKEST - 1.0) * self.ray.deviation_rad);
        let depth = (-beyond_rad).sqrt();
        let guess = self.incidence_near_caustic(Complex64::new(0.0, depth));
        let ray = self.complex_ray(Complex64::from(beyond_rad), guess).0;
        let strengths = strengths(&ray, Complex64::new(0.0, depth));
        RayPair {
            stretch: 1.5 * ray.optical_path().im / (beyond_rad * depth),
            even: strengths.map(|b| b.re),
            odd: strengths.map(|b| b.im / depth),
        }
    }

    /// Leading term of i(σ).
    fn incidence_near_caustic(&self, sigma: Complex64) -> Complex64 {
        self.ray.incidence_rad + sigma / self.ray.half_curvature().sqrt()
    }

    /// The ray with deviation D_R + d for complex d, and its incidence, by Newton's rule.
    fn complex_ray(&self, beyond: Complex64, guess: Complex64) -> (Ray<Complex64>, Complex64) {
        let mut incidence = guess;
        let mut ray = self.path.ray(incidence);
        for _ in 0..MOST_STEPS {
            let step = (ray.deviation - self.ray.deviation_rad - beyond) / ray.slope;
            incidence -= step;
            ray = self.path.ray(incidence);
            if step.norm() < CONVERGED_RAD {
                break;
            }
        }
        (ray, incidence)
    }

    /// Coefficients of e, E and O in d, from rays on the circle |σ| = `radius`: c_k is the mean of
    /// F(σ)/σ^k over it, the conjugate half being the conjugate. The odd part of sin i gives e:
    /// ΔG = ∫ sin i dD.
    fn caustic_series(&self, radius: f64) -> [[f64; 5]; N_TERMS] {
        let mut incidence = self.incidence_near_caustic(Complex64::from(radius));
        let mut circle = Vec::with_capacity(N_HALF_CIRCLE + 1);
        for step in 0..=N_HALF_CIRCLE {
            let phase = PI * step as f64 / N_HALF_CIRCLE as f64;
            let sigma = Complex64::from_polar(radius, phase);
            let ray;
            (ray, incidence) = self.complex_ray(sigma * sigma, incidence);
            let weight = if step % N_HALF_CIRCLE == 0 { 0.5 } else { 1.0 } / N_HALF_CIRCLE as f64;
            circle.push((sigma, weight, ray));
            // i(σ) goes on along the circle.
            let turn = Complex64::from_polar(1.0, PI / N_HALF_CIRCLE as f64) - 1.0;
            incidence += 2.0 * sigma * sigma * turn / ray.slope;
        }
        let mut series = [[0.0; 5]; N_TERMS];
        for (sigma, weight, ray) in circle {
            let [s, p] = strengths(&ray, sigma);
            let square = sigma.powi(-2);
            let mut power = Complex64::from(weight);
            for (index, terms) in series.iter_mut().enumerate() {
                let odd = power / sigma;
                let sin_to_stretch = 3.0 / (2 * index + 3) as f64;
                terms[0] += sin_to_stretch * (ray.sin_incidence * odd).re;
                terms[1] += (s * power).re;
                terms[2] += (p * power).re;
                terms[3] += (s * odd).re;
                terms[4] += (p * odd).re;
                power *= square;
            }
        }
        series
    }
}

impl RayPair {
    /// ζ x^(−2/3)/A.
    fn argument(&self, beyond_rad: f64) -> f64 {
        self.stretch.cbrt().powi(2) * beyond_rad / ARGUMENT
    }

    /// What both rays send without interference, 2 (E² + d O²)/(π sin θ sqrt(d)); 1/sr.
    fn light_of_both(&self, beyond_rad: f64, theta_rad: f64) -> [f64; 2] {
        let scale = 2.0 / (PI * theta_rad.sin() * beyond_rad.sqrt());
        [0, 1].map(|j| scale * (self.even[j].powi(2) + beyond_rad * self.odd[j].powi(2)))
    }
}

/// B(σ) for each polarisation.
fn strengths<T: Incidence>(ray: &Ray<T>, sigma: T) -> [T; 2] {
    let spread = ray.sin_incidence * ray.cos_incidence * sigma / ray.slope;
    ray.amplitudes().map(|amplitude| amplitude * spread.sqrt())
}

#[cfg(test)]
mod tests;
