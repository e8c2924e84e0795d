//! Any bytes as a file of one of the readers of `tests/support/readers.rs`: that which `NIJI_READER` names.

#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/mutations.rs"]
mod mutations;

use mutations::Reader;

/// The reader, and the folder of this process for its files, which are read by path.
static READER: LazyLock<(Reader, tempfile::TempDir)> = LazyLock::new(|| {
    let name = std::env::var("NIJI_READER").unwrap_or_default();
    let readers = mutations::readers();
    let names: Vec<_> = readers.iter().map(|reader| reader.file).collect();
    let names = names.join(", ");
    let reader = readers.into_iter().find(|reader| reader.file == name);
    let reader = reader.unwrap_or_else(|| panic!("NIJI_READER is {name:?}, expected one of {names}"));
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    (reader, folder)
});

fuzz_target!(|bytes: &[u8]| {
    let (reader, folder) = &*READER;
    reader.put(folder.path(), bytes);
    reader.read(folder.path());
});
