//! The bows of the shipped scenes, measured in their spectral images.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use support::Profile;
use support::profile;
use support::run_scene;
use support::variant;

use niji_exchange::SpectralImage;
use niji_scene::Scene;

fn render(name: &str, changes: &[(&str, &str)]) -> (Scene, SpectralImage) {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant(name, folder.path(), changes);
    run_scene(&scene, &folder.path().join("out"))
}

fn everywhere(scene: &Scene, image: &SpectralImage, wavelength_nm: f64) -> Profile {
    profile(image, scene, wavelength_nm, |_, _| true)
}

#[test]
fn drops_of_a_tenth_of_a_millimetre_have_their_bows_where_the_wave_puts_them() {
    let (scene, image) = render("paper-c-figure-3.toml", &[]);
    let green = everywhere(&scene, &image, 560.0);

    // Not at 42 degrees: for this size the first peak lies a degree inside Descartes' angle.
    let primary = green.peak_deg(38.0, 44.0);
    assert!((primary - 41.0).abs() < 0.2, "primary at {primary}");
    let secondary = green.peak_deg(49.0, 57.0);
    assert!((secondary - 52.7).abs() < 0.3, "secondary at {secondary}");

    let (dark, inside) = (green.mean(45.0, 47.0), green.mean(37.0, 39.0));
    assert!(dark < 0.05 * green.mean(40.5, 41.5), "Alexander's band");
    assert!(
        inside > 5.0 * dark,
        "brighter inside the primary than between the bows"
    );
    assert!(
        green.mean(52.0, 53.5) > 3.0 * dark,
        "the secondary stands out"
    );

    // 40.97 38.96 37.62 36.41 degrees by Lorenz-Mie.
    let fringes = green.maxima_deg(35.5, 42.0);
    for expected in [40.97, 38.96, 37.62, 36.41] {
        let found = fringes
            .iter()
            .any(|fringe| (fringe - expected).abs() < 0.35);
        assert!(found, "no supernumerary near {expected} in {fringes:?}");
    }

    let (blue, red) = (
        everywhere(&scene, &image, 450.0),
        everywhere(&scene, &image, 650.0),
    );
    assert!(
        red.peak_deg(38.0, 44.0) > blue.peak_deg(38.0, 44.0) + 0.5,
        "primary: red outside"
    );
    assert!(
        red.peak_deg(49.0, 57.0) < blue.peak_deg(49.0, 57.0) - 0.5,
        "secondary: red inside"
    );
}

#[test]
fn large_drops_have_their_bows_near_descartes_rays() {
    let size = (
        "drops.uniform.law",
        "{ monodisperse = { radius_um = 500.0 } }",
    );
    let flat = ("drops.law", "{ monodisperse = { radius_um = 500.0 } }");
    let text = std::fs::read_to_string(support::repository("data/scenes/paper-c-figure-3.toml"));
    let nested = text.unwrap().contains("[drops.uniform]");
    let (scene, image) = render("paper-c-figure-3.toml", &[if nested { size } else { flat }]);
    let green = everywhere(&scene, &image, 560.0);
    let index = scene
        .water()
        .refractive_index(niji_radiometry::Nanometers(560.0));
    let descartes = 180.0
        - niji_airy::rainbow_ray(index, 2)
            .unwrap()
            .theta_rad()
            .to_degrees();
    let primary = green.peak_deg(39.0, 45.0);
    // The wave's peak lies 0.3 degrees inside the ray for this size.
    assert!(
        (descartes - primary - 0.3).abs() < 0.2,
        "primary {primary}, ray {descartes}"
    );
    let secondary = green.peak_deg(49.0, 55.0);
    assert!(
        (51.2..51.9).contains(&secondary),
        "secondary at {secondary}"
    );
}

#[test]
fn the_bow_is_fainter_where_there_are_fewer_drops() {
    let size = [("camera.width_px", "320"), ("camera.height_px", "240")];
    let (scene, even) = render("paper-c-figure-3.toml", &size);
    let (_, graded) = render("paper-c-figure-5.toml", &size);
    // Density runs from 0 on the ground to 1000 at the top; figure 3 has 1000 everywhere.
    let share = |rows: std::ops::Range<usize>| {
        let keep = |_: usize, y: usize| rows.contains(&y);
        let on_bow = |image| profile(image, &scene, 560.0, keep).mean(40.0, 42.0);
        on_bow(&graded) / on_bow(&even)
    };
    let (top, feet) = (share(84..94), share(130..145));
    assert!(
        top > 2.5 * feet,
        "share of the drops at the top {top}, at the feet {feet}"
    );
    assert!(top < 0.9 && feet > 0.0);
}

#[test]
fn the_primary_changes_its_look_with_height_where_the_size_does() {
    let size = [("camera.width_px", "320"), ("camera.height_px", "240")];
    let (scene, even) = render("paper-c-figure-3.toml", &size);
    let (_, graded) = render("paper-c-figure-4.toml", &size);
    // Drops of 1.5 mm at the ground and 0.01 mm at the top, against 0.1 mm everywhere: the scattered
    // light follows the square of the radius.
    let gain = |rows: std::ops::Range<usize>| {
        let keep = |_: usize, y: usize| rows.contains(&y);
        let on_bow = |image| profile(image, &scene, 560.0, keep).mean(40.0, 42.5);
        on_bow(&graded) / on_bow(&even)
    };
    let (top, feet) = (gain(84..94), gain(130..145));
    assert!(
        feet > 1.5 * top,
        "gain at the feet {feet}, at the top {top}"
    );
    // Large drops blur no fringes into the bow: its peak lies where geometry puts it.
    let peak = profile(&graded, &scene, 560.0, |_, _| true).peak_deg(38.0, 44.0);
    assert!((peak - 41.8).abs() < 0.3, "peak at {peak}");
}

#[test]
fn the_lower_the_sun_the_less_blue_is_left_in_the_whole_bow() {
    let size = [("camera.width_px", "320"), ("camera.height_px", "240")];
    let blue_over_red = |name: &str| {
        let (scene, image) = render(name, &size);
        let mean = |wavelength_nm| {
            let profile = everywhere(&scene, &image, wavelength_nm);
            let (primary, secondary) = (profile.mean(40.0, 42.5), profile.mean(51.0, 54.0));
            [primary, secondary]
        };
        let (blue, red) = (mean(450.0), mean(650.0));
        [blue[0] / red[0], blue[1] / red[1]]
    };
    let ratios = [
        blue_over_red("paper-b-sun-30-attenuation.toml"),
        blue_over_red("paper-b-sun-20-attenuation.toml"),
        blue_over_red("paper-b-sun-10-attenuation.toml"),
    ];
    for bow in 0..2 {
        let [high, middle, low] = ratios.map(|ratio| ratio[bow]);
        assert!(
            high > 1.1 * middle && middle > 1.2 * low,
            "bow {bow}: {high}, {middle}, {low}"
        );
    }
    // Direct beam with the papers' constants: T(450)/T(650) is 0.635/0.901 at 30 degrees and
    // 0.282/0.748 at 10.
    let fall = ratios[2][0] / ratios[0][0];
    let expected = (0.282 / 0.748) / (0.635 / 0.901);
    assert!(
        (fall / expected - 1.0).abs() < 0.08,
        "fall {fall}, expected {expected}"
    );
}
