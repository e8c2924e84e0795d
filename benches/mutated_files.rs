//! Mutates files of every kind that the program reads, and says what broke a reader and what took long.
//!
//!     cargo bench --bench mutated_files [SEED] [FILES OF EACH KIND] [KIND, say gltf]
//!
//! The file that is being read stays in `target/mutated`, for what ends the process; one that breaks a reader is
//! kept there under its seed.

use std::fs;
use std::path::Path;
use std::time::Duration;

#[path = "../tests/support/mutations.rs"]
mod mutations;

/// A reader that takes longer for a file of a few kilobytes does something foolish.
const SLOW: Duration = Duration::from_secs(1);

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|it| it != "--bench")
        .collect();
    let number = |index: usize, default: u64| {
        let given = arguments.get(index);
        given.map_or(default, |it| it.parse().expect("a whole number"))
    };
    let (first, n_files) = (number(0, 1), number(1, 20_000));
    let kind = arguments.get(2).map_or("", String::as_str);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/mutated");
    fs::create_dir_all(&folder).expect("a folder for mutated files");
    println!("seeds from {first}, {n_files} files of each kind");
    for reader in mutations::readers() {
        if !reader.file.contains(kind) {
            continue;
        }
        let (mut total, mut longest, mut n_kept) = (Duration::ZERO, (Duration::ZERO, first), 0);
        for seed in first..first + n_files {
            let tried = reader.try_seed(seed, &folder);
            total += tried.time;
            longest = longest.max((tried.time, seed));
            if tried.is_broken || tried.time > SLOW {
                n_kept += 1;
                let kept = folder.join(format!("{seed}-{}", reader.file));
                println!("  {} after {:.1?}", kept.display(), tried.time);
                fs::copy(reader.place(&folder), kept).expect("room for a file");
            }
        }
        let (time, seed) = longest;
        println!(
            "{:<12} {n_kept} broken or slow; {:.1?} each, the longest {time:.1?} (seed {seed})",
            reader.file,
            total.div_f64(n_files.max(1) as f64)
        );
    }
}
