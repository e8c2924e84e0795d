//! The stage `scatter`: a theory, drop sizes and the sun's disc become a scattering table.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;
use std::time::Instant;

use niji_airy::AIRY_SMALLEST_RADIUS;
use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use niji_picture::scattering;
use niji_radiometry::WavelengthGrid;
use niji_scatter::Theory;
use niji_scene::ScatteringNeed;

use crate::failure::Failure;
use crate::output;
use crate::progress;
use crate::progress::Estimate;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "scatter.exr";
/// Steps of the progress bar.
const N_PROGRESS_STEPS: f64 = 1000.0;

/// What a scattering table is made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableInputs<'a> {
    /// What it has to hold.
    pub need: &'a ScatteringNeed,
    /// For which wavelengths.
    pub wavelengths: WavelengthGrid,
    /// The table of f(z), where the theory uses it.
    pub airy: Option<&'a Path>,
}

/// Writes the scattering table that is needed.
///
/// # Errors
/// A need that cannot be met, an input that is missing or damaged, an output that exists, or a file
/// that cannot be written.
pub(crate) fn make(
    made_from: TableInputs,
    to: &Path,
    options: StageOptions,
) -> Result<Done, Failure> {
    let TableInputs {
        need,
        wavelengths,
        airy,
    } = made_from;
    let airy = airy.filter(|_| need.theory.uses_airy_table());
    let inputs = airy.map(|path| ("airy", path)).into_iter().collect();
    let settings = scattering::settings(need, wavelengths);
    let request = Request {
        stage: "scatter",
        settings,
        inputs,
        outputs: vec![to],
    };
    let mut further_orders_s = 0.0;
    let done = perform(&request, options, |provenance| {
        let (table, seconds) = timed(need, wavelengths, airy, options.verbosity)?;
        further_orders_s = seconds;
        let file = table.to_file(provenance);
        output::write_file(to, |writer| file.write(writer))
    })?;
    Ok(Done {
        further_orders_s,
        ..done
    })
}

/// The scattering table that is needed, with progress.
///
/// # Errors
/// A need that cannot be met, or a table of f(z) that is missing or damaged.
pub(crate) fn computed(
    need: &ScatteringNeed,
    wavelengths: WavelengthGrid,
    airy: Option<&Path>,
    verbosity: Verbosity,
) -> Result<ScatteringTable, Failure> {
    timed(need, wavelengths, airy, verbosity).map(|(table, _)| table)
}

/// The same, and the seconds that went into its phase functions.
fn timed(
    need: &ScatteringNeed,
    wavelengths: WavelengthGrid,
    airy: Option<&Path>,
    verbosity: Verbosity,
) -> Result<(ScatteringTable, f64), Failure> {
    warn_of_small_drops(need, verbosity);
    let airy = airy.filter(|_| need.theory.uses_airy_table());
    let airy = airy.map(stages::airy::read).transpose()?;
    let bar = progress::bar("scatter", N_PROGRESS_STEPS as u64, verbosity);
    let shown = AtomicU64::new(0);
    let estimate = Estimate::new("scatter", verbosity);
    let start = Instant::now();
    let seen = OnceLock::new();
    let table = scattering::table(need, wavelengths, airy.as_ref(), &|_, part| {
        if need.phase_functions && part >= scattering::SHARE_OF_SEEN {
            seen.get_or_init(|| start.elapsed());
        }
        let step = (part * N_PROGRESS_STEPS) as u64;
        if shown.fetch_max(step, Ordering::Relaxed) < step {
            bar.set_position(step);
            estimate.hear(part, &bar);
        }
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    let of_phases = seen.get().map(|seen| start.elapsed().saturating_sub(*seen));
    Ok((table?, of_phases.unwrap_or_default().as_secs_f64()))
}

/// How far linear interpolation along each axis is from the theory, where that is known.
pub(crate) fn interpolation_error(table: &ScatteringTable) -> Option<String> {
    let title = "interpolation error over the peak of the bow, rms and largest:";
    let mut lines = vec![title.to_owned()];
    for (axis, error) in table.interpolation_error?.axes() {
        lines.push(format!("  {axis:<19} {:.1e}  {:.1e}", error.rms, error.max));
    }
    Some(lines.join("\n"))
}

/// Airy's theory is no theory of fog.
fn warn_of_small_drops(need: &ScatteringNeed, verbosity: Verbosity) {
    let smallest_um = need
        .effective_radius_um
        .first()
        .copied()
        .unwrap_or(f64::INFINITY);
    let is_airy = matches!(need.theory, Theory::Airy | Theory::AiryPublished);
    if is_airy && smallest_um < AIRY_SMALLEST_RADIUS.0 {
        verbosity.warn(format_args!(
            "the smallest drops have {smallest_um:.1} µm: of those below {} µm Airy's bow is wrong by more than 8 % and \
             misplaced; accuracy.theory = \"by-size\" is right for all",
            AIRY_SMALLEST_RADIUS.0
        ));
    }
}

/// Reads a scattering table.
///
/// # Errors
/// A missing or damaged file, or one that holds something else.
pub(crate) fn read(path: &Path) -> Result<ScatteringTable, Failure> {
    let file = TableFile::read(path).map_err(|error| Failure::bad_input(path, error))?;
    ScatteringTable::from_file(file).map_err(|error| Failure::bad_input(path, error))
}
