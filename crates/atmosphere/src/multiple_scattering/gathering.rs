//! One order of scattering from the one before: moments of the light at every node.
//!
//! X_lm(h, z_s) = sum over directions of  w Y_lm(mu) cos(m phi) L(mu, phi)
//! L(mu, phi) = sum over crossings k of W_k  sum over l, m of q_l Y_lm(mu_k) cos(m phi_k) X'_lm(h_k, z_k)
//!            + T_ground A/pi F'(z_k)
//! `X'` moments of the order before with the expansion weights in them, `F'` its irradiance on the
//! ground. At every crossing the sun stands at another zenith angle z_k and azimuth phi_k: the sphere
//! is taken as it is. Directions: Gauss-Legendre nodes above and below the horizon, crowded at it,
//! and even azimuths on one side of the sun, one more than the largest order m: products of two
//! harmonics are then integrated exactly.

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_exchange::DiffuseView;
use niji_exchange::cosines_of_multiples;
use niji_exchange::harmonics;
use niji_exchange::moment_index;
use niji_exchange::n_moments;
use niji_geometry::Planet;
use rayon::iter::IntoParallelIterator;
use rayon::iter::ParallelIterator;

use crate::gauss_legendre::Rule;
use crate::leg::RayPoint;
use crate::multiple_scattering::light::Light;
use crate::multiple_scattering::light::add_scaled;
use crate::multiple_scattering::shell_path::ShellPath;
use crate::multiple_scattering::sun_axis::SunAxis;

/// One direction from one shell.
pub(crate) struct Direction {
    pub(crate) height_m: f64,
    pub(crate) cos_zenith: f64,
    pub(crate) weight: f64,
    pub(crate) path: ShellPath,
}

/// All directions from all shells.
pub(crate) struct Directions {
    planet: Planet,
    n_wavelengths: usize,
    /// `[shell][direction]`
    by_shell: Vec<Vec<Direction>>,
}

/// Radiances from one direction, `[sun][azimuth][wavelength]`, into moments.
pub(crate) struct Azimuths {
    max_degree: usize,
    max_order: usize,
    cos_azimuth: Vec<f64>,
    /// cos(m phi): `[azimuth][m]`.
    // f32: as the light.
    cosines: Vec<f32>,
}

/// Every sun of an axis with every azimuth of its directions: the rows of a radiance.
#[derive(Clone, Copy)]
pub(crate) struct SunSides<'a> {
    pub(crate) axis: &'a SunAxis,
    pub(crate) azimuths: &'a Azimuths,
}

/// A sun and an azimuth, as they are seen from the start of a direction.
#[derive(Clone, Copy)]
pub(crate) struct SunSide {
    /// Row of the radiance.
    pub(crate) row: usize,
    cos_sun_zenith: f64,
    /// Of the scattering angle, one for the whole ray.
    pub(crate) cos_scattering: f64,
}

/// A shell where a ray crosses it.
#[derive(Clone, Copy)]
struct CrossedShell<'a> {
    shell: usize,
    /// Cosine of the zenith angle of the ray there.
    mu: f64,
    /// What its source counts on the ray, by wavelength.
    weights: &'a [f32],
}

/// Where the suns stand farther along a ray: mu_s(s) = (r0 mu_s + s nu)/r.
#[derive(Clone, Copy)]
pub(crate) struct SunShift {
    /// r0/r and s/r.
    shares: [f64; 2],
}

impl Directions {
    /// Follows the rays of every shell once for all orders.
    pub(crate) fn new(air: &AtmosphereTable, shells_m: &[f64], n_zeniths: usize) -> Self {
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let rule = Rule::new(n_zeniths);
        let by_shell = shells_m
            .iter()
            .map(|&height_m| directions(air, shells_m, height_m, &rule))
            .collect();
        Self {
            planet,
            n_wavelengths: air.wavelengths.len(),
            by_shell,
        }
    }

    /// The light that a source sends to the nodes over the suns of `axis`.
    ///
    /// # Errors
    /// What `go_on` says.
    pub(crate) fn gather<E: Send>(
        &self,
        source: &Light,
        axis: &SunAxis,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Light, E> {
        let azimuths = Azimuths::new(source.max_degree, source.max_order);
        let sides = SunSides {
            axis,
            azimuths: &azimuths,
        };
        gather_shells(self.by_shell.len(), go_on, |shell| {
            let mut light = azimuths.dark(axis, self.n_wavelengths);
            let mut radiance = vec![0.0_f32; sides.len() * self.n_wavelengths];
            for direction in &self.by_shell[shell] {
                self.radiances(direction, source, sides, &mut radiance);
                azimuths.add(direction, &radiance, &mut light);
            }
            light
        })
    }

    /// Radiance from one direction.
    fn radiances(
        &self,
        direction: &Direction,
        source: &Light,
        sides: SunSides,
        radiance: &mut [f32],
    ) {
        radiance.fill(0.0);
        let n = self.n_wavelengths;
        let n_orders = source.max_order + 1;
        let axis = sides.axis;
        let mut towards = vec![0.0_f32; axis.len() * n_orders * n];
        let mut cosines = vec![0.0; n_orders];
        for (at, crossing) in direction.path.crossings.iter().enumerate() {
            let Some(shell) = crossing.shell else {
                continue;
            };
            let mu = crossing.point.mu;
            let weights = &direction.path.weights[at * n..(at + 1) * n];
            let crossed = CrossedShell { shell, mu, weights };
            write_source_by_order(source, crossed, &mut towards);
            let shift = SunShift::new(self.planet, direction, crossing.distance_m);
            sides.each(direction, |side| {
                let mu_s = shift.cos_sun_zenith(side);
                let Some((low, share)) = axis.place(mu_s) else {
                    return;
                };
                let view = DiffuseView {
                    cos_zenith: mu,
                    cos_sun_zenith: mu_s,
                    cos_scattering: side.cos_scattering,
                };
                cosines_of_multiples(view.cos_azimuth(), &mut cosines);
                let target = &mut radiance[side.row * n..(side.row + 1) * n];
                for (m, cosine) in cosines.iter().enumerate() {
                    let cosine = *cosine as f32;
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
            let on_ground = &source.on_ground;
            let shift = SunShift::new(self.planet, direction, *ground_m);
            sides.each(direction, |side| {
                let Some((low, share)) = axis.place(shift.cos_sun_zenith(side)) else {
                    return;
                };
                let target = &mut radiance[side.row * n..(side.row + 1) * n];
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
}

impl Azimuths {
    /// As many as an order m needs.
    pub(crate) fn new(max_degree: usize, max_order: usize) -> Self {
        let n = max_order + 1;
        let azimuth_rad = |i: usize| PI * (i as f64 + 0.5) / n as f64;
        let cosines = |i: usize| (0..n).map(move |m| (m as f64 * azimuth_rad(i)).cos() as f32);
        Self {
            max_degree,
            max_order,
            cos_azimuth: (0..n).map(|i| azimuth_rad(i).cos()).collect(),
            cosines: (0..n).flat_map(cosines).collect(),
        }
    }

    /// Number of azimuths.
    pub(crate) fn len(&self) -> usize {
        self.cos_azimuth.len()
    }

    /// No light at one shell.
    pub(crate) fn dark(&self, axis: &SunAxis, n_wavelengths: usize) -> Light {
        Light {
            max_degree: self.max_degree,
            max_order: self.max_order,
            n_suns: axis.len(),
            n_wavelengths,
            moments: vec![0.0; axis.len() * n_moments(self.max_degree) * n_wavelengths],
            on_ground: vec![0.0; axis.len() * n_wavelengths],
        }
    }

    /// Adds the moments of the radiance from one direction to the light of its shell.
    pub(crate) fn add(&self, direction: &Direction, radiance: &[f32], light: &mut Light) {
        let n = light.n_wavelengths;
        let n_moments = n_moments(self.max_degree);
        let weight = direction.weight * 2.0 * PI / self.len() as f64;
        let y = harmonics(self.max_degree, direction.cos_zenith);
        let mut by_order = vec![0.0_f32; (self.max_order + 1) * n];
        for (sun, rows) in radiance.chunks(self.len() * n).enumerate() {
            self.to_orders(rows, &mut by_order);
            let block = &mut light.moments[sun * n_moments * n..(sun + 1) * n_moments * n];
            for l in 0..=self.max_degree {
                for m in 0..=l.min(self.max_order) {
                    let pair = moment_index(l, m);
                    let target = &mut block[pair * n..(pair + 1) * n];
                    let factor = (weight * y[pair]) as f32;
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

    /// Sums over azimuth of the radiance times cos(m phi).
    fn to_orders(&self, rows: &[f32], by_order: &mut [f32]) {
        by_order.fill(0.0);
        let n = by_order.len() / (self.max_order + 1);
        for (row, cosines) in rows.chunks(n).zip(self.cosines.chunks(self.len())) {
            for (target, cosine) in by_order.chunks_mut(n).zip(cosines) {
                add_scaled(target, *cosine, row);
            }
        }
    }
}

impl SunSides<'_> {
    /// Number of rows.
    pub(crate) fn len(self) -> usize {
        self.axis.len() * self.azimuths.len()
    }

    /// Calls `f` for every sun and azimuth around a direction.
    pub(crate) fn each(self, direction: &Direction, mut f: impl FnMut(SunSide)) {
        let mu = direction.cos_zenith;
        let sin = safe_sqrt((1.0 - mu) * (1.0 + mu));
        let mut row = 0;
        for &mu_s in self.axis.cosines() {
            let sin_s = safe_sqrt((1.0 - mu_s) * (1.0 + mu_s));
            for cos_azimuth in &self.azimuths.cos_azimuth {
                f(SunSide {
                    row,
                    cos_sun_zenith: mu_s,
                    cos_scattering: (mu * mu_s + sin * sin_s * cos_azimuth).clamp(-1.0, 1.0),
                });
                row += 1;
            }
        }
    }
}

impl SunShift {
    pub(crate) fn new(planet: Planet, direction: &Direction, distance_m: f64) -> Self {
        let (height_m, mu) = (direction.height_m, direction.cos_zenith);
        let r_m = planet.radius_m + planet.height_along_ray(height_m, mu, distance_m);
        let r0_m = planet.radius_m + height_m;
        Self {
            shares: [r0_m / r_m, distance_m / r_m],
        }
    }

    /// Cosine of the sun's zenith angle there.
    pub(crate) fn cos_sun_zenith(self, side: SunSide) -> f64 {
        let [here, along] = self.shares;
        (here * side.cos_sun_zenith + along * side.cos_scattering).clamp(-1.0, 1.0)
    }
}

/// Gathers shells in parallel and puts them together in their order; the first stands on the ground.
///
/// # Errors
/// What `go_on` says.
pub(crate) fn gather_shells<E: Send>(
    n_shells: usize,
    go_on: impl Fn() -> Result<(), E> + Sync,
    at_shell: impl Fn(usize) -> Light + Sync,
) -> Result<Light, E> {
    let shells = (0..n_shells).into_par_iter().map(|shell| {
        go_on()?;
        Ok(at_shell(shell))
    });
    let shells: Vec<Light> = shells.collect::<Result<_, E>>()?;
    let on_ground = shells[0].on_ground.clone();
    let first = Light {
        moments: Vec::new(),
        on_ground,
        ..shells[0]
    };
    let moments = shells.into_iter().flat_map(|light| light.moments);
    Ok(Light {
        moments: moments.collect(),
        ..first
    })
}

/// The directions of a height, followed through shells.
pub(crate) fn directions(
    air: &AtmosphereTable,
    shells_m: &[f64],
    height_m: f64,
    rule: &Rule,
) -> Vec<Direction> {
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    let direction = |(cos_zenith, weight)| {
        let start = RayPoint {
            height_m,
            mu: cos_zenith,
        };
        Direction {
            height_m,
            cos_zenith,
            weight,
            path: ShellPath::new(air, shells_m, start, f64::INFINITY),
        }
    };
    let cosines = cosines(planet, height_m, rule).into_iter();
    cosines.map(direction).collect()
}

/// Source of a shell along a ray that crosses it, times the weights of the crossing: `[sun][order m]
/// [wavelength]`.
fn write_source_by_order(source: &Light, crossed: CrossedShell, towards: &mut [f32]) {
    let n = source.n_wavelengths;
    let n_orders = source.max_order + 1;
    let y = harmonics(source.max_degree, crossed.mu);
    towards.fill(0.0);
    let suns = towards
        .chunks_mut(n_orders * n)
        .zip(source.at_shell(crossed.shell).chunks(source.block()));
    for (orders, moments) in suns {
        for l in 0..=source.max_degree {
            for m in 0..=l.min(source.max_order) {
                let pair = moment_index(l, m);
                let target = &mut orders[m * n..(m + 1) * n];
                add_scaled(target, y[pair] as f32, &moments[pair * n..(pair + 1) * n]);
            }
        }
        for row in orders.chunks_mut(n) {
            for (value, weight) in row.iter_mut().zip(crossed.weights) {
                *value *= weight;
            }
        }
    }
}

/// Cosines of zenith angles and their weights, which add up to 2, from a height:
/// mu = horizon + (1 - horizon) x^2 above it, and in the same way below.
fn cosines(planet: Planet, height_m: f64, rule: &Rule) -> Vec<(f64, f64)> {
    let horizon = -planet.horizon_dip(height_m).0.sin();
    let half = |end: f64| {
        let width = end - horizon;
        let node = move |(x, weight): (f64, f64)| {
            (horizon + width * x * x, 2.0 * x * weight * width.abs())
        };
        rule.pairs().map(node).collect::<Vec<_>>()
    };
    [-1.0, 1.0].into_iter().flat_map(half).collect()
}

/// The root of a number that only rounding can make negative.
fn safe_sqrt(square: f64) -> f64 {
    if square > 0.0 { square.sqrt() } else { 0.0 }
}
