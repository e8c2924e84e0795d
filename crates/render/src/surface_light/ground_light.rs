//! Light of the air's ground among surfaces: what they leave of sun and sky, and what they send to it.

use glam::DVec2;
use glam::DVec3;
use niji_geometry::Planet;
use niji_geometry::Ray;

use super::GROUND_M;
use super::Shade;
use super::SunThroughDrops;
use super::SurfaceLight;
use super::SurfaceRoom;
use super::dim;
use super::over_pi;
use crate::air::Air;
use crate::node_views::Seen;
use crate::node_views::View;

/// Ground at the end of a ray.
#[derive(Debug)]
pub(crate) struct Ground {
    point: DVec3,
    /// How far it is from the eye.
    eye_m: f64,
    view: View,
    through: SunThroughDrops,
    /// Share of the sky's light that drops leave.
    skylit: f64,
}

impl SurfaceLight<'_> {
    /// The ground at a distance along a ray.
    pub(crate) fn ground(&self, ray: &Ray, ground_m: f64, planet: Planet) -> Ground {
        let point = ray.at(ground_m);
        let seen = Seen {
            pixel_m: self.pixel_rad * ground_m,
            cosine: ray.direction.y.abs(),
        };
        Ground {
            point,
            eye_m: ground_m,
            view: self.view_of_ground(point, seen, planet),
            through: self.sun_through_drops(point),
            skylit: self.sky_through_drops(point),
        }
    }

    fn view_of_ground(&self, point: DVec3, seen: Seen, planet: Planet) -> View {
        if !self.has_shadows_of_surfaces() {
            return View::OPEN;
        }
        let look = |point| self.look_around((point, DVec3::Y), (DVec3::Y, None));
        let of_node = |DVec2 { x, y: z }| {
            let above = DVec3::new(x, GROUND_M, z);
            look(above - planet.height_m(above) * DVec3::Y)
        };
        let known = self.ground.at(point, seen, of_node);
        known.unwrap_or_else(|| look(point))
    }

    /// What of sun and sky reaches the ground.
    pub(crate) fn shade_of_ground(&self, ground: &Ground) -> Shade {
        let Ground { view, through, .. } = ground;
        let straight = if self.is_ground_shaded(ground.point) {
            0.0
        } else {
            through.straight
        };
        Shade {
            sun: straight + view.free * through.scattered,
            sky: view.free * ground.skylit,
        }
    }

    /// Writes what of the light that surfaces send to the ground this sends to the eye, and what that may lack.
    pub(crate) fn ground_radiance(
        &self,
        ground: &Ground,
        (ray, air): (&Ray, &Air),
        room: &mut SurfaceRoom,
    ) {
        let SurfaceRoom {
            light,
            lacking,
            around,
            ..
        } = room;
        light.fill(0.0);
        lacking.fill(0.0);
        if ground.view.senders.are_none() {
            return;
        }
        around.look((ground.point, ground.skylit), Some(air));
        self.add_sent((&ground.view, ground.through), around, [light, lacking]);
        dim(
            (ray, ground.eye_m),
            (air, &mut around.sun),
            [light, lacking],
        );
        for values in [light, lacking] {
            for (value, albedo) in values.iter_mut().zip(air.ground_albedo()) {
                *value *= over_pi(*albedo);
            }
        }
    }
}
