//! What was decided for scenes, kept between commands: only the first one that plans a scene measures for it.
//!
//! A folder with a file of a choice for each request, named by its hash. Whatever cannot be read there, or is not as it
//! was written, is decided anew; a folder that cannot be written keeps nothing. The oldest go when there are too many.

use std::fs;
use std::fs::DirEntry;
use std::path::Path;
use std::path::PathBuf;
use std::time::SystemTime;

use etcetera::BaseStrategy;
use niji_picture::Choice;

use crate::choice_file;
use crate::flags::Common;
use crate::output::Existing;

/// Inside the folder of the program.
const FOLDER: &str = "choices";

/// The name for no folder.
const NOWHERE: &str = "none";

/// Most bytes that files may take: those of some two thousand scenes.
const MOST_BYTES: u64 = 64 << 20;

/// Where choices are kept.
pub(crate) struct KeptChoices {
    folder: Option<PathBuf>,
}

impl KeptChoices {
    /// Where the command line, or else the user's environment, says.
    pub(crate) fn of(common: &Common) -> Self {
        let folder = match &common.cache {
            Some(folder) if folder.as_os_str() == NOWHERE => None,
            Some(folder) => Some(folder.clone()),
            None => etcetera::choose_base_strategy()
                .ok()
                .map(|user| user.cache_dir().join("niji")),
        };
        Self {
            folder: folder.map(|it| it.join(FOLDER)),
        }
    }

    fn file(&self, request: &str) -> Option<PathBuf> {
        let folder = self.folder.as_ref()?;
        Some(folder.join(format!("{request}.toml")))
    }

    /// What was decided for a request of this hash.
    pub(crate) fn find(&self, request: &str) -> Option<Choice> {
        choice_file::read(&self.file(request)?).ok()
    }

    /// Keeps what was decided.
    pub(crate) fn keep(&self, choice: &Choice) {
        let Some(file) = self.file(&choice.request) else {
            return;
        };
        let writes = |_: &&Path| choice_file::write(choice, &file, Existing::Replace).is_ok();
        if let Some(folder) = file.parent().filter(writes) {
            tidy(folder, MOST_BYTES);
        }
    }
}

/// Removes the oldest files of a folder until the others take no more than so many bytes.
fn tidy(folder: &Path, most_bytes: u64) {
    let look = |entry: DirEntry| {
        let about = entry.metadata().ok()?;
        let written = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        Some((written, about.len(), entry.path()))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.filter_map(look).collect();
    files.sort();
    let mut n_bytes: u64 = files.iter().map(|(_, n_bytes, _)| n_bytes).sum();
    for (_, n_bytes_of_file, path) in files {
        if n_bytes <= most_bytes {
            return;
        }
        // Somebody else may have done it.
        let _ = fs::remove_file(path);
        n_bytes -= n_bytes_of_file;
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_oldest_files_go() {
        let folder = tempfile::tempdir().unwrap();
        for age_s in [30, 10, 20, 0] {
            let path = folder.path().join(format!("{age_s}.toml"));
            fs::write(&path, [0; 100]).unwrap();
            let written = SystemTime::now() - Duration::from_secs(age_s);
            let file = File::options().write(true).open(&path).unwrap();
            file.set_modified(written).unwrap();
        }
        tidy(folder.path(), 250);
        let left = |age_s| folder.path().join(format!("{age_s}.toml")).exists();
        assert_eq!([0, 10, 20, 30].map(left), [true, true, false, false]);
        tidy(folder.path(), 250);
        assert!(left(10));
    }
}
