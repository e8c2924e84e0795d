//! Names of the levels of accuracy in scene files and in JSON.
//!
//! The levels belong to the crates that run them, which know no files; here they get their spelling.
//! The compiler keeps both in step.

use niji_dropfield::Interpolation;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::MirroredLight;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_render::SunPath;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// How the integral along a view ray is taken.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Integration", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum IntegrationName {
    /// Equal steps with the midpoint rule.
    FixedStep {
        /// Length of a step, m.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        step_m: f64,
    },
    /// Cell by cell, exact for the interpolated moments.
    CellExact,
    /// Cell by cell, with as many pieces and Gauss points as the error asks for.
    Adaptive {
        /// Largest relative error of the light of a piece.
        #[schemars(range(min = 1e-12, max = 1.0))]
        relative_error: f64,
    },
}

/// What is interpolated between the nodes of the drop volume.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Interpolation", rename_all = "kebab-case")]
pub(crate) enum InterpolationName {
    /// Radius and number density, as in publications.
    RadiusDensity,
    /// Moments of the size law: light and water are conserved.
    Moments,
}

/// Which part of the drops' extinction leaves the picture.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "DropExtinctionModel", rename_all = "kebab-case")]
pub(crate) enum DropExtinctionName {
    /// Q = 1: diffracted light goes on within a lobe narrower than the bow.
    WithoutDiffraction,
    /// Q = 2: the whole extinction.
    Full,
}

/// How often light is scattered by drops.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "DropOrders", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum DropOrdersName {
    /// Once.
    SingleScattering,
    /// Any number of times, by random paths on a coarse lattice of view directions.
    MultipleScattering {
        /// Directions along both sides of the coarse lattice; four times as many share the rest of the time.
        #[schemars(range(min = 2, max = 128))]
        nodes_across: usize,
        /// Paths for every direction of the coarse lattice.
        #[schemars(range(min = 2, max = 1_048_576))]
        paths_per_node: usize,
    },
}

/// The drops' optical depth towards the sun.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "SunPath", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum SunPathName {
    /// Drops cast no shadow on drops.
    Ignore,
    /// A volume of optical depth, swept away from the sun.
    Volume {
        /// Distance of its nodes, m.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        voxel_m: f64,
    },
    /// A march from every node of the drops to the sun.
    March {
        /// Length of a step, m.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        step_m: f64,
    },
}

/// The air's optical depths.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "AirPath", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum AirPathName {
    /// Air as dense along every ray as at the eye.
    Constant,
    /// Equal steps with the midpoint rule.
    Midpoint {
        /// Steps on each path.
        #[schemars(range(min = 1, max = 1_000_000))]
        n_steps: usize,
    },
    /// Gauss-Legendre nodes.
    Quadrature {
        /// Nodes on each path.
        #[schemars(range(min = 1, max = 256))]
        n_nodes: usize,
    },
    /// Columns that were integrated when the table of the air was made.
    Table,
}

/// What shines behind the drops.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "SkyModel", rename_all = "kebab-case")]
pub(crate) enum SkyName {
    /// Black.
    None,
    /// Sunlight scattered once by the air, and the ground in direct sunlight.
    SingleScattering,
    /// Besides, light that air and ground scattered before.
    MultipleScattering,
}

/// What of a pixel is seen.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(
    remote = "PixelFootprint",
    rename_all = "kebab-case",
    deny_unknown_fields
)]
pub(crate) enum PixelFootprintName {
    /// The ray through its center.
    Center,
    /// The ray through its center, with the table averaged over the pixel.
    Prefiltered,
    /// n x n rays.
    Grid {
        /// Rays along a side of the pixel.
        #[schemars(range(min = 1, max = 64))]
        n: u32,
    },
}

/// What of the light that water mirrors is followed.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "MirroredLight", rename_all = "kebab-case")]
pub(crate) enum MirroredLightName {
    /// Its irradiance alone, as if it were natural light.
    Natural,
    /// Its polarization too.
    Polarized,
}

/// A module that reads and writes an optional level by its name.
macro_rules! optional_level {
    ($module:ident, $level:ident, $name:literal) => {
        pub(crate) mod $module {
            use serde::Deserialize;
            use serde::Deserializer;
            use serde::Serialize;
            use serde::Serializer;

            use super::*;

            #[derive(Serialize, Deserialize)]
            struct Named(#[serde(with = $name)] $level);

            #[expect(clippy::ref_option, reason = "serde calls it so")]
            pub(crate) fn serialize<S: Serializer>(
                level: &Option<$level>,
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                (*level).map(Named).serialize(serializer)
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Option<$level>, D::Error> {
                Ok(Option::<Named>::deserialize(deserializer)?.map(|named| named.0))
            }
        }
    };
}

optional_level!(integration, Integration, "IntegrationName");
optional_level!(interpolation, Interpolation, "InterpolationName");
optional_level!(drop_extinction, DropExtinctionModel, "DropExtinctionName");
optional_level!(drop_orders, DropOrders, "DropOrdersName");
optional_level!(sun_path, SunPath, "SunPathName");
optional_level!(air_path, AirPath, "AirPathName");
optional_level!(sky, SkyModel, "SkyName");
optional_level!(pixel_footprint, PixelFootprint, "PixelFootprintName");
optional_level!(mirrored_light, MirroredLight, "MirroredLightName");
