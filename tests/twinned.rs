//! The twinned bow of the shipped scene, measured in its picture.
//!
//! Flattening moves the primary of the large drops inwards at the top and not where the bow meets the ground; that
//! of the small drops stays. So luminance has two maxima at the top and one at the feet. The secondary moves so
//! little that it stays single.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_radiometry::Colorimetry;
use support::Profile;
use support::profile_of;
use support::run_scene;
use support::variant;

/// Half of the scene's wavelengths.
const SPECTRUM: [(&str, &str); 3] = [
    ("spectrum.first_nm", "380"),
    ("spectrum.step_nm", "20"),
    ("spectrum.n_wavelengths", "21"),
];
/// A column of pixels of up to 0.1 degrees through both bows at their top.
const TOP: [(&str, &str); 5] = [
    ("camera.azimuth_deg", "0.0"),
    ("camera.elevation_deg", "20.0"),
    ("camera.horizontal_fov_deg", "0.1"),
    ("camera.width_px", "1"),
    ("camera.height_px", "360"),
];
/// A row of such pixels through the primary half a degree above the ground.
const FEET: [(&str, &str); 5] = [
    ("camera.azimuth_deg", "37.0"),
    ("camera.elevation_deg", "0.5"),
    ("camera.horizontal_fov_deg", "24.0"),
    ("camera.width_px", "240"),
    ("camera.height_px", "1"),
];
/// Where the bows are looked for, degrees from the antisolar point.
const PRIMARY_DEG: (f64, f64) = (36.0, 46.0);
const SECONDARY_DEG: (f64, f64) = (48.0, 56.0);

/// Luminance of all light.
fn luminance(image: &SpectralImage) -> Array2<f64> {
    let weights = Colorimetry::new(&image.wavelengths);
    let (_, height, width) = image.radiance.dim();
    let mut sum = Array2::zeros((height, width));
    for (plane, [_, y, _]) in image.radiance.outer_iter().zip(weights.weights()) {
        sum.zip_mut_with(&plane, |sum, value| *sum += y * f64::from(*value));
    }
    sum
}

/// Luminance against the bow angle along a line of pixels.
fn along(line: &[(&str, &str)]) -> Profile {
    let folder = tempfile::tempdir().unwrap();
    let changes = [&SPECTRUM[..], line].concat();
    let scene = variant("twinned-bow.toml", folder.path(), &changes);
    let (scene, image) = run_scene(&scene, &folder.path().join("out"));
    profile_of(&luminance(&image), &scene, |_, _| true)
}

#[test]
fn the_twinned_bow_has_two_maxima_at_the_top_and_one_at_the_feet() {
    let [top, feet] = [along(&TOP), along(&FEET)];
    let maxima = |profile: &Profile, (from_deg, to_deg)| profile.maxima_deg(from_deg, to_deg);
    let primary = maxima(&top, PRIMARY_DEG);
    assert_eq!(primary.len(), 2, "{primary:?}");
    let peak_deg = |near_deg: f64| top.peak_deg(near_deg - 0.3, near_deg + 0.3);
    let apart_deg = peak_deg(primary[1]) - peak_deg(primary[0]);
    assert!((1.5..2.5).contains(&apart_deg), "{apart_deg}");
    let secondary = maxima(&top, SECONDARY_DEG);
    assert_eq!(secondary.len(), 1, "{secondary:?}");
    let at_feet = maxima(&feet, PRIMARY_DEG);
    assert_eq!(at_feet.len(), 1, "{at_feet:?}");
    println!("{primary:?}, {apart_deg:.2} apart, {secondary:?}, {at_feet:?}");
}
