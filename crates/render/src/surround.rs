//! The light of the surroundings that drops scatter into the view, at its cheapest level.
//!
//! L_drops = (1 - T) S,   S = (1/4 pi) int L_surround domega
//!
//! `T = exp(-tau)` is what the drops let pass without diffraction (Q = 1), `S` the mean of sky and
//! ground over the sphere. Drops do not absorb: what they take out of the view they give back from
//! elsewhere, and this is that balance with the phase function replaced by a constant. So in a
//! uniform surround T S + (1 - T) S = S: the drops are invisible, as they must be. Forward-peaked
//! scattering of a bright horizon is what it misses.

use std::f64::consts::TAU;
use std::num::NonZeroUsize;

use glam::DVec3;
use niji_geometry::Ray;

use crate::air::Air;
use crate::air_glow::AirGlow;
use crate::air_glow::Glow;
use crate::air_glow::GlowNodes;
use crate::air_glow::GlowRange;
use crate::air_glow::GlowRay;
use crate::gauss_nodes::GaussRule;
use crate::scattering_angle::scattering_angle_rad;
use crate::surface_light::Shade;

/// Gauss nodes of the cosine of the zenith angle in each hemisphere.
const N_COSINES: NonZeroUsize = NonZeroUsize::new(8).unwrap();

/// Nodes of the air's light on long stretches of a direction.
const N_NODES: usize = 24;

/// Azimuths around the zenith.
const N_AZIMUTHS: usize = 16;

/// Mean radiance of sky and ground over all directions at a point, for unit sun irradiance [1/sr].
pub(crate) fn mean_surround(air: &Air, at: DVec3, n_wavelengths: usize) -> Vec<f32> {
    let mut sum = vec![0.0_f32; n_wavelengths];
    let glow = AirGlow::new(N_NODES);
    let mut light = Glow::dark(n_wavelengths, 0);
    let mut nodes = GlowNodes::default();
    let range = GlowRange {
        drops_m: None,
        surface_m: f64::INFINITY,
        in_front: false,
        beyond: true,
        lost: false,
    };
    for hemisphere in [-1.0, 1.0] {
        for (cosine, weight) in GaussRule::new(N_COSINES).nodes() {
            for azimuth in 0..N_AZIMUTHS {
                let azimuth = TAU * (azimuth as f64 + 0.5) / N_AZIMUTHS as f64;
                let sine = (1.0 - cosine * cosine).sqrt();
                let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
                let direction =
                    DVec3::new(sine * sin_azimuth, hemisphere * cosine, -sine * cos_azimuth);
                let ray = Ray {
                    origin: at,
                    direction,
                };
                glow.lay_out(air, &ray, &range, &mut nodes);
                light.clear();
                let theta_rad = scattering_angle_rad(direction, air.sun_direction());
                let glow_ray = GlowRay {
                    air,
                    rules: &glow,
                    ray: &ray,
                    theta_rad,
                    dimmed_by_drops: None,
                    ground_shade: Shade::NONE,
                };
                light.gather(&glow_ray, &nodes);
                let share = (0.5 * weight / N_AZIMUTHS as f64) as f32;
                for (sum, value) in sum.iter_mut().zip(&light.beyond) {
                    *sum += share * value;
                }
            }
        }
    }
    sum
}

/// Light of the surroundings from drops of transmittance T.
pub(crate) fn skylit_radiance(transmittance: f64, surround: f32) -> f32 {
    (1.0 - transmittance) as f32 * surround
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_a_uniform_surround_drops_are_invisible() {
        for depth in [0.0, 1e-9, 0.3, 1.0, 12.0, 1e3_f64] {
            let transmittance = (-depth).exp();
            let seen = transmittance as f32 * 0.7 + skylit_radiance(transmittance, 0.7);
            assert!((seen - 0.7).abs() < 1e-6, "{depth}");
        }
    }
}
