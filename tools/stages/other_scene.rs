//! Tables that were made for another scene, as far as their headers tell.
//!
//! A picture takes them: whoever wants the light of one air over the ground of another may have it. But it
//! is said, because a table that was forgotten looks the same.

use std::path::Path;

use niji_radiometry::Water;
use niji_scene::Scene;
use serde_json::Value;

use crate::progress::Verbosity;
use crate::stages;
use crate::stages::stored_provenance;

/// Water in settings of a scattering table; salt stands there only if there is any.
const TEMPERATURE: &str = "temperature_c";
const SALINITY: &str = "salinity_per_mille";
/// What settings of the air hold by index, and where a scene has it.
const PARTS_OF_AIR: [(usize, &str); 3] = [(0, "[air]"), (1, "[ground]"), (3, "[sun]")];

/// Says on standard error which tables were made for another scene.
pub(crate) fn warn(
    scene: &Scene,
    (table, air): (Option<&Path>, Option<&Path>),
    verbosity: Verbosity,
) {
    if verbosity == Verbosity::Quiet {
        return;
    }
    let of_water = table.and_then(|path| other_water(scene, path));
    let of_air = air.map_or_else(Vec::new, |path| other_air(scene, path));
    for warning in of_water.into_iter().chain(of_air) {
        eprintln!("{:>11}  {warning}", "warning");
    }
}

/// A scattering table of other water.
fn other_water(scene: &Scene, path: &Path) -> Option<String> {
    let settings = settings(path, "niji scatter")?;
    let need = settings.get(0)?;
    let found = Water {
        temperature_c: need.get(TEMPERATURE)?.as_f64()?,
        salinity_per_mille: need.get(SALINITY).and_then(Value::as_f64).unwrap_or(0.0),
    };
    let expected = scene.water();
    // Both were read from decimals.
    (found != expected).then(|| {
        format!(
            "{}: made of water at {found}, the scene has {expected} in [water]: the bow stands \
             elsewhere; make it anew with niji scatter --scene",
            path.display()
        )
    })
}

/// The air of another scene.
fn other_air(scene: &Scene, path: &Path) -> Vec<String> {
    let expected = serde_json::from_str::<Value>(&stages::atmosphere::settings(scene, None)).ok();
    let Some((found, expected)) = settings(path, "niji atmosphere").zip(expected) else {
        return Vec::new();
    };
    let differing = PARTS_OF_AIR.into_iter().filter_map(|(index, section)| {
        let (found, expected) = (found.get(index)?, expected.get(index)?);
        (found != expected).then(|| {
            format!(
                "{}: made for {section} {found}, the scene has {expected}; make it anew with niji \
                 atmosphere --scene",
                path.display()
            )
        })
    });
    differing.collect()
}

/// The settings of a file that a stage of this program made; `None` for any other.
fn settings(path: &Path, tool: &str) -> Option<Value> {
    let provenance = stored_provenance(path).filter(|provenance| provenance.tool == tool)?;
    serde_json::from_str(&provenance.settings).ok()
}
