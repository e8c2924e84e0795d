//! One order of scattering from the one before: moments of the light at every node.
//!
//! X_lm(h, z_s) = sum over directions of  w Y_lm(mu) cos(m phi) L(mu, phi)
//! L(mu, phi) = sum over crossings k of W_k  sum over l, m of q_l Y_lm(mu_k) cos(m phi_k) X'_lm(h_k, z_k)
//!            + T_ground A/pi F'(z_k)
//! `X'` moments of the order before with the expansion weights in them, `F'` its irradiance on the
//! ground. At every crossing the sun stands at another zenith angle z_k and azimuth phi_k: the sphere
//! is taken as it is. Directions: Gauss-Legendre nodes above and below the horizon, crowded at it,
//! and even azimuths on one side of the sun.

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use rayon::iter::IntoParallelIterator;
use rayon::iter::ParallelIterator;

use crate::gauss_legendre::Rule;
use crate::leg::RayPoint;
use crate::multiple_scattering::harmonics::cosines_of_multiples;
use crate::multiple_scattering::harmonics::harmonics;
use crate::multiple_scattering::harmonics::moment;
use crate::multiple_scattering::harmonics::n_moments;
use crate::multiple_scattering::shell_path::ShellPath;
use crate::multiple_scattering::sun_axis::SunAxis;
use crate::view_ray::ViewRay;

/// Light at every node: `[shell][sun][moment][wavelength]`, and on the ground: `[sun][wavelength]`.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    // f32: the solution is good to 1e-3.
    pub(crate) moments: Vec<f32>,
    pub(crate) on_ground: Vec<f32>,
}

/// What sends light along rays: the light of the order before, times what the air makes of it.
pub(crate) struct Source<'a> {
    pub(crate) axis: &'a SunAxis,
    pub(crate) light: Light,
}

/// One direction from one shell.
struct Direction {
    height_m: f64,
    cos_zenith: f64,
    weight: f64,
    harmonics: Vec<f64>,
    path: ShellPath,
}

/// All directions from all shells.
pub(crate) struct Gathering<'a> {
    planet: Planet,
    shells_m: &'a [f64],
    max_degree: usize,
    n_wavelengths: usize,
    azimuths: Vec<f64>,
    /// `[shell][direction]`
    directions: Vec<Vec<Direction>>,
}

impl<'a> Gathering<'a> {
    /// Follows the rays of every shell once for all orders.
    pub(crate) fn new(
        air: &AtmosphereTable,
        shells_m: &'a [f64],
        max_degree: usize,
        [n_zeniths, n_azimuths]: [usize; 2],
    ) -> Self {
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let rule = Rule::new(n_zeniths);
        let directions_at = |&height_m: &f64| {
            let directions = cosines(planet, height_m, &rule).into_iter();
            directions
                .map(|(cos_zenith, weight)| Direction {
                    height_m,
                    cos_zenith,
                    weight,
                    harmonics: harmonics(max_degree, cos_zenith),
                    path: ShellPath::new(
                        air,
                        shells_m,
                        RayPoint {
                            height_m,
                            mu: cos_zenith,
                        },
                        f64::INFINITY,
                    ),
                })
                .collect()
        };
        let n_azimuths = n_azimuths.max(1);
        let azimuth = |i: usize| PI * (i as f64 + 0.5) / n_azimuths as f64;
        Self {
            planet,
            shells_m,
            max_degree,
            n_wavelengths: air.wavelengths.len(),
            azimuths: (0..n_azimuths).map(azimuth).collect(),
            directions: shells_m.iter().map(directions_at).collect(),
        }
    }

    /// The light that a source sends to the nodes over the suns of `axis`.
    pub(crate) fn gather(&self, source: &Source, axis: &SunAxis) -> Light {
        let shells: Vec<Light> = (0..self.shells_m.len())
            .into_par_iter()
            .map(|shell| self.gather_at(shell, source, axis))
            .collect();
        let on_ground = shells[0].on_ground.clone();
        let moments = shells.into_iter().flat_map(|light| light.moments).collect();
        Light { moments, on_ground }
    }

    fn gather_at(&self, shell: usize, source: &Source, axis: &SunAxis) -> Light {
        let n = self.n_wavelengths;
        let n_moments = n_moments(self.max_degree);
        let mut light = Light {
            moments: vec![0.0; axis.len() * n_moments * n],
            on_ground: vec![0.0; axis.len() * n],
        };
        let azimuth_weight = 2.0 * PI / self.azimuths.len() as f64;
        let mut radiance = vec![0.0_f32; axis.len() * self.azimuths.len() * n];
        let mut by_order = vec![0.0_f32; (self.max_degree + 1) * n];
        for direction in &self.directions[shell] {
            self.radiances(direction, source, axis, &mut radiance);
            let weight = direction.weight * azimuth_weight;
            let rows = radiance.chunks(self.azimuths.len() * n);
            for (sun, rows) in rows.enumerate() {
                self.to_orders(rows, &mut by_order);
                let block = &mut light.moments[sun * n_moments * n..(sun + 1) * n_moments * n];
                for l in 0..=self.max_degree {
                    for m in 0..=l {
                        let pair = moment(l, m);
                        let factor = (weight * direction.harmonics[pair]) as f32;
                        let target = &mut block[pair * n..(pair + 1) * n];
                        add_scaled(target, factor, &by_order[m * n..(m + 1) * n]);
                    }
                }
                if direction.cos_zenith > 0.0 {
                    let target = &mut light.on_ground[sun * n..(sun + 1) * n];
                    let factor = (weight * direction.cos_zenith) as f32;
                    add_scaled(target, factor, &by_order[..n]);
                }
            }
        }
        light
    }

    /// Sums over azimuth of the radiance times cos(m phi).
    fn to_orders(&self, rows: &[f32], by_order: &mut [f32]) {
        by_order.fill(0.0);
        let n = self.n_wavelengths;
        for (row, azimuth) in rows.chunks(n).zip(&self.azimuths) {
            for (m, target) in by_order.chunks_mut(n).enumerate() {
                add_scaled(target, (m as f64 * azimuth).cos() as f32, row);
            }
        }
    }

    /// Radiance from one direction: `[sun][azimuth][wavelength]`.
    fn radiances(
        &self,
        direction: &Direction,
        source: &Source,
        axis: &SunAxis,
        radiance: &mut [f32],
    ) {
        radiance.fill(0.0);
        let n = self.n_wavelengths;
        let n_moments = n_moments(self.max_degree);
        let n_orders = self.max_degree + 1;
        let mut towards = vec![0.0_f32; source.axis.len() * n_orders * n];
        for (at, crossing) in direction.path.crossings.iter().enumerate() {
            let Some(crossed) = crossing.shell else {
                continue;
            };
            let weights = &direction.path.weights[at * n..(at + 1) * n];
            let y = harmonics(self.max_degree, crossing.point.mu);
            let block = source.axis.len() * n_moments * n;
            let light = &source.light.moments[crossed * block..(crossed + 1) * block];
            towards.fill(0.0);
            let suns = towards
                .chunks_mut(n_orders * n)
                .zip(light.chunks(n_moments * n));
            for (orders, moments) in suns {
                for l in 0..=self.max_degree {
                    for m in 0..=l {
                        let pair = moment(l, m);
                        let target = &mut orders[m * n..(m + 1) * n];
                        add_scaled(target, y[pair] as f32, &moments[pair * n..(pair + 1) * n]);
                    }
                }
                for row in orders.chunks_mut(n) {
                    for (value, weight) in row.iter_mut().zip(weights) {
                        *value *= weight;
                    }
                }
            }
            let point = crossing.point;
            self.each_sun(direction, axis, crossing.distance_m, |row, ray| {
                let [_, mu_s] = ray.sun_at(self.planet, crossing.distance_m);
                let Some((low, share)) = source.axis.place(mu_s) else {
                    return;
                };
                let mut cosines = Vec::with_capacity(n_orders);
                let cos_phi = cos_azimuth(point.mu, mu_s, ray.cos_scattering);
                cosines_of_multiples(self.max_degree, cos_phi, &mut cosines);
                let target = &mut radiance[row * n..(row + 1) * n];
                for (m, cosine) in cosines.into_iter().enumerate() {
                    let cosine = cosine as f32;
                    let from = (low * n_orders + m) * n;
                    let to = from + n_orders * n;
                    let pairs = towards[from..from + n].iter().zip(&towards[to..to + n]);
                    let (near, far) = (cosine * (1.0 - share), cosine * share);
                    for (target, (a, b)) in target.iter_mut().zip(pairs) {
                        *target += near * a + far * b;
                    }
                }
            });
        }
        if let Some((ground_m, transmittance)) = &direction.path.ground {
            let on_ground = &source.light.on_ground;
            self.each_sun(direction, axis, *ground_m, |row, ray| {
                let [_, mu_s] = ray.sun_at(self.planet, *ground_m);
                let Some((low, share)) = source.axis.place(mu_s) else {
                    return;
                };
                let target = &mut radiance[row * n..(row + 1) * n];
                let pairs = on_ground[low * n..(low + 1) * n]
                    .iter()
                    .zip(&on_ground[(low + 1) * n..(low + 2) * n])
                    .zip(transmittance);
                for (target, ((a, b), transmittance)) in target.iter_mut().zip(pairs) {
                    *target += transmittance * (a * (1.0 - share) + b * share);
                }
            });
        }
    }

    /// Calls `f` with the row of the radiance and the ray for every sun and azimuth.
    fn each_sun(
        &self,
        direction: &Direction,
        axis: &SunAxis,
        length_m: f64,
        mut f: impl FnMut(usize, &ViewRay),
    ) {
        let mu = direction.cos_zenith;
        let sin = safe_sqrt((1.0 - mu) * (1.0 + mu));
        for (sun, &mu_s) in axis.cosines().iter().enumerate() {
            let sin_s = safe_sqrt((1.0 - mu_s) * (1.0 + mu_s));
            for (i, azimuth) in self.azimuths.iter().enumerate() {
                let ray = ViewRay {
                    height_m: direction.height_m,
                    cos_zenith: mu,
                    length_m,
                    cos_sun_zenith: mu_s,
                    cos_scattering: (mu * mu_s + sin * sin_s * azimuth.cos()).clamp(-1.0, 1.0),
                };
                f(sun * self.azimuths.len() + i, &ray);
            }
        }
    }
}

/// Cosine of the azimuth between a direction and the sun, from the cosines of both zenith angles and
/// of the angle between them; 1 where there is no azimuth, and nothing depends on it.
pub(crate) fn cos_azimuth(mu: f64, mu_s: f64, nu: f64) -> f64 {
    let sines = safe_sqrt((1.0 - mu) * (1.0 + mu)) * safe_sqrt((1.0 - mu_s) * (1.0 + mu_s));
    if sines > 0.0 {
        ((nu - mu * mu_s) / sines).clamp(-1.0, 1.0)
    } else {
        1.0
    }
}

/// Cosines of zenith angles and their weights, which add up to 2, from a height:
/// mu = horizon + (1 - horizon) x^2 above it, and in the same way below.
fn cosines(planet: Planet, height_m: f64, rule: &Rule) -> Vec<(f64, f64)> {
    let horizon = -planet.horizon_dip(height_m).0.sin();
    let ends = [-1.0, 1.0];
    let half = |end: f64| {
        let width = end - horizon;
        let node = move |(x, weight): (f64, f64)| {
            (horizon + width * x * x, 2.0 * x * weight * width.abs())
        };
        rule.pairs().map(node).collect::<Vec<_>>()
    };
    ends.into_iter().flat_map(half).collect()
}

fn add_scaled(target: &mut [f32], factor: f32, values: &[f32]) {
    for (target, value) in target.iter_mut().zip(values) {
        *target += factor * value;
    }
}

/// The root of a number that only rounding can make negative.
fn safe_sqrt(square: f64) -> f64 {
    if square > 0.0 { square.sqrt() } else { 0.0 }
}
