//! A sun by date, time and place, and what the section `[sun]` refuses.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use niji_scene::Moment;
use niji_scene::Scene;

/// The scene with another section `[sun]`, which begins in line 3.
fn scene_text(sun: &str) -> String {
    format!(
        r#"format = 1
name = "time"
[sun]
{sun}
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 90.0
width_px = 64
height_px = 48
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, -120.0]
box_max_m = [50.0, 50.0, -20.0]
voxel_m = 5.0
law = {{ monodisperse = {{ radius_um = 20.0 }} }}
number_density_m3 = 1e7
"#
    )
}

const PLACE: &str = "latitude_deg = 35.0\nlongitude_deg = 135.8\n";
const POSITION: &str = "elevation_deg = 10.0\nazimuth_deg = 250.0\n";

fn refusal(sun: &str) -> String {
    Scene::from_toml(&scene_text(sun)).unwrap_err().to_string()
}

/// Elevation and azimuth of the sun at a date, degrees.
fn sun_at(date_time: &str) -> [f64; 2] {
    let text = scene_text(&format!("date_time = \"{date_time}\"\n{PLACE}"));
    let sun = Scene::from_toml(&text).unwrap().sun;
    [sun.elevation_deg, sun.azimuth_deg]
}

#[test]
fn the_clock_its_zone_and_the_place_count_as_they_are_written() {
    let moment = Moment {
        local_time: [2026, 6, 21, 18, 30, 7],
        utc_offset_h: 9.5,
        latitude_deg: 35.0,
        longitude_deg: 135.8,
    };
    let sun = moment.sun().unwrap();
    let expected = [sun.elevation_deg, sun.azimuth_deg];
    assert_eq!(sun_at("2026-06-21T18:30:07+09:30"), expected);
    // The same moment on other clocks, to the rounding of dates; fractions of a second do not matter.
    for same in ["2026-06-21T09:00:07.9Z", "2026-06-21 06:00:07-03:00"] {
        for (found, expected) in sun_at(same).into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-6,
                "{same}: {found} {expected}"
            );
        }
    }
    // A leap day.
    assert!(sun_at("2024-02-29T03:00:00Z")[0] > 40.0);
}

#[test]
fn a_sun_by_time_is_the_same_scene_as_a_sun_by_position() {
    let date = "date_time = \"2026-06-21T18:30:00+09:00\"\n";
    let by_time = Scene::from_toml(&scene_text(&format!("{date}{PLACE}"))).unwrap();
    let [elevation_deg, azimuth_deg] = sun_at("2026-06-21T18:30:00+09:00");
    let by_position = scene_text(&format!(
        "elevation_deg = {elevation_deg}\nazimuth_deg = {azimuth_deg}\n"
    ));
    assert_eq!(by_time, Scene::from_toml(&by_position).unwrap());
    // What was resolved stands in the canonical form, so that requests depend on it alone.
    let again = Scene::from_json(&by_time.canonical_json()).unwrap();
    assert_eq!(again, by_time);
}

#[test]
fn both_ways_or_neither_are_refused() {
    let time = "date_time = \"2026-06-21T18:30:00Z\"\n";
    for sun in [
        format!("{time}{PLACE}{POSITION}"),
        format!("{POSITION}latitude_deg = 35.0\n"),
        String::new(),
    ] {
        let found = refusal(&sun);
        assert!(found.starts_with("line 3: `sun` is"), "{found}");
        assert!(found.contains("expected either elevation_deg"), "{found}");
    }
    for (sun, missing) in [
        (PLACE.to_owned(), "date_time"),
        (format!("{time}latitude_deg = 1.0"), "longitude_deg"),
        ("elevation_deg = 1.0".to_owned(), "azimuth_deg"),
    ] {
        assert_eq!(refusal(&sun), format!("line 3: [sun] lacks `{missing}`"));
    }
}

#[test]
fn dates_without_a_zone_dates_that_never_were_and_places_off_the_globe_are_refused_with_their_line()
{
    let date = |text: &str| refusal(&format!("date_time = \"{text}\"\n{PLACE}"));
    let zoneless = date("2026-06-21T18:30:00");
    assert_eq!(
        zoneless,
        "line 4: `sun.date_time` is \"2026-06-21T18:30:00\" without a time zone, expected a date and \
         time with its zone, as 2026-06-21T18:30:00+02:00"
    );
    for wrong in [
        "2026-06-21",
        "2026-02-30T12:00:00Z",
        "yesterday",
        "",
        "2026-06-21T25:00:00Z",
    ] {
        let found = date(wrong);
        assert!(found.starts_with("line 4: `sun.date_time` is"), "{found}");
        assert!(found.contains("with its zone"), "{found}");
    }
    // A date of TOML's own.
    let bare = refusal(&format!("date_time = 2026-06-21T18:30:00Z\n{PLACE}"));
    assert!(bare.contains("in quotes"), "{bare}");
    let time = "date_time = \"2026-06-21T18:30:00Z\"\n";
    let off = refusal(&format!("{time}latitude_deg = 95.0\nlongitude_deg = 0.0"));
    assert!(off.starts_with("line 5: `sun.latitude_deg` is 95"), "{off}");
    let off = refusal(&format!("{time}latitude_deg = 9.0\nlongitude_deg = 200.0"));
    assert!(off.starts_with("line 6: `sun.longitude_deg`"), "{off}");
}

#[test]
fn the_moon_needs_a_position() {
    let found = refusal(&format!(
        "body = \"moon\"\ndate_time = \"2026-06-21T18:30:00Z\"\n{PLACE}"
    ));
    assert!(found.contains("the moon has no almanac here"), "{found}");
    assert!(found.starts_with("line 5"), "{found}");
}
