//! Any bytes as a VDB file: headers and voxels. What is read can be written, and is the same when read again.

#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use niji_vdb::Compression;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

fuzz_target!(|bytes: &[u8]| {
    let header = VdbHeader::parse(bytes);
    let file = VdbFile::parse(bytes);
    let Ok(file) = file else { return };
    assert!(header.is_ok(), "a file without a header was read");
    // NaN is not equal to itself: the written bytes are compared, not the values.
    let written = written(&file);
    let again = VdbFile::parse(&written).expect("what was written is read");
    assert!(written == self::written(&again), "the voxels have changed");
});

fn written(file: &VdbFile) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    file.write(&mut bytes, Compression::None)
        .expect("memory takes everything");
    bytes.into_inner()
}
