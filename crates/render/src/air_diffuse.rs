//! Light that air and ground scattered before, scattered once more towards the eye.
//!
//! J = sum_c beta_s,c rho_c(h) sum_l p_l,c B_l    [1/(m sr)], for unit sun irradiance
//!
//! `B_l` diffuse light by degree from the air's table ([`DiffuseLight`]), `p_l,c` moments of the phase
//! function of constituent c, `beta_s,c` its scattering coefficient [1/m], `rho_c` relative density.
//! The light is there in the planet's shadow too: it makes the twilight.
//!
//! On a face with the normal n it has the irradiance
//! E(n) = c sum_l a_l B_l(n),   a_0 = pi, a_1 = 2 pi/3, a_2 = pi/4, a_4 = -pi/24, all other up to 5 are 0
//! `B_l(n)` its part of degree l in the direction of n, `c` by wavelength, so that level ground has what the table
//! says of it: few degrees cannot part sky from ground.
//! [RH01] R. Ramamoorthi and P. Hanrahan, J. Opt. Soc. Am. A 18, 2448-2459 (2001).

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

/// A face in the air.
pub(crate) struct FaceOfAir<'a> {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    /// What the air leaves of sunlight there, by wavelength.
    pub(crate) sunlight: &'a [f32],
}

/// a_l of degrees 0 to 4.
const OF_COSINE: [f32; 5] = [
    std::f32::consts::PI,
    2.0 * std::f32::consts::FRAC_PI_3,
    std::f32::consts::FRAC_PI_4,
    0.0,
    -std::f32::consts::PI / 24.0,
];

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
        self.on_level(ray.at(ground_m))
    }

    /// Irradiance on level ground at a point, by wavelength.
    pub(crate) fn on_level(&self, point: DVec3) -> Vec<f32> {
        let cos_sun = self.planet.cos_zenith(point, self.sun_direction);
        self.light.ground_irradiance(cos_sun)
    }

    /// Irradiance on a face, by wavelength, to which surfaces leave shares of the sky and of the ground with an albedo.
    pub(crate) fn on_face(
        &self,
        face: &FaceOfAir,
        ([sky, ground], albedo): ([f64; 2], &[f64]),
    ) -> Vec<f32> {
        let zenith = self.planet.zenith(face.point);
        let cos_sun = self.planet.cos_zenith(face.point, self.sun_direction);
        let level = self.light.ground_irradiance(cos_sun);
        let expanded =
            |height_m: f64, normal: DVec3| self.expanded((height_m, cos_sun), zenith, normal);
        let on_level = expanded(0.0, zenith);
        let height_m = self.planet.height_m(face.point).max(0.0);
        let mut light = expanded(height_m, face.normal);
        let down = (0.5 * (1.0 - face.normal.dot(zenith))) as f32;
        for (index, light) in light.iter_mut().enumerate() {
            let of_sun = cos_sun.max(0.0) as f32 * face.sunlight[index];
            let of_ground = albedo[index] as f32 * down * (level[index] + of_sun);
            let all = if on_level[index] > 0.0 {
                *light * level[index] / on_level[index]
            } else {
                0.0
            };
            *light = sky as f32 * (all - of_ground).max(0.0) + ground as f32 * of_ground;
        }
        light
    }

    /// The sum over degrees at a height under a sun.
    fn expanded(&self, (height_m, cos_sun): (f64, f64), zenith: DVec3, normal: DVec3) -> Vec<f32> {
        let n = self.light.n_wavelengths();
        let mut sum = vec![0.0; n];
        let Some(place) = self.light.place(height_m, cos_sun) else {
            return sum;
        };
        let view = DiffuseView {
            cos_zenith: zenith.dot(normal).clamp(-1.0, 1.0),
            cos_sun_zenith: cos_sun,
            cos_scattering: normal.dot(self.sun_direction).clamp(-1.0, 1.0),
        };
        let mut by_degree = vec![0.0; (self.light.max_degree + 1) * n];
        self.light.write_by_degree(place, view, &mut by_degree);
        for (weight, light) in OF_COSINE.iter().zip(by_degree.chunks(n)) {
            for (sum, light) in sum.iter_mut().zip(light) {
                *sum += weight * light;
            }
        }
        sum
    }
}
