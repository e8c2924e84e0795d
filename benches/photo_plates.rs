//! `niji photo` on photographs whose sky is known: the shipped one cropped, turned and darkened, and plates by seed.
//!
//!     cargo bench --bench photo_plates -- [FIRST-LAST] [FOLDER]
//!
//! Prints of each: pixels at which the sky is right, how far the bow is off at the point that was asked for, pixels of
//! the foreground that are painted over (beyond the soft edge of two pixels), and how far the horizon that was taken for
//! true is off. Leaves composites, and what the masks got wrong (`*.mask.png`, sky that is
//! none red, sky that was missed yellow), in FOLDER, `target/photo_plates` where it is left out. Ends with a message where
//! a bow is off by more than half a degree. How a sky is found was fitted on photographs and on seeds 1 to 10.

#[path = "../tests/support/bow_in_photo.rs"]
mod bow_in_photo;
#[allow(dead_code, unreachable_pub, reason = "others use the rest")]
#[path = "../tests/support/pavilion.rs"]
mod pavilion;
#[path = "../tests/support/plates.rs"]
mod plates;
#[path = "../tests/support/mod.rs"]
mod support;

use std::fs;
use std::fs::File;
use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use niji_exchange::Provenance;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::read_labels;
use niji_photo::write_jpeg;
use niji_photo::write_png;

use bow_in_photo::off_deg;
use bow_in_photo::painted;
use bow_in_photo::pavilion_changed;
use bow_in_photo::photo;
use plates::agreement;
use plates::horizon;
use plates::plate;

/// Size of the plates, and what they and the photograph see.
const SIZE: [usize; 2] = [480, 320];
const FOV_DEG: f64 = 60.0;
/// Top of the bow in the shipped photograph.
const APEX: [f64; 2] = [400.0, 45.0];
/// What is asked for.
const MOST_OFF_DEG: f64 = 0.5;
const LEAST_RIGHT: f64 = 0.97;

/// A photograph, its sky, and the bow that it gets.
struct Known {
    name: String,
    light: LinearPicture,
    sky: Array2<f32>,
    apex: [f64; 2],
    /// How far up its camera looks, where that is known and not said.
    up_deg: Option<f64>,
    flags: Vec<String>,
}

fn main() {
    // Cargo adds `--bench`.
    let mut arguments = std::env::args().skip(1).filter(|it| it != "--bench");
    let seeds = arguments.next().unwrap_or_else(|| "11-30".to_owned());
    let (first, last) = seeds.split_once('-').expect("seeds as 11-30");
    let seeds = first.parse().expect("a seed")..=last.parse::<u64>().expect("a seed");
    let ours = || Path::new(env!("CARGO_MANIFEST_DIR")).join("target/photo_plates");
    let folder = arguments.next().map_or_else(ours, PathBuf::from);
    fs::create_dir_all(&folder).expect("a folder can be made");
    println!("              sky right  bow off  painted  horizon off");
    let photographs = pavilion_changed(1).into_iter().map(of_pavilion);
    let outcomes = photographs.chain(seeds.map(of_seed));
    let outcomes: Vec<(String, f64, f64)> = outcomes.map(|it| with_bow(&it, &folder)).collect();
    let worst = outcomes.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let (name, right, _) = worst.expect("there is a photograph");
    println!("worst mask: {name}, {:.2} %", 100.0 * right);
    let n_right = outcomes.iter().filter(|it| it.1 >= LEAST_RIGHT).count();
    println!("right on 97 % and more: {n_right} of {}", outcomes.len());
    for (name, _, off) in &outcomes {
        assert!(
            *off <= MOST_OFF_DEG,
            "{name}: the bow is off by {off} degrees"
        );
    }
}

fn of_pavilion(changed: pavilion::Changed) -> Known {
    // A cropped picture sees less.
    let part = changed.light.ncols() as f64 / 640.0;
    let half = (part * (0.5 * FOV_DEG).to_radians().tan()).atan();
    Known {
        name: changed.name.to_owned(),
        apex: (changed.moved)(APEX),
        up_deg: None,
        flags: vec![
            format!("--fov-deg={}", 2.0 * half.to_degrees()),
            format!("--roll-deg={}", changed.roll_deg),
        ],
        light: changed.light,
        sky: changed.sky,
    }
}

/// A plate with the top of its bow in the free column that is nearest to its middle.
fn of_seed(seed: u64) -> Known {
    let plate = plate(seed, SIZE);
    let [width, height] = SIZE;
    let is_free = |x: &usize| (0..height / 4).all(|y| plate.sky[[y, *x]] > 0.0);
    let middle = width / 2;
    let free = (2..width - 2).filter(is_free);
    // The horizon below the middle, over the distance of the picture plane.
    let up = (horizon(seed) - 0.5) * 2.0 * height as f64 / width as f64;
    let up = up * (0.5 * FOV_DEG).to_radians().tan();
    let x = free.min_by_key(|x| x.abs_diff(middle)).unwrap_or(middle);
    Known {
        name: format!("plate-{seed}"),
        apex: [x as f64 + 0.5, 0.15 * height as f64],
        up_deg: Some(up.atan().to_degrees()),
        flags: vec![format!("--fov-deg={FOV_DEG}")],
        light: plate.light,
        sky: plate.sky,
    }
}

/// Sets the bow, tells of it, and gives the name, part of the mask that is right, and how far the bow is off.
fn with_bow(known: &Known, folder: &Path) -> (String, f64, f64) {
    let name = &known.name;
    let file = folder.join(format!("{name}.jpg"));
    write_jpeg(&known.light, File::create(&file).expect("a new file")).expect("a JPEG");
    let photograph = Photograph::read(&file).expect("what was written");
    let out = folder.join(name);
    let apex = format!("--apex={},{}", known.apex[0], known.apex[1]);
    let flags = known.flags.iter().map(String::as_str);
    let flags: Vec<&str> = flags.chain([apex.as_str(), "--force"]).collect();
    photo(0, &file, &out, &flags);
    let mask = read_labels(&out.join("sky.png"), 2).expect("a mask");
    let mask = mask.mapv(|label| label == 1);
    let right = agreement(&mask, &known.sky);
    let off = off_deg(&out, known.apex);
    let [foreground, _] = painted(&photograph, &out, |y, x| known.sky[[y, x]] > 0.0);
    let scene = fs::read_to_string(out.join("photo.toml")).expect("a scene");
    let scene: toml::Table = scene.parse().expect("TOML");
    let found_deg = scene["camera"]["elevation_deg"].as_float();
    let found_deg = found_deg.expect("a number");
    let horizon = known.up_deg.map_or_else(String::new, |up_deg| {
        format!("{:>6.2}° of {up_deg:.1}°", found_deg - up_deg)
    });
    println!(
        "{name:<12} {:>8.2} %  {off:>6.2}°  {:>7}  {horizon}",
        100.0 * right,
        foreground.n_painted,
    );
    let shown = Array2::from_shape_fn(known.light.dim(), |at| {
        match (mask[at], known.sky[at] > 0.5) {
            (true, false) => [1.0, 0.0, 0.0],
            (false, true) => [1.0, 1.0, 0.0],
            (true, true) | (false, false) => photograph.light[at],
        }
    });
    let shown_in = File::create(folder.join(format!("{name}.mask.png"))).expect("a new file");
    write_png(&shown, &Provenance::default(), shown_in).expect("a PNG");
    (name.clone(), right, off)
}
