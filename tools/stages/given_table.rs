//! A scattering table from elsewhere in place of the scene's own.

use std::path::Path;
use std::path::PathBuf;

use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;
use niji_scene::ScatteringNeed;

use crate::failure::Failure;
use crate::progress::Verbosity;
use crate::stages;
use niji_picture::PlannedScene;

/// The table that serves a plan, if one is given and any is needed.
///
/// # Errors
/// As [`read`].
pub(crate) fn given(
    planned: &PlannedScene,
    path: Option<&Path>,
    verbosity: Verbosity,
) -> Result<Option<PathBuf>, Failure> {
    let Some(path) = path else {
        return Ok(None);
    };
    let Some(need) = &planned.plan.scattering else {
        warn_unused(verbosity);
        return Ok(None);
    };
    read(path, need, planned.scene.spectrum)?;
    Ok(Some(path.to_owned()))
}

/// Says on standard error that a table is of no use.
pub(crate) fn warn_unused(verbosity: Verbosity) {
    verbosity.warn("the plan of this scene needs no scattering table: --table is not used");
}

/// Reads a table that serves a scene.
///
/// # Errors
/// A file that is no scattering table, or one that does not serve the scene, with all that is wrong and
/// what to change.
pub(crate) fn read(
    path: &Path,
    need: &ScatteringNeed,
    wavelengths: WavelengthGrid,
) -> Result<ScatteringTable, Failure> {
    let table = stages::scatter::read(path)?;
    let misfits = need.misfits(&table, wavelengths);
    if misfits.is_empty() {
        return Ok(table);
    }
    let misfits: Vec<String> = misfits.iter().map(ToString::to_string).collect();
    Err(Failure::bad_input(
        path,
        format!(
            "the table does not serve this scene: {}; flags are those of `niji scatter`, which makes \
             the scene's own by --scene",
            misfits.join("; ")
        ),
    ))
}
