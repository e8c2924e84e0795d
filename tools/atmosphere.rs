//! `niji atmosphere`: the air of a scene.

use std::path::PathBuf;

use clap::Args;

use crate::cli::Common;
use crate::failure::Failure;
use crate::scene_file;
use crate::stages;

/// Tabulate the air (EXR).
///
/// Density profiles, lengths to the top of the air, phase functions, sunlight and ground albedo.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  niji atmosphere --scene data/scenes/paper-b-sun-10-inscatter.toml -o atmosphere.exr")]
pub(crate) struct AtmosphereCommand {
    /// The scene whose section [air] is meant.
    #[arg(long, value_name = "TOML")]
    scene: PathBuf,
    /// The file to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::atmosphere::make`]; a scene in a vacuum.
pub(crate) fn execute(command: &AtmosphereCommand, common: &Common) -> Result<(), Failure> {
    let scene = scene_file::read(&command.scene, common)?;
    stages::atmosphere::make(&scene, &command.output, common.manner()).map(|_| ())
}
