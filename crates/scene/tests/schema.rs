//! The JSON Schema and the reader of scene files agree.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

#[path = "schema/validator.rs"]
mod validator;

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::fs;

use niji_scene::IceScene;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::SunPosition;
use niji_scene::ice_scene_schema;
use niji_scene::scene_schema;
use serde_json::Value;
use serde_json::json;

use validator::first_fault;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/");

/// Reads a document as a scene of ice if it is one; a sun that is to be picked stands at 30 degrees.
fn read(document: &Value) -> Result<(), SceneError> {
    let text = toml::to_string(document).unwrap();
    if document.get("ice").is_some() {
        return IceScene::from_toml(&text).map(|_| ());
    }
    let picked = SunPosition {
        elevation_deg: 30.0,
        azimuth_deg: 180.0,
    };
    Scene::from_toml_with_picks(&text, |_| Ok(picked.into())).map(|_| ())
}

fn schema_of(document: &Value) -> Value {
    if document.get("ice").is_some() {
        ice_scene_schema()
    } else {
        scene_schema()
    }
}

fn document(path: &str) -> Value {
    let text = fs::read_to_string(format!("{DATA}{path}")).unwrap();
    toml::from_str(&text).unwrap()
}

/// The paths of all scenes that come with the project, below the folder of data.
fn shipped() -> Vec<String> {
    let names = |folder: &str| {
        let entries = fs::read_dir(format!("{DATA}{folder}")).unwrap();
        let files = entries.map(|entry| entry.unwrap().path());
        let scenes = files.filter(|file| file.extension().is_some_and(|it| it == "toml"));
        let names = scenes.map(|file| file.file_name().unwrap().to_owned());
        let paths = names.map(|name| format!("{folder}/{}", name.to_str().unwrap()));
        paths.collect::<Vec<_>>()
    };
    let mut paths = [names("scenes"), names("measurements")].concat();
    paths.sort();
    paths
}

#[test]
fn the_schemas_in_data_are_those_of_the_reader() {
    for (name, schema) in [
        ("scene.schema.json", scene_schema()),
        ("ice-scene.schema.json", ice_scene_schema()),
    ] {
        let found = fs::read_to_string(format!("{DATA}{name}")).unwrap();
        let as_printed = format!("{schema:#}\n");
        assert!(found == as_printed, "{name}: write it again by niji schema");
    }
}

#[test]
fn every_shipped_scene_is_as_the_schema_says() {
    let paths = shipped();
    assert!(paths.len() > 35, "{paths:?}");
    for path in paths {
        let scene = document(&path);
        assert_eq!(first_fault(&schema_of(&scene), &scene), None, "{path}");
        read(&scene).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
}

/// The key by which a table says what it is.
fn naming_key(schema: &Value) -> &str {
    let is_choice = |key: &&str| schema["properties"][key].get("oneOf").is_some();
    ["shape", "level"]
        .into_iter()
        .find(is_choice)
        .unwrap_or_default()
}

#[test]
fn every_key_says_what_it_is() {
    fn check(schema: &Value, path: &str) {
        for (key, field) in schema["properties"].as_object().into_iter().flatten() {
            let is_bare = field.is_boolean() || field.get("const").is_some();
            assert!(
                is_bare || field.get("description").is_some() || key == naming_key(schema),
                "{path}/{key}"
            );
        }
        let children = match schema {
            Value::Object(object) => object.iter().map(|(key, it)| (key.clone(), it)).collect(),
            Value::Array(items) => items.iter().map(|it| (String::new(), it)).collect(),
            _ => Vec::new(),
        };
        for (key, child) in children {
            if key != "anyOf" && key != "if" {
                check(child, &format!("{path}/{key}"));
            }
        }
    }
    check(&scene_schema(), "scene");
    check(&ice_scene_schema(), "ice");
}

/// Sets, or with null removes, what stands at a path.
fn with(document: &Value, path: &str, value: Value) -> Value {
    let mut changed = document.clone();
    let (parent, key) = path.rsplit_once('/').unwrap();
    match changed.pointer_mut(parent).unwrap() {
        Value::Object(table) if value.is_null() => drop(table.remove(key).unwrap()),
        Value::Object(table) => drop(table.insert(key.to_owned(), value)),
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        other => panic!("{parent} is {other}"),
    }
    changed
}

#[test]
fn wrong_scenes_are_refused_by_schema_and_reader() {
    let rain = "scenes/rain-shaft-5-mm-h.toml";
    let berg = "scenes/ice-iceberg-rainbow.toml";
    let twinned = "scenes/twinned-bow.toml";
    for (scene, path, value) in [
        // Misspelt, at three depths.
        (rain, "/drop", json!({})),
        (rain, "/camera/widht_px", json!(64)),
        (rain, "/drops/footprint/colum", json!({ "radius_m": 3.0 })),
        (berg, "/ice/colour", json!("blue")),
        // Of the wrong type.
        (rain, "/sun/elevation_deg", json!("high")),
        (rain, "/camera/width_px", json!(64.5)),
        (rain, "/camera/position_m", json!([0.0, 1.6])),
        (rain, "/accuracy", json!("draft")),
        // Out of range.
        (rain, "/format", json!(2)),
        (rain, "/camera/width_px", json!(0)),
        (rain, "/drops/voxel_m", json!(-1.0)),
        (rain, "/sun/elevation_deg", json!(91.0)),
        (berg, "/ice/shape/length_m", json!(-5.0)),
        // Of several drops.
        (twinned, "/drops", json!([])),
        (twinned, "/drops/1/voxel_m", json!(-1.0)),
        (twinned, "/drops/1/name", json!(2)),
        (twinned, "/drops/1/name", json!("")),
        (twinned, "/drops/0/source", json!("file")),
        (twinned, "/drops/0/shape", Value::Null),
        (twinned, "/drops/0", json!("rain.vdb")),
        // Missing.
        (rain, "/sun", Value::Null),
        (rain, "/drops/voxel_m", Value::Null),
        (rain, "/drops/shape", Value::Null),
        (berg, "/ice/shape", Value::Null),
        // No such name.
        (rain, "/drops/shape", json!("drizzle")),
        (rain, "/effects", json!({ "occluders": "off" })),
        (
            rain,
            "/terrain",
            json!({ "file": "a.png", "spacing_m": 30.0, "height_m": [0.0, 900.0], "albedo": "gras" }),
        ),
        (rain, "/accuracy", json!({ "sun_path": "march" })),
        (rain, "/accuracy", json!({ "theory": { "level": "debye" } })),
        // Twice, or not at all.
        (rain, "/sun/date_time", json!("2026-06-21T18:30:00+02:00")),
        (rain, "/camera/horizontal_fov_deg", Value::Null),
        (rain, "/camera/focal_length_mm", json!(35.0)),
        (rain, "/air", json!({ "constituents": ["ozone", "ozone"] })),
    ] {
        let sound = document(scene);
        let wrong = with(&sound, path, value.clone());
        let schema = schema_of(&sound);
        assert_eq!(first_fault(&schema, &sound), None);
        assert!(
            first_fault(&schema, &wrong).is_some(),
            "schema: {path} = {value}"
        );
        assert!(read(&wrong).is_err(), "reader: {path} = {value}");
    }
}

/// Scenes that have every shape, size law and level with settings.
fn scenes_with_everything() -> Vec<Value> {
    let mut all: Vec<Value> = [
        "fog-bank-fogbow",
        "garden-fountain",
        "ice-cube-0.1-m",
        "ice-iceberg-rainbow",
        "rain-cell",
        "rain-shaft-5-mm-h",
        "sea-spray",
        "waterfall-gorge",
    ]
    .map(|name| document(&format!("scenes/{name}.toml")))
    .into();
    let rain = document("scenes/rain-shaft-5-mm-h.toml");
    let boxed = |more: Value| {
        let mut drops = json!({
            "box_min_m": [-10.0, 0.0, -40.0], "box_max_m": [10.0, 20.0, -20.0], "voxel_m": 2.0,
        });
        drops
            .as_object_mut()
            .unwrap()
            .extend(more.as_object().unwrap().clone());
        with(&rain, "/drops", drops)
    };
    all.push(boxed(json!({
        "shape": "gradient", "axis": "y", "radius_at_min_um": 500.0, "radius_at_max_um": 100.0,
        "number_density_at_min_m3": 10.0, "number_density_at_max_m3": 20.0, "effective_variance": 0.1,
    })));
    let amounts =
        |law: Value| boxed(json!({ "shape": "uniform", "law": law, "number_density_m3": 9.0 }));
    all.extend([
        amounts(json!({ "monodisperse": { "radius_um": 100.0 } })),
        amounts(json!({ "uniform": { "radius_min_um": 50.0, "radius_max_um": 100.0 } })),
        amounts(json!({ "normal": { "radius_mean_um": 99.0, "radius_standard_deviation_um": 9.0 } })),
        amounts(json!({ "modified-gamma": { "alpha": 6.0, "b_per_um_gamma": 1.5, "gamma": 1.0 } })),
        amounts(json!({ "hansen-travis": { "effective_radius_um": 10.0, "effective_variance": 0.1 } })),
        amounts(json!({ "ulbrich": { "shape": 2.0, "slope_per_mm": 2.0, "d_max_mm": 8.0 } })),
        amounts(json!({ "lognormal":
            { "radius_median_um": 10.0, "geometric_standard_deviation": 2.0, "d_min_mm": 0.001 } })),
        amounts(json!({ "rosin-rammler": { "diameter_mm": 1.0, "spread": 3.5 } })),
        amounts(json!({ "truncated-normal": { "radius_mean_um": 99.0,
            "radius_standard_deviation_um": 9.0, "d_min_mm": 0.1, "d_max_mm": 0.4 } })),
        boxed(json!({ "shape": "uniform", "law": { "marshall-palmer": { "rain_rate_mm_h": 5.0 } } })),
        boxed(json!({ "shape": "uniform", "law": { "marshall-palmer-dbz": { "reflectivity_dbz": 30.0 } } })),
        with(&rain, "/drops", json!({ "shape": "from-vdb", "file": "cloud.vdb",
            "density_means": "water", "scale": 0.3, "effective_radius_um": 10.0, "effective_variance": 0.1 })),
        with(&rain, "/drops", json!([
            { "name": "small", "shape": "uniform", "box_min_m": [-10.0, 0.0, -40.0],
              "box_max_m": [10.0, 20.0, -20.0], "voxel_m": 2.0, "number_density_m3": 9.0,
              "law": { "monodisperse": { "radius_um": 100.0 } } },
            { "file": "drops.vdb" }])),
        with(&rain, "/sun", json!({ "body": "moon", "phase_angle_deg": 20.0,
            "elevation_deg": 20.0, "azimuth_deg": 0.0 })),
        with(&rain, "/sun", json!({ "date_time": "2026-06-21T18:30:00+02:00",
            "latitude_deg": 60.0, "longitude_deg": 11.0 })),
        with(&rain, "/camera", json!({ "position_m": [0.0, 1.6, 0.0], "azimuth_deg": 0.0,
            "elevation_deg": 10.0, "roll_deg": 1.0, "projection": "fisheye-equisolid", "overscan_px": 8,
            "focal_length_mm": 8.0, "sensor_width_mm": 36.0, "image_circle_deg": 100.0,
            "width_px": 64, "height_px": 48 })),
        with(&rain, "/air", json!({ "constituents": ["rayleigh", "aerosol", "ozone", "water-vapor"],
            "pressure_hpa": 900.0, "visibility_km": 20.0, "ozone_dobson": 350.0,
            "precipitable_water_cm": 2.0 })),
        with(&rain, "/occluders", json!({ "depth": "depth.exr", "meshes": [{ "file": "ship.stl",
            "scale": 2.0, "turn_deg": 30.0, "position_m": [0.0, 1.0, 2.0], "albedo": [0.1, 0.2, 0.3] }] })),
        with(&rain, "/terrain", json!({ "file": "a.png", "spacing_m": 30.0, "height_m": [0.0, 900.0],
            "position_m": [0.0, -9.0, 2.0], "albedo": 0.3 })),
        with(&rain, "/photo", json!({ "picture": "lake.jpg", "white_card": 0.8, "cloud_cover": 0.4 })),
        with(&rain, "/accuracy", json!({ "tolerance": 0.02, "table_relative_error": 0.01,
            "theory": { "level": "debye", "max_order": 3 },
            "integration": { "level": "fixed-step", "step_m": 2.0 },
            "drop_orders": { "level": "multiple-scattering", "nodes_across": 8, "paths_per_node": 64 },
            "sun_path": { "level": "march", "step_m": 2.0 },
            "air_path": { "level": "midpoint", "n_steps": 9 },
            "pixel_footprint": { "level": "grid", "n": 2 } })),
        with(&rain, "/accuracy", json!({
            "integration": { "level": "adaptive", "relative_error": 1e-3 },
            "sun_path": { "level": "volume", "voxel_m": 2.0 },
            "air_path": { "level": "quadrature", "n_nodes": 9 } })),
    ]);
    all.extend(
        [
            json!({ "water": { "temperature_c": 10.0 }, "ground": { "albedo": 0.3 },
            "picture": { "exposure_ev": 1.0 },
            "spectrum": { "first_nm": 400.0, "step_nm": 10.0, "n_wavelengths": 31 } }),
        ]
        .map(|sections| {
            let mut scene = rain.clone();
            scene
                .as_object_mut()
                .unwrap()
                .extend(sections.as_object().unwrap().clone());
            scene
        }),
    );
    all
}

/// Paths of all numbers; of a list the first alone, since all have one range.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Object(table) => {
            for (key, child) in table {
                numbers(child, &format!("{path}/{key}"), found);
            }
        }
        Value::Array(items) => {
            if let Some(child) = items.first() {
                numbers(child, &format!("{path}/0"), found);
            }
        }
        Value::Null | Value::Bool(_) | Value::String(_) => (),
    }
}

/// The bounds of every key, and what lies just beyond them.
fn bounds(schema: &Value, key: &str, found: &mut BTreeMap<String, BTreeSet<String>>) {
    match schema {
        Value::Object(object) => {
            for (keyword, child) in object {
                let is_bound = keyword.ends_with("inimum") || keyword.ends_with("aximum");
                if let Some(bound) = child.as_f64().filter(|_| is_bound) {
                    let step = 1e-7 + 1e-6 * bound.abs();
                    let probes = [bound - 1.0, bound - step, bound, bound + step, bound + 1.0];
                    let probes = probes.map(|number| format!("{number:?}"));
                    found.entry(key.to_owned()).or_default().extend(probes);
                } else if keyword == "properties" {
                    for (key, child) in child.as_object().into_iter().flatten() {
                        bounds(child, key, found);
                    }
                } else {
                    bounds(child, key, found);
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| bounds(item, key, found)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => (),
    }
}

/// What is tried at every number.
const PROBES: [&str; 3] = ["-1.0", "0.0", "1e9"];

/// The key that a path ends at, or in whose list it ends.
fn last_key(path: &str) -> &str {
    let is_key = |part: &&str| part.parse::<usize>().is_err();
    path.split('/').rfind(is_key).unwrap()
}

/// What is wrong with a scene in which another number stands at a path: the word of the schema where
/// it differs from that of the reader.
fn difference(schema: &Value, scene: &Value, (path, probe): (&str, &str)) -> Option<String> {
    let number: f64 = probe.parse().unwrap();
    let is_whole = scene.pointer(path).unwrap().is_i64();
    if is_whole && number.fract() != 0.0 {
        return None;
    }
    let value = if is_whole {
        json!(number as i64)
    } else {
        json!(number)
    };
    let probed = with(scene, path, value);
    match (first_fault(schema, &probed), read(&probed)) {
        (None, Ok(())) | (Some(_), Err(_)) => None,
        (Some(fault), Ok(())) => Some(format!("{path} = {probe}: only the schema: {fault}")),
        (None, Err(error)) => {
            let message = error.to_string();
            let is_left = LEFT_TO_THE_READER.iter().any(|part| message.contains(part));
            (!is_left).then(|| format!("{path} = {probe}: only the reader: {message}"))
        }
    }
}

/// Parts of the reader's words on what holds between keys, of which the schema knows nothing.
const LEFT_TO_THE_READER: [&str; 14] = [
    "nodes and need ",
    "no lattice fits the box",
    "is not above the lower end",
    "at most radius_m",
    "at most the width of the shaft",
    "`drops.top_y_m - base_y_m`",
    "`drops.nozzle_m[1] - basin_y_m`",
    "`drops.splash_fraction + mist_fraction`",
    "expected d_min_mm, or a spread above 3",
    "wavelength bins",
    "is seen in air without any aerosol",
    "at least the reflectance of the ice",
    "`camera.horizontal_fov_deg` is",
    "found a field of view",
];

#[test]
fn ranges_are_those_of_the_reader() {
    let (mut by_key, mut seen, mut differ) = (BTreeMap::new(), BTreeSet::new(), BTreeSet::new());
    let schemas = [scene_schema(), ice_scene_schema()];
    for schema in &schemas {
        bounds(schema, "", &mut by_key);
    }
    for scene in scenes_with_everything() {
        let is_ice = scene.get("ice").is_some();
        let schema = &schemas[usize::from(is_ice)];
        assert_eq!(first_fault(schema, &scene), None, "{scene}");
        read(&scene).unwrap_or_else(|error| panic!("{error}: {scene}"));
        let mut paths = Vec::new();
        numbers(&scene, "", &mut paths);
        // Keys of shapes mean something else in every shape, all others the same in every scene.
        let shape = scene["drops"]["shape"].to_string();
        let owner = |path: &str| path.starts_with("/drops/").then(|| shape.clone());
        paths.retain(|path| seen.insert((path.clone(), owner(path), is_ice)));
        for path in &paths {
            let own = by_key.get(last_key(path)).into_iter().flatten();
            let probes = own.map(String::as_str).chain(PROBES);
            differ.extend(probes.filter_map(|probe| difference(schema, &scene, (path, probe))));
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}
