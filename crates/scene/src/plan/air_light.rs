//! Bounds on what the air takes from light and adds to it.
//!
//! Along any straight way inside a region, tau_l <= s sum_c beta_c,l max rho_c, with `s` its length
//! and `rho_c` the relative density at the heights of the region. Single scattering of sunlight over
//! a way of optical depth tau adds at most
//!   E_l max_c P_c(theta) w_l (1 - exp(-tau_l)),  w_l the largest single-scattering albedo,
//! and without extinction  E_l sum_c beta_s,c,l P_c(theta) l_c,  `l_c` equivalent length.
//! The sun's optical depth is largest at the lowest point seen, and smallest at the highest.
//! Factors are by line of the spectrum; 1 where a scene has no air.

use glam::DVec3;
use niji_exchange::AtmosphereTable;
use niji_geometry::Aabb;
use niji_geometry::Planet;

use super::bow_light::Line;
use super::view::Block;

/// Widens every bound for the air's levels of accuracy and for tables between their nodes.
const MARGIN: f64 = 1.05;

/// Samples of a phase function within a block, and what a smooth one may rise between them.
const N_PHASE_SAMPLES: usize = 5;

/// Samples of the sky's elevation for its mean.
const N_SKY_SAMPLES: usize = 32;

/// Rise above the geometric horizon of a ray that just passes over it.
const ABOVE_HORIZON: f64 = 1e-9;

/// The air of a scene, for bounds.
pub(super) struct AirLight<'a> {
    table: &'a AtmosphereTable,
    lines: &'a [Line],
    planet: Planet,
    eye: DVec3,
    eye_height_m: f64,
    sun: DVec3,
    /// Sun's optical depth at the eye and the drops, by line: smallest and largest.
    sun_depth: Vec<(f64, f64)>,
    /// Largest extinction between the eye and the drops, by line [1/m].
    extinction_m1: Vec<f64>,
    /// Largest relative density of each constituent there.
    density: Vec<f64>,
}

/// What scattered sunlight loses on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dimmed {
    /// Air dims the sun.
    pub(super) sunlight: bool,
    /// Air dims the view.
    pub(super) view: bool,
}

impl<'a> AirLight<'a> {
    pub(super) fn new(
        (table, lines): (&'a AtmosphereTable, &'a [Line]),
        eye: DVec3,
        sun: DVec3,
        drops: Option<&Aabb>,
    ) -> Self {
        let planet = Planet {
            radius_m: table.planet_radius_m,
        };
        let points = eye_and_corners(eye, drops);
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
                table.optical_depth_at(line.index, *height_m, planet.cos_zenith(*point, sun))
            });
            depths.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), depth| {
                (low.min(depth), high.max(depth))
            })
        };
        Self {
            table,
            lines,
            planet,
            eye,
            eye_height_m: planet.height_m(eye),
            sun,
            sun_depth: lines.iter().map(sun_depth).collect(),
            extinction_m1: lines.iter().map(extinction).collect(),
            density,
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

    /// Relative luminance that the air adds on a way of `length_m` from the eye, at most.
    pub(super) fn inscatter(&self, block: &Block, length_m: f64, dimmed: Dimmed) -> f64 {
        let lengths: Vec<f64> = self
            .density
            .iter()
            .map(|density| density * length_m)
            .collect();
        let sunlight = self.sun_factor(dimmed);
        self.scattered(block, &lengths, dimmed.view, &sunlight)
    }

    /// Relative luminance of air and ground on the whole way, at most.
    pub(super) fn sky(&self, block: &Block, dimmed: Dimmed) -> f64 {
        let horizon = -self.planet.horizon_dip(self.eye_height_m).0.sin();
        // The zenith of an eye far from the origin leans away from y.
        let lean = self.eye.x.hypot(self.eye.z) / self.planet.radius_m;
        let (low, high) = (block.rise.0 - lean, (block.rise.1 + lean).min(1.0));
        let ground = if low <= horizon {
            self.ground(dimmed)
        } else {
            0.0
        };
        let longest = high.min((horizon + ABOVE_HORIZON).max(low));
        let mut light = 0.0_f64;
        for rise in [longest, low.max(-1.0)] {
            let lengths = self.whole_lengths(rise);
            let sunlight = vec![1.0; self.lines.len()];
            light = light.max(self.scattered(block, &lengths, dimmed.view, &sunlight));
        }
        light + ground
    }

    /// Mean over all directions of what shines around the drops, at most, relative luminance.
    pub(super) fn mean_surround(&self, dimmed: Dimmed) -> f64 {
        let n = N_SKY_SAMPLES as f64;
        let everywhere = |rise: f64| Block {
            share: 1.0,
            theta_rad: (0.0, std::f64::consts::PI),
            rise: (rise, rise),
            drops: None,
            depth: 0.0,
        };
        // The lower edge of each interval is the brighter one.
        let upper: f64 = (0..N_SKY_SAMPLES)
            .map(|i| self.sky(&everywhere(i as f64 / n), dimmed) / n)
            .sum();
        let lower = self.sky(&everywhere(-0.05), dimmed);
        0.5 * (upper + lower)
    }

    fn sun_factor(&self, dimmed: Dimmed) -> Vec<f64> {
        if dimmed.sunlight {
            self.sunlight()
        } else {
            vec![1.0; self.lines.len()]
        }
    }

    /// Sunlit ground, at most: E mu_sun A/pi.
    fn ground(&self, dimmed: Dimmed) -> f64 {
        let below = DVec3::new(self.eye.x, self.eye.y - self.eye_height_m, self.eye.z);
        let cos_sun = self.planet.cos_zenith(below, self.sun);
        // Ground up to the horizon sees the sun at another elevation by as much as it is away.
        let spread = self.planet.horizon_dip(self.eye_height_m).0;
        let highest_sun = (cos_sun + spread).min(1.0);
        if highest_sun <= 0.0 {
            return 0.0;
        }
        let reflected = |line: &Line| {
            let depth = self.table.optical_depth_at(line.index, 0.0, highest_sun);
            let sunlight = if dimmed.sunlight {
                (-depth / MARGIN).exp()
            } else {
                1.0
            };
            let albedo = self.table.ground_albedo[line.index];
            line.weight * sunlight * highest_sun * albedo / std::f64::consts::PI
        };
        self.lines.iter().map(reflected).sum()
    }

    /// Equivalent lengths of a whole way from the eye.
    fn whole_lengths(&self, rise: f64) -> Vec<f64> {
        let length = |index| {
            let hits = self.planet.distance_to_ground(self.eye_height_m, rise);
            let end_m = hits.unwrap_or(f64::INFINITY);
            self.table
                .segment_length(index, self.eye_height_m, rise, end_m)
        };
        (0..self.table.constituents.len()).map(length).collect()
    }

    fn scattered(&self, block: &Block, lengths: &[f64], view: bool, sunlight: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (line, sunlight) in self.lines.iter().zip(sunlight) {
            let (mut thin, mut depth, mut scattering) = (0.0, 0.0, 0.0);
            let mut phase_sr1 = 0.0_f64;
            for (index, length_m) in lengths.iter().enumerate() {
                let air = &self.table.constituents[index];
                let phase = self.largest_phase(index, line.index, block.theta_rad);
                thin += air.scattering_m1[line.index] * length_m * phase;
                scattering += air.scattering_m1[line.index] * length_m;
                depth += air.extinction_m1[line.index] * length_m;
                phase_sr1 = phase_sr1.max(phase);
            }
            // With extinction, no more than what is scattered at all leaves towards the eye.
            let dimmed = if depth > 0.0 {
                phase_sr1
                    * (scattering / depth)
                        .min(1.0)
                        .max(self.largest_albedo(line.index))
                    * -(-depth * MARGIN).exp_m1()
            } else {
                0.0
            };
            sum += line.weight * sunlight * if view { thin.min(dimmed) } else { thin };
        }
        MARGIN * sum
    }

    fn largest_albedo(&self, wavelength: usize) -> f64 {
        let albedo = |(scattering, extinction): (f64, f64)| {
            if extinction > 0.0 {
                scattering / extinction
            } else {
                0.0
            }
        };
        let pairs = self
            .table
            .constituents
            .iter()
            .map(|air| (air.scattering_m1[wavelength], air.extinction_m1[wavelength]));
        pairs.map(albedo).fold(0.0, f64::max)
    }

    fn largest_phase(&self, index: usize, wavelength: usize, (low, high): (f64, f64)) -> f64 {
        (0..N_PHASE_SAMPLES)
            .map(|i| low + (high - low) * i as f64 / (N_PHASE_SAMPLES - 1) as f64)
            .map(|theta_rad| self.table.phase_at(index, wavelength, theta_rad))
            .fold(0.0, f64::max)
    }
}

fn eye_and_corners(eye: DVec3, drops: Option<&Aabb>) -> Vec<DVec3> {
    let mut points = vec![eye];
    if let Some(bounds) = drops {
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
