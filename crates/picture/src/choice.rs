//! What a plan decided and what was measured for it, kept so that nobody measures it again.

use std::collections::BTreeMap;

use niji_exchange::Provenance;
use niji_scene::Foretold;
use niji_scene::Picture;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::canonical_json;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;

use crate::budget::Afforded;
use crate::pilot::Seen;

/// What a plan decided, and what it was decided from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// The program that decided, as far as it decides on results.
    pub version: String,
    /// Hash of the scene with what is asked of its picture, of what bounds foretell, and of the program.
    pub request: String,
    /// The effects that are on.
    pub effects: Vec<String>,
    /// The level of every stage.
    pub levels: Value,
    /// How it was to be shown: display white, over which errors are told, follows from it. Shown otherwise, the same
    /// picture serves as long as its error allows.
    #[serde(default)]
    pub picture: Picture,
    /// What there was time for, where a picture had to be there at a time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub afforded: Option<Afforded>,
    /// What was measured for it.
    pub(crate) seen: Seen,
}

impl Choice {
    /// Of a plan for a picture by a version of the program for a request, with what was measured.
    pub(crate) fn of(
        (plan, picture): (&Plan, Picture),
        (version, request): (&str, String),
        seen: Seen,
    ) -> Self {
        let on = plan.effects_on().map(|effect| effect.name().to_owned());
        Self {
            version: version.to_owned(),
            request,
            effects: on.collect(),
            levels: serde_json::to_value(plan.levels).unwrap_or_default(),
            picture,
            afforded: None,
            seen,
        }
    }
}

/// What a choice is made for, by a version of the program from files of drops; `drops` tells where which drops are.
pub(crate) fn request(
    (version, files): (&str, &BTreeMap<String, String>),
    scene: &Scene,
    drops: &str,
    foretold: &Foretold,
) -> String {
    let on: Vec<&str> = foretold.on.iter().map(|effect| effect.name()).collect();
    let provenance = Provenance {
        version: version.to_owned(),
        settings: canonical_json(&(scene, drops, on, foretold.further_orders)),
        inputs: files.clone(),
        ..Provenance::default()
    };
    provenance.request_hash()
}
