//! Light that one leg of a view ray gathers: panels, cut by optical depth, halved where they disagree.
//!
//! A leg is first cut where its optical depth exceeds `PANEL_DEPTH` at any wavelength, so that thick
//! haze is resolved. By the adaptive method a panel is then halved, until the radiance by Kronrod's 15
//! nodes differs from that by Gauss's 7 among them by less than the tolerance times what the ray
//! gathers; the light of a setting sun that rises above haze and grazing shadows are found in this way
//! wherever they are.

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
struct Panel<'a> {
    ray: &'a ViewRay,
    leg: Leg,
    near_u: f64,
    far_u: f64,
    /// How often a panel was halved to make this one.
    n_halvings: usize,
}

impl Panel<'_> {
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
        let n_halvings = self.n_halvings + 1;
        let near = Self {
            far_u: middle_u,
            n_halvings,
            ..self
        };
        let far = Self {
            near_u: middle_u,
            n_halvings,
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
    fn new(air: &'a AtmosphereTable, index: usize, panel: &Panel<'a>) -> Self {
        match air.constituents[index].law {
            DensityLaw::Exponential => Self::Samples,
            DensityLaw::Linear => {
                let ray = panel.ray;
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

/// What makes the coarse rule of a panel agree with the fine one.
struct Agreement<'a> {
    tolerance: f64,
    /// beta P(theta) by constituent and wavelength.
    directed: &'a [Vec<f64>],
    /// Radiance over the sun's irradiance that differences are compared with, by wavelength.
    scale: Vec<f64>,
}

impl Agreement<'_> {
    /// Whether both rules gather the same.
    fn holds(&self, panel: &Solved) -> bool {
        let depths = panel.gathered.depth.iter().zip(&panel.depth_excess);
        let depths_agree = depths.into_iter().all(|(depth, excess)| {
            excess.abs() <= self.tolerance * depth.max(1.0) || *depth > BLACK_DEPTH
        });
        if !depths_agree {
            return false;
        }
        let mut differences = vec![0.0; self.scale.len()];
        for (directed, excess_m) in self.directed.iter().zip(&panel.gathered.excess_m) {
            let terms = directed.iter().zip(excess_m);
            for (difference, (directed, excess_m)) in differences.iter_mut().zip(terms) {
                *difference += directed * excess_m.abs();
            }
        }
        let pairs = differences.iter().zip(&self.scale);
        pairs
            .into_iter()
            .all(|(difference, scale)| *difference <= self.tolerance * scale)
    }
}

/// What a panel gathers.
struct Solved {
    gathered: Gathered,
    /// By how much its optical depth exceeds that of the coarse rule, by wavelength.
    depth_excess: Vec<f64>,
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
        let mut densities = self.no_densities();
        // u at the near and at the far end of what is left of the leg.
        let (mut near_u, end_u) = if leg.rises { (0.0, 1.0) } else { (1.0, 0.0) };
        let mut far_u = end_u;
        for _ in 0..MAX_CUTS {
            let panel = Panel {
                ray,
                leg,
                near_u,
                far_u,
                n_halvings: 0,
            };
            self.sample_densities(&panel, &mut densities);
            let (thickest, depth) = self.thickest(&densities, &sum.depth);
            if depth > 2.0 * PANEL_DEPTH {
                far_u = panel.u(self.cut(thickest, &densities));
                continue;
            }
            self.add_panel(&panel, &densities, directed, sum);
            let is_done = (far_u - end_u).abs() <= 0.0;
            if is_done || sum.depth.iter().all(|&depth| depth > BLACK_DEPTH) {
                break;
            }
            near_u = far_u;
            far_u = end_u;
        }
    }

    /// Adds what a panel gathers.
    fn add_panel(
        &self,
        panel: &Panel,
        densities: &[Vec<f64>],
        directed: &[Vec<f64>],
        sum: &mut Gathered,
    ) {
        let whole = self.solve_panel(panel, densities, &sum.depth);
        match self.method {
            InScattering::Adaptive { tolerance } => {
                let mut scale = sum.radiance_per_sun(directed);
                let more = whole.gathered.radiance_per_sun(directed);
                for (scale, more) in scale.iter_mut().zip(more) {
                    *scale += more;
                }
                let agreement = Agreement {
                    tolerance,
                    directed,
                    scale,
                };
                self.add_agreed(panel, &whole, &agreement, sum);
            }
            InScattering::Midpoint { .. }
            | InScattering::Nested { .. }
            | InScattering::Quadrature { .. } => sum.append(&whole.gathered),
        }
    }

    /// Adds what a panel gathers, or each of its halves, where the rules do not agree on it.
    fn add_agreed(
        &self,
        panel: &Panel,
        solved: &Solved,
        agreement: &Agreement,
        sum: &mut Gathered,
    ) {
        if panel.n_halvings == MAX_HALVINGS || agreement.holds(solved) {
            sum.append(&solved.gathered);
            return;
        }
        let mut densities = self.no_densities();
        for half in panel.halves() {
            self.sample_densities(&half, &mut densities);
            let solved = self.solve_panel(&half, &densities, &sum.depth);
            self.add_agreed(&half, &solved, agreement, sum);
        }
    }

    /// What one panel gathers behind an optical depth.
    fn solve_panel(&self, panel: &Panel, densities: &[Vec<f64>], depth_before: &[f64]) -> Solved {
        let lengths: Vec<ViewLength> = (0..self.air.constituents.len())
            .map(|index| ViewLength::new(self.air, index, panel))
            .collect();
        let mut sum = Gathered::behind(self.air, depth_before);
        if !self.excess.is_empty() {
            sum.excess_m.clone_from(&sum.lengths_m);
        }
        let mut sample = Sample::new(self.air.constituents.len());
        for (node, (x, weight)) in self.rule.pairs().enumerate() {
            let distance_m = panel.distance_m(x);
            let [height_m, mu_s] = panel.ray.sun_at(self.planet, distance_m);
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
            match self.excess.get(node) {
                Some(&excess) => sum.add_with_excess(self.air, &sample, [weight, excess]),
                None => sum.add(self.air, &sample, weight),
            }
        }
        let end_m = panel.distance_m(1.0);
        let totals_m: Vec<f64> = lengths
            .iter()
            .zip(densities)
            .map(|(length, samples)| length.to_m(end_m, || self.rule.total(samples)))
            .collect();
        sum.pass(self.air, &totals_m);
        Solved {
            gathered: sum,
            depth_excess: self.depth_excess(&lengths, densities),
        }
    }

    /// By how much the optical depth of a panel exceeds that of the coarse rule, by wavelength.
    fn depth_excess(&self, lengths: &[ViewLength], densities: &[Vec<f64>]) -> Vec<f64> {
        let mut depth_excess = vec![0.0; self.air.wavelengths.len()];
        for (index, constituent) in self.air.constituents.iter().enumerate() {
            let excess_m: f64 = match lengths[index] {
                ViewLength::ClosedForm { .. } => continue,
                ViewLength::Samples => {
                    let terms = self.excess.iter().zip(&densities[index]);
                    terms.map(|(excess, sample)| excess * sample).sum()
                }
            };
            for (depth, extinction_m1) in depth_excess.iter_mut().zip(&constituent.extinction_m1) {
                *depth += extinction_m1 * excess_m;
            }
        }
        depth_excess
    }

    /// Room for the samples of every constituent.
    fn no_densities(&self) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.rule.len()]; self.air.constituents.len()]
    }

    /// Density times length of ray per node, in the order along the ray.
    fn sample_densities(&self, panel: &Panel, densities: &mut [Vec<f64>]) {
        let ray = panel.ray;
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
