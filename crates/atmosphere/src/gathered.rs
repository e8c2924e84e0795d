//! What a view ray gathers of each constituent: a length, by wavelength.
//!
//! G_j(lambda) = integral of rho_j exp(-tau_view - tau_sun) ds   [m]
//! L(lambda) = E_sun(lambda) sum over j of  beta_j(lambda) P_j(lambda, theta) G_j(lambda)
//! The sun is distant, so the scattering angle theta is one for the whole ray and the phase function
//! P_j stands before the integral. G_j knows neither and is smooth in the ray's direction, which is
//! why a sky can be tabulated. Only constituents that scatter have one.

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;

use crate::exponential::exp_minus;

/// What one point of the view ray contributes, by constituent.
pub(crate) struct Sample {
    pub(crate) density: Vec<f64>,
    /// Equivalent length from the start of the panel, m.
    pub(crate) view_m: Vec<f64>,
    /// Equivalent length towards the sun, m.
    pub(crate) sun_m: Vec<f64>,
}

impl Sample {
    pub(crate) fn new(n_constituents: usize) -> Self {
        let zeros = vec![0.0; n_constituents];
        Self {
            density: zeros.clone(),
            view_m: zeros.clone(),
            sun_m: zeros,
        }
    }
}

/// Running sums along a ray.
pub(crate) struct Gathered {
    /// G_j, m: one row of wavelengths for each constituent, empty where nothing is scattered.
    pub(crate) lengths_m: Vec<Vec<f64>>,
    /// By how much these exceed what a coarser rule finds at the same nodes, m; empty where no rule
    /// does.
    pub(crate) excess_m: Vec<Vec<f64>>,
    /// Optical depth passed so far, by wavelength.
    pub(crate) depth: Vec<f64>,
    /// Share of the light that arrives by way of the sample at hand, by wavelength.
    share: Vec<f64>,
}

impl Gathered {
    /// Nothing gathered yet.
    pub(crate) fn new(air: &AtmosphereTable) -> Self {
        let zeros = vec![0.0; air.wavelengths.len()];
        let row = |constituent: &AirConstituent| {
            if scatters(constituent) {
                zeros.clone()
            } else {
                Vec::new()
            }
        };
        Self {
            lengths_m: air.constituents.iter().map(row).collect(),
            excess_m: Vec::new(),
            depth: zeros.clone(),
            share: zeros,
        }
    }

    /// Nothing gathered yet, behind an optical depth.
    pub(crate) fn behind(air: &AtmosphereTable, depth: &[f64]) -> Self {
        let mut empty = Self::new(air);
        empty.depth.copy_from_slice(depth);
        empty
    }

    /// Adds what was gathered behind the optical depth passed so far.
    pub(crate) fn append(&mut self, next: &Self) {
        for (lengths_m, next) in self.lengths_m.iter_mut().zip(&next.lengths_m) {
            for (length_m, next) in lengths_m.iter_mut().zip(next) {
                *length_m += next;
            }
        }
        self.depth.copy_from_slice(&next.depth);
    }

    /// Radiance over the sun's irradiance, 1/sr, for beta P(theta) by constituent and wavelength.
    pub(crate) fn radiance_per_sun(&self, directed: &[Vec<f64>]) -> Vec<f64> {
        let mut radiance = vec![0.0; self.depth.len()];
        for (directed, lengths_m) in directed.iter().zip(&self.lengths_m) {
            for ((radiance, directed), length_m) in radiance.iter_mut().zip(directed).zip(lengths_m)
            {
                *radiance += directed * length_m;
            }
        }
        radiance
    }

    /// Adds one sample. Constituents outside, wavelengths inside: the loops run over spectra.
    pub(crate) fn add(&mut self, air: &AtmosphereTable, sample: &Sample, weight: f64) {
        self.find_share(air, sample);
        add_weighted(&mut self.lengths_m, &self.share, &sample.density, weight);
    }

    /// Adds one sample, and to the excess what its weight exceeds that of the coarser rule by.
    pub(crate) fn add_with_excess(
        &mut self,
        air: &AtmosphereTable,
        sample: &Sample,
        [weight, excess]: [f64; 2],
    ) {
        self.add(air, sample, weight);
        add_weighted(&mut self.excess_m, &self.share, &sample.density, excess);
    }

    /// Finds the share of the light that arrives by way of a sample.
    fn find_share(&mut self, air: &AtmosphereTable, sample: &Sample) {
        self.share.copy_from_slice(&self.depth);
        for (index, constituent) in air.constituents.iter().enumerate() {
            let length_m = sample.view_m[index] + sample.sun_m[index];
            for (depth, extinction_m1) in self.share.iter_mut().zip(&constituent.extinction_m1) {
                *depth += extinction_m1 * length_m;
            }
        }
        for share in &mut self.share {
            *share = exp_minus(*share);
        }
    }

    /// Share of the light that passes the whole ray; below 1e-26 only a bound.
    pub(crate) fn transmittance(&self) -> Vec<f64> {
        self.depth.iter().map(|depth| (-depth).exp()).collect()
    }

    /// Adds what equivalent lengths, by constituent, dim.
    pub(crate) fn pass(&mut self, air: &AtmosphereTable, lengths_m: &[f64]) {
        for (constituent, length_m) in air.constituents.iter().zip(lengths_m) {
            for (depth, extinction_m1) in self.depth.iter_mut().zip(&constituent.extinction_m1) {
                *depth += extinction_m1 * length_m;
            }
        }
    }
}

/// Adds a sample to lengths.
fn add_weighted(lengths_m: &mut [Vec<f64>], share: &[f64], density: &[f64], weight: f64) {
    for (lengths_m, density) in lengths_m.iter_mut().zip(density) {
        let stretch_m = weight * density;
        for (length_m, share) in lengths_m.iter_mut().zip(share) {
            *length_m += stretch_m * share;
        }
    }
}

/// Whether a constituent scatters at any wavelength.
pub(crate) fn scatters(constituent: &AirConstituent) -> bool {
    constituent
        .scattering_m1
        .iter()
        .any(|&scattering| scattering > 0.0)
}
