//! A frame is the mean over the time its shutter is open: camera, sun and drops move, whoever makes it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use niji_exchange::FrameTime;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
use niji_picture::Error;
use niji_picture::PictureParts;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::SequenceChoice;
use niji_picture::SequenceRequest;
use niji_picture::unwatched;
use niji_scene::BoundKind;
use niji_scene::Effect;
use niji_scene::Scene;
use niji_scene::Sequence;
use support::niji;
use support::niji_ends_with;
use support::text;

/// A shower in the sun, a few hundred metres away, in few pixels and wavelengths.
const SCENE: &str = r#"format = 1
name = "shower"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 15.0
horizontal_fov_deg = 60.0
width_px = 48
height_px = 32
[spectrum]
first_nm = 450.0
step_nm = 60.0
n_wavelengths = 4
[picture]
exposure_ev = 5.0
[effects]
multiple_scattering = "off"
drop_flattening = "off"
[accuracy]
table_relative_error = 0.05
theory = "airy"
integration = "cell-exact"
pixel_footprint = "center"
[drops]
shape = "rain-shaft"
rain_rate_mm_h = 10.0
footprint = { box = { width_x_m = 400.0, width_z_m = 200.0 } }
center_xz_m = [0.0, -400.0]
base_y_m = 0.0
top_y_m = 300.0
edge_m = 40.0
voxel_m = 25.0
[sequence]
"#;

/// A camera that pans by two degrees a frame, and stands before and after.
const PAN: &str = "camera.azimuth_deg = [[1, -4.0], [5, 4.0]]\n";
const OPEN: &str = "shutter_deg = 180\n";

/// A sequence, decided.
struct Film {
    sequence: Sequence,
    choice: SequenceChoice,
}

fn read(sequence: &Sequence, number: u32, after: f64) -> Result<Scene, Error> {
    Ok(Scene::from_toml(
        &sequence.scene_text_beside(number, after),
    )?)
}

impl Film {
    fn new(keys: &str) -> Self {
        let sequence = Sequence::from_toml(&format!("{SCENE}{keys}"))
            .unwrap()
            .unwrap();
        let frames = [1, 3, 5].map(|it| (it, read(&sequence, it, 0.0).unwrap()));
        let request = SequenceRequest {
            plan: PlanRequest::default(),
            settings: "",
            frames: &frames,
            shutter: sequence.shutter,
            beside: &|number, after| read(&sequence, number, after),
        };
        let choice = request.decide(&frames).unwrap();
        Self { sequence, choice }
    }

    fn is_on(&self) -> bool {
        self.choice.plan.is_on(Effect::MotionBlur)
    }

    /// A frame so many frames later, at the instants.
    fn planned(&self, (number, after): (u32, f64), instants: &[f64]) -> PlannedScene {
        let time = FrameTime {
            frame: number,
            frames_per_second: 24.0,
        };
        let scene = |after: f64| read(&self.sequence, number, after).unwrap();
        let instants = instants.iter().map(|it| scene(*it)).collect();
        PlannedScene::of_frame((scene(after), time, instants), Path::new(""), &self.choice)
    }

    fn blurred(&self, number: u32) -> SpectralImage {
        let instants = self.choice.instants(self.sequence.shutter);
        self.planned((number, 0.0), &instants)
            .picture(&unwatched)
            .unwrap()
    }

    /// Luminance of the mean of many stills, each lit and laid out by itself.
    fn of_stills(&self, number: u32, n_stills: u32) -> Array2<f64> {
        let mut sum = Array2::zeros((0, 0));
        let mut table = None;
        for after in self.sequence.shutter.instants(n_stills) {
            let planned = self.planned((number, after), &[]);
            let table = table.get_or_insert_with(|| {
                let airy = planned.airy().unwrap();
                planned.scattering(airy.as_ref(), &unwatched).unwrap()
            });
            let parts = PictureParts {
                drops: planned.drops().unwrap(),
                table: table.clone(),
                air: planned.air(&unwatched).unwrap(),
                surfaces: None,
            };
            let settings = PictureSettings::of(&planned);
            let whole = settings.whole().unwrap();
            let work = PictureWork::new(settings, parts, &unwatched).unwrap();
            let light = light(&work.render(whole, &unwatched).unwrap());
            sum = if sum.is_empty() { light } else { sum + light };
        }
        sum / f64::from(n_stills)
    }
}

fn light(image: &SpectralImage) -> Array2<f64> {
    luminance(&image.radiance, &image.wavelengths)
}

fn rms(values: &Array2<f64>) -> f64 {
    (values.mapv(|it| it * it).sum() / values.len() as f64).sqrt()
}

/// What is told of the instants, pixel by pixel.
fn motion(image: &SpectralImage) -> Array2<f64> {
    let error = image.aovs.iter().find(|aov| aov.name == "error").unwrap();
    let motion = error
        .channels
        .iter()
        .find(|(name, _)| name == "motion")
        .unwrap();
    motion.1.mapv(f64::from)
}

/// Holds a frame against many stills: the mean is within the tolerance's part for motion and far nearer than the frame
/// at once, and what is told covers what it is off by.
fn hold(keys: &str, (number, n_stills): (u32, u32)) {
    let film = Film::new(&format!("{OPEN}{keys}"));
    assert!(film.is_on(), "{keys}");
    let white = film.planned((number, 0.0), &[]).plan.display_white_cd_m2;
    let blurred = film.blurred(number);
    let truth = film.of_stills(number, n_stills);
    let off = (light(&blurred) - &truth).mapv(f64::abs) / white;
    let at_once = light(
        &film
            .planned((number, 0.0), &[])
            .picture(&unwatched)
            .unwrap(),
    );
    let unblurred = rms(&(at_once - &truth)) / white;
    let told = motion(&blurred) / white;
    let (off_rms, told_rms) = (rms(&off), rms(&told));
    assert!(
        off_rms < 0.25 * unblurred,
        "{keys}: {off_rms:e}, at once {unblurred:e}"
    );
    assert!(
        2.0 * off_rms < told_rms && told_rms < 3.6e-3,
        "{keys}: {off_rms:e}, told {told_rms:e}"
    );
    // Of the pixels that count.
    let pairs = off.iter().zip(&told).filter(|(off, _)| **off > 1e-4);
    let (mut n, mut n_covered) = (0, 0);
    for (off, told) in pairs {
        n += 1;
        n_covered += usize::from(off <= told);
    }
    assert!(
        n > 50 && n_covered as f64 > 0.65 * f64::from(n),
        "{keys}: {n_covered} of {n}"
    );
}

#[test]
fn a_pan_is_the_mean_of_many_stills_and_tells_how_far_it_is_off() {
    hold(PAN, (2, 33));
}

#[test]
fn a_sun_that_moves_is_followed() {
    hold("sun.elevation_deg = [[1, 18.0], [5, 26.0]]\n", (3, 33));
}

#[test]
fn drops_that_move_are_laid_out_at_every_instant() {
    hold(
        "drops.center_xz_m = [[1, [-150.0, -400.0]], [5, [150.0, -400.0]]]\n",
        (4, 33),
    );
}

#[test]
fn what_does_not_move_has_no_blur_and_costs_no_picture_more() {
    let still = "camera.azimuth_deg = [[1, 2.0], [5, 2.0]]\n";
    let film = Film::new(&format!("{OPEN}{still}"));
    let bound = film.choice.plan.bound(Effect::MotionBlur).unwrap();
    assert!(!film.is_on() && bound.value == 0.0 && bound.kind == BoundKind::Measured);
    assert!(film.choice.instants(film.sequence.shutter).is_empty());
}

#[test]
fn a_frame_in_which_nothing_moves_is_one_picture_of_a_sequence_that_moves() {
    let film = Film::new(&format!("{OPEN}{PAN}"));
    let instants = film.choice.instants(film.sequence.shutter);
    let of = |number| PictureSettings::of(&film.planned((number, 0.0), &instants));
    // The camera stands from frame 5 on, and until the frame itself at 1.
    assert_eq!(of(6).n_pictures(), 1);
    assert_eq!(of(3).n_pictures(), instants.len() as u64);
    assert_eq!(of(1).n_pictures(), 1 + instants.len() as u64 / 2);
    let (blurred, at_once) = (
        film.blurred(6),
        film.planned((6, 0.0), &[]).picture(&unwatched),
    );
    assert!(blurred.radiance == at_once.unwrap().radiance);
    assert!(motion(&blurred).iter().all(|it| *it == 0.0));
}

fn scene_file(folder: &Path, keys: &str) -> PathBuf {
    let path = folder.join("shower.toml");
    fs::write(&path, format!("{SCENE}{keys}")).unwrap();
    path
}

fn run(scene: &Path, out: &Path, flags: &[&str]) {
    niji_ends_with(
        0,
        &[&["run", text(scene), "-o", text(out), "-q"], flags].concat(),
    );
}

fn image(out: &Path, number: u32) -> Vec<u8> {
    fs::read(out.join(format!("image.{number:04}.exr"))).unwrap()
}

#[test]
fn a_frame_has_the_same_bytes_alone_in_the_sequence_in_tiles_and_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_file(folder.path(), &format!("{OPEN}{PAN}"));
    let out = |name: &str| folder.path().join(name);
    run(&scene, &out("all"), &["--frames", "2-3"]);
    let left = fs::read_dir(out("all"))
        .unwrap()
        .map(|it| it.unwrap().file_name());
    assert!(
        !left
            .into_iter()
            .any(|it| it.to_string_lossy().ends_with(".parts"))
    );
    run(&scene, &out("alone"), &["--frames", "3"]);
    assert!(image(&out("alone"), 3) == image(&out("all"), 3));
    // In tiles, by what was decided elsewhere, as a farm does it.
    let choice = out("all").join("choice.toml");
    for tiles in ["1/3", "2-3/3"] {
        let flags = ["--frames", "3", "--tiles", tiles, "--choice", text(&choice)];
        run(&scene, &out("tiles"), &flags);
    }
    niji_ends_with(0, &["merge", text(&out("tiles")), "--frames", "3", "-q"]);
    assert!(image(&out("tiles"), 3) == image(&out("all"), 3));
}

#[test]
fn a_shutter_that_is_shut_changes_no_byte_and_one_by_one_stages_refuse_an_open_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    run(
        &scene_file(folder.path(), PAN),
        &out("without"),
        &["--frames", "2"],
    );
    let shut = scene_file(folder.path(), &format!("shutter_deg = 0\n{PAN}"));
    run(&shut, &out("shut"), &["--frames", "2"]);
    assert!(image(&out("shut"), 2) == image(&out("without"), 2));
    niji_ends_with(0, &["plan", text(&shut), "--script"]);
    let open = scene_file(folder.path(), &format!("{OPEN}{PAN}"));
    let refused = niji(&["plan", text(&open), "--script"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(
        message.contains("--frames") && message.contains("effects.motion_blur"),
        "{message}"
    );
    run(&open, &out("open"), &["--frames", "2"]);
    assert!(image(&out("open"), 2) != image(&out("without"), 2));
}
