//! The scattering table that a scene needs.

use niji_airy::AiryTable;
use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;
use niji_scatter::adaptive_table;
use niji_scene::ScatteringNeed;
use niji_scene::Stage;
use niji_scene::canonical_json;

use crate::error::Error;
use crate::watch::Watch;

/// The table that is needed; `airy` is Airy's integral in advance, taken where the theory uses it.
///
/// # Errors
/// A need that cannot be met; [`Error::Stopped`].
pub fn table(
    need: &ScatteringNeed,
    wavelengths: WavelengthGrid,
    airy: Option<&AiryTable>,
    watch: Watch,
) -> Result<ScatteringTable, Error> {
    let airy = airy.filter(|_| need.theory.uses_airy_table());
    let request = need.request(wavelengths, airy);
    Ok(adaptive_table(&request, &|part| {
        watch(Stage::Scatter, part)
    })?)
}

/// What a table depends on besides Airy's integral, as JSON.
pub fn settings(need: &ScatteringNeed, wavelengths: WavelengthGrid) -> String {
    let spectrum = (
        wavelengths.first_nm(),
        wavelengths.step_nm(),
        wavelengths.len(),
    );
    canonical_json(&(need, spectrum))
}

/// A table without what a scene of spheres does not move, where any table may serve it.
pub fn as_needed(mut table: ScatteringTable, need: &ScatteringNeed) -> ScatteringTable {
    if need.motion.is_none() {
        table.moved = None;
    }
    table
}
