//! Mutates files of every kind that the program takes, and holds their readers to a value or an error.
//!
//! A reader may refuse a file or take it; it may not panic, abort, go on for long or take much memory. Same seed,
//! same files.

#![allow(
    dead_code,
    unreachable_pub,
    unused_imports,
    reason = "each target uses its part"
)]
#![allow(clippy::unwrap_used, reason = "samples are sound")]

use std::fs;
use std::panic::AssertUnwindSafe;
use std::panic::catch_unwind;
use std::path::Path;
use std::path::PathBuf;
use std::time::Duration;
use std::time::Instant;

mod changes;
mod places;
mod readers;
mod samples;

#[path = "../../crates/exchange/tests/common/mod.rs"]
mod exchange_files;

#[path = "../../crates/vdb/tests/common/mod.rs"]
mod vdb_files;

#[path = "../../crates/photo/tests/common/mod.rs"]
mod photographs;

use vdb_files::Random;

pub use places::mend_checksums;
pub use readers::readers;

/// A kind of file, and what reads it.
pub struct Reader {
    /// Its name on disk.
    pub file: &'static str,
    /// How many files of other kinds are read in the time that one of these takes.
    pub cost: u64,
    /// Files beside it that are not mutated.
    beside: Vec<(&'static str, Vec<u8>)>,
    /// Sound files of the kind.
    pub samples: Vec<Vec<u8>>,
    /// Whether a reader takes the file.
    read: fn(&Path) -> bool,
}

/// What a reader did with a mutated file.
pub struct Tried {
    /// How long it took.
    pub time: Duration,
    /// Whether it panicked.
    pub is_broken: bool,
    /// Whether it took the file.
    pub is_read: bool,
}

impl Reader {
    /// Reads the file of this seed in a folder, where it stays.
    pub fn try_seed(&self, seed: u64, folder: &Path) -> Tried {
        self.put(folder, &self.mutated(seed));
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| self.read(folder)));
        Tried {
            time: start.elapsed(),
            is_broken: outcome.is_err(),
            is_read: outcome.unwrap_or(false),
        }
    }

    /// The file of a seed.
    pub fn mutated(&self, seed: u64) -> Vec<u8> {
        let mut random = Random(seed);
        let mut bytes = self.samples[random.below(self.samples.len())].clone();
        for _ in 0..=random.below(4) {
            changes::change(&mut bytes, &mut random);
        }
        // Half of the files pass the checksums that hide what lies behind them.
        if random.below(2) == 0 {
            places::mend_checksums(&mut bytes);
        }
        bytes
    }

    /// Puts a file and what stands beside it into a folder.
    pub fn put(&self, folder: &Path, bytes: &[u8]) {
        for (name, content) in &self.beside {
            fs::write(folder.join(name), content).unwrap();
        }
        fs::write(self.place(folder), bytes).unwrap();
    }

    /// Reads the file in a folder and says whether it is taken; panics if that breaks its reader.
    pub fn read(&self, folder: &Path) -> bool {
        (self.read)(&self.place(folder))
    }

    /// Where the file of a seed is kept for whoever mends its reader.
    pub fn place(&self, folder: &Path) -> PathBuf {
        folder.join(self.file)
    }
}
