//! Airy's theory of the rainbow, absolute and for both polarisations.
//!
//! dσ_j/dΩ = (a λ / 4π²) (sin i0 / sin θ) ε_j² f(z)² M²,
//! M = 2k (3 a² λ/(4 h cos d))^(1/3),   z = (4/λ) sin d (3 a² λ/(4 h cos d))^(1/3),   k = 2π/λ
//! `a` radius, `λ` wavelength in the air, `d` = D − D_R the deviation beyond the rainbow ray (not the
//! scattering angle), `i0`, `h`, ε_j of the rainbow ray. The exponent is 1/3: `a² λ` is a volume.
//! Equal to 2 x^(1/3) h^(−2/3) (sin i0/sin θ) ε_j² Ai²(−ζ) π a² up to cos d, x = 2π a/λ.
//!
//! That is the amplitude of the rainbow ray alone. To first order in its neighbors (KB79) the amplitude
//! is ε Ai(−ζ) + i ε' (cos i0)^(−1) (x h)^(−1/3) Ai'(−ζ), ε' = d/di [ε sqrt(sin i)]/sqrt(sin i0), and
//! the two parts add as intensities. The second one fills the dark fringes of the weak polarisation.
//!
//! The theory has the amplitude of the rainbow ray everywhere. Away from it the rays carry another
//! one, 10 % less at 8 degrees: so from a tenth to three tenths of its reach (10 degrees for p = 2,
//! 4 for higher orders) the mean over the fringes is drawn to that of the rays, and at the end of the
//! reach (smoothstep, a fifth to either side) the fringes fade into the rays.
//!
//! Against the exact Debye order (see the tests): 3.5 to 7 % RMS within 2 degrees for radii of 50 µm to
//! 1 mm, 10 to 14 % at 10 µm, and the peak is more than 8 % too high below [`AIRY_SMALLEST_RADIUS`].
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

/// Radius below which the theory should not be used: the first peak of the primary bow is 8 % too high
/// at 650 nm, 13 % at 10 µm (against the exact Debye order), and it lies 0.14 and 1 degree off.
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
const MEAN_FROM: f64 = 0.1;
/// Where the mean over the fringes is that of the rays, in parts of the reach.
const MEAN_TO: f64 = 0.3;

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
        let beyond_rad = self.ray.beyond_rad(theta.0);
        let deviation_rad = self.ray.deviation_rad + beyond_rad;
        let spread = self.ray.incidence_rad.sin() / theta.0.sin().max(SMALLEST_SIN);
        // (4/π)(3/(4 h cos d))^(2/3) (a/λ)^(1/3) f², with a/λ = x/2π.
        let common = 4.0 / PI * TAU.cbrt().recip() * spread;
        let mut bow = self.squared_amplitudes(beyond_rad);
        bow.rays = self.rays.beside_deviation(deviation_rad, theta.0);
        let mut factors = [common; 2];
        if self.ramp(beyond_rad, MEAN_FROM, MEAN_TO) > 0.0 {
            let own = self.rays.at_deviation(deviation_rad, theta.0);
            let rays_weight = self.ramp(beyond_rad, 1.0 - BLEND, 1.0 + BLEND);
            factors = self
                .drawn_to_rays(beyond_rad, spread, own)
                .map(|drawn| common * (1.0 - rays_weight) * drawn);
            bow.rays = [0, 1].map(|j| bow.rays[j] + rays_weight * own[j]);
        }
        bow.strength = [0, 1].map(|j| factors[j] * bow.strength[j]);
        bow.derivative_strength = [0, 1].map(|j| factors[j] * bow.derivative_strength[j]);
        bow
    }

    /// Factors that draw the mean over the fringes to that of the rays.
    fn drawn_to_rays(&self, beyond_rad: f64, spread: f64, rays: [f64; 2]) -> [f64; 2] {
        let weight = self.ramp(beyond_rad, MEAN_FROM, MEAN_TO);
        let mean = spread * fringe_mean(beyond_rad, self.ray.wavefront_h);
        // Ai² and Ai'² have the means 1/(2π sqrt(ζ)) and sqrt(ζ)/2π.
        let zeta = beyond_rad / self.ray.wavefront_h.cbrt();
        [0, 1].map(|j| {
            let [amplitude, derivative] = [self.ray.amplitudes[j], self.derivative_amplitudes[j]];
            let own = mean * (amplitude * amplitude + zeta * derivative * derivative);
            if own > 0.0 {
                (rays[j] / own).powf(weight)
            } else {
                0.0
            }
        })
    }

    /// The same for the published form, without a derivative.
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

    /// The intensity of the published form, I = f² M², with no factor a λ: its colors and sizes are
    /// wrong by that factor. It is scaled to the absolute one at 100 µm and 550 nm. 1/sr.
    #[must_use]
    pub fn published(
        &self,
        radius: Micrometers,
        wavelength: Nanometers,
        theta: Radians,
        squares: impl Fn(f64) -> [f64; 2],
    ) -> [f64; 2] {
        self.published_direction(theta)
            .evaluate(AiryForm::Published, (radius, wavelength), squares)
    }

    /// 0 up to `from` parts of the reach, 1 from `to` parts on, smooth between.
    fn ramp(&self, beyond_rad: f64, from: f64, to: f64) -> f64 {
        let part = ((beyond_rad / self.reach_rad - from) / (to - from)).clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    }
}

/// ε'/(cos i0 h^(1/3)) with ε' = d/di [ε sqrt(sin i)]/sqrt(sin i0).
fn derivative_amplitudes(ray: &RainbowRay) -> [f64; 2] {
    let path = RayPath { n: ray.n, p: ray.p };
    let beside = path.ray(Complex64::new(ray.incidence_rad, COMPLEX_STEP));
    let root = (beside.sin_incidence / ray.incidence_rad.sin()).sqrt();
    let length = ray.incidence_rad.cos() * ray.wavefront_h.cbrt();
    beside
        .amplitudes()
        .map(|amplitude| (amplitude * root).im / COMPLEX_STEP / length)
}

/// (a λ / 4π²) f² M² / (π a²) averaged over the fringes: Ai² has the mean 1/(2π sqrt(ζ)), and radius
/// and wavelength cancel, leaving 1/(π sqrt(h sin d cos d)).
fn fringe_mean(d: f64, h: f64) -> f64 {
    let (sin_d, cos_d) = d.sin_cos();
    1.0 / (PI * (h * sin_d * cos_d).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airy_integral::airy_squares;
    use spec_math::Bessel;

    const RED: Nanometers = Nanometers(650.0);
    const RED_INDEX: f64 = 1.3312;

    fn unpolarized(bow: &AiryBow, radius_um: f64, theta_deg: f64) -> f64 {
        let theta = Radians::from_degrees(theta_deg);
        let [s, p] = bow.direction(theta).normalized_cross_section(
            Micrometers(radius_um),
            RED,
            airy_squares,
        );
        0.5 * (s + p)
    }

    /// Angle beyond the rainbow ray, in degrees, and height of the highest peak.
    fn peak(bow: &AiryBow, radius_um: f64) -> (f64, f64) {
        let start_deg = bow.ray().theta_rad().to_degrees();
        (0..9000)
            .map(|step| 1e-3 * f64::from(step))
            .map(|beyond| {
                let theta_deg = start_deg + bow.ray().bright_side() * beyond;
                // Without the factor 1/sin θ, whose slope would move the peak of small drops.
                (
                    beyond,
                    unpolarized(bow, radius_um, theta_deg) * theta_deg.to_radians().sin(),
                )
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap()
    }

    #[test]
    fn the_papers_variables_give_the_textbook_form() {
        // |S_j|² = 2π x^(7/3) h^(−2/3) (sin i0/sin θ) ε_j² Ai²(−ζ), ζ = x^(2/3) h^(−1/3) (D − D_R).
        let bow = AiryBow::new(RED_INDEX, 2).unwrap();
        let ray = *bow.ray();
        for radius_um in [10.0, 100.0, 1000.0_f64] {
            let x = TAU * radius_um / 0.65;
            let theta_rad = ray.theta_rad() + 0.4 * x.powf(-2.0 / 3.0);
            let zeta = x.powf(2.0 / 3.0)
                * ray.wavefront_h.powf(-1.0 / 3.0)
                * (theta_rad - ray.theta_rad());
            let ai = (-zeta).airy().ai;
            let expected = 2.0
                * x.powf(1.0 / 3.0)
                * ray.wavefront_h.powf(-2.0 / 3.0)
                * (ray.incidence_rad.sin() / theta_rad.sin())
                * ray.amplitudes[0].powi(2)
                * ai
                * ai;
            let radius = Micrometers(radius_um);
            let found = bow.direction(Radians(theta_rad)).normalized_cross_section(
                radius,
                RED,
                airy_squares,
            )[0];
            assert!(
                (found / expected - 1.0).abs() < 2e-4,
                "{found} against {expected}"
            );
        }
    }

    #[test]
    fn first_peaks_lie_where_the_wave_puts_them() {
        // d1 = 1.01879 h^(1/3) x^(−2/3) in degrees for 650 nm.
        let bow = AiryBow::new(RED_INDEX, 2).unwrap();
        for (radius_um, offset_deg) in [
            (20.0, 2.98),
            (50.0, 1.62),
            (100.0, 1.02),
            (200.0, 0.64),
            (500.0, 0.35),
            (1000.0, 0.22),
        ] {
            assert!((peak(&bow, radius_um).0 - offset_deg).abs() < 0.02);
        }
    }

    #[test]
    fn peaks_grow_as_the_seventh_third_power_of_the_radius() {
        // t = (dσ/dΩ)/(π a²), so t grows with the power 1/3; sin θ changes a little with the peak.
        let bow = AiryBow::new(RED_INDEX, 2).unwrap();
        let slope = (peak(&bow, 1000.0).1 / peak(&bow, 250.0).1).ln() / 4.0_f64.ln();
        assert!((slope - 1.0 / 3.0).abs() < 0.01, "slope {slope}");
    }

    /// Difference of the means over the fringes from the rays; measured worst 0.024.
    const MEAN_TOLERANCE: f64 = 0.05;

    #[test]
    fn fringes_average_to_the_rays_far_inside() {
        for (p, from_deg, to_deg) in [(2, 140, 178), (3, 61, 127)] {
            let bow = AiryBow::new(RED_INDEX, p).unwrap();
            let rays = GeometricOrder::new(RED_INDEX, p).unwrap();
            for center_deg in from_deg..=to_deg {
                // A Hann window of 1.2 degrees to either side.
                let (mut wave, mut ray) = (0.0, 0.0);
                for step in -1000..1000 {
                    let part = f64::from(step) / 1000.0;
                    let weight = (0.5 * PI * part).cos().powi(2);
                    let theta_deg = f64::from(center_deg) + 1.2 * part;
                    wave += weight * unpolarized(&bow, 1500.0, theta_deg);
                    let [s, p] = rays.normalized_cross_section(Radians::from_degrees(theta_deg));
                    ray += weight * 0.5 * (s + p);
                }
                let ratio = wave / ray;
                let off = (ratio - 1.0).abs();
                assert!(
                    off < MEAN_TOLERANCE,
                    "p = {p}, {center_deg} deg: ratio {ratio}"
                );
            }
        }
    }

    #[test]
    fn the_mean_over_the_fringes_is_that_of_the_rays_at_the_caustic() {
        // The closed form of the mean is the leading term of the rays as D approaches D_R.
        for p in [2, 3, 5] {
            let bow = AiryBow::new(RED_INDEX, p).unwrap();
            let rays = GeometricOrder::new(RED_INDEX, p).unwrap();
            let beyond_rad = 0.05_f64.to_radians();
            let theta_rad = bow.ray().theta_rad() + bow.ray().bright_side() * beyond_rad;
            let spread = bow.ray().incidence_rad.sin() / theta_rad.sin();
            let mean = fringe_mean(beyond_rad, bow.ray().wavefront_h)
                * spread
                * bow.ray().amplitudes[0].powi(2);
            let ratio = rays.normalized_cross_section(Radians(theta_rad))[0] / mean;
            assert!((ratio - 1.0).abs() < 6e-3, "p = {p}: {ratio}");
        }
    }

    #[test]
    fn every_angle_and_size_gives_a_finite_value_that_is_not_negative() {
        for p in [2, 3, 4, 5, 6, 7] {
            let bow = AiryBow::new(RED_INDEX, p).unwrap();
            for radius_um in [1.0, 10.0, 1500.0] {
                for theta_deg in [0.0, 1e-7, 30.0, 128.0, 138.0, 165.0, 179.999_999, 180.0] {
                    let t = unpolarized(&bow, radius_um, theta_deg);
                    assert!(
                        t.is_finite() && t >= 0.0,
                        "p = {p}, {radius_um} um, {theta_deg} deg: {t}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_published_form_meets_the_absolute_one_where_it_is_scaled_and_leaves_it_elsewhere() {
        let bow = AiryBow::new(RED_INDEX, 2).unwrap();
        let theta = Radians(bow.ray().theta_rad());
        let ratio = |radius_um, wavelength_nm| {
            let (radius, wavelength) = (Micrometers(radius_um), Nanometers(wavelength_nm));
            bow.published(radius, wavelength, theta, airy_squares)[0]
                / bow
                    .direction(theta)
                    .normalized_cross_section(radius, wavelength, airy_squares)[0]
        };
        assert!((ratio(100.0, 550.0) - 1.0).abs() < 1e-12);
        // The missing factor is a λ.
        assert!((ratio(1000.0, 550.0) - 0.1).abs() < 1e-12);
        assert!((ratio(100.0, 700.0) - 550.0 / 700.0).abs() < 1e-12);
    }
}
