//! What the tests of plans share.

#![allow(dead_code, reason = "each test target uses a part of it")]

use niji_scene::Effect;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Switch;
use niji_scene::plan;

/// The scene of a text.
pub(crate) fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

/// A scene in which everything decides itself.
pub(crate) fn all_auto(text: &str) -> Scene {
    let mut scene = scene(text);
    for effect in Effect::ALL {
        scene.effects.set(effect, Switch::Auto);
    }
    scene
}

/// The plan of a shape.
pub(crate) fn planned(scene: &Scene) -> Plan {
    plan(scene, None).unwrap()
}
