//! Scene files and their plans, as every command reads them.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_render::ask_for_memory;
use niji_scene::DropSummary;
use niji_scene::Effect;
use niji_scene::Moment;
use niji_scene::Plan;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::Stage;
use niji_scene::SunPosition;
use niji_scene::Switch;
use niji_scene::calls_for_multiple_scattering;
use niji_scene::levels_for_tolerance;
use niji_scene::plan as plan_of;
use niji_scene::tolerance_for_rays;

use crate::check::ephemeris::TimeAndPlace;
use crate::cli::Common;
use crate::failure::Failure;
use crate::stages;
use crate::stages::drops::Part;
use crate::stages::drops::Source;

/// A scene and what it calls for.
pub(crate) struct Planned {
    /// Its file, to whose folder paths in it are relative.
    pub file: PathBuf,
    /// The scene, with the accuracy asked for on the command line.
    pub scene: Scene,
    /// What it calls for.
    pub plan: Plan,
    /// The tolerance that was asked for on the command line, which the picture has to keep.
    pub tolerance: Option<f64>,
    /// Its drop volume, where it names one.
    pub drop_file: Option<PathBuf>,
    /// What its drop volume is made from, where it names none.
    pub drop_source: Option<Source>,
}

/// Reads a scene and makes its plan, with levels for the tolerance on the command line.
///
/// # Errors
/// A scene or a drop volume that is missing or wrong.
pub(crate) fn load(path: &Path, common: &Common) -> Result<Planned, Failure> {
    planned_for(read(path, common)?, path, (|drops| drops, common))
}

/// Makes the plan of a scene that stands in the file `path`.
///
/// # Errors
/// A drop volume that is missing or wrong, or a scene that cannot be planned.
pub(crate) fn planned(scene: Scene, path: &Path) -> Result<Planned, Failure> {
    let drops = Drops::of(&scene, path, |drops| drops)?;
    let plan = drops.plan(&scene)?;
    Ok(drops.planned((scene, plan), None))
}

/// As [`planned`], with what the tolerance on the command line calls for.
fn planned_for(
    mut scene: Scene,
    path: &Path,
    (of_file, common): (impl Fn(DropSummary) -> DropSummary, &Common),
) -> Result<Planned, Failure> {
    let drops = Drops::of(&scene, path, of_file)?;
    let mut plan = drops.plan(&scene)?;
    if let Some(tolerance) = common.tolerance
        && calls_for_multiple_scattering(&scene, &plan, tolerance)
    {
        scene.effects.set(Effect::MultipleScattering, Switch::On);
        plan = drops.plan(&scene)?;
    }
    Ok(drops.planned((scene, plan), common.tolerance))
}

/// The drops of a scene, looked at once for all its plans.
struct Drops<'a> {
    path: &'a Path,
    file: Option<PathBuf>,
    source: Option<Source>,
    summary: Option<DropSummary>,
}

impl<'a> Drops<'a> {
    fn of(
        scene: &Scene,
        path: &'a Path,
        of_file: impl Fn(DropSummary) -> DropSummary,
    ) -> Result<Self, Failure> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let file = scene.drops.file().map(|file| folder.join(file));
        let source = Source::of(&scene.drops, folder);
        let summary = match (&file, &source) {
            (_, Some(source)) => source.summary(of_file)?,
            (Some(file), None) => Source::only(Part::Volume(file.clone())).summary(of_file)?,
            (None, None) => None,
        };
        Ok(Self {
            path,
            file,
            source,
            summary,
        })
    }

    fn plan(&self, scene: &Scene) -> Result<Plan, Failure> {
        plan_of(scene, self.summary.clone())
            .map_err(|error| Failure::bad_input(self.path, with_causes(&error)))
    }

    fn planned(self, (scene, plan): (Scene, Plan), tolerance: Option<f64>) -> Planned {
        Planned {
            file: self.path.to_owned(),
            scene,
            plan,
            tolerance,
            drop_file: self.file,
            drop_source: self.source,
        }
    }
}

/// Reads a scene.
///
/// # Errors
/// A scene that is missing or wrong.
pub(crate) fn read(path: &Path, common: &Common) -> Result<Scene, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::bad_input(path, error))?;
    parsed(&stages::photo::with_picked_sun(text, path)?, path, common)
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
/// so that other frames need the same.
///
/// # Errors
/// As [`load`] and [`frame_scene`].
pub(crate) fn frame(text: &str, path: &Path, common: &Common) -> Result<Planned, Failure> {
    let scene = frame_scene(text, path, common)?;
    let mut planned = planned_for(scene, path, (DropSummary::with_rounded_sizes, common))?;
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
    if let Some(tolerance) = common.tolerance {
        scene.accuracy.tolerance = tolerance;
    }
    match (common.accuracy, common.tolerance) {
        (Some(preset), _) => scene.accuracy.preset = preset.into(),
        (None, Some(tolerance)) => scene.accuracy = levels_for_tolerance(&scene, tolerance),
        (None, None) => (),
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
        self.tolerance.map(tolerance_for_rays)
    }

    /// Refuses a scene whose scattering table the stage would refuse, in the same words:
    /// [`Failure::Usage`] if the table cannot be made, for one because it is too large.
    fn check_table(&self) -> Result<(), Failure> {
        let refused = self.plan.table_refused.as_ref();
        refused.map_or(Ok(()), |error| Err(Failure::Usage(error.to_string())))
    }

    /// Refuses whatever a stage of the run would refuse later.
    ///
    /// # Errors
    /// As [`Self::check_inputs`], [`Self::check_light`] and [`Self::check_memory`].
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.check_light()?;
        self.check_inputs()?;
        self.check_memory()
    }

    /// Refuses a scene without a table, or without a file that it names.
    ///
    /// # Errors
    /// As [`Self::check_table`]; a file that is not there.
    pub(crate) fn check_inputs(&self) -> Result<(), Failure> {
        self.check_table()?;
        let folder = self.file.parent().unwrap_or(Path::new(""));
        let (photo, occluders) = (self.scene.photo.iter(), self.scene.occluders.iter());
        let of_photo = photo.flat_map(|it| [&it.layers, &it.labels].into_iter().flatten());
        let maps = occluders.clone().filter_map(|it| it.depth.as_ref());
        let meshes = occluders.flat_map(|it| it.meshes.iter().map(|mesh| &mesh.file));
        for file in of_photo.chain(maps).chain(meshes) {
            let path = folder.join(file);
            fs::metadata(&path).map_err(|error| Failure::bad_input(&path, error))?;
        }
        Ok(())
    }

    /// Refuses a picture for which memory cannot be had, in the words of the renderer.
    ///
    /// # Errors
    /// [`Failure::Failed`].
    pub(crate) fn check_memory(&self) -> Result<(), Failure> {
        let region = self.scene.camera.region();
        let region = region.map_err(|error| Failure::Usage(error.to_string()))?;
        let mut stages = self.plan.stages.iter();
        let picture = stages.find(|planned| planned.stage == Stage::Render);
        // Its file at most, as numbers lie in memory.
        let bytes = picture.and_then(|planned| planned.estimate.file_bytes);
        ask_for_memory((region.width_px, region.height_px), bytes.unwrap_or(0)).map_err(|error| {
            Failure::Failed(format!("{error} (`niji render --tiles` or `--region`)"))
        })
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
