//! Scene files and their plans, as every command reads them.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_scene::Choice;
use niji_scene::ChoiceRequest;
use niji_scene::DropSummary;
use niji_scene::Effect;
use niji_scene::Goal;
use niji_scene::MeasuredLevels;
use niji_scene::Moment;
use niji_scene::Plan;
use niji_scene::PlanInputs;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::SunPosition;
use niji_scene::Switch;
use niji_scene::calls_for_multiple_scattering;
use niji_scene::choose;
use niji_scene::plan as plan_of;

use crate::check::ephemeris::TimeAndPlace;
use crate::cli::Common;
use crate::failure::Failure;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::drops::Part;
use crate::stages::drops::Source;

/// What was measured by `niji calibrate`, as it was when the program was built.
const MEASURED: &str = include_str!("../data/measurements/levels.csv");

/// A scene and what it calls for.
pub(crate) struct Planned {
    /// Its file, to whose folder paths in it are relative.
    pub file: PathBuf,
    /// The scene, with the accuracy asked for on the command line.
    pub scene: Scene,
    /// What it calls for.
    pub plan: Plan,
    /// How its levels were chosen, where a tolerance or a budget was asked for.
    pub choice: Option<Choice>,
    /// What levels cost.
    pub measured: MeasuredLevels,
    /// Its drop volume, where it names one.
    pub drop_file: Option<PathBuf>,
    /// What its drop volume is made from, where it names none.
    pub drop_source: Option<Source>,
}

/// What was measured about levels of accuracy: in a file, or before the program was built.
///
/// # Errors
/// A file that is missing or damaged; never for a program that was built from sound sources.
fn measured_levels(file: Option<&Path>) -> Result<MeasuredLevels, Failure> {
    let Some(path) = file else {
        let built_in = MeasuredLevels::from_csv(MEASURED);
        return built_in.map_err(|error| Failure::Failed(error.to_string()));
    };
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(path, error);
    let text = fs::read_to_string(path).map_err(|error| bad(&error))?;
    MeasuredLevels::from_csv(&text).map_err(|error| bad(&error))
}

/// What is asked of the levels of a scene.
#[derive(Default)]
struct Asked {
    goal: Option<Goal>,
    /// The file of measurements.
    calibration: Option<PathBuf>,
    /// Levels that were chosen already, of a frame before.
    chosen: Option<Choice>,
    /// Whether the levels of the preset are to stay, because it was asked for by name.
    keeps_preset: bool,
}

impl Asked {
    fn of(common: &Common) -> Self {
        let tolerance = common.tolerance.map(Goal::Tolerance);
        Self {
            goal: tolerance.or(common.budget.map(Goal::Budget)),
            calibration: common.calibration.clone(),
            chosen: None,
            keeps_preset: common.accuracy.is_some(),
        }
    }
}

/// Reads a scene and makes its plan, with levels chosen for the tolerance or the budget on the command
/// line.
///
/// # Errors
/// A scene, a drop volume or a calibration that is missing or wrong, or a budget that cannot be kept.
pub(crate) fn load(path: &Path, common: &Common) -> Result<Planned, Failure> {
    planned_with(read(path, common)?, path, |drops| drops, Asked::of(common))
}

/// Makes the plan of a scene that stands in the file `path`.
///
/// # Errors
/// A drop volume that is missing or wrong, or a scene that cannot be planned.
pub(crate) fn planned(scene: Scene, path: &Path) -> Result<Planned, Failure> {
    planned_with(scene, path, |drops| drops, Asked::default())
}

/// As [`planned`], with levels chosen for a tolerance.
///
/// # Errors
/// As [`planned`], and a calibration that is missing or wrong.
pub(crate) fn planned_for(
    mut scene: Scene,
    path: &Path,
    (tolerance, common): (f64, &Common),
) -> Result<Planned, Failure> {
    let asked = Asked {
        goal: Some(Goal::Tolerance(tolerance)),
        calibration: common.calibration.clone(),
        ..Asked::default()
    };
    scene.accuracy.tolerance = tolerance;
    planned_with(scene, path, |drops| drops, asked)
}

fn planned_with(
    mut scene: Scene,
    path: &Path,
    of_file: impl Fn(DropSummary) -> DropSummary,
    asked: Asked,
) -> Result<Planned, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let drop_file = scene.drops.file().map(|file| folder.join(file));
    let drop_source = Source::of(&scene.drops, folder);
    // Once for all plans.
    let drops = match (&drop_file, &drop_source) {
        (_, Some(source)) => source.summary(of_file)?,
        (Some(file), None) => Source::only(Part::Volume(file.clone())).summary(of_file)?,
        (None, None) => None,
    };
    let measured = measured_levels(asked.calibration.as_deref())?;
    let inputs = PlanInputs {
        measured: &measured,
        drops,
    };
    let bad = |error| Failure::bad_input(path, with_causes(&error));
    let mut plan = plan_of(&scene, &inputs).map_err(bad)?;
    if let Some(Goal::Tolerance(tolerance)) = asked.goal
        && calls_for_multiple_scattering(&scene, &plan, tolerance)
    {
        scene.effects.set(Effect::MultipleScattering, Switch::On);
        plan = plan_of(&scene, &inputs).map_err(bad)?;
    }
    let choice = chosen(&mut scene, &plan, (asked, &measured))?;
    if let Some(choice) = &choice {
        scene.accuracy = choice.accuracy;
        plan = plan_of(&scene, &inputs).map_err(bad)?;
    }
    Ok(Planned {
        file: path.to_owned(),
        scene,
        plan,
        choice,
        measured,
        drop_file,
        drop_source,
    })
}

/// The levels for what is asked; `None` where nothing is.
fn chosen(
    scene: &mut Scene,
    plan: &Plan,
    (asked, measured): (Asked, &MeasuredLevels),
) -> Result<Option<Choice>, Failure> {
    let Some(goal) = asked.goal else {
        return Ok(None);
    };
    if asked.chosen.is_some() {
        return Ok(asked.chosen);
    }
    if asked.keeps_preset {
        scene.accuracy = scene.accuracy.spelled_out(plan.work.voxel_m);
    }
    let request = ChoiceRequest {
        scene,
        plan,
        measured,
        goal,
    };
    let choice = choose(&request).map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(Some(choice))
}

/// Reads a scene.
///
/// # Errors
/// A scene that is missing or wrong.
pub(crate) fn read(path: &Path, common: &Common) -> Result<Scene, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::bad_input(path, error))?;
    parsed(&stages::photo::with_picked_sun(text, path)?, path, common)
}

/// Reads a scene with the levels that [`load`] gives it, for stages that need no plan.
///
/// # Errors
/// As [`read`], and as [`load`] where levels are to be chosen.
pub(crate) fn read_with_levels(path: &Path, common: &Common) -> Result<Scene, Failure> {
    if common.tolerance.is_none() && common.budget.is_none() {
        return read(path, common);
    }
    Ok(load(path, common)?.scene)
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

/// Makes the plan of a frame, whose text stands for that of the file `path`: what it needs is rounded,
/// so that other frames need the same. What was chosen for a frame before is kept: levels that change
/// would be seen.
///
/// # Errors
/// As [`load`] and [`frame_scene`].
pub(crate) fn frame(
    text: &str,
    path: &Path,
    (common, chosen): (&Common, Option<Choice>),
) -> Result<Planned, Failure> {
    let scene = frame_scene(text, path, common)?;
    let asked = Asked {
        chosen,
        ..Asked::of(common)
    };
    let mut planned = planned_with(scene, path, DropSummary::with_rounded_sizes, asked)?;
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
    /// What the estimated error of a pixel may be before it gets more rays, relative to the reference
    /// luminance; `None` where no tolerance was asked for.
    pub(crate) fn tolerance_for_rays(&self) -> Option<f64> {
        self.choice.as_ref().and_then(|choice| choice.for_rays)
    }

    /// Says on standard error that a tolerance is out of reach, before anything runs for it.
    pub(crate) fn warn_of_tolerance(&self, verbosity: Verbosity) {
        let warning = self.choice.as_ref().and_then(Choice::out_of_reach);
        if let (Some(warning), true) = (warning, verbosity > Verbosity::Quiet) {
            eprintln!("{:>11}  {warning}", "warning");
        }
    }

    /// Refuses a scene whose scattering table the stage would refuse, in the same words.
    ///
    /// # Errors
    /// [`Failure::Usage`] if the table cannot be made, for one because it is too large.
    pub(crate) fn check_table(&self) -> Result<(), Failure> {
        let refused = self.plan.table_refused.as_ref();
        refused.map_or(Ok(()), |error| Err(Failure::Usage(error.to_string())))
    }

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
