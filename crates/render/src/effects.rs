//! Which effects take part in a picture. What is off is decided once, before the first ray.

use glam::DVec3;

use crate::levels::SkyModel;

/// Whether an effect takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toggle {
    /// It takes part.
    On,
    /// It is left out and costs nothing.
    Off,
}

impl Toggle {
    /// Whether the effect takes part.
    pub fn is_on(self) -> bool {
        match self {
            Self::On => true,
            Self::Off => false,
        }
    }
}

/// The effects of the ray integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RenderEffects {
    /// Light at scattering angles from the table's split upwards: the primary bow, its
    /// supernumeraries and what lies inside it.
    pub primary_bow: Toggle,
    /// Light at scattering angles below the split: the secondary bow and what lies outside it.
    pub secondary_bow: Toggle,
    /// Light that is neither bow's, on both sides of the split: what else the table holds.
    pub higher_orders: Toggle,
    /// Drops between a point and the eye take light away, also from what shines behind them.
    pub drop_extinction: Toggle,
    /// Drops between a point and the sun take light away.
    pub drop_shadow: Toggle,
    /// Drops scatter the light of the surroundings, so that a curtain of rain before a bright sky is
    /// not a dark band.
    pub skylit_drops: Toggle,
    /// Air on the sun's way to the drops takes light away.
    pub sunlight_through_air: Toggle,
    /// Air between the drops and the eye takes light away.
    pub air_extinction: Toggle,
    /// Air from the eye to the far side of the drops scatters sunlight to the eye.
    pub air_inscatter: Toggle,
    /// Air beyond the drops, the whole ray where there are none, and the ground.
    pub sky: Toggle,
    /// Surfaces with an albedo send light of sun and sky, and the ground has the shadow of drops and surfaces.
    pub lit_surfaces: Toggle,
}

impl RenderEffects {
    /// Whether sky and ground stand behind the drops.
    pub(crate) fn shows_sky(&self, model: SkyModel) -> bool {
        self.sky.is_on() && model != SkyModel::None
    }

    /// Whether the ground, at y = 0, hides drops below it: where it is seen, but from an eye that is below itself.
    #[must_use]
    pub fn ground_hides(&self, model: SkyModel, eye: DVec3) -> bool {
        self.shows_sky(model) && eye.y >= 0.0
    }

    /// The bows alone: drops in a vacuum that neither dim nor shadow each other, the published form.
    pub const BOWS_ONLY: Self = Self {
        primary_bow: Toggle::On,
        secondary_bow: Toggle::On,
        higher_orders: Toggle::Off,
        drop_extinction: Toggle::Off,
        drop_shadow: Toggle::Off,
        skylit_drops: Toggle::Off,
        sunlight_through_air: Toggle::Off,
        air_extinction: Toggle::Off,
        air_inscatter: Toggle::Off,
        sky: Toggle::Off,
        lit_surfaces: Toggle::Off,
    };

    /// Everything.
    pub const ALL: Self = Self {
        primary_bow: Toggle::On,
        secondary_bow: Toggle::On,
        higher_orders: Toggle::On,
        drop_extinction: Toggle::On,
        drop_shadow: Toggle::On,
        skylit_drops: Toggle::On,
        sunlight_through_air: Toggle::On,
        air_extinction: Toggle::On,
        air_inscatter: Toggle::On,
        sky: Toggle::On,
        lit_surfaces: Toggle::On,
    };
}
