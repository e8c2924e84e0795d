//! Where results go: never half-written, never over somebody's file by accident.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and renamed, so a
//! reader sees the old file or the new one. An interrupt removes what is unfinished; what a process
//! that was killed left behind, the next one removes. Whoever writes a temporary file holds a lock on
//! it, which ends with the process: that tells abandoned files from those of other processes.

use std::collections::BTreeSet;
use std::fs;
use std::fs::File;
use std::fs::TryLockError;
use std::io;
use std::io::BufWriter;
use std::io::Write;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;

use niji_exchange::Provenance;
use niji_exchange::content_hash;
use tempfile::Builder;
use tempfile::NamedTempFile;

use crate::checksums;
use crate::checksums::Found;
use crate::failure::Failure;
use crate::run::files::hash;

/// Temporary files of this process, removed when it is interrupted.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Folders that were looked through for abandoned files.
static TIDIED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Start of the names of temporary files.
const PREFIX: &str = ".niji-";
/// End of the names of temporary files.
const SUFFIX: &str = ".part";

/// May a file that exists be replaced?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    /// Refuse with exit code 2.
    Refuse,
    /// Replace what a run before made and nobody changed since; refuse all else.
    ReplaceOwn,
    /// Replace it (`--force`).
    Replace,
}

/// Refuses a path that is taken, before any work is done.
///
/// # Errors
/// [`Failure::Usage`] if something is there and may not be replaced.
pub(crate) fn check_free(path: &Path, existing: Existing) -> Result<(), Failure> {
    check_regular(path)?;
    let (is_free, whose) = match existing {
        Existing::Replace => (true, ""),
        Existing::ReplaceOwn => (
            checksums::found(path, false) == Found::Whole,
            " and is not as a run left it",
        ),
        Existing::Refuse => (false, ""),
    };
    if is_free || !path.exists() {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{} exists already{whose}: choose another name with -o, or replace it with --force",
        path.display()
    )))
}

/// Refuses the name of something that no result replaces: a folder, a pipe, a device, a link.
///
/// # Errors
/// [`Failure::Usage`] if there is something else than a file.
pub(crate) fn check_regular(path: &Path) -> Result<(), Failure> {
    let Ok(found) = fs::symlink_metadata(path) else {
        return Ok(());
    };
    let kind = found.file_type();
    let what = match (kind.is_file(), kind.is_dir(), kind.is_symlink()) {
        (true, _, _) => return Ok(()),
        (_, true, _) => "a folder",
        (_, _, true) => "a link",
        _ => "a pipe or a device",
    };
    Err(Failure::Usage(format!(
        "{} is {what}, expected the name of a file to write",
        path.display()
    )))
}

/// Refuses a name for two outputs.
///
/// # Errors
/// [`Failure::Usage`] for the first that another one has.
pub(crate) fn check_distinct(paths: &[&Path]) -> Result<(), Failure> {
    let again = (1..paths.len()).find(|index| paths[..*index].contains(&paths[*index]));
    again.map_or(Ok(()), |index| {
        Err(Failure::Usage(format!(
            "{} is the name of two outputs, expected a name for each: choose another one with -o",
            paths[index].display()
        )))
    })
}

/// Refuses an output that is an input: it would be lost.
///
/// # Errors
/// [`Failure::Usage`] for the first that is one, whatever may be replaced.
pub(crate) fn check_no_input(outputs: &[&Path], inputs: &[&Path]) -> Result<(), Failure> {
    let inputs = inputs.iter().filter_map(|path| path.canonicalize().ok());
    let inputs: Vec<PathBuf> = inputs.collect();
    let is_input = |path: &&&Path| path.canonicalize().is_ok_and(|it| inputs.contains(&it));
    outputs.iter().find(is_input).map_or(Ok(()), |path| {
        Err(Failure::Usage(format!(
            "{} is read and would be written over: choose another place with -o",
            path.display()
        )))
    })
}

/// Writes a file as a whole or not at all.
///
/// # Errors
/// [`Failure::Failed`] if the folder cannot be made or the file cannot be written, [`Failure::Usage`] if
/// something else than a file has its name; whatever stood under that name before is untouched then.
pub(crate) fn write_file<E: std::fmt::Display>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), Failure> {
    place(path, None, |writer| {
        write(writer).map_err(|error| failed(path, &error))
    })
}

/// Writes a file whose content is still to be made, which may fail for reasons of its own.
///
/// # Errors
/// As [`write_file`]; those of `make`.
pub(crate) fn make_file(
    path: &Path,
    make: impl FnOnce(&mut BufWriter<File>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    place(path, None, make)
}

/// Writes a file that has no place for what it was made for: that is noted before it stands there, so that whoever is
/// interrupted knows it again.
///
/// # Errors
/// As [`write_file`].
pub(crate) fn write_file_for<E: std::fmt::Display>(
    path: &Path,
    made_for: &Provenance,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), Failure> {
    let write = |writer: &mut _| write(writer).map_err(|error| failed(path, &error));
    place(path, Some(made_for), write)
}

/// A file that cannot be written.
pub(crate) fn failed(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Failed(format!("cannot write {}: {error}", path.display()))
}

/// A file under a temporary name, which goes unless it is put in its place.
pub(crate) struct Temporary {
    path: PathBuf,
    file: NamedTempFile,
    /// Behind the file, which is gone by then.
    _name: Unfinished,
}

/// The name of a file that goes when the process is interrupted.
struct Unfinished(PathBuf);

impl Temporary {
    /// What is to become the file `path`, in its folder.
    ///
    /// # Errors
    /// [`Failure::Failed`] if the folder cannot be made or nothing written in it.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        fs::create_dir_all(folder).map_err(|error| failed(path, &error))?;
        if guarded(&TIDIED).insert(folder.to_owned()) {
            remove_abandoned(folder);
        }
        let file = locked_file(folder).map_err(|error| failed(path, &error))?;
        let name = file.path().to_owned();
        guarded(&UNFINISHED).insert(name.clone());
        Ok(Self {
            path: path.to_owned(),
            file,
            _name: Unfinished(name),
        })
    }

    /// What writes it.
    ///
    /// # Errors
    /// [`Failure::Failed`] if the system has no handle for it.
    pub(crate) fn handle(&self) -> Result<File, Failure> {
        let handle = self.file.as_file().try_clone();
        handle.map_err(|error| failed(&self.path, &error))
    }

    /// Puts what was written in its place.
    ///
    /// # Errors
    /// As [`write_file`].
    pub(crate) fn place(self) -> Result<(), Failure> {
        self.place_for(None)
    }

    fn place_for(self, made_for: Option<&Provenance>) -> Result<(), Failure> {
        let path = &self.path;
        let failed = |error: &dyn std::fmt::Display| failed(path, error);
        check_regular(path)?;
        let synced = self.file.as_file().sync_data();
        synced.map_err(|error| failed(&error))?;
        let hash = content_hash(self.file.path()).map_err(|error| failed(&error))?;
        if let Some(made_for) = made_for {
            let foreseen = checksums::foresee(path, &made_for.request_hash(), hash.clone());
            foreseen.map_err(|error| failed(&error))?;
        }
        let file = self.file.persist(path);
        let file = file.map_err(|error| failed(&error))?;
        // Renaming it has changed its time of change.
        let written = file.metadata().map_err(|error| failed(&error))?;
        checksums::keep(path, &written, hash);
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        guarded(&UNFINISHED).remove(&self.0);
    }
}

fn place(
    path: &Path,
    made_for: Option<&Provenance>,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    check_regular(path)?;
    let temporary = Temporary::of(path)?;
    let mut writer = BufWriter::with_capacity(1 << 20, temporary.handle()?);
    write(&mut writer)?;
    writer.flush().map_err(|error| failed(path, &error))?;
    temporary.place_for(made_for)
}

/// Writes a text.
///
/// # Errors
/// As [`write_file`].
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write_file(path, |writer| writer.write_all(text.as_bytes()))
}

/// Writes pixels of three bytes as a picture of so many columns and rows.
///
/// # Errors
/// As [`write_file`].
pub(crate) fn write_rgb_png(path: &Path, size_px: [usize; 2], rgb: &[u8]) -> Result<(), Failure> {
    let [width, height] = size_px.map(|it| it as u32);
    write_file(path, |writer| {
        let mut encoder = png::Encoder::new(writer, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()
    })
}

/// Writes rows as CSV, with the names of their fields as header.
///
/// # Errors
/// As [`write_file`].
pub(crate) fn write_csv(path: &Path, rows: &[impl serde::Serialize]) -> Result<(), Failure> {
    write_file(path, |writer| {
        let mut csv = csv::Writer::from_writer(writer);
        for row in rows {
            csv.serialize(row).map_err(|error| error.to_string())?;
        }
        csv.flush().map_err(|error| error.to_string())
    })
}

/// Prints a result. A reader that has seen enough (`| head`) is no failure.
///
/// # Errors
/// [`Failure::Failed`] if standard output cannot be written.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(text.as_bytes());
    printed(written.and_then(|()| stdout.flush()))
}

/// What became of something printed.
///
/// # Errors
/// [`Failure::Failed`] if it is lost, though somebody may wait for it.
pub(crate) fn printed(outcome: io::Result<()>) -> Result<(), Failure> {
    match outcome {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("cannot print: {error}")))
        }
        _ => Ok(()),
    }
}

/// Says something on standard error, where somebody may have stopped to listen.
pub(crate) fn say(text: impl std::fmt::Display) {
    // There is nobody to tell of a failure.
    let _ = writeln!(io::stderr(), "{text}");
}

/// Removes temporary files that nobody writes any more.
pub(crate) fn remove_abandoned(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries {
        let (path, is_file) = (entry.path(), entry.file_type().is_ok_and(|it| it.is_file()));
        let is_abandoned = || File::open(&path).is_ok_and(|file| file.try_lock().is_ok());
        if is_file && is_temporary(&path) && is_abandoned() {
            // What cannot be removed does no harm.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Start of the names of the temporary files of a process: a hash of its number tells them from what others call
/// so.
fn prefix(process: &str) -> String {
    format!("{PREFIX}{process}-{}-", hash(format!("niji {process}")))
}

/// Is it the name of a temporary file of ours?
fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| {
        let process = name
            .strip_prefix(PREFIX)
            .and_then(|it| it.split('-').next());
        name.ends_with(SUFFIX) && process.is_some_and(|it| name.starts_with(&prefix(it)))
    })
}

/// A temporary file that nobody takes for abandoned.
fn locked_file(folder: &Path) -> io::Result<NamedTempFile> {
    loop {
        let file = temporary_file(folder)?;
        match file.as_file().try_lock() {
            // Where files cannot be locked none is removed.
            Ok(()) | Err(TryLockError::Error(_)) if file.path().exists() => return Ok(file),
            // Another process looked at it before it was locked.
            Ok(()) | Err(TryLockError::Error(_) | TryLockError::WouldBlock) => (),
        }
    }
}

fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    let prefix = prefix(&std::process::id().to_string());
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    // The default of the crate is private to the user; results are for whoever the umask says.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn guarded(paths: &'static Mutex<BTreeSet<PathBuf>>) -> MutexGuard<'static, BTreeSet<PathBuf>> {
    paths.lock().unwrap_or_else(PoisonError::into_inner)
}

/// On Ctrl-C or a termination signal, removes unfinished files and ends with exit code 130.
pub(crate) fn remove_unfinished_on_interrupt() {
    // A second handler in one process (tests) is refused by the crate; the first one serves.
    let _ = ctrlc::set_handler(|| {
        for name in guarded(&UNFINISHED).iter() {
            let _ = fs::remove_file(name);
        }
        std::process::exit(130);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.exr");
        fs::write(&path, "old").unwrap();
        let outcome = write_file(&path, |writer| {
            writer
                .write_all(b"half of the new")
                .map_err(|error| error.to_string())?;
            Err("disk full".to_owned())
        });
        assert!(matches!(outcome, Err(Failure::Failed(message)) if message.contains("disk full")));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_without_a_place_for_its_request_is_noted_as_it_is_placed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drawing.svg");
        let made_for = |settings: &str| Provenance {
            tool: "niji lee".to_owned(),
            version: "1".to_owned(),
            settings: settings.to_owned(),
            inputs: std::collections::BTreeMap::new(),
        };
        let hash = |settings| made_for(settings).request_hash();
        write_file_for(&path, &made_for("{}"), |to| to.write_all(b"<svg/>")).unwrap();
        assert!(checksums::fits(&path, &hash("{}"), true));
        assert!(!checksums::fits(&path, &hash("[]"), true));
    }

    #[test]
    fn only_abandoned_temporary_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let abandoned = folder.path().join(prefix("17") + "killed.part");
        let foreign = [
            "notes.part",
            ".niji-killed.part",
            ".niji-17-00ff-killed.part",
        ];
        let foreign = foreign.map(|name| folder.path().join(name));
        for path in [&abandoned].into_iter().chain(&foreign) {
            fs::write(path, "half").unwrap();
        }
        let written = locked_file(folder.path()).unwrap();
        write_file(&folder.path().join("table.exr"), |writer| {
            writer.write_all(b"new")
        })
        .unwrap();
        assert!(!abandoned.exists());
        assert!(foreign.iter().all(|path| path.exists()) && written.path().exists());
    }

    #[test]
    fn an_existing_file_is_refused_without_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.exr");
        assert!(check_free(&path, Existing::Refuse).is_ok());
        fs::write(&path, "old").unwrap();
        assert!(matches!(
            check_free(&path, Existing::Refuse),
            Err(Failure::Usage(_))
        ));
        assert!(check_free(&path, Existing::Replace).is_ok());
        assert!(matches!(
            check_free(folder.path(), Existing::Replace),
            Err(Failure::Usage(_))
        ));
    }

    #[cfg(unix)]
    #[test]
    fn only_files_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (link, target) = (folder.path().join("link"), folder.path().join("target"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        for path in [&link, Path::new("/dev/null"), folder.path()] {
            let outcome = write_text(path, "new");
            assert!(
                matches!(outcome, Err(Failure::Usage(_))),
                "{}",
                path.display()
            );
        }
        assert_eq!(fs::read_to_string(&link).unwrap(), "old");
    }
}
