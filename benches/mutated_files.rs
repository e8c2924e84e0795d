//! Mutates files of every kind that the program reads, and says what broke a reader, took long or much memory.
//!
//!     cargo bench --bench mutated_files -- [--files N | --seconds N] [--seed N] [--kind gltf] [--corpus FOLDER]
//!
//! The file that is being read stays in `target/mutated`, for what ends the process; one that breaks a reader is
//! kept there under its seed. Ends with code 1 if there is any. `--corpus` only writes the sound files of each kind,
//! for libFuzzer.

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::Instant;

use clap::Parser;

#[path = "../tests/support/mutations.rs"]
mod mutations;
#[path = "../tools/peak_memory.rs"]
mod peak_memory;

use mutations::Reader;
use niji_radiometry::Bytes;
use niji_radiometry::set_memory_limit;
use peak_memory::PeakMemory;

/// A reader that takes longer for a file of a few kilobytes does something foolish, unless it plans a scene.
const SLOW: Duration = Duration::from_secs(3);
/// One that takes longer hangs.
const HANGS: Duration = Duration::from_secs(10);
/// Memory that the process may hold with a file of a few kilobytes: twice what it is told.
const MOST_MEMORY: u64 = 512 << 20;

#[derive(Parser)]
struct Arguments {
    /// Files of each kind.
    #[arg(long, default_value_t = 20_000)]
    files: u64,
    /// Seconds for each kind, instead of a number of files.
    #[arg(long)]
    seconds: Option<u64>,
    /// Seed of the first file; each has the next.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only kinds whose file name holds this.
    #[arg(long, default_value = "")]
    kind: String,
    /// Write the sound files that are mutated into a folder for each kind.
    #[arg(long)]
    corpus: Option<PathBuf>,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // Some of the sound files are planned.
    set_memory_limit(Bytes(u128::from(MOST_MEMORY / 2))).expect("nobody asked for it yet");
    let mut readers = mutations::readers();
    readers.retain(|reader| reader.file.contains(&arguments.kind));
    if let Some(folder) = &arguments.corpus {
        write_corpus(&readers, folder);
        return ExitCode::SUCCESS;
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/mutated");
    fs::create_dir_all(&folder).expect("a folder for mutated files");
    let n_read = Arc::new(AtomicU64::new(0));
    end_what_hangs(n_read.clone(), folder.clone());
    println!("seeds from {}", arguments.seed);
    println!(
        "kind         files      taken      broken  slowest (its seed)  peak memory (its seed)"
    );
    let (mut n_broken, start) = (0, Instant::now());
    for reader in &readers {
        n_broken += try_all(reader, &arguments, &folder, &n_read);
    }
    let (n_files, seconds) = (n_read.load(Ordering::Relaxed), start.elapsed().as_secs());
    println!(
        "{n_files} files in {seconds} s: {n_broken} broke a reader, were slow or took much memory"
    );
    ExitCode::from(u8::from(n_broken > 0))
}

/// Tries the files of one kind and says how many are to be looked at.
fn try_all(reader: &Reader, arguments: &Arguments, folder: &Path, n_read: &AtomicU64) -> u64 {
    let first = arguments.seed;
    let (mut longest, mut largest) = ((Duration::ZERO, first), (0, first));
    let (mut n_broken, mut n_taken) = (0, 0);
    let (mut seed, start) = (first, Instant::now());
    let goes_on = |seed: u64| match arguments.seconds {
        Some(seconds) => start.elapsed() < Duration::from_secs(seconds),
        None => seed < first + arguments.files.div_ceil(reader.cost),
    };
    while goes_on(seed) {
        let memory = PeakMemory::start();
        let tried = reader.try_seed(seed, folder);
        n_read.fetch_add(1, Ordering::Relaxed);
        let bytes = memory.bytes().unwrap_or(0);
        n_taken += u64::from(tried.is_read);
        longest = longest.max((tried.time, seed));
        largest = largest.max((bytes, seed));
        let slow = if reader.cost > 1 { HANGS } else { SLOW };
        if tried.is_broken || tried.time > slow || bytes > MOST_MEMORY {
            n_broken += 1;
            let kept = folder.join(format!("{seed}-{}", reader.file));
            let mebibytes = bytes >> 20;
            println!(
                "  {} after {:.1?}, {mebibytes} MiB",
                kept.display(),
                tried.time
            );
            fs::copy(reader.place(folder), kept).expect("room for a file");
        }
        seed += 1;
    }
    let ((time, slowest), (bytes, heaviest)) = (longest, largest);
    println!(
        "{:<12} {:<10} {n_taken:<10} {n_broken:<7} {:<19} {} MiB ({heaviest})",
        reader.file,
        seed - first,
        format!("{time:.1?} ({slowest})"),
        bytes >> 20
    );
    n_broken
}

/// Ends the process when one file is read for too long.
fn end_what_hangs(n_read: Arc<AtomicU64>, folder: PathBuf) {
    std::thread::spawn(move || {
        loop {
            let before = n_read.load(Ordering::Relaxed);
            std::thread::sleep(HANGS);
            if n_read.load(Ordering::Relaxed) == before {
                println!(
                    "a file in {} is read for more than {HANGS:?}",
                    folder.display()
                );
                std::process::exit(1);
            }
        }
    });
}

fn write_corpus(readers: &[Reader], folder: &Path) {
    for reader in readers {
        let folder = folder.join(reader.file);
        fs::create_dir_all(&folder).expect("a folder for sound files");
        for (index, sample) in reader.samples.iter().enumerate() {
            fs::write(folder.join(index.to_string()), sample).expect("room for a file");
        }
    }
}
