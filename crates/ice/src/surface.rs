//! What the surface of ice does with light, by level.

use glam::DVec3;
use niji_radiometry::Nanometers;
use niji_radiometry::ice_refractive_index;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::diffuse_surface::DiffuseSurface;
use crate::error::Error;
use crate::error::check_range;
use crate::facets::Facets;
use crate::rough_dielectric::RoughDielectric;
use crate::sampler::VertexNumbers;

/// What the surface of ice does with light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum IceSurface {
    /// Light is thrown back or goes through in any direction, by the cosine law. The published
    /// surface; which share is thrown back it leaves open.
    Diffuse {
        /// Share thrown back outside, 0 up to 1: 0.063, that of smooth ice in diffuse light, where it
        /// is left out.
        #[serde(default = "usual_outer_reflectance")]
        #[schemars(range(min = 0.0, max = 0.999))]
        outer_reflectance: f64,
        /// Share thrown back inside, 0 up to 1: 0, as light is said to run straight through and out,
        /// where it is left out. Smooth ice would have 0.45, most of it beyond the critical angle.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 0.999))]
        inner_reflectance: f64,
    },
    /// Fresnel's equations on facets of random slope.
    RoughDielectric {
        /// Width of the distribution of facets (GGX), 0.02 to 1.
        #[schemars(range(min = 0.02, max = 1.0))]
        roughness: f64,
    },
}

fn usual_outer_reflectance() -> f64 {
    0.063
}

impl IceSurface {
    /// The published surface with the reflectances that hold where none is given.
    pub const PUBLISHED: Self = Self::Diffuse {
        outer_reflectance: 0.063,
        inner_reflectance: 0.0,
    };

    /// Checks the ranges.
    ///
    /// # Errors
    /// A share outside 0 up to 1, or a roughness outside 0.02 to 1.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Diffuse {
                outer_reflectance,
                inner_reflectance,
            } => {
                let expected = "0 to 0.999";
                check_range(
                    "outer_reflectance",
                    outer_reflectance,
                    [0.0, 0.999],
                    expected,
                )?;
                check_range(
                    "inner_reflectance",
                    inner_reflectance,
                    [0.0, 0.999],
                    expected,
                )
            }
            // Sharper lobes hardly ever find the sun.
            Self::RoughDielectric { roughness } => {
                check_range("roughness", roughness, [0.02, 1.0], "0.02 to 1")
            }
        }
    }

    /// The surface at one wavelength.
    pub(crate) fn at(&self, wavelength: Nanometers) -> SurfaceAt {
        match *self {
            Self::Diffuse {
                outer_reflectance,
                inner_reflectance,
            } => SurfaceAt::Diffuse(DiffuseSurface {
                outer_reflectance,
                inner_reflectance,
            }),
            Self::RoughDielectric { roughness } => SurfaceAt::Rough(RoughDielectric {
                facets: Facets { roughness },
                refractive_index: ice_refractive_index(wavelength).0,
            }),
        }
    }
}

/// The side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Outside,
    Inside,
}

impl Side {
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Outside => Self::Inside,
            Self::Inside => Self::Outside,
        }
    }
}

/// A path that arrives at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arrival {
    /// The side that it arrives on.
    pub(crate) side: Side,
    /// Unit vector to where it came from.
    pub(crate) back: DVec3,
}

/// How a path goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scattered {
    /// Unit vector.
    pub(crate) direction: DVec3,
    /// Where it goes on.
    pub(crate) side: Side,
    /// What its light counts.
    pub(crate) weight: f64,
}

impl Scattered {
    /// All light goes on.
    pub(crate) fn all(direction: DVec3, side: Side) -> Self {
        Self {
            direction,
            side,
            weight: 1.0,
        }
    }
}

/// A surface at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SurfaceAt {
    Diffuse(DiffuseSurface),
    Rough(RoughDielectric),
}

impl SurfaceAt {
    /// How light inside counts against light outside.
    pub(crate) fn kappa(&self) -> f64 {
        match self {
            Self::Diffuse(surface) => surface.kappa(),
            Self::Rough(surface) => surface.refractive_index.powi(-2),
        }
    }

    /// What it does with a path that arrives: the share of the irradiance on a plane across `light`,
    /// which is outside, that goes to it, 1/sr, and how it goes on.
    pub(crate) fn scatter(
        &self,
        normal: DVec3,
        arrival: Arrival,
        light: DVec3,
        mut random: VertexNumbers,
    ) -> (f64, Option<Scattered>) {
        let (lit_per_sr, onwards) = match self {
            Self::Diffuse(surface) => {
                let side = arrival.side;
                let onwards = surface.sample(normal, side, random.choice_and_direction());
                (surface.towards_light(normal, side, light), Some(onwards))
            }
            Self::Rough(surface) => surface.scatter(normal, arrival, light, &mut random),
        };
        let is_lit = normal.dot(light) > 0.0;
        (if is_lit { lit_per_sr } else { 0.0 }, onwards)
    }
}
