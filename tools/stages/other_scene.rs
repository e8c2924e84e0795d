//! Air that was made for another scene, as far as its header tells.
//!
//! A picture takes it: whoever wants the light of one air over the ground of another may have it. But it
//! is said, because a table that was forgotten looks the same.

use std::path::Path;

use niji_picture::air;
use niji_scene::Scene;
use serde_json::Value;

use crate::progress::Verbosity;
use crate::stages::stored_provenance;

/// What settings of the air hold by index, and where a scene has it.
const PARTS_OF_AIR: [(usize, &str); 3] = [(0, "[air]"), (1, "[ground]"), (3, "[sun]")];

/// Says on standard error in what the air was made for another scene.
pub(crate) fn warn(scene: &Scene, air: Option<&Path>, verbosity: Verbosity) {
    if verbosity == Verbosity::Quiet {
        return;
    }
    for warning in air.map_or_else(Vec::new, |path| other_air(scene, path)) {
        verbosity.warn(warning);
    }
}

/// The air of another scene.
fn other_air(scene: &Scene, path: &Path) -> Vec<String> {
    let expected = serde_json::from_str::<Value>(&air::settings(scene, None)).ok();
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
