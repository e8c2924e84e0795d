//! `niji photo`: a bow set into a photograph with one command.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "support/plates.rs"]
mod plates;
mod support;

use std::path::Path;

use niji_exchange::SpectralImage;
use niji_geometry::Camera;
use niji_photo::Photograph;
use niji_photo::read_labels;
use niji_photo::write_labels;
use niji_scene::Scene;
use plates::plate;
use plates::without_sky;
use support::niji_ends_with;
use support::repository;
use support::text;

const SIZE: [usize; 2] = [240, 160];

/// Runs `niji photo` on a photograph that sees 60 degrees and tells what it said.
fn photo(code: i32, photograph: &Path, out: &Path, flags: &[&str]) -> String {
    let fixed = [
        "photo",
        text(photograph),
        "-o",
        text(out),
        "--accuracy",
        "draft",
    ];
    let output = niji_ends_with(code, &[&fixed[..], flags].concat());
    String::from_utf8(output.stderr).unwrap()
}

/// Angle between a point of the photograph and the brightest of the rendered bow straight above or below it.
fn off_deg(out: &Path, [x, y]: [f64; 2]) -> f64 {
    let scene = std::fs::read_to_string(out.join("photo.toml")).unwrap();
    let camera: Camera = Scene::from_toml(&scene).unwrap().camera.camera().unwrap();
    let image = SpectralImage::read_spectral(&out.join("image.exr")).unwrap();
    let bow = image
        .aovs
        .iter()
        .find(|aov| aov.name == "bow.primary")
        .unwrap();
    let luminance = &bow.channels[1].1;
    let column = luminance.column(x as usize);
    let brightest = column
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .unwrap();
    assert!(*brightest.1 > 0.0, "there is a bow");
    let view = |y: f64| camera.ray(x, y).unwrap().direction;
    let off = view(brightest.0 as f64 + 0.5).angle_between(view(y));
    off.to_degrees()
}

/// Part of the pixels where a composite is another than the photograph: of those that are foreground beyond the soft
/// edge of two pixels, and of the sky.
fn changed(photograph: &Photograph, out: &Path, is_sky: impl Fn(usize, usize) -> bool) -> [f64; 2] {
    let composite = Photograph::read(&out.join("composite.png")).unwrap();
    let (height, width) = photograph.light.dim();
    let mut counts = [[0.0; 2]; 2];
    for y in 2..height - 2 {
        for x in 2..width - 2 {
            let near = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| (y, x)));
            let n_sky = near.filter(|(y, x)| is_sky(*y, *x)).count();
            let count = match n_sky {
                0 => &mut counts[0],
                25 => &mut counts[1],
                _ => continue,
            };
            count[0] += f64::from(u8::from(
                composite.light[[y, x]] != photograph.light[[y, x]],
            ));
            count[1] += 1.0;
        }
    }
    counts.map(|[n_changed, n]| n_changed / n)
}

#[test]
fn the_shipped_photograph_has_a_bow_through_its_apex_with_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let pavilion = repository("data/photos/pavilion.jpg");
    let flags = ["--apex", "400,45", "--fov-deg", "60"];
    let told = photo(0, &pavilion, &out, &flags);
    for word in ["confidence", "level", "24.1 degrees high", "mm/h"] {
        assert!(told.contains(word), "{word}: {told}");
    }
    let off = off_deg(&out, [400.0, 45.0]);
    assert!(off < 0.5, "{off}");
    let labels = read_labels(&repository("data/photos/pavilion.labels.png"), 29).unwrap();
    let photograph = Photograph::read(&pavilion).unwrap();
    // The far shore and the lake go over into the sky without an edge; pavilion and trees do not.
    let is_clear = |y: usize, x: usize| labels[[y, x]] < 25;
    let [foreground, sky] = changed(&photograph, &out, is_clear);
    assert!(foreground < 1e-3, "{foreground}");
    assert!(sky > 0.3, "{sky}");
    // Again there is nothing to do; what somebody edited stays, and a run goes on with it.
    assert!(photo(0, &pavilion, &out, &flags).contains("everything is up to date"));
    let scene = out.join("photo.toml");
    let edited = std::fs::read_to_string(&scene).unwrap() + "# mine\n";
    std::fs::write(&scene, edited).unwrap();
    assert!(photo(2, &pavilion, &out, &flags).contains("--force"));
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
        let [foreground, sky] = changed(&photograph, &out, |y, x| truth.sky[[y, x]] > 0.0);
        assert!(foreground <= 0.0, "{seed}: {foreground}");
        assert!(sky > 0.9, "{seed}: {sky}");
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
    let told = photo(4, &room, &out, &flags);
    assert!(told.contains("no sky") && told.contains("--sky"), "{told}");
    assert!(!out.exists(), "nothing was written");
    // The top of a bow in rain stands at most 40.9 degrees high.
    let high = [&flags[..], &["--elevation-deg", "40"]].concat();
    assert!(photo(4, &room, &out, &high).contains("expected at most 40.9"));
    photo(2, &room, &out, &["--fov-deg", "60"]);
    photo(2, &room, &out, &["--bow", "10,20", "--fov-deg", "60"]);
    photo(2, &room, &out, &[&flags[..], &["--rain", "-1"]].concat());
    photo(3, &folder.path().join("none.jpg"), &out, &flags);
    // With a mask the ceiling is a sky.
    let mask = folder.path().join("mask.png");
    let ceiling = ndarray::Array2::from_shape_fn((320, 480), |(y, _)| u8::from(y < 60));
    write_labels(&ceiling, 2, std::fs::File::create(&mask).unwrap()).unwrap();
    let told = photo(
        0,
        &room,
        &out,
        &[&flags[..], &["--sky", text(&mask)]].concat(),
    );
    assert!(told.contains("mask.png"), "{told}");
    let photograph = Photograph::read(&room).unwrap();
    let [below, above] = changed(&photograph, &out, |y, x| ceiling[[y, x]] == 1);
    assert!(below <= 0.0 && above > 0.9, "{below} {above}");
}
