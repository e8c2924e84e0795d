//! Any text as a scene file. A scene that is read survives its canonical JSON.

#![no_main]

use libfuzzer_sys::fuzz_target;
use niji_scene::Scene;

fuzz_target!(|text: &str| {
    let Ok(scene) = Scene::from_toml(text) else {
        return;
    };
    let json = scene.canonical_json();
    let again = Scene::from_json(&json).expect("a scene's own JSON is a scene");
    assert_eq!(json, again.canonical_json());
});
