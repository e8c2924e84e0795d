//! `niji drops`: a shape, from flags or from a scene, becomes a drop volume.

mod flags;

use std::path::PathBuf;

use clap::Args;
use clap::Subcommand;
use niji_droplets::Shape;
use niji_vdb::Compression;

use crate::cli::Common;
use crate::failure::Failure;
use crate::scene_file;
use crate::stages;

use flags::GradientFlags;
use flags::RainShaftFlags;
use flags::UniformFlags;

/// Author a drop volume (VDB).
///
/// Grids number_density [1/m3], effective_radius [m], effective_variance, and density (extinction at
/// Q = 2, 1/m) for display. Says how much water there is and warns where nature has no such volume.
#[derive(Debug, Args)]
#[command(subcommand_required = false, args_conflicts_with_subcommands = false)]
#[command(after_help = "Examples:
  niji drops uniform --box-min-m=-50,0,-150 --box-max-m=50,60,-50 --voxel-m 2 \\
      --law monodisperse --radius-um 100 --number-density-m3 1000 -o spray.vdb
  niji drops rain-shaft --rain-rate-mm-h 5 --radius-m 300 --top-m 800 --voxel-m 20 -o rain.vdb
  niji drops --scene data/scenes/paper-c-figure-4.toml -o drops.vdb")]
pub(crate) struct DropsCommand {
    /// The scene whose section [drops] is meant, instead of a shape.
    #[arg(long, value_name = "TOML")]
    scene: Option<PathBuf>,
    /// The file to write.
    #[arg(short, long, value_name = "VDB", global = true)]
    output: Option<PathBuf>,
    /// Deflate the voxels: slow, and noisy values hardly shrink.
    #[arg(long, global = true)]
    zip: bool,
    #[command(subcommand)]
    shape: Option<ShapeCommand>,
}

#[derive(Debug, Subcommand)]
enum ShapeCommand {
    Uniform(UniformFlags),
    Gradient(GradientFlags),
    RainShaft(RainShaftFlags),
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::drops::make`]; neither or both of a shape and a scene.
pub(crate) fn execute(command: &DropsCommand, common: &Common) -> Result<(), Failure> {
    let shape = match (&command.shape, &command.scene) {
        (Some(_), Some(_)) => {
            return Err(Failure::Usage(
                "found a shape and --scene, expected one of them".to_owned(),
            ));
        }
        (None, None) => {
            let shapes = "uniform, gradient, rain-shaft";
            return Err(Failure::Usage(format!(
                "expected a shape ({shapes}) or --scene"
            )));
        }
        (Some(shape), None) => of_flags(shape)?,
        (None, Some(path)) => {
            let scene = scene_file::read(path, common)?;
            let is_file = || {
                Failure::Usage("the scene names a drop volume, there is nothing to make".to_owned())
            };
            scene.drops.shape().ok_or_else(is_file)?
        }
    };
    let no_output = || Failure::Usage("expected -o FILE.vdb".to_owned());
    let output = command.output.as_deref().ok_or_else(no_output)?;
    let compression = if command.zip {
        Compression::Zip
    } else {
        Compression::None
    };
    stages::drops::make(&shape, compression, output, common.manner()).map(|_| ())
}

fn of_flags(shape: &ShapeCommand) -> Result<Shape, Failure> {
    match shape {
        ShapeCommand::Uniform(flags) => flags.shape(),
        ShapeCommand::Gradient(flags) => Ok(flags.shape()),
        ShapeCommand::RainShaft(flags) => flags.shape(),
    }
}
