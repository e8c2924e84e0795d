//! A scene file says what it means, or is refused with the line and what would be right.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use niji_droplets::Shape;
use niji_radiometry::GroundCover;
use niji_radiometry::Reflectance;
use niji_scene::Albedo;
use niji_scene::Effect;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::Switch;
use niji_scene::plan;

const SCENE: &str = r#"format = 1
name = "test"

[sun]
elevation_deg = 20.0
azimuth_deg = 180

[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 90.0
width_px = 64
height_px = 48

[drops]
shape = "gradient"
box_min_m = [-200.0, 0.0, -300.0]
box_max_m = [200.0, 150.0, -100.0]
voxel_m = 10.0
axis = "y"
radius_at_min_um = 1500.0
radius_at_max_um = 10.0
number_density_at_min_m3 = 1000.0
number_density_at_max_m3 = 1000.0

[air]
constituents = ["rayleigh"]

[effects]
drop_shadow = "off"

[accuracy]
preset = "draft"
theory = "airy"
integration = { level = "adaptive", relative_error = 1e-3 }

[accuracy.sun_path]
level = "march"
step_m = 5.0
"#;

fn refused(right: &str, wrong: &str) -> SceneError {
    assert!(SCENE.contains(right), "{right}");
    Scene::from_toml(&SCENE.replacen(right, wrong, 1)).unwrap_err()
}

/// Line of the first occurrence of `text` in the scene.
fn line_of(text: &str) -> usize {
    SCENE.lines().position(|line| line.contains(text)).unwrap() + 1
}

#[test]
fn a_sound_scene_is_read_as_written() {
    let scene = Scene::from_toml(SCENE).unwrap();
    assert_eq!((scene.sun.azimuth_deg, scene.camera.height_px), (180.0, 48));
    assert!(
        matches!(scene.drops.shape(), Some(Shape::Gradient(gradient)) if gradient.radius_at_max_um == 10.0)
    );
    assert_eq!(scene.accuracy.preset, Preset::Draft);
    assert_eq!(scene.effects.of(Effect::DropShadow), Switch::Off);
    assert_eq!(scene.effects.of(Effect::SunDisc), Switch::Auto);
    let named = scene.levels(10.0).named();
    let level = |key: &str| {
        named
            .iter()
            .find(|(name, _)| name == key)
            .unwrap()
            .1
            .clone()
    };
    assert_eq!(level("integration"), "adaptive relative_error=0.001");
    assert_eq!(level("sun_path"), "march step_m=5.0");
    assert_eq!(level("air_path"), "table");
}

#[test]
fn a_misspelt_key_gets_its_line_and_a_suggestion_at_every_depth() {
    let cases = [
        // Depth 1: a section, and a key of the top level.
        ("[camera]", "[camra]", "the top level", "camera"),
        ("name = ", "nam = ", "the top level", "name"),
        // Depth 2: a key of a section, of a shape, and an effect.
        ("width_px", "widht_px", "[camera]", "width_px"),
        (
            "radius_at_max_um",
            "radius_at_max_mm",
            "[drops]",
            "radius_at_max_um",
        ),
        ("drop_shadow", "drop_shadows", "[effects]", "drop_shadow"),
        // Depth 3: settings of a level, inline and as a section of their own.
        (
            "relative_error",
            "relativ_error",
            "[accuracy.integration]",
            "relative_error",
        ),
        ("step_m", "steps_m", "[accuracy.sun_path]", "step_m"),
        (
            "level = \"march\"",
            "levle = \"march\"",
            "[accuracy.sun_path]",
            "level",
        ),
    ];
    for (right, wrong, where_it_is, expected) in cases {
        let error = refused(right, wrong);
        let SceneError::UnknownKey {
            line,
            section,
            key,
            suggestion,
            allowed,
        } = &error
        else {
            panic!("{right}: {error}");
        };
        assert_eq!(*line, line_of(right), "{error}");
        assert_eq!(
            (section.as_str(), suggestion.as_deref()),
            (where_it_is, Some(expected))
        );
        assert!(wrong.contains(key.as_str()) && allowed.iter().any(|name| name == expected));
        let text = error.to_string();
        assert!(
            text.contains(&format!("did you mean `{expected}`?")),
            "{text}"
        );
    }
}

#[test]
fn a_key_that_belongs_to_another_shape_is_unknown() {
    let error = refused("axis = \"y\"", "rain_rate_mm_h = 5.0");
    let SceneError::UnknownKey { line, allowed, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(*line, line_of("axis"));
    assert!(allowed.contains(&"axis".to_string()) && allowed.contains(&"shape".to_string()));
}

#[test]
fn keys_that_look_like_nothing_get_no_suggestion() {
    let error = refused("azimuth_deg = 180", "xyz = 180");
    assert!(
        matches!(
            error,
            SceneError::UnknownKey {
                suggestion: None,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn an_unknown_name_gets_its_line_a_suggestion_and_the_choices() {
    for (right, wrong, path, expected) in [
        ("\"gradient\"", "\"gradiant\"", "drops.shape", "gradient"),
        ("\"draft\"", "\"darft\"", "accuracy.preset", "draft"),
        ("\"off\"", "\"of\"", "effects.drop_shadow", "off"),
        (
            "\"adaptive\"",
            "\"adaptiv\"",
            "accuracy.integration.level",
            "adaptive",
        ),
        ("\"airy\"", "\"ary\"", "accuracy.theory", "airy"),
        (
            "[\"rayleigh\"]",
            "[\"raleigh\"]",
            "air.constituents[0]",
            "rayleigh",
        ),
        ("axis = \"y\"", "axis = \"yy\"", "drops.axis", "y"),
    ] {
        let error = refused(right, wrong);
        let SceneError::UnknownName {
            line,
            key,
            suggestion,
            allowed,
            ..
        } = &error
        else {
            panic!("{right}: {error}");
        };
        assert_eq!((*line, key.as_str()), (line_of(right), path));
        assert_eq!(suggestion.as_deref(), Some(expected), "{error}");
        assert!(allowed.contains(&expected.to_string()));
    }
}

#[test]
fn a_wrong_type_says_what_was_found_and_what_was_expected() {
    for (right, wrong, found, expected) in [
        (
            "elevation_deg = 20.0",
            "elevation_deg = \"high\"",
            "string \"high\"",
            "a number",
        ),
        (
            "width_px = 64",
            "width_px = 64.5",
            "floating point `64.5`",
            "a whole number from 0 up",
        ),
        (
            "position_m = [0.0, 1.6, 0.0]",
            "position_m = [0.0, 1.6]",
            "length 2",
            "length 3",
        ),
        (
            "name = \"test\"",
            "name = 7",
            "integer `7`",
            "a text in quotes",
        ),
        ("theory = \"airy\"", "theory = 3", "integer 3", "one of"),
        (
            "voxel_m = 10.0",
            "voxel_m = 2026-01-01",
            "the date",
            "no date",
        ),
        (
            "integration = { level = \"adaptive\", relative_error = 1e-3 }",
            "integration = \"adaptive\"",
            "bare name",
            "level = \"adaptive\", relative_error = …",
        ),
    ] {
        let error = refused(right, wrong);
        let SceneError::WrongType {
            line,
            found: what,
            expected: wanted,
            ..
        } = &error
        else {
            panic!("{right}: {error}");
        };
        let is_text = |text: &str, part: &str| text.contains(part);
        assert_eq!(*line, line_of(right), "{error}");
        assert!(
            is_text(what, found) || is_text(what, &found.replace('`', "")),
            "{error}"
        );
        assert!(wanted.contains(expected), "{error}");
    }
}

#[test]
fn values_out_of_range_are_refused_at_their_line() {
    for (right, wrong) in [
        ("elevation_deg = 20.0", "elevation_deg = 91.0"),
        ("elevation_deg = 20.0", "elevation_deg = nan"),
        ("elevation_deg = 20.0", "elevation_deg = inf"),
        ("width_px = 64", "width_px = 0"),
        ("width_px = 64", "width_px = -64"),
        ("horizontal_fov_deg = 90.0", "horizontal_fov_deg = 180.0"),
        ("step_m = 5.0", "step_m = 0.0"),
        ("relative_error = 1e-3", "relative_error = -1.0"),
        ("format = 1", "format = 2"),
        ("radius_at_max_um = 10.0", "radius_at_max_um = -10.0"),
        (
            "number_density_at_min_m3 = 1000.0",
            "number_density_at_min_m3 = -1.0",
        ),
        ("[\"rayleigh\"]", "[]"),
        ("[\"rayleigh\"]", "[\"rayleigh\", \"rayleigh\"]"),
    ] {
        let error = refused(right, wrong);
        let in_range_of = matches!(error, SceneError::OutOfRange { .. });
        assert!(in_range_of, "{wrong}: {error:?}");
        let section = ["radius_at_max", "width"]
            .iter()
            .any(|part| right.contains(part));
        if !section {
            assert_eq!(error.line(), Some(line_of(right)), "{wrong}: {error}");
        }
    }
    let error = refused(
        "box_max_m = [200.0, 150.0, -100.0]",
        "box_max_m = [200.0, -1.0, -100.0]",
    );
    assert!(
        matches!(error, SceneError::Drops { line, .. } if line == line_of("[drops]")),
        "{error}"
    );
}

#[test]
fn missing_keys_are_named_with_their_section() {
    for (line, section, key) in [
        ("azimuth_deg = 180\n", "[sun]", "azimuth_deg"),
        ("shape = \"gradient\"\n", "[drops]", "shape"),
        ("voxel_m = 10.0\n", "[drops]", "voxel_m"),
        ("name = \"test\"\n", "the top level", "name"),
        (
            "level = \"march\"\nstep_m = 5.0\n",
            "[accuracy.sun_path]",
            "level",
        ),
    ] {
        let error = refused(line, "");
        let SceneError::MissingKey {
            section: found,
            key: missing,
            line,
            ..
        } = &error
        else {
            panic!("{key}: {error}");
        };
        assert_eq!((found.as_str(), missing.as_str()), (section, key));
        if section != "the top level" {
            assert!(
                (*line as i64 - line_of(section) as i64).abs() <= 1,
                "{error}"
            );
        }
    }
}

/// The scene with other drops.
fn with_drops(text: &str) -> Result<Scene, String> {
    let start = SCENE.find("[drops]").unwrap();
    let end = SCENE[start..]
        .find("\n[")
        .map_or(SCENE.len(), |at| start + at + 1);
    let scene = SCENE.replace(&SCENE[start..end], &format!("[drops]\n{text}\n"));
    Scene::from_toml(&scene).map_err(|error| error.to_string())
}

#[test]
fn all_keys_that_a_table_lacks_are_named_at_once() {
    for (drops, lacking) in [
        (
            "shape = \"rain-shaft\"\nrain_rate_mm_h = 5.0",
            "[drops] lacks `footprint`, `center_xz_m`, `base_y_m`, `top_y_m` and `voxel_m`",
        ),
        (
            "shape = \"rain-shaft\"\nbase_y_m = 0.0\ncenter_xz_m = [0.0, 0.0]\nfootprint = { column = { radius_m = 9.0 } }",
            "[drops] lacks `top_y_m` and `voxel_m`",
        ),
        // Inside of another first.
        (
            "shape = \"rain-shaft\"\nfootprint = { column = {} }",
            "[drops.footprint.column] lacks `radius_m`",
        ),
    ] {
        let error = with_drops(drops).unwrap_err();
        assert!(error.ends_with(lacking), "{error}");
    }
    // What is wrong comes before what is missing.
    let error = with_drops("shape = \"rain-shaft\"\nvoxel_m = true").unwrap_err();
    assert!(error.contains("`drops.voxel_m` is boolean"), "{error}");
    let nameless = SCENE
        .replace("name = \"test\"\n", "")
        .replace("format = 1\n", "");
    let error = Scene::from_toml(&nameless).unwrap_err().to_string();
    assert!(
        error.ends_with("the top level lacks `format` and `name`"),
        "{error}"
    );
}

#[test]
fn drops_need_a_shape_or_a_file() {
    with_drops("file = \"mist.vdb\"").unwrap();
    let line = line_of("[drops]") + 1;
    for (misspelt, key) in [("fil", "file"), ("filename", "file"), ("shap", "shape")] {
        let expected = format!(
            "line {line}: unknown key `{misspelt}` in [drops], did you mean `{key}`?; allowed here: shape, file"
        );
        assert_eq!(
            with_drops(&format!("{misspelt} = \"mist.vdb\"")),
            Err(expected)
        );
    }
    for other in ["vdb = \"mist.vdb\"", "profile = \"jet\""] {
        let error = with_drops(other).unwrap_err();
        assert!(
            error.ends_with("[drops] lacks `shape` or `file`"),
            "{error}"
        );
    }
}

#[test]
fn a_spectrum_needs_light_that_is_seen() {
    let spectrum = |first_nm: f64| {
        let start = SCENE.find("[drops]").unwrap();
        let (head, rest) = SCENE.split_at(start);
        let section =
            format!("[spectrum]\nfirst_nm = {first_nm}\nstep_nm = 10.0\nn_wavelengths = 3\n");
        Scene::from_toml(&format!("{head}{section}{rest}"))
    };
    // Of the last bin below, and of the first above, the eye sees 5 nm.
    for first_nm in [340.0, 550.0, 830.0] {
        spectrum(first_nm).unwrap();
    }
    for first_nm in [310.0, 900.0] {
        let error = spectrum(first_nm).unwrap_err();
        assert_eq!(error.line(), Some(line_of("[drops]")));
        let message = error.to_string();
        assert!(
            message.contains("`spectrum` is")
                && message.contains("the eye sees some, of 360 to 830 nm"),
            "{message}"
        );
    }
}

#[test]
fn a_scene_that_was_changed_in_code_is_checked() {
    let scene = Scene::from_toml(SCENE).unwrap();
    scene.check().unwrap();
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        let error = scene.check().unwrap_err();
        assert_eq!(error.line(), None);
        let planned = plan(&scene, None).unwrap_err();
        assert_eq!(planned.to_string(), error.to_string());
        error.to_string()
    };
    for (tolerance, found) in [(f64::NAN, "NaN"), (-1.0, "-1"), (0.0, "0")] {
        assert_eq!(
            refused(&|scene| scene.accuracy.tolerance = Some(tolerance)),
            format!("`accuracy.tolerance` is {found}, expected 0.000001 to 1")
        );
    }
    for temperature_c in [500.0, f64::NAN] {
        let error = refused(&|scene| scene.water.temperature_c = temperature_c);
        assert!(error.starts_with("`water` cannot be used: "), "{error}");
    }
    let error = refused(&|scene| scene.sun.elevation_deg = f64::INFINITY);
    assert_eq!(error, "`sun.elevation_deg` is inf, expected -90 to 90");
}

#[test]
fn air_effects_need_air() {
    let vacuum = SCENE.replace("[air]\nconstituents = [\"rayleigh\"]\n", "");
    Scene::from_toml(&vacuum).unwrap();
    let error =
        Scene::from_toml(&vacuum.replace("drop_shadow = \"off\"", "sky = \"on\"")).unwrap_err();
    assert!(error.to_string().contains("effects.sky"), "{error}");
}

#[test]
fn air_has_settings_for_its_constituents_and_for_no_other() {
    let hazy = SCENE.replace(
        "constituents = [\"rayleigh\"]",
        "constituents = [\"rayleigh\", \"aerosol\", \"ozone\"]\npressure_hpa = 900\n\
         aerosol = \"rural\"\nvisibility_km = 20\nozone_dobson = 350",
    );
    let scene = Scene::from_toml(&hazy).unwrap();
    let model = scene
        .air
        .unwrap()
        .model(scene.spectrum, Reflectance::Even(0.2), &scene.sun)
        .unwrap();
    assert_eq!(model.tabulate().unwrap().constituents.len(), 3);
    for (right, wrong) in [
        ("\"aerosol\", ", ""),
        ("visibility_km = 20", "visibility_km = 0.0"),
        // Clearer than air without any haze.
        ("visibility_km = 20", "visibility_km = 345"),
        ("pressure_hpa = 900", "pressure_hpa = -1"),
    ] {
        let error = Scene::from_toml(&hazy.replace(right, wrong)).unwrap_err();
        assert!(error.to_string().contains("`air"), "{wrong}: {error}");
    }
    let error = Scene::from_toml(&hazy.replace("\"rural\"", "\"urbane\"")).unwrap_err();
    assert!(
        error.to_string().contains("did you mean `urban`?"),
        "{error}"
    );
}

#[test]
fn text_that_is_not_toml_is_refused_with_its_line() {
    let error = refused("width_px = 64", "width_px = ");
    assert!(
        matches!(error, SceneError::Syntax { line, .. } if line == line_of("width_px")),
        "{error}"
    );
    let twice = refused("name = \"test\"", "name = \"test\"\nname = \"again\"");
    assert!(
        matches!(twice, SceneError::Syntax { line: 3, .. }),
        "{twice}"
    );
    assert!(Scene::from_toml("").is_err() && Scene::from_toml("\u{feff}[").is_err());
}

#[test]
fn drops_come_from_a_file_as_well() {
    let start = SCENE.find("shape = ").unwrap();
    let end = SCENE.find("[air]").unwrap();
    let scene = format!(
        "{}file = \"drops.vdb\"\n\n{}",
        &SCENE[..start],
        &SCENE[end..]
    );
    assert_eq!(
        Scene::from_toml(&scene).unwrap().drops.file(),
        Some("drops.vdb")
    );
    let error = Scene::from_toml(&scene.replace("file = ", "voxel_m = 1.0\nfile = ")).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("unknown key `voxel_m` in [drops]"),
        "{error}"
    );
    let error = Scene::from_toml(&scene.replace("file = ", "fiel = ")).unwrap_err();
    assert!(
        error.line() == Some(line_of("shape = ")) || error.to_string().contains("shape"),
        "{error}"
    );
}

#[test]
fn json_reads_back_as_the_same_scene() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let json = scene.canonical_json();
    assert_eq!(Scene::from_json(&json).unwrap(), scene);
    assert_eq!(Scene::from_json(&json).unwrap().canonical_json(), json);
    assert!(Scene::from_json(&json.replace("\"albedo\":0.2", "\"albedo\":2.0")).is_err());
    assert!(Scene::from_json("{}").is_err());
}

#[test]
fn a_ground_that_was_measured_is_written_by_its_name() {
    for cover in GroundCover::ALL {
        let ground = format!("[ground]\nalbedo = \"{}\"\n", cover.name());
        let scene = Scene::from_toml(&format!("{SCENE}{ground}")).unwrap();
        assert_eq!(scene.ground.albedo, Albedo::Measured(cover));
        let json = scene.canonical_json();
        assert!(json.contains(&format!("\"albedo\":\"{}\"", cover.name())));
        assert_eq!(Scene::from_json(&json).unwrap(), scene);
    }
    let error = Scene::from_toml(&format!("{SCENE}[ground]\nalbedo = \"gras\"\n")).unwrap_err();
    let SceneError::UnknownName {
        key, suggestion, ..
    } = &error
    else {
        panic!("{error}")
    };
    assert_eq!(
        (key.as_str(), suggestion.as_deref()),
        ("ground.albedo", Some("grass"))
    );
}

#[test]
fn canonical_json_does_not_depend_on_the_order_of_keys_or_on_what_is_left_out() {
    let json = Scene::from_toml(SCENE).unwrap().canonical_json();
    let reordered = SCENE
        .replace(
            "elevation_deg = 20.0\nazimuth_deg = 180",
            "azimuth_deg = 180.0\nelevation_deg = 2e1",
        )
        .replace("name = \"test\"", "description = \"\"\nname = \"test\"")
        .replace(
            "drop_shadow = \"off\"",
            "sun_disc = \"auto\"\ndrop_shadow = \"off\"",
        );
    assert_ne!(reordered, SCENE);
    assert_eq!(Scene::from_toml(&reordered).unwrap().canonical_json(), json);
    let with_defaults = format!(
        "{SCENE}\n[spectrum]\nfirst_nm = 380\nstep_nm = 10\nn_wavelengths = 41\n\n[ground]\nalbedo = 0.2\n"
    );
    assert_eq!(
        Scene::from_toml(&with_defaults).unwrap().canonical_json(),
        json
    );
}
