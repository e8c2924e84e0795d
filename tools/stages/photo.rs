//! The stages around a photograph: the commands that a scene's section `[photo]` stands for.
//!
//! `niji run` parses the command lines that `niji plan --script` prints, so that a chain by hand makes
//! the same files.

use std::path::Path;

use clap::Args;
use niji_photo::Finding;
use niji_picture::CardExposure;
use niji_picture::Distances;
use niji_picture::PlannedScene;
use niji_picture::SurfaceFiles;
use niji_scene::Camera;
use niji_scene::Photo;
use niji_scene::Stage;

use crate::check;
use crate::check::CheckCommand;
use crate::composite;
use crate::composite::CompositeCommand;
use crate::depth;
use crate::depth::DepthCommand;
use crate::failure::Failure;
use crate::schema_flags::name;
use crate::stages;
use crate::stages::Done;
use crate::stages::StageOptions;
use crate::sun;
use crate::sun::SunCommand;
use crate::water_flags;

/// Names of the files in the folder of a run.
const DEPTH: &str = "depth.exr";
const SUN: &str = "sun.json";
const SUN_PREVIEW: &str = "sun.png";
const CHECK: &str = "check.json";
/// The photograph with the bow.
pub(crate) const COMPOSITE: &str = "composite.png";

/// Shapes whose drops are no rain.
const SPRAYS: [&str; 3] = ["fountain", "waterfall", "sea-spray"];
const FOGS: [&str; 1] = ["fog-bank"];

/// Where the light of the render stage ends: at the photographed surfaces, or at those that the scene
/// names.
pub(crate) fn surfaces(planned: &PlannedScene, folder: &Path) -> SurfaceFiles {
    let of_scene = SurfaceFiles::of_scene(&planned.scene, &planned.folder);
    match planned.scene.photo {
        Some(_) => of_scene.with_depth(folder.join(DEPTH)),
        None => of_scene,
    }
}

/// The command line of a stage around the photograph; `None` for any other stage or scene.
pub(crate) fn arguments(
    planned: &PlannedScene,
    stage: Stage,
    folder: &Path,
) -> Option<Vec<String>> {
    let photo = planned.scene.photo.as_ref()?;
    let mut arguments = vec![stage.name().to_owned()];
    let inside = |name: &str| folder.join(name).display().to_string();
    let camera = || picture_and_camera(photo, &planned.scene.camera, &planned.folder);
    let output = |name: &str| ["-o".to_owned(), inside(name)];
    match stage {
        Stage::Depth => {
            arguments.extend(camera());
            arguments.extend(planned.photo_distances().iter().flat_map(distances));
            arguments.extend(output(DEPTH));
        }
        Stage::Sun => {
            arguments.extend(camera());
            let picks = photo.picks_px.iter();
            arguments.extend(picks.map(|[x, y]| format!("--pick={x},{y}")));
            arguments.push(format!("--bow={}", name(photo.bow)));
            arguments.push(format!("--edge={}", name(photo.edge)));
            arguments.extend(water_flags::arguments(planned.scene.water()));
            arguments.push(format!("--preview={}", inside(SUN_PREVIEW)));
            arguments.extend(output(SUN));
        }
        Stage::Check => {
            arguments.extend(camera());
            arguments.extend(circumstances(photo, planned, &inside));
            arguments.extend(output(CHECK));
        }
        Stage::Composite => {
            arguments.push(beside(&planned.folder, &photo.picture));
            arguments.push(format!("--image={}", inside(stages::render::FILE)));
            arguments.push(format!("--depth={}", inside(DEPTH)));
            arguments.push(format!("--exposure={}", exposure(photo.into())));
            arguments.extend(output(COMPOSITE));
        }
        Stage::Drops | Stage::Airy | Stage::Scatter | Stage::Atmosphere | Stage::Render => {
            return None;
        }
    }
    Some(arguments)
}

/// Runs a stage around the photograph; what the check found comes with it.
///
/// # Errors
/// Whatever the command reports.
pub(crate) fn make(
    planned: &PlannedScene,
    stage: Stage,
    folder: &Path,
    options: StageOptions,
) -> Result<(Done, Vec<Finding>), Failure> {
    let unknown = || Failure::Failed(format!("no photograph for the stage {}", stage.name()));
    let arguments = arguments(planned, stage, folder).ok_or_else(unknown)?;
    let done = match stage {
        Stage::Depth => depth::make(&parse::<DepthCommand>(&arguments)?, options)?,
        Stage::Sun => sun::make(&parse::<SunCommand>(&arguments)?, options)?,
        Stage::Check => {
            let command = parse::<CheckCommand>(&arguments)?;
            return check::make(&command, &folder.join(CHECK), options);
        }
        Stage::Composite => composite::make(&parse::<CompositeCommand>(&arguments)?, options)?,
        Stage::Drops | Stage::Airy | Stage::Scatter | Stage::Atmosphere | Stage::Render => {
            return Err(unknown());
        }
    };
    Ok((done, Vec::new()))
}

/// The flags of a subcommand, whose name comes first.
fn parse<T: Args>(arguments: &[String]) -> Result<T, Failure> {
    let command = T::augment_args(clap::Command::new("niji"));
    let matches = command.try_get_matches_from(arguments);
    matches
        .and_then(|matches| T::from_arg_matches(&matches))
        .map_err(|error| Failure::Failed(error.to_string()))
}

/// A path of a scene whose files lie in a folder.
fn beside(folder: &Path, path: &str) -> String {
    folder.join(path).display().to_string()
}

fn picture_and_camera(photo: &Photo, camera: &Camera, folder: &Path) -> Vec<String> {
    vec![
        beside(folder, &photo.picture),
        // A scene with a photograph has a pinhole camera, hence a field of view.
        format!(
            "--fov-deg={}",
            camera.horizontal_fov_deg.unwrap_or_default()
        ),
        format!("--azimuth-deg={}", camera.azimuth_deg),
        format!("--elevation-deg={}", camera.elevation_deg),
        format!("--roll-deg={}", camera.roll_deg),
    ]
}

fn distances(distances: &Distances) -> Vec<String> {
    match distances {
        Distances::Layers { distances, labels } => vec![
            format!("--layers={}", distances.display()),
            format!("--labels={}", labels.display()),
        ],
        Distances::Map(map) => vec![
            format!("--map={}", map.path.display()),
            "--kind=metres".to_owned(),
            format!("--along={}", name(map.along)),
        ],
        Distances::Proposed { .. } => Vec::new(),
    }
}

fn circumstances(
    photo: &Photo,
    planned: &PlannedScene,
    inside: &dyn Fn(&str) -> String,
) -> Vec<String> {
    let sun = &planned.scene.sun;
    let populations = planned.scene.drops.populations();
    let are_all = |kind: &[&str]| {
        populations
            .iter()
            .all(|it| kind.contains(&it.source.name()))
    };
    let drops = if are_all(&SPRAYS) {
        "spray"
    } else if are_all(&FOGS) {
        "fog"
    } else {
        "rain"
    };
    let mut arguments = vec![
        format!("--sun-elevation-deg={}", sun.elevation_deg),
        format!("--sun-azimuth-deg={}", sun.azimuth_deg),
        format!("--bow={}", name(photo.bow)),
        format!("--drops={drops}"),
        format!("--image={}", inside(stages::render::FILE)),
    ];
    arguments.extend(water_flags::arguments(planned.scene.water()));
    if let Some((nearest_m, _)) = planned.plan.view.distance_m {
        arguments.push(format!("--depth={}", inside(DEPTH)));
        arguments.push(format!("--drops-distance-m={nearest_m}"));
    }
    let cover = photo.cloud_cover;
    arguments.extend(cover.map(|cover| format!("--cloud-cover={cover}")));
    arguments
}

fn exposure(exposure: CardExposure) -> String {
    match exposure {
        CardExposure::Match => "match".to_owned(),
        CardExposure::Camera => "camera".to_owned(),
        CardExposure::Value(value) => value.to_string(),
    }
}
