//! Scene files and their plans, as every command reads them.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_scene::DropSummary;
use niji_scene::MeasuredLevels;
use niji_scene::Moment;
use niji_scene::Plan;
use niji_scene::PlanInputs;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::SunPosition;
use niji_scene::plan;

use crate::check::ephemeris::TimeAndPlace;
use crate::cli::Common;
use crate::failure::Failure;
use crate::stages;
use crate::stages::drops::Source;

/// What was measured by `niji calibrate`, as it was when the program was built.
const MEASURED: &str = include_str!("../data/measurements/levels.csv");

/// A scene and what it calls for.
pub(crate) struct Planned {
    /// Its file, to whose folder paths in it are relative.
    pub file: PathBuf,
    /// The scene, with the accuracy asked for on the command line.
    pub scene: Scene,
    /// The tolerance asked for on the command line, which the picture shall keep.
    pub asked_tolerance: Option<f64>,
    /// What it calls for.
    pub plan: Plan,
    /// Its drop volume, where it names one.
    pub drop_file: Option<PathBuf>,
    /// What its drop volume is made from, where it names none.
    pub drop_source: Option<Source>,
}

/// What was measured about levels of accuracy.
///
/// # Errors
/// Never for a program that was built from sound sources.
pub(crate) fn measured_levels() -> Result<MeasuredLevels, Failure> {
    MeasuredLevels::from_csv(MEASURED).map_err(|error| Failure::Failed(error.to_string()))
}

/// Reads a scene and makes its plan.
///
/// # Errors
/// A scene or a drop volume that is missing or wrong, or a scene without any light.
pub(crate) fn load(path: &Path, common: &Common) -> Result<Planned, Failure> {
    let planned = planned(read(path, common)?, path)?;
    Ok(Planned {
        asked_tolerance: common.tolerance,
        ..planned
    })
}

/// Makes the plan of a scene that stands in the file `path`.
///
/// # Errors
/// A drop volume that is missing or wrong, or a scene that cannot be planned.
pub(crate) fn planned(scene: Scene, path: &Path) -> Result<Planned, Failure> {
    planned_with(scene, path, |drops| drops)
}

fn planned_with(
    scene: Scene,
    path: &Path,
    of_file: impl Fn(DropSummary) -> DropSummary,
) -> Result<Planned, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(path, error);
    let folder = path.parent().unwrap_or(Path::new(""));
    let drop_file = scene.drops.file().map(|file| folder.join(file));
    let drop_source = Source::of(&scene.drops, folder);
    let volume = match (&drop_file, &drop_source) {
        (Some(file), _) => Some(stages::drops::read(file)?),
        (None, Some(density @ Source::Density(..))) => Some(density.volume()?),
        // The plan knows shapes by itself.
        (None, Some(Source::Shape(_)) | None) => None,
    };
    let drops = volume.as_ref().and_then(DropSummary::of_volume);
    let drops = drops.map(of_file);
    let measured = measured_levels()?;
    let inputs = PlanInputs {
        measured: &measured,
        drops,
    };
    let plan = plan(&scene, &inputs).map_err(|error| bad(&with_causes(&error)))?;
    Ok(Planned {
        file: path.to_owned(),
        scene,
        asked_tolerance: None,
        plan,
        drop_file,
        drop_source,
    })
}

/// Reads a scene.
///
/// # Errors
/// A scene that is missing or wrong.
pub(crate) fn read(path: &Path, common: &Common) -> Result<Scene, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::bad_input(path, error))?;
    parsed(&stages::photo::with_picked_sun(text, path)?, path, common)
}

/// Edge of a voxel of a scene's drops in metres; 1 for drops of a file.
pub(crate) fn voxel_m(scene: &Scene) -> f64 {
    let shape = scene.drops.shape();
    shape.map_or(1.0, |shape| shape.grid().voxel_m)
}

/// Makes the plan of a frame, whose text stands for that of the file `path`: what it needs is rounded,
/// so that other frames need the same.
///
/// # Errors
/// As [`load`], and a scene of a photograph.
pub(crate) fn frame(text: &str, path: &Path, common: &Common) -> Result<Planned, Failure> {
    let scene = parsed(text, path, common)?;
    if scene.photo.is_some() {
        let message = "a photograph is a single frame: its scene has no sequence";
        return Err(Failure::bad_input(path, message));
    }
    let mut planned = planned_with(scene, path, DropSummary::with_rounded_sizes)?;
    planned.asked_tolerance = common.tolerance;
    let need = planned.plan.scattering.take();
    planned.plan.scattering = need.map(ScatteringNeed::with_rounded_directions);
    Ok(planned)
}

/// Reads the text of a scene.
fn parsed(text: &str, path: &Path, common: &Common) -> Result<Scene, Failure> {
    let mut scene = Scene::from_toml_with(text, sun_position).map_err(|error| match error {
        SceneError::UnknownKey { key, .. } if key == "ice" => Failure::bad_input(
            path,
            format!(
                "this is a scene of ice: `niji ice {} -o EXR` makes its picture",
                path.display()
            ),
        ),
        error => Failure::bad_input(path, error),
    })?;
    if let Some(preset) = common.accuracy {
        scene.accuracy.preset = preset.into();
    }
    if let Some(tolerance) = common.tolerance {
        scene.accuracy.tolerance = tolerance;
    }
    Ok(scene)
}

/// Where the sun of a scene stands at a moment.
fn sun_position(moment: &Moment) -> Result<SunPosition, String> {
    let at = TimeAndPlace {
        local_time: moment.local_time,
        utc_offset_h: moment.utc_offset_h,
        position_deg: [moment.latitude_deg, moment.longitude_deg],
    };
    let [elevation_deg, azimuth_deg] = at.sun_deg().map_err(|failure| failure.to_string())?;
    Ok(SunPosition {
        elevation_deg,
        azimuth_deg,
    })
}

/// An error and its causes in one line.
pub(crate) fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += ": ";
        text += &error.to_string();
        cause = error.source();
    }
    text
}

impl Planned {
    /// Refuses a scene that sends no light at all.
    ///
    /// # Errors
    /// [`Failure::Impossible`] if no effect that is on sends light into the picture.
    pub(crate) fn check_light(&self) -> Result<(), Failure> {
        if !self.plan.is_dark() {
            return Ok(());
        }
        Err(Failure::Impossible(format!(
            "{}: no effect that is on sends any light into the picture: a bow needs drops in view at \
             its angle and the sun above the horizon, a sky needs air; `niji plan` says what each \
             effect contributes",
            self.scene.name
        )))
    }
}
