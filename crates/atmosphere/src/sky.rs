//! Radiance of the sky and of the ground below it, lit by the sun alone.
//!
//! sky     L = light scattered once along the whole ray
//! ground  L = that up to the ground + T (albedo/pi) E_sun mu_s T_sun,  a diffuse reflector
//! The sun's own disc is not included. Single scattering misses 8 to 60 % of a clear sky (most in
//! blue, at a right angle to the sun).

use std::f64::consts::PI;

use niji_geometry::Planet;

use crate::in_scattering::SingleScattering;
use crate::leg::RayPoint;
use crate::sun_beam::sun_irradiance_at;
use crate::sun_disc::SUN_RADIUS;
use crate::view_ray::ViewRay;

impl SingleScattering<'_> {
    /// Radiance that arrives along a ray of any length from air and ground, W m^-2 sr^-1 nm^-1.
    pub fn sky_radiance(&self, ray: &ViewRay) -> Vec<f64> {
        let ray = ViewRay {
            length_m: f64::INFINITY,
            ..*ray
        };
        let mut light = self.solve(&ray);
        let air = self.air();
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let Some(ground_m) = planet.distance_to_ground(ray.height_m, ray.cos_zenith) else {
            return light.radiance;
        };
        let start = RayPoint {
            height_m: ray.height_m,
            mu: ray.cos_zenith,
        };
        let height_m = start.advanced(planet, ground_m).height_m;
        let [_, mu_s] = ray.sun_at(planet, ground_m);
        if mu_s > 0.0 {
            let irradiance = sun_irradiance_at(air, height_m, mu_s, SUN_RADIUS);
            for (index, radiance) in light.radiance.iter_mut().enumerate() {
                let reflected = air.ground_albedo[index] / PI * mu_s * irradiance[index];
                *radiance += light.transmittance[index] * reflected;
            }
        }
        light.radiance
    }
}
