//! Bounds on what the air takes from light and adds to it.
//!
//! Along any straight way inside a region, tau_l <= s sum_c beta_c,l max rho_c, with `s` its length
//! and `rho_c` the relative density of constituent c at the heights of the region. The sun's optical
//! depth is largest at one of the corners of the drops' box or at the eye.
//!
//! Sunlight scattered once on the way to the eye, and sky and ground behind, are solved for at the
//! corners and in the middle of every block of the picture: they are smooth but at the horizon, on
//! both sides of which blocks that hold it are solved as well. [`MARGIN`] covers what lies between.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::ViewRay;
use niji_exchange::AtmosphereTable;
use niji_geometry::Aabb;
use niji_geometry::Planet;
use rayon::prelude::*;

use super::luminance::Line;
use super::view::Block;

/// Part of the way to the ground that is air alone.
const ABOVE_GROUND: f64 = 1.0 - 1e-9;

/// Widens every bound for the air's levels of accuracy and for what lies between samples.
const MARGIN: f64 = 1.1;

/// Widens the light of higher orders besides: what its draft level may miss.
const DIFFUSE_MARGIN: f64 = 1.15;

/// Nodes on each leg of a view ray: a few thousandths on whole-sky rays.
const N_NODES: usize = 6;

/// Rise above and below the geometric horizon at which both sides of it are solved.
const BESIDE_HORIZON: f64 = 1e-6;

/// Samples of the sphere around the drops: cosines of the zenith angle and azimuths.
const SPHERE_SAMPLES: (usize, usize) = (24, 16);

/// The air of a scene, for bounds. Luminances are relative to the reference.
pub(super) struct AirLight {
    /// Sun's optical depth at the eye and the drops, by line: smallest and largest.
    sun_depth: Vec<(f64, f64)>,
    /// Largest extinction between the eye and the drops, by line (1/m).
    extinction_m1: Vec<f64>,
    /// Luminance from the eye to the far side of the drops, by block.
    front: Vec<f64>,
    /// Luminance of the whole ray, the ground included, by block.
    whole: Vec<f64>,
    /// Mean luminance around the drops.
    surround: f64,
}

/// What the bounds are computed for.
pub(super) struct AirRequest<'a> {
    pub(super) table: &'a AtmosphereTable,
    pub(super) lines: &'a [Line],
    /// Luminance per radiance over the reference, by wavelength of the table.
    pub(super) luminance: &'a [f64],
    pub(super) eye: DVec3,
    pub(super) sun: DVec3,
    pub(super) drops: &'a Aabb,
    pub(super) blocks: &'a [Block],
}

impl AirLight {
    pub(super) fn new(request: &AirRequest<'_>) -> Self {
        let sky = Sky::new(request);
        let (sun_depth, extinction_m1) = depths(request, sky.planet);
        Self {
            sun_depth,
            extinction_m1,
            front: request.blocks.par_iter().map(|it| sky.front(it)).collect(),
            whole: sky.whole(),
            surround: sky.surround(),
        }
    }

    /// Largest share of sunlight that reaches the drops, by line.
    pub(super) fn sunlight(&self) -> Vec<f64> {
        self.sun_depth
            .iter()
            .map(|(low, _)| (-low / MARGIN).exp())
            .collect()
    }

    /// Largest share of sunlight that the air takes before the drops, by line.
    pub(super) fn sunlight_lost(&self) -> Vec<f64> {
        self.sun_depth
            .iter()
            .map(|(_, high)| -(-high * MARGIN).exp_m1())
            .collect()
    }

    /// Largest share of light that the air takes on a way of `length_m` in front of the drops.
    pub(super) fn view_lost(&self, length_m: f64) -> Vec<f64> {
        let lost = |extinction: &f64| -(-extinction * length_m * MARGIN).exp_m1();
        self.extinction_m1.iter().map(lost).collect()
    }

    /// Luminance that the air adds between the eye and the far side of the drops, at most.
    pub(super) fn inscatter(&self, block_index: usize) -> f64 {
        self.front[block_index]
    }

    /// Luminance of air and ground beyond the drops, at most.
    pub(super) fn sky(&self, block_index: usize) -> f64 {
        self.whole[block_index]
    }

    /// Mean luminance of what shines around the drops, at most.
    pub(super) fn mean_surround(&self) -> f64 {
        self.surround
    }
}

/// Solves view rays for their luminance.
struct Sky<'a> {
    request: &'a AirRequest<'a>,
    solver: SingleScattering<'a>,
    /// Where the level of the sky asks for it.
    diffuse: Option<DiffuseSky<'a>>,
    planet: Planet,
}

impl<'a> Sky<'a> {
    fn new(request: &'a AirRequest<'a>) -> Self {
        let planet = Planet {
            radius_m: request.table.planet_radius_m,
        };
        let method = InScattering::Quadrature { n_nodes: N_NODES };
        Self {
            request,
            solver: SingleScattering::new(request.table, method),
            diffuse: DiffuseSky::new(request.table).ok(),
            planet,
        }
    }

    fn ray(&self, position: DVec3, direction: DVec3, length_m: f64) -> ViewRay {
        ViewRay::new(
            self.planet,
            [position, direction, self.request.sun],
            length_m,
        )
    }

    fn luminance(&self, radiance: &[f64]) -> f64 {
        radiance
            .iter()
            .zip(self.request.luminance)
            .map(|(radiance, weight)| radiance * weight)
            .sum()
    }

    /// Luminance of light of higher orders; 0 where it is left out.
    fn diffuse_luminance(&self, ray: &ViewRay) -> f64 {
        let Some(diffuse) = &self.diffuse else {
            return 0.0;
        };
        let suns = self.request.table.sun_irradiance.iter();
        let per_sun = diffuse.radiance_per_sun(ray).into_iter();
        let radiance: Vec<f64> = per_sun.zip(suns).map(|(light, sun)| light * sun).collect();
        DIFFUSE_MARGIN * self.luminance(&radiance)
    }

    fn front(&self, block: &Block) -> f64 {
        let Some(chord) = block.drops else { return 0.0 };
        let eye = self.request.eye;
        let (height_m, zenith) = (self.planet.height_m(eye), self.planet.zenith(eye));
        let light = |direction: &DVec3| {
            // The ground in skylight is part of the sky, also where drops stand on it.
            let ground_m = self
                .planet
                .distance_to_ground(height_m, zenith.dot(*direction));
            let above_m = ground_m.map_or(f64::INFINITY, |ground_m| ABOVE_GROUND * ground_m);
            let ray = self.ray(eye, *direction, chord.leave_m.min(above_m));
            self.luminance(&self.solver.solve(&ray).radiance) + self.diffuse_luminance(&ray)
        };
        MARGIN * block.samples.iter().map(light).fold(0.0, f64::max)
    }

    /// All that a ray meets, the ground included.
    fn beyond(&self, position: DVec3, direction: DVec3) -> f64 {
        let ray = self.ray(position, direction, f64::INFINITY);
        self.luminance(&self.solver.sky_radiance(&ray)) + self.diffuse_luminance(&ray)
    }

    /// Of the whole ray, by block.
    fn whole(&self) -> Vec<f64> {
        let eye = self.request.eye;
        let bits = |direction: &DVec3| direction.to_array().map(f64::to_bits);
        let blocks = self.request.blocks.iter();
        let samples: Vec<Vec<DVec3>> = blocks.map(|block| self.samples(block)).collect();
        // Blocks share their corners.
        let directions: BTreeMap<[u64; 3], DVec3> = samples
            .iter()
            .flatten()
            .map(|direction| (bits(direction), *direction))
            .collect();
        let lights = directions.into_par_iter();
        let lights: BTreeMap<[u64; 3], f64> = lights
            .map(|(bits, direction)| (bits, self.beyond(eye, direction)))
            .collect();
        let largest = |samples: &Vec<DVec3>| {
            let lights = samples.iter().map(|direction| lights[&bits(direction)]);
            MARGIN * lights.fold(0.0, f64::max)
        };
        samples.iter().map(largest).collect()
    }

    /// Directions in which a block is solved.
    fn samples(&self, block: &Block) -> Vec<DVec3> {
        let eye = self.request.eye;
        let horizon = -self.planet.horizon_dip(self.planet.height_m(eye)).0.sin();
        let zenith = self.planet.zenith(eye);
        let mut samples = block.samples.to_vec();
        let rises = block.samples.map(|direction| zenith.dot(direction));
        let holds_horizon =
            rises.iter().any(|rise| *rise >= horizon) && rises.iter().any(|rise| *rise <= horizon);
        if holds_horizon {
            for direction in block.samples {
                let level = (direction - zenith * zenith.dot(direction)).normalize_or(DVec3::X);
                for rise in [horizon - BESIDE_HORIZON, horizon + BESIDE_HORIZON] {
                    samples.push(level * (1.0 - rise * rise).max(0.0).sqrt() + zenith * rise);
                }
            }
        }
        samples
    }

    /// Mean over all directions around the middle of the drops.
    fn surround(&self) -> f64 {
        let middle = 0.5 * (self.request.drops.min + self.request.drops.max);
        let (n_cosines, n_azimuths) = SPHERE_SAMPLES;
        let light = |sample: usize| {
            let (row, column) = (sample / n_azimuths, sample % n_azimuths);
            let cosine = -1.0 + 2.0 * (row as f64 + 0.5) / n_cosines as f64;
            let sine = (1.0 - cosine * cosine).sqrt();
            let (sin, cos) = (TAU * column as f64 / n_azimuths as f64).sin_cos();
            self.beyond(middle, DVec3::new(sine * cos, cosine, sine * sin))
        };
        let n_samples = n_cosines * n_azimuths;
        let lights: Vec<f64> = (0..n_samples).into_par_iter().map(light).collect();
        MARGIN * lights.iter().sum::<f64>() / n_samples as f64
    }
}

/// The sun's optical depth at the drops and the extinction in front of them, by line.
fn depths(request: &AirRequest<'_>, planet: Planet) -> (Vec<(f64, f64)>, Vec<f64>) {
    let (table, eye) = (request.table, request.eye);
    let points = eye_and_corners(eye, request.drops);
    let heights: Vec<f64> = points.iter().map(|point| planet.height_m(*point)).collect();
    let high_m = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let span_m = points
        .iter()
        .map(|point| point.distance(eye))
        .fold(0.0, f64::max);
    // A straight way dips below its ends by at most s^2/(8 R).
    let sagitta_m = span_m * span_m / (8.0 * planet.radius_m);
    let low_m = heights.iter().copied().fold(f64::INFINITY, f64::min) - sagitta_m;
    let density: Vec<f64> = (0..table.constituents.len())
        .map(|index| largest_density(table, index, (low_m, high_m)))
        .collect();
    let extinction = |line: &Line| {
        let terms = table.constituents.iter().zip(&density);
        terms
            .map(|(air, density)| air.extinction_m1[line.index] * density)
            .sum()
    };
    let sun_depth = |line: &Line| {
        let depths = points.iter().zip(&heights).map(|(point, height_m)| {
            let cos_sun = planet.cos_zenith(*point, request.sun);
            table.optical_depth_at(line.index, *height_m, cos_sun)
        });
        depths.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), depth| {
            (low.min(depth), high.max(depth))
        })
    };
    let lines = request.lines;
    (
        lines.iter().map(sun_depth).collect(),
        lines.iter().map(extinction).collect(),
    )
}

fn eye_and_corners(eye: DVec3, bounds: &Aabb) -> Vec<DVec3> {
    let mut points = vec![eye];
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        points.push(DVec3::new(pick(0), pick(1), pick(2)));
    }
    points
}

/// Largest relative density between two heights: at their ends or at a node between them.
fn largest_density(table: &AtmosphereTable, index: usize, (low_m, high_m): (f64, f64)) -> f64 {
    let air = &table.constituents[index];
    let inside = air
        .height_m
        .iter()
        .filter(|height| (low_m..=high_m).contains(*height));
    let heights = inside.copied().chain([low_m, high_m]);
    heights
        .map(|height_m| table.density_at(index, height_m))
        .fold(0.0, f64::max)
}
