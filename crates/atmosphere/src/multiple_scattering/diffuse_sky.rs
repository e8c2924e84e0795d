//! Light of higher orders along a view ray, and the sky with all of them.
//!
//! L = integral of T(s) sum over c of beta_s,c rho_c sum over l of p_l,c B_l ds + T_ground A/pi F
//! `B_l` the diffuse light by degree and `F` its irradiance on the ground, from the table of the air;
//! `T` transmittance from the eye. The source is taken as linear in optical depth between shells, the
//! heights of the table and those halfway between them.

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_exchange::DiffuseLight;
use niji_exchange::DiffuseView;
use niji_geometry::Planet;

use super::shell_path::Crossing;
use super::shell_path::ShellPath;
use crate::error::Error;
use crate::view_ray::ViewRay;

/// The diffuse light of an air, as a sky.
#[derive(Debug, Clone)]
pub struct DiffuseSky<'a> {
    air: &'a AtmosphereTable,
    light: &'a DiffuseLight,
    shells_m: Vec<f64>,
}

impl<'a> DiffuseSky<'a> {
    /// The sky of an air whose table holds light of higher orders.
    ///
    /// # Errors
    /// If the table holds none, or one that does not fit the air.
    pub fn new(air: &'a AtmosphereTable) -> Result<Self, Error> {
        let light = air.diffuse.as_ref().ok_or(Error::NoDiffuseLight)?;
        if !light.is_sound(air.constituents.len(), air.wavelengths.len()) {
            return Err(Error::NoDiffuseLight);
        }
        let mut shells_m = vec![light.height_m[0]];
        for pair in light.height_m.windows(2) {
            shells_m.extend([0.5 * (pair[0] + pair[1]), pair[1]]);
        }
        Ok(Self {
            air,
            light,
            shells_m,
        })
    }

    /// Radiance along a ray by light that was scattered twice or more often, or was scattered after
    /// the ground reflected it, or is reflected by the ground after it was scattered; over the sun's
    /// irradiance, 1/sr.
    ///
    /// Added to single scattering and to the ground in direct sunlight it makes all of the sky.
    pub fn radiance_per_sun(&self, ray: &ViewRay) -> Vec<f64> {
        let n = self.air.wavelengths.len();
        let mut radiance = vec![0.0; n];
        let planet = Planet {
            radius_m: self.air.planet_radius_m,
        };
        let Some([enter_m, end_m]) = ray.in_air(planet, self.air.top_height_m) else {
            return radiance;
        };
        let start = ray.start().advanced(planet, enter_m);
        let path = ShellPath::new(self.air, &self.shells_m, start, end_m - enter_m);
        let mut by_degree = vec![0.0_f32; (self.light.max_degree + 1) * n];
        for (at, crossing) in path.crossings.iter().enumerate() {
            let [_, mu_s] = ray.sun_at(planet, enter_m + crossing.distance_m);
            let Some(place) = self.light.place(crossing.point.height_m, mu_s) else {
                continue;
            };
            let view = DiffuseView {
                cos_zenith: crossing.point.mu,
                cos_sun_zenith: mu_s,
                cos_scattering: ray.cos_scattering,
            };
            self.light.write_by_degree(place, view, &mut by_degree);
            let weights = &path.weights[at * n..(at + 1) * n];
            self.add_source(crossing, weights, &by_degree, &mut radiance);
        }
        if let Some((ground_m, transmittance)) = &path.ground {
            let [_, mu_s] = ray.sun_at(planet, enter_m + ground_m);
            let irradiance = self.light.ground_irradiance(mu_s);
            for (index, radiance) in radiance.iter_mut().enumerate() {
                let reflected = self.air.ground_albedo[index] / PI * f64::from(irradiance[index]);
                *radiance += f64::from(transmittance[index]) * reflected;
            }
        }
        // The expansion of a forward lobe oscillates behind it.
        for radiance in &mut radiance {
            *radiance = radiance.max(0.0);
        }
        radiance
    }

    /// Adds the source over the extinction at a crossing, times its weights.
    fn add_source(
        &self,
        crossing: &Crossing,
        weights: &[f32],
        by_degree: &[f32],
        radiance: &mut [f64],
    ) {
        let n = radiance.len();
        // Above the air a ray's end has no weight: any air will do.
        let height_m = crossing.point.height_m.clamp(0.0, self.air.top_height_m);
        let mut extinction = vec![0.0; n];
        let mut scattered = vec![0.0; n];
        for (index, constituent) in self.air.constituents.iter().enumerate() {
            let density = constituent.density_at(height_m);
            let moments = self.light.phase_moments_of(index);
            for (wavelength, scattered) in scattered.iter_mut().enumerate() {
                let at = |l: usize| {
                    let entry = l * n + wavelength;
                    f64::from(moments[entry] * by_degree[entry])
                };
                let light: f64 = (0..=self.light.max_degree).map(at).sum();
                extinction[wavelength] += constituent.extinction_m1[wavelength] * density;
                *scattered += constituent.scattering_m1[wavelength] * density * light;
            }
        }
        for (index, radiance) in radiance.iter_mut().enumerate() {
            if extinction[index] > 0.0 {
                *radiance += f64::from(weights[index]) * scattered[index] / extinction[index];
            }
        }
    }
}
