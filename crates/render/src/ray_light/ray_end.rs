//! What a view ray ends on, where that is lit: a surface, or ground that surfaces light.

use niji_geometry::Ray;

use super::RayLight;
use crate::air::Air;
use crate::frame::Frame;
use crate::surface_light::Ground;
use crate::surface_light::Spot;
use crate::surface_light::SurfaceLight;
use crate::surfaces::Sight;

impl Frame<'_> {
    /// Where the air on a sight ends (m): water lies in the ground, not on it.
    pub(super) fn air_ends_m(&self, sight: &Sight) -> f64 {
        let ground_m = sight.foot.and_then(|_| self.ground_m(&sight.ray));
        ground_m.map_or(sight.surface_m, |ground_m| ground_m.min(sight.surface_m))
    }

    /// The lit place at the end of a sight; `None` where it ends on the ground, or nothing is lit.
    pub(crate) fn lit_spot(&self, sight: &Sight) -> Option<Spot> {
        self.lit.as_ref()?;
        let spot = Spot::of(sight)?;
        let ground_m = self.ground_m(&sight.ray);
        let is_hidden = self.glows.1 && ground_m.is_some_and(|it| it < sight.surface_m);
        (!is_hidden).then_some(spot)
    }

    /// Light of the surface that ends a ray.
    pub(super) fn add_surface(
        &self,
        lit: &SurfaceLight,
        (sight, air): (&Sight, Option<&Air>),
        out: &mut RayLight,
    ) {
        let Some(spot) = self.lit_spot(sight) else {
            return;
        };
        out.glows = true;
        lit.radiance(&spot, (sight, air), &mut out.scratch.surface);
        let through = self.left_behind(out);
        let room = &out.scratch.surface;
        out.errors.surfaces = through * self.luminance(&room.lacking);
        let lights = self.irradiance.iter().zip(&room.light);
        for (surface, (irradiance, light)) in out.lit_surface.iter_mut().zip(lights) {
            *surface = irradiance * through as f32 * light;
        }
    }

    /// Light that surfaces send to the ground that ends a ray.
    pub(super) fn add_sent_to_ground(
        &self,
        (lit, ground): (&SurfaceLight, &Ground),
        (ray, air): (&Ray, &Air),
        out: &mut RayLight,
    ) {
        lit.ground_radiance(ground, (ray, air), &mut out.scratch.surface);
        let through = self.left_behind(out);
        let room = &out.scratch.surface;
        out.errors.surfaces = through * self.luminance(&room.lacking);
        let lights = self.irradiance.iter().zip(&room.light);
        for (sky, (irradiance, light)) in out.sky.iter_mut().zip(lights) {
            *sky += irradiance * through as f32 * light;
        }
    }
}
