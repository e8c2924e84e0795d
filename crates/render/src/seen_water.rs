//! Water that is seen: what of drops, air, surfaces and sun it mirrors into a view ray.
//!
//! L = T_drops T_air sum_k W_k [R_k L_k + B_k] + sun
//! `W_k` share of the facets of stratum k (`wave_facets`), `R` = (R_s + R_p)/2, `L_k` light along the ray that goes on from
//! them, of air, surfaces and drops that scatter more than once, as if it were natural; `B_k` light of the bows there,
//! mirrored by its polarization (`polarized_rows`); the sun by `sun_glint`, dimmed by drops and surfaces on its way and by air. `T` what
//! drops and air in front of the water let pass. The ray that goes on is followed as any other, but for water.
//!
//! Left out: polarization of the sky and of what the mirrored sun lights; light that goes on from facet to facet, which
//! counts as mirrored once; waves do not hide edges, nor blur what stands behind the drops by more than five strata
//! do. Light of further orders in the water is that which the eye itself has in that direction.

use niji_geometry::Ray;

use crate::air_glow::both_ways;
use crate::flattening::axis_squares;
use crate::frame::Frame;
use crate::frame::FrameBasis;
use crate::mirrored_table::Polarization;
use crate::polarized_rows::LitAngles;
use crate::polarized_rows::PolarizedRoom;
use crate::polarized_rows::PolarizedRows;
use crate::ray_light::RayLight;
use crate::ray_settings::RaySettings;
use crate::request::RenderRequest;
use crate::scattering_angle::scattering_angle_rad;
use crate::scattering_rows::ScatteringRows;
use crate::spectra::multiply;
use crate::sun_glint::Glint;
use crate::sun_glint::glint;
use crate::sun_streak::cos_2_between;
use crate::surface_light::SurfaceLight;
use crate::surfaces::Sight;
use crate::surfaces::Surfaces;
use crate::water_reflectance::water_reflectance;
use crate::water_surface::Foot;
use crate::water_surface::WaterSurface;
use crate::wave_facets::Facet;
use crate::wave_facets::facets_seen;

/// Steps of the table's angles over the slope of the waves.
const STEP: f64 = 0.3;

/// Water that is seen, and what all rays share of its light.
pub(crate) struct SeenWater<'a> {
    surface: WaterSurface,
    surfaces: Option<&'a Surfaces>,
    /// Refractive index by wavelength.
    indices: Vec<f64>,
    /// Bows by polarization, where they are wanted.
    bows: Option<PolarizedRows<'a>>,
    /// What shades it.
    shade: SurfaceLight<'a>,
}

/// A thread's room for the light of water.
#[derive(Clone, Debug)]
pub(crate) struct WaterRoom {
    /// What the eye has of it [W m^-2 sr^-1 nm^-1].
    pub(crate) light: Vec<f32>,
    beyond: RayLight,
    /// (R_s + R_p)/2 and (R_s - R_p)/2 of a facet.
    natural: Vec<f32>,
    polarized: Vec<f32>,
    transmitted: Vec<f32>,
}

impl WaterRoom {
    pub(crate) fn new(frame: &Frame) -> Self {
        let dark = vec![0.0; frame.irradiance.len()];
        Self {
            light: dark.clone(),
            beyond: RayLight::beyond_water(frame),
            natural: dark.clone(),
            polarized: dark.clone(),
            transmitted: dark,
        }
    }

    /// Forget the pixel before.
    pub(crate) fn begin_pixel(&mut self) {
        self.beyond.begin_pixel();
    }

    /// Take note of what a facet reflects.
    fn reflect(&mut self, indices: &[f64], cos_incidence: f64) {
        let sums = self.natural.iter_mut().zip(&mut self.polarized);
        for ((natural, polarized), index) in sums.zip(indices) {
            let [s, p] = water_reflectance(*index, cos_incidence);
            *natural = (0.5 * (s + p)) as f32;
            *polarized = (0.5 * (s - p)) as f32;
        }
    }
}

impl<'a> SeenWater<'a> {
    /// The water of a picture in which drops are seen by these rows.
    pub(crate) fn new(
        request: &RenderRequest<'a>,
        (basis, surface): (&FrameBasis<'a>, WaterSurface),
        rows: Option<&ScatteringRows>,
    ) -> Self {
        let wavelengths = &request.wavelengths;
        let centers = (0..wavelengths.len()).map(|bin| wavelengths.center(bin));
        let bows = request.table.zip(rows).map(|(table, rows)| {
            let angles = (rows.angles().theta_range_rad(), STEP * surface.slope);
            PolarizedRows::new((request, table), basis, angles, &Polarization::BOTH)
        });
        Self {
            surface,
            surfaces: request.surfaces,
            indices: centers
                .map(|center| surface.water.refractive_index(center))
                .collect(),
            bows,
            shade: SurfaceLight::of_sun(request),
        }
    }

    /// Bows by polarization.
    pub(crate) fn bows(&self) -> Option<&PolarizedRows<'a>> {
        self.bows.as_ref()
    }

    /// The rows, to be checked.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        self.bows.iter().flat_map(PolarizedRows::rows)
    }

    /// Room for the bows in it.
    pub(crate) fn room(&self, n_wavelengths: usize) -> Option<PolarizedRoom> {
        Some(self.bows.as_ref()?.room(n_wavelengths))
    }

    /// The sight from a foot that a facet makes.
    fn sight_on(&self, foot: &Foot, facet: &Facet) -> Sight {
        let ray = Ray {
            origin: foot.point,
            direction: facet.direction,
        };
        match self.surfaces {
            Some(surfaces) => surfaces.sight(ray),
            None => Sight {
                ray,
                surface_m: f64::INFINITY,
                face: None,
                foot: None,
            },
        }
    }
}

impl Frame<'_> {
    /// How a sight goes on from water at its end, facet by facet.
    pub(crate) fn sights_in_water(&self, sight: &Sight) -> Vec<Sight> {
        let Some((water, foot)) = self.water.as_ref().zip(sight.foot) else {
            return Vec::new();
        };
        let facets = facets_seen(water.surface.slope, sight.ray.direction, foot.up);
        let sights = facets.iter().map(|facet| water.sight_on(&foot, facet));
        sights.collect()
    }

    /// Whether water that is seen is a mirror.
    pub(crate) fn has_still_water(&self) -> bool {
        let water = self.water.as_ref();
        water.is_some_and(|water| water.surface.slope == 0.0)
    }

    /// Whether the sun is seen in water at the end of a sight.
    pub(crate) fn shows_sun(&self, sight: &Sight) -> bool {
        let water = self.water.as_ref().zip(sight.foot);
        water.is_some_and(|(water, foot)| {
            let is_seen = self.glint(water, sight, &foot).is_some();
            is_seen && !water.shade.is_ground_shaded(foot.point)
        })
    }

    fn glint(&self, water: &SeenWater, sight: &Sight, foot: &Foot) -> Option<Glint> {
        let towards = [-sight.ray.direction, self.sun_direction];
        glint(water.surface.slope, foot.up, towards)
    }

    /// Add the light of water that ends a ray.
    pub(crate) fn add_water(
        &self,
        water: &SeenWater,
        (sight, foot): (&Sight, &Foot),
        settings: RaySettings,
        out: &mut RayLight,
    ) {
        let Some(mut room) = out.water_room().take() else {
            return;
        };
        let direction = sight.ray.direction;
        for facet in facets_seen(water.surface.slope, direction, foot.up) {
            room.reflect(&water.indices, facet.cos_incidence);
            self.add_facet(
                water,
                (&water.sight_on(foot, &facet), &facet),
                settings,
                &mut room,
            );
            let share = facet.share * out.transmittance;
            out.errors.add(share, 1.0, &room.beyond.errors);
            out.errors.air += share * self.front_error(&room);
        }
        room.light
            .iter_mut()
            .for_each(|light| *light *= out.transmittance as f32);
        if let Some(air) = settings.air {
            let ray = air.ray(sight.ray.origin, direction);
            air.transmit(&air.to_eye(ray, sight.surface_m), &mut room.transmitted);
            multiply(&mut room.light, &room.transmitted);
        }
        self.add_glint(
            water,
            (sight, foot),
            settings,
            (&mut room, out.transmittance),
        );
        out.glows = true;
        *out.water_room() = Some(room);
    }

    /// Add what a facet shows, as if nothing were in front of it.
    fn add_facet(
        &self,
        water: &SeenWater,
        (sight, facet): (&Sight, &Facet),
        settings: RaySettings,
        room: &mut WaterRoom,
    ) {
        let sun = self.sun_direction;
        let WaterRoom {
            light,
            beyond,
            natural,
            polarized,
            ..
        } = room;
        if let (Some(bows), Some(room)) = (&water.bows, beyond.bows_room()) {
            let theta_rad = scattering_angle_rad(facet.direction, sun);
            let off = |direction| scattering_angle_rad(direction, sun) - theta_rad;
            let [along, across] = facet.beside.map(off);
            let angles = LitAngles {
                theta_rad,
                sd_rad: along.hypot(across),
                width_rad: settings.width_rad,
                axis_squares: axis_squares(facet.direction, sun),
            };
            bows.place(&angles, room);
            let cos_2_alpha = cos_2_between(facet.across, sun.cross(facet.direction));
            PolarizedRows::light(natural, (polarized, cos_2_alpha), room);
        }
        self.trace((sight, self.range_m(sight)), settings, beyond);
        let share = facet.share as f32;
        for (index, sum) in light.iter_mut().enumerate() {
            let beside = beyond.beside();
            let even: f32 = beside.iter().filter_map(|part| part.get(index)).sum();
            let multiple = beyond.multiple.get(index).copied().unwrap_or_default();
            let reflected = beyond.reflected().get(index).copied().unwrap_or_default();
            *sum += share * (natural[index] * (even + multiple + reflected) + beyond.bow[index]);
        }
    }

    /// Error of luminance of the air in front of the drops that a facet shows [cd/m²].
    fn front_error(&self, room: &WaterRoom) -> f64 {
        let beyond = &room.beyond;
        let weights = self.luminance_weights.iter().zip(&self.irradiance);
        let light = beyond.inscatter.iter().zip(&room.natural);
        let terms = weights.zip(light).filter(|((_, sun), _)| **sun > 0.0);
        let luminance = terms.map(|((weight, sun), (inscatter, reflected))| {
            weight * f64::from(inscatter * reflected / sun)
        });
        beyond.front_error * luminance.sum::<f64>()
    }

    /// Add the sun in the water.
    fn add_glint(
        &self,
        water: &SeenWater,
        (sight, foot): (&Sight, &Foot),
        settings: RaySettings,
        (room, through_drops): (&mut WaterRoom, f64),
    ) {
        let Some(glint) = self.glint(water, sight, foot) else {
            return;
        };
        let seen = through_drops * glint.light * water.shade.sun_on_ground(foot.point);
        if let Some(air) = settings.air {
            let Some(to_sun) = air.to_sun(foot.point) else {
                return;
            };
            let ray = air.ray(sight.ray.origin, sight.ray.direction);
            let to_eye = air.to_eye(ray, sight.surface_m);
            air.transmit(&both_ways(&to_sun, &to_eye), &mut room.transmitted);
        } else {
            room.transmitted.fill(1.0);
        }
        room.reflect(&water.indices, glint.cos_incidence);
        for (index, sum) in room.light.iter_mut().enumerate() {
            let light = self.irradiance[index] * room.transmitted[index] * room.natural[index];
            *sum += seen as f32 * light;
        }
    }
}
