//! What a plan decided and what was measured for it, kept so that nobody measures it again.

use std::collections::BTreeMap;

use niji_exchange::Provenance;
use niji_scene::Picture;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::canonical_json;
use serde::Deserialize;
use serde::Serialize;

use crate::budget::Afforded;
use crate::pilot::Seen;

/// What a plan decided, and what it was decided from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// The program that decided, as far as it decides on results.
    pub version: String,
    /// Hash of the scene with what is asked of its picture, of its files of drops, and of the program.
    pub request: String,
    /// How it was to be shown: display white, over which errors are told, follows from it. Shown otherwise, the same
    /// picture serves as long as its error allows.
    #[serde(default)]
    pub picture: Picture,
    /// What there was time for, where a picture had to be there at a time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub afforded: Option<Afforded>,
    /// What it calls for.
    pub plan: Plan,
    /// What was measured for it.
    pub(crate) seen: Seen,
}

/// What a choice is made for, by a version of the program from files of drops.
pub(crate) fn request(
    (version, files): (&str, &BTreeMap<String, String>),
    scene: &Scene,
) -> String {
    let provenance = Provenance {
        version: version.to_owned(),
        settings: canonical_json(scene),
        inputs: files.clone(),
        ..Provenance::default()
    };
    provenance.request_hash()
}
