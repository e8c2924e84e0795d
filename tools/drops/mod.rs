//! `niji drops`: a shape, from flags or from a scene, becomes a drop volume, and several become one.

mod mix;
mod shape_command;
mod shape_examples;

use std::path::PathBuf;

use clap::Args;
use clap::Subcommand;
use niji_vdb::Compression;

use crate::failure::Failure;
use crate::flags::Common;
use crate::scene_file;
use crate::stages;

use mix::MixCommand;
use shape_command::ShapeCommand;

/// Place in the help of what follows the flags of a shape.
const AFTER_SHAPE: usize = 100;

/// Author a drop volume (VDB).
///
/// Grids number_density [1/m3], effective_radius [m], effective_variance, and density (extinction at
/// Q = 2, 1/m) for display. Says how much water there is and warns where nature has no such volume.
#[derive(Debug, Args)]
#[command(subcommand_required = false, args_conflicts_with_subcommands = false)]
#[command(after_help = "Examples:
  niji drops uniform --box-min-m=-50,0,-150 --box-max-m=50,60,-50 --voxel-m 2 \\
      --law monodisperse --radius-um 100 --number-density-m3 1000 -o spray.vdb
  niji drops rain-shaft --rain-rate-mm-h 5 --footprint column --radius-m 300 \\
      --center-xz-m 0,-500 --base-y-m 0 --top-y-m 800 --voxel-m 20 -o rain.vdb
  niji drops from-vdb smoke.vdb --grid density --density-means water --scale 0.3 \\
      --effective-radius-um 200 -o drops.vdb
  niji drops mix drizzle=small.vdb shower.vdb -o rain.vdb
  niji drops --scene data/scenes/paper-c-figure-4.toml -o drops.vdb")]
pub(crate) struct DropsCommand {
    /// The scene whose section [drops] is meant, instead of a shape.
    #[arg(long, value_name = "TOML")]
    scene: Option<PathBuf>,
    /// The file to write.
    #[arg(short, long, value_name = "VDB", global = true, display_order = AFTER_SHAPE)]
    output: Option<PathBuf>,
    /// Deflate the voxels: slow, and noisy values hardly shrink.
    #[arg(long, global = true, display_order = AFTER_SHAPE)]
    zip: bool,
    #[command(subcommand)]
    what: Option<DropsSubcommand>,
}

/// What the drops are made from.
#[derive(Clone, Debug, Subcommand)]
enum DropsSubcommand {
    #[command(flatten)]
    Shape(ShapeCommand),
    Mix(MixCommand),
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::drops::make`]; neither or both of a shape and a scene.
pub(crate) fn execute(command: &DropsCommand, common: &Common) -> Result<(), Failure> {
    let source = match (&command.what, &command.scene) {
        (Some(_), Some(_)) => {
            return Err(Failure::Usage(
                "found a shape and --scene, expected one of them".to_owned(),
            ));
        }
        (None, None) => {
            return Err(Failure::Usage(format!(
                "expected a shape ({}) or --scene",
                shape_command::names()
            )));
        }
        (Some(DropsSubcommand::Shape(shape)), None) => shape.source()?,
        (Some(DropsSubcommand::Mix(mix)), None) => mix.source()?,
        (None, Some(path)) => {
            let is_file = || {
                Failure::Usage("the scene names a drop volume, there is nothing to make".to_owned())
            };
            let planned = scene_file::load(path, common)?;
            planned.drop_source.ok_or_else(is_file)?
        }
    };
    let no_output = || Failure::Usage("expected -o FILE.vdb".to_owned());
    let output = command.output.as_deref().ok_or_else(no_output)?;
    let compression = if command.zip {
        Compression::Zip
    } else {
        Compression::None
    };
    stages::drops::make(&source, compression, output, common.options()).map(|_| ())
}
