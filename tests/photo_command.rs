//! `niji photo`: a bow set into a photograph with one command.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "support/bow_in_photo.rs"]
mod bow_in_photo;
#[allow(dead_code, unreachable_pub, reason = "others use the rest")]
#[path = "support/pavilion.rs"]
mod pavilion;
#[path = "support/plates.rs"]
mod plates;
mod support;

use std::fs::File;

use bow_in_photo::Painted;
use bow_in_photo::off_deg;
use bow_in_photo::painted;
use bow_in_photo::pavilion_changed;
use bow_in_photo::photo;
use ndarray::Array2;
use niji_exchange::Provenance;
use niji_photo::Photograph;
use niji_photo::read_labels;
use niji_photo::write_jpeg;
use niji_photo::write_labels;
use niji_photo::write_png;
use plates::horizon;
use plates::plate;
use plates::without_sky;
use support::niji_ends_with;
use support::repository;
use support::text;

const SIZE: [usize; 2] = [240, 160];

#[test]
fn the_shipped_photograph_has_a_bow_through_its_apex_with_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let pavilion = repository("data/photos/pavilion.jpg");
    let flags = ["--apex", "400,45", "--fov-deg", "60"];
    let told = photo(0, &pavilion, &out, &flags);
    for word in ["confidence", "by the lowest sky", "--horizon", "mm/h"] {
        assert!(told.contains(word), "{word}: {told}");
    }
    let off = off_deg(&out, [400.0, 45.0]);
    assert!(off < 0.5, "{off}");
    let labels = read_labels(&repository("data/photos/pavilion.labels.png"), 29).unwrap();
    let photograph = Photograph::read(&pavilion).unwrap();
    // The far shore and the lake go over into the sky without an edge; pavilion and trees do not.
    let is_clear = |y: usize, x: usize| labels[[y, x]] < 25;
    let [foreground, sky] = painted(&photograph, &out, is_clear).map(Painted::part);
    assert!(foreground < 1e-3, "{foreground}");
    assert!(sky > 0.3, "{sky}");
    // Again there is nothing to do; what somebody edited stays, and a run goes on with it.
    assert!(photo(0, &pavilion, &out, &flags).contains("everything is up to date"));
    let scene = out.join("photo.toml");
    let edited = std::fs::read_to_string(&scene).unwrap() + "# mine\n";
    std::fs::write(&scene, edited).unwrap();
    assert!(photo(2, &pavilion, &out, &flags).contains("--force"));
}

/// At half its size; plates and the whole size in `cargo bench --bench photo_plates`.
#[test]
fn the_shipped_photograph_gets_its_bow_cropped_turned_and_darkened() {
    let folder = tempfile::tempdir().unwrap();
    for it in pavilion_changed(25) {
        let size = (it.light.nrows() / 2, it.light.ncols() / 2);
        let light = Array2::from_shape_fn(size, |(y, x)| it.light[[2 * y, 2 * x]]);
        let file = folder.path().join(format!("{}.jpg", it.name));
        write_jpeg(&light, File::create(&file).unwrap()).unwrap();
        let photograph = Photograph::read(&file).unwrap();
        let apex = (it.moved)([400.0, 45.0]).map(|place| 0.5 * place);
        let out = folder.path().join(it.name);
        let [x, y] = apex;
        let flags = [
            format!("--apex={x},{y}"),
            "--fov-deg=55".to_owned(),
            format!("--roll-deg={}", it.roll_deg),
        ];
        photo(0, &file, &out, &flags.each_ref().map(String::as_str));
        let off = off_deg(&out, apex);
        assert!(off < 0.5, "{}: {off}", it.name);
        let is_sky = |y: usize, x: usize| it.sky[[2 * y, 2 * x]] > 0.0;
        let [foreground, sky] = painted(&photograph, &out, is_sky).map(Painted::part);
        assert!(foreground < 1e-3, "{}: {foreground}", it.name);
        assert!(sky > 0.3, "{}: {sky}", it.name);
    }
}

#[test]
fn bows_in_plates_stand_where_they_are_wanted_and_before_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (seed, apex) in [(2, [150.0, 24.0]), (10, [90.0, 30.0])] {
        let file = folder.path().join(format!("{seed}.jpg"));
        let truth = plate(seed, SIZE);
        let photograph = truth.through_jpeg(&file);
        let out = folder.path().join(format!("out-{seed}"));
        let at = format!("{},{}", apex[0], apex[1]);
        photo(0, &file, &out, &["--apex", &at, "--fov-deg", "60"]);
        let off = off_deg(&out, apex);
        assert!(off < 0.5, "{seed}: {off}");
        // The sky says how far the camera looks up at least: hills may stand before the rest.
        let scene = std::fs::read_to_string(out.join("photo.toml")).unwrap();
        let scene: toml::Table = scene.parse().unwrap();
        let found_deg = scene["camera"]["elevation_deg"].as_float().unwrap();
        let up = (horizon(seed) - 0.5) * SIZE[1] as f64;
        let true_deg = (up / 120.0 * 30_f64.to_radians().tan()).atan().to_degrees();
        assert!(found_deg < true_deg + 0.3, "{seed}: {found_deg} {true_deg}");
        // The photograph is named from where the scene lies.
        let named = format!("../{seed}.jpg");
        assert_eq!(scene["photo"]["picture"].as_str(), Some(named.as_str()));
        let [foreground, sky] = painted(&photograph, &out, |y, x| truth.sky[[y, x]] > 0.0);
        assert_eq!(foreground.n_painted, 0, "{seed}");
        assert!(sky.part() > 0.9, "{seed}: {sky:?}");
    }
}

#[test]
fn points_that_no_bow_meets_give_the_nearest_one_with_its_misfit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.jpg");
    plate(2, SIZE).through_jpeg(&file);
    let run = |points: &[&str]| {
        let out = folder.path().join(format!("out-{}", points.join("-")));
        let points = points.iter().flat_map(|point| ["--bow", point]);
        let flags: Vec<&str> = points.chain(["--fov-deg", "60"]).collect();
        photo(0, &file, &out, &flags)
    };
    // Two points of a bow always have one; three too steep ones have none.
    assert!(run(&["60,40", "150,30"]).contains("misses the points by 0.00 degrees"));
    let off = run(&["40,75", "120,10", "200,75"]);
    let misfit = off.split("misses the points by ").nth(1).unwrap();
    let misfit: f64 = misfit.split(' ').next().unwrap().parse().unwrap();
    assert!(misfit > 0.5, "{off}");
}

#[test]
fn what_cannot_be_is_refused_with_its_code_and_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let room = folder.path().join("room.jpg");
    without_sky(4, [480, 320]).through_jpeg(&room);
    let wanted = ["--apex", "120,30"];
    assert!(photo(2, &room, &out, &wanted).contains("--fov-deg"));
    let flags = ["--apex", "240,40", "--fov-deg", "60"];
    let told = photo(4, &room, &out, &["--sun=180,20", "--fov-deg=60"]);
    assert!(told.contains("no sky") && told.contains("--sky"), "{told}");
    assert!(
        told.contains("sky.png") && out.join("sky.png").exists(),
        "{told}"
    );
    assert!(
        !out.join("photo.toml").exists(),
        "a mask to be corrected, and no more"
    );
    // Nobody corrected it: another photograph of this folder may have its own.
    let mask = std::fs::read(out.join("sky.png")).unwrap();
    let other = folder.path().join("other.jpg");
    plate(2, SIZE).through_jpeg(&other);
    photo(0, &other, &out, &["--apex=150,24", "--fov-deg=60"]);
    assert!(std::fs::read(out.join("sky.png")).unwrap() != mask);
    let out = folder.path().join("nothing");
    // The top of a bow in rain stands at most 40.9 degrees high.
    let high = [&flags[..], &["--elevation-deg", "40"]].concat();
    let open = folder.path().join("open.jpg");
    plate(2, SIZE).through_jpeg(&open);
    assert!(photo(4, &open, &out, &high).contains("expected at most 40.9"));
    let outside = photo(2, &open, &out, &["--apex", "240,400", "--fov-deg", "60"]);
    assert!(outside.contains("--apex 240,400 is outside"), "{outside}");
    photo(2, &room, &out, &["--fov-deg", "60"]);
    photo(2, &room, &out, &["--bow", "10,20", "--fov-deg", "60"]);
    photo(2, &room, &out, &[&flags[..], &["--rain", "-1"]].concat());
    photo(3, &folder.path().join("none.jpg"), &out, &flags);
    // With a mask the ceiling is a sky.
    let mask = folder.path().join("mask.png");
    let ceiling = Array2::from_shape_fn((320, 480), |(y, _)| u8::from(y < 60));
    write_labels(&ceiling, 2, File::create(&mask).unwrap()).unwrap();
    let out = folder.path().join("ceiling");
    let told = photo(
        0,
        &room,
        &out,
        &[&flags[..], &["--sky", text(&mask)]].concat(),
    );
    assert!(told.contains("mask.png"), "{told}");
    let photograph = Photograph::read(&room).unwrap();
    let parts = painted(&photograph, &out, |y, x| ceiling[[y, x]] == 1);
    let [below, above] = parts.map(Painted::part);
    assert!(below <= 0.0 && above > 0.9, "{below} {above}");
}

#[test]
fn what_is_read_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let light = plate(2, SIZE).light;
    let flags = ["--apex", "150,24", "--fov-deg", "60"];
    for name in ["composite.png", "sky.png", "image.png"] {
        let out = folder.path().join(name.replace('.', "-"));
        std::fs::create_dir(&out).unwrap();
        let own = out.join(name);
        write_png(&light, &Provenance::default(), File::create(&own).unwrap()).unwrap();
        let before = std::fs::read(&own).unwrap();
        for force in [&[][..], &["--force"]] {
            let told = photo(2, &own, &out, &[&flags[..], force].concat());
            assert!(told.contains(name), "{told}");
        }
        assert_eq!(std::fs::read(&own).unwrap(), before);
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1, "nothing made");
        // A stage by itself, before it looks at its other inputs.
        let own = text(&own);
        let over = ["composite", own, "--image", own, "-o", own, "--force"];
        niji_ends_with(2, &over);
        assert_eq!(std::fs::read(own).unwrap(), before);
    }
}

#[test]
fn a_mask_that_was_corrected_in_place_is_taken_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.jpg");
    let truth = plate(2, SIZE);
    truth.through_jpeg(&file);
    let out = folder.path().join("out");
    let flags = ["--apex", "150,24", "--fov-deg", "60"];
    std::fs::create_dir(&out).unwrap();
    let mask = out.join("sky.png");
    let corrected = Array2::from_shape_fn((80, 120), |(y, x)| {
        u8::from(truth.sky[[2 * y, 2 * x]] > 0.5)
    });
    write_labels(&corrected, 2, File::create(&mask).unwrap()).unwrap();
    let before = std::fs::read(&mask).unwrap();
    photo(
        0,
        &file,
        &out,
        &[&flags[..], &["--sky", text(&mask)]].concat(),
    );
    assert_eq!(std::fs::read(&mask).unwrap(), before);
}

#[test]
fn a_bow_of_which_nothing_is_seen_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.jpg");
    plate(2, SIZE).through_jpeg(&file);
    let mask = |name: &str, is_sky: &dyn Fn(usize, usize) -> bool| {
        let path = folder.path().join(name);
        let labels = Array2::from_shape_fn((SIZE[1], SIZE[0]), |(y, x)| u8::from(is_sky(y, x)));
        write_labels(&labels, 2, File::create(&path).unwrap()).unwrap();
        text(&path).to_owned()
    };
    let out = folder.path().join("out");
    let refused = |flags: &[&str]| {
        let told = photo(4, &file, &out, &[flags, &["--fov-deg", "60"]].concat());
        assert!(told.contains("--sky MASK.png"), "{told}");
        assert!(!out.exists(), "nothing was written");
    };
    // What stands there is no sky, whether that was found or said.
    refused(&["--apex", "120,150"]);
    let corner = mask("corner.png", &|y, x| y < 20 && x < 20);
    refused(&["--apex", "150,24", "--sky", &corner]);
    let sun = ["--sun", "180,20", "--elevation-deg", "10"];
    refused(&[&sun[..], &["--sky", &corner]].concat());
    // Below the horizon there is no bow, even in a picture of nothing but sky.
    let all = mask("all.png", &|_, _| true);
    refused(&["--apex", "120,120", "--elevation-deg", "0", "--sky", &all]);
}

#[test]
fn a_photograph_of_nothing_but_sky_gets_a_bow_and_numbers_that_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.jpg");
    plate(2, SIZE).through_jpeg(&file);
    let mask = folder.path().join("all.png");
    let all = Array2::from_elem((SIZE[1], SIZE[0]), 1);
    write_labels(&all, 2, File::create(&mask).unwrap()).unwrap();
    let out = folder.path().join("out");
    let flags = ["--apex", "120,24", "--fov-deg", "60", "--sky", text(&mask)];
    let told = photo(0, &file, &out, &flags);
    let scene = std::fs::read_to_string(out.join("photo.toml")).unwrap();
    for said in [told, scene] {
        let is_digit = |it: char| it.is_ascii_digit();
        let longest = said.split(|it| !is_digit(it)).map(str::len).max();
        assert!(longest < Some(15), "{said}");
    }
}

#[test]
fn a_time_that_is_none_is_told_by_its_flag_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.jpg");
    plate(2, SIZE).through_jpeg(&file);
    let out = folder.path().join("out");
    for time in ["2026-06-31T19:30:00+02:00", "yesterday"] {
        let flags = ["--place", "48,11", "--time", time, "--fov-deg", "60"];
        let told = photo(2, &file, &out, &flags);
        assert!(
            told.contains("--time") && !told.contains("date_time"),
            "{told}"
        );
        assert!(!out.exists(), "nothing was written");
    }
}
