//! `niji info`: what a VDB or EXR file holds, for people, for scripts and as a check.

mod assertion;
mod exr;
mod preview;
mod vdb;

use std::path::PathBuf;

use clap::Args;
use niji_picture::read_vdb;
use niji_radiometry::open_file;
use serde_json::Value;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::stages::is_vdb;

use assertion::Assertion;
use assertion::Ranges;

/// Say what a VDB or EXR file holds; assert it in scripts.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji info out/drops.vdb
  niji info out/image.exr --json
  niji info out/drops.vdb --assert 'max(effective_radius) < 2e-3'
  niji info out/drops.vdb --preview drops.png

NAME in an assertion is a grid of a VDB file (values of active voxels) or a channel of an EXR
file, PART:CHANNEL where several parts have it. A failed assertion ends with exit code 6.")]
pub(crate) struct InfoCommand {
    /// The file.
    file: PathBuf,
    /// A condition that must hold: min|max|mean(NAME) < | <= | > | >= NUMBER; may be repeated.
    #[arg(long, value_name = "CONDITION")]
    assert: Vec<Assertion>,
    /// Draw the float grids of a VDB file: a row each, projections along x, y, z, then slices.
    #[arg(long, value_name = "PNG")]
    preview: Option<PathBuf>,
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
    if let Some(preview) = &command.preview {
        output::check_free(preview, common.options().existing)?;
    }
    // A pipe would be waited for.
    open_file(path).map_err(|error| Failure::bad_input(path, error))?;
    let report = if is_vdb(path) {
        let file = read_vdb(path, |_| true)?;
        if let Some(to) = &command.preview {
            preview::write(&file, (path, to), common.verbosity())?;
        }
        vdb::report(&file)
    } else if command.preview.is_some() {
        return Err(Failure::Usage(
            "--preview draws VDB files; an image has its PNG beside it, a table is drawn by \
             `niji scatter --table FILE --plot SVG`"
                .to_owned(),
        ));
    } else {
        exr::report(path)?
    };
    if common.json {
        output::print(&format!("{:#}\n", report.json))?;
    } else if !common.quiet {
        output::print(&report.text)?;
    }
    for assertion in &command.assert {
        assertion.check(&report.ranges, path)?;
    }
    Ok(())
}
