//! Sunlight that the air scatters once into a view ray.
//!
//! L(lambda) = E_sun(lambda) * integral over s of
//!     sum over constituents of beta rho(h) P(theta)  *  exp(-tau_view(s) - tau_sun(s))  ds
//! `beta` scattering coefficient at density 1, `P` phase function [1/sr]. With a distant sun theta is
//! one angle for the whole ray, and beta P stands before the integral (`gathered`). Points in the
//! planet's shadow receive nothing.
//!
//! Lengths are found once for all wavelengths; the optical depth on the view ray comes from the
//! running integral of the same samples.
//! [N93] Nishita, Sirai, Tadamura and Nakamae, SIGGRAPH 93, 175-182 (1993): the published sum.

mod leg_light;

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_geometry::Planet;

use crate::gathered::Gathered;
use crate::gathered::Sample;
use crate::gathered::scatters;
use crate::gauss_kronrod::rule_and_excess;
use crate::gauss_legendre::Rule;
use crate::leg::RayPoint;
use crate::leg::crossings;
use crate::leg::legs;
use crate::optical_length::length_by_midpoints;
use crate::optical_length::length_by_rule;
use crate::view_ray::ViewRay;

/// How the integral along the view ray is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InScattering {
    /// The published sum: equal steps on the view ray, and as many on every sun ray. With 50 steps
    /// the error on whole-sky rays is up to 1.7e-2, and falls with the square of their number.
    Midpoint {
        /// Number of steps on either ray, at least 1.
        n_steps: usize,
    },
    /// Gauss-Legendre quadrature with s = D u^2 on the view ray, and on every sun ray.
    Nested {
        /// Number of nodes on every leg of the view ray, at least 1.
        n_nodes: usize,
        /// Number of nodes on every leg of a sun ray, at least 1.
        n_sun_nodes: usize,
    },
    /// Gauss-Legendre quadrature with s = D u^2; the sun's path from the table. Legs end where a ray
    /// crosses the wall of the planet's shadow and the nodes of layers, and where the sun's rays graze
    /// them: with 16 nodes the error on whole-sky rays in hazy air is at most 3.3e-7 under suns from
    /// -4 to 60 degrees (2026-11-21).
    Quadrature {
        /// Number of nodes on every leg, at least 1.
        n_nodes: usize,
    },
    /// The same by 15 nodes of Kronrod, on panels that are halved until these agree with the 7 of
    /// Gauss among them.
    Adaptive {
        /// Largest relative difference; the error of the 15, which remains, is far smaller.
        tolerance: f64,
    },
}

impl InScattering {
    /// The default level: 9e-7 at worst over the whole sky, twilight and observers in space included,
    /// and 7e-7 on segments of 20 m to 500 km (2026-11-21).
    pub const STANDARD: Self = Self::Adaptive { tolerance: 1e-5 };
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
    /// By how much the weights of the rule exceed those of a coarser one; empty without one.
    excess: Vec<f64>,
    sun_rule: Rule,
    /// Heights at which the sun's columns have kinks: the ground, whose shadow begins there, and the
    /// nodes of layers of linear density.
    kinks_m: Vec<f64>,
}

impl<'a> SingleScattering<'a> {
    /// A solver for one air.
    pub fn new(air: &'a AtmosphereTable, method: InScattering) -> Self {
        let gauss = |n_nodes: usize| (Rule::new(n_nodes), Vec::new());
        let ((rule, excess), n_sun_nodes) = match method {
            InScattering::Midpoint { .. } => (gauss(1), 1),
            InScattering::Nested {
                n_nodes,
                n_sun_nodes,
            } => (gauss(n_nodes), n_sun_nodes),
            InScattering::Quadrature { n_nodes } => (gauss(n_nodes), 1),
            InScattering::Adaptive { .. } => (rule_and_excess(), 1),
        };
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        Self {
            air,
            planet,
            method,
            rule,
            excess,
            sun_rule: Rule::new(n_sun_nodes),
            kinks_m: kinks_m(air),
        }
    }

    /// The air that is solved for.
    pub fn air(&self) -> &AtmosphereTable {
        self.air
    }

    /// Light along a view ray.
    pub fn solve(&self, ray: &ViewRay) -> AirLight {
        let directed = self.directed_scattering(ray);
        let gathered = self.gather(ray, &directed);
        let mut radiance = gathered.radiance_per_sun(&directed);
        for (radiance, sun) in radiance.iter_mut().zip(&self.air.sun_irradiance) {
            *radiance *= sun;
        }
        AirLight {
            radiance,
            transmittance: gathered.transmittance(),
        }
    }

    /// beta P(theta) of every constituent, one row of wavelengths each, empty where nothing is
    /// scattered: no phase function is asked for there.
    pub(crate) fn directed_scattering(&self, ray: &ViewRay) -> Vec<Vec<f64>> {
        let theta_rad = ray.cos_scattering.clamp(-1.0, 1.0).acos();
        let row = |constituent: &AirConstituent| {
            if !scatters(constituent) {
                return Vec::new();
            }
            let phase_sr1 = constituent.phases_at(theta_rad);
            let spectrum = constituent.scattering_m1.iter().zip(phase_sr1);
            spectrum.map(|(beta, phase)| beta * phase).collect()
        };
        self.air.constituents.iter().map(row).collect()
    }

    /// The lengths that a view ray gathers, and its optical depth; `directed` is what they will be
    /// multiplied with, and so decides which of them matter.
    pub(crate) fn gather(&self, ray: &ViewRay, directed: &[Vec<f64>]) -> Gathered {
        let mut sum = Gathered::new(self.air);
        let Some(ends_m) = ray.in_air(self.planet, self.air.top_height_m) else {
            return sum;
        };
        match self.method {
            InScattering::Midpoint { n_steps } => self.march(ray, ends_m, n_steps, &mut sum),
            InScattering::Nested { .. }
            | InScattering::Quadrature { .. }
            | InScattering::Adaptive { .. } => {
                let walls = |&height_m: &f64| ray.shadow_walls(self.planet, height_m);
                let mut breaks_m: Vec<f64> = self.kinks_m.iter().flat_map(walls).collect();
                breaks_m.extend(crossings(self.planet, ray.start(), &self.kinks_m));
                for leg in legs(self.planet, ray.start(), ends_m, &breaks_m) {
                    self.add_leg(ray, leg, directed, &mut sum);
                }
            }
        }
        sum
    }

    /// Equivalent length of a constituent towards a sun that is up.
    fn sun_length_m(&self, index: usize, constituent: &AirConstituent, sun: RayPoint) -> f64 {
        match self.method {
            InScattering::Midpoint { n_steps } => {
                length_by_midpoints(constituent, self.planet, n_steps.max(1), sun)
            }
            InScattering::Nested { .. } => {
                length_by_rule(constituent, self.planet, &self.sun_rule, sun)
            }
            InScattering::Quadrature { .. } | InScattering::Adaptive { .. } => {
                self.air.column_at(index, sun.height_m, sun.mu)
            }
        }
    }

    /// The published sum (N93, eq. 8).
    fn march(&self, ray: &ViewRay, [enter_m, end_m]: [f64; 2], n_steps: usize, sum: &mut Gathered) {
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
                    sample.sun_m[index] = self.sun_length_m(index, constituent, sun);
                }
            }
            if is_lit {
                sum.add(self.air, &sample, step_m);
            }
        }
        sum.pass(self.air, &view_m);
    }
}

/// Heights at which the column to the sun, as a function of its ray's perigee, is not smooth. What
/// dims nothing has no column, and may not move a bit of the sum.
fn kinks_m(air: &AtmosphereTable) -> Vec<f64> {
    let layered = air.constituents.iter().filter(|air| match air.law {
        DensityLaw::Linear => air.extinction_m1.iter().any(|&extinction| extinction > 0.0),
        DensityLaw::Exponential => false,
    });
    let nodes_m = layered.flat_map(|air| air.height_m.iter().copied());
    let mut heights_m: Vec<f64> = std::iter::once(0.0).chain(nodes_m).collect();
    heights_m.sort_by(f64::total_cmp);
    heights_m.dedup();
    heights_m
}
