//! Scene files and their plans, as every command reads them.

use std::cell::Cell;
use std::path::Path;

use niji_picture::Choice;
use niji_picture::Error;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_scene::Goal;
use niji_scene::LEAST_TOLERANCE;
use niji_scene::Scene;
use niji_scene::SceneError;

use crate::checksums::hash_once;
use crate::choice_file;
use crate::failure::Failure;
use crate::flags::Common;
use crate::kept_choices::KeptChoices;
use crate::shell_word::quoted;
use crate::text_file;
use crate::version;

/// Reads a scene and makes its plan, with levels for what is asked of the picture, or as a choice says.
///
/// # Errors
/// A scene, a drop volume or a choice that is missing or wrong; a choice for something else.
pub(crate) fn load(path: &Path, common: &Common) -> Result<PlannedScene, Failure> {
    as_asked(read(path, common)?, path, common)
}

/// The same of a scene that was read.
///
/// # Errors
/// As [`load`].
pub(crate) fn as_asked(
    scene: Scene,
    path: &Path,
    common: &Common,
) -> Result<PlannedScene, Failure> {
    let Some(file) = &common.choice else {
        return planned(scene, path, common);
    };
    let choice: Choice = choice_file::read(file)?;
    let of = (file.as_path(), path, &*common.picture_flags());
    check_version(&choice.version, of)?;
    let scene = match choice.afforded {
        Some(afforded) if common.tolerance.is_none() => at_tolerance(scene, afforded.tolerance),
        _ => scene,
    };
    let request = PlanRequest {
        choice: Some(&choice),
        ..beside(path)
    };
    let planned = planned_for(scene, path, request)?;
    if planned.choice == choice {
        return Ok(planned);
    }
    Err(refused("for another scene or other accuracy", of))
}

/// Refuses what another program decided.
///
/// # Errors
/// Both versions.
pub(crate) fn check_version(found: &str, of: ChoiceOf) -> Result<(), Failure> {
    if found == version() {
        return Ok(());
    }
    let what = format!("by niji {found}, expected one by niji {}", version());
    Err(refused(&what, of))
}

/// The file of a choice, the scene that it is taken for, and the flags that plan that.
type ChoiceOf<'a> = (&'a Path, &'a Path, &'a [String]);

/// Refuses a choice of something else.
pub(crate) fn refused(what: &str, (file, scene, flags): ChoiceOf) -> Failure {
    let words = [&[quoted(scene)], flags].concat().join(" ");
    let (shown, to) = (file.display(), quoted(file));
    Failure::Usage(format!(
        "{shown}: found a choice {what}; make it anew: niji plan {words} -o {to} --force"
    ))
}

/// Makes the plan of a scene that stands in the file `path`.
///
/// # Errors
/// A drop volume that is missing or wrong, or a scene that cannot be planned.
pub(crate) fn planned(scene: Scene, path: &Path, common: &Common) -> Result<PlannedScene, Failure> {
    planned_as_before(scene, path, (common, None))
}

/// The same, for which something may have been chosen before.
///
/// # Errors
/// As [`planned`].
pub(crate) fn planned_as_before(
    scene: Scene,
    path: &Path,
    (common, choice): (&Common, Option<&Choice>),
) -> Result<PlannedScene, Failure> {
    let keeper = KeptChoices::of(common);
    let is_kept = Cell::new(false);
    let kept = |request: &str| {
        let found = keeper.find(request);
        is_kept.set(found.is_some());
        found
    };
    let request = PlanRequest {
        choice,
        kept: &kept,
        ..beside(path)
    };
    let planned = planned_for(scene, path, request)?;
    if !is_kept.get() && Some(&planned.choice) != choice {
        keeper.keep(&planned.choice);
    }
    Ok(planned)
}

/// A scene whose picture has to keep a tolerance.
pub(crate) fn at_tolerance(scene: Scene, tolerance: f64) -> Scene {
    let goal = Goal {
        preset: None,
        tolerance: Some(tolerance),
    };
    goal.of(scene)
}

/// Files that a scene names lie beside its own.
pub(crate) fn beside(path: &Path) -> PlanRequest<'_> {
    PlanRequest {
        folder: path.parent().unwrap_or(Path::new("")),
        version: version(),
        hash_of: hash_once,
        ..PlanRequest::default()
    }
}

/// Makes the plan of a scene as it is asked for.
///
/// # Errors
/// As [`planned`].
pub(crate) fn planned_for(
    scene: Scene,
    path: &Path,
    request: PlanRequest,
) -> Result<PlannedScene, Failure> {
    PlannedScene::new(scene, request).map_err(|error| unplannable(path, error))
}

/// Why the scene of a file cannot be planned.
pub(crate) fn unplannable(path: &Path, error: Error) -> Failure {
    match error {
        Error::Plan(_) | Error::NoFrameWithDrops(_) => Failure::bad_input(path, error),
        error => error.into(),
    }
}

/// Reads a scene.
///
/// # Errors
/// A scene that is missing or wrong.
pub(crate) fn read(path: &Path, common: &Common) -> Result<Scene, Failure> {
    let text = text_file::read(path)?;
    parsed(&text, path, common)
}

/// Reads the scene of a frame, whose text stands for that of the file `path`.
///
/// # Errors
/// As [`read`], and a scene of a photograph.
pub(crate) fn frame_scene(text: &str, path: &Path, common: &Common) -> Result<Scene, Failure> {
    let scene = parsed(text, path, common)?;
    if scene.photo.is_some() {
        let message = "a photograph is a single frame: its scene has no sequence";
        return Err(Failure::bad_input(path, message));
    }
    Ok(scene)
}

/// Reads the text of a scene.
fn parsed(text: &str, path: &Path, common: &Common) -> Result<Scene, Failure> {
    let scene = common.sandbox()?.scene_from_toml(text, beside(path).folder);
    let scene = scene.map_err(|error| match error {
        Error::SceneFile(SceneError::UnknownKey { key, .. }) if key == "ice" => Failure::bad_input(
            path,
            format!(
                "this is a scene of ice: `niji ice {} -o EXR` makes its picture",
                path.display()
            ),
        ),
        Error::SceneFile(error) => Failure::bad_input(path, error),
        error => error.into(),
    })?;
    let goal = common.goal();
    keepable(goal)?;
    let mut scene = goal.of(scene);
    if let Some(spectral) = common.spectral {
        scene.picture.spectral = spectral;
    }
    Ok(scene)
}

/// Refuses a tolerance that no picture keeps, before anybody waits for one.
fn keepable(goal: Goal) -> Result<(), Failure> {
    let least = goal
        .tolerance
        .filter(|tolerance| *tolerance < LEAST_TOLERANCE);
    least.map_or(Ok(()), |tolerance| {
        Err(Failure::AccuracyNotReached(format!(
            "found --tolerance {tolerance:e}, expected at least {LEAST_TOLERANCE:e}: numbers of a picture have \
             24 bits, so that none is nearer (nothing was made)"
        )))
    })
}
