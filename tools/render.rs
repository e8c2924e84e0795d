//! `niji render`: the picture of a scene from the files of the other stages.

use std::path::PathBuf;

use clap::Args;
use niji_scene::Along;

use crate::cli::Common;
use crate::failure::Failure;
use crate::scene_file;
use crate::stages;
use crate::stages::render::Inputs;
use crate::stages::render::Surfaces;

/// Integrate along the view rays (EXR, PNG).
///
/// Writes the spectral image with its AOVs, a plain *.rgb.exr and a PNG preview beside it.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  niji render --scene scene.toml --drops drops.vdb --table scatter.exr -o image.exr")]
pub(crate) struct RenderCommand {
    /// The scene: camera, sun, effects and levels.
    #[arg(long, value_name = "TOML")]
    scene: PathBuf,
    /// The drop volume.
    #[arg(long, value_name = "VDB")]
    drops: PathBuf,
    /// The scattering table.
    #[arg(long, value_name = "EXR")]
    table: Option<PathBuf>,
    /// The air.
    #[arg(long, value_name = "EXR")]
    air: Option<PathBuf>,
    /// Distances of surfaces that hide what is behind them (EXR, Z in metres along the ray, see
    /// `niji depth`) [default: those of the scene].
    #[arg(long, value_name = "EXR")]
    depth: Option<PathBuf>,
    /// The spectral image to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::render::make`]; a file that the scene's plan needs and that is not named.
pub(crate) fn execute(command: &RenderCommand, common: &Common) -> Result<(), Failure> {
    let planned = scene_file::load(&command.scene, common)?;
    planned.check_light()?;
    let need = |name, is_needed: bool, given: &Option<PathBuf>| match (is_needed, given) {
        (true, None) => Err(Failure::Usage(format!("this scene needs --{name}"))),
        (true, Some(path)) => Ok(Some(path.clone())),
        (false, _) => Ok(None),
    };
    let table = need("table", planned.plan.scattering.is_some(), &command.table)?;
    let runs_air = planned.plan.runs(niji_scene::Stage::Atmosphere);
    let air = need("air", runs_air, &command.air)?;
    let scene = &planned.scene;
    let of_scene = stages::render::scene_surfaces(scene, &command.scene);
    let given = command.depth.clone().map(|path| Surfaces {
        path,
        along: Along::Ray,
    });
    let surfaces = given.or(of_scene);
    if scene.photo.is_some() && surfaces.is_none() {
        return Err(Failure::Usage("this scene needs --depth".to_owned()));
    }
    let inputs = Inputs {
        drops: &command.drops,
        table: table.as_deref(),
        air: air.as_deref(),
        surfaces: surfaces.as_ref(),
    };
    let settings = stages::render::Settings::of(&planned);
    stages::render::make(&settings, inputs, &command.output, common.manner()).map(|_| ())
}
