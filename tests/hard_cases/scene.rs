//! Hard cases of scene files: numbers that are none, wrong bytes, nesting without end.

use niji_scene::Scene;

use crate::hard_case::HardCase;
use crate::hard_case::Random;
use crate::hard_case::violations;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "NaN and infinities in place of any number are refused",
        measure: "accepted scenes",
        allowed: 0.0,
        error: numbers_that_are_none,
    },
    HardCase {
        claim: "wrong bytes are an error or another scene that reads back as written",
        measure: "scenes of 3000 that do not",
        allowed: 0.0,
        error: wrong_bytes,
    },
    HardCase {
        claim: "brackets nested 100000 deep are an error, not the end of the stack",
        measure: "accepted texts",
        allowed: 0.0,
        error: nesting_without_end,
    },
];

const SCENE: &str = r#"format = 1
name = "hard"

[sun]
elevation_deg = 20.0
azimuth_deg = 180.0

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

[accuracy]
preset = "draft"
integration = { level = "adaptive", relative_error = 0.001 }
"#;

fn numbers_that_are_none() -> f64 {
    let numbers = SCENE.split([' ', '[', ']', ',', '\n']);
    let mut numbers: Vec<&str> = numbers.filter(|word| word.contains('.')).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let is_sound = Scene::from_toml(SCENE).is_ok();
    let scenes = numbers.into_iter().flat_map(|number| {
        ["nan", "inf", "-inf"]
            .map(|none| SCENE.replacen(&format!(" {number}"), &format!(" {none}"), 1))
    });
    let changed = scenes.filter(|text| text != SCENE);
    violations(changed.map(|text| Scene::from_toml(&text).is_err())) + violations([is_sound])
}

fn wrong_bytes() -> f64 {
    let mut random = Random(9);
    violations((0..3000).map(|_| {
        let mut bytes = SCENE.as_bytes().to_vec();
        for _ in 0..=random.below(4) {
            let place = random.below(bytes.len());
            bytes[place] = 32 + random.below(95) as u8;
        }
        let scene = Scene::from_toml(&String::from_utf8_lossy(&bytes));
        scene.map_or(true, |scene| {
            Scene::from_json(&scene.canonical_json()).is_ok_and(|again| again == scene)
        })
    }))
}

fn nesting_without_end() -> f64 {
    let brackets = "[".repeat(100_000);
    let dots = vec!["a"; 100_000].join(".");
    let texts = [
        format!("name = {brackets}"),
        format!("{SCENE}\n{brackets}"),
        format!("{dots} = 1"),
    ];
    let json = format!("{{\"name\": {brackets}");
    violations(texts.map(|text| Scene::from_toml(&text).is_err()))
        + violations([Scene::from_json(&json).is_err()])
}
