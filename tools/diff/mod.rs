//! `niji diff`: how far one file is from another, for people, for scripts and as a check.

mod exr;
mod measure;
mod vdb;

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::stages::is_vdb;

use measure::Measure;

/// Compare a VDB or EXR file with a reference.
///
/// Channels that differ in wavelength only, S0.550,0nm say, are taken together.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji diff reference/image.exr draft/image.exr
  niji diff a/image.exr b/image.exr --max-relative-rmse 1e-3 -o difference.exr
  niji diff a/drops.vdb b/drops.vdb --max-difference 0

Columns: relative RMSE (over the RMS of the reference), RMSE, bias (mean of FILE - REFERENCE),
largest difference and where: channel and pixel from the top left, or grid and voxel. A threshold
that does not hold, or parts, channels or sizes that differ, end with exit code 6.")]
pub(crate) struct DiffCommand {
    /// The file that counts as true.
    reference: PathBuf,
    /// The file that is judged.
    file: PathBuf,
    /// Largest RMSE of any channel group or grid, over the RMS of the reference.
    #[arg(long, value_name = "E", value_parser = threshold)]
    max_relative_rmse: Option<f64>,
    /// Largest difference of any value, in its unit.
    #[arg(long, value_name = "D", value_parser = threshold)]
    max_difference: Option<f64>,
    /// Write FILE - REFERENCE as EXR.
    #[arg(short, long, value_name = "EXR")]
    output: Option<PathBuf>,
}

fn threshold(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err(format!("found {text}, expected a number from 0")),
    }
}

/// Compares two files and checks the thresholds.
///
/// # Errors
/// A missing or damaged file, files of which one is a VDB and one is not, or a comparison that fails.
pub(crate) fn execute(command: &DiffCommand, common: &Common) -> Result<(), Failure> {
    let (reference, file) = (&command.reference, &command.file);
    if let Some(path) = &command.output {
        output::check_free(path, common.options().existing)?;
    }
    let measures = match (is_vdb(reference), is_vdb(file)) {
        (true, true) if command.output.is_some() => {
            return Err(Failure::Usage(
                "-o writes differences of EXR files only".to_owned(),
            ));
        }
        (true, true) => vdb::compare(reference, file)?,
        (false, false) => exr::compare(reference, file, command.output.as_deref())?,
        _ => {
            let message = "found a VDB file and another, expected two of a kind";
            return Err(Failure::Usage(message.to_owned()));
        }
    };
    if common.json {
        let rows: Vec<_> = measures.iter().map(Measure::json).collect();
        output::print(&format!("{:#}\n", json!(rows)))?;
    } else if !common.quiet {
        output::print(&measure::table(&measures))?;
    }
    for measure in &measures {
        measure.check(command.max_relative_rmse, command.max_difference)?;
    }
    Ok(())
}
