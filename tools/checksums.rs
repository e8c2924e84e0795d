//! Which files are as they were written: what "up to date" stands on.
//!
//! For each output `NAME` a file `.niji/NAME.json` beside it says for which request it was made, the SHA-256 of its
//! bytes as they were written, and what the file system said of it when they were last read whole. An output that
//! still has that size, inode and time of change is not read again: each write sets that time, and nothing sets it
//! back as it does the time of modification. Any other is read. Each process writes files of its own outputs as
//! a whole, so that several can work in one folder; where such a file is missing or damaged, its output is made anew.

use std::collections::BTreeMap;
use std::fs;
use std::fs::Metadata;
use std::io;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;
use std::time::SystemTime;
use std::time::UNIX_EPOCH;

use niji_exchange::content_hash;
use serde::Deserialize;
use serde::Serialize;

use crate::failure::Failure;
use crate::output;

/// The folder of what is known of the files beside it.
const FOLDER: &str = ".niji";

/// Longest text of what is known of an output, several times over (bytes).
const MOST_BYTES: u64 = 4096;

/// A file that changed less than this before it was looked at may change once more within the same tick of a coarse
/// clock: two seconds are the longest tick of file systems in use (s).
const LONGEST_TICK_S: i64 = 2;

/// What the file system says of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Look {
    bytes: u64,
    inode: u64,
    changed_s: i64,
    changed_ns: i64,
}

/// What is known of an output.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    /// Hash of the request that it was made for.
    request: String,
    /// SHA-256 of its bytes as they were written.
    sha256: String,
    /// Hash of the tiles that it was merged from, where it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tiles: Option<String>,
    /// How it looked when they were last read, where any later change shows.
    seen: Option<Look>,
}

/// Content hashes of files by how they look.
type Hashes = BTreeMap<(PathBuf, Look), String>;

/// Files that this process wrote or read: stages and frames share theirs.
static HASHES: Mutex<Hashes> = Mutex::new(Hashes::new());

fn hashes() -> MutexGuard<'static, Hashes> {
    HASHES.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Look {
    #[cfg(unix)]
    fn of(found: &Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self {
            bytes: found.size(),
            inode: found.ino(),
            changed_s: found.ctime(),
            changed_ns: found.ctime_nsec(),
        }
    }

    /// Without a time of change that nobody sets every file is read.
    #[cfg(not(unix))]
    fn of(found: &Metadata) -> Self {
        let modified = found.modified().unwrap_or(UNIX_EPOCH);
        let since = modified.duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            bytes: found.len(),
            inode: 0,
            changed_s: since.as_secs() as i64,
            changed_ns: since.subsec_nanos().into(),
        }
    }

    /// The same where any later change will show.
    fn settled(self) -> Option<Self> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).ok()?;
        let age_s = now.as_secs() as i64 - self.changed_s;
        (cfg!(unix) && age_s > LONGEST_TICK_S).then_some(self)
    }
}

/// SHA-256 of a file's content, in hexadecimal; what this process wrote or read is not read again.
///
/// # Errors
/// As [`content_hash`].
pub(crate) fn hash_once(path: &Path) -> io::Result<String> {
    let key = (path.to_owned(), Look::of(&fs::metadata(path)?));
    if let Some(hash) = hashes().get(&key) {
        return Ok(hash.clone());
    }
    let hash = content_hash(path)?;
    hashes().insert(key, hash.clone());
    Ok(hash)
}

/// Keeps the hash of a file that was written.
pub(crate) fn keep(path: &Path, written: &Metadata, hash: String) {
    hashes().insert((path.to_owned(), Look::of(written)), hash);
}

/// Is an output there, made for this request and unchanged? With `reads` its bytes are read however it looks.
pub(crate) fn fits(path: &Path, request: &str, reads: bool) -> bool {
    let known = Known::of(path).filter(|known| known.request == request);
    known.is_some_and(|known| known.holds(path, reads))
}

/// What is found of an output, for whichever request it was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Found {
    /// The bytes that were written.
    Whole,
    /// Other bytes.
    Changed,
    /// Nothing, or nothing finished.
    Missing,
}

/// Looks for an output. With `reads` its bytes are read however it looks.
pub(crate) fn found(path: &Path, reads: bool) -> Found {
    let is_whole = Known::of(path).map(|known| known.holds(path, reads));
    match is_whole {
        Some(true) => Found::Whole,
        Some(false) if path.exists() => Found::Changed,
        _ => Found::Missing,
    }
}

/// Was an output merged from tiles of this hash?
pub(crate) fn is_merged_from(path: &Path, tiles: &str) -> bool {
    Known::of(path).is_some_and(|known| known.tiles.as_deref() == Some(tiles))
}

/// Notes that this process made an output for a request. What another one put in its place since is not noted.
///
/// # Errors
/// A note that cannot be written.
pub(crate) fn note(path: &Path, request: &str) -> Result<(), Failure> {
    note_merged(path, request, None)
}

/// The same of an output that was merged from tiles of a hash.
///
/// # Errors
/// As [`note`].
pub(crate) fn note_merged(path: &Path, request: &str, tiles: Option<&str>) -> Result<(), Failure> {
    let look = fs::symlink_metadata(path).map(|found| Look::of(&found));
    let look = look.map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))?;
    let written = hashes().get(&(path.to_owned(), look)).cloned();
    let Some(sha256) = written else {
        return Ok(());
    };
    Known {
        tiles: tiles.map(str::to_owned),
        ..Known::new(request, sha256)
    }
    .write(path)
}

/// Notes what an output will be before it stands there.
///
/// # Errors
/// As [`note`].
pub(crate) fn foresee(path: &Path, request: &str, sha256: String) -> Result<(), Failure> {
    Known::new(request, sha256).write(path)
}

/// Removes an output with what is known of it, as far as that is possible: what is left does no harm.
pub(crate) fn remove(path: &Path) {
    let note = note_file(path);
    let _ = fs::remove_file(path);
    let _ = note.as_ref().map(fs::remove_file);
    let _ = note.as_deref().and_then(Path::parent).map(fs::remove_dir);
}

impl Known {
    /// Of an output that nobody has looked at since.
    fn new(request: &str, sha256: String) -> Self {
        Self {
            request: request.to_owned(),
            sha256,
            tiles: None,
            seen: None,
        }
    }

    /// What is known of an output; what is damaged or none of ours is nothing.
    fn of(path: &Path) -> Option<Self> {
        let file = note_file(path)?;
        let found = fs::symlink_metadata(&file).ok()?;
        if !found.is_file() || found.len() > MOST_BYTES {
            return None;
        }
        serde_json::from_str(&fs::read_to_string(file).ok()?).ok()
    }

    /// Does an output have the bytes that were written?
    fn holds(&self, path: &Path, reads: bool) -> bool {
        let Ok(found) = fs::symlink_metadata(path) else {
            return false;
        };
        if !found.is_file() {
            return false;
        }
        let look = Look::of(&found);
        if !reads && self.seen == Some(look) {
            keep(path, &found, self.sha256.clone());
            return true;
        }
        // Before it is read.
        let seen = look.settled();
        if hash_once(path).ok().as_ref() != Some(&self.sha256) {
            return false;
        }
        if seen.is_some() && seen != self.seen {
            // Else it is read again next time.
            let _ = Self {
                seen,
                ..self.clone()
            }
            .write(path);
        }
        true
    }

    fn write(&self, path: &Path) -> Result<(), Failure> {
        let no_name = || Failure::Failed(format!("{} is no name of a file", path.display()));
        let text =
            serde_json::to_string(self).map_err(|error| Failure::Failed(error.to_string()))?;
        output::write_text(&note_file(path).ok_or_else(no_name)?, &(text + "\n"))
    }
}

/// Where it stands what is known of an output.
fn note_file(path: &Path) -> Option<PathBuf> {
    let mut name = path.file_name()?.to_owned();
    name.push(".json");
    Some(path.with_file_name(FOLDER).join(name))
}
