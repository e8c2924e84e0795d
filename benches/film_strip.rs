//! A sequence as a film strip: a plume that grows from nothing, a sun that rises and a camera that moves, each frame
//! beside the same frame at a quarter of the tolerance with every effect on.
//!
//!     cargo bench --bench film_strip -- [FRAMES] [FOLDER] [density|drops]
//!
//! Prints, in percent, how far the mean luminance of each frame is from that of its reference, the same of the change
//! since the frame before, and of that change pixel by pixel (RMS over display white), in which an effect would show
//! that comes or goes. (Light that drops scatter more than once has the same noise in both until the reference follows
//! more paths.) First of a density with one size of drops, then of drops that are largest and smallest between the
//! frames that are looked at in any case. The strips are `density.png` and `drops.png` in FOLDER, `target/film_strip` where it is left
//! out. Ends with a message where a mean or its change is off by more than 0.2 %.

#[path = "../tests/support/film.rs"]
mod film;
#[path = "../tests/support/plume.rs"]
mod plume;
#[path = "../tests/support/mod.rs"]
mod support;

use std::fs;
use std::fs::File;
use std::io::BufReader;
use std::io::BufWriter;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::Provenance;
use niji_exchange::write_srgb_png;
use niji_scene::Effect;

use film::Beside;
use film::Film;
use film::Volumes;

/// Frames beside each other in a strip.
const COLUMNS: usize = 8;
/// Tolerance of the references; light of further orders takes 16 times as long as by the usual one.
const FINEST: f64 = 2.5e-3;
/// Largest error of a mean luminance, or of its change, over that of its reference.
const ALLOWED: f64 = 2e-3;

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|it| it != "--bench")
        .collect();
    let n_frames = arguments.first();
    let n_frames = n_frames.map_or(48, |it| it.parse().expect("a whole number"));
    let ours = || Path::new(env!("CARGO_MANIFEST_DIR")).join("target/film_strip");
    let folder = arguments.get(1).map_or_else(ours, PathBuf::from);
    fs::create_dir_all(&folder).expect("a folder can be made");
    let wanted = arguments.get(2).map_or("", String::as_str);
    for volumes in [Volumes::Density, Volumes::Drops] {
        if volumes.name().contains(wanted) {
            let film = Film {
                volumes,
                folder: &folder,
                n_frames,
                size_px: [128, 72],
                finest: FINEST,
            };
            show(&film);
        }
    }
}

/// Makes a film, tells how far it is off, and puts its frames beside each other.
fn show(film: &Film) {
    let beside = film.beside_references();
    let choice = film.choice();
    let on: Vec<&str> = choice.plan.effects_on().map(Effect::name).collect();
    println!("{}: {}", film.volumes.name(), on.join(" "));
    println!("frames looked at: {:?}", choice.frames);
    let [frame, mean, off, change, pixels] = ["frame", "cd/m2", "mean %", "change %", "pixels %"];
    println!("{frame:>5} {mean:>9} {off:>9} {change:>9} {pixels:>9}");
    for it in &beside {
        let [off, change, pixels] = percent(it);
        let (frame, mean) = (it.frame, it.mean_cd_m2);
        println!("{frame:>5} {mean:>9.1} {off:>9.4} {change:>9.4} {pixels:>9.4}");
    }
    let worst = |index: usize| {
        beside
            .iter()
            .map(|it| percent(it)[index].abs())
            .fold(0.0, f64::max)
    };
    let (off, change, pixels) = (worst(0), worst(1), worst(2));
    println!(
        "{:>5} {:>9} {off:>9.4} {change:>9.4} {pixels:>9.4}",
        "worst", ""
    );
    println!("{}", strip(film).display());
    let most = 100.0 * ALLOWED;
    assert!(
        off <= most && change <= most,
        "found {off:.3} and {change:.3} %, expected at most {most} %"
    );
}

fn percent(beside: &Beside) -> [f64; 3] {
    [beside.off, beside.change_off, beside.pixels_off].map(|it| 100.0 * it)
}

/// Writes the previews beside each other.
fn strip(film: &Film) -> PathBuf {
    let ([width, height], n_frames) = (film.size_px, film.n_frames as usize);
    let (line, rows) = (3 * COLUMNS * width, n_frames.div_ceil(COLUMNS));
    let mut strip = vec![0; line * rows * height];
    for index in 0..n_frames {
        let path = film.made().join(format!("image.{:04}.png", index + 1));
        let file = BufReader::new(File::open(path).expect("a preview"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
        let mut codes = vec![0; 3 * width * height];
        reader.next_frame(&mut codes).expect("8-bit RGB");
        let corner = index / COLUMNS * height * line + index % COLUMNS * 3 * width;
        for (y, row) in codes.chunks(3 * width).enumerate() {
            let start = corner + y * line;
            strip[start..start + row.len()].copy_from_slice(row);
        }
    }
    let path = film.folder.join(format!("{}.png", film.volumes.name()));
    let file = BufWriter::new(File::create(&path).expect("a file can be made"));
    let size_px = [COLUMNS * width, rows * height];
    write_srgb_png(&strip, size_px, &Provenance::default(), file).expect("a PNG");
    path
}
