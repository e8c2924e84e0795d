//! The scenes that come with the project.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_scene::IceScene;
use niji_scene::PickedSun;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::SunPosition;
use niji_scene::plan;

/// All scene files with their texts.
fn texts() -> Vec<(PathBuf, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes");
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// Scenes of ice are documents of their own.
fn is_ice(text: &str) -> bool {
    text.contains("\n[ice.shape]\n")
}

fn shipped() -> Vec<(PathBuf, Scene)> {
    let read = |(path, text): (PathBuf, String)| {
        // Where picks in a photograph tell the sun, here it stands about where they put it.
        let picked = |_: &Scene| -> Result<PickedSun, SceneError> {
            let position = SunPosition {
                elevation_deg: 27.0,
                azimuth_deg: 190.0,
            };
            Ok(position.into())
        };
        let scene = Scene::from_toml_with_picks(&text, picked);
        let scene = scene.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        (path, scene)
    };
    let bows = texts().into_iter().filter(|(_, text)| !is_ice(text));
    bows.map(read).collect()
}

fn is_named_after_its_file(path: &Path, name: &str) -> bool {
    path.file_stem().is_some_and(|stem| stem == name)
}

#[test]
fn every_scene_of_ice_parses_and_is_named_after_its_file() {
    let scenes: Vec<_> = texts()
        .into_iter()
        .filter(|(_, text)| is_ice(text))
        .collect();
    assert!(scenes.len() >= 4, "{} scenes", scenes.len());
    for (path, text) in scenes {
        let scene = IceScene::from_toml(&text);
        let scene = scene.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            is_named_after_its_file(&path, &scene.name),
            "{}",
            scene.name
        );
    }
}

#[test]
fn every_scene_parses_and_plans_and_is_named_after_its_file() {
    let scenes = shipped();
    assert!(scenes.len() >= 12, "{} scenes", scenes.len());
    for (path, scene) in scenes {
        assert!(
            is_named_after_its_file(&path, &scene.name),
            "{}",
            scene.name
        );
        let plan = plan(&scene, None).unwrap();
        println!("{plan}");
        assert_eq!(Scene::from_json(&scene.canonical_json()).unwrap(), scene);
        if scene.name == "clear-sky" {
            continue;
        }
        assert!(!plan.is_dark(), "{}", scene.name);
        let scattering = plan.scattering.as_ref().expect("every scene shows a bow");
        assert!(scattering.orders.contains(&2), "{:?}", scattering.orders);
    }
}
