//! The levels of accuracy that `niji calibrate` and `niji sweep` measure: every decision on its own.

use niji_dropfield::Interpolation;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Effect;
use niji_scene::Stage;

use crate::scene_file::Planned;

/// Puts a level of one decision in place of the preset's; the number is the edge of a voxel in metres.
pub(crate) type Change = fn(&mut Accuracy, f64);

/// A decision between levels.
pub(crate) struct Decision {
    /// Its key in the section `[accuracy]`.
    pub(crate) key: &'static str,
    /// The stage it costs time in.
    pub(crate) stage: Stage,
    needs: Needs,
    /// Its levels, the best one last.
    pub(crate) levels: &'static [Change],
}

/// What a scene must have for a decision to change anything.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Needs {
    Nothing,
    Air,
    MultipleScattering,
}

/// Every decision of a scene.
pub(crate) const DECISIONS: [Decision; 10] = [
    Decision {
        key: "theory",
        stage: Stage::Scatter,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.theory = Some(Theory::Geometric);
            },
            |a, _| {
                a.theory = Some(Theory::AiryPublished);
            },
            |a, _| {
                a.theory = Some(Theory::Airy);
            },
            |a, _| {
                a.theory = Some(Theory::Uniform);
            },
            |a, _| {
                a.theory = Some(Theory::Debye { max_order: 7 });
            },
            |a, _| {
                a.theory = Some(Theory::Mie);
            },
        ],
    },
    Decision {
        key: "table_relative_error",
        stage: Stage::Scatter,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.table_relative_error = Some(2e-2);
            },
            |a, _| {
                a.table_relative_error = Some(5e-3);
            },
            |a, _| {
                a.table_relative_error = Some(2e-4);
            },
        ],
    },
    Decision {
        key: "integration",
        stage: Stage::Render,
        needs: Needs::Nothing,
        levels: &[
            |a, voxel_m| {
                a.integration = Some(Integration::FixedStep {
                    step_m: 2.0 * voxel_m,
                });
            },
            |a, voxel_m| {
                a.integration = Some(Integration::FixedStep {
                    step_m: 0.25 * voxel_m,
                });
            },
            |a, _| {
                a.integration = Some(Integration::Adaptive {
                    relative_error: 1e-2,
                });
            },
            |a, _| {
                a.integration = Some(Integration::CellExact);
            },
            |a, _| {
                a.integration = Some(Integration::Adaptive {
                    relative_error: 1e-6,
                });
            },
        ],
    },
    Decision {
        key: "interpolation",
        stage: Stage::Render,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.interpolation = Some(Interpolation::RadiusDensity);
            },
            |a, _| {
                a.interpolation = Some(Interpolation::Moments);
            },
        ],
    },
    Decision {
        key: "drop_extinction",
        stage: Stage::Render,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::Full);
            },
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::WithoutDiffraction);
            },
        ],
    },
    Decision {
        key: "drop_orders",
        stage: Stage::Render,
        needs: Needs::MultipleScattering,
        levels: &[
            |a, _| {
                a.drop_orders = Some(DropOrders::MultipleScattering {
                    nodes_across: 8,
                    paths_per_node: 512,
                });
            },
            |a, _| {
                a.drop_orders = Some(DropOrders::MultipleScattering {
                    nodes_across: 16,
                    paths_per_node: 2048,
                });
            },
            |a, _| {
                a.drop_orders = Some(DropOrders::MultipleScattering {
                    nodes_across: 24,
                    paths_per_node: 16384,
                });
            },
        ],
    },
    Decision {
        key: "sun_path",
        stage: Stage::Render,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.sun_path = Some(SunPath::Ignore);
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::Volume {
                    voxel_m: 2.0 * voxel_m,
                });
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::Volume { voxel_m });
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::March {
                    step_m: 0.5 * voxel_m,
                });
            },
        ],
    },
    Decision {
        key: "air_path",
        stage: Stage::Render,
        needs: Needs::Air,
        levels: &[
            |a, _| {
                a.air_path = Some(AirPath::Constant);
            },
            |a, _| {
                a.air_path = Some(AirPath::Midpoint { n_steps: 50 });
            },
            |a, _| {
                a.air_path = Some(AirPath::Table);
            },
            |a, _| {
                a.air_path = Some(AirPath::Quadrature { n_nodes: 32 });
            },
        ],
    },
    Decision {
        key: "sky",
        stage: Stage::Render,
        needs: Needs::Air,
        levels: &[
            |a, _| {
                a.sky = Some(SkyModel::None);
            },
            |a, _| {
                a.sky = Some(SkyModel::SingleScattering);
            },
            |a, _| {
                a.sky = Some(SkyModel::MultipleScattering);
            },
        ],
    },
    Decision {
        key: "pixel_footprint",
        stage: Stage::Render,
        needs: Needs::Nothing,
        levels: &[
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Center);
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Prefiltered);
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Grid { n: 2 });
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Grid { n: 4 });
            },
        ],
    },
];

impl Decision {
    /// Whether the scene has anything that the decision changes.
    pub(crate) fn concerns(&self, planned: &Planned) -> bool {
        let has_table = planned.plan.runs(Stage::Scatter);
        let has_needs = match self.needs {
            Needs::Nothing => true,
            Needs::Air => planned.scene.air.is_some(),
            Needs::MultipleScattering => planned.plan.is_on(Effect::MultipleScattering),
        };
        has_needs && (self.stage != Stage::Scatter || has_table)
    }

    /// The level that a plan holds, in words.
    pub(crate) fn level_of(&self, planned: &Planned) -> String {
        let named = planned.plan.levels.named();
        let level = named.into_iter().find(|(key, _)| key == self.key);
        level.map(|(_, level)| level).unwrap_or_default()
    }
}
