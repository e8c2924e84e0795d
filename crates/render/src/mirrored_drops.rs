//! Drops that know how much of the sun in the water reaches them.
//!
//! tau(x) = int_p^x pi M2 ds + tau_sun(p)   at Q = 1, `p` where the light is mirrored that reaches x
//!
//! Sunlight that water mirrors comes by two ways through the drops, down to the water and up again. Both are
//! swept, or marched, through the drops above the water; the first ends where it enters them from p. Waves do
//! not bend either: shadows are those of still water.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::Ray;

use crate::error::Error;
use crate::levels::SunPath;
use crate::lit_drops::marched_depth;
use crate::lit_drops::store;
use crate::progress::unwatched;
use crate::shadow_error::ShadowError;
use crate::sun_sweep::SunSweep;
use crate::water_surface::MirroredLight;
use crate::water_surface::WaterSurface;
use crate::water_surface::mirrored;

/// A sun in the water.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror {
    pub(crate) surface: WaterSurface,
    pub(crate) light: MirroredLight,
    /// Towards the sun itself.
    pub(crate) sun_direction: DVec3,
}

/// The drops in the light of a sun in the water.
#[derive(Clone, Debug)]
pub(crate) struct MirroredDrops {
    pub(crate) mirror: Mirror,
    /// With the optical depth to the sun by way of the water.
    pub(crate) bricks: Vec<Bricks>,
    /// Of the way from the drops to the water.
    pub(crate) shadow_error: Option<ShadowError>,
}

impl MirroredDrops {
    /// Find the optical depth by way of the water at the nodes of all modes; `above` is their box above it.
    ///
    /// # Errors
    /// [`Error::SunVolumeTooLarge`] if the level asks for too many nodes.
    pub(crate) fn new(
        drops: &[Bricks],
        (mirror, above): (Mirror, Aabb),
        sun_path: SunPath,
    ) -> Result<Self, Error> {
        let mut lit = Self {
            mirror,
            bricks: drops.to_vec(),
            shadow_error: None,
        };
        let progress = &unwatched;
        let up = mirror.sun_direction;
        let down = mirrored(up);
        let from_foot = |point: DVec3| Ray {
            origin: mirror.surface.foot(point, up),
            direction: up,
        };
        match sun_path {
            SunPath::Ignore => (),
            SunPath::Volume { voxel_m } => {
                let sweep = |towards: DVec3| {
                    SunSweep::over(above, towards, voxel_m)?.through(drops, progress)
                };
                let (sweep_down, sweep_up) = (sweep(down)?, sweep(up)?);
                store(&mut lit.bricks, progress, |_, point| sweep_down.at(point))?;
                lit.shadow_error = Some(ShadowError::of(&lit.bricks, above, down));
                let depth_up = |ray: Ray| {
                    let enter_m = above.intersect(&ray).map(|(enter_m, _)| enter_m);
                    enter_m.map_or(0.0, |enter_m| sweep_up.at(ray.at(enter_m)))
                };
                store(&mut lit.bricks, progress, |_, point| {
                    sweep_down.at(point) + depth_up(from_foot(point))
                })?;
            }
            SunPath::March { step_m } => {
                let to_water = |origin: DVec3| Ray {
                    origin,
                    direction: down,
                };
                let depth =
                    |bricks: &[Bricks], ray: Ray| marched_depth(bricks, above, &ray, step_m);
                store(&mut lit.bricks, progress, |bricks, point| {
                    depth(bricks, to_water(point))
                })?;
                lit.shadow_error = Some(ShadowError::of(&lit.bricks, above, down));
                store(&mut lit.bricks, progress, |bricks, point| {
                    depth(bricks, to_water(point)) + depth(bricks, from_foot(point))
                })?;
            }
        }
        Ok(lit)
    }
}
