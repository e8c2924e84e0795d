//! `niji view` by plain HTTP: who may ask, what a change does, what is saved.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[allow(dead_code, unreachable_pub, reason = "others use the rest")]
#[path = "support/changes.rs"]
mod changes;
#[allow(dead_code, unreachable_pub, reason = "others use the rest")]
#[path = "support/places.rs"]
mod places;
mod support;
#[allow(unreachable_pub, reason = "others use the rest")]
#[path = "../crates/vdb/tests/common/mod.rs"]
mod vdb_files;
#[path = "support/view.rs"]
mod view;

use std::fs;
use std::path::Path;

use changes::change;
use niji_exchange::SpectralImage;
use niji_photo::Photograph;
use serde_json::Value;
use serde_json::json;
use support::TINY;
use support::niji_ends_with;
use support::text;
use vdb_files::Random;
use view::View;

/// The pixels that `niji run` leaves of a scene.
fn pixels_of_run(scene: &Path, out: &Path) -> Vec<f32> {
    niji_ends_with(0, &["run", text(scene), "-o", text(out), "-q"]);
    let image = SpectralImage::read_spectral(&out.join("image.exr")).unwrap();
    image
        .shown()
        .permuted_axes([1, 2, 0])
        .iter()
        .copied()
        .collect()
}

fn tiny(folder: &Path) -> std::path::PathBuf {
    let scene = folder.join("tiny.toml");
    fs::write(&scene, format!("# Ours.\n{TINY}")).unwrap();
    scene
}

#[test]
fn a_change_shows_the_picture_that_a_run_makes_of_it_and_so_does_what_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    let first = view.pixels();
    let out = folder.path().join("first");
    assert_eq!(first, pixels_of_run(&scene, &out));
    let report = fs::read_to_string(out.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let told = &view.picture()["error_of_white"];
    assert_eq!(told, &report["accuracy"]["error"]);

    let (status, told) = view.set("sun.elevation_deg", &json!(25.0));
    assert_eq!((status, &told["is_edited"]), (200, &json!(true)));
    let second = view.pixels();
    assert!(second != first);
    // Nothing is written but by saving, and then nothing but the value.
    let before = fs::read_to_string(&scene).unwrap();
    assert_eq!(view.post("save", &json!({})).0, 200);
    let saved = fs::read_to_string(&scene).unwrap();
    assert_eq!(
        saved,
        before.replace("elevation_deg = 20.0", "elevation_deg = 25.0")
    );
    assert_eq!(second, pixels_of_run(&scene, &folder.path().join("second")));

    // Exposure follows no ray.
    let number = view.picture()["number"].clone();
    assert_eq!(view.set("picture.exposure_ev", &json!(2.0)).0, 200);
    assert_eq!(view.picture()["number"], number);

    let (_, told) = view.post("undo", &json!({}));
    assert_eq!(told["text"], saved);
    let (_, told) = view.post("undo", &json!({}));
    assert_eq!(told["text"], before);
    assert_eq!(view.pixels(), first);
    let (_, told) = view.post("redo", &json!({}));
    assert_eq!(
        (&told["text"], &told["can_redo"]),
        (&json!(saved), &json!(true))
    );
}

#[test]
fn a_wrong_value_is_told_with_its_key_as_a_run_tells_it_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    let (status, told) = view.set("sun.elevation_deg", &json!(95));
    assert_eq!((status, &told["key"]), (422, &json!("sun.elevation_deg")));
    fs::write(
        &scene,
        TINY.replace("elevation_deg = 20.0", "elevation_deg = 95.0"),
    )
    .unwrap();
    let run = niji_ends_with(3, &["plan", text(&scene)]);
    let of_run = String::from_utf8(run.stderr).unwrap();
    let of_view = told["message"].as_str().unwrap();
    let reason = of_view.split_once(": ").unwrap().1;
    assert!(of_run.contains(reason), "{of_run} {of_view}");
    for (key, value, expected) in [
        ("sun.elevatio", json!(1), "sun.elevatio"),
        ("camera.width_px", json!("wide"), "camera.width_px"),
        ("drops.law", Value::Null, "drops.law"),
        ("drops.voxel_m.x", json!(1), "drops.voxel_m.x"),
    ] {
        let (status, told) = view.set(key, &value);
        assert_eq!((status, &told["key"]), (422, &json!(expected)), "{told}");
    }
    assert_eq!(view.json("scene")["is_edited"], false);
}

#[test]
fn the_sun_goes_to_date_and_place_and_back_and_no_scene_on_the_way_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    let before = view.json("scene");
    let set = |values: Value| view.post("set", &json!({ "values": values }));
    let timed = json!({
        "sun.elevation_deg": null, "sun.azimuth_deg": null,
        "sun.date_time": "2026-06-21T18:30:00+02:00", "sun.latitude_deg": 48.1, "sun.longitude_deg": 11.6,
    });
    let (status, told) = set(timed);
    assert_eq!(status, 200, "{told}");
    let sun = |told: &Value, key: &str| told["sun"][key].as_f64().unwrap();
    // Munich, 16:30 UTC: 25 degrees high, a little north of west.
    assert!((sun(&told, "elevation_deg") - 25.0).abs() < 3.0, "{told}");
    assert!((sun(&told, "azimuth_deg") - 277.0).abs() < 3.0, "{told}");
    // Half of either way is none.
    let (status, told) = view.set("sun.elevation_deg", &json!(20));
    assert_eq!((status, &told["key"]), (422, &json!("sun")), "{told}");
    let back = json!({
        "sun.date_time": null, "sun.latitude_deg": null, "sun.longitude_deg": null,
        "sun.elevation_deg": 20.0, "sun.azimuth_deg": 180.0,
    });
    let (status, told) = set(back);
    assert_eq!((status, &told["sun"]), (200, &before["sun"]));
}

#[test]
fn the_drops_under_the_pointer_have_their_radius_and_their_box_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    view.pixels();
    let told = view.json("at?right=0.5&down=0.5");
    let radius_um = told["effective_radius_um"].as_f64().unwrap();
    assert!((radius_um - 500.0).abs() < 0.1, "{told}");
    // Straight down there is nothing between the eye and the near face.
    assert_eq!(
        view.json("at?right=0.5&down=0.999")["effective_radius_um"],
        Value::Null
    );
    let lines = view.picture()["drops"].clone();
    assert!(lines.as_array().unwrap().len() > 3, "{lines}");
    let places = lines
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|line| line.as_array().unwrap());
    for place in places.flat_map(|place| place.as_array().unwrap()) {
        assert!((0.0..=1.0).contains(&place.as_f64().unwrap()), "{place}");
    }
}

#[test]
fn a_file_that_somebody_else_changed_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    assert_eq!(view.set("sun.azimuth_deg", &json!(170)).0, 200);
    let theirs = TINY.replace("name = \"tiny\"", "name = \"theirs\"");
    fs::write(&scene, &theirs).unwrap();
    let (status, told) = view.post("save", &json!({}));
    assert_eq!(status, 409);
    assert!(
        told["message"].as_str().unwrap().contains("somebody else"),
        "{told}"
    );
    assert_eq!(fs::read_to_string(&scene).unwrap(), theirs);
    let (status, told) = view.post("again", &json!({}));
    assert_eq!((status, &told["name"]), (200, &json!("theirs")));
    assert_eq!(view.post("save", &json!({})).0, 200);
    // A text of before that is no longer the one that is there.
    let (status, _) = view.post("text", &json!({ "text": TINY, "of": 1 }));
    assert_eq!(status, 422);
}

#[test]
fn only_who_knows_the_address_is_answered_and_nothing_but_the_page_is_served() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    fs::write(folder.path().join("secret.txt"), "secret").unwrap();
    let view = View::of(&scene);
    let own = format!("Host: {}\r\n", view.host);
    let port = view.host.split_once(':').unwrap().1;
    assert_eq!(view.get_from(&view.base, &own).0, 200);
    let local = format!("Host: localhost:{port}\r\nOrigin: http://localhost:{port}\r\n");
    assert_eq!(view.get_from(&view.base, &local).0, 200);

    let wrong = format!("/{}/", "0".repeat(view.base.len() - 2));
    for (path, fields) in [
        ("/", own.clone()),
        (&*wrong, own.clone()),
        (&view.base[..view.base.len() - 1], own.clone()),
        (&view.base, "Host: evil.example\r\n".to_owned()),
        (&view.base, format!("Host: evil.example:{port}\r\n")),
        (&view.base, String::new()),
        (&view.base, format!("{own}Origin: http://evil.example\r\n")),
        (
            &view.base,
            format!("{own}Origin: https://{}\r\n", view.host),
        ),
        (&view.base, format!("{own}Origin: null\r\n")),
        (&view.base, format!("{own}Sec-Fetch-Site: cross-site\r\n")),
        (&view.base, format!("{own}Sec-Fetch-Site: same-site\r\n")),
    ] {
        assert_eq!(view.get_from(path, &fields).0, 403, "{path} {fields}");
    }
    for path in [
        "tiny.toml",
        "secret.txt",
        "../secret.txt",
        "%2e%2e/secret.txt",
        "..%2fsecret.txt",
        "//etc/passwd",
        "page/index.html",
        "pixels",
        "at?right=2&down=0.5",
        "at?right=nan&down=0.5",
    ] {
        assert_eq!(view.get(path).0, 404, "{path}");
    }
    // The scene may name no file that it did not name.
    let (status, told) = view.set("drops", &json!({ "file": "secret.txt" }));
    assert_eq!(status, 422);
    assert!(
        told["message"].as_str().unwrap().contains("secret.txt"),
        "{told}"
    );
}

#[test]
fn no_request_ends_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let view = View::of(&scene);
    let body = json!({ "values": { "sun.elevation_deg": 21.5 }, "gesture": "g" }).to_string();
    let sound = format!(
        "POST {}set HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\n\r\n{body}",
        view.base,
        view.host,
        body.len()
    );
    let mut random = Random(40);
    let mut n_refused = 0;
    for _ in 0..400 {
        let mut bytes = sound.clone().into_bytes();
        for _ in 0..=random.below(4) {
            change(&mut bytes, &mut random);
        }
        let refused = view.send(&bytes).is_none_or(|(status, _)| status != 200);
        n_refused += usize::from(refused);
    }
    assert!(n_refused > 100, "{n_refused}");
    // Some changed the scene, which is still one.
    assert_eq!(
        view.json("scene")["name"].as_str().map(str::is_empty),
        Some(false)
    );
    view.pixels();
}

#[test]
fn what_is_saved_keeps_the_line_ends_and_the_mark_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let scene = tiny(folder.path());
    let plain = fs::read_to_string(&scene).unwrap();
    let before = format!("\u{feff}{}", plain.replace('\n', "\r\n"));
    fs::write(&scene, &before).unwrap();
    let view = View::of(&scene);
    assert_eq!(view.json("scene")["is_edited"], false);
    assert_eq!(view.set("sun.elevation_deg", &json!(25.0)).0, 200);
    assert_eq!(view.post("save", &json!({})).0, 200);
    let saved = fs::read_to_string(&scene).unwrap();
    let expected = before.replace("elevation_deg = 20.0", "elevation_deg = 25.0");
    assert_eq!(saved, expected);
    assert_eq!(view.json("scene")["is_edited"], false);
}

#[test]
fn a_bow_in_a_photograph_is_that_of_a_run_and_goes_where_its_picks_are_dragged() {
    let folder = tempfile::tempdir().unwrap();
    let photos = concat!(env!("CARGO_MANIFEST_DIR"), "/data/photos/");
    let small = include_str!("../data/scenes/photo-pavilion-rain.toml")
        .replace("../photos/", photos)
        .replace("preset = \"standard\"", "preset = \"draft\"");
    let scene = folder.path().join("photograph.toml");
    fs::write(&scene, &small).unwrap();
    let view = View::of(&scene);
    let told = view.picture();
    assert_eq!(
        (&told["size"], &told["is_photograph"]),
        (&json!([640, 427]), &json!(true))
    );
    let shown = folder.path().join("shown.png");
    fs::write(&shown, view.get("picture.png").1).unwrap();
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let [shown, run] = [shown, out.join("composite.png")].map(|it| Photograph::read(&it).unwrap());
    assert!(shown == run);

    let picks = |told: &Value| -> Vec<[f64; 2]> {
        serde_json::from_value(told["values"]["photo"]["picks_px"].clone()).unwrap()
    };
    let first = view.json("scene");
    assert_eq!(first["photograph_size"], json!([640, 427]));
    let taken = picks(&first)[1];
    let part = |[x, y]: [f64; 2]| [x / 640.0, y / 427.0];
    let drag = |to: [f64; 2]| {
        let values = json!({ "picks_px": picks(&first), "from": part(taken), "to": part(to) });
        view.post("drag-picks", &json!({ "values": values }))
    };
    let wanted = [taken[0] - 15.0, taken[1] + 20.0];
    let (status, told) = drag(wanted);
    assert_eq!(status, 200);
    // Picks are written in tenths of a pixel.
    let found = picks(&told)[1];
    assert!(
        (found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 0.1,
        "{found:?}"
    );
    let risen = [&told, &first].map(|it| it["sun"]["elevation_deg"].as_f64().unwrap());
    assert!((risen[0] - risen[1] - 1.9).abs() < 0.3, "{risen:?}");
    // The sun of a bow so high has set, and nobody picks behind the camera.
    for to in [[320.0, -500.0], [-1e9, 0.0]] {
        let (status, refused) = drag(to);
        assert_eq!(status, 422, "{refused}");
    }
    let now = view.json("scene");
    assert_eq!(picks(&now), picks(&told));
    // What it never named is not opened.
    for file in ["/etc/passwd", "photograph.toml"] {
        let (status, refused) = view.set("photo.picture", &json!(file));
        assert_eq!(status, 422);
        let message = refused["message"].as_str().unwrap();
        assert!(message.contains("named when it was opened"), "{message}");
    }
    // A larger photograph has about the pixels of its picture.
    assert_eq!(view.set("camera.width_px", &json!(320)).0, 200);
    assert_eq!(view.set("camera.height_px", &json!(213)).0, 200);
    assert_eq!(view.picture()["size"], json!([320, 213]));
    assert_eq!(view.pixels().len(), 3 * 320 * 213);
}
