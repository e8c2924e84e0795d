//! What a file is called from a folder, so that both can be moved together.

use std::io;
use std::path::Component;
use std::path::Path;
use std::path::PathBuf;

/// The name of a file from a folder, which need not be there yet: over the folder that both lie in. The whole name where
/// they have nothing in common.
///
/// # Errors
/// A file that is missing.
pub(super) fn name_from(folder: &Path, file: &Path) -> io::Result<PathBuf> {
    let file = file.canonicalize()?;
    let folder = std::path::absolute(folder)?;
    let there = folder.ancestors().find_map(|it| {
        let rest = folder.strip_prefix(it).ok()?;
        Some((it.canonicalize().ok()?, rest))
    });
    let Some((there, rest)) = there else {
        return Ok(file);
    };
    let folder = there.join(rest);
    let is_plain = |it: Component| matches!(it, Component::Normal(_));
    if !rest.components().all(is_plain) {
        return Ok(file);
    }
    let (from, to) = (folder.components(), file.components());
    let both: Vec<Component> = from
        .zip(to)
        .take_while(|(a, b)| a == b)
        .map(|it| it.0)
        .collect();
    if !both.iter().copied().any(is_plain) {
        return Ok(file);
    }
    let up = folder
        .components()
        .skip(both.len())
        .map(|_| Component::ParentDir);
    Ok(up.chain(file.components().skip(both.len())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_over_the_folder_that_both_lie_in() {
        let root = tempfile::tempdir().unwrap();
        let photos = root.path().join("photos");
        std::fs::create_dir(&photos).unwrap();
        let file = photos.join("a.jpg");
        std::fs::write(&file, "").unwrap();
        for (folder, expected) in [
            ("photos", "a.jpg"),
            (".", "photos/a.jpg"),
            ("bow", "../photos/a.jpg"),
            ("new/bow", "../../photos/a.jpg"),
            ("photos/bow", "../a.jpg"),
        ] {
            let found = name_from(&root.path().join(folder), &file).unwrap();
            assert_eq!(found, Path::new(expected), "{folder}");
        }
        let whole = name_from(Path::new("/nowhere/at/all"), &file).unwrap();
        assert_eq!(whole, file.canonicalize().unwrap());
        assert!(name_from(root.path(), &photos.join("none.jpg")).is_err());
    }
}
