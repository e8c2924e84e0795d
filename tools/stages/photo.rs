//! The stages around a photograph: what a scene's section `[photo]` says to the commands for photographs.

use std::path::Path;
use std::path::PathBuf;

use niji_photo::Finding;
use niji_picture::PlannedScene;
use niji_picture::SurfaceFiles;
use niji_scene::Photo;
use niji_scene::Stage;

use crate::check;
use crate::check::CheckCommand;
use crate::composite;
use crate::composite::CompositeCommand;
use crate::depth;
use crate::depth::DepthCommand;
use crate::failure::Failure;
use crate::output;
use crate::stages;
use crate::stages::Done;
use crate::stages::StageOptions;
use crate::sun;
use crate::sun::SunCommand;

/// Names of the files in the folder of a run.
pub(crate) const DEPTH: &str = "depth.exr";
pub(crate) const SUN: &str = "sun.json";
pub(crate) const SUN_PREVIEW: &str = "sun.png";
pub(crate) const CHECK: &str = "check.json";
/// The photograph with the bow.
pub(crate) const COMPOSITE: &str = "composite.png";

/// Refuses a folder in which a file of a run would be written over one of these.
///
/// # Errors
/// As [`output::check_no_input`].
pub(crate) fn check_no_input(folder: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let (image, depth) = (folder.join(stages::render::FILE), folder.join(DEPTH));
    let shown = [&image, &depth].map(|path| path.with_extension("png"));
    let plain = image.with_extension("layers.exr");
    let others = [SUN, SUN_PREVIEW, CHECK, COMPOSITE].map(|name| folder.join(name));
    let all = [image, depth, plain].into_iter().chain(shown).chain(others);
    let all: Vec<_> = all.collect();
    let all: Vec<&Path> = all.iter().map(PathBuf::as_path).collect();
    output::check_no_input(&all, inputs)
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

/// What a scene says of its photograph.
///
/// # Errors
/// A scene without one.
pub(crate) fn section(planned: &PlannedScene) -> Result<&Photo, Failure> {
    let none = || Failure::Usage("the scene has no section [photo]".to_owned());
    planned.scene.photo.as_ref().ok_or_else(none)
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
    let inside = |name: &str| folder.join(name);
    let rendered = || (inside(stages::render::FILE), inside(DEPTH));
    let done = match stage {
        Stage::Depth => depth::make(&DepthCommand::of_scene(planned, inside(DEPTH))?, options)?,
        Stage::Sun => {
            let (output, preview) = (Some(inside(SUN)), Some(inside(SUN_PREVIEW)));
            sun::make(&SunCommand::of_scene(planned, output, preview)?, options)?
        }
        Stage::Check => {
            let (image, depth) = rendered();
            let command = CheckCommand::of_scene(planned, Some(image), Some(depth))?;
            return check::make(&command, &inside(CHECK), options);
        }
        Stage::Composite => {
            let command = CompositeCommand::of_scene(planned, rendered(), inside(COMPOSITE))?;
            composite::make(&command, options)?
        }
        Stage::Drops | Stage::Airy | Stage::Scatter | Stage::Atmosphere | Stage::Render => {
            let stage = stage.name();
            return Err(Failure::Failed(format!(
                "no photograph for the stage {stage}"
            )));
        }
    };
    Ok((done, Vec::new()))
}
