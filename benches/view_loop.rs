//! How long a person waits who works on a scene: from a change to what `niji view` shows of it.
//!
//! Rain with air and a sky of all orders, 640 x 360 pixels, 41 wavelengths. For changes of the sun, the drops' sizes and
//! the camera: seconds to the first picture and to the picture of `niji run`, and the error of what is shown within
//! a second, against that picture, RMS of luminance over display white; and a cold `niji run` of the same scene.
//!
//!     cargo bench --bench view_loop -- [ROUNDS]

use std::fs;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;
use serde_json::json;

#[path = "../tests/support/view.rs"]
mod view;

use view::View;

const SCENE: &str = include_str!("../data/scenes/rain-5-mm-h-flattened.toml");
const SECOND: f64 = 1.0;
/// Luminance of linear Rec.709.
const Y: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A picture that was shown, and when.
struct Shown {
    seconds: f64,
    size: [usize; 2],
    pixels: Vec<f32>,
    is_finished: bool,
}

impl Shown {
    /// Luminance at a place in parts of the frame, of the nearest pixel.
    fn at(&self, right: f64, down: f64) -> f64 {
        let [width, height] = self.size;
        let [x, y] = [right * width as f64, down * height as f64].map(|it| it as usize);
        let pixel = 3 * (y * width + x);
        let light = self.pixels[pixel..pixel + 3].iter();
        light
            .zip(Y)
            .map(|(light, weight)| f64::from(*light) * weight)
            .sum()
    }

    /// RMS over the pixels of another picture, which is of display white 1.
    fn error(&self, of: &Self) -> f64 {
        let [width, height] = of.size;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let squares = places.map(|(x, y)| {
            let right = (x as f64 + 0.5) / width as f64;
            let down = (y as f64 + 0.5) / height as f64;
            (self.at(right, down) - of.at(right, down)).powi(2)
        });
        (squares.sum::<f64>() / (width * height) as f64).sqrt()
    }
}

/// Sets a value and follows what is shown until the picture is finished.
fn change(view: &View, key: &str, value: &Value) -> Vec<Shown> {
    let start = Instant::now();
    let (status, told) = view.set(key, value);
    assert_eq!(status, 200, "{told}");
    let (mut after, mut shown) = (0, Vec::<Shown>::new());
    let mut last = 0;
    loop {
        let news = view.json(&format!("news?after={after}"));
        after = news["event"].as_u64().unwrap_or(0);
        let picture = &news["picture"];
        let number = picture["number"].as_u64().unwrap_or(0);
        if picture["revision"] != told["revision"] || number == last {
            continue;
        }
        last = number;
        let (status, bytes) = view.get(&format!("pixels?picture={number}"));
        if status != 200 {
            continue;
        }
        let (values, _) = bytes.as_chunks::<4>();
        let side = |index: usize| picture["size"][index].as_u64().unwrap_or(0) as usize;
        shown.push(Shown {
            seconds: start.elapsed().as_secs_f64(),
            size: [side(0), side(1)],
            pixels: values.iter().map(|it| f32::from_le_bytes(*it)).collect(),
            is_finished: picture["is_finished"] == true,
        });
        if shown.last().is_some_and(|it| it.is_finished) {
            return shown;
        }
    }
}

fn main() {
    let n_rounds = std::env::args().skip(1).find_map(|it| it.parse().ok());
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("rain.toml");
    let text = SCENE
        .replace("width_px = 480", "width_px = 640")
        .replace("height_px = 320", "height_px = 360");
    fs::write(&scene, &text).expect("the folder can be written");
    let start = Instant::now();
    let run = Command::new(env!("CARGO_BIN_EXE_niji"))
        .arg("run")
        .arg(&scene)
        .arg("-q")
        .arg("-o")
        .arg(folder.path().join("out"))
        .output();
    assert!(run.is_ok_and(|it| it.status.success()), "a run");
    let cold_s = start.elapsed().as_secs_f64();
    println!("niji run, cold: {cold_s:.2} s");

    let exposure_ev = 1.0_f64;
    let view = View::of(&scene);
    view.picture();
    println!("change                       first s  within 1 s: error %  standard s  of cold");
    for round in 0..n_rounds.unwrap_or(3) {
        let step = f64::from(round);
        for (key, value) in [
            ("sun.elevation_deg", json!(21.0 + step)),
            ("sun.azimuth_deg", json!(181.0 + step)),
            ("camera.azimuth_deg", json!(1.0 + step)),
            (
                "drops.law.marshall-palmer.rain_rate_mm_h",
                json!(6.0 + step),
            ),
        ] {
            let shown = change(&view, key, &value);
            let last = &shown[shown.len() - 1];
            let within = shown.iter().rfind(|it| it.seconds <= SECOND);
            let error = within.map(|it| 100.0 * it.error(last) * exposure_ev.exp2());
            println!(
                "{key:<42.42} {:>6.2} {:>10} {:>14.2} {:>8.2}",
                shown[0].seconds,
                error.map_or("none".to_owned(), |it| format!("{it:.2}")),
                last.seconds,
                last.seconds / cold_s
            );
        }
    }
    let start = Instant::now();
    view.set("picture.exposure_ev", &json!(1.5));
    println!(
        "picture.exposure_ev: {:.3} s in the program, no ray",
        start.elapsed().as_secs_f64()
    );
}
