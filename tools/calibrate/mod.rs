//! `niji calibrate`: the tables of measurements: bounds of effects, theories, methods of the air, ice.

mod air;
mod ice;
mod theories;

use std::path::Path;
use std::path::PathBuf;

use clap::ArgGroup;
use clap::Args;
use serde::Serialize;

use crate::failure::Failure;
use crate::flags::Common;
use crate::measure_effects::measure;
use crate::output;
use crate::scene_file;

/// Measure bounds of effects, theories and methods against what they bound or stand for.
///
/// With --effects: what switching every effect of scenes over changes, as `niji plan --measure`, beside
/// its bound. With --theories: error against time of the theories of one drop by radius, for both bows,
/// against the exact order and the exact light. With --air: of the methods for lengths, segments and
/// skies of air, against converged quadrature. With --ice: of the levels of light through ice, against
/// many more paths.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji calibrate --effects data/scenes/moonbow.toml --date 2026-11-22 -o bounds.csv
  niji calibrate --theories --date 2026-11-21 -o data/measurements/theories.csv --force
  niji calibrate --air --date 2026-11-21 -o data/measurements/air.csv --force
  niji calibrate --ice --date 2026-11-21 -o data/measurements/ice.csv --force")]
#[command(group = ArgGroup::new("what").required(true))]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub(crate) struct CalibrateCommand {
    /// The scenes whose effects are measured.
    #[arg(required_if_eq("effects", "true"), conflicts_with_all = ["theories", "air", "ice"])]
    scenes: Vec<PathBuf>,
    /// Measure what every effect of the scenes changes, beside its bound.
    #[arg(long, group = "what")]
    effects: bool,
    /// Measure the theories of one drop.
    #[arg(long, group = "what")]
    theories: bool,
    /// Measure the methods of the air.
    #[arg(long, group = "what")]
    air: bool,
    /// Measure the levels of light through ice.
    #[arg(long, group = "what")]
    ice: bool,
    /// Day of the measurement, written into the file.
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: String,
    /// The file to write.
    #[arg(short, long, value_name = "CSV")]
    output: PathBuf,
}

/// Measures and writes the file.
///
/// # Errors
/// A scene that cannot be run, or an output that exists or cannot be written.
pub(crate) fn execute(command: &CalibrateCommand, common: &Common) -> Result<(), Failure> {
    let options = common.options();
    output::check_free(&command.output, options.existing)?;
    if command.theories {
        let rows = theories::rows(&command.date, options.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    if command.air {
        let rows = air::rows(&command.date, options.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    if command.ice {
        let rows = ice::rows(&command.date, options.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    let mut rows = Vec::new();
    for path in &command.scenes {
        let measured = measure(&scene_file::load(path, common)?, options.verbosity)?;
        rows.extend(measured.rows(&command.date));
    }
    write_csv(&rows, &command.output)
}

fn write_csv(rows: &[impl Serialize], path: &Path) -> Result<(), Failure> {
    output::write_csv(path, rows)?;
    output::print(&format!("{}\n", path.display()))
}
