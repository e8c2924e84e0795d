//! Several populations of drops in one scene: how they are read, refused and planned.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use niji_dropfield::DropVolume;
use niji_droplets::Shape;
use niji_scene::DropSource;
use niji_scene::DropSummary;
use niji_scene::Effect;
use niji_scene::PlanError;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::Stage;
use niji_scene::Switch;
use niji_scene::plan;

use support::planned;

const HEAD: &str = r#"format = 1
name = "two"

[sun]
elevation_deg = 20.0
azimuth_deg = 180.0

[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 12.0
horizontal_fov_deg = 90.0
width_px = 64
height_px = 48

"#;

const FINE: &str = r#"[[drops]]
name = "fine"
shape = "uniform"
box_min_m = [-200.0, 0.0, -400.0]
box_max_m = [200.0, 300.0, -200.0]
voxel_m = 20.0
law = { hansen-travis = { effective_radius_um = 200.0, effective_variance = 0.02 } }
number_density_m3 = 100.0

"#;

const COARSE: &str = r#"[[drops]]
shape = "uniform"
box_min_m = [-200.0, 0.0, -300.0]
box_max_m = [200.0, 200.0, -100.0]
voxel_m = 10.0
law = { hansen-travis = { effective_radius_um = 500.0, effective_variance = 0.005 } }
number_density_m3 = 20.0

"#;

fn two() -> String {
    [HEAD, FINE, COARSE].concat()
}

fn refused(right: &str, wrong: &str) -> SceneError {
    let text = two();
    assert!(text.contains(right), "{right}");
    Scene::from_toml(&text.replace(right, wrong)).unwrap_err()
}

fn line_of(text: &str) -> usize {
    two().lines().position(|line| line.contains(text)).unwrap() + 1
}

fn summary(scene: &Scene) -> DropSummary {
    DropSummary::of_shapes(&scene.drops).unwrap()
}

#[test]
fn a_list_of_drops_is_read_in_its_order_and_written_back() {
    let scene = Scene::from_toml(&two()).unwrap();
    assert_eq!(scene.drops.mode_names(), ["fine", "uniform_1"]);
    assert_eq!((scene.drops.shape(), scene.drops.file()), (None, None));
    assert_eq!(Scene::from_json(&scene.canonical_json()).unwrap(), scene);
    // A list of one is the table itself.
    let one = [HEAD, COARSE].concat();
    let scene = Scene::from_toml(&one).unwrap();
    let table = Scene::from_toml(&one.replace("[[drops]]", "[drops]")).unwrap();
    assert_eq!(scene.canonical_json(), table.canonical_json());
    assert!(matches!(table.drops.shape(), Some(Shape::Uniform(_))));
    assert_eq!(table.drops.mode_names(), [""]);
}

#[test]
fn what_is_wrong_is_told_with_its_entry_and_line() {
    for (right, wrong, expected) in [
        (
            "voxel_m = 10.0",
            "voxel_m = true",
            "`drops[1].voxel_m` is boolean",
        ),
        (
            "voxel_m = 10.0",
            "voxel = 1.0",
            "unknown key `voxel` in drops[1], did you mean `voxel_m`",
        ),
        (
            "number_density_m3 = 20.0",
            "number_density_m3 = -2.0",
            "`drops[1].number_density_m3` is -2",
        ),
        ("name = \"fine\"", "name = 3", "`drops[0].name` is integer"),
        (
            "name = \"fine\"",
            "name = \"two words\"",
            "`drops[0].name` is \"two words\", expected a letter",
        ),
        (
            "name = \"fine\"",
            "name = \"uniform_1\"",
            "`drops[1].name` is \"uniform_1\", expected another",
        ),
        (
            "name = \"fine\"",
            "source = \"fine\"",
            "unknown key `source` in drops[0]",
        ),
        (
            "name = \"fine\"",
            "nmae = \"fine\"",
            "in drops[0], did you mean `name`?; allowed here: shape, name, ",
        ),
        (
            "effective_radius_um = 500.0",
            "effective_radius_um = -5.0",
            "`drops[1].law.hansen-travis.effective_radius_um` is -5",
        ),
        (
            "box_max_m = [200.0, 200.0, -100.0]",
            "box_max_m = [200.0, -2.0, -100.0]",
            "drops[1]: drop volume: no lattice",
        ),
    ] {
        let error = refused(right, wrong);
        let message = error.to_string();
        assert!(message.contains(expected), "{wrong}: {message}");
        let whole_entry = matches!(error, SceneError::Drops { .. }) || wrong.contains("uniform_1");
        let expected = if whole_entry {
            line_of("number_density_m3 = 100.0") + 2
        } else {
            line_of(right)
        };
        assert_eq!(error.line(), Some(expected), "{message}");
    }
    let error = refused(
        "[[drops]]\nname = \"fine\"\nshape = \"uniform\"\n",
        "[[drops]]\n",
    );
    assert!(
        error.to_string().contains("drops[0] lacks `shape`"),
        "{error}"
    );
    let of_nothing = HEAD.replacen("name", "drops = []\nname", 1);
    let error = Scene::from_toml(&of_nothing).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`drops` is an array of length 0"),
        "{error}"
    );
}

#[test]
fn figures_of_several_cover_each_of_them() {
    let scene = Scene::from_toml(&two()).unwrap();
    let whole = summary(&scene);
    let shapes = scene
        .drops
        .populations()
        .iter()
        .map(|it| it.source.shape().unwrap());
    let each: Vec<DropSummary> = shapes
        .map(|it| DropSummary::of_shape(&it).unwrap())
        .collect();
    for one in &each {
        assert!(whole.bounds().contains(one.min_m) && whole.bounds().contains(one.max_m));
        assert!(whole.effective_radius_um.0 <= one.effective_radius_um.0);
        assert!(whole.effective_radius_um.1 >= one.effective_radius_um.1);
        assert!(whole.effective_variance.0 <= one.effective_variance.0);
        assert!(whole.effective_variance.1 >= one.effective_variance.1);
    }
    assert_eq!(whole.n_nodes, each[0].n_nodes + each[1].n_nodes);
    assert_eq!(whole.voxel_m, 10.0);
    // They overlap, and light on the way through both passes the drops of both.
    let sum = each[0].max_extinction_m1_q1 + each[1].max_extinction_m1_q1;
    assert_eq!(whole.max_extinction_m1_q1, sum);
    let modes = whole.parts.iter().map(|part| part.mode).max();
    assert_eq!((whole.parts[0].mode, modes), (0, Some(1)));
}

#[test]
fn a_joined_volume_has_the_figures_of_its_parts() {
    // The waterfall has three modes of its own.
    let text = include_str!("../../../data/scenes/waterfall-gorge.toml");
    let fall = Scene::from_toml(text).unwrap().drops.shape().unwrap();
    let scene = Scene::from_toml(&[HEAD, COARSE].concat()).unwrap();
    let rain = scene.drops.shape().unwrap();
    let (fall, rain) = (fall.volume().unwrap(), rain.volume().unwrap());
    let of_volume = |volume: &DropVolume| DropSummary::of_volume(volume).unwrap();
    let joined = DropSummary::joined([of_volume(&rain), of_volume(&fall)]).unwrap();
    let parts = [(String::new(), rain), ("fall".to_owned(), fall)];
    let volume = DropVolume::joined(parts);
    let whole = of_volume(&volume);
    assert_eq!(joined.parts, whole.parts);
    assert_eq!(joined.n_nodes, whole.n_nodes);
    // The fall has one grid for display; beside others each of its modes has its own.
    let ratio = joined.file_bytes as f64 / whole.file_bytes as f64;
    assert!((0.8..1.0).contains(&ratio), "{ratio}");
    assert_eq!((joined.min_m, joined.max_m), (whole.min_m, whole.max_m));
    assert_eq!(joined.effective_variance, whole.effective_variance);
    assert_eq!(DropSummary::joined([]), None);
}

#[test]
fn showers_apart_are_no_denser_together() {
    let away = COARSE
        .replace("-300.0]", "-3300.0]")
        .replace("-100.0]", "-3100.0]");
    let scene = Scene::from_toml(&[HEAD, FINE, &away].concat()).unwrap();
    let fine = Scene::from_toml(&[HEAD, FINE].concat()).unwrap();
    let coarse = Scene::from_toml(&[HEAD, &away].concat()).unwrap();
    let densest = summary(&fine)
        .max_extinction_m1_q1
        .max(summary(&coarse).max_extinction_m1_q1);
    assert_eq!(summary(&scene).max_extinction_m1_q1, densest);
}

#[test]
fn the_table_of_a_plan_holds_the_sizes_of_all() {
    let mut scene = Scene::from_toml(&two()).unwrap();
    scene.effects.set(Effect::DropFlattening, Switch::On);
    scene.effects.set(Effect::SizeSpread, Switch::On);
    let both = planned(&scene);
    assert!(both.is_on(Effect::PrimaryBow) && both.runs(Stage::Drops));
    let need = both.scattering.as_ref().unwrap();
    let ends = |axis: &[f64]| (axis[0], axis[axis.len() - 1]);
    // Flattened drops: single sizes, as far as the laws of both reach.
    let (first_um, last_um) = ends(&need.effective_radius_um);
    assert!(first_um < 130.0 && last_um > 640.0, "{first_um} {last_um}");
    assert_eq!(need.effective_variance, [0.0]);
    let drops = both
        .stages
        .iter()
        .find(|it| it.stage == Stage::Drops)
        .unwrap();
    assert!(
        drops.makes.contains("(uniform, uniform)"),
        "{}",
        drops.makes
    );
    // More drops are seen through more of them.
    let fine = planned(&Scene::from_toml(&[HEAD, FINE].concat()).unwrap());
    assert!(both.view.max_optical_depth > fine.view.max_optical_depth);
}

#[test]
fn drops_of_files_among_others_have_to_be_read_first() {
    let file = "[[drops]]\nfile = \"spray.vdb\"\n\n";
    let scene = Scene::from_toml(&[HEAD, FINE, file].concat()).unwrap();
    assert!(matches!(
        scene.drops.populations()[1].source,
        DropSource::File(_)
    ));
    let missing = plan(&scene, None).unwrap_err();
    assert!(matches!(missing, PlanError::NoDrops { file } if file.contains("spray.vdb")));
    let drops = summary(&Scene::from_toml(&two()).unwrap());
    // They become one volume, which is made.
    assert!(plan(&scene, Some(drops)).unwrap().runs(Stage::Drops));
}

#[test]
fn a_thin_one_of_several_is_warned_of_by_name() {
    let thin = FINE.replace("[200.0, 300.0, -200.0]", "[200.0, 10.0, -200.0]");
    let scene = Scene::from_toml(&[HEAD, &thin, COARSE].concat()).unwrap();
    let warnings = planned(&scene).warnings;
    assert!(
        warnings
            .iter()
            .any(|it| it.starts_with("the drops fine fill 10 m")),
        "{warnings:?}"
    );
}
