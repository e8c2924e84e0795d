//! The first order: sunlight scattered once, and sunlight from the ground, as moments.
//!
//! L(mu, phi) = sum over crossings k of W_k T_sun(h_k, z_k)  sum over c of w_c(h_k) P_c(nu)
//!            + T_ground A/pi mu_s T_sun
//! w_c = beta_s,c rho_c / sum over c of beta_e,c rho_c
//! `P_c` phase function up to the degree that is kept, `nu` the cosine of the scattering angle, one
//! for the whole ray, since the sun is far. Other symbols as in `gathering`. The beam of a low sun
//! fades within a layer, so shells and axis of the sun are cut finer than for light that was
//! scattered before.

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_exchange::legendre_polynomials;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::gauss_legendre::Rule;
use crate::multiple_scattering::gathering::Azimuths;
use crate::multiple_scattering::gathering::Direction;
use crate::multiple_scattering::gathering::SunShift;
use crate::multiple_scattering::gathering::SunSides;
use crate::multiple_scattering::gathering::directions;
use crate::multiple_scattering::gathering::gather_shells;
use crate::multiple_scattering::light::Light;
use crate::multiple_scattering::light::add_scaled;
use crate::multiple_scattering::medium::Medium;
use crate::multiple_scattering::sun_axis::SunAxis;
use crate::sun_beam::sun_transmittance;

/// Cuts of each step of the axis of the sun, for it sets within a degree.
pub(crate) const AXIS_CUTS: usize = 4;
/// Cuts of each layer.
const LAYER_CUTS: usize = 3;

/// The direct beam in the air.
pub(crate) struct Beam<'a> {
    air: &'a AtmosphereTable,
    medium: &'a Medium,
    shells_m: &'a [f64],
    fine_shells_m: Vec<f64>,
    axis: SunAxis,
    /// T_sun by wavelength: `[fine shell][sun of the fine axis][wavelength]`.
    transmittance: Vec<f32>,
    /// w_c: `[fine shell][scattering constituent][wavelength]`.
    shares: Vec<Vec<f32>>,
}

impl<'a> Beam<'a> {
    pub(crate) fn new(
        air: &'a AtmosphereTable,
        medium: &'a Medium,
        shells_m: &'a [f64],
        axis: SunAxis,
    ) -> Self {
        let fine_shells_m = refined(shells_m, LAYER_CUTS);
        let mut transmittance = Vec::new();
        for &shell_m in &fine_shells_m {
            for &mu_s in axis.cosines() {
                let shares = sun_transmittance(air, shell_m, mu_s, Radians(0.0));
                // f32: as all light.
                transmittance.extend(shares.into_iter().map(|share| share as f32));
            }
        }
        Self {
            air,
            medium,
            shells_m,
            shares: medium.shares_at_shells(air, &fine_shells_m),
            fine_shells_m,
            axis,
            transmittance,
        }
    }

    /// The light at the nodes over the suns of `axis`.
    ///
    /// # Errors
    /// What `go_on` says.
    pub(crate) fn gather<E: Send>(
        &self,
        axis: &SunAxis,
        n_zeniths: usize,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Light, E> {
        let azimuths = Azimuths::new(self.medium.max_degree, self.medium.max_degree);
        let sides = SunSides {
            axis,
            azimuths: &azimuths,
        };
        let rule = Rule::new(n_zeniths);
        let n = self.air.wavelengths.len();
        gather_shells(self.shells_m.len(), go_on, |shell| {
            let mut light = azimuths.dark(axis, n);
            let mut radiance = vec![0.0_f32; sides.len() * n];
            let height_m = self.shells_m[shell];
            for direction in directions(self.air, &self.fine_shells_m, height_m, &rule) {
                self.radiances(&direction, sides, &mut radiance);
                azimuths.add(&direction, &radiance, &mut light);
            }
            light
        })
    }

    /// Radiance from one direction: `[sun][azimuth][wavelength]`.
    fn radiances(&self, direction: &Direction, sides: SunSides, radiance: &mut [f32]) {
        radiance.fill(0.0);
        let n = self.air.wavelengths.len();
        let planet = Planet {
            radius_m: self.air.planet_radius_m,
        };
        let weighted = self.weighted_shares(direction);
        let block = weighted.len() / direction.path.crossings.len().max(1);
        let mut phases = vec![0.0_f32; block];
        let shift = |distance_m: f64| SunShift::new(planet, direction, distance_m);
        let crossings = &direction.path.crossings;
        let shifts: Vec<SunShift> = crossings
            .iter()
            .map(|crossing| shift(crossing.distance_m))
            .collect();
        sides.each(direction, |side| {
            let target = &mut radiance[side.row * n..(side.row + 1) * n];
            self.write_phases(side.cos_scattering, &mut phases);
            let weighted = weighted.chunks(block.max(1));
            for ((crossing, shift), weighted) in crossings.iter().zip(&shifts).zip(weighted) {
                let Some(shell) = crossing.shell else {
                    continue;
                };
                let mu_s = shift.cos_sun_zenith(side);
                let Some([(near, a), (far, b)]) = self.beam_at(shell, mu_s) else {
                    continue;
                };
                for (weighted, phases) in weighted.chunks(n).zip(phases.chunks(n)) {
                    let source = weighted.iter().zip(phases).zip(a.iter().zip(b));
                    for (target, ((weight, phase), (a, b))) in target.iter_mut().zip(source) {
                        *target += weight * phase * (near * a + far * b);
                    }
                }
            }
        });
        if let Some((ground_m, transmittance)) = &direction.path.ground {
            let shift = shift(*ground_m);
            sides.each(direction, |side| {
                let mu_s = shift.cos_sun_zenith(side);
                let target = &mut radiance[side.row * n..(side.row + 1) * n];
                self.add_ground(mu_s, transmittance, target);
            });
        }
    }

    /// Sunlight that the ground reflects.
    fn add_ground(&self, mu_s: f64, transmittance: &[f32], target: &mut [f32]) {
        let beam = self.beam_at(0, mu_s).filter(|_| mu_s > 0.0);
        let Some([(near, a), (far, b)]) = beam else {
            return;
        };
        let spectra = target.iter_mut().zip(transmittance);
        let spectra = spectra.zip(&self.air.ground_albedo).zip(a.iter().zip(b));
        for (((target, transmittance), albedo), (a, b)) in spectra {
            let reflectance = (albedo / PI * mu_s) as f32;
            *target += transmittance * reflectance * (near * a + far * b);
        }
    }

    /// T_sun at a fine shell: weights and spectra of the nodes around a sun.
    fn beam_at(&self, shell: usize, mu_s: f64) -> Option<[(f32, &[f32]); 2]> {
        let n = self.air.wavelengths.len();
        let (low, share) = self.axis.place(mu_s)?;
        let start = (shell * self.axis.len() + low) * n;
        let nodes = &self.transmittance[start..start + 2 * n];
        Some([(1.0 - share, &nodes[..n]), (share, &nodes[n..])])
    }

    /// W_k w_c: `[crossing][scattering constituent][wavelength]`.
    fn weighted_shares(&self, direction: &Direction) -> Vec<f32> {
        let n = self.air.wavelengths.len();
        let mut weighted = Vec::new();
        let weights = direction.path.weights.chunks(n.max(1));
        for (crossing, weights) in direction.path.crossings.iter().zip(weights) {
            // All crossings of a ray from a shell are shells.
            let shares = &self.shares[crossing.shell.unwrap_or(0)];
            for shares in shares.chunks(n.max(1)) {
                weighted.extend(
                    shares
                        .iter()
                        .zip(weights)
                        .map(|(share, weight)| share * weight),
                );
            }
        }
        weighted
    }

    /// P_c up to the degree that is kept: `[scattering constituent][wavelength]`.
    fn write_phases(&self, nu: f64, phases: &mut [f32]) {
        let n = self.air.wavelengths.len();
        phases.fill(0.0);
        let polynomials = legendre_polynomials(self.medium.max_degree, nu);
        let scatterers = self.medium.scatterers();
        for (moments, target) in scatterers.zip(phases.chunks_mut(n.max(1))) {
            for (l, (polynomial, moments)) in polynomials.iter().zip(moments).enumerate() {
                let factor = (2.0 * l as f64 + 1.0) / (4.0 * PI) * polynomial;
                add_scaled(target, factor as f32, moments);
            }
        }
    }
}

/// Each step of an axis cut into so many.
fn refined(axis: &[f64], n_cuts: usize) -> Vec<f64> {
    let cut = |i: usize| i as f64 / n_cuts as f64;
    let mut fine: Vec<f64> = axis
        .windows(2)
        .flat_map(|pair| (0..n_cuts).map(move |i| pair[0] + (pair[1] - pair[0]) * cut(i)))
        .collect();
    fine.extend(axis.last());
    fine
}
