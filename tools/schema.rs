//! `niji schema`: what a scene file may say, for editors.

use clap::Args;

use crate::failure::Failure;
use crate::output;

/// The JSON Schema of scene files, on standard output.
///
/// Editors complete and check a scene that begins with the line `#:schema scene.schema.json`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  niji schema > scene.schema.json\n  \
                        niji schema --ice > ice-scene.schema.json")]
pub(crate) struct SchemaCommand {
    /// That of scenes of ice.
    #[arg(long)]
    ice: bool,
}

/// Prints the schema.
///
/// # Errors
/// As [`output::print`].
pub(crate) fn execute(command: &SchemaCommand) -> Result<(), Failure> {
    let schema = if command.ice {
        niji_scene::ice_scene_schema()
    } else {
        niji_scene::scene_schema()
    };
    output::print(&format!("{schema:#}\n"))
}
