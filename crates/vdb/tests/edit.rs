//! Metadata can be edited without touching anything else.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use std::io::Cursor;

use common::BLOSC;
use common::bytes;
use common::small_file;
use common::small_tree;
use common::stream_with_instances;
use common::transform;
use niji_vdb::Compression;
use niji_vdb::Error;
use niji_vdb::Grid;
use niji_vdb::MetaValue;
use niji_vdb::MetadataEdit;
use niji_vdb::SparseTree;
use niji_vdb::VdbFile;
use niji_vdb::edit_metadata;

fn edited(original: &[u8], edits: &[MetadataEdit]) -> Result<Vec<u8>, Error> {
    let mut output = Cursor::new(Vec::new());
    edit_metadata(Cursor::new(original), edits, &mut output)?;
    Ok(output.into_inner())
}

fn edit(grid: Option<&str>, item: &str, value: Option<MetaValue>) -> MetadataEdit {
    MetadataEdit {
        grid: grid.map(str::to_owned),
        item: item.to_owned(),
        value,
    }
}

fn three_grids() -> VdbFile {
    let mut file = small_file();
    let other = SparseTree::<i32>::new(7);
    file.grids
        .push(Grid::new("count", "unknown", transform(), other));
    file.grids
        .push(Grid::new("density", "level set", transform(), small_tree()));
    file
}

#[test]
fn an_edited_file_is_the_file_that_would_have_been_written() {
    let edits = [
        edit(None, "comment", Some("a longer comment than before".into())),
        edit(None, "zoom", Some(2.5.into())),
        edit(Some("density"), "unit", None),
        edit(Some("density"), "author", Some("nobody".into())),
        edit(Some("count"), "class", Some("fog volume".into())),
        edit(Some("count"), "missing", None),
    ];
    let original = three_grids();
    let mut expected = original.clone();
    expected
        .metadata
        .insert("comment", "a longer comment than before");
    expected.metadata.insert("zoom", 2.5);
    for place in [0, 2] {
        expected.grids[place].metadata.remove("unit");
        expected.grids[place].metadata.insert("author", "nobody");
    }
    expected.grids[1].class = "fog volume".to_owned();
    for compression in [Compression::None, Compression::Zip] {
        let found = edited(&bytes(&original, compression), &edits).unwrap();
        assert!(found == bytes(&expected, compression), "{compression:?}");
    }
}

#[test]
fn no_edits_keep_every_byte_of_a_file_by_openvdb_but_its_uuid() {
    let mut copy = edited(BLOSC, &[]).unwrap();
    copy[21..57].copy_from_slice(&BLOSC[21..57]);
    assert!(copy == BLOSC);
}

#[test]
fn voxels_that_openvdb_compressed_stay_bit_for_bit() {
    let text = "0123456789".repeat(100);
    let edits = [edit(Some("ball"), "comment", Some(text.as_str().into()))];
    let copy = edited(BLOSC, &edits).unwrap();
    assert_eq!(copy.len(), BLOSC.len() + 4 + 7 + 4 + 6 + 4 + 1000);
    // Behind the metadata all is the same, the delayed-load item of OpenVDB included.
    assert!(copy[copy.len() - 18_000..] == BLOSC[BLOSC.len() - 18_000..]);
    let (before, after) = (
        VdbFile::parse(BLOSC).unwrap(),
        VdbFile::parse(&copy).unwrap(),
    );
    assert_eq!(before.grids[0].tree, after.grids[0].tree);
    assert_eq!(
        after.grids[0].metadata.get_str("comment"),
        Some(text.as_str())
    );
}

#[test]
fn files_without_offsets_and_instances_are_edited_too() {
    let stream = stream_with_instances(&bytes(&small_file(), Compression::Zip), 3, "density");
    let edits = [
        edit(None, "comment", None),
        edit(Some("density"), "unit", Some(1_i64.into())),
    ];
    let before = VdbFile::parse(&stream).unwrap();
    let after = VdbFile::parse(&edited(&stream, &edits).unwrap()).unwrap();
    assert!(after.metadata.is_empty());
    for (before, after) in before.grids.iter().zip(&after.grids) {
        assert_eq!(before.tree, after.tree);
        assert_eq!(after.metadata.get("unit"), Some(&MetaValue::Int64(1)));
    }
}

#[test]
fn grids_of_types_that_are_not_read_are_copied() {
    let original = bytes(&small_file(), Compression::None);
    let points = common::replaced(&original, b"Tree_float_5_4_3", b"Tree_ptdta_5_4_3");
    let edits = [edit(Some("density"), "unit", Some("1".into()))];
    let copy = edited(&points, &edits).unwrap();
    let back = common::replaced(&copy, b"Tree_ptdta_5_4_3", b"Tree_float_5_4_3");
    let grid = &VdbFile::parse(&back).unwrap().grids[0];
    assert_eq!(grid.tree, small_tree().into());
    assert_eq!(grid.metadata.get_str("unit"), Some("1"));
}

#[test]
fn grids_that_are_not_there_and_derived_items_are_refused() {
    let original = bytes(&three_grids(), Compression::None);
    let error = edited(&original, &[edit(Some("dense"), "unit", None)]).unwrap_err();
    let text = "there is no grid `dense`, expected one of: density, count, density";
    assert_eq!(error.to_string(), text);
    for item in ["name", "file_voxel_count", "is_saved_as_half_float"] {
        let error = edited(&original, &[edit(Some("count"), item, None)]).unwrap_err();
        assert!(error.to_string().contains(item), "{error}");
    }
}

#[test]
fn the_source_may_be_any_stream_and_the_output_may_start_behind_other_bytes() {
    let original = bytes(&small_file(), Compression::None);
    let mut output = Cursor::new(vec![7; 100]);
    output.set_position(100);
    edit_metadata(Cursor::new(&original), &[], &mut output).unwrap();
    assert_eq!(output.get_ref()[..100], [7; 100]);
    assert!(output.get_ref()[100..] == original);
}
