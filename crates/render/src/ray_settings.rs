//! How finely a ray is followed.

use niji_geometry::Ray;

use crate::air::Air;
use crate::air_glow::AirGlow;
use crate::march::March;

/// How a ray is followed.
#[derive(Clone, Copy)]
pub(crate) struct RaySettings<'a> {
    /// The march through the drops, of the level or a finer one.
    pub(crate) march: &'a March<'a>,
    /// The air, where any of its effects is on.
    pub(crate) air: Option<&'a Air<'a>>,
    /// Nodes of the air's light.
    pub(crate) glow: &'a AirGlow,
    /// Scattering angle that the pixel spans (0: a point).
    pub(crate) width_rad: f64,
}

/// A ray on its way through drops.
#[derive(Clone, Copy)]
pub(crate) struct RayThroughDrops<'a> {
    pub(crate) ray: &'a Ray,
    /// Distances between which it may meet them (m).
    pub(crate) range_m: (f64, f64),
    pub(crate) settings: RaySettings<'a>,
}
