//! Frames of a scene, and what a sequence cannot be.

use super::*;

const SCENE: &str = r#"format = 1
name = "frames # are not here"
[sun]
elevation_deg = 20
azimuth_deg = 180.0
[camera]
position_m = [
  0.0, 1.6,
  0.0,
]
azimuth_deg = 0.0
[drops]
file = "spray.####.vdb"
[sequence]
sun.elevation_deg = [[10, 10.0], [20, 20.0], [30, 0]]
camera.position_m = [[1, [0.0, 1.6, 0.0]], [5, [4.0, 1.6, -8.0]]]
"#;

fn sequence(text: &str) -> Sequence {
    Sequence::from_toml(text).unwrap().unwrap()
}

fn frame(number: u32) -> toml::Table {
    sequence(SCENE).scene_text(number).parse().unwrap()
}

fn elevation_deg(number: u32) -> f64 {
    frame(number)["sun"]["elevation_deg"].as_float().unwrap()
}

#[test]
fn values_are_linear_between_keys_exact_at_them_and_stay_outside() {
    for (number, expected) in [
        (1, 10.0),
        (10, 10.0),
        (15, 15.0),
        (20, 20.0),
        (25, 10.0),
        (99, 0.0),
    ] {
        assert!((elevation_deg(number) - expected).abs() < 1e-12, "{number}");
    }
    // Stored values come back to the bit.
    assert_eq!(elevation_deg(20), 20.0);
    let position = frame(2)["camera"]["position_m"].clone();
    assert_eq!(
        position,
        toml::Value::Array(vec![1.0.into(), 1.6.into(), (-2.0).into()])
    );
}

/// The scene with a picture of whole pixels that widens.
fn widening(keys: &str) -> Sequence {
    let (scene, _) = SCENE.split_once("[sequence]").unwrap();
    let scene = scene.replace("[camera]", "[camera]\nwidth_px = 64");
    sequence(&format!("{scene}[sequence]\ncamera.width_px = {keys}\n"))
}

#[test]
fn between_whole_numbers_lie_whole_numbers() {
    let widths = widening("[[1, 1], [240, 240]]");
    for number in 1..=240 {
        let table: toml::Table = widths.scene_text(number).parse().unwrap();
        let expected = toml::Value::Integer(number.into());
        assert_eq!(table["camera"]["width_px"], expected, "{number}");
    }
    // Where none lies between them, and where one is written with a point, it is a number as before.
    let halves = widening("[[1, 64], [3, 65]]");
    assert!(halves.scene_text(2).contains("width_px = 64.5\n"));
    let real = widening("[[1, 64], [3, 66.0]]");
    assert!(real.scene_text(2).contains("width_px = 65.0\n"));
    let extremes = widening("[[0, -9223372036854775808], [2, 9223372036854775806]]");
    assert!(extremes.scene_text(1).contains("width_px = -1\n"));
}

#[test]
fn what_does_not_change_and_every_line_stays() {
    let text = sequence(SCENE).scene_text(15);
    assert_eq!(text.lines().count(), SCENE.lines().count());
    for (number, (before, after)) in SCENE.lines().zip(text.lines()).enumerate() {
        let changes = [3, 6, 7, 8, 9, 12].contains(&number);
        assert!(changes || before == after, "line {}: {after}", number + 1);
    }
    assert!(text.contains("name = \"frames # are not here\""));
}

#[test]
fn digits_of_the_frame_stand_in_names_of_files() {
    assert_eq!(frame(7)["drops"]["file"].as_str(), Some("spray.0007.vdb"));
    assert_eq!(
        frame(12345)["drops"]["file"].as_str(),
        Some("spray.12345.vdb")
    );
    assert_eq!(with_frame("a#/b.##.vdb", 3), "a3/b.03.vdb");
}

#[test]
fn tables_of_a_list_are_meant_by_their_name_or_place() {
    let scene = "format = 1\n[[drops]]\nvoxel_m = 1.0\n[[drops]]\nname = \"fine\"\nvoxel_m = 2.0\n\
                 file = \"a.##.vdb\"\n[sequence]\n";
    let keys = "drops.0.voxel_m = [[1, 4.0]]\ndrops.fine.voxel_m = [[1, 5.0], [3, 7.0]]\n";
    let frame = sequence(&format!("{scene}{keys}")).scene_text(2);
    let expected = "[[drops]]\nvoxel_m = 4.0\n[[drops]]\nname = \"fine\"\nvoxel_m = 6.0\n\
                    file = \"a.02.vdb\"\n";
    assert!(frame.contains(expected), "{frame}");
    // One key for one number.
    let twice = Sequence::from_toml(&format!("{scene}drops.1.voxel_m = [[1, 4.0]]"));
    let message = twice.unwrap_err().to_string();
    assert!(message.contains("drops.fine.voxel_m"), "{message}");
}

#[test]
fn a_scene_in_which_nothing_changes_is_no_sequence() {
    let (scene, _) = SCENE.split_once("[sequence]").unwrap();
    let still = scene.replace('#', "0");
    assert_eq!(Sequence::from_toml(&still), Ok(None));
    let empty = still + "[sequence]\n";
    assert_eq!(Sequence::from_toml(&empty), Ok(None));
}

fn refusal(line: &str) -> String {
    let (scene, _) = SCENE.split_once("[sequence]").unwrap();
    let text = format!("{scene}[sequence]\n{line}\n");
    Sequence::from_toml(&text).unwrap_err().to_string()
}

#[test]
fn a_key_that_the_scene_does_not_have_gets_a_suggestion() {
    let message = refusal("sun.elevaton_deg = [[1, 2.0]]");
    let expected =
        "line 14: unknown key `sun.elevaton_deg` in [sequence], did you mean `sun.elevation_deg`?";
    assert!(message.starts_with(expected), "{message}");
    // The format is the scene's, not a frame's.
    let message = refusal("format = [[1, 1]]");
    assert!(message.contains("unknown key `format`"), "{message}");
    let (_, allowed) = message.split_once("allowed here: ").unwrap();
    assert!(!allowed.contains("format"), "{message}");
    // Of a text nothing lies between.
    assert!(refusal("drops.file = [[1, 2.0]]").contains("unknown key `drops.file`"));
}

#[test]
fn values_that_are_no_keys_of_the_same_form_are_refused() {
    for line in [
        "sun.elevation_deg = 10.0",
        "sun.elevation_deg = []",
        "sun.elevation_deg = [10.0, 20.0]",
        "sun.elevation_deg = [[1.5, 10.0]]",
        "sun.elevation_deg = [[-1, 10.0]]",
        "sun.elevation_deg = [[1, 10.0, 20.0]]",
        "sun.elevation_deg = [[1, \"high\"]]",
        "sun.elevation_deg = [[1, nan]]",
        "sun.elevation_deg = [[1, [10.0]]]",
        "camera.position_m = [[1, [0.0, 1.6]]]",
        "camera.position_m = [[1, 2.0]]",
    ] {
        let message = refusal(line);
        assert!(
            message.contains("pairs of a frame and a value"),
            "{line}: {message}"
        );
    }
    let message = refusal("sun.elevation_deg = [[3, 10.0], [3, 20.0]]");
    assert!(message.contains("frames in ascending order"), "{message}");
    assert!(refusal("sun.elevation_deg = [[3, 10.0]] x").starts_with("line 15"));
}

#[test]
fn a_rate_is_no_key_of_the_scene_and_films_have_24() {
    assert_eq!(sequence(SCENE).frames_per_second, 24.0);
    let with = |rate: &str| {
        let rate = format!("[sequence]\nframes_per_second = {rate}");
        Sequence::from_toml(&SCENE.replace("[sequence]", &rate))
    };
    for (rate, expected) in [("25", 25.0), ("23.976", 23.976)] {
        let sequence = with(rate).unwrap().unwrap();
        assert_eq!(sequence.frames_per_second, expected);
        assert!(sequence.scene_text(15).contains("elevation_deg = 15.0"));
    }
    for rate in ["0", "-24", "nan", "\"24\"", "[[1, 24]]"] {
        let refused = with(rate).unwrap_err().to_string();
        assert!(refused.contains("sequence.frames_per_second"), "{refused}");
    }
}

#[test]
fn frames_with_written_values_and_numbered_files_are_told() {
    let sequence = sequence(SCENE);
    assert!(sequence.keys().into_iter().eq([1, 5, 10, 20, 30]));
    assert!(sequence.file_names().eq(["spray.####.vdb"]));
    assert_eq!(with_frame("a.##/b.####.vdb", 7), "a.07/b.0007.vdb");
    // Comments change nothing.
    let commented = SCENE.replace("[sun]", "# the light\n[sun]");
    let again = Sequence::from_toml(&commented).unwrap().unwrap();
    assert_eq!(again.settings(), sequence.settings());
}

#[test]
fn within_a_frame_values_go_on_and_counts_and_grids_stay() {
    let scene = "[sun]\nelevation_deg = 20\n[camera]\nwidth_px = 64\n[drops]\nvoxel_m = 4.0\nfile = \"a.##.vdb\"\n\
                 [spectrum]\nstep_nm = 10.0\n[sequence]\nshutter_deg = 180\n";
    let keys = "sun.elevation_deg = [[1, 10], [3, 12], [5, 8]]\ncamera.width_px = [[1, 64], [5, 68]]\n\
                drops.voxel_m = [[1, 4.0], [5, 8.0]]\nspectrum.step_nm = [[1, 10.0], [5, 14.0]]\n";
    let sequence = sequence(&format!("{scene}{keys}"));
    assert_eq!(sequence.shutter.ends(), [-0.25, 0.25]);
    let at = |after: f64| -> toml::Table { sequence.scene_text_beside(3, after).parse().unwrap() };
    for (after, elevation_deg) in [(-0.25, 11.75), (0.0, 12.0), (0.25, 11.5)] {
        let scene = at(after);
        let found = &scene["sun"]["elevation_deg"];
        let found = found.as_float().or(found.as_integer().map(|it| it as f64));
        assert_eq!(found, Some(elevation_deg), "{after}");
        let still = [
            ("camera", "width_px"),
            ("drops", "voxel_m"),
            ("drops", "file"),
            ("spectrum", "step_nm"),
        ];
        for (section, key) in still {
            assert_eq!(scene[section][key], at(0.0)[section][key], "{after} {key}");
        }
    }
    // Beyond the keys nothing moves, and a shutter alone makes no sequence.
    assert_eq!(sequence.scene_text_beside(5, 0.2), sequence.scene_text(5));
    assert_eq!(sequence.scene_text_beside(1, -0.2), sequence.scene_text(1));
    let none = scene.replace("##", "01");
    assert_eq!(Sequence::from_toml(&none), Ok(None));
    let wide = Sequence::from_toml(&format!("{}{keys}", scene.replace("180", "361")));
    let message = wide.unwrap_err().to_string();
    assert!(
        message.contains("sequence.shutter_deg") && message.contains("0 to 360"),
        "{message}"
    );
}

#[test]
fn of_an_odd_number_of_instants_the_frame_is_one_and_they_lie_evenly_about_it() {
    let shutter = Shutter { angle_deg: 180.0 };
    for n_instants in [3, 5, 9, 17, 33, 65] {
        let instants = shutter.instants(n_instants);
        assert_eq!(instants[n_instants as usize / 2], 0.0);
        assert!(
            instants
                .iter()
                .zip(instants.iter().rev())
                .all(|(a, b)| *a == -b)
        );
        let first = -0.25 + 0.25 / f64::from(n_instants);
        assert!((instants[0] - first).abs() < 1e-15);
    }
}
