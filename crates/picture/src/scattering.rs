//! The scattering table that a scene needs.

use niji_airy::AiryTable;
use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;
use niji_scatter::adaptive_table;
use niji_scatter::phase_functions;
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
    let of_seen = if need.phase_functions {
        SHARE_OF_SEEN
    } else {
        1.0
    };
    let mut table = adaptive_table(&request, &|part| watch(Stage::Scatter, of_seen * part))?;
    if need.phase_functions {
        let progress = |part| watch(Stage::Scatter, of_seen + (1.0 - of_seen) * part);
        table.phase_functions = Some(Box::new(phase_functions(&request, &progress)?));
    }
    Ok(table)
}

/// What is told of the part done of a table with phase functions when all of what is seen is.
pub const SHARE_OF_SEEN: f64 = 0.8;

/// What a table depends on besides Airy's integral, as JSON.
pub fn settings(need: &ScatteringNeed, wavelengths: WavelengthGrid) -> String {
    let spectrum = (
        wavelengths.first_nm(),
        wavelengths.step_nm(),
        wavelengths.len(),
    );
    // What is made does not depend on it.
    let need = ScatteringNeed {
        support_um: (0.0, 0.0),
        ..need.clone()
    };
    canonical_json(&(need, spectrum))
}

/// A table without what a scene has no use for, where any table may serve it.
pub fn as_needed(mut table: ScatteringTable, need: &ScatteringNeed) -> ScatteringTable {
    if need.motion.is_none() {
        table.moved = None;
    }
    if !need.phase_functions {
        table.phase_functions = None;
    }
    table
}
