//! Radiance of the sky and of the ground below it, lit by the sun alone.
//!
//! sky     L = light scattered once along the whole ray
//! ground  L = that up to the ground + T (albedo/pi) E_sun mu_s T_sun,  a diffuse reflector
//! The sun's own disc is not included. Single scattering misses 8 to 60 % of a clear sky (most in
//! blue, at a right angle to the sun).

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;

use crate::in_scattering::SingleScattering;
use crate::leg::RayPoint;
use crate::sun_beam::sun_transmittance;
use crate::sun_disc::SUN_RADIUS;
use crate::view_ray::ViewRay;

impl SingleScattering<'_> {
    /// Radiance that arrives along a ray of any length from air and ground, W m^-2 sr^-1 nm^-1.
    pub fn sky_radiance(&self, ray: &ViewRay) -> Vec<f64> {
        let ray = ViewRay {
            length_m: f64::INFINITY,
            ..*ray
        };
        let light = self.solve(&ray);
        let ground = self.ground_radiance(&ray, &light.transmittance);
        light
            .radiance
            .into_iter()
            .zip(ground)
            .map(|(air, ground)| air + ground)
            .collect()
    }

    /// Sunlight that the ground at the end of a ray gives back and the air lets through, W m^-2 sr^-1
    /// nm^-1; zeros where the ray does not end on the ground.
    pub(crate) fn ground_radiance(&self, ray: &ViewRay, transmittance: &[f64]) -> Vec<f64> {
        let air = self.air();
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let dark = vec![0.0; air.wavelengths.len()];
        let Some(ground_m) = planet.distance_to_ground(ray.height_m, ray.cos_zenith) else {
            return dark;
        };
        let start = RayPoint {
            height_m: ray.height_m,
            mu: ray.cos_zenith,
        };
        let height_m = start.advanced(planet, ground_m).height_m;
        let [_, mu_s] = ray.sun_at(planet, ground_m);
        if mu_s <= 0.0 {
            return dark;
        }
        let sun = sun_transmittance(air, height_m, mu_s, SUN_RADIUS);
        let reflected = reflected_by_ground(air, transmittance).into_iter().zip(sun);
        reflected
            .map(|(reflected, sun)| mu_s * sun * reflected)
            .collect()
    }
}

/// What the ground gives back of a sun in the zenith without air, through air of a transmittance:
/// T (albedo/pi) E_sun, W m^-2 sr^-1 nm^-1.
pub(crate) fn reflected_by_ground(air: &AtmosphereTable, transmittance: &[f64]) -> Vec<f64> {
    let spectra = transmittance
        .iter()
        .zip(&air.ground_albedo)
        .zip(&air.sun_irradiance);
    spectra
        .map(|((share, albedo), sun)| share * albedo / PI * sun)
        .collect()
}
