//! Bows in air as it is measured: molecules with today's constants, ozone and haze.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use niji_exchange::SpectralImage;
use niji_scene::Scene;
use support::niji_ends_with;
use support::profile;
use support::run_scene;
use support::variant;

/// The bow against the beam; worst 0.012.
const BEAM_TOLERANCE: f64 = 0.03;

const SIZE: [(&str, &str); 2] = [("camera.width_px", "120"), ("camera.height_px", "90")];
/// The same air without haze.
const MOLECULES: (&str, &str) = (
    "air",
    "{ constituents = [\"rayleigh\", \"ozone\"], rayleigh = \"bodhaine\" }",
);

fn render(name: &str, changes: &[(&str, &str)]) -> (Scene, SpectralImage) {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant(name, folder.path(), &[&SIZE[..], changes].concat());
    run_scene(&scene, &folder.path().join("out"))
}

/// Blue over red in the primary bow.
fn blue_over_red((scene, image): &(Scene, SpectralImage)) -> f64 {
    let mean = |nm| profile(image, scene, nm, |_, _| true).mean(40.0, 42.5);
    mean(450.0) / mean(650.0)
}

/// By how much the primary bow is brighter than the band outside it, in green.
fn contrast((scene, image): &(Scene, SpectralImage)) -> f64 {
    let green = profile(image, scene, 550.0, |_, _| true);
    green.mean(41.0, 42.0) / green.mean(44.5, 48.0) - 1.0
}

/// Share of the sunlight at 450 and 650 nm that haze alone leaves at a height, sun at 10 degrees, and
/// along a level kilometer.
fn through_haze(height_m: &str) -> [[f64; 2]; 2] {
    let arguments = "eval air --constituents aerosol --aerosol rural --visibility-km 23 \
                     --wavelengths-nm 450,650 --sun-zenith-deg 80 --view-zenith-deg 90 \
                     --distance-m 1000 --height-m";
    let all: Vec<&str> = arguments.split_whitespace().chain([height_m]).collect();
    let output = String::from_utf8(niji_ends_with(0, &all).stdout).unwrap();
    let mut lines = output.lines().map(|line| line.split(','));
    let header: Vec<&str> = lines.next().unwrap().collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|row| row.map(|field| field.parse().unwrap()).collect())
        .collect();
    ["sun_transmittance", "transmittance"].map(|name| {
        let column = header.iter().position(|column| *column == name).unwrap();
        [rows[0][column], rows[1][column]]
    })
}

#[test]
fn haze_reddens_the_low_bow_as_it_reddens_the_beam() {
    let scene = "paper-b-sun-10-attenuation-haze.toml";
    let found = blue_over_red(&render(scene, &[])) / blue_over_red(&render(scene, &[MOLECULES]));
    // The bow stands in the lowest 700 m of the rain.
    let [sun, view] = through_haze("350");
    let expected = (sun[0] / sun[1]) * (view[0] / view[1]);
    assert!(expected < 0.6, "{expected}");
    assert!(
        (found / expected - 1.0).abs() < BEAM_TOLERANCE,
        "found {found}, expected {expected}"
    );
}

#[test]
fn the_light_of_the_air_takes_contrast_from_the_bow() {
    let attenuated = contrast(&render("paper-b-sun-10-attenuation-haze.toml", &[]));
    let hazy = contrast(&render("paper-b-sun-10-inscatter-haze.toml", &[]));
    // Nothing but the light between the bows is behind a bow that the air only dims.
    assert!(attenuated > 1000.0, "{attenuated}");
    // Measured 0.24.
    assert!((0.15..0.35).contains(&hazy), "{hazy}");
}

#[test]
fn a_scene_without_air_effects_has_the_pixels_of_a_vacuum() {
    let off = [
        "sunlight_through_air",
        "air_extinction",
        "air_inscatter",
        "sky",
    ]
    .map(|effect| (format!("effects.{effect}"), "\"off\""));
    let off: Vec<(&str, &str)> = off.iter().map(|(key, off)| (key.as_str(), *off)).collect();
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str, changes: &[(&str, &str)]| {
        let changes = [&SIZE[..], changes].concat();
        let scene = variant("paper-c-figure-3.toml", folder.path(), &changes);
        let out = folder.path().join(name);
        let (_, image) = run_scene(&scene, &out);
        assert!(!out.join("atmosphere.exr").exists());
        image.radiance
    };
    let vacuum = picture("vacuum", &[]);
    let unused = picture("unused", &[&[MOLECULES][..], &off].concat());
    assert_eq!(vacuum, unused);
}
