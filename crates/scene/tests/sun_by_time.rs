//! A sun by date, time and place: what the section `[sun]` hands to whoever knows the sun's course,
//! and what it refuses.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use std::cell::Cell;

use niji_scene::Moment;
use niji_scene::Scene;
use niji_scene::SunPosition;

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

#[allow(clippy::unnecessary_wraps, reason = "an almanac may refuse")]
fn somewhere(_: &Moment) -> Result<SunPosition, String> {
    Ok(SunPosition {
        elevation_deg: 12.5,
        azimuth_deg: 240.0,
    })
}

fn refusal(sun: &str) -> String {
    let refused = Scene::from_toml_with(&scene_text(sun), somewhere);
    refused.unwrap_err().to_string()
}

/// What a date hands over.
fn moment(date_time: &str) -> Moment {
    let seen = Cell::new(None);
    let text = scene_text(&format!("date_time = \"{date_time}\"\n{PLACE}"));
    let scene = Scene::from_toml_with(&text, |moment| {
        seen.set(Some(*moment));
        somewhere(moment)
    });
    assert_eq!(scene.unwrap().sun.elevation_deg, 12.5);
    seen.get().unwrap()
}

#[test]
fn the_clock_its_zone_and_the_place_are_handed_over_as_they_are_written() {
    let east = moment("2026-06-21T18:30:07+09:30");
    assert_eq!(east.local_time, [2026, 6, 21, 18, 30, 7]);
    assert_eq!(east.utc_offset_h, 9.5);
    assert_eq!((east.latitude_deg, east.longitude_deg), (35.0, 135.8));
    assert_eq!(moment("2026-06-21T18:30:00Z").utc_offset_h, 0.0);
    assert_eq!(moment("2026-06-21 18:30:00-03:00").utc_offset_h, -3.0);
    // A leap day, and fractions of a second, which do not matter to the sun.
    assert_eq!(
        moment("2024-02-29T00:00:59.9Z").local_time,
        [2024, 2, 29, 0, 0, 59]
    );
}

#[test]
fn a_sun_by_time_is_the_same_scene_as_a_sun_by_position() {
    let by_time = scene_text(&format!(
        "date_time = \"2026-06-21T18:30:00+09:00\"\n{PLACE}"
    ));
    let by_time = Scene::from_toml_with(&by_time, somewhere).unwrap();
    let by_position = scene_text("elevation_deg = 12.5\nazimuth_deg = 240.0\n");
    assert_eq!(by_time, Scene::from_toml(&by_position).unwrap());
    // What was resolved stands in the canonical form, so that requests depend on it alone.
    let again = Scene::from_json(&by_time.canonical_json()).unwrap();
    assert_eq!(again, by_time);
}

#[test]
fn a_position_needs_nobody_who_knows_the_suns_course() {
    let scene = Scene::from_toml_with(&scene_text(POSITION), |_| unreachable!()).unwrap();
    assert_eq!(scene.sun.elevation_deg, 10.0);
    let by_time = scene_text(&format!("date_time = \"2026-06-21T18:30:00Z\"\n{PLACE}"));
    let refused = Scene::from_toml(&by_time).unwrap_err().to_string();
    assert!(refused.starts_with("line 4: `sun.date_time`"), "{refused}");
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

#[test]
fn what_the_almanac_refuses_has_the_line_of_the_date() {
    let text = scene_text(&format!("date_time = \"2026-06-21T18:30:00Z\"\n{PLACE}"));
    let refused = Scene::from_toml_with(&text, |_| Err("too long ago".to_owned()));
    let found = refused.unwrap_err().to_string();
    assert!(
        found.starts_with("line 4") && found.contains("(too long ago)"),
        "{found}"
    );
}
