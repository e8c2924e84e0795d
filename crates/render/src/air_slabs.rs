//! Air in front of the drops and between them and the sun, slab by slab along a view ray.
//!
//! Light W that drops send from distances s with weights w(s) is dimmed by the air as
//! int w(s) exp(-tau(s)) ds ~ W exp(-tau(m)) (1 + tau'² V / 2)
//! `tau` optical depth of the air from the sun to s and from s to the eye, `m` and `V` mean and
//! variance of s over the light of the slab, tau' the slope of tau. The next term is
//! -tau'³ <(s - m)³>/6: with slabs over which tau changes by 0.25 at most it is below 1e-4, and a
//! bow's spectrum is touched once a slab.

use niji_geometry::Ray;

use crate::air::Air;
use crate::air::Lengths;
use crate::air::MAX_CONSTITUENTS;
use crate::deposits::Deposits;
use crate::gauss_nodes::AirRay;

/// Change of the air's optical depth over a slab at the wavelength where it is largest.
const SLAB_DEPTH: f64 = 0.25;

/// Air of optical depth 16 across the drops is more than any eye looks through.
const MAX_SLABS: usize = 64;

/// Which air dims the light of the drops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DimmedBy {
    /// Air between the sun and the drops.
    pub(crate) sunlight: bool,
    /// Air between the drops and the eye.
    pub(crate) view: bool,
}

impl DimmedBy {
    /// No air at all.
    pub(crate) fn nothing(self) -> bool {
        !self.sunlight && !self.view
    }
}

/// A view ray through air.
pub(crate) struct AirSlabs<'a> {
    air: &'a Air<'a>,
    dimmed_by: DimmedBy,
    ray: &'a Ray,
    air_ray: AirRay,
    /// d l_c/ds by constituent.
    slopes: Lengths,
}

/// The part of a ray that crosses drops, and the air that dims it.
#[derive(Clone, Copy)]
pub(crate) struct AirWay<'a> {
    pub(crate) air: &'a Air<'a>,
    pub(crate) dimmed_by: DimmedBy,
    pub(crate) ray: &'a Ray,
    /// Distances from the eye where it begins and ends (m).
    pub(crate) range_m: (f64, f64),
}

impl<'a> AirSlabs<'a> {
    /// Cut the part of a ray that crosses drops into slabs, whose ends go to `ends_m`.
    pub(crate) fn cut(way: AirWay<'a>, ends_m: &mut Vec<f64>) -> Self {
        let AirWay {
            air,
            dimmed_by,
            ray,
            range_m,
        } = way;
        let air_ray = air.ray(ray.origin, ray.direction);
        let mut slabs = Self {
            air,
            dimmed_by,
            ray,
            air_ray,
            slopes: [0.0; MAX_CONSTITUENTS],
        };
        ends_m.clear();
        let length_m = range_m.1 - range_m.0;
        let ends = (slabs.lengths(range_m.0), slabs.lengths(range_m.1));
        let n_slabs = if let (Some(first), Some(last)) = ends {
            let change = std::array::from_fn(|index| last[index] - first[index]);
            slabs.slopes = change.map(|change: f64| change / length_m);
            (air.largest_depth(&change) / SLAB_DEPTH)
                .ceil()
                .clamp(1.0, MAX_SLABS as f64) as usize
        } else {
            // The planet's shadow ends somewhere on the way.
            MAX_SLABS
        };
        let end = |slab: usize| range_m.0 + length_m * slab as f64 / n_slabs as f64;
        ends_m.extend((1..n_slabs).map(end));
        slabs
    }

    /// What the air leaves of a slab's light, by wavelength; 0 where the sun has set.
    pub(crate) fn transmit(&self, light: &Deposits, out: &mut [f32]) {
        let mean_m = light.light_m / light.light;
        let variance_m2 = (light.light_m2 / light.light - mean_m * mean_m).max(0.0);
        let Some(lengths) = self.lengths(mean_m) else {
            out.fill(0.0);
            return;
        };
        // tau' first, for the spread of distances in the slab.
        let spread = self.slopes.map(|slope| slope * variance_m2.sqrt());
        let mut bend = vec![0.0_f32; out.len()];
        self.air.optical_depth(&spread, &mut bend);
        self.air.transmit(&lengths, out);
        for (value, bend) in out.iter_mut().zip(&bend) {
            *value *= 1.0 + 0.5 * bend * bend;
        }
    }

    /// Lengths from the sun to a point of the ray and on to the eye.
    fn lengths(&self, distance_m: f64) -> Option<Lengths> {
        let mut sum = [0.0; MAX_CONSTITUENTS];
        if self.dimmed_by.sunlight {
            sum = self.air.to_sun(self.ray.at(distance_m))?;
        }
        if self.dimmed_by.view {
            let view = self.air.to_eye(self.air_ray, distance_m);
            sum = std::array::from_fn(|index| sum[index] + view[index]);
        }
        Some(sum)
    }
}
