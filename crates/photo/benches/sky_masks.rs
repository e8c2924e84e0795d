//! How well skies are found in a folder of pictures.
//!
//!     cargo bench -p niji-photo --bench sky_masks -- PICTURES [MASKS]
//!
//! Beside `NAME.jpg` a `NAME.sky.png` is white where the sky is; a picture without one has none. Prints of each: pixels
//! at which the sky is right, the confidence and the seconds, then a summary. Leaves what was found in MASKS.

use std::fs::File;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_photo::Photograph;
use niji_photo::SURE_OF_SKY;
use niji_photo::find_sky;
use niji_photo::read_labels;
use niji_photo::write_labels;

/// What was found of one picture; `right` where its sky is known.
struct Outcome {
    name: String,
    right: Option<f64>,
    is_sure: bool,
}

fn main() {
    // Cargo adds `--bench`.
    let mut arguments = std::env::args().skip(1).filter(|it| it != "--bench");
    let folder = PathBuf::from(arguments.next().expect("a folder of pictures"));
    let masks = arguments.next().map(PathBuf::from);
    let entries = std::fs::read_dir(&folder).expect("a folder");
    let mut pictures: Vec<PathBuf> = entries.map(|it| it.expect("a file").path()).collect();
    pictures.retain(|path| path.extension().is_some_and(|end| end == "jpg"));
    pictures.sort();
    let outcomes: Vec<Outcome> = pictures
        .iter()
        .map(|path| looked_at(path, masks.as_deref()))
        .collect();
    let (with, without): (Vec<_>, Vec<_>) = outcomes.iter().partition(|it| it.right.is_some());
    let rights = || {
        with.iter()
            .filter_map(|it| it.right.map(|right| (right, it)))
    };
    let refused = with.iter().filter(|it| !it.is_sure).count();
    let accepted = without.iter().filter(|it| it.is_sure).count();
    println!("with a sky: {}, refused {refused}", with.len());
    if let Some((right, worst)) = rights().min_by(|a, b| a.0.total_cmp(&b.0)) {
        let mean = rights().map(|it| it.0).sum::<f64>() / with.len() as f64;
        println!(
            "right: {:.2} % in the mean, {:.2} % of {}",
            100.0 * mean,
            100.0 * right,
            worst.name
        );
    }
    println!("without: {}, accepted {accepted}", without.len());
}

fn looked_at(path: &Path, masks: Option<&Path>) -> Outcome {
    let name = path.file_stem().expect("a name").to_string_lossy();
    let light = Photograph::read(path).expect("a picture").light;
    let start = Instant::now();
    let found = find_sky(&light, None).expect("a picture that is large enough");
    let elapsed_s = start.elapsed().as_secs_f64();
    if let Some(folder) = masks {
        let file = File::create(folder.join(format!("{name}.png"))).expect("a new file");
        write_labels(&found.is_sky.mapv(u8::from), 2, file).expect("a mask");
    }
    let truth = path.with_extension("sky.png");
    let right = truth.exists().then(|| {
        let truth = read_labels(&truth, 2).expect("a mask");
        let pairs = truth.iter().zip(&found.is_sky);
        let n_right = pairs
            .filter(|(truth, found)| (**truth == 1) == **found)
            .count();
        n_right as f64 / truth.len() as f64
    });
    let is_sure = found.confidence >= SURE_OF_SKY;
    let shown = right.map_or_else(|| "no sky".to_owned(), |it| format!("{:.2} %", 100.0 * it));
    println!(
        "{name:<28} {shown:>8}  {:.3}  {elapsed_s:.2} s  {}",
        found.confidence,
        found.reasons.join(", ")
    );
    Outcome {
        name: name.into_owned(),
        right,
        is_sure,
    }
}
