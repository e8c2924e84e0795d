//! The levels of accuracy that are measured and chosen between: every decision on its own.
//!
//! Lengths of levels follow from the voxel of the drops, so that what was measured on one scene holds
//! for another; the best level of a decision comes last. It is what the others are compared with, unless
//! the decision has a finer yardstick.

use niji_dropfield::Interpolation;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_scatter::Theory;

use crate::accuracy::Accuracy;
use crate::accuracy::Levels;
use crate::effect::Effect;
use crate::plan::Plan;
use crate::plan::Stage;
use crate::scene::Scene;

/// Puts a level of one decision in place of the preset's; the number is the edge of a voxel in meters.
pub type Change = fn(&mut Accuracy, f64);

/// A decision between levels.
pub struct Decision {
    /// Its key in the section `[accuracy]`.
    pub key: &'static str,
    /// The effects whose light it is about.
    pub about: &'static [Effect],
    /// The stage it costs time in.
    pub stage: Stage,
    /// A stage before it that has more to do for a better level.
    pub table: Option<Stage>,
    /// Its levels, the best one last; see [`Decision::levels_for`].
    pub levels: &'static [Change],
    /// What its levels are compared with, where the best of them is no nearer to the truth than others.
    pub yardstick: Option<Change>,
    /// Whether its levels differ in accuracy, or in what is meant: `niji run --tolerance` chooses
    /// only between the former.
    pub is_of_accuracy: bool,
    /// Whether a scene names the level itself.
    pub is_named: fn(&Accuracy) -> bool,
    needs: Needs,
}

/// What a scene must have for a decision to change anything.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Needs {
    Table,
    Air,
    MultipleScattering,
    Nothing,
}
/// What drops send into the picture.
pub(crate) const LIGHT_OF_DROPS: [Effect; 3] = [
    Effect::PrimaryBow,
    Effect::SecondaryBow,
    Effect::HigherOrders,
];
/// What makes a picture.
const ALL_LIGHT: [Effect; 5] = [
    Effect::PrimaryBow,
    Effect::SecondaryBow,
    Effect::HigherOrders,
    Effect::AirInscatter,
    Effect::Sky,
];

/// Every decision of a scene.
pub const DECISIONS: [Decision; 10] = [
    Decision {
        key: "theory",
        about: &LIGHT_OF_DROPS,
        stage: Stage::Scatter,
        table: None,
        needs: Needs::Table,
        is_of_accuracy: true,
        is_named: |a| a.theory.is_some(),
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
        yardstick: None,
    },
    Decision {
        key: "table_relative_error",
        about: &LIGHT_OF_DROPS,
        stage: Stage::Scatter,
        table: None,
        needs: Needs::Table,
        is_of_accuracy: true,
        is_named: |a| a.table_relative_error.is_some(),
        levels: &[
            |a, _| {
                a.table_relative_error = Some(2e-2);
            },
            |a, _| {
                a.table_relative_error = Some(5e-3);
            },
            |a, _| {
                a.table_relative_error = Some(1e-3);
            },
            |a, _| {
                a.table_relative_error = Some(2e-4);
            },
        ],
        yardstick: None,
    },
    Decision {
        key: "integration",
        about: &LIGHT_OF_DROPS,
        stage: Stage::Render,
        table: None,
        needs: Needs::Nothing,
        is_of_accuracy: true,
        is_named: |a| a.integration.is_some(),
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
                    relative_error: 2e-2,
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
        yardstick: Some(|a, _| {
            a.integration = Some(Integration::Adaptive {
                relative_error: 1e-9,
            });
        }),
    },
    Decision {
        key: "interpolation",
        about: &LIGHT_OF_DROPS,
        stage: Stage::Render,
        table: None,
        needs: Needs::Nothing,
        is_of_accuracy: false,
        is_named: |a| a.interpolation.is_some(),
        levels: &[
            |a, _| {
                a.interpolation = Some(Interpolation::RadiusDensity);
            },
            |a, _| {
                a.interpolation = Some(Interpolation::Moments);
            },
        ],
        yardstick: None,
    },
    Decision {
        key: "drop_extinction",
        about: &[Effect::DropExtinction],
        stage: Stage::Render,
        table: None,
        needs: Needs::Nothing,
        is_of_accuracy: false,
        is_named: |a| a.drop_extinction.is_some(),
        levels: &[
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::Full);
            },
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::WithoutDiffraction);
            },
        ],
        yardstick: None,
    },
    Decision {
        key: "drop_orders",
        about: &[Effect::MultipleScattering],
        stage: Stage::Render,
        table: None,
        needs: Needs::MultipleScattering,
        is_of_accuracy: true,
        is_named: |a| a.drop_orders.is_some(),
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
        yardstick: None,
    },
    Decision {
        key: "sun_path",
        about: &[Effect::DropShadow],
        stage: Stage::Render,
        table: None,
        needs: Needs::Nothing,
        is_of_accuracy: true,
        is_named: |a| a.sun_path.is_some(),
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
        yardstick: None,
    },
    Decision {
        key: "air_path",
        about: &[
            Effect::SunlightThroughAir,
            Effect::AirExtinction,
            Effect::AirInscatter,
        ],
        stage: Stage::Render,
        table: None,
        needs: Needs::Air,
        is_of_accuracy: true,
        is_named: |a| a.air_path.is_some(),
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
        yardstick: None,
    },
    Decision {
        key: "sky",
        about: &[Effect::Sky, Effect::AirInscatter],
        stage: Stage::Render,
        table: Some(Stage::Atmosphere),
        needs: Needs::Air,
        is_of_accuracy: true,
        is_named: |a| a.sky.is_some(),
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
        yardstick: None,
    },
    Decision {
        key: "pixel_footprint",
        about: &ALL_LIGHT,
        stage: Stage::Render,
        table: None,
        needs: Needs::Nothing,
        is_of_accuracy: true,
        is_named: |a| a.pixel_footprint.is_some(),
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
        yardstick: None,
    },
];

impl Decision {
    /// Whether the scene has anything that the decision changes.
    pub fn concerns(&self, scene: &Scene, plan: &Plan) -> bool {
        match self.needs {
            Needs::Nothing => true,
            Needs::Table => plan.runs(Stage::Scatter),
            Needs::Air => scene.air.is_some(),
            Needs::MultipleScattering => plan.is_on(Effect::MultipleScattering),
        }
    }

    /// The levels that the plan of a scene allows, the best one last: light that drops scatter more than
    /// once is what their shadow took, so that there is none without it.
    pub fn levels_for(&self, plan: &Plan) -> Vec<Change> {
        let has_orders = plan.is_on(Effect::MultipleScattering);
        let is_allowed = |change: &Change| {
            let mut accuracy = Accuracy::default();
            change(&mut accuracy, plan.work.voxel_m);
            !(has_orders && accuracy.sun_path == Some(SunPath::Ignore))
        };
        self.levels.iter().copied().filter(is_allowed).collect()
    }

    /// The level that it stands at, in words.
    pub fn level_of(&self, levels: &Levels) -> String {
        self.own(levels.named())
    }

    /// The level that it stands at, as measurements are kept of it.
    pub fn measured_name(&self, levels: &Levels, voxel_m: f64) -> String {
        self.own(levels.measured_names(voxel_m))
    }

    fn own(&self, named: Vec<(String, String)>) -> String {
        let level = named.into_iter().find(|(key, _)| key == self.key);
        level.map(|(_, level)| level).unwrap_or_default()
    }
}
