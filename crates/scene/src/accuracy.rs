//! Levels of accuracy of a scene: a preset, and levels of single stages that replace the preset's.
//!
//! The presets live here and nowhere else: every library takes its levels explicitly.

use niji_dropfield::Interpolation;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::MirroredLight;
use niji_render::PixelFootprint;
use niji_render::RenderLevels;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_scatter::Theory;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// A named set of levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// For looking: coarse tables, few samples.
    Draft,
    /// For pictures: levels follow from the tolerance.
    #[default]
    Standard,
    /// The most accurate level of every stage.
    Reference,
}

impl Preset {
    /// The name of the preset in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }

    /// What a picture of the preset may err by, RMS of luminance over display white.
    pub fn tolerance(self) -> f64 {
        match self {
            Self::Draft => 0.05,
            Self::Standard => 0.01,
            Self::Reference => 0.001,
        }
    }

    /// The levels of the preset for drops on a lattice of `voxel_m`; a picture of `standard` takes those of its
    /// tolerance instead ([`Scene::levels`](crate::Scene::levels)).
    pub fn levels(self, voxel_m: f64) -> Levels {
        let standard = Levels {
            theory: Theory::BySize,
            table_relative_error: 5e-3,
            integration: Integration::CellExact,
            interpolation: Interpolation::Moments,
            drop_extinction: DropExtinctionModel::WithoutDiffraction,
            drop_orders: DropOrders::MultipleScattering {
                nodes_across: 16,
                paths_per_node: 2048,
            },
            sun_path: SunPath::Volume { voxel_m },
            air_path: AirPath::Table,
            sky: SkyModel::MultipleScattering,
            pixel_footprint: PixelFootprint::Prefiltered,
            mirrored_light: MirroredLight::Polarized,
            drop_spacing: DropSpacing::AsGiven,
            shutter_instants: None,
        };
        match self {
            Self::Draft => Levels {
                theory: Theory::Airy,
                table_relative_error: 2e-2,
                integration: Integration::Adaptive {
                    relative_error: 2e-2,
                },
                drop_orders: DropOrders::MultipleScattering {
                    nodes_across: 8,
                    paths_per_node: 512,
                },
                sun_path: SunPath::Volume {
                    voxel_m: 2.0 * voxel_m,
                },
                pixel_footprint: PixelFootprint::Center,
                ..standard
            },
            Self::Standard => standard,
            Self::Reference => Levels {
                theory: Theory::Mie,
                table_relative_error: 5e-4,
                integration: Integration::Adaptive {
                    relative_error: 1e-6,
                },
                drop_orders: DropOrders::MultipleScattering {
                    nodes_across: 24,
                    paths_per_node: 16_384,
                },
                sun_path: SunPath::March {
                    step_m: 0.5 * voxel_m,
                },
                air_path: AirPath::Quadrature { n_nodes: 32 },
                pixel_footprint: PixelFootprint::Grid { n: 4 },
                ..standard
            },
        }
    }
}

/// How far apart the nodes of drops are that are laid out from a shape.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum DropSpacing {
    /// `voxel_m` of the shape.
    #[default]
    AsGiven,
    /// Half of it: eight times as many nodes.
    Halved,
}

impl DropSpacing {
    /// What `voxel_m` is multiplied by.
    pub fn times(self) -> f64 {
        match self {
            Self::AsGiven => 1.0,
            Self::Halved => 0.5,
        }
    }
}

/// One level for every stage, with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Levels {
    /// How one drop scatters.
    pub theory: Theory,
    /// Largest error of the interpolated scattering table, relative to its maximum.
    pub table_relative_error: f64,
    /// The integral along the view ray.
    pub integration: Integration,
    /// What is interpolated between the nodes of the drop volume.
    pub interpolation: Interpolation,
    /// Which part of the drops' extinction leaves the picture.
    pub drop_extinction: DropExtinctionModel,
    /// Light scattered by more than one drop; not written where that effect is off.
    #[serde(
        default = "single_scattering",
        skip_serializing_if = "is_single_scattering"
    )]
    pub drop_orders: DropOrders,
    /// The drops' optical depth towards the sun.
    pub sun_path: SunPath,
    /// The air's optical depths.
    pub air_path: AirPath,
    /// What shines behind the drops.
    pub sky: SkyModel,
    /// What of a pixel is seen.
    pub pixel_footprint: PixelFootprint,
    /// What of the light that water mirrors is followed; written where it is not all.
    #[serde(default = "polarized", skip_serializing_if = "is_polarized")]
    pub mirrored_light: MirroredLight,
    /// The nodes of drops that are laid out from a shape; written where they are closer than the scene says.
    #[serde(default, skip_serializing_if = "is_as_given")]
    pub drop_spacing: DropSpacing,
    /// Instants of an open shutter over which a frame is the mean; written where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shutter_instants: Option<u32>,
}

impl Levels {
    /// Every decision with its level in words, as `("sun_path", "volume voxel_m=2.0")`.
    pub fn named(&self) -> Vec<(String, String)> {
        let serde_json::Value::Object(levels) =
            serde_json::to_value(self).unwrap_or(serde_json::Value::Null)
        else {
            return Vec::new();
        };
        let words = levels.iter();
        let mut named: Vec<_> = words
            .map(|(key, level)| (key.clone(), in_words(level)))
            .collect();
        named.sort();
        named
    }

    /// The levels of the ray integral.
    pub fn render_levels(&self) -> RenderLevels {
        RenderLevels {
            integration: self.integration,
            drop_extinction_model: self.drop_extinction,
            drop_orders: self.drop_orders,
            air_path: self.air_path,
            sky_model: self.sky,
            pixel_footprint: self.pixel_footprint,
        }
    }
}

fn single_scattering() -> DropOrders {
    DropOrders::SingleScattering
}

fn polarized() -> MirroredLight {
    MirroredLight::Polarized
}

/// Whether nothing is to be said of further orders.
fn is_single_scattering(orders: &DropOrders) -> bool {
    *orders == DropOrders::SingleScattering
}

/// Whether nothing is to be said of mirrored light.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_polarized(light: &MirroredLight) -> bool {
    *light == MirroredLight::Polarized
}

/// Whether nothing is to be said of the nodes of drops.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_as_given(spacing: &DropSpacing) -> bool {
    *spacing == DropSpacing::AsGiven
}

/// `"center"` as `center`, `{"grid": {"n": 4}}` as `grid n=4`.
fn in_words(level: &serde_json::Value) -> String {
    match level {
        serde_json::Value::String(name) => name.clone(),
        serde_json::Value::Object(variant) => {
            let words = variant
                .iter()
                .map(|(name, settings)| with_settings(name, settings));
            words.collect::<Vec<_>>().join(" ")
        }
        other => other.to_string(),
    }
}

/// A name and its settings, each as ` key=value`.
fn with_settings(name: &str, settings: &serde_json::Value) -> String {
    let mut words = name.to_string();
    if let serde_json::Value::Object(settings) = settings {
        for (key, value) in settings {
            words.extend([" ", key, "=", &value.to_string()]);
        }
    }
    words
}

/// The section `[accuracy]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Accuracy {
    /// The set of levels that holds where nothing else is said.
    #[serde(default)]
    pub preset: Preset,
    /// Largest RMS error of luminance over the picture, over that of display white: half of it for effects
    /// left out, half for levels. That of the preset where it is left out: 0.05, 0.01 or 0.001.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1.0))]
    pub tolerance: Option<f64>,
    /// Replaces the preset's theory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub theory: Option<Theory>,
    /// Replaces the preset's error of the scattering table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 0.5))]
    pub table_relative_error: Option<f64>,
    /// Replaces the preset's integration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integration: Option<Integration>,
    /// Replaces the preset's interpolation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// Replaces the preset's extinction of drops.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drop_extinction: Option<DropExtinctionModel>,
    /// Replaces the preset's orders of scattering by drops, where that effect is on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drop_orders: Option<DropOrders>,
    /// Replaces the preset's path through the drops to the sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun_path: Option<SunPath>,
    /// Replaces the preset's path through the air.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air_path: Option<AirPath>,
    /// Replaces the preset's sky.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<SkyModel>,
    /// Replaces the preset's pixel footprint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixel_footprint: Option<PixelFootprint>,
    /// Replaces the polarization of the light that water mirrors by that of natural light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirrored_light: Option<MirroredLight>,
    /// How far apart the nodes of drops are that are laid out from a shape, in place of what the picture is seen to
    /// need.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drop_spacing: Option<DropSpacing>,
    /// Instants of an open shutter over which a frame of a sequence is the mean, in place of what its frames are seen
    /// to need; of an odd number the frame itself is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 3, max = 256))]
    pub shutter_instants: Option<u32>,
}

impl Accuracy {
    /// What the picture may err by, RMS of luminance over display white.
    pub fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(self.preset.tolerance())
    }

    /// Levels with those that are named in place of what they are.
    pub(crate) fn named_over(&self, levels: Levels) -> Levels {
        Levels {
            theory: self.theory.unwrap_or(levels.theory),
            table_relative_error: (self.table_relative_error)
                .unwrap_or(levels.table_relative_error),
            integration: self.integration.unwrap_or(levels.integration),
            interpolation: self.interpolation.unwrap_or(levels.interpolation),
            drop_extinction: self.drop_extinction.unwrap_or(levels.drop_extinction),
            drop_orders: self.drop_orders.unwrap_or(levels.drop_orders),
            sun_path: self.sun_path.unwrap_or(levels.sun_path),
            air_path: self.air_path.unwrap_or(levels.air_path),
            sky: self.sky.unwrap_or(levels.sky),
            pixel_footprint: self.pixel_footprint.unwrap_or(levels.pixel_footprint),
            mirrored_light: self.mirrored_light.unwrap_or(levels.mirrored_light),
            drop_spacing: self.drop_spacing.unwrap_or(levels.drop_spacing),
            // Sequences say whether there is a shutter.
            shutter_instants: levels.shutter_instants,
        }
    }
}
