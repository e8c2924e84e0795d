//! Names of the levels of accuracy in scene files and in JSON.
//!
//! The levels belong to the crates that run them, which know no files; here they get their spelling.
//! The compiler keeps both in step.

use niji_dropfield::Interpolation;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_render::SunPath;
use serde::Deserialize;
use serde::Serialize;

#[derive(Serialize, Deserialize)]
#[serde(remote = "Integration", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum IntegrationName {
    FixedStep { step_m: f64 },
    CellExact,
    Adaptive { relative_error: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Interpolation", rename_all = "kebab-case")]
pub(crate) enum InterpolationName {
    RadiusDensity,
    Moments,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DropExtinctionModel", rename_all = "kebab-case")]
pub(crate) enum DropExtinctionName {
    WithoutDiffraction,
    Full,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DropOrders", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum DropOrdersName {
    SingleScattering,
    MultipleScattering {
        nodes_across: usize,
        paths_per_node: usize,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SunPath", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum SunPathName {
    Ignore,
    Volume { voxel_m: f64 },
    March { step_m: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "AirPath", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum AirPathName {
    Constant,
    Midpoint { n_steps: usize },
    Quadrature { n_nodes: usize },
    Table,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SkyModel", rename_all = "kebab-case")]
pub(crate) enum SkyName {
    None,
    SingleScattering,
    MultipleScattering,
}

#[derive(Serialize, Deserialize)]
#[serde(
    remote = "PixelFootprint",
    rename_all = "kebab-case",
    deny_unknown_fields
)]
pub(crate) enum PixelFootprintName {
    Center,
    Prefiltered,
    Grid { n: u32 },
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
