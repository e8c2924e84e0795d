//! The stages around a photograph: the commands that a scene's section `[photo]` stands for.
//!
//! `niji run` parses the command lines that `niji plan --script` prints, so that a chain by hand makes
//! the same files.

use std::path::Path;

use clap::Args;
use niji_photo::Finding;
use niji_picture::SurfaceFiles;
use niji_radiometry::Water;
use niji_scene::Along;
use niji_scene::Camera;
use niji_scene::Photo;
use niji_scene::PhotoExposure;
use niji_scene::PickedBow;
use niji_scene::PickedColor;
use niji_scene::Stage;
use niji_scene::picked_sun;
use niji_scene::with_sun;

use crate::check;
use crate::check::CheckCommand;
use crate::composite;
use crate::composite::CompositeCommand;
use crate::depth;
use crate::depth::DepthCommand;
use crate::failure::Failure;
use crate::stages;
use crate::stages::Done;
use crate::stages::StageOptions;
use crate::sun;
use crate::sun::SunCommand;
use crate::water_flags;
use niji_picture::PlannedScene;

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

/// A scene file with the sun that its picks give, where it says none.
///
/// # Errors
/// A photograph that cannot be read, or picks that no sun explains.
pub(crate) fn with_picked_sun(text: String, scene_file: &Path) -> Result<String, Failure> {
    let Some(picked) = picked_sun(&text) else {
        return Ok(text);
    };
    let folder = scene_file.parent().unwrap_or(Path::new(""));
    let mut arguments = vec!["sun".to_owned()];
    arguments.extend(picture_and_camera(&picked.photo, &picked.camera, folder));
    arguments.extend(picks(&picked.photo, picked.water));
    let solved = sun::solve(&parse::<SunCommand>(&arguments)?)?;
    let best = solved.best()?;
    let (elevation_deg, azimuth_deg) = (best.elevation.to_degrees(), best.azimuth.to_degrees());
    Ok(with_sun(&text, elevation_deg, azimuth_deg))
}

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
            arguments.extend(distances(photo, planned));
            arguments.extend(output(DEPTH));
        }
        Stage::Sun => {
            arguments.extend(camera());
            arguments.extend(picks(photo, planned.scene.water()));
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
            arguments.push(format!("--exposure={}", exposure(photo)));
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

fn distances(photo: &Photo, planned: &PlannedScene) -> Vec<String> {
    let beside = |path: &str| beside(&planned.folder, path);
    if let (Some(layers), Some(labels)) = (&photo.layers, &photo.labels) {
        return vec![
            format!("--layers={}", beside(layers)),
            format!("--labels={}", beside(labels)),
        ];
    }
    let Some(occluders) = &planned.scene.occluders else {
        return Vec::new();
    };
    let map = occluders.depth.iter().flat_map(|depth| {
        [
            format!("--map={}", beside(depth)),
            "--kind=metres".to_owned(),
            match occluders.along {
                Along::Ray => "--along=ray".to_owned(),
                Along::Axis => "--along=axis".to_owned(),
            },
        ]
    });
    map.collect()
}

fn picks(photo: &Photo, water: Water) -> Vec<String> {
    let edge = match photo.edge {
        PickedColor::Red => "red",
        PickedColor::Middle => "middle",
        PickedColor::Violet => "violet",
    };
    let picks = photo.picks_px.iter();
    picks
        .map(|[x, y]| format!("--pick={x},{y}"))
        .chain([bow(photo), format!("--edge={edge}")])
        .chain(water_flags::arguments(water))
        .collect()
}

fn bow(photo: &Photo) -> String {
    match photo.bow {
        PickedBow::Primary => "--bow=primary".to_owned(),
        PickedBow::Secondary => "--bow=secondary".to_owned(),
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
        bow(photo),
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

fn exposure(photo: &Photo) -> String {
    match (photo.white_card, photo.exposure) {
        (Some(value), _) => value.to_string(),
        (None, PhotoExposure::Match) => "match".to_owned(),
        (None, PhotoExposure::Camera) => "camera".to_owned(),
    }
}
