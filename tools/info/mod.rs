//! `niji info`: what a VDB or EXR file holds, for people, for scripts and as a check.

mod assertion;
mod exr;
mod vdb;

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use crate::cli::Common;
use crate::failure::Failure;
use crate::stages::is_vdb;

use assertion::Assertion;
use assertion::Ranges;

/// Say what a VDB or EXR file holds; assert it in scripts.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji info out/drops.vdb
  niji info out/image.exr --json
  niji info out/drops.vdb --assert 'max(effective_radius) < 2e-3'

NAME in an assertion is a grid of a VDB file (values of active voxels) or a channel of an EXR
file, PART:CHANNEL where several parts have it. A failed assertion ends with exit code 6.")]
pub(crate) struct InfoCommand {
    /// The file.
    file: PathBuf,
    /// A condition that must hold: min|max|mean(NAME) < | <= | > | >= NUMBER; may be repeated.
    #[arg(long, value_name = "CONDITION")]
    assert: Vec<Assertion>,
}

/// What there is to say about a file.
struct Report {
    /// For people.
    text: String,
    /// For scripts.
    json: Value,
    /// For assertions.
    ranges: Ranges,
}

/// Prints what a file holds and checks the assertions.
///
/// # Errors
/// A missing or damaged file, a name that the file has not, or an assertion that does not hold.
pub(crate) fn execute(command: &InfoCommand, common: &Common) -> Result<(), Failure> {
    let path = &command.file;
    let report = if is_vdb(path) {
        vdb::report(path)?
    } else {
        exr::report(path)?
    };
    if common.json {
        println!("{:#}", report.json);
    } else if !common.quiet {
        print!("{}", report.text);
    }
    for assertion in &command.assert {
        assertion.check(&report.ranges, path)?;
    }
    Ok(())
}
