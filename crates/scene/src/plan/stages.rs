//! The stages that run, with only the tables and angles that are needed, and what they take.

use std::collections::BTreeSet;

use niji_droplets::Shape;
use niji_exchange::AtmosphereTable;
use niji_scatter::NumberOfAngles;
use niji_scatter::SizeRows;
use serde::Deserialize;
use serde::Serialize;

use crate::drops::DropSource;
use crate::effect::Effect;
use crate::effect::Role;
use crate::scene::Scene;
use crate::sky_level::SkyLevel;

use super::facts::Situation;
use super::resources;
use super::resources::Resources;
use super::scattering_need::ScatteringNeed;

/// A stage of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// The surfaces of a photograph get their distances.
    Depth,
    /// The sun follows from picked pixels.
    Sun,
    /// The shape becomes a drop volume.
    Drops,
    /// Airy's integral is tabulated.
    Airy,
    /// The scattering table is made.
    Scatter,
    /// The air's table is made.
    Atmosphere,
    /// The picture is rendered.
    Render,
    /// What nature would not do is listed.
    Check,
    /// The bow is set into the photograph.
    Composite,
}

impl Stage {
    /// The subcommand that runs it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Sun => "sun",
            Self::Drops => "drops",
            Self::Airy => "airy",
            Self::Scatter => "scatter",
            Self::Atmosphere => "atmosphere",
            Self::Render => "render",
            Self::Check => "check",
            Self::Composite => "composite",
        }
    }
}

/// What a stage takes; `None` where nothing can be counted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Estimate {
    /// Memory at its highest, bytes.
    pub memory_bytes: Option<u64>,
    /// Size of its file, bytes; of the picture, which is compressed, at most.
    pub file_bytes: Option<u64>,
}

/// A stage that runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StagePlan {
    /// The stage.
    pub stage: Stage,
    /// What it makes, in words.
    pub makes: String,
    /// What it takes.
    pub estimate: Estimate,
}

/// What was chosen to be simulated.
pub(super) struct Chosen<'a> {
    /// Effects that are on.
    pub(super) on: &'a BTreeSet<Effect>,
    /// The scattering table, and how many angles it has.
    pub(super) scattering: Option<(&'a ScatteringNeed, &'a NumberOfAngles)>,
    /// The air, tabulated.
    pub(super) air: Option<&'a AtmosphereTable>,
}

/// The stages to run, in order.
pub(super) fn stages(scene: &Scene, situation: &Situation, chosen: &Chosen) -> Vec<StagePlan> {
    let Chosen {
        on,
        scattering,
        air,
    } = *chosen;
    let mut stages = Vec::new();
    let mut add = |stage: Stage, makes: String, resources: Option<Resources>| {
        let estimate = Estimate {
            memory_bytes: resources.map(|it| it.memory_bytes),
            file_bytes: resources.map(|it| it.file_bytes),
        };
        stages.push(StagePlan {
            stage,
            makes,
            estimate,
        });
    };
    if let Some(photo) = &scene.photo {
        let map = scene.occluders.as_ref().and_then(|it| it.depth.as_ref());
        let makes = match (&photo.layers, map) {
            (Some(_), _) => "distances of the given layers",
            (None, Some(_)) => "distances of the given map",
            (None, None) => "proposed distances",
        };
        add(Stage::Depth, makes.to_string(), None);
    }
    if let Some(photo) = scene
        .photo
        .as_ref()
        .filter(|photo| !photo.picks_px.is_empty())
    {
        let makes = format!("the sun by {} picks", photo.picks_px.len());
        add(Stage::Sun, makes, None);
    }
    let drops = &situation.drops;
    if scene.drops.file().is_none() {
        let sources = || scene.drops.populations().iter().map(|it| &it.source);
        let names: Vec<&str> = sources().map(DropSource::name).collect();
        let makes = format!(
            "{} voxels of {} m ({})",
            drops.n_nodes,
            drops.voxel_m,
            names.join(", ")
        );
        let is_fountain = sources().any(|it| matches!(it, DropSource::Shape(Shape::Fountain(_))));
        add(
            Stage::Drops,
            makes,
            Some(resources::drops(drops, is_fountain)),
        );
    }
    let table = scattering.map(|need| resources::table(need, situation));
    if let Some((need, _)) = scattering {
        if need.theory.uses_airy_table() {
            let makes = "Airy's integral f(z) and its derivative".to_string();
            add(Stage::Airy, makes, Some(resources::airy()));
        }
        add(Stage::Scatter, what_it_holds(need, situation), table);
    }
    if on.iter().any(|effect| effect.needs_air()) || is_lit_through_air(scene, on) {
        let constituents = scene.air.iter().flat_map(|air| &air.constituents);
        let names: Vec<&str> = constituents.map(|constituent| constituent.name()).collect();
        let orders = sky_level(scene, on).map(SkyLevel::orders);
        let resources = air.map(|table| resources::atmosphere((table, orders), situation));
        add(Stage::Atmosphere, names.join(", "), resources);
    }
    add(
        Stage::Render,
        format!(
            "{} x {} pixels, {} wavelengths",
            situation.camera.width_px(),
            situation.camera.height_px(),
            situation.grid.len()
        ),
        Some(resources::picture(scene, situation, (on, table))),
    );
    if scene.photo.is_some() {
        add(Stage::Check, "what nature would not do".to_string(), None);
        add(
            Stage::Composite,
            "the photograph with the bow".to_string(),
            None,
        );
    }
    stages
}

/// A scattering table in words.
fn what_it_holds(need: &ScatteringNeed, situation: &Situation) -> String {
    format!(
        "{}, orders {:?}, theta {:.1} to {:.1} degrees, {} {} x {} wavelengths, {}{}{}",
        need.theory.name(),
        need.orders,
        need.theta_range_rad.0.to_degrees(),
        need.theta_range_rad.1.to_degrees(),
        need.effective_radius_um.len() * need.effective_variance.len(),
        match need.rows {
            SizeRows::Laws => "sizes",
            SizeRows::Bins { .. } => "bins of size",
        },
        situation.grid.len(),
        if need.sun_disc_diameter_rad > 0.0 {
            "sun's disc"
        } else {
            "point sun"
        },
        need.motion.map_or("", |_| ", flattened drops"),
        if need.phase_functions {
            ", phase functions"
        } else {
            ""
        },
    )
}

/// How finely light of higher orders by the air is solved, where anything that is on shows it.
pub(super) fn sky_level(scene: &Scene, on: &BTreeSet<Effect>) -> Option<SkyLevel> {
    let is_shown = Effect::of_role(Role::AirLight).any(|effect| on.contains(&effect));
    let is_shown = is_shown || is_lit_through_air(scene, on);
    scene.sky_level_where_seen().filter(|_| is_shown)
}

/// Whether surfaces have the light of a sky, seen itself or not.
fn is_lit_through_air(scene: &Scene, on: &BTreeSet<Effect>) -> bool {
    scene.air.is_some() && on.contains(&Effect::LitSurfaces)
}
