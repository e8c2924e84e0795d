//! `niji airy`: the table of Airy's integral.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::flags::Common;
use crate::stages;

/// Tabulate the rainbow integral f(z) (EXR).
///
/// One table serves every drop up to 2 mm radius, every wavelength and every order.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  niji airy -o airy.exr")]
pub(crate) struct AiryCommand {
    /// The scene it is for; every scene needs the same table.
    #[arg(long, value_name = "TOML")]
    scene: Option<PathBuf>,
    /// The file to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::airy::make`].
pub(crate) fn execute(command: &AiryCommand, common: &Common) -> Result<(), Failure> {
    stages::airy::make(&command.output, common.options()).map(|_| ())
}
