//! The air along given rays, one row per ray and wavelength: what `niji eval air` prints.

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::in_scattering::InScattering;
use crate::in_scattering::SingleScattering;
use crate::multiple_scattering::DiffuseSky;
use crate::sun_beam::sun_transmittance;
use crate::view_ray::ViewRay;

/// The air along one ray at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirSample {
    /// Index of the ray among those given.
    pub ray_index: usize,
    /// Center of the bin, nm.
    pub wavelength_nm: f64,
    /// Optical depth of the ray, up to the ground if it ends there.
    pub optical_depth: f64,
    /// Share of the light that passes.
    pub transmittance: f64,
    /// Radiance scattered once into the ray, W m^-2 sr^-1 nm^-1.
    pub in_scattering: f64,
    /// Radiance that arrives along the ray from the air and from the ground where it ends there,
    /// W m^-2 sr^-1 nm^-1; of all orders where the table of the air holds diffuse light.
    pub radiance: f64,
    /// Optical depth from the observer to the center of the sun; infinite behind the ground.
    pub sun_optical_depth: f64,
    /// Share of the sun's light that arrives at the observer.
    pub sun_transmittance: f64,
}

/// Evaluates rays at every wavelength of the air.
pub fn evaluate_rays(
    air: &AtmosphereTable,
    rays: &[ViewRay],
    method: InScattering,
    sun_disc_radius: Radians,
) -> Vec<AirSample> {
    let solver = SingleScattering::new(air, method);
    let diffuse = DiffuseSky::new(air).ok();
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    let mut samples = Vec::with_capacity(rays.len() * air.wavelengths.len());
    for (ray_index, ray) in rays.iter().enumerate() {
        let light = solver.solve(ray);
        let mut radiance = if ray.ends_on_ground(planet) {
            solver.sky_radiance(ray)
        } else {
            light.radiance.clone()
        };
        if let Some(diffuse) = &diffuse {
            let more = diffuse.radiance_per_sun(ray).into_iter();
            let more = more.zip(&air.sun_irradiance);
            for (radiance, (more, sun)) in radiance.iter_mut().zip(more) {
                *radiance += more * sun;
            }
        }
        let sun = sun_transmittance(air, ray.height_m, ray.cos_sun_zenith, sun_disc_radius);
        let depths = view_optical_depths(air, ray);
        for (index, wavelength) in air.wavelengths.centers().enumerate() {
            samples.push(AirSample {
                ray_index,
                wavelength_nm: wavelength.0,
                optical_depth: depths[index],
                transmittance: (-depths[index]).exp(),
                in_scattering: light.radiance[index],
                radiance: radiance[index],
                sun_optical_depth: air.optical_depth_at(index, ray.height_m, ray.cos_sun_zenith),
                sun_transmittance: sun[index],
            });
        }
    }
    samples
}

/// Optical depth of a view ray by wavelength, up to the ground if it ends there.
fn view_optical_depths(air: &AtmosphereTable, ray: &ViewRay) -> Vec<f64> {
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    let mut depths = vec![0.0; air.wavelengths.len()];
    let Some([_, end_m]) = ray.in_air(planet, air.top_height_m) else {
        return depths;
    };
    for (index, constituent) in air.constituents.iter().enumerate() {
        let length_m = air.segment_length(index, ray.height_m, ray.cos_zenith, end_m);
        for (depth, extinction_m1) in depths.iter_mut().zip(&constituent.extinction_m1) {
            *depth += extinction_m1 * length_m;
        }
    }
    depths
}
