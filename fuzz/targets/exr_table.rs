//! Any bytes as an EXR file of tables, and as one with provenance.

#![no_main]

use libfuzzer_sys::fuzz_target;
use niji_exchange::TableFile;
use niji_exchange::read_provenance;

fuzz_target!(|bytes: &[u8]| {
    // Tables are read by path; the name is this process's own.
    let path = std::env::temp_dir().join(format!("niji-fuzz-{}.exr", std::process::id()));
    std::fs::write(&path, bytes).expect("the folder for temporary files takes a file");
    let _ = TableFile::read(&path);
    let _ = read_provenance(&path);
});
