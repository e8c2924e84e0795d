//! Any bytes as a VDB file: headers, voxels, edited metadata. What is read can be written, and is
//! the same when read again.

#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use niji_vdb::Compression;
use niji_vdb::MetadataEdit;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;
use niji_vdb::edit_metadata;

fuzz_target!(|bytes: &[u8]| {
    let header = VdbHeader::parse(bytes);
    let file = VdbFile::parse(bytes);
    let edit = MetadataEdit {
        grid: None,
        item: "comment".to_owned(),
        value: Some("fuzzed".into()),
    };
    let mut edited = Cursor::new(Vec::new());
    let edit = edit_metadata(Cursor::new(bytes), &[edit], &mut edited);
    let Ok(file) = file else { return };
    assert!(header.is_ok(), "a file without a header was read");
    assert!(edit.is_ok(), "a file that is read cannot be edited");
    // NaN is not equal to itself: the written bytes are compared, not the values.
    let written = written(&file);
    let again = VdbFile::parse(&written).expect("what was written is read");
    assert!(written == self::written(&again), "the voxels have changed");
    let edited = VdbFile::parse(edited.get_ref()).expect("what was edited is read");
    assert_eq!(edited.metadata.get_str("comment"), Some("fuzzed"));
});

fn written(file: &VdbFile) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    file.write(&mut bytes, Compression::None)
        .expect("memory takes everything");
    bytes.into_inner()
}
