//! Sunlight that the air scatters once into a view ray.
//!
//! L(lambda) = E_sun(lambda) * integral over s of
//!     sum over constituents of beta rho(h) P(theta)  *  exp(-tau_view(s) - tau_sun(s))  ds
//! `beta` scattering coefficient at density 1, `P` phase function [1/sr]. With a distant sun theta is
//! one angle for the whole ray. Points in the planet's shadow receive nothing.
//!
//! Lengths are found once for all wavelengths; the optical depth on the view ray comes from the
//! running integral of the same samples. A leg on which the view ray's optical depth exceeds
//! `PANEL_DEPTH` at any wavelength is cut where it does, so that thick haze is resolved too.
//! [N93] Nishita, Sirai, Tadamura and Nakamae, SIGGRAPH 93, 175-182 (1993): the published sum.

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::gauss_legendre::Rule;
use crate::leg::Leg;
use crate::leg::RayPoint;
use crate::leg::legs;
use crate::optical_length::length_by_midpoints;
use crate::view_ray::ViewRay;

/// Optical depth up to which one panel of nodes is enough.
const PANEL_DEPTH: f64 = 4.0;
/// Optical depth beyond which nothing reaches the eye: e^-60 = 9e-27.
const BLACK_DEPTH: f64 = 60.0;
/// Most cuts of one leg.
const MAX_CUTS: usize = 200;

/// How the integral along the view ray is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InScattering {
    /// The published sum: equal steps on the view ray, and as many on every sun ray. With 50 steps
    /// the error on whole-sky rays is up to 1.7e-2, and falls with the square of their number.
    Midpoint {
        /// Number of steps on either ray, at least 1.
        n_steps: usize,
    },
    /// Gauss-Legendre quadrature with s = D u^2; the sun's path from the table. With 12 nodes the
    /// error on whole-sky rays is at most 3.5e-5, with 16 nodes 2.7e-7.
    Quadrature {
        /// Number of nodes on every leg, at least 1.
        n_nodes: usize,
    },
}

/// Light along a view ray.
#[derive(Debug, Clone, PartialEq)]
pub struct AirLight {
    /// Radiance scattered into the ray, W m^-2 sr^-1 nm^-1.
    pub radiance: Vec<f64>,
    /// Share of the light that passes the whole ray; below 1e-26 only a bound.
    pub transmittance: Vec<f64>,
}

/// Solves view rays through one air at one level of accuracy.
#[derive(Debug, Clone)]
pub struct SingleScattering<'a> {
    air: &'a AtmosphereTable,
    planet: Planet,
    method: InScattering,
    rule: Rule,
}

impl<'a> SingleScattering<'a> {
    /// A solver for one air.
    pub fn new(air: &'a AtmosphereTable, method: InScattering) -> Self {
        let n_nodes = match method {
            InScattering::Midpoint { .. } => 1,
            InScattering::Quadrature { n_nodes } => n_nodes,
        };
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        Self {
            air,
            planet,
            method,
            rule: Rule::new(n_nodes),
        }
    }

    /// The air that is solved for.
    pub fn air(&self) -> &AtmosphereTable {
        self.air
    }

    /// Light along a view ray.
    pub fn solve(&self, ray: &ViewRay) -> AirLight {
        let n_wavelengths = self.air.wavelengths.len();
        let mut sum = Sum {
            radiance: vec![0.0; n_wavelengths],
            depth: vec![0.0; n_wavelengths],
            scattering_sr1_m1: self.directed_scattering(ray),
        };
        if let Some(ends_m) = ray.in_air(self.planet, self.air.top_height_m) {
            match self.method {
                InScattering::Midpoint { n_steps } => self.march(ray, ends_m, n_steps, &mut sum),
                InScattering::Quadrature { .. } => {
                    let walls_m = ray.shadow_walls(self.planet);
                    for leg in legs(self.planet, ray.start(), ends_m, &walls_m) {
                        self.add_leg(ray, leg, &mut sum);
                    }
                }
            }
        }
        let lit = sum.radiance.iter().zip(&self.air.sun_irradiance);
        AirLight {
            radiance: lit.map(|(per_sun, sun)| per_sun * sun).collect(),
            transmittance: sum.depth.iter().map(|depth| (-depth).exp()).collect(),
        }
    }

    /// beta P(theta) of every constituent, one row of wavelengths each.
    fn directed_scattering(&self, ray: &ViewRay) -> Vec<Vec<f64>> {
        let theta = Radians(ray.cos_scattering.clamp(-1.0, 1.0).acos());
        let row = |constituent: &niji_exchange::AirConstituent| {
            let spectrum = constituent.scattering_m1.iter().enumerate();
            spectrum
                .map(|(index, &scattering_m1)| {
                    // No phase function is asked for where nothing is scattered.
                    if scattering_m1 > 0.0 {
                        scattering_m1 * constituent.phase_at(index, theta.0)
                    } else {
                        0.0
                    }
                })
                .collect()
        };
        self.air.constituents.iter().map(row).collect()
    }

    /// The published sum (N93, eq. 8).
    fn march(&self, ray: &ViewRay, [enter_m, end_m]: [f64; 2], n_steps: usize, sum: &mut Sum) {
        let n_steps = n_steps.max(1);
        let step_m = (end_m - enter_m) / n_steps as f64;
        let constituents = &self.air.constituents;
        let mut view_m = vec![0.0; constituents.len()];
        let mut sample = Sample::new(constituents.len());
        for step in 0..n_steps {
            let distance_m = enter_m + (step as f64 + 0.5) * step_m;
            let [height_m, mu_s] = ray.sun_at(self.planet, distance_m);
            let is_lit = !self.planet.hits_ground(height_m, mu_s);
            let sun = RayPoint { height_m, mu: mu_s };
            for (index, constituent) in constituents.iter().enumerate() {
                let density = constituent.density_at(height_m);
                sample.density[index] = density;
                // To the middle of the step, where the sample stands.
                sample.view_m[index] = view_m[index] + 0.5 * step_m * density;
                view_m[index] += step_m * density;
                if is_lit {
                    sample.sun_m[index] =
                        length_by_midpoints(constituent, self.planet, n_steps, sun);
                }
            }
            if is_lit {
                sum.add(self.air, &sample, step_m);
            }
        }
        sum.pass(self.air, &view_m);
    }

    /// One leg, cut into panels that are not too thick.
    fn add_leg(&self, ray: &ViewRay, leg: Leg, sum: &mut Sum) {
        let n = self.rule.len();
        let n_constituents = self.air.constituents.len();
        let mut densities = vec![vec![0.0; n]; n_constituents];
        // u at the near and at the far end of what is left of the leg.
        let (mut near_u, end_u) = if leg.rises { (0.0, 1.0) } else { (1.0, 0.0) };
        let mut far_u = end_u;
        for _ in 0..MAX_CUTS {
            let panel = Panel { leg, near_u, far_u };
            self.sample_densities(ray, &panel, &mut densities);
            let total_m: Vec<f64> = densities
                .iter()
                .map(|samples| self.rule.total(samples))
                .collect();
            let (thickest, depth) = self.thickest(&total_m, &sum.depth);
            if depth > 2.0 * PANEL_DEPTH {
                far_u = panel.u(self.cut(thickest, &densities));
                continue;
            }
            self.add_panel(ray, &panel, &densities, sum);
            sum.pass(self.air, &total_m);
            let is_done = (far_u - end_u).abs() <= 0.0;
            if is_done || sum.depth.iter().all(|&depth| depth > BLACK_DEPTH) {
                break;
            }
            near_u = far_u;
            far_u = end_u;
        }
    }

    /// Density times length of ray per node, in the order along the ray.
    fn sample_densities(&self, ray: &ViewRay, panel: &Panel, densities: &mut [Vec<f64>]) {
        for (node, (x, _)) in self.rule.pairs().enumerate() {
            let distance_m = panel.distance_m(x);
            let height_m = self
                .planet
                .height_along_ray(ray.height_m, ray.cos_zenith, distance_m);
            let stretch_m = panel.stretch_m(x);
            for (samples, constituent) in densities.iter_mut().zip(&self.air.constituents) {
                samples[node] = constituent.density_at(height_m) * stretch_m;
            }
        }
    }

    /// Wavelength and optical depth where equivalent lengths dim most, among the wavelengths that
    /// are not black yet.
    fn thickest(&self, lengths_m: &[f64], passed: &[f64]) -> (usize, f64) {
        let depths = (0..passed.len()).map(|wavelength| {
            let is_black = passed[wavelength] > BLACK_DEPTH;
            let constituents = self.air.constituents.iter().zip(lengths_m);
            let depth: f64 = constituents
                .map(|(air, length_m)| air.extinction_m1[wavelength] * length_m)
                .sum();
            (wavelength, if is_black { 0.0 } else { depth })
        });
        depths.fold(
            (0, 0.0),
            |most, next| if next.1 > most.1 { next } else { most },
        )
    }

    /// Where on a panel, 0 to 1, the optical depth at a wavelength reaches about `PANEL_DEPTH`.
    fn cut(&self, wavelength: usize, densities: &[Vec<f64>]) -> f64 {
        let depth_to = |node: usize| -> f64 {
            let constituents = self.air.constituents.iter().zip(densities);
            constituents
                .map(|(air, samples)| {
                    air.extinction_m1[wavelength] * self.rule.running(node, samples)
                })
                .sum()
        };
        let mut cut = f64::NAN;
        for (node, (x, _)) in self.rule.pairs().enumerate() {
            if cut.is_nan() || depth_to(node) <= PANEL_DEPTH {
                cut = x;
            } else {
                break;
            }
        }
        // Half of the way at most: the samples may have missed where the air begins.
        cut.min(0.5)
    }

    /// Scattered light of one panel.
    fn add_panel(&self, ray: &ViewRay, panel: &Panel, densities: &[Vec<f64>], sum: &mut Sum) {
        let mut sample = Sample::new(densities.len());
        for (node, (x, weight)) in self.rule.pairs().enumerate() {
            let [height_m, mu_s] = ray.sun_at(self.planet, panel.distance_m(x));
            if self.planet.hits_ground(height_m, mu_s) {
                continue;
            }
            for (index, samples) in densities.iter().enumerate() {
                sample.density[index] = samples[node];
                sample.view_m[index] = self.rule.running(node, samples);
                sample.sun_m[index] = self.air.column_at(index, height_m, mu_s);
            }
            sum.add(self.air, &sample, weight);
        }
    }
}

/// Part of a leg, from `near_u` to `far_u` on it, seen along the ray.
struct Panel {
    leg: Leg,
    near_u: f64,
    far_u: f64,
}

impl Panel {
    fn u(&self, x: f64) -> f64 {
        self.near_u + (self.far_u - self.near_u) * x
    }

    fn distance_m(&self, x: f64) -> f64 {
        self.leg.distance_m(self.u(x))
    }

    fn stretch_m(&self, x: f64) -> f64 {
        self.leg.stretch_m(self.u(x)) * (self.far_u - self.near_u).abs()
    }
}

/// What one point of the view ray contributes, by constituent.
struct Sample {
    density: Vec<f64>,
    view_m: Vec<f64>,
    sun_m: Vec<f64>,
}

impl Sample {
    fn new(n_constituents: usize) -> Self {
        let zeros = vec![0.0; n_constituents];
        Self {
            density: zeros.clone(),
            view_m: zeros.clone(),
            sun_m: zeros,
        }
    }
}

/// Running sums along a ray, by wavelength.
struct Sum {
    /// Radiance over the sun's irradiance, 1/sr.
    radiance: Vec<f64>,
    /// Optical depth passed so far.
    depth: Vec<f64>,
    /// beta P(theta) by constituent and wavelength.
    scattering_sr1_m1: Vec<Vec<f64>>,
}

impl Sum {
    /// Adds one sample. Constituents outside, wavelengths inside: the loops run over spectra.
    fn add(&mut self, air: &AtmosphereTable, sample: &Sample, weight: f64) {
        for (wavelength, radiance) in self.radiance.iter_mut().enumerate() {
            let mut depth = self.depth[wavelength];
            let mut source = 0.0;
            for (index, constituent) in air.constituents.iter().enumerate() {
                let length_m = sample.view_m[index] + sample.sun_m[index];
                depth += constituent.extinction_m1[wavelength] * length_m;
                source += self.scattering_sr1_m1[index][wavelength] * sample.density[index];
            }
            *radiance += weight * source * (-depth).exp();
        }
    }

    /// Adds what equivalent lengths, by constituent, dim.
    fn pass(&mut self, air: &AtmosphereTable, lengths_m: &[f64]) {
        for (constituent, length_m) in air.constituents.iter().zip(lengths_m) {
            for (depth, extinction_m1) in self.depth.iter_mut().zip(&constituent.extinction_m1) {
                *depth += extinction_m1 * length_m;
            }
        }
    }
}
