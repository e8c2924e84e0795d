//! Airy's theory of the rainbow, absolute and for both polarisations.
//!
//! dσ_j/dΩ = (a λ / 4π²) (sin i0 / sin θ) ε_j² f(z)² M²,
//! M = 2k (3 a² λ/(4 h cos d))^(1/3),   z = (4/λ) sin d (3 a² λ/(4 h cos d))^(1/3),   k = 2π/λ
//! `a` radius, `λ` wavelength in the air, `d` = D − D_R the deviation beyond the rainbow ray (not the
//! scattering angle), `i0`, `h`, ε_j of the rainbow ray. The exponent is 1/3: `a² λ` is a volume.
//! Equal to 2 x^(1/3) h^(−2/3) (sin i0/sin θ) ε_j² Ai²(−ζ) π a² up to cos d, x = 2π a/λ.
//!
//! That is the amplitude of the rainbow ray alone. To first order in its neighbors the amplitude is
//! ε Ai(−ζ) + i ε' (cos i0)^(−1) (x h)^(−1/3) Ai'(−ζ), and the two parts add as intensities (KB79):
//! ε' = d/di [ε sqrt(sin i cos i)]/sqrt(sin i0 cos i0) − ε D'''/(6 D'') at the rainbow ray, from the
//! expansion of the amplitude of a ray, sqrt(sin i cos i/|dD/di|) ε, in sqrt(D − D_R). The second part
//! fills the dark fringes of the weak polarisation.
//!
//! The theory has the amplitude of the rainbow ray everywhere. Away from it the rays carry another
//! one, 10 % less at 8 degrees: so from a hundredth to a tenth of its reach (10 degrees for p = 2,
//! 4 for higher orders) the mean over the fringes is drawn to that of the rays, and at the end of the
//! reach (smoothstep, a fifth to either side) the fringes fade into the rays.
//!
//! Against the exact Debye order (see the tests): 0.9 to 3 % RMS within 2 degrees for radii of 50 µm to
//! 1 mm, where the phase of the fringes decides, and 7 % at 10 µm; 4 to 8 % and 16 % in the weak
//! polarisation. As a textbook has it, without derivative and rays: 3.5 to 7 % and 14 %; 40 to 80 % in
//! the weak polarisation. See [`AIRY_SMALLEST_RADIUS`].
//! [A38] G. B. Airy, Trans. Camb. Phil. Soc. 6, 379-403 (1838). [vdH57] H. C. van de Hulst, Light
//! Scattering by Small Particles, ch. 13.23 (1957). [KB79] G. P. Können and J. H. de Boer, Appl. Opt.
//! 18, 1961-1965 (1979).

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_radiometry::Meters;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use num_complex::Complex64;

use crate::airy_integral::ARGUMENT;
use crate::bow_direction::BowDirection;
use crate::geometric::GeometricOrder;
use crate::rainbow_ray::RainbowRay;
use crate::rainbow_ray::rainbow_ray;
use crate::ray_path::RayPath;

/// Radius below which the theory should not be used. The first peak of the primary bow at 650 nm, over
/// that of the exact Debye order: 0.975 at this radius and 0.88 at 10 µm; without derivative and rays,
/// as in a textbook, 1.08 and 1.13.
pub const AIRY_SMALLEST_RADIUS: Micrometers = Micrometers(30.0);

/// Step of a complex-step derivative: far below rounding, so nothing is lost.
const COMPLEX_STEP: f64 = 1e-30;

/// Reach of the theory inside the primary bow.
const PRIMARY_REACH_RAD: f64 = 10.0 * PI / 180.0;
/// Reach of the theory inside the secondary bow and beyond.
const HIGHER_REACH_RAD: f64 = 4.0 * PI / 180.0;
/// Part of the reach, on either side of it, over which the theory fades into rays.
const BLEND: f64 = 0.2;
/// Smallest sin θ in the factor sin i0/sin θ: on the bright side the blend has switched the factor off
/// long before; on the dark side it stops where a drop of 4 µm radius no longer focuses, 1/x.
const SMALLEST_SIN: f64 = 0.02;

/// Radius at which the published form has the brightness of the absolute one.
const PUBLISHED_RADIUS_M: f64 = 100e-6;
/// Wavelength at which the published form has the brightness of the absolute one.
const PUBLISHED_WAVELENGTH_M: f64 = 550e-9;

/// Where the mean over the fringes begins to follow the rays, in parts of the reach.
const MEAN_FROM: f64 = 0.01;
/// Where the mean over the fringes is that of the rays, in parts of the reach.
const MEAN_TO: f64 = 0.1;

/// The bow of one order in Airy's theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AiryBow {
    ray: RainbowRay,
    rays: GeometricOrder,
    /// ε'/(cos i0 h^(1/3)).
    derivative_amplitudes: [f64; 2],
    reach_rad: f64,
}

/// Which of the two forms of the theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AiryForm {
    /// In 1/sr, drawn to the rays where the theory ends.
    Absolute,
    /// I = f² M² at every angle, scaled to the absolute form at one size and wavelength.
    Published,
}

impl AiryForm {
    /// The factor of a direction's strength that depends on size and wavelength: x^(1/3) with
    /// x = 2π a/λ, or (a/λ)^(4/3)/a² in 1/m².
    #[must_use]
    pub fn size_factor(self, radius: Micrometers, wavelength: Nanometers) -> f64 {
        let (radius_m, wavelength_m) = (Meters::from(radius).0, Meters::from(wavelength).0);
        let relative = radius_m / wavelength_m;
        match self {
            Self::Absolute => (TAU * relative).cbrt(),
            Self::Published => relative * relative.cbrt() / (radius_m * radius_m),
        }
    }

    /// The power of the radius in [`Self::size_factor`].
    #[must_use]
    pub fn radius_exponent(self) -> f64 {
        match self {
            Self::Absolute => 1.0 / 3.0,
            Self::Published => -2.0 / 3.0,
        }
    }
}

impl AiryBow {
    /// The bow of order `p` for drops of index `n`, or `None` where there is none.
    #[must_use]
    pub fn new(n: f64, p: u32) -> Option<Self> {
        let reach_rad = if p == 2 {
            PRIMARY_REACH_RAD
        } else {
            HIGHER_REACH_RAD
        };
        let ray = rainbow_ray(n, p)?;
        Some(Self {
            ray,
            rays: GeometricOrder::new(n, p)?,
            derivative_amplitudes: derivative_amplitudes(&ray),
            reach_rad,
        })
    }

    /// The rainbow ray.
    #[must_use]
    pub fn ray(&self) -> &RainbowRay {
        &self.ray
    }

    /// z x^(−2/3) in the direction θ, [`BowDirection::argument`] alone; 0 where the form ends.
    #[must_use]
    pub fn argument(&self, theta: Radians) -> f64 {
        self.squared_amplitudes(self.ray.beyond_rad(theta.0))
            .argument
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
        let spread = self.ray.incidence_rad.sin() / theta.0.sin().max(SMALLEST_SIN);
        // (4/π)(3/(4 h cos d))^(2/3) (a/λ)^(1/3) f², with a/λ = x/2π.
        let common = 4.0 / PI * TAU.cbrt().recip() * spread;
        let mut bow = self.squared_amplitudes(beyond_rad);
        let mut factors = [[common; 2]; 2];
        if self.ramp(beyond_rad, MEAN_FROM, MEAN_TO) > 0.0 {
            let deviation_rad = self.ray.deviation_rad + beyond_rad;
            let own = self.rays.at_deviation(deviation_rad, theta.0);
            let part = 1.0 - self.rays_weight(beyond_rad);
            let drawn = self.drawn_to_rays(beyond_rad, spread, own);
            factors = drawn.map(|factors| factors.map(|f| common * part * f));
        }
        bow.strength = [0, 1].map(|j| factors[j][0] * bow.strength[j]);
        bow.derivative_strength = [0, 1].map(|j| factors[j][1] * bow.derivative_strength[j]);
        bow
    }

    /// Light of the rays that make no bow in a direction, in 1/sr: those where the theory has faded, and those of
    /// other turns.
    #[must_use]
    pub fn rays_beside(&self, theta: Radians) -> [f64; 2] {
        let beyond_rad = self.ray.beyond_rad(theta.0);
        let deviation_rad = self.ray.deviation_rad + beyond_rad;
        let light = |other| self.rays.at_deviation(other, theta.0);
        let beside = self.rays.beside_deviation(deviation_rad, theta.0, light);
        let weight = self.rays_weight(beyond_rad);
        if weight <= 0.0 {
            return beside;
        }
        let own = light(deviation_rad);
        [0, 1].map(|j| beside[j] + weight * own[j])
    }

    /// 0 within the reach, 1 where the form has faded into rays.
    fn rays_weight(&self, beyond_rad: f64) -> f64 {
        self.ramp(beyond_rad, 1.0 - BLEND, 1.0 + BLEND)
    }

    /// For each polarisation the factors of f² and f'² that draw the mean over the fringes to that of
    /// the rays. The theory knows the first order of f'² but not that of f²: so it is f² that gives way.
    fn drawn_to_rays(&self, beyond_rad: f64, spread: f64, rays: [f64; 2]) -> [[f64; 2]; 2] {
        let weight = self.ramp(beyond_rad, MEAN_FROM, MEAN_TO);
        let mean = spread * fringe_mean(beyond_rad, self.ray.wavefront_h);
        // Ai² and Ai'² have the means 1/(2π sqrt(ζ)) and sqrt(ζ)/2π.
        let zeta = beyond_rad / self.ray.wavefront_h.cbrt();
        [0, 1].map(|j| {
            let value = mean * self.ray.amplitudes[j].powi(2);
            let derivative = mean * zeta * self.derivative_amplitudes[j].powi(2);
            let value_factor = if value > 0.0 {
                ((rays[j] - derivative) / value).max(0.0)
            } else {
                1.0
            };
            let derivative_factor = if derivative > rays[j] {
                rays[j] / derivative
            } else {
                1.0
            };
            [value_factor, derivative_factor].map(|factor| 1.0 + weight * (factor - 1.0))
        })
    }

    /// The same for the published form, I = f² M² without a derivative and without the factor a λ: its
    /// colors and sizes are wrong by that factor. It is scaled to the absolute one at 100 µm and 550 nm.
    #[must_use]
    pub fn published_direction(&self, theta: Radians) -> BowDirection {
        let mut bow = self.squared_amplitudes(self.ray.beyond_rad(theta.0));
        // f² M² = 16π² (3/(4 h cos d))^(2/3) (a/λ)^(4/3) f², and a λ/4π² of the size it is scaled to.
        let spread = self.ray.incidence_rad.sin() / self.ray.theta_rad().sin();
        let scale = 4.0 / PI * PUBLISHED_RADIUS_M * PUBLISHED_WAVELENGTH_M * spread;
        bow.strength = bow.strength.map(|strength| scale * strength);
        bow.derivative_strength = [0.0; 2];
        bow
    }

    /// ε_j² (3/(4 h cos d))^(2/3), the same for the derivative, and
    /// z x^(−2/3) = 4 sin d (3/(4 h cos d))^(1/3) (2π)^(−2/3) for a deviation `d` beyond the rainbow ray;
    /// nothing a quarter turn or more away from it, where the form ends.
    fn squared_amplitudes(&self, d: f64) -> BowDirection {
        let (sin_d, cos_d) = d.sin_cos();
        if cos_d <= 0.0 {
            return BowDirection {
                argument: 0.0,
                strength: [0.0; 2],
                derivative_strength: [0.0; 2],
                rays: [0.0; 2],
            };
        }
        let length = (3.0 / (4.0 * self.ray.wavefront_h * cos_d)).cbrt();
        // Ai(−A z) = f/V, Ai'(−A z) = −f'/(V A).
        let derivative_length = length / ARGUMENT;
        let square = |amplitude: f64| amplitude * amplitude;
        BowDirection {
            argument: 4.0 * sin_d * length / (TAU * TAU).cbrt(),
            strength: self.ray.amplitudes.map(|e| square(e * length)),
            derivative_strength: self
                .derivative_amplitudes
                .map(|e| square(e * derivative_length)),
            rays: [0.0; 2],
        }
    }

    /// 0 up to `from` parts of the reach, 1 from `to` parts on, smooth between.
    fn ramp(&self, beyond_rad: f64, from: f64, to: f64) -> f64 {
        let part = ((beyond_rad / self.reach_rad - from) / (to - from)).clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    }
}

/// ε'/(cos i0 h^(1/3)).
fn derivative_amplitudes(ray: &RainbowRay) -> [f64; 2] {
    let path = RayPath { n: ray.n, p: ray.p };
    let beside = path.ray(Complex64::new(ray.incidence_rad, COMPLEX_STEP));
    let (sin, cos) = ray.incidence_rad.sin_cos();
    let root = (beside.sin_incidence * beside.cos_incidence / (sin * cos)).sqrt();
    let bend = ray.third_derivative() / (12.0 * ray.half_curvature());
    let length = cos * ray.wavefront_h.cbrt();
    let slopes = beside
        .amplitudes()
        .map(|near| (near * root).im / COMPLEX_STEP);
    [0, 1].map(|j| (slopes[j] - bend * ray.amplitudes[j]) / length)
}

/// (a λ / 4π²) f² M² / (π a²) averaged over the fringes: Ai² has the mean 1/(2π sqrt(ζ)), and radius
/// and wavelength cancel, leaving 1/(π sqrt(h sin d cos d)).
fn fringe_mean(d: f64, h: f64) -> f64 {
    let (sin_d, cos_d) = d.sin_cos();
    1.0 / (PI * (h * sin_d * cos_d).sqrt())
}

#[cfg(test)]
mod tests;
