//! Sunlight that the air and the ground send along a view ray.
//!
//! L = E_sun sum_c int beta_s,c rho_c(h(s)) P_c(theta) exp(-tau(sun -> s -> eye)) T_drops(s) ds
//!     + E_sun mu_sun A/pi exp(-tau(sun -> ground -> eye)) T_drops
//!
//! `beta_s,c` scattering coefficient of constituent c [1/m], `rho_c` its relative density, `P_c` its
//! phase function [1/sr], `A` albedo of the ground, `mu_sun` cosine of the sun's zenith angle there,
//! `T_drops` what the drops in front let pass, without diffraction. At the level of multiple
//! scattering the source of diffuse light is added at every node (`air_diffuse`), and skylight on the
//! ground. The shadow of the drops on the air and on the ground is left out.
//! \[NMN87\] Nishita, Miyawaki, Nakamae, Computer Graphics 21(4), 303-310 (1987), and the same sum
//! with constant steps as published for rainbows.
//!
//! The integrand is smooth, so it has its own few Gauss nodes: 1 below 300 m (error 3e-5), 4 below
//! 30 km (3e-6), 16 beyond, crowded at the dense end.

use std::num::NonZeroUsize;

use niji_geometry::Ray;

use crate::air::Air;
use crate::air::Lengths;
use crate::gauss_nodes::AirRay;
use crate::gauss_nodes::GaussRule;
use crate::gauss_nodes::RayNode;
use crate::march::Probe;

/// Nodes for stretches below a length.
const STRETCHES_M: [(f64, usize); 3] = [(300.0, 1), (30_000.0, 4), (f64::INFINITY, 16)];

/// Whose light is wanted on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GlowRange {
    /// The way through the drops (m); `None` where there are none.
    pub(crate) drops_m: Option<(f64, f64)>,
    /// Distance of the surface that ends the ray (m); infinite where there is none.
    pub(crate) surface_m: f64,
    /// Whether air from the eye to the far side of the drops counts.
    pub(crate) in_front: bool,
    /// Whether air and ground beyond the drops count.
    pub(crate) beyond: bool,
}

/// Nodes of a ray in the air.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlowNodes {
    nodes: Vec<RayNode>,
    /// Nodes up to here are in front of the far side of the drops.
    n_in_front: usize,
    ground_m: Option<f64>,
    /// The nodes, and the ground where it is seen, for the march through the drops to answer.
    pub(crate) probes: Vec<Probe>,
}

/// The air's light on rays.
pub(crate) struct AirGlow {
    rules: [(f64, GaussRule); 3],
}

impl AirGlow {
    /// The rules for stretches of all lengths.
    pub(crate) fn new() -> Self {
        let rule = |n: usize| GaussRule::new(NonZeroUsize::new(n).unwrap_or(NonZeroUsize::MIN));
        Self {
            rules: STRETCHES_M.map(|(longest_m, n)| (longest_m, rule(n))),
        }
    }

    /// Choose the nodes of a ray.
    pub(crate) fn lay_out(&self, air: &Air, ray: &Ray, range: &GlowRange, out: &mut GlowNodes) {
        out.nodes.clear();
        out.probes.clear();
        (out.n_in_front, out.ground_m) = (0, None);
        let planet = air.planet();
        let air_ray = air.ray(ray.origin, ray.direction);
        let ground_m = planet.distance_to_ground(air_ray.height_m, air_ray.cos_zenith);
        let chord = planet.shell_chord(air_ray.height_m, air_ray.cos_zenith, air.top_height_m());
        let far_side_m = range.drops_m.map_or(0.0, |(_, leave_m)| leave_m);
        if let Some((enter_m, leave_m)) = chord {
            let end_m = ground_m.map_or(leave_m, |ground_m| ground_m.min(leave_m));
            let end_m = end_m.min(range.surface_m);
            if let (true, Some((drops_m, _))) = (range.in_front, range.drops_m) {
                let cut = |distance_m: f64| distance_m.clamp(enter_m, end_m.max(enter_m));
                self.stretch(air, air_ray, (enter_m, cut(drops_m)), &mut out.nodes);
                self.stretch(
                    air,
                    air_ray,
                    (cut(drops_m), cut(far_side_m)),
                    &mut out.nodes,
                );
            }
            out.n_in_front = out.nodes.len();
            if range.beyond {
                self.stretch(
                    air,
                    air_ray,
                    (enter_m.max(far_side_m), end_m),
                    &mut out.nodes,
                );
            }
        }
        out.ground_m = ground_m.filter(|ground_m| range.beyond && *ground_m < range.surface_m);
        let distances = out
            .nodes
            .iter()
            .map(|node| node.distance_m)
            .chain(out.ground_m);
        out.probes.extend(distances.map(|distance_m| Probe {
            distance_m,
            depth: 0.0,
        }));
        // The ground may lie in front of drops that reach below it.
        out.probes
            .sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    }

    fn stretch(
        &self,
        air: &Air,
        air_ray: AirRay,
        (from_m, to_m): (f64, f64),
        out: &mut Vec<RayNode>,
    ) {
        let length_m = to_m - from_m;
        let rule = self
            .rules
            .iter()
            .find(|(longest_m, _)| length_m < *longest_m);
        if let (true, Some((_, rule))) = (length_m > 0.0, rule) {
            rule.place(air.planet(), air_ray, (from_m, to_m), out);
        }
    }
}

/// Spectra of the air's light, for unit sun irradiance [1/sr].
#[derive(Clone, Debug)]
pub(crate) struct Glow {
    /// From the eye to the far side of the drops.
    pub(crate) in_front: Vec<f32>,
    /// Beyond, dimmed by the drops.
    pub(crate) beyond: Vec<f32>,
    /// Scattering towards the eye by constituent, then wavelength [1/(m sr)].
    towards_eye: Vec<f32>,
    transmitted: Vec<f32>,
    /// Diffuse light scattered towards the eye.
    source: Vec<f32>,
    /// For the diffuse light to work in.
    room: Vec<f32>,
}

impl Glow {
    /// Darkness at `n_wavelengths`.
    pub(crate) fn dark(n_wavelengths: usize) -> Self {
        let dark = vec![0.0; n_wavelengths];
        Self {
            in_front: dark.clone(),
            beyond: dark.clone(),
            towards_eye: Vec::new(),
            transmitted: dark.clone(),
            source: dark,
            room: Vec::new(),
        }
    }

    /// Darkness again.
    pub(crate) fn clear(&mut self) {
        self.in_front.fill(0.0);
        self.beyond.fill(0.0);
    }

    /// Gather the light of a ray whose probes have been answered; `drops_dim` is whether what lies
    /// behind drops is dimmed by them.
    pub(crate) fn gather(
        &mut self,
        air: &Air,
        ray: &Ray,
        nodes: &GlowNodes,
        (theta_rad, drops_dim): (f64, bool),
    ) {
        air.scattering_towards(theta_rad, &mut self.towards_eye);
        let air_ray = air.ray(ray.origin, ray.direction);
        let planet = air.planet();
        let through_drops = |distance_m: f64| {
            let probe = nodes
                .probes
                .partition_point(|probe| probe.distance_m < distance_m);
            if drops_dim {
                (-nodes.probes[probe].depth).exp()
            } else {
                1.0
            }
        };
        for (index, node) in nodes.nodes.iter().enumerate() {
            let height_m =
                planet.height_along_ray(air_ray.height_m, air_ray.cos_zenith, node.distance_m);
            let weight_m = node.weight_m * through_drops(node.distance_m);
            let weighted = air.densities(height_m).map(|density| weight_m * density);
            let is_in_front = index < nodes.n_in_front;
            let to_eye = air.to_eye(air_ray, node.distance_m);
            if let Some(to_sun) = air.to_sun(ray.at(node.distance_m)) {
                air.transmit(&sum(&to_sun, &to_eye), &mut self.transmitted);
                self.add_scattered_once(&weighted, is_in_front);
            }
            if let Some(diffuse) = air.diffuse() {
                let Self { source, room, .. } = self;
                diffuse.source((ray, node.distance_m), &weighted, room, source);
                air.transmit(&to_eye, &mut self.transmitted);
                self.add_source(is_in_front);
            }
        }
        if let Some(ground_m) = nodes.ground_m {
            self.add_ground(air, ray, ground_m, through_drops(ground_m));
        }
    }

    /// Sunlight that densities times a length scatter.
    fn add_scattered_once(&mut self, weighted: &Lengths, is_in_front: bool) {
        let sum = if is_in_front {
            &mut self.in_front
        } else {
            &mut self.beyond
        };
        let n_wavelengths = sum.len();
        for (scattering, density) in self.towards_eye.chunks(n_wavelengths).zip(weighted) {
            let density = *density as f32;
            let spectra = sum.iter_mut().zip(scattering).zip(&self.transmitted);
            for ((sum, beta), transmitted) in spectra {
                *sum += density * beta * transmitted;
            }
        }
    }

    /// The source of diffuse light, transmitted.
    fn add_source(&mut self, is_in_front: bool) {
        let sum = if is_in_front {
            &mut self.in_front
        } else {
            &mut self.beyond
        };
        let spectra = sum.iter_mut().zip(&self.source).zip(&self.transmitted);
        for ((sum, source), transmitted) in spectra {
            *sum += source * transmitted;
        }
    }

    fn add_ground(&mut self, air: &Air, ray: &Ray, ground_m: f64, through_drops: f64) {
        let air_ray = air.ray(ray.origin, ray.direction);
        let scale = (through_drops * std::f64::consts::FRAC_1_PI) as f32;
        let to_eye = air.to_eye(air_ray, ground_m);
        if let Some(diffuse) = air.diffuse() {
            air.transmit(&to_eye, &mut self.transmitted);
            let irradiance = diffuse.on_ground(ray, ground_m);
            for (transmitted, irradiance) in self.transmitted.iter_mut().zip(irradiance) {
                *transmitted *= irradiance;
            }
            self.add_reflected(air, scale);
        }
        let cos_sun = air
            .planet()
            .cos_zenith(ray.at(ground_m), air.sun_direction());
        let (true, Some(to_sun)) = (cos_sun > 0.0, air.to_sun(ray.at(ground_m))) else {
            return;
        };
        air.transmit(&sum(&to_sun, &to_eye), &mut self.transmitted);
        self.add_reflected(air, scale * cos_sun as f32);
    }

    /// What is left of the light on the ground on its way to the eye, times albedo and `scale`.
    fn add_reflected(&mut self, air: &Air, scale: f32) {
        let spectra = self.beyond.iter_mut().zip(air.ground_albedo());
        for ((sum, albedo), transmitted) in spectra.zip(&self.transmitted) {
            *sum += scale * *albedo as f32 * transmitted;
        }
    }
}

/// Both ways, one after the other.
fn sum(a: &Lengths, b: &Lengths) -> Lengths {
    std::array::from_fn(|index| a[index] + b[index])
}
