//! Light that air and ground scattered already: what a volume of air scatters besides sunlight.
//!
//! X_lm(h, z) = integral over directions of L(mu, phi) Y_lm(mu) cos(m phi) domega
//! per unit irradiance by the sun above the air; `h` height, `z` the sun's zenith angle there, `mu` and
//! `phi` where the light comes from: the cosine of its zenith angle and its azimuth from the sun's.
//! Moments serve every constituent, for each scatters them on its own: into a view the source is
//!   J(mu, phi) = sum over c of beta_c rho_c sum over l of p_l,c B_l(mu, phi)    [1/(m sr)]
//!   B_l(mu, phi) = (2l+1)/(4 pi) sum over m of (2 - delta_m0) Y_lm(mu) cos(m phi) X_lm
//! `beta_c` scattering coefficient, `rho_c` relative density, `p_l,c` moments of the phase function. J
//! holds sunlight scattered twice or more often, and light from the ground. X is linear between
//! heights and between zenith angles of the sun, as it was when it was solved: what interpolation
//! misses is part of the error of the level that solved it (1.4 % of all light at the usual one, 0.1 %
//! in clear air, against discrete ordinates).

use super::harmonics::cosines_of_multiples;
use super::harmonics::expansion_weights;
use super::harmonics::harmonics;
use super::harmonics::moment_index;
use super::harmonics::n_moments;
use super::ray_start::safe_sqrt;

/// Largest degree that a table may have: 33 orders of azimuth, more than any haze needs.
pub(super) const LARGEST_DEGREE: usize = 32;

/// The diffuse light in an air under suns of all heights.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseLight {
    /// Heights, m, rising.
    pub height_m: Vec<f64>,
    /// Zenith angles of the sun, rad, rising from 0. Beyond the last there is no light.
    pub sun_zenith_rad: Vec<f64>,
    /// Largest degree of the moments, 1 to 32.
    pub max_degree: usize,
    /// X over the sun's irradiance: `[height][sun][moment][wavelength]`, the last one fastest.
    // f32: the light is known to 1e-3.
    pub moments: Vec<f32>,
    /// Irradiance on the ground over the sun's above the air: `[sun][wavelength]`.
    pub on_ground: Vec<f32>,
    /// Moments of each constituent's phase function, 1 for degree 0:
    /// `[constituent][degree][wavelength]`.
    pub phase_moments: Vec<f32>,
}

/// A point in the air, for lookups: nodes around it with their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffusePlace {
    /// Index of a node, height slowest, and its weight.
    corners: [(usize, f64); 4],
}

/// A direction of view at a point under a sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseView {
    /// Cosine of the zenith angle of the view.
    pub cos_zenith: f64,
    /// Cosine of the sun's zenith angle at the point.
    pub cos_sun_zenith: f64,
    /// Cosine of the angle between view and sun, of the scattering angle.
    pub cos_scattering: f64,
}

impl DiffuseLight {
    /// Whether all sizes fit, axes rise and every number is finite.
    pub fn is_sound(&self, n_constituents: usize, n_wavelengths: usize) -> bool {
        let axes = [&self.height_m, &self.sun_zenith_rad];
        let rises = |axis: &Vec<f64>| {
            axis.len() >= 2
                && axis.iter().all(|value| value.is_finite())
                && axis.windows(2).all(|pair| pair[0] < pair[1])
        };
        let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let n_suns = self.sun_zenith_rad.len();
        (1..=LARGEST_DEGREE).contains(&self.max_degree)
            && axes.into_iter().all(rises)
            && self.moments.len()
                == self.height_m.len() * n_suns * n_moments(self.max_degree) * n_wavelengths
            && self.on_ground.len() == n_suns * n_wavelengths
            && self.phase_moments.len() == n_constituents * (self.max_degree + 1) * n_wavelengths
            && [&self.moments, &self.on_ground, &self.phase_moments]
                .into_iter()
                .all(|values| finite(values))
    }

    /// Number of wavelengths.
    pub fn n_wavelengths(&self) -> usize {
        self.on_ground.len() / self.sun_zenith_rad.len().max(1)
    }

    /// The nodes around a height under a sun; `None` where the sun is so low that no light is left.
    ///
    /// Below the lowest height and above the highest the light is what it is there.
    ///
    /// # Panics
    /// If an axis has fewer than two values; so do the other lookups.
    pub fn place(&self, height_m: f64, cos_sun_zenith: f64) -> Option<DiffusePlace> {
        let (sun, sun_share) = self.place_sun(cos_sun_zenith)?;
        let above = self.height_m.partition_point(|&node_m| node_m <= height_m);
        let low = above.clamp(1, self.height_m.len() - 1) - 1;
        let (from_m, to_m) = (self.height_m[low], self.height_m[low + 1]);
        let share = ((height_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0);
        let node = |height: usize, sun: usize| height * self.sun_zenith_rad.len() + sun;
        Some(DiffusePlace {
            corners: [
                (node(low, sun), (1.0 - share) * (1.0 - sun_share)),
                (node(low, sun + 1), (1.0 - share) * sun_share),
                (node(low + 1, sun), share * (1.0 - sun_share)),
                (node(low + 1, sun + 1), share * sun_share),
            ],
        })
    }

    /// Node below a sun and share of the next; `None` beyond the axis.
    fn place_sun(&self, cos_sun_zenith: f64) -> Option<(usize, f64)> {
        let zenith_rad = cos_sun_zenith.clamp(-1.0, 1.0).acos();
        let above = self
            .sun_zenith_rad
            .partition_point(|&node| node <= zenith_rad);
        if above >= self.sun_zenith_rad.len() || zenith_rad.is_nan() {
            return None;
        }
        let low = above.saturating_sub(1);
        let (from, to) = (self.sun_zenith_rad[low], self.sun_zenith_rad[low + 1]);
        Some((low, ((zenith_rad - from) / (to - from)).clamp(0.0, 1.0)))
    }

    /// Writes B_l towards an eye that looks along `view`: `[degree][wavelength]`, 1/sr.
    ///
    /// # Panics
    /// If `by_degree` has no room for every degree and wavelength.
    pub fn write_by_degree(&self, place: DiffusePlace, view: DiffuseView, by_degree: &mut [f32]) {
        let n = self.n_wavelengths();
        let by_degree = &mut by_degree[..(self.max_degree + 1) * n];
        by_degree.fill(0.0);
        let y = harmonics(self.max_degree, view.cos_zenith);
        let mut cosines = [0.0; LARGEST_DEGREE + 1];
        cosines_of_multiples(view.cos_azimuth(), &mut cosines[..=self.max_degree]);
        let expansion = expansion_weights(self.max_degree);
        let block = n_moments(self.max_degree) * n;
        for (node, weight) in place.corners {
            let moments = &self.moments[node * block..(node + 1) * block];
            for (l, row) in by_degree.chunks_exact_mut(n.max(1)).enumerate() {
                for (m, cosine) in cosines.iter().enumerate().take(l + 1) {
                    let pair = moment_index(l, m);
                    // f32: as the light.
                    let factor = (weight * expansion[pair] * y[pair] * cosine) as f32;
                    for (sum, moment) in row.iter_mut().zip(&moments[pair * n..(pair + 1) * n]) {
                        *sum += factor * moment;
                    }
                }
            }
        }
    }

    /// Irradiance on level ground by all diffuse light, over the sun's above the air, by wavelength.
    pub fn ground_irradiance(&self, cos_sun_zenith: f64) -> Vec<f32> {
        let n = self.n_wavelengths();
        let Some((low, share)) = self.place_sun(cos_sun_zenith) else {
            return vec![0.0; n];
        };
        let rows = self.on_ground[low * n..(low + 2) * n].split_at(n);
        let share = share as f32;
        rows.0
            .iter()
            .zip(rows.1)
            .map(|(low, high)| low * (1.0 - share) + high * share)
            .collect()
    }

    /// Net downward flux of the diffuse light through a level surface, over the sun's irradiance
    /// above the air, by wavelength.
    pub fn net_flux(&self, height_m: f64, cos_sun_zenith: f64) -> Vec<f64> {
        let n = self.n_wavelengths();
        let mut flux = vec![0.0; n];
        let Some(place) = self.place(height_m, cos_sun_zenith) else {
            return flux;
        };
        for (node, weight) in place.corners {
            let start = (node * n_moments(self.max_degree) + moment_index(1, 0)) * n;
            for (sum, moment) in flux.iter_mut().zip(&self.moments[start..start + n]) {
                *sum += weight * f64::from(*moment);
            }
        }
        flux
    }

    /// Moments of a constituent's phase function: `[degree][wavelength]`.
    pub fn phase_moments_of(&self, constituent_index: usize) -> &[f32] {
        let block = (self.max_degree + 1) * self.n_wavelengths();
        &self.phase_moments[constituent_index * block..(constituent_index + 1) * block]
    }
}

impl DiffuseView {
    /// Cosine of the azimuth between view and sun; 1 where there is no azimuth, and nothing depends
    /// on it.
    pub fn cos_azimuth(self) -> f64 {
        let (mu, mu_s, nu) = (self.cos_zenith, self.cos_sun_zenith, self.cos_scattering);
        let sines = safe_sqrt((1.0 - mu) * (1.0 + mu)) * safe_sqrt((1.0 - mu_s) * (1.0 + mu_s));
        if sines > 0.0 {
            ((nu - mu * mu_s) / sines).clamp(-1.0, 1.0)
        } else {
            1.0
        }
    }
}
