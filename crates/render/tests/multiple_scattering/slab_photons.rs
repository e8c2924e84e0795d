//! Photons in a slab of drops, followed one by one: all orders of scattering with the whole extinction
//! (Q = 2) and the light diffracted forward, written down from first principles.
//!
//! Sunlight falls in from straight above. A photon flies an exponential optical depth, then half of
//! the time it is diffracted into the pattern of a round hole, (2 J1(x)/x)², x = k r sin(psi), else
//! scattered by the phase function. At each drop it shows itself to every view direction. What would
//! then be diffracted on its way out stays in the picture: the view is turned by as many draws of the
//! pattern as a Poisson law gives, which is how often that happens at half of the optical depth.

use std::f64::consts::PI;
use std::f64::consts::TAU;

/// A slab and how it is looked at.
pub(crate) struct Slab<'a> {
    /// Optical depth at Q = 2.
    pub(crate) depth: f64,
    /// Phase function without diffraction, of integral 1.
    pub(crate) phase_sr1: &'a dyn Fn(f64) -> f64,
    /// 2 pi r / lambda.
    pub(crate) size_parameter: f64,
    /// Angles of the views from above to straight down.
    pub(crate) view_angles_deg: &'a [f64],
    pub(crate) n_photons: u32,
}

/// Numbers of a linear congruential generator with 64 bits (Knuth's MMIX), the upper 53 used.
struct Dice(u64);

impl Dice {
    fn throw(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number of events whose mean is `mean`: exponential waits until it is over.
    fn poisson(&mut self, mean: f64) -> usize {
        let mut waited = -(1.0 - self.throw()).ln();
        let mut n = 0;
        while waited < mean {
            waited -= (1.0 - self.throw()).ln();
            n += 1;
        }
        n
    }
}

/// A cumulative distribution on even steps, ending with 1.
struct Distribution {
    step: f64,
    cumulative: Vec<f64>,
}

impl Distribution {
    fn of(density: impl Fn(f64) -> f64, end: f64, n: usize) -> Self {
        let step = end / n as f64;
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = (0..n)
            .map(|index| {
                sum += density((index as f64 + 0.5) * step);
                sum
            })
            .collect();
        for value in &mut cumulative {
            *value /= sum;
        }
        Self { step, cumulative }
    }

    fn draw(&self, dice: &mut Dice) -> f64 {
        let u = dice.throw();
        let index = self.cumulative.partition_point(|value| *value <= u);
        (index as f64 + dice.throw()) * self.step
    }
}

/// J1 by Bessel's integral.
fn bessel_j1(x: f64) -> f64 {
    let n = 200 + x as usize;
    (0..n)
        .map(|index| PI * (index as f64 + 0.5) / n as f64)
        .map(|t| (t - x * t.sin()).cos())
        .sum::<f64>()
        / n as f64
}

/// Direction with a cosine to the old one and a random azimuth.
fn turn([x, y, z]: [f64; 3], angle: f64, azimuth: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let (s, c) = azimuth.sin_cos();
    let across = (1.0 - z * z).sqrt();
    if across < 1e-9 {
        return [sin * c, sin * s, z.signum() * cos];
    }
    [
        x * cos + sin * (x * z * c - y * s) / across,
        y * cos + sin * (y * z * c + x * s) / across,
        z * cos - sin * c * across,
    ]
}

/// Radiance over irradiance for each view [1/sr].
pub(crate) fn all_orders(slab: &Slab) -> Vec<f64> {
    let turns = Distribution::of(|theta| theta.sin() * (slab.phase_sr1)(theta), PI, 20_000);
    // 99.7 % of the light is within x = 200.
    let pattern = Distribution::of(|x| bessel_j1(x).powi(2) / x, 200.0, 8_000);
    let spread = |dice: &mut Dice| {
        let sine = pattern.draw(dice) / slab.size_parameter;
        sine.min(1.0).asin()
    };
    let n_cells = 7_200;
    let phase: Vec<f64> = (0..n_cells)
        .map(|cell| (slab.phase_sr1)((f64::from(cell) + 0.5) * PI / f64::from(n_cells)))
        .collect();
    let mut dice = Dice(20_241_121);
    let mut sums = vec![0.0; slab.view_angles_deg.len()];
    for _ in 0..slab.n_photons {
        let (mut depth, mut direction) = (0.0, [0.0, 0.0, 1.0]);
        loop {
            depth -= direction[2] * (1.0 - dice.throw()).ln();
            if !(0.0..=slab.depth).contains(&depth) {
                break;
            }
            let azimuth = TAU * dice.throw();
            for (sum, angle_deg) in sums.iter_mut().zip(slab.view_angles_deg) {
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                let to_eye = [sin * azimuth.cos(), sin * azimuth.sin(), -cos];
                let out = 0.5 * depth / cos;
                let to_eye = (0..dice.poisson(out)).fold(to_eye, |to_eye, _| {
                    turn(to_eye, spread(&mut dice), TAU * dice.throw())
                });
                let cosine: f64 = (0..3).map(|axis| to_eye[axis] * direction[axis]).sum();
                let cell = cosine.clamp(-1.0, 1.0).acos() / PI * f64::from(n_cells);
                let scattered = phase[(cell as usize).min(phase.len() - 1)];
                *sum += 0.5 * scattered * (-out).exp() / cos;
            }
            let angle = if dice.throw() < 0.5 {
                (pattern.draw(&mut dice) / slab.size_parameter)
                    .min(1.0)
                    .asin()
            } else {
                turns.draw(&mut dice)
            };
            direction = turn(direction, angle, TAU * dice.throw());
        }
    }
    let n = f64::from(slab.n_photons);
    sums.into_iter().map(|sum| sum / n).collect()
}
