//! Light that one leg of a view ray gathers: panels, cut by optical depth, halved where they disagree.
//!
//! A leg is first cut where its optical depth exceeds `PANEL_DEPTH` at any wavelength, so that thick
//! haze is resolved. By the adaptive method a panel is then halved, until the radiance of both halves
//! together differs from that of the whole by less than the tolerance times what the ray gathers;
//! the light of a setting sun that rises above haze and grazing shadows are found in this way wherever
//! they are.

use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;

use super::InScattering;
use super::SingleScattering;
use crate::gathered::Gathered;
use crate::gathered::Sample;
use crate::leg::Leg;
use crate::leg::RayPoint;
use crate::view_ray::ViewRay;

/// Optical depth up to which one panel of nodes is enough.
const PANEL_DEPTH: f64 = 4.0;
/// Optical depth beyond which nothing reaches the eye: e^-60 = 9e-27.
const BLACK_DEPTH: f64 = 60.0;
/// Most cuts of one leg.
const MAX_CUTS: usize = 200;
/// Most halvings of one panel, to a thousandth of its width in u and a millionth of its length.
const MAX_HALVINGS: usize = 10;

/// Part of a leg, from `near_u` to `far_u` on it, seen along the ray.
#[derive(Clone, Copy)]
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

    fn halves(self) -> [Self; 2] {
        let middle_u = 0.5 * (self.near_u + self.far_u);
        let near = Self {
            far_u: middle_u,
            ..self
        };
        let far = Self {
            near_u: middle_u,
            ..self
        };
        [near, far]
    }
}

/// How the equivalent length of a constituent on a panel is found.
enum ViewLength<'a> {
    /// From the samples of its density.
    Samples,
    /// Layers of linear density in closed form, since no polynomial follows their kinks.
    ClosedForm {
        air: &'a AtmosphereTable,
        index: usize,
        ray: &'a ViewRay,
        /// Length up to the start of the panel, m.
        before_m: f64,
    },
}

impl<'a> ViewLength<'a> {
    fn new(air: &'a AtmosphereTable, index: usize, ray: &'a ViewRay, panel: &Panel) -> Self {
        match air.constituents[index].law {
            DensityLaw::Exponential => Self::Samples,
            DensityLaw::Linear => {
                let start_m = panel.distance_m(0.0);
                Self::ClosedForm {
                    air,
                    index,
                    ray,
                    before_m: air.segment_length(index, ray.height_m, ray.cos_zenith, start_m),
                }
            }
        }
    }

    /// Equivalent length from the start of the panel, m.
    fn to_m(&self, distance_m: f64, by_samples: impl Fn() -> f64) -> f64 {
        match self {
            Self::Samples => by_samples(),
            Self::ClosedForm {
                air,
                index,
                ray,
                before_m,
            } => {
                let whole_m = air.segment_length(*index, ray.height_m, ray.cos_zenith, distance_m);
                // Rounding of two equal lengths outside the layer.
                (whole_m - before_m).max(0.0)
            }
        }
    }
}

/// What makes two halves agree with their whole.
struct Agreement<'a> {
    tolerance: f64,
    /// beta P(theta) by constituent and wavelength.
    directed: &'a [Vec<f64>],
    /// Radiance over the sun's irradiance that differences are compared with, by wavelength.
    scale: Vec<f64>,
}

impl Agreement<'_> {
    /// Whether the whole of a panel gathers what its halves do.
    fn holds(&self, whole: &Gathered, near: &Gathered, far: &Gathered) -> bool {
        let depths = whole.depth.iter().zip(&far.depth);
        let depths_agree = depths.into_iter().all(|(whole, halves)| {
            (whole - halves).abs() <= self.tolerance * halves.max(1.0) || *halves > BLACK_DEPTH
        });
        if !depths_agree {
            return false;
        }
        let mut differences = vec![0.0; self.scale.len()];
        for (index, directed) in self.directed.iter().enumerate() {
            let lengths = whole.lengths_m[index]
                .iter()
                .zip(&near.lengths_m[index])
                .zip(&far.lengths_m[index]);
            let differing = differences.iter_mut().zip(directed);
            for ((difference, directed), ((whole, near), far)) in differing.zip(lengths) {
                *difference += directed * (whole - near - far).abs();
            }
        }
        let pairs = differences.iter().zip(&self.scale);
        pairs
            .into_iter()
            .all(|(difference, scale)| *difference <= self.tolerance * scale)
    }
}

impl SingleScattering<'_> {
    /// Adds what a leg gathers.
    pub(super) fn add_leg(
        &self,
        ray: &ViewRay,
        leg: Leg,
        directed: &[Vec<f64>],
        sum: &mut Gathered,
    ) {
        let n = self.rule.len();
        let mut densities = vec![vec![0.0; n]; self.air.constituents.len()];
        // u at the near and at the far end of what is left of the leg.
        let (mut near_u, end_u) = if leg.rises { (0.0, 1.0) } else { (1.0, 0.0) };
        let mut far_u = end_u;
        for _ in 0..MAX_CUTS {
            let panel = Panel { leg, near_u, far_u };
            self.sample_densities(ray, &panel, &mut densities);
            let (thickest, depth) = self.thickest(&densities, &sum.depth);
            if depth > 2.0 * PANEL_DEPTH {
                far_u = panel.u(self.cut(thickest, &densities));
                continue;
            }
            self.add_panel(ray, &panel, directed, sum);
            let is_done = (far_u - end_u).abs() <= 0.0;
            if is_done || sum.depth.iter().all(|&depth| depth > BLACK_DEPTH) {
                break;
            }
            near_u = far_u;
            far_u = end_u;
        }
    }

    /// Adds what a panel gathers.
    fn add_panel(&self, ray: &ViewRay, panel: &Panel, directed: &[Vec<f64>], sum: &mut Gathered) {
        let whole = self.solve_panel(ray, panel, &sum.depth);
        match self.method {
            InScattering::Adaptive { tolerance } => {
                let mut scale = sum.radiance_per_sun(directed);
                for (scale, more) in scale.iter_mut().zip(whole.radiance_per_sun(directed)) {
                    *scale += more;
                }
                let agreement = Agreement {
                    tolerance,
                    directed,
                    scale,
                };
                self.add_halves(ray, (panel, &whole), (&agreement, MAX_HALVINGS), sum);
            }
            InScattering::Midpoint { .. }
            | InScattering::Nested { .. }
            | InScattering::Quadrature { .. } => sum.append(&whole),
        }
    }

    /// Adds what both halves of a panel gather, each halved again where they do not agree with what
    /// the whole gathers.
    fn add_halves(
        &self,
        ray: &ViewRay,
        (panel, whole): (&Panel, &Gathered),
        (agreement, halvings_left): (&Agreement, usize),
        sum: &mut Gathered,
    ) {
        let [near_panel, far_panel] = panel.halves();
        let near = self.solve_panel(ray, &near_panel, &sum.depth);
        let far = self.solve_panel(ray, &far_panel, &near.depth);
        if halvings_left == 0 || agreement.holds(whole, &near, &far) {
            sum.append(&near);
            sum.append(&far);
            return;
        }
        let next = (agreement, halvings_left - 1);
        self.add_halves(ray, (&near_panel, &near), next, sum);
        self.add_halves(ray, (&far_panel, &far), next, sum);
    }

    /// What one panel gathers behind an optical depth.
    fn solve_panel(&self, ray: &ViewRay, panel: &Panel, depth_before: &[f64]) -> Gathered {
        let n_constituents = self.air.constituents.len();
        let mut densities = vec![vec![0.0; self.rule.len()]; n_constituents];
        self.sample_densities(ray, panel, &mut densities);
        let lengths: Vec<ViewLength> = (0..n_constituents)
            .map(|index| ViewLength::new(self.air, index, ray, panel))
            .collect();
        let mut sum = Gathered::behind(self.air, depth_before);
        let mut sample = Sample::new(n_constituents);
        for (node, (x, weight)) in self.rule.pairs().enumerate() {
            let distance_m = panel.distance_m(x);
            let [height_m, mu_s] = ray.sun_at(self.planet, distance_m);
            if self.planet.hits_ground(height_m, mu_s) {
                continue;
            }
            let sun = RayPoint { height_m, mu: mu_s };
            for (index, constituent) in self.air.constituents.iter().enumerate() {
                let samples = &densities[index];
                sample.density[index] = samples[node];
                sample.view_m[index] =
                    lengths[index].to_m(distance_m, || self.rule.running(node, samples));
                sample.sun_m[index] = self.sun_length_m(index, constituent, sun);
            }
            sum.add(self.air, &sample, weight);
        }
        let end_m = panel.distance_m(1.0);
        let totals = lengths.iter().zip(&densities);
        let totals_m: Vec<f64> = totals
            .map(|(length, samples)| length.to_m(end_m, || self.rule.total(samples)))
            .collect();
        sum.pass(self.air, &totals_m);
        sum
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

    /// Wavelength and optical depth where a panel dims most, among the wavelengths that are not black
    /// yet.
    fn thickest(&self, densities: &[Vec<f64>], passed: &[f64]) -> (usize, f64) {
        let totals_m: Vec<f64> = densities
            .iter()
            .map(|samples| self.rule.total(samples))
            .collect();
        let depths = (0..passed.len()).map(|wavelength| {
            let is_black = passed[wavelength] > BLACK_DEPTH;
            let constituents = self.air.constituents.iter().zip(&totals_m);
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
}
