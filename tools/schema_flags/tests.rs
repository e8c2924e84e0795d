use clap::Command;
use niji_droplets::Shape;
use niji_sizes::SizeLaw;
use serde_json::json;

use super::field::Field;
use super::field::Kind;
use super::*;

/// The command of a shape.
fn command(name: &str) -> (Flags, Command) {
    let variant = variants::<Shape>()
        .into_iter()
        .find(|variant| variant.name == name)
        .unwrap();
    let command = Command::new(variant.name).no_binary_name(true);
    let command = command.args(variant.flags.arguments());
    (variant.flags, command)
}

fn given(name: &str, line: &str) -> Result<Value, String> {
    let (flags, command) = command(name);
    let matches = command.try_get_matches_from(line.split_whitespace());
    let matches = matches.map_err(|error| error.to_string())?;
    flags.value(&matches).map_err(|failure| failure.to_string())
}

const BOX: &str = "--box-min-m=-8,0,-8 --box-max-m 8,16,8 --voxel-m 1";

#[test]
fn every_shape_and_every_law_has_flags_that_clap_accepts() {
    let shapes = variants::<Shape>();
    assert!(shapes.len() >= 8);
    for shape in shapes {
        assert!(shape.flags.fields.len() > 3 && !shape.about.is_empty());
        // In debug and in tests this panics on two flags of one name.
        command(&shape.name).1.debug_assert();
    }
    let laws = variants::<SizeLaw>();
    assert!(laws.len() >= 12);
    let no_text = |field: &Field| !matches!(field.kind, Kind::Text) && !field.help.is_empty();
    for law in &laws {
        assert!(flagged(&law.flags.fields).all(no_text), "{}", law.name);
    }
    let json = serde_json::to_value(SizeLaw::Cloud(niji_sizes::Cloud {
        preset: niji_sizes::CloudPreset::Fog,
    }));
    assert_eq!(json.unwrap(), json!({ "cloud": { "preset": "fog" } }));
}

#[test]
fn flags_become_the_json_of_the_struct() {
    let found = given(
        "uniform",
        &format!("{BOX} --law monodisperse --radius-um 100 --number-density-m3 1000"),
    );
    assert_eq!(
        found.unwrap(),
        json!({
            "box_min_m": [-8.0, 0.0, -8.0],
            "box_max_m": [8.0, 16.0, 8.0],
            "voxel_m": 1.0,
            "law": { "monodisperse": { "radius_um": 100.0 } },
            "number_density_m3": 1000.0,
        })
    );
}

#[test]
fn a_struct_inside_has_flags_with_its_name_and_may_be_left_out() {
    let cell = "--max-rain-rate-mm-h 20 --radius-m 900 --center-xz-m 0,-5e3 --base-y-m 0 \
                --top-y-m 2000 --voxel-m 100";
    let calm = given("rain-cell", cell).unwrap();
    assert!(calm.get("turbulence").is_none() && calm["center_xz_m"][1] == -5000.0);
    let gusts = "--turbulence-strength 0.5 --turbulence-eddy-m 300 --turbulence-seed 7";
    let gusty = given("rain-cell", &format!("{cell} {gusts}")).unwrap();
    let expected = json!({ "strength": 0.5, "eddy_m": 300.0, "seed": 7 });
    assert_eq!(gusty["turbulence"], expected);
    let message = given("rain-cell", &format!("{cell} --turbulence-seed 7")).unwrap_err();
    assert!(message.contains("--turbulence-strength"), "{message}");
}

#[test]
fn a_flag_of_another_variant_is_refused_and_the_right_ones_are_listed() {
    let line = format!("{BOX} --law normal --radius-um 100");
    let message = given("uniform", &line).unwrap_err();
    for part in [
        "--radius-um",
        "--radius-mean-um",
        "--radius-standard-deviation-um",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let line = format!("{BOX} --law marshall-palmer --d-min-mm 0.5");
    let message = given("uniform", &line).unwrap_err();
    assert!(message.contains("expected --rain-rate-mm-h"), "{message}");
}

#[test]
fn what_is_no_number_is_refused_with_its_flag() {
    for (wrong, flag) in [
        (
            "--box-min-m=1,2 --box-max-m 1,2,3 --voxel-m 1",
            "--box-min-m",
        ),
        (
            "--box-min-m=1,2,3 --box-max-m 1,2,inf --voxel-m 1",
            "--box-max-m",
        ),
        (
            "--box-min-m=1,2,3 --box-max-m 1,2,3 --voxel-m one",
            "--voxel-m",
        ),
    ] {
        let message = given("uniform", &format!("{wrong} --law cloud --preset fog")).unwrap_err();
        assert!(message.contains(flag), "{message}");
    }
}

#[test]
fn messages_of_the_libraries_name_the_flag() {
    let (flags, _) = command("rain-cell");
    let named = |message| flags.name_flags(message);
    assert_eq!(
        named("eddy_m = -1, expected more"),
        "--turbulence-eddy-m = -1, expected more"
    );
    assert_eq!(named("voxel_m: too small"), "--voxel-m: too small");
    assert_eq!(
        named("found one, expected max_rain_rate_mm_h"),
        "found one, expected --max-rain-rate-mm-h"
    );
    assert_eq!(named("size law: a seed, bad"), "size law: a seed, bad");
}
