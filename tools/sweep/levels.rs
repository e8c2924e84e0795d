//! The levels that a sweep tries: every decision on its own, the best level of each last. Lengths follow
//! from the voxel of the drops.

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
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Stage;

/// Puts a level of one decision in place of the scene's; the number is the edge of a voxel (m).
pub(super) type Change = fn(&mut Accuracy, f64);

/// A decision between levels.
pub(super) struct Decision {
    /// Its key in the section `[accuracy]`.
    pub(super) key: &'static str,
    needs: Needs,
    levels: &'static [Change],
}

/// What a scene must have for a decision to change anything.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Needs {
    Table,
    Air,
    MultipleScattering,
    Nothing,
}

/// Every decision of a scene.
pub(super) const DECISIONS: [Decision; 10] = [
    Decision {
        key: "theory",
        needs: Needs::Table,
        levels: &[
            |a, _| a.theory = Some(Theory::Geometric),
            |a, _| a.theory = Some(Theory::AiryPublished),
            |a, _| a.theory = Some(Theory::Airy),
            |a, _| a.theory = Some(Theory::Uniform),
            |a, _| a.theory = Some(Theory::Debye { max_order: 7 }),
            |a, _| a.theory = Some(Theory::Mie),
        ],
    },
    Decision {
        key: "table_relative_error",
        needs: Needs::Table,
        levels: &[
            |a, _| a.table_relative_error = Some(2e-2),
            |a, _| a.table_relative_error = Some(5e-3),
            |a, _| a.table_relative_error = Some(1e-3),
            |a, _| a.table_relative_error = Some(2e-4),
        ],
    },
    Decision {
        key: "integration",
        needs: Needs::Nothing,
        levels: &[
            |a, voxel_m| a.integration = Some(fixed_step(2.0 * voxel_m)),
            |a, voxel_m| a.integration = Some(fixed_step(0.25 * voxel_m)),
            |a, _| a.integration = Some(adaptive(2e-2)),
            |a, _| a.integration = Some(Integration::CellExact),
            |a, _| a.integration = Some(adaptive(1e-6)),
        ],
    },
    Decision {
        key: "interpolation",
        needs: Needs::Nothing,
        levels: &[
            |a, _| a.interpolation = Some(Interpolation::RadiusDensity),
            |a, _| a.interpolation = Some(Interpolation::Moments),
        ],
    },
    Decision {
        key: "drop_extinction",
        needs: Needs::Nothing,
        levels: &[
            |a, _| a.drop_extinction = Some(DropExtinctionModel::Full),
            |a, _| a.drop_extinction = Some(DropExtinctionModel::WithoutDiffraction),
        ],
    },
    Decision {
        key: "drop_orders",
        needs: Needs::MultipleScattering,
        levels: &[
            |a, _| a.drop_orders = Some(further_orders(8, 512)),
            |a, _| a.drop_orders = Some(further_orders(16, 2048)),
            |a, _| a.drop_orders = Some(further_orders(24, 16384)),
        ],
    },
    Decision {
        key: "sun_path",
        needs: Needs::Nothing,
        levels: &[
            |a, _| a.sun_path = Some(SunPath::Ignore),
            |a, voxel_m| a.sun_path = Some(volume(2.0 * voxel_m)),
            |a, voxel_m| a.sun_path = Some(volume(voxel_m)),
            |a, voxel_m| {
                a.sun_path = Some(SunPath::March {
                    step_m: 0.5 * voxel_m,
                });
            },
        ],
    },
    Decision {
        key: "air_path",
        needs: Needs::Air,
        levels: &[
            |a, _| a.air_path = Some(AirPath::Constant),
            |a, _| a.air_path = Some(AirPath::Midpoint { n_steps: 50 }),
            |a, _| a.air_path = Some(AirPath::Table),
            |a, _| a.air_path = Some(AirPath::Quadrature { n_nodes: 32 }),
        ],
    },
    Decision {
        key: "sky",
        needs: Needs::Air,
        levels: &[
            |a, _| a.sky = Some(SkyModel::None),
            |a, _| a.sky = Some(SkyModel::SingleScattering),
            |a, _| a.sky = Some(SkyModel::MultipleScattering),
        ],
    },
    Decision {
        key: "pixel_footprint",
        needs: Needs::Nothing,
        levels: &[
            |a, _| a.pixel_footprint = Some(PixelFootprint::Center),
            |a, _| a.pixel_footprint = Some(PixelFootprint::Prefiltered),
            |a, _| a.pixel_footprint = Some(PixelFootprint::Grid { n: 2 }),
            |a, _| a.pixel_footprint = Some(PixelFootprint::Grid { n: 4 }),
        ],
    },
];

fn fixed_step(step_m: f64) -> Integration {
    Integration::FixedStep { step_m }
}

fn adaptive(relative_error: f64) -> Integration {
    Integration::Adaptive { relative_error }
}

fn volume(voxel_m: f64) -> SunPath {
    SunPath::Volume { voxel_m }
}

fn further_orders(nodes_across: usize, paths_per_node: usize) -> DropOrders {
    DropOrders::MultipleScattering {
        nodes_across,
        paths_per_node,
    }
}

impl Decision {
    /// Whether the scene has anything that the decision changes.
    pub(super) fn concerns(&self, scene: &Scene, plan: &Plan) -> bool {
        match self.needs {
            Needs::Nothing => true,
            Needs::Table => plan.runs(Stage::Scatter),
            Needs::Air => scene.air.is_some(),
            Needs::MultipleScattering => plan.is_on(Effect::MultipleScattering),
        }
    }

    /// The levels that the plan of a scene allows, the best one last: light that drops scatter more than
    /// once is what their shadow took, so that there is none without it.
    pub(super) fn levels_for(&self, plan: &Plan) -> Vec<Change> {
        let has_orders = plan.is_on(Effect::MultipleScattering);
        let is_allowed = |change: &Change| {
            let mut accuracy = Accuracy::default();
            change(&mut accuracy, plan.voxel_m);
            !(has_orders && accuracy.sun_path == Some(SunPath::Ignore))
        };
        self.levels.iter().copied().filter(is_allowed).collect()
    }
}
