//! Light that air and ground scattered before, scattered once more towards the eye.
//!
//! J = sum_c beta_s,c rho_c(h) sum_l p_l,c B_l    [1/(m sr)], for unit sun irradiance
//!
//! `B_l` diffuse light by degree from the air's table ([`DiffuseLight`]), `p_l,c` moments of the phase
//! function of constituent c, `beta_s,c` its scattering coefficient [1/m], `rho_c` relative density.
//! The light is there in the planet's shadow too: it makes the twilight.

use glam::DVec3;
use niji_exchange::AtmosphereTable;
use niji_exchange::DiffuseLight;
use niji_exchange::DiffuseView;
use niji_geometry::Planet;
use niji_geometry::Ray;

use crate::air::Lengths;

/// A point of a view ray.
#[derive(Clone, Copy)]
pub(crate) struct PointOfRay<'a> {
    pub(crate) ray: &'a Ray,
    /// Its distance from the eye.
    pub(crate) distance_m: f64,
}

/// The diffuse light of an air.
#[derive(Clone)]
pub(crate) struct DiffuseAir<'a> {
    light: &'a DiffuseLight,
    planet: Planet,
    sun_direction: DVec3,
    /// Constituents that scatter.
    scatterers: Vec<Scatterer>,
}

#[derive(Clone)]
struct Scatterer {
    constituent_index: usize,
    /// beta_s p_l by degree, then wavelength [1/m], up to the last degree that is not 0.
    // f32: as the light.
    moments_m1: Vec<f32>,
}

impl<'a> DiffuseAir<'a> {
    /// The light in an air whose table was checked; `None` where it has none.
    pub(crate) fn new(air: &'a AtmosphereTable, sun_direction: DVec3) -> Option<Self> {
        let light = air.diffuse.as_ref()?;
        let scatterer =
            |(constituent_index, constituent): (usize, &niji_exchange::AirConstituent)| {
                let n = constituent.scattering_m1.len();
                let betas = constituent.scattering_m1.iter().cycle();
                let moments = light.phase_moments_of(constituent_index).iter().zip(betas);
                let mut moments_m1: Vec<f32> = moments
                    .map(|(moment, beta)| (f64::from(*moment) * beta) as f32)
                    .collect();
                let n_used = moments_m1.iter().rposition(|moment| *moment != 0.0)? + 1;
                moments_m1.truncate(n_used.div_ceil(n) * n);
                Some(Scatterer {
                    constituent_index,
                    moments_m1,
                })
            };
        Some(Self {
            light,
            planet: Planet {
                radius_m: air.planet_radius_m,
            },
            sun_direction,
            scatterers: air
                .constituents
                .iter()
                .enumerate()
                .filter_map(scatterer)
                .collect(),
        })
    }

    /// Write the source towards the eye at a distance on a view ray, by wavelength, for relative
    /// densities (or those times a length). `room` is taken to work in.
    pub(crate) fn source(
        &self,
        at: PointOfRay,
        densities: &Lengths,
        room: &mut Vec<f32>,
        out: &mut [f32],
    ) {
        out.fill(0.0);
        let ray = at.ray;
        let point = ray.at(at.distance_m);
        let view = DiffuseView {
            cos_zenith: self.planet.cos_zenith(point, ray.direction),
            cos_sun_zenith: self.planet.cos_zenith(point, self.sun_direction),
            cos_scattering: ray.direction.dot(self.sun_direction),
        };
        let height_m = self.planet.height_m(point);
        let Some(place) = self.light.place(height_m, view.cos_sun_zenith) else {
            return;
        };
        let n = out.len();
        room.resize((self.light.max_degree + 1) * n, 0.0);
        self.light.write_by_degree(place, view, room);
        for scatterer in &self.scatterers {
            // f32: spectra leave in f32.
            let density = densities[scatterer.constituent_index] as f32;
            for (moments_m1, light) in scatterer.moments_m1.chunks(n).zip(room.chunks(n)) {
                for ((out, moment), light) in out.iter_mut().zip(moments_m1).zip(light) {
                    *out += density * moment * light;
                }
            }
        }
        // The expansion of a forward lobe oscillates behind it.
        for out in out {
            *out = out.max(0.0);
        }
    }

    /// Irradiance on the ground at the end of a ray, by wavelength.
    pub(crate) fn on_ground(&self, ray: &Ray, ground_m: f64) -> Vec<f32> {
        let cos_sun = self.planet.cos_zenith(ray.at(ground_m), self.sun_direction);
        self.light.ground_irradiance(cos_sun)
    }
}
